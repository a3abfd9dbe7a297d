//! The Paper tab: pages, findings, errata, the scene of a figure, theory over the live plot.

use super::bench::Bench;
use super::hand::Hand;
use egui::Key;
use egui_kittest::kittest::Queryable;
use std::sync::Arc;
use tackscope::follow::record::Direction;
use tackscope::numerics::cancel::Cancel;
use tackscope::paper::errata::{Erratum, Evidence};
use tackscope::paper::figure::Finding;
use tackscope::paper::overlay::ZeroRange;
use tackscope::paper::{Figure, GALLERY, Size, Task};
use tackscope::plot::panel::{
    Area, Arrow, Axis, Colour, Content, Inset, Label, Panel, Role, Series, Symbol,
};
use tackscope::worker::background::{Page, PageContent};
use tackscope::worker::job::Reporter;

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

/// A page is there.
fn done(bench: &mut Bench, report: &Reporter<PageContent>, content: PageContent) {
    report.result(content);
    report.end(Ok(()));
    bench.settle();
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
    done(&mut bench, &report, figure(two));
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
    assert_eq!(
        bench
            .scenes()
            .iter()
            .map(|scene| (**scene).clone())
            .collect::<Vec<_>>(),
        [(entry.scene)()]
    );
    assert!(bench.state().plots.overlay, "with theory over it");
    bench.click("Undo");
    assert_eq!(*bench.state().scene, super::bench::fig2());
}

#[test]
fn theory_is_laid_over_the_live_plot_in_its_units_and_follows_the_scene() {
    let mut bench = opened();
    let report = asked(&bench, Page::Figure(first()));
    done(&mut bench, &report, figure(first()));
    bench.click("Overlay theory");
    let report = asked(&bench, Page::Theory);
    assert!(bench.state().overlay().is_empty());
    done(
        &mut bench,
        &report,
        PageContent::Theory(Arc::new(ZeroRange::compute(&Cancel::default()).unwrap())),
    );
    let lines = bench.state().overlay();
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
        bench.state().overlay().len(),
        2,
        "a line cell knows no dimple"
    );
    bench.click("Overlay theory");
    assert!(bench.state().overlay().is_empty());
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
    done(
        &mut bench,
        &report,
        PageContent::Errata(Arc::new(vec![erratum])),
    );
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
    done(&mut bench, &report, figure(first()));
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
    done(&mut bench, &report, PageContent::Figure(Arc::new(figure)));
    bench.says("Fig. 10 diagram a:");
}
