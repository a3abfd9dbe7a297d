//! The tab Study: marks as they are computed, and the scene of a mark.

use super::bench::Bench;
use egui_kittest::kittest::Queryable;
use tackscope::scene::Range;

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
    assert!(bench.names().contains(said), "{}", bench.names());
    let picture = bench.window.get_by_label(said).rect();
    // The first mark: the loss falls with the range, so that it is the highest on the left.
    let mut at = picture.left_top();
    'search: for x in 30..160 {
        for y in 0..60 {
            at = picture.left_top() + egui::vec2(x as f32, y as f32);
            bench.window.hover_at(at);
            bench.window.step();
            if bench.window.output().platform_output.cursor_icon == egui::CursorIcon::PointingHand {
                break 'search;
            }
        }
    }
    bench.click_at(at);
    assert_eq!(bench.state().scene.law.range, Range::Length(1.1));
    assert!(bench.names().contains(said), "marks of this scene stay");
    bench.press(egui::Modifiers::COMMAND, egui::Key::Z);
    assert_eq!(bench.state().scene.law.range, Range::Length(1.0));
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
    let names = bench.names();
    assert!(
        names.contains("Study of drive.start: 2 of 2 loops, 1 failed"),
        "{names}"
    );
}

#[test]
fn a_study_of_another_scene_is_not_shown() {
    let mut bench = bench();
    bench.click("Compute");
    bench.run_jobs();
    assert!(bench.names().contains("Study of law.range"));
    bench.press(egui::Modifiers::NONE, egui::Key::Num2);
    assert!(
        !bench.names().contains("Study of law.range"),
        "{}",
        bench.names()
    );
}
