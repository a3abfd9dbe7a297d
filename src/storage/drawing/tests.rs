//! Figures made up for the purpose: drawn, written, and looked into.

use super::*;
use crate::follow::record::{Direction, LoopRecord};
use crate::paper::errata::Evidence;
use crate::paper::scenes;
use crate::plot::loop_panel::tests::{invented_loop, law};
use crate::plot::panel::{Area, Arrow, Axis, Colour, Content, Inset, Label, Role, Series, Symbol};
use crate::plot::{chart_panel, loop_panel};
use crate::scene::Model;
use crate::storage::export::tests::invented;
use crate::storage::export::{
    FIGURE_COLUMNS, write_figure_csv, write_findings_csv, write_table_csv,
};
use crate::study::chart::Chart;
use ndarray::Array2;

fn series(
    name: &str,
    role: Role,
    symbol: Option<Symbol>,
    colour: Colour,
    curve: impl Fn(f64) -> [f64; 2],
) -> Series {
    let count = if symbol.is_some() { 12 } else { 200 };
    let points = (0..=count)
        .map(|i| curve(f64::from(i) / f64::from(count)))
        .collect();
    Series {
        name: name.to_owned(),
        role,
        symbol,
        colour,
        points,
        ..Series::default()
    }
}

fn bump() -> Array2<f64> {
    Array2::from_shape_fn((24, 24), |(j, i)| {
        let (x, y) = (i as f64 / 12.0 - 1.0, j as f64 / 12.0 - 1.0);
        3.0 * (-4.0 * (x * x + y * y)).exp()
    })
}

/// A loop with areas, arrows, labels, maps and a diagram inside.
fn everything() -> Panel {
    let inner = Panel {
        x: Axis::linear("t"),
        y: Axis::linear("s"),
        series: vec![series("", Role::Theory, None, Colour::Purple, |t| {
            [t, t * t]
        })],
        ..Panel::default()
    };
    Panel {
        title: "a loop: gamma_hys".to_owned(),
        x: Axis::linear("mean displacement u0/rho").from_to(0.0, 4.0),
        y: Axis::linear("pressure p/sigma_max"),
        areas: vec![Area {
            name: "lost energy".to_owned(),
            colour: Colour::Gold,
            spans: (0..=50)
                .map(|i| 1.0 + f64::from(i) / 25.0)
                .map(|x| [x, -0.3 * x, 0.2 * x])
                .collect(),
            ..Area::default()
        }],
        series: vec![
            series("approach", Role::Simulation, None, Colour::Blue, |t| {
                [5.0 * t, -t]
            }),
            series("retraction", Role::Simulation, None, Colour::Red, |t| {
                [4.0 * t, t * t - 0.5]
            }),
            series("flat state", Role::Guide, None, Colour::Grey, |t| {
                [4.0 * t, 0.4 * (9.0 * t).sin()]
            }),
        ],
        arrows: vec![
            Arrow {
                name: "jump",
                tail: [1.0, -0.2],
                head: [1.0, 0.4],
                colour: Colour::Blue,
                direction: Direction::Approach,
            },
            Arrow {
                name: "jump",
                tail: [3.0, 0.3],
                head: [2.6, -0.4],
                colour: Colour::Red,
                direction: Direction::Retraction,
            },
        ],
        labels: vec![Label {
            at: [2.0, -0.8],
            text: "ridge, p~ = -(4/pi)^{1/3} u~^{2/3}".to_owned(),
            ..Label::default()
        }],
        insets: vec![
            Inset {
                place: [0.02, 0.72, 0.2, 0.25],
                content: Content::Map {
                    letter: "a".to_owned(),
                    gap: bump(),
                },
            },
            Inset {
                place: [0.62, 0.6, 0.36, 0.38],
                content: Content::Diagram(Box::new(inner)),
            },
        ],
    }
}

/// Every role and symbol over logarithmic axes, leaving the frame.
fn power_panel() -> Panel {
    let symbols = [
        Symbol::Circle,
        Symbol::Square,
        Symbol::Diamond,
        Symbol::Triangle,
        Symbol::Cross,
        Symbol::Dot,
    ];
    let colours = [
        Colour::Ink,
        Colour::Green,
        Colour::Orange,
        Colour::Purple,
        Colour::Teal,
        Colour::Blue,
    ];
    let law = |factor: f64| {
        move |t: f64| {
            [
                10f64.powf(4.0 * t - 2.0),
                factor * 10f64.powf(8.0 * t / 3.0 - 6.0),
            ]
        }
    };
    let mut list = vec![
        series(
            "exact, vhat(alpha)",
            Role::Theory,
            None,
            Colour::Ink,
            law(1.0),
        ),
        series("as printed", Role::Printed, None, Colour::Ink, law(3.0)),
        series("slope 2/3", Role::Guide, None, Colour::Grey, law(30.0)),
    ];
    for (i, (symbol, colour)) in symbols.into_iter().zip(colours).enumerate() {
        let name = format!("n = {}", 64 << i);
        list.push(series(
            &name,
            Role::Simulation,
            Some(symbol),
            colour,
            law(0.8 / (i + 1) as f64),
        ));
    }
    Panel {
        x: Axis::logarithmic("u~"),
        y: Axis::logarithmic("energy per area v/(E* u_0^2/L)").from_to(1e-6, 1e-3),
        series: list,
        ..Panel::default()
    }
}

/// The picture of a figure of these diagrams.
fn drawn(panels: Vec<Panel>) -> String {
    let figure = Figure {
        panels,
        ..Figure::default()
    };
    page_svg(&figure.page())
}

fn single() -> Figure {
    Figure {
        number: 98,
        title: "All that can be drawn <&>".to_owned(),
        panels: vec![everything()],
        ..Figure::default()
    }
}

fn several(count: usize) -> Figure {
    let panels = (0..count)
        .map(|i| {
            if i % 2 == 0 {
                everything()
            } else {
                power_panel()
            }
        })
        .collect();
    Figure {
        number: 99,
        title: "Several diagrams".to_owned(),
        panels,
        ..Figure::default()
    }
}

#[test]
fn figures_become_svg_and_png_twice_the_same() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    // A folder to look at the pictures: TACKSCOPE_LOOK=/tmp/look cargo test figures_become.
    let kept = std::env::var_os("TACKSCOPE_LOOK").map(std::path::PathBuf::from);
    let out = kept.as_deref().unwrap_or(folder.path());
    for (name, figure) in [("one", single()), ("two", several(2)), ("five", several(5))] {
        let stem = out.join(name);
        assert!(write_page(&stem, &figure.page()).iter().all(Result::is_ok));
        let [svg, png] = ["svg", "png"].map(|end| stem.with_extension(end));
        let text = std::fs::read_to_string(&svg).expect("text");
        assert_eq!(text, page_svg(&figure.page()));
        assert!(
            text.contains("lost energy")
                && text.contains("data:image/png;base64,")
                && text.contains("γ"),
            "{name}"
        );
        let picture = image::open(&png).expect("a picture").into_rgb8();
        assert!(picture.width() >= 1600, "{:?}", picture.dimensions());
        // The brightest colour of a gap map (viridis), which nothing else has.
        let map = picture
            .pixels()
            .filter(|p| p.0[0] > 220 && p.0[1] > 210 && p.0[2] < 80)
            .count();
        assert!(map > 100, "{name}: {map} pixels of the maps");
        let red = picture
            .pixels()
            .filter(|p| p.0[0] > 150 && p.0[2] < 150 && p.0[1] < 150)
            .count();
        let bytes = std::fs::read(&png).expect("bytes");
        write_page_png(&png, &figure.page()).expect("a PNG");
        assert!(
            red > 500 && std::fs::read(&png).expect("bytes") == bytes,
            "{name}: {red} red pixels"
        );
    }
}

#[test]
fn nothing_is_drawn_outside_the_frame_of_a_diagram() {
    let mut panel = power_panel();
    panel.series.retain(|s| s.symbol.is_none());
    panel.series.iter_mut().for_each(|s| s.name.clear());
    let svg = drawn(vec![panel]);
    let attribute = |line: &str, key: &str| {
        Some(
            line.split(&format!(" {key}=\""))
                .nth(1)?
                .split('"')
                .next()?
                .to_owned(),
        )
    };
    let lines = |width: &str| -> Vec<Vec<[f64; 2]>> {
        let own = svg
            .lines()
            .filter(|line| attribute(line, "stroke-width").is_some_and(|found| found == width));
        let number = |text: &str| text.parse::<f64>().expect("a number");
        let place = |pair: &str| {
            pair.split_once(',')
                .map(|(x, y)| [number(x), number(y)])
                .expect("a place")
        };
        own.filter_map(|line| Some(attribute(line, "points")?.split(' ').map(place).collect()))
            .collect()
    };
    // The frame is the only closed outline.
    let outlines = lines("1");
    let frame = outlines
        .iter()
        .find(|points| points.len() == 5 && points[0] == points[4])
        .expect("a frame");
    let (low, high) = (frame[0], frame[2]);
    let curves: Vec<_> = ["1.4", "1.7", "0.9"].into_iter().flat_map(lines).collect();
    assert!(
        curves.len() >= 3 && curves.iter().map(Vec::len).sum::<usize>() > 200,
        "{curves:?}"
    );
    for p in curves.iter().flatten() {
        assert!(
            (0..2).all(|k| p[k] >= low[k] - 0.01 && p[k] <= high[k] + 0.01),
            "{p:?} outside {low:?} {high:?}"
        );
    }
}

#[test]
fn roles_differ_without_colour() {
    let text = drawn(vec![power_panel()]);
    let of = |what: &str| text.lines().filter(|line| line.contains(what)).count();
    assert!(
        of("stroke-dasharray=\"8 4\"") >= 2,
        "the printed curve and its sample in the legend"
    );
    assert!(of("stroke-width=\"1.4\"") >= 2 && of("stroke-width=\"0.9\"") >= 2);
}

#[test]
fn broken_numbers_and_empty_figures_are_drawn_too() {
    let mut panel = everything();
    panel.series[0].points[3] = [f64::NAN, 1.0];
    panel.series[1].points[5] = [1.0, f64::INFINITY];
    panel.areas[0].spans[7] = [f64::NAN; 3];
    panel.arrows[0].head = [f64::NAN, 0.0];
    panel.insets.push(Inset {
        place: [0.0, 0.0, 0.1, 0.1],
        content: Content::Map {
            letter: String::new(),
            gap: Array2::from_elem((1, 4), f64::NAN),
        },
    });
    panel.x = Axis::logarithmic("x");
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (i, panels) in [vec![], vec![Panel::default()], vec![panel]]
        .into_iter()
        .enumerate()
    {
        let figure = Figure {
            panels,
            title: "bell \u{7}".to_owned(),
            ..Figure::default()
        };
        let text = page_svg(&figure.page());
        assert!(!text.contains(['\u{7}']) && !text.contains("NaN"));
        write_page_png(&folder.path().join(format!("{i}.png")), &figure.page()).expect("a picture");
    }
}

#[test]
fn the_csv_has_a_row_for_every_point_and_a_matrix_for_every_map() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("figure-98.csv");
    write_figure_csv(&path, &single()).expect("a CSV");
    let text = std::fs::read_to_string(&path).expect("text");
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[0], "# Fig. 98: All that can be drawn <&>");
    assert_eq!(
        lines[1],
        "# panel a: x = mean displacement u0/rho, y = pressure p/sigma_max: a loop: gamma_hys"
    );
    assert_eq!(lines[3], FIGURE_COLUMNS);
    let count = |part: &str| lines.iter().filter(|line| line.starts_with(part)).count();
    assert_eq!(
        [
            "a,approach,simulation,",
            "a,flat state,guide,",
            "a,lost energy,area,",
            "a inset 1,"
        ]
        .map(count),
        [201, 201, 51, 201]
    );
    assert!(lines.contains(&"a,retraction,arrow,3.0,0.3,2.6,-0.4"));
    let matrix =
        std::fs::read_to_string(folder.path().join("figure-98-a-map-a.csv")).expect("a matrix");
    let rows: Vec<Vec<f64>> = matrix
        .lines()
        .map(|l| l.split(',').map(|c| c.parse().expect("a number")).collect())
        .collect();
    assert_eq!((rows.len(), rows[3][5]), (24, bump()[[3, 5]]));
}

#[test]
fn a_table_becomes_csv_svg_and_png_and_findings_say_whether_they_agree() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = |name: &str| folder.path().join(name);
    let cells = |cells: &[&str]| cells.iter().map(|c| (*c).to_owned()).collect::<Vec<_>>();
    let table = Table {
        number: 1,
        title: "values of mu_rho".to_owned(),
        columns: cells(&["author", "mu_rho"]),
        rows: vec![cells(&["Hillerborg, 1976", "0.5"]), cells(&["Hui", "1.09"])],
        ..Table::default()
    };
    write_table_csv(&out("t.csv"), &table).expect("a CSV");
    let csv = std::fs::read_to_string(out("t.csv")).expect("text");
    assert_eq!(
        csv,
        "# Table 1: values of mu_rho\nauthor,mu_rho\n\"Hillerborg, 1976\",0.5\nHui,1.09\n"
    );
    assert!(write_table(&out("t"), &table).iter().all(Result::is_ok));
    assert!(
        std::fs::read_to_string(out("t.svg"))
            .expect("text")
            .contains("Hillerborg, 1976")
    );
    assert!(image::open(out("t.png")).expect("a picture").width() >= 1600);
    let finding = |found, tolerance| Finding::new("p", found, 1.0, "Eq. 8", tolerance);
    let findings = [(1.25, Some(0.5)), (3.0, Some(0.5)), (2.0, None)];
    let findings = findings.map(|(found, tolerance)| finding(found, tolerance));
    write_findings_csv(
        &out("f.csv"),
        findings.iter().map(|f| ("Fig. 4".to_owned(), f)),
    )
    .expect("a CSV");
    let csv = std::fs::read_to_string(out("f.csv")).expect("text");
    assert_eq!(
        csv.lines().skip(1).collect::<Vec<_>>(),
        [
            "Fig. 4,p,1.25,1.0,Eq. 8,0.25,0.5,yes",
            "Fig. 4,p,3.0,1.0,Eq. 8,2.0,0.5,no",
            "Fig. 4,p,2.0,1.0,Eq. 8,1.0,,stated"
        ]
    );
}

fn flat_model() -> Model {
    Model {
        law: law(),
        ..scenes::flat("", 256.0, crate::scene::Points::Square(64), 4.2, 0.2, 0.02)
            .model()
            .expect("a model")
    }
}

#[test]
fn a_loop_becomes_an_svg_and_a_png() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [svg, png] = ["loop.svg", "loop.png"].map(|name| folder.path().join(name));
    let page = loop_panel::page(
        &invented_loop(),
        &flat_model(),
        "Fig. 2: four patterns <&>",
        Some(0.01),
    );
    assert!(write_page(&svg, &page).iter().all(Result::is_ok));
    let text = std::fs::read_to_string(&svg).expect("text");
    for words in [
        "Dissipated energy",
        "&lt;&amp;&gt;",
        "retraction",
        "bulge",
        "unstable",
        "lost energy",
    ] {
        assert!(text.contains(words), "{words}");
    }
    let picture = image::open(&png).expect("a picture").into_rgb8();
    assert!(picture.width() >= 1600);
    let of = |colour: Colour| {
        let rgb = colour.on(crate::plot::style::Ground::Light);
        picture.pixels().filter(|p| p.0 == rgb).count()
    };
    let [approach, retraction] = Direction::BOTH.map(|direction| of(Colour::of(direction)));
    assert!(
        approach > 2000 && retraction > 2000,
        "approach {approach} and retraction {retraction} pixels"
    );
}

#[test]
fn the_ticks_of_a_narrow_drive_are_told_apart() {
    for (middle, width) in [
        (3.1, 1e-6),
        (0.0, 1e-9),
        (2e6, 1.0),
        (0.004, 1e-3),
        (3.0, 4.0),
    ] {
        let mut record = LoopRecord::default();
        let template = &invented_loop().states[30];
        record.states.extend((0..=20).map(|i| {
            let mean_displacement = middle + width * (0.5 - f64::from(i) / 20.0);
            crate::follow::record::StateRecord {
                mean_displacement,
                ..template.clone()
            }
        }));
        let panel = loop_panel::loop_panel(&record, &flat_model());
        let (ticks, _) = crate::plot::scale::ticks(&crate::plot::scale::scales(&panel)[0]);
        let mut numbers: Vec<String> = ticks.into_iter().filter_map(|tick| tick.label).collect();
        let all = numbers.len();
        numbers.dedup();
        assert!(
            all >= 4 && numbers.len() == all,
            "{middle} +- {width}: {numbers:?}"
        );
    }
}

#[test]
fn loops_of_nothing_and_of_broken_numbers_are_drawn_too() {
    let mut one = LoopRecord::default();
    one.states.push(invented_loop().states[0].clone());
    let mut broken = invented_loop();
    broken.states[7].stress_over_max = f64::NAN;
    broken.states[9].mean_displacement = f64::INFINITY;
    broken.jumps[0].stress_after = f64::NAN;
    for record in [LoopRecord::default(), one, broken] {
        let text = page_svg(&loop_panel::page(
            &record,
            &flat_model(),
            "bell \u{7}",
            Some(0.01),
        ));
        assert!(!text.contains(['\u{7}']) && !text.contains("NaN") && !text.contains("inf"));
    }
}

#[test]
fn a_chart_is_drawn_with_its_failures_named_and_without_anything_too() {
    let text = page_svg(&chart_panel::page(
        &invented(),
        "Fig. 2 <&> \u{1b}[31m\u{fffe}",
    ));
    for word in [
        "&lt;&amp;&gt; \\u{1b}[31m\\u{fffe}",
        "not converged",
        "NaN: time step beyond its limit",
        "loop not closed",
        "Newton-Krylov",
        "Pareto front",
        "plan&#39;s choice",
    ] {
        assert!(text.contains(word), "{word}");
    }
    assert!(!page_svg(&chart_panel::page(&Chart::default(), "")).contains("NaN"));
}

#[test]
fn the_page_holds_everything_escaped_and_needs_nothing_else() {
    let finding = |found: f64, tolerance: Option<f64>| {
        Finding::new("u_c/rho <b>", found, 1.0, "Eq. 8 & more", tolerance)
    };
    let figure = Figure {
        number: 4,
        title: "a < b".to_owned(),
        words: "<script>alert(1)</script>".to_owned(),
        findings: vec![
            finding(1.01, Some(0.1)),
            finding(1.5, Some(0.1)),
            finding(2.0, None),
        ],
        ..Figure::default()
    };
    let table = Table {
        number: 1,
        rows: vec![vec!["<i>".to_owned()]],
        ..Table::default()
    };
    let evidence = vec![Evidence {
        quantity: "vhat_c",
        found: 0.400643,
        printed: 0.4204,
        right: 0.400643,
        tolerance: 1e-6,
    }];
    let errata = [Erratum {
        place: "Eq. 24",
        printed: "<0.42>",
        right: "0.40",
        because: "",
        evidence,
    }];
    let report = Report {
        figures: vec![(&figure, "look <here>")],
        tables: vec![&table],
        errata: &errata,
        missing: vec!["Fig. 5: <x>".to_owned()],
    };
    let page = report_page(&report);
    for part in [
        "<svg",
        "&lt;script&gt;",
        "u<sub>c</sub>/ρ &lt;b&gt;",
        "Eq. 8 &amp; more",
        "class=\"yes\"",
        "class=\"no\"",
        "stated only",
        "look &lt;here&gt;",
        "&lt;i&gt;",
        "&lt;0.42&gt;",
        "Fig. 5: &lt;x&gt;",
        "3 numbers are compared; 2 of them",
        "of those 1 agree",
        "@media print",
        "0.4204",
    ] {
        assert!(page.contains(part), "{part} is missing");
    }
    for foreign in ["<script", "<b>", "<i>\u{20}", "http-equiv", "src=", "<link"] {
        assert!(!page.contains(foreign), "{foreign}");
    }
    for tag in ["section", "table", "tbody", "figure", "nav", "ul", "tr"] {
        let (open, close) = (
            page.matches(&format!("<{tag}>")).count() + page.matches(&format!("<{tag} ")).count(),
            page.matches(&format!("</{tag}>")).count(),
        );
        assert_eq!(open, close, "{tag}");
    }
}
