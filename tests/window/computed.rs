//! Tabs whose contents a job computes. Speed against accuracy, and a study: marks as they come, and the
//! scene of a mark. The paper: pages, findings, errata, the scene of a figure, theory over the live plot.

use super::bench::Bench;
use super::hand::Hand;
use egui::{Key, pos2};
use egui_kittest::kittest::{NodeT, Queryable};
use std::sync::Arc;
use tackscope::follow::record::Direction;
use tackscope::numerics::threads::Cancel;
use tackscope::paper::Finding;
use tackscope::paper::errata::{Erratum, Evidence};
use tackscope::paper::{Figure, GALLERY, Size, Task};
use tackscope::plot::curve::ZeroRange;
use tackscope::plot::panel::{
    Area, Arrow, Axis, Colour, Content, Inset, Label, Panel, Role, Series, Symbol,
};
use tackscope::scene::{Points, Range, Strategy};
use tackscope::solver::methods::MethodKind;
use tackscope::study::chart::{Effort, Errors, Judged, Point, Precision, Verdict};
use tackscope::worker::background::{ChartSoFar, Page, PageContent};
use tackscope::worker::job::Reporter;
use tackscope::worker::protocol::Command;

fn row(method: MethodKind, seconds: f64, error: f64, verdict: Verdict) -> Judged {
    Judged {
        point: Point {
            method,
            model: Strategy::WHOLE,
            line: false,
            points: 48,
            precision: Precision::Double,
            step: 0.08,
        },
        dissipated_energy: 0.1174,
        errors: Errors {
            dissipated_energy: error,
            jumps: error,
            stress: error,
        },
        transforms: (seconds * 1e4) as usize,
        transforms_per_increment: 20.0,
        seconds,
        processor_seconds: seconds,
        pareto_transforms: false,
        pareto_time: false,
        plan: method == MethodKind::NewtonKrylov,
        paper_budget: method == MethodKind::Gfmd,
        verdict,
    }
}

fn chart() -> ChartSoFar {
    let failed = Verdict::Failed {
        what: "2 jumps missing".to_owned(),
        message: "two jumps of the reference are missing".to_owned(),
    };
    ChartSoFar {
        rows: vec![
            row(MethodKind::NewtonKrylov, 0.3, 1e-4, Verdict::Done),
            row(MethodKind::Fire, 2.0, 3e-4, Verdict::Done),
            row(MethodKind::Gfmd, 9.0, f64::NAN, failed),
        ],
        floor: Some(1e-6),
    }
}

#[test]
fn a_chart_is_asked_for_shown_as_it_comes_and_cancelled() {
    let mut bench = Bench::new();
    bench.click("Speed and accuracy tab");
    bench.click("Run quick");
    let (effort, report) = bench.chart();
    assert_eq!(effort, Effort::Quick);
    report.progress(0.3, "fire, whole, n = 48");
    report.result(ChartSoFar {
        rows: chart().rows[..1].to_vec(),
        floor: None,
    });
    bench.settle();
    bench.says("fire, whole, n = 48");
    bench.says("1 points measured, 0 of them failed");
    bench.click("Cancel");
    assert!(report.cancel.requested());
    report.end(Ok(()));
    bench.settle();
    assert!(bench.query_by_label("Run full").is_some());
    assert!(
        bench.names().contains("1 points measured"),
        "what was measured stays"
    );
}

#[test]
fn every_mark_is_found_by_the_pointer_failures_on_the_top_edge_and_a_click_makes_its_settings_the_scenes()
 {
    let mut bench = Bench::new();
    bench.click("Speed and accuracy tab");
    bench.click("Run quick");
    let (_, report) = bench.chart();
    bench.answer(&report, chart());
    let plot = bench.place_of("Speed against accuracy: 3 points measured, 1 of them failed");
    // Which row the pointer is on is known by what is said beside it.
    let mut found: Vec<(&str, egui::Pos2)> = Vec::new();
    for i in 0..(plot.height() / 8.0) as usize {
        for k in 0..(plot.width() / 8.0) as usize {
            let at = pos2(
                plot.left() + 3.0 + 8.0 * k as f32,
                plot.top() + 3.0 + 8.0 * i as f32,
            );
            bench.hover_at(at);
            bench.step();
            bench.step();
            let names = bench.names();
            for word in [
                "newton, whole, n = 48",
                "fire, whole, n = 48",
                "gfmd, whole, n = 48",
            ] {
                if names.contains(word) && found.iter().all(|(w, _)| *w != word) {
                    assert_eq!(
                        word.starts_with("gfmd"),
                        names.contains("failed: two jumps of the reference are missing")
                    );
                    found.push((word, at));
                }
            }
        }
    }
    assert_eq!(found.len(), 3, "{found:?}");
    let at = |word: &str| found.iter().find(|(w, _)| w.starts_with(word)).unwrap().1;
    assert!(
        at("gfmd").y < plot.top() + 0.2 * plot.height() && at("gfmd").y < at("fire").y,
        "failures stand on the top edge"
    );
    assert!(at("newton").x < at("fire").x && at("fire").x < at("gfmd").x);
    bench.heard();
    bench.click_at(at("fire"));
    assert_eq!(
        (bench.view().method, bench.view().scene.cell.points),
        (MethodKind::Fire, Points::Square(48))
    );
    assert_eq!(bench.view().scene.drive.step, 0.08);
    let heard = bench.heard();
    assert!(
        matches!(
            &heard[..],
            [
                Command::SetScene {
                    method: MethodKind::Fire,
                    ..
                },
                ..
            ]
        ),
        "{heard:?}"
    );
    assert!(
        bench.names().contains("3 points measured"),
        "it is still a chart of this loop"
    );
    bench.click("law cosine");
    bench.lacks("points measured");
}

#[test]
fn one_measurement_is_under_way_at_a_time_and_ends_with_its_run_and_the_layout_is_restored() {
    let mut bench = Bench::new();
    bench.click("Speed and accuracy tab");
    bench.click("Run quick");
    let (_, chart) = bench.chart();
    bench.click("Stability tab");
    bench.click("time steps");
    bench.click("Measure");
    let (_, steps) = bench.time_steps();
    assert!(chart.cancel.requested() && !steps.cancel.requested());
    chart.end(Err("stopped".to_owned()));
    bench.click("Speed and accuracy tab");
    assert!(
        bench.view().messages.failure.is_none(),
        "who stopped it needs not hear of it"
    );
    bench.click("Run full");
    let (effort, chart) = bench.chart();
    assert_eq!(effort, Effort::Full { seconds: 120.0 });
    assert!(steps.cancel.requested());
    bench.click("Reset");
    assert!(chart.cancel.requested());
    bench.click("Run quick");
    let (_, chart) = bench.chart();
    chart.end(Err("no reference".to_owned()));
    bench.settle();
    let failure = bench.view().messages.failure.as_ref().expect("said");
    assert!(failure.message.contains("no reference"), "{failure:?}");

    bench.click("transforms");
    let transforms = |bench: &Bench| {
        let radio = bench.get_by_label("transforms");
        radio.accesskit_node().toggled() == Some(egui::accesskit::Toggled::True)
    };
    assert!(transforms(&bench));
    bench.ctrl(egui::Key::K);
    bench.click("Restore layout");
    assert_eq!(bench.view().view.tab, 0, "the first tab is the chosen one");
    bench.click("Speed and accuracy tab");
    assert!(!transforms(&bench));
}

fn bench() -> Bench {
    let mut bench = Bench::new();
    bench.click("Study tab");
    bench.enter("loops", "3");
    bench.enter("from", "1.1");
    bench.enter("to", "1.3");
    bench.run_jobs();
    bench
}

#[test]
fn marks_come_from_a_job_and_a_click_opens_the_scene_of_one_until_it_is_undone() {
    let mut bench = bench();
    bench.click("Compute");
    bench.run_jobs();
    let said = "Study of law.range: 3 of 3 loops; a click opens one";
    bench.says(said);
    let picture = bench.place_of(said);
    // The first mark: the loss falls with the range, so that it is the highest on the left.
    let mut at = picture.left_top();
    'search: for x in 30..160 {
        for y in 0..60 {
            at = picture.left_top() + egui::vec2(x as f32, y as f32);
            bench.hover_at(at);
            bench.step();
            if bench.output().platform_output.cursor_icon == egui::CursorIcon::PointingHand {
                break 'search;
            }
        }
    }
    bench.click_at(at);
    assert_eq!(bench.view().scene.law.range, Range::Length(1.1));
    assert!(bench.names().contains(said), "marks of this scene stay");
    bench.ctrl(egui::Key::Z);
    assert_eq!(bench.view().scene.law.range, Range::Length(1.0));
}

#[test]
fn a_value_that_is_refused_is_a_mark_of_its_own_and_said() {
    let mut bench = Bench::new();
    bench.click("Study tab");
    bench.click("Number that goes");
    bench.click("start of the drive");
    bench.enter("loops", "2");
    bench.enter("from", "0.1");
    bench.enter("to", "4.2");
    bench.click("Compute");
    bench.run_jobs();
    bench.says("Study of drive.start: 2 of 2 loops, 1 failed");
}

#[test]
fn a_study_of_another_scene_is_not_shown() {
    let mut bench = bench();
    bench.click("Compute");
    bench.run_jobs();
    bench.says("Study of law.range");
    bench.tap(egui::Key::Num2);
    bench.lacks("Study of law.range");
}

fn opened() -> Bench {
    let mut bench = Bench::new();
    bench.heard();
    bench.click("Paper tab");
    bench
}

/// The one page that the window asked for since the last call.
fn asked(bench: &Bench, page: Page) -> Reporter<PageContent> {
    let mut pages = bench.pages();
    assert_eq!(
        pages.iter().map(|(page, _)| *page).collect::<Vec<_>>(),
        [page]
    );
    pages.remove(0).1
}

fn first() -> usize {
    GALLERY[0].number
}

fn made_up(number: usize) -> Figure {
    let points = vec![[1.0, 1.0], [10.0, 3.0], [f64::NAN, 0.0], [100.0, 2.0]];
    let series = |role, symbol| Series {
        name: format!("{role:?}"),
        role,
        symbol,
        colour: Colour::Blue,
        points: points.clone(),
        ..Series::default()
    };
    let inner = Panel {
        x: Axis::linear("t"),
        y: Axis::linear("s"),
        series: vec![series(Role::Theory, None)],
        ..Panel::default()
    };
    let panel = Panel {
        x: Axis::logarithmic("L/L_c"),
        y: Axis::linear("u_c/rho"),
        areas: vec![Area {
            name: "loss".to_owned(),
            colour: Colour::Gold,
            spans: vec![[1.0, 0.0, 1.0], [10.0, 0.0, 1.0]],
            ..Area::default()
        }],
        series: vec![
            series(Role::Simulation, Some(Symbol::Circle)),
            series(Role::Theory, None),
            series(Role::Printed, None),
        ],
        arrows: vec![Arrow {
            name: "jump",
            tail: [1.0, 1.0],
            head: [10.0, 2.0],
            colour: Colour::Red,
            direction: Direction::Retraction,
        }],
        labels: vec![Label {
            at: [10.0, 2.0],
            text: "here".to_owned(),
            ..Label::default()
        }],
        insets: vec![
            Inset {
                place: [0.1, 0.6, 0.2, 0.3],
                content: Content::Map {
                    letter: "a".to_owned(),
                    gap: ndarray::Array2::from_shape_fn((8, 8), |(j, i)| (i * j) as f64),
                },
            },
            Inset {
                place: [0.6, 0.6, 0.3, 0.3],
                content: Content::Diagram(Box::new(inner)),
            },
        ],
        ..Panel::default()
    };
    let finding =
        |found, tolerance| Finding::new("slope of the line", found, 1.0, "Eq. 8", tolerance);
    Figure {
        number,
        title: "made up".to_owned(),
        panels: vec![panel.clone(), panel],
        words: "A paragraph about it.".to_owned(),
        findings: vec![
            finding(1.01, Some(0.1)),
            finding(1.5, Some(0.1)),
            finding(2.0, None),
        ],
    }
}

fn figure(number: usize) -> PageContent {
    PageContent::Figure(Arc::new(made_up(number)))
}

#[test]
fn the_tab_asks_for_its_figure_once_says_how_far_it_is_and_can_be_cancelled() {
    let mut bench = opened();
    let page = Page::Figure(first());
    let report = asked(&bench, page);
    report.progress(0.4, "the loop of the day");
    bench.settle();
    bench.says("the loop of the day");
    bench.says(GALLERY[0].title);
    bench.click("Events tab");
    assert!(report.cancel.requested(), "nobody looks at it any more");
    bench.click("Paper tab");
    let report = asked(&bench, page);
    bench.click("Cancel");
    assert!(report.cancel.requested() && bench.pages().is_empty());
    bench.says("Not there: cancelled.");
    bench.click("Compute");
    asked(&bench, page).end(Err("no convergence".to_owned()));
    bench.settle();
    bench.says("Not there: no convergence.");
    assert!(
        bench.pages().is_empty(),
        "what failed is not tried again by itself"
    );
}

#[test]
fn another_figure_takes_the_place_of_the_one_under_way_and_what_came_is_kept() {
    let mut bench = opened();
    let [one, two, three] = [GALLERY[0].number, GALLERY[1].number, GALLERY[2].number];
    let report = asked(&bench, Page::Figure(one));
    // It comes in the very frame in which another one is asked for.
    report.result(figure(one));
    report.end(Ok(()));
    bench.click(&format!("Figure {three}"));
    let dropped = asked(&bench, Page::Figure(three));
    assert!(
        !bench.names().contains("A paragraph about it."),
        "another page is looked at"
    );
    bench.click(&format!("Figure {two}"));
    assert!(dropped.cancel.requested());
    let report = asked(&bench, Page::Figure(two));
    bench.answer(&report, figure(two));
    for words in [
        format!("Fig. {two} diagram a: u_c/rho against L/L_c, 3 curves"),
        format!("Fig. {two} diagram b: u_c/rho against L/L_c, 3 curves"),
        format!("Fig. {two} diagram a inset 2: s against t, 1 curves"),
        "A paragraph about it.".to_owned(),
        "1.01, expected 1 (Eq. 8): agrees".to_owned(),
        "1.5, expected 1 (Eq. 8): does not agree".to_owned(),
        "2, expected 1 (Eq. 8): stated".to_owned(),
    ] {
        bench.says(&words);
    }
    bench.click(&format!("Figure {one}"));
    bench.says(&format!("Fig. {one} diagram a"));
    assert!(bench.pages().is_empty(), "both are known");
}

#[test]
fn a_figure_is_chosen_by_the_keyboard_and_its_scene_opened() {
    let mut bench = opened();
    let entry = &GALLERY[1];
    bench
        .get_by_label(&format!("Figure {}", entry.number))
        .focus();
    bench.settle();
    bench.tap(Key::Enter);
    let last = bench.pages().pop().expect("asked for");
    assert_eq!(last.0, Page::Figure(entry.number));
    bench.heard();
    bench.click("Open this scene");
    assert_eq!(bench.scenes(), [(entry.scene)()]);
    assert!(bench.view().plots.overlay, "with theory over it");
    bench.click("Undo");
    assert_eq!(*bench.view().scene, super::bench::fig2());
}

#[test]
fn theory_is_laid_over_the_live_plot_in_its_units_and_follows_the_scene() {
    let mut bench = opened();
    let report = asked(&bench, Page::Figure(first()));
    bench.answer(&report, figure(first()));
    bench.click("Overlay theory");
    let report = asked(&bench, Page::Theory);
    assert!(bench.view().overlay().is_empty());
    bench.answer(
        &report,
        PageContent::Theory(Arc::new(ZeroRange::compute(&Cancel::default()).unwrap())),
    );
    let lines = bench.view().overlay();
    assert_eq!(
        lines.iter().map(|line| line.0).collect::<Vec<_>>(),
        ["flat", "ridge", "dimple", "bulge"]
    );
    // sigma_max is the largest of the flat state; the ridge of Fig. 2 flattens at 0.665608
    // sqrt(0.15 * 256) rho.
    let top = lines[0].1.iter().map(|p| p[1]).fold(0.0, f64::max);
    let end = lines[1].1.last().expect("points")[0];
    assert!(
        (top - 1.0).abs() < 1e-2 && (end - 4.12463).abs() < 1e-4,
        "{top} {end}"
    );
    bench.click("Line cell (uniform along y)");
    assert_eq!(
        bench.view().overlay().len(),
        2,
        "a line cell knows no dimple"
    );
    bench.click("Overlay theory");
    assert!(bench.view().overlay().is_empty());
}

#[test]
fn the_errata_are_listed_with_their_evidence() {
    let mut bench = opened();
    bench.pages();
    bench.click("Errata");
    let report = asked(&bench, Page::Errata);
    let evidence = vec![Evidence {
        quantity: "root of the slope",
        found: 0.4006428,
        printed: 0.4204,
        right: 0.4006428,
        tolerance: 1e-6,
    }];
    let erratum = Erratum {
        place: "Eq. 24",
        printed: "0.4204",
        right: "0.40064",
        because: "It is exact.",
        evidence,
    };
    bench.answer(&report, PageContent::Errata(Arc::new(vec![erratum])));
    for words in [
        "Eq. 24",
        "printed: 0.4204",
        "right: 0.40064",
        "root of the slope: 0.400643; print 0.4204, right 0.400643",
    ] {
        bench.says(words);
    }
}

#[test]
fn a_page_has_a_window_of_its_own_and_every_panel_stays_inside() {
    let mut bench = Bench::sized(900.0, 600.0);
    bench.click("Paper tab");
    let report = asked(&bench, Page::Figure(first()));
    bench.answer(&report, figure(first()));
    for label in ["Play loop", "Menu", "Fit", "Open this scene", "Enlarge"] {
        let rect = bench.place_of(label);
        assert!(
            rect.min.x >= 0.0 && rect.max.x <= 900.0 && rect.max.y <= 600.0,
            "{label} at {rect:?}"
        );
    }
    // A new window finds its size in a few more frames than `run` allows.
    bench.get_by_label("Enlarge").click();
    bench.run_steps(10);
    let diagrams = bench
        .names()
        .matches(&format!("Fig. {} diagram a:", first()))
        .count();
    assert_eq!(diagrams, 2, "in the tab and in the window");
}

#[test]
fn the_first_figure_of_the_gallery_is_drawn_as_it_is_computed() {
    let mut bench = opened();
    // The quickest one: closed forms.
    let entry = GALLERY
        .iter()
        .find(|entry| entry.number == 10)
        .expect("Fig. 10");
    let cancel = Cancel::default();
    let figure =
        (entry.compute)(&mut Task::new(Size::Quick, &cancel, &mut |_, _| {})).expect("a figure");
    bench.pages();
    bench.click("Figure 10");
    let report = asked(&bench, Page::Figure(10));
    bench.answer(&report, PageContent::Figure(Arc::new(figure)));
    bench.says("Fig. 10 diagram a:");
}
