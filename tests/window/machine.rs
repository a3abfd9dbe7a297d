//! The machine, and the map of patterns.

use super::bench::{Bench, fig2};
use super::random::signed_zero;
use super::stepped::opened;
use egui::Key;
use egui_kittest::kittest::Queryable;
use tackscope::physics::control::Control;
use tackscope::worker::protocol::Command;

#[test]
fn a_spring_is_chosen_from_its_picture_and_the_slider_then_drives_the_stage() {
    let mut bench = Bench::new();
    bench.heard();
    assert!(bench.names().contains("mean displacement u0"));
    bench.click("machine spring");
    let drive = bench.state().scene.drive;
    let Control::Spring { stiffness } = drive.control else {
        panic!("{drive:?}")
    };
    assert!(stiffness > 0.0);
    assert!(
        matches!(&bench.heard()[..], [Command::SetScene { scene, .. }] if scene.drive == drive)
    );
    assert!(bench.names().contains("stage w"), "{}", bench.names());
    bench.enter("Stiffness of the spring k", "0.005");
    let asked = Control::Spring { stiffness: 0.005 };
    assert_eq!(bench.state().scene.drive.control, asked);
    assert!(bench.names().contains("it snaps as one block"));
    bench.click("machine weight");
    assert_eq!(bench.state().scene.drive.control, Control::Load);
    assert!(bench.names().contains("load F"), "{}", bench.names());
    // Back on the way it came, one edit at a time.
    bench.click("machine stiff");
    assert_eq!(bench.state().scene.drive.control, Control::Displacement);
    assert!(bench.names().contains("mean displacement u0"));
}

#[test]
fn a_click_on_the_map_opens_the_scene_of_that_range_and_the_map_stays() {
    let mut bench = Bench::new();
    bench.click("Map tab");
    bench.run_jobs();
    let map = bench
        .window
        .get_by_label("Map of patterns: approach")
        .rect();
    let before = bench.state().model.law.range;
    bench.click_at(map.lerp_inside(egui::vec2(0.6, 0.7)));
    bench.settle();
    let after = bench.state().model.law.range;
    assert!(after < 0.9 * before && after > 0.5 * before, "{after}");
    // It holds this scene too: nothing is begun anew.
    bench.window.get_by_label("Map of patterns: approach");
    // The loop under the pointer lies in the plot while it is there.
    let preview = |bench: &Bench| bench.state().plots.preview.clone();
    bench.window.hover_at(map.lerp_inside(egui::vec2(0.6, 0.3)));
    bench.settle();
    let shown = preview(&bench).expect("a loop");
    assert!(shown.name.starts_with("ρ = ") && shown.points.len() > 100);
    bench.window.hover_at(egui::pos2(2.0, 2.0));
    bench.settle();
    assert!(preview(&bench).is_none());
    // Of another law it says nothing.
    bench.click("law cosine");
    let maps = bench.window.query_all_by_label("Map of patterns: approach");
    assert_eq!(maps.count(), 0);
}

#[test]
fn under_a_weight_no_zero_has_a_sign_on_the_way_through_a_loop() {
    let mut window = opened(fig2());
    window.get_by_label("machine weight").click();
    window.step();
    window.key_press(Key::Space);
    for _ in 0..40 {
        window.step();
        assert_eq!(signed_zero(&window), None);
    }
    assert!(!window.state().state().run.record.jumps.is_empty());
}
