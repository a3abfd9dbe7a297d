//! The axes of the plot by the mouse.

use super::bench::Bench;
use egui::{
    Event, Modifiers, MouseWheelSource, MouseWheelUnit, PointerButton, Pos2, Rect, TouchPhase,
    Vec2, vec2,
};
use egui_kittest::kittest::Queryable;
use tackscope::follow::record::Direction;

/// A window with a curve, and the place of its plot.
fn walked() -> (Bench, Rect) {
    let mut bench = Bench::new();
    for i in 0..8 {
        bench.reach(4.0 - 0.1 * f64::from(i), Direction::Approach);
    }
    let plot = bench
        .window
        .get_by_label_contains("Stress against u0:")
        .rect();
    (bench, plot)
}

fn wheel(bench: &mut Bench, at: Pos2, turned: f32) {
    bench.window.hover_at(at);
    bench.window.step();
    bench.window.event(Event::MouseWheel {
        unit: MouseWheelUnit::Point,
        delta: vec2(0.0, turned),
        phase: TouchPhase::Move,
        source: MouseWheelSource::Wheel,
        modifiers: Modifiers::NONE,
    });
    bench.settle();
}

/// The value at a place in shares of the axes.
fn at(bench: &Bench, share: [f64; 2]) -> [f64; 2] {
    let (low, high) = bench.state().axes();
    [0, 1].map(|k| low[k] + share[k] * (high[k] - low[k]))
}

fn near(a: [f64; 2], b: [f64; 2], within: f64) -> bool {
    (0..2).all(|k| (a[k] - b[k]).abs() < within)
}

#[test]
fn the_wheel_over_the_plot_zooms_about_the_pointer_and_scene_axes_brings_it_back() {
    let (mut bench, plot) = walked();
    let scene = bench.state().axes();
    let length = |bench: &Bench| {
        let (low, high) = bench.state().axes();
        [high[0] - low[0], high[1] - low[1]]
    };
    let (begun, target) = (length(&bench), bench.state().target);
    // Something stays where it is: the place under the pointer, wherever that is in the frame.
    let pointer = plot.lerp_inside(vec2(0.7, 0.4));
    wheel(&mut bench, pointer, 80.0);
    let (closer, (low, high)) = (length(&bench), bench.state().axes());
    assert!(
        (0..2).all(|k| closer[k] < 0.8 * begun[k]),
        "{closer:?} {begun:?}"
    );
    assert!((0..2).all(|k| low[k] > scene.0[k] && high[k] < scene.1[k]));
    assert!(
        (closer[0] / begun[0] - closer[1] / begun[1]).abs() < 1e-9,
        "both alike"
    );
    // The fixed place is the same from step to step.
    let fixed = |before: ([f64; 2], [f64; 2]), after: ([f64; 2], [f64; 2])| {
        [0, 1].map(|k| {
            let shrunk = (after.1[k] - after.0[k]) / (before.1[k] - before.0[k]);
            (after.0[k] - shrunk * before.0[k]) / (1.0 - shrunk)
        })
    };
    let first = fixed(scene, (low, high));
    wheel(&mut bench, pointer, 80.0);
    let second = fixed((low, high), bench.state().axes());
    assert!(near(first, second, 1e-3), "{first:?} {second:?}");
    wheel(&mut bench, pointer, -400.0);
    assert!(length(&bench)[0] > begun[0]);
    // Never lost in the void.
    for _ in 0..20 {
        wheel(&mut bench, pointer, -800.0);
    }
    assert!(length(&bench)[0] < 5.0 * begun[0]);
    assert_eq!(bench.state().target, target, "the body has not moved");
    bench.click("Scene axes");
    assert_eq!(bench.state().axes(), scene);
}

#[test]
fn a_drag_with_the_second_button_moves_the_axes_and_shows_no_stored_state() {
    let (mut bench, plot) = walked();
    let before = at(&bench, [0.0, 0.0]);
    let from = plot.center();
    bench.window.hover_at(from);
    bench.window.step();
    bench.button(from, PointerButton::Secondary, true);
    let by: Vec2 = vec2(-60.0, 30.0);
    bench.window.hover_at(from + by);
    bench.window.step();
    bench.window.step();
    bench.button(from + by, PointerButton::Secondary, false);
    bench.settle();
    let after = at(&bench, [0.0, 0.0]);
    // What lay at the right comes in, and what lay above.
    assert!(
        after[0] > before[0] && after[1] > before[1],
        "{before:?} {after:?}"
    );
    assert!(bench.state().run.selection.is_none());
}
