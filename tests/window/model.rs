//! The model in use: in words with its error, overruled by hand, changed on the way.

use super::bench::Bench;
use egui_kittest::kittest::Queryable;
use tackscope::follow::record::Direction;
use tackscope::physics::body::{Body, Layer};
use tackscope::scene::part::{Part, Strategy};
use tackscope::worker::protocol::{Command, Event};

#[test]
fn the_status_bar_says_the_model_in_use_and_the_error_it_is_expected_to_have() {
    let mut bench = Bench::new();
    assert!(
        bench.status().contains("mesh 64 × 64"),
        "before the solver has spoken"
    );
    bench.ready();
    bench.reach(3.9, Direction::Approach);
    assert!(bench.names().contains("exact to 0.005 %"), "the chip");
    let names = bench.status();
    for words in [
        "quarter of 64 × 64, expected error 0.005 %",
        "Plan: flat in closed form, ridge on half a line",
    ] {
        assert!(names.contains(words), "{words} in {names}");
    }
}

#[test]
fn the_plan_is_overruled_by_hand_which_begins_a_new_run() {
    let mut bench = Bench::new();
    bench.heard();
    bench.click("Advanced");
    for (label, asked) in [
        ("Model: whole cell", Some(Strategy::WHOLE)),
        ("Model: quarter", Some(Strategy::QUARTER)),
        ("Model: plan", None),
    ] {
        bench.window.get_by_label(label).scroll_to_me();
        bench.settle();
        bench.click(label);
        let heard = bench.heard();
        assert!(
            matches!(&heard[..], [Command::SetScene { asked: heard, .. }] if *heard == asked),
            "{heard:?}"
        );
    }
}

#[test]
fn a_model_changed_on_the_way_is_a_notice_and_no_failure() {
    let mut bench = Bench::new();
    bench.ready();
    let mut choice = bench.state().run.ready.as_ref().unwrap().choice.clone();
    choice.part = Part::Whole;
    choice.because = Some("a mode that is not mirror-symmetric goes soft here".to_owned());
    bench.say(Event::Remodelled(choice));
    assert_eq!(bench.state().messages.failure, None);
    let names = bench.names();
    assert!(
        names.contains("now on the whole cell: a mode that is not mirror-symmetric goes soft here"),
        "{names}"
    );
    assert!(
        bench
            .status()
            .contains("whole cell 64 × 64, expected error")
    );
}

#[test]
fn the_body_becomes_a_layer_by_its_list_and_its_numbers_are_edited_like_those_of_a_law() {
    let mut bench = Bench::new();
    bench.click("Advanced");
    assert!(!bench.names().contains("Poisson"));
    fn list(bench: &Bench) -> egui_kittest::Node<'_> {
        bench
            .window
            .get_by_role_and_label(egui::Role::ComboBox, "Body")
    }
    list(&bench).scroll_to_me();
    bench.settle();
    list(&bench).click();
    bench.settle();
    bench.click("layer");
    let thickness = bench.state().model.grid.length / 8.0;
    let layer = |poisson| Body::Layer(Layer { thickness, poisson });
    assert_eq!(bench.state().scene.body, layer(0.5));
    bench.enter("Poisson's ratio ν", "0.3");
    assert_eq!(bench.state().scene.body, layer(0.3));
    let scene = bench.scenes().pop().expect("a new run");
    assert_eq!(scene.body, layer(0.3));
    // The plate is driven, and pulls at the surface through the layer.
    assert!(bench.names().contains("stage w"), "{}", bench.names());
}
