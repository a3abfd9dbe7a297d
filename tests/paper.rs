//! Every figure of the paper, what is found in it, and its theory over a loop; and `tackscope figure` and
//! `tackscope table`, as a user or a script meets them.

#[path = "program/binary.rs"]
mod binary;

use binary::{
    Running, command, content, done, errors, folder, is_png, perform, refuses, said, says,
};
use std::f64::consts::PI;
use std::sync::OnceLock;
use std::time::Instant;
use tackscope::numerics::threads::Cancel;
use tackscope::paper::{Entry, Figure, GALLERY, Size, Stopped, TABLES, Task, UNDER_LOAD, scenes};
use tackscope::physics::body::{Body, Layer};
use tackscope::plot::curve::{TheoryLine, ZeroRange};
use tackscope::plot::panel::{Content, Panel, Role};
use tackscope::scene::Points;
use tackscope::storage;

fn check_panel(number: usize, panel: &Panel) {
    assert!(
        !panel.x.label.is_empty() && !panel.y.label.is_empty(),
        "figure {number}: an axis without a name"
    );
    assert!(
        !panel.series.is_empty() || !panel.areas.is_empty(),
        "figure {number}: an empty diagram"
    );
    for series in &panel.series {
        let finite = series
            .points
            .iter()
            .filter(|p| p[0].is_finite() && p[1].is_finite())
            .count();
        assert!(
            finite > 0,
            "figure {number}: nothing to see of {:?}",
            series.name
        );
    }
    for inset in &panel.insets {
        match &inset.content {
            Content::Map { gap, .. } => assert!(gap.iter().all(|g| g.is_finite())),
            Content::Diagram(inner) => check_panel(number, inner),
        }
    }
}

/// Every figure, those under a load last.
fn all() -> impl Iterator<Item = &'static Entry> {
    GALLERY.iter().chain(UNDER_LOAD)
}

/// The figure at a place among all, computed once for all tests; its progress only grows.
fn computed(place: usize) -> &'static Figure {
    static FIGURES: [OnceLock<Figure>; 32] = [const { OnceLock::new() }; 32];
    FIGURES[place].get_or_init(|| {
        let entry = all().nth(place).unwrap();
        let began = Instant::now();
        let (cancel, mut last) = (Cancel::default(), 0.0);
        let mut observe = |share: f64, _: &str| {
            assert!(
                (last..=1.0).contains(&share),
                "figure {}: progress went from {last} to {share}",
                entry.number
            );
            last = share;
        };
        let task = &mut Task::new(Size::Quick, &cancel, &mut observe);
        let figure = (entry.compute)(task).unwrap();
        let seconds = began.elapsed().as_secs_f64();
        println!("figure {}: {seconds:.2} s", entry.number);
        figure
    })
}

fn check((place, entry): (usize, &Entry)) {
    let figure = computed(place);
    assert_eq!(figure.number, entry.number);
    assert!(!figure.words.is_empty() && !figure.findings.is_empty());
    for panel in &figure.panels {
        check_panel(figure.number, panel);
    }
    for finding in &figure.findings {
        let gap = finding.found - finding.expected;
        println!(
            "  {} = {:.6} against {:.6} ({gap:+.1e}), {}",
            finding.quantity, finding.found, finding.expected, finding.source
        );
        assert_ne!(
            finding.agrees(),
            Some(false),
            "figure {}: {finding:?}",
            entry.number
        );
    }
}

#[test]
fn every_figure_agrees_with_its_theory_and_its_progress_only_grows() {
    all().enumerate().for_each(check);
}

#[test]
fn the_gallery_is_in_the_papers_order_and_its_scenes_are_allowed() {
    assert!(
        GALLERY
            .windows(2)
            .all(|pair| pair[0].number < pair[1].number)
    );
    for entry in all() {
        (entry.scene)()
            .validate()
            .unwrap_or_else(|error| panic!("figure {}: {error}", entry.number));
        assert!(
            !entry.title.is_empty() && entry.look_for.matches(['.', '?', '!']).count() >= 2,
            "figure {}",
            entry.number
        );
    }
}

#[test]
fn a_figure_that_is_stopped_says_so() {
    let cancel = Cancel::default();
    cancel.request();
    for entry in all() {
        let stopped = (entry.compute)(&mut Task::new(Size::Quick, &cancel, &mut |_, _| ()));
        assert_eq!(
            stopped.err(),
            Some(Stopped::Cancelled),
            "figure {}",
            entry.number
        );
    }
}

#[test]
fn the_scenes_of_figures_2_and_3_and_the_ridge_s_are_the_presets() {
    for (scene, name) in [
        (scenes::figure_2(), "fig2"),
        (scenes::figure_3(), "fig3"),
        (scenes::ridge_line(), "ridge-line"),
    ] {
        let mut preset = storage::resolve(name).unwrap();
        preset.source = scene.source.clone();
        assert_eq!(scene, preset);
    }
}

#[test]
fn every_table_is_full_and_agrees_with_the_print() {
    let cancel = Cancel::default();
    for entry in TABLES {
        let table = (entry.compute)(&mut Task::new(Size::Quick, &cancel, &mut |_, _| ())).unwrap();
        assert_eq!(
            (table.number, table.title.as_str()),
            (entry.number, entry.title)
        );
        assert!(
            !table.rows.is_empty()
                && table
                    .rows
                    .iter()
                    .all(|row| row.len() == table.columns.len())
        );
        assert!(
            table
                .findings
                .iter()
                .all(|finding| finding.agrees() == Some(true)),
            "{:?}",
            table.findings
        );
    }
}

fn figure(number: usize) -> &'static Figure {
    computed(all().position(|entry| entry.number == number).unwrap())
}

/// Asserts that all judged findings agree, and that there are at least `count` of them.
fn assert_agrees(figure: &Figure, count: usize) {
    let wrong: Vec<_> = figure
        .findings
        .iter()
        .filter(|f| f.agrees() == Some(false))
        .collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(
        figure
            .findings
            .iter()
            .filter(|f| f.agrees().is_some())
            .count()
            >= count
    );
    assert!(
        !figure.words.is_empty() && !figure.words.contains("NaN"),
        "{}",
        figure.words
    );
    for series in figure.panels.iter().flat_map(|panel| &panel.series) {
        assert!(series.points.len() > 1, "{} is empty", series.name);
    }
}

/// Found and expected of the findings whose quantity begins with `begin` and whose source contains
/// `source`.
fn pairs(figure: &Figure, begin: &str, source: &str) -> Vec<(f64, f64)> {
    let wanted = figure
        .findings
        .iter()
        .filter(|f| f.quantity.starts_with(begin) && f.source.contains(source));
    wanted.map(|f| (f.found, f.expected)).collect()
}

#[test]
fn noise_on_a_flat_surface_begins_to_grow_where_eq_8_says_from_just_above_l_c_to_a_hundred() {
    let figure = figure(4);
    assert_agrees(figure, 17);
    let cells: Vec<f64> = figure.panels[0]
        .series
        .iter()
        .filter(|s| s.role == Role::Simulation)
        .flat_map(|s| &s.points)
        .map(|p| p[0])
        .collect();
    assert!(
        cells.len() >= 16 && cells.iter().any(|c| *c < 1.1) && cells.iter().any(|c| *c >= 100.0),
        "{cells:?}"
    );
}

#[test]
fn the_ridge_comes_closer_to_the_exact_one_and_to_its_end_with_half_the_range() {
    let figure = figure(7);
    assert_agrees(figure, 3);
    let middle = pairs(figure, "largest |p̃", "exact");
    // Half the range: at least as much as the first order would give.
    assert!(
        middle.len() == 2 && middle[1].0 < 0.5 * middle[0].0,
        "{middle:?}"
    );
    for end in ["ũ₀ where the ridge flattens", "ũ₀ where the ridge closes"] {
        let off: Vec<f64> = pairs(figure, end, "exact")
            .iter()
            .map(|(found, exact)| (found - exact).abs())
            .collect();
        assert!(off.len() == 2 && off[1] < off[0], "{end}: {off:?}");
    }
}

#[test]
fn sixteen_points_carry_a_ridge_up_to_mu_rho_one_half_and_pin_it_above() {
    let figure = figure(8);
    assert_agrees(figure, 6);
    let jumps: Vec<f64> = pairs(figure, "jumps from ridge to ridge", "")
        .iter()
        .map(|p| p.0)
        .collect();
    assert_eq!(jumps[..2], [0.0, 0.0]);
    assert!(jumps[2..].iter().all(|n| *n > 0.0), "{jumps:?}");
    // The two limits that the text quotes ask for the same mu_rho, and that is not 0.5.
    let asked = pairs(figure, "μ_ρ at which", "");
    assert!(
        (asked[0].0 - asked[1].0).abs() < 0.02 && asked[0].0 > 0.6,
        "{asked:?}"
    );
}

#[test]
fn the_loss_tends_to_that_of_the_exact_ridge_as_the_range_shrinks_and_never_reaches_the_printed_one()
 {
    let figure = figure(11);
    assert_agrees(figure, 15);
    let cosine = pairs(figure, "γ_hys/γ, cosine", "exact ridge");
    let off: Vec<f64> = cosine
        .iter()
        .map(|(found, theory)| (found / theory - 1.0).abs())
        .collect();
    assert!(
        off.len() >= 3 && off.windows(2).all(|w| w[0] < w[1]),
        "shorter ranges come first: {off:?}"
    );
    let zero = pairs(figure, "γ_hys/γ without range", "printed");
    assert!(
        (zero[0].0 - 1.087557).abs() < 1e-6 && (zero[0].1 - 1.365).abs() < 5e-4,
        "{zero:?}"
    );
    let points = figure.panels[0]
        .series
        .iter()
        .filter(|s| s.role == Role::Simulation)
        .flat_map(|s| &s.points);
    assert!(points.into_iter().all(|p| p[1] > 0.0 && p[1] < zero[0].0));
}

#[test]
fn a_figure_stops_when_asked() {
    for number in [4, 7, 8, 11] {
        let entry = GALLERY.iter().find(|entry| entry.number == number).unwrap();
        let cancel = Cancel::default();
        let (token, mut told) = (cancel.clone(), 0);
        let mut observe = |_: f64, _: &str| {
            told += 1;
            if told == 3 {
                token.request();
            }
        };
        let end = (entry.compute)(&mut Task::new(Size::Quick, &cancel, &mut observe));
        assert_eq!(end.err(), Some(Stopped::Cancelled), "Fig. {number}");
    }
}

#[test]
fn a_tip_has_the_branch_of_jkr_alone_and_in_its_cell_up_to_their_ends() {
    let model = scenes::tip(64, 0.5).model().expect("a model");
    let lines = ZeroRange::compute(&Cancel::default())
        .unwrap()
        .lines(&model, -0.0145, 0.02);
    assert_eq!(
        lines.iter().map(|line| line.name).collect::<Vec<_>>(),
        ["JKR", "JKR, periodic"]
    );
    let gamma = scenes::TIP_SURFACE_ENERGY;
    let pull = |line: &TheoryLine| {
        line.points.iter().map(|p| p[1]).fold(0.0, f64::max) / (1.5 * PI * gamma)
    };
    assert!((pull(&lines[0]) - 1.0).abs() < 1e-3 && (pull(&lines[1]) - 1.0041178).abs() < 1e-3);
    for line in &lines {
        assert!(
            line.points.windows(2).all(|pair| pair[1][0] > pair[0][0])
                && line.points[0][0] < -0.013,
            "{line:?}"
        );
    }
    // The branch alone turns back at 5/9 of the pull-off force, where a^3 = pi gamma R^2/8.
    let end = lines[0].points.last().expect("points");
    let a = (PI * gamma / 8.0).cbrt();
    assert!(
        (end[0] - ((2.0 * PI * gamma * a).sqrt() - a * a)).abs() < 1e-4,
        "{end:?}"
    );
}

#[test]
fn over_a_layer_there_is_no_theory_but_the_flat_state() {
    let body = Body::Layer(Layer {
        thickness: 0.1,
        poisson: 0.5,
    });
    let theory = ZeroRange::compute(&Cancel::default()).unwrap();
    let flat = scenes::flat("", 1024.0, Points::Square(64), 6.0, 0.2, 0.02);
    for (scene, lines) in [(scenes::tip(64, 0.5), 0), (flat, 1)] {
        let mut model = scene.model().expect("a model");
        assert!(theory.lines(&model, -0.01, 1.0).len() > lines);
        model.body = body;
        assert_eq!(theory.lines(&model, -0.01, 1.0).len(), lines);
    }
}

#[test]
fn the_lines_are_theory_in_the_units_of_the_scene() {
    let scene = scenes::flat("", 1024.0, Points::Square(64), 6.0, 0.2, 0.02);
    let model = scene.model().expect("a model");
    let lines = ZeroRange::compute(&Cancel::default())
        .unwrap()
        .lines(&model, 0.2, 6.0);
    assert_eq!(
        lines.iter().map(|line| line.name).collect::<Vec<_>>(),
        ["flat", "ridge", "dimple", "bulge"]
    );
    // The ridge flattens at u_c~ = 0.665607924 with p_c~ = -0.354996680: here sqrt(gamma L) =
    // sqrt(153.6), p = p~ gamma/u0.
    let end = lines[1].points.last().expect("points");
    let u0 = 0.665607924 * 153.6f64.sqrt();
    assert!(
        (end[0] - u0).abs() < 1e-6 && (end[1] - 0.354996680 * 0.15 / u0).abs() < 1e-9,
        "{end:?}"
    );
    // A small dimple: p~ = -(1.79301 u~)^(4/5) to leading order, approached as alpha^3, that is
    // u~^(6/5).
    let [u0, stress] = lines[2].points[1];
    let u = u0 / 153.6f64.sqrt();
    assert!(
        (stress * u0 / 0.15 / (1.79301 * u).powf(0.8) - 1.0).abs() < 2.0 * u.powf(1.2),
        "{u} {stress}"
    );
    // The flat state feels the law itself: sigma_max = gamma/(2 rho) at rho ln 2.
    let top = lines[0].points.iter().map(|p| p[1]).fold(0.0, f64::max);
    assert!((top - 0.075).abs() < 1e-4, "{top}");
    let line = scenes::flat("", 1024.0, Points::Line(64), 6.0, 0.2, 0.02)
        .model()
        .expect("a model");
    assert_eq!(
        ZeroRange::compute(&Cancel::default())
            .unwrap()
            .lines(&line, 0.2, 6.0)
            .len(),
        2
    );
}

#[test]
fn a_figure_becomes_data_and_pictures_and_one_closing_line() {
    let home = folder();
    let output = perform(&["figure", "4", "--quick"], home.path());
    let line = done(&output);
    assert!(
        line.starts_with("1 figure") && line.lines().count() == 1,
        "{line}"
    );
    says(
        &errors(&output),
        &["Fig. 4: Where the flat surface gives way"],
    );
    let csv = content(home.path().join("figure-04.csv"));
    assert!(csv.starts_with("# Fig. 4: ") && csv.contains("\npanel,series,role,x,y,x_to,y_to\n"));
    assert!(content(home.path().join("figure-04.svg")).starts_with("<svg"));
    assert!(is_png(&home.path().join("figure-04.png")));
}

#[test]
fn an_unknown_figure_or_table_is_refused_with_what_there_is() {
    for (arguments, allowed) in [
        (["figure", "77"], "or all"),
        (["figure", "all4"], "4"),
        (["table", "2"], "1"),
    ] {
        let home = folder();
        let out = home.path().join("out");
        let output = perform(&arguments, &out);
        refuses(&output, &[arguments[1], allowed]);
        assert!(!out.exists(), "nothing is written for a refused number");
    }
}

#[test]
fn table_1_becomes_data_and_pictures() {
    let home = folder();
    let output = perform(&["table", "1"], home.path());
    done(&output);
    let csv = content(home.path().join("table-1.csv"));
    for row in [
        "Dugdale,1960,0.798,π/8,0.7979",
        "Popov,2015,0.729,0.47,0.7293",
    ] {
        assert!(csv.lines().any(|line| line == row), "{row} in {csv}");
    }
    for name in ["table-1.svg", "table-1.png"] {
        assert!(home.path().join(name).exists(), "{name}");
    }
    assert!(said(&output).contains("6 of 6 findings agree"));
}

#[test]
fn quiet_is_silent() {
    let output = perform(&["figure", "4", "--quick", "--quiet"], folder().path());
    assert!(output.status.success() && output.stdout.is_empty() && output.stderr.is_empty());
}

#[test]
fn a_report_is_one_page_with_picture_findings_table_and_errata() {
    let home = folder();
    let output = perform(
        &["figure", "4", "--quick", "--quiet", "--report"],
        home.path(),
    );
    done(&output);
    let page = content(home.path().join("report.html"));
    says(
        &page,
        &[
            "<svg",
            "Fig. 4",
            "Table 1",
            "Dugdale",
            "What the print got wrong",
            "0.400643",
            "</html>",
        ],
    );
    let findings = content(home.path().join("findings.csv"));
    assert!(
        findings.starts_with("where,quantity,found,expected,source,deviation,tolerance,agrees\n")
    );
    assert!(
        findings
            .lines()
            .any(|line| line.starts_with("Table 1,") && line.ends_with(",yes")),
        "{findings}"
    );
}

#[test]
#[cfg(unix)]
fn ctrl_c_keeps_what_is_done_and_the_report_says_what_is_missing() {
    let home = folder();
    let words = ["figure", "all", "--quick", "--report"];
    let mut going = Running::spawn(command(&words, home.path()));
    let mut done = String::new();
    while !done.starts_with("Fig. ") {
        done = going.line();
        assert!(!done.is_empty(), "it ended before a figure was done");
    }
    going.signal("INT");
    let (code, rest) = going.end();
    assert_eq!(code, Some(130), "{rest}");
    says(&rest, &["interrupted; what was computed is in"]);
    let number: usize = done[5..]
        .split(':')
        .next()
        .and_then(|n| n.parse().ok())
        .expect("its number");
    assert!(home.path().join(format!("figure-{number:02}.png")).exists());
    let page = content(home.path().join("report.html"));
    assert!(
        page.contains(&format!("id=\"figure-{number}\"")) && page.contains("stopped"),
        "the page says what is missing"
    );
}
