//! The tabs of speed against accuracy and of a study: marks as they are computed, and the scene of a
//! mark.

use super::bench::Bench;
use super::hand::Hand;
use egui::pos2;
use egui_kittest::kittest::{NodeT, Queryable};
use tackscope::scene::part::Strategy;
use tackscope::scene::{Points, Range};
use tackscope::solver::methods::MethodKind;
use tackscope::study::chart::{Effort, Errors, Judged, Point, Precision, Verdict};
use tackscope::worker::background::ChartSoFar;
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
    report.result(chart());
    report.end(Ok(()));
    bench.settle();
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
        (bench.state().method, bench.state().scene.cell.points),
        (MethodKind::Fire, Points::Square(48))
    );
    assert_eq!(bench.state().scene.drive.step, 0.08);
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
        bench.state().messages.failure.is_none(),
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
    let failure = bench.state().messages.failure.as_ref().expect("said");
    assert!(failure.message.contains("no reference"), "{failure:?}");

    bench.click("transforms");
    let transforms = |bench: &Bench| {
        let radio = bench.get_by_label("transforms");
        radio.accesskit_node().toggled() == Some(egui::accesskit::Toggled::True)
    };
    assert!(transforms(&bench));
    bench.press(egui::Modifiers::COMMAND, egui::Key::K);
    bench.click("Restore layout");
    assert_eq!(bench.state().view.tab, 0, "the first tab is the chosen one");
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
