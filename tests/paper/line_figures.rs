//! Figs 4, 7, 8 and 11 of the paper at quick size: every judged number agrees, and differences
//! shrink with the range.

use tackscope::numerics::cancel::Cancel;
use tackscope::paper::figure::Figure;
use tackscope::paper::{GALLERY, Size, Stopped, Task};
use tackscope::plot::panel::Role;

fn figure(number: usize) -> Figure {
    let entry = GALLERY.iter().find(|entry| entry.number == number).unwrap();
    let (cancel, mut last) = (Cancel::default(), 0.0);
    let mut observe = |done: f64, _: &str| {
        assert!(done >= last && done <= 1.0, "{last} {done}");
        last = done;
    };
    (entry.compute)(&mut Task::new(Size::Quick, &cancel, &mut observe)).unwrap()
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
    assert_agrees(&figure, 17);
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
    assert_agrees(&figure, 3);
    let middle = pairs(&figure, "largest |p̃", "exact");
    // Half the range: at least as much as the first order would give.
    assert!(
        middle.len() == 2 && middle[1].0 < 0.5 * middle[0].0,
        "{middle:?}"
    );
    for end in ["ũ₀ where the ridge flattens", "ũ₀ where the ridge closes"] {
        let off: Vec<f64> = pairs(&figure, end, "exact")
            .iter()
            .map(|(found, exact)| (found - exact).abs())
            .collect();
        assert!(off.len() == 2 && off[1] < off[0], "{end}: {off:?}");
    }
}

#[test]
fn sixteen_points_carry_a_ridge_up_to_mu_rho_one_half_and_pin_it_above() {
    let figure = figure(8);
    assert_agrees(&figure, 6);
    let jumps: Vec<f64> = pairs(&figure, "jumps from ridge to ridge", "")
        .iter()
        .map(|p| p.0)
        .collect();
    assert_eq!(jumps[..2], [0.0, 0.0]);
    assert!(jumps[2..].iter().all(|n| *n > 0.0), "{jumps:?}");
    // The two limits that the text quotes ask for the same mu_rho, and that is not 0.5.
    let asked = pairs(&figure, "μ_ρ at which", "");
    assert!(
        (asked[0].0 - asked[1].0).abs() < 0.02 && asked[0].0 > 0.6,
        "{asked:?}"
    );
}

#[test]
fn the_loss_tends_to_that_of_the_exact_ridge_as_the_range_shrinks_and_never_reaches_the_printed_one()
 {
    let figure = figure(11);
    assert_agrees(&figure, 15);
    let cosine = pairs(&figure, "γ_hys/γ, cosine", "exact ridge");
    let off: Vec<f64> = cosine
        .iter()
        .map(|(found, theory)| (found / theory - 1.0).abs())
        .collect();
    assert!(
        off.len() >= 3 && off.windows(2).all(|w| w[0] < w[1]),
        "shorter ranges come first: {off:?}"
    );
    let zero = pairs(&figure, "γ_hys/γ without range", "printed");
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
