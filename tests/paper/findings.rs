//! The gallery: every figure computes, agrees with its theory, and can be stopped.

use std::time::Instant;
use tackscope::numerics::cancel::Cancel;
use tackscope::paper::{Entry, GALLERY, Size, Stopped, TABLES, Task, scenes};
use tackscope::plot::panel::{Content, Panel};
use tackscope::storage::presets;

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

fn check(entry: &Entry) {
    let began = Instant::now();
    let cancel = Cancel::default();
    let mut last = 0.0;
    let mut observe = |share: f64, _: &str| {
        assert!(
            (last..=1.0).contains(&share),
            "figure {}: progress went from {last} to {share}",
            entry.number
        );
        last = share;
    };
    let figure = (entry.compute)(&mut Task::new(Size::Quick, &cancel, &mut observe)).unwrap();
    println!(
        "figure {}: {:.2} s",
        entry.number,
        began.elapsed().as_secs_f64()
    );
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
    GALLERY.iter().for_each(check);
}

#[test]
fn the_gallery_is_in_the_papers_order_and_its_scenes_are_allowed() {
    assert!(
        GALLERY
            .windows(2)
            .all(|pair| pair[0].number < pair[1].number)
    );
    for entry in GALLERY {
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
    for entry in GALLERY {
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
        let mut preset = presets::resolve(name).unwrap();
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
