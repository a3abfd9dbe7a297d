//! How long the window takes for a frame while something is dragged: layout and shapes, as without a
//! screen. Measured on demand, never judged:
//! `cargo test --test window frames -- --ignored --nocapture`.

use super::bench::fig2;
use super::stepped::opened;
use egui::{Key, Pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use std::time::Instant;
use tackscope::ui::App;

/// Drags from the middle of what has this label, back and forth; milliseconds of each frame, in
/// order.
fn drag(window: &mut Harness<'static, App>, label: &str, by: egui::Vec2) -> Vec<f64> {
    let from = window.get_by_label_contains(label).rect().center();
    let at = |share: f32| -> Pos2 { from + share * by };
    window.hover_at(from);
    window.step();
    window.drag_at(from);
    window.step();
    let mut times: Vec<f64> = (0..200)
        .map(|i| {
            window.hover_at(at((i as f32 / 20.0).sin()));
            let begin = Instant::now();
            window.step();
            1e3 * begin.elapsed().as_secs_f64()
        })
        .collect();
    window.drop_at(from);
    window.step();
    times.sort_by(f64::total_cmp);
    times
}

#[test]
#[ignore = "a measurement"]
fn frames_while_dragged() {
    let mut window = opened(fig2());
    // Something to draw, and to scrub.
    window.get_by_label("Play loop").click();
    window.step();
    while window.state().state().run.is_busy() {
        window.step();
    }
    window.get_by_label("Advanced").click();
    window.run_steps(3);
    for (label, by) in [
        ("Patterns walked:", vec2(150.0, 0.0)),
        ("mean displacement u0", vec2(0.0, 120.0)),
        ("mesh number mu_rho", vec2(25.0, 0.0)),
    ] {
        window.get_by_label_contains(label).scroll_to_me();
        window.run_steps(3);
        let times = drag(&mut window, label, by);
        let (median, worst) = (times[times.len() / 2], times[times.len() - 1]);
        println!(
            "{label}: median {median:.1} ms, worst {worst:.1} ms of {} frames",
            times.len()
        );
        window.key_press(Key::Escape);
        window.step();
    }
}
