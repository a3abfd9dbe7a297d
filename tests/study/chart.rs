//! The chart of speed against accuracy: what it measures, how it judges, and what it writes.

use crate::binary::{content, done, errors, folder, is_png, perform, says};
use crate::loops::preset;
use proptest::prelude::*;
use proptest::strategy::Strategy as _;
use std::fs;
use std::path::Path;
use std::process::Output;
use std::sync::OnceLock;
use tackscope::numerics::threads::Cancel;
use tackscope::physics::control::Control;
use tackscope::scene::{Points, Range, Scene, Strategy, Turn};
use tackscope::solver::methods::MethodKind;
use tackscope::storage::export::CHART_COLUMNS;
use tackscope::storage::scene_file;
use tackscope::study::chart::{
    Chart, Effort, Measured, News, Point, Precision, Reference, Verdict, front, measure, points,
    run, saved,
};

/// A square cell of twice the critical length: all four patterns, small jumps.
const TINY: &str = "format = 1\ntitle = \"Tiny\"\n[cell]\nlength = 160.0\npoints = 36\n[law]\nkind = \"morse\"\nsurface_energy = 0.15\n\
                    range = 1.0\n[indenter]\nkind = \"flat\"\n[drive]\nstart = 3.4\nturn = 0.4\nstep = 0.04\n";

fn tiny() -> Scene {
    scene_file::parse(TINY, "tiny").unwrap()
}

fn quick() -> &'static Chart {
    static CHART: OnceLock<Chart> = OnceLock::new();
    CHART.get_or_init(|| run(&tiny(), Effort::Quick, &Cancel::default(), &mut |_| {}).unwrap())
}

fn whole(method: MethodKind, points: usize, step: f64) -> Point {
    Point {
        method,
        model: Strategy::WHOLE,
        line: false,
        points,
        precision: Precision::Double,
        step,
    }
}

fn measured(scene: &Scene, point: Point) -> Measured {
    measure(
        scene,
        &point,
        f64::INFINITY,
        &Cancel::default(),
        &mut |_| {},
    )
    .unwrap()
}

#[test]
fn every_method_is_measured_and_what_is_done_is_near_the_reference() {
    let chart = quick();
    assert!(
        !chart.cancelled && chart.skipped.is_empty(),
        "{:?}",
        chart.skipped
    );
    for method in MethodKind::ALL {
        assert!(
            chart.rows.iter().any(|row| row.point.method == method),
            "{method:?}"
        );
    }
    let reference = chart.reference.as_ref().unwrap();
    assert!(
        !reference.finest.record.jumps.is_empty() && reference.errors.dissipated_energy < 1e-2,
        "{:?}",
        reference.errors
    );
    for row in chart
        .rows
        .iter()
        .filter(|row| row.point.method.build(0).locates())
    {
        assert_eq!(row.verdict, Verdict::Done, "{row:?}");
        assert!(
            row.errors.dissipated_energy < 1e-2
                && row.errors.jumps < 1e-2
                && row.errors.stress < 1e-3,
            "{row:?}"
        );
        assert!(row.transforms > 0 && row.processor_seconds >= 0.0 && row.seconds > 0.0);
    }
}

#[test]
fn the_papers_budget_is_a_row_that_says_that_it_has_not_converged() {
    for row in quick()
        .rows
        .iter()
        .filter(|row| row.point.method == MethodKind::Gfmd)
    {
        let Verdict::Failed { message, .. } = &row.verdict else {
            panic!("{row:?}")
        };
        assert!(message.contains("states above the tolerance"), "{message}");
        assert!(
            !row.pareto_transforms && !row.pareto_time,
            "a failure is on no front"
        );
    }
}

#[test]
fn the_reference_is_finer_than_anything_it_judges() {
    let mut scenes: Vec<Scene> = ["fig2", "fig3", "ridge-line", "coarse-mesh", "no-hysteresis"]
        .map(preset)
        .to_vec();
    scenes.push(tiny());
    for scene in scenes {
        for effort in [Effort::Quick, Effort::Full { seconds: 180.0 }] {
            let (list, [finest, coarser, longer]) = points(&scene, effort).unwrap();
            assert!(
                list.iter()
                    .all(|p| p.points < finest.points && p.step > finest.step),
                "{}",
                scene.title
            );
            assert!(coarser.points < finest.points && coarser.step >= finest.step);
            assert!(longer.points <= finest.points && longer.step > finest.step);
            assert_eq!(
                list.iter().all(|p| p.line),
                matches!(scene.cell.points, Points::Line(_))
            );
        }
    }
}

#[test]
fn the_references_error_bar_holds_against_an_atlas_half_as_fine_again() {
    let reference = quick().reference.as_ref().unwrap();
    let point = *reference.point();
    assert_eq!(point.model, Strategy::Atlas);
    let finer = Point {
        points: point.points * 3 / 2 / 8 * 8,
        ..point
    };
    let finer = measured(&tiny(), finer);
    let off = (reference.dissipated_energy / finer.dissipated_energy() - 1.0).abs();
    let stated = reference.errors.dissipated_energy;
    assert!(off <= stated, "{off:e}, stated {stated:e}");
    for (ours, better) in reference
        .finest
        .record
        .jumps
        .iter()
        .zip(&finer.record.jumps)
    {
        let late = (ours.control - better.control).abs();
        assert!(
            late <= reference.errors.jumps,
            "{late:e} {:?}",
            reference.errors
        );
    }
    assert!(
        stated < 1e-6 && reference.errors.jumps < 1e-6,
        "{:?}",
        reference.errors
    );
}

#[test]
fn what_is_saved_is_against_the_papers_loops_and_no_worse_than_they() {
    let chart = quick();
    let floor = chart.reference.as_ref().unwrap().errors.dissipated_energy;
    let [budget, best] = saved(&chart.rows, floor);
    assert!(
        budget.is_none(),
        "the scene's own step is not in a quick chart"
    );
    let best = best.unwrap();
    let error = |row: &tackscope::study::chart::Judged| row.errors.dissipated_energy;
    assert_eq!(best.paper.point.method, MethodKind::Gfmd);
    assert_eq!(best.ours.verdict, Verdict::Done);
    assert!(error(best.ours) <= error(best.paper).max(floor));
    let beaten = chart.rows.iter().filter(|row| {
        row.verdict == Verdict::Done
            && error(row) <= error(best.paper)
            && row.processor_seconds < best.ours.processor_seconds
    });
    assert_eq!(beaten.count(), 0);
}

#[test]
fn the_full_chart_of_fig_2_has_the_plan_and_the_papers_budget_in_it() {
    let scene = preset("fig2");
    let (list, _) = points(&scene, Effort::Full { seconds: 180.0 }).unwrap();
    for method in [MethodKind::default(), MethodKind::Gfmd] {
        assert!(
            list.contains(&whole(method, 64, scene.drive.step)),
            "{method:?}"
        );
    }
}

#[test]
fn a_range_given_by_the_mesh_stays_what_it_is_on_the_scenes_own_mesh() {
    let mut scene = tiny();
    scene.law.range = Range::MuRho(0.45);
    let range = scene.model().unwrap().law.range;
    let chart = run(&scene, Effort::Quick, &Cancel::default(), &mut |_| {}).unwrap();
    assert_eq!(chart.reference.unwrap().finest.law.range, range);
}

#[test]
fn steps_that_skip_a_pattern_are_named() {
    let mut scene = preset("fig2");
    scene.drive.step = 0.04;
    let fine = measured(&scene, whole(MethodKind::NewtonKrylov, 48, 0.04));
    let reference = Reference::new([fine.clone(), fine.clone(), fine]);
    let coarse = measured(&scene, whole(MethodKind::GfmdTuned, 48, 0.23));
    let row = reference.judge(&coarse);
    let Verdict::Failed { message, .. } = &row.verdict else {
        panic!("{row:?}")
    };
    assert!(message.contains("bulge skipped on retraction"), "{message}");
}

#[test]
fn a_loop_compared_with_itself_has_no_error() {
    let loop_ = measured(&tiny(), whole(MethodKind::NewtonKrylov, 36, 0.04));
    let reference = Reference::new([loop_.clone(), loop_.clone(), loop_.clone()]);
    let row = reference.judge(&loop_);
    assert_eq!(
        (
            row.errors.dissipated_energy,
            row.errors.jumps,
            row.errors.stress
        ),
        (0.0, 0.0, 0.0)
    );
    assert!((reference.integral - loop_.integral()).abs() < 1e-12);
}

/// On one mesh every other state is at the same stage: nothing is interpolated.
#[test]
fn under_a_spring_loops_are_compared_where_the_stage_is_the_same() {
    let mut scene = tiny();
    scene.drive.control = Control::Spring { stiffness: 0.05 };
    (scene.drive.start, scene.drive.turn) = (5.0, Turn::At(-1.0));
    let [fine, long] =
        [0.1, 0.2].map(|step| measured(&scene, whole(MethodKind::NewtonKrylov, 32, step)));
    let jumps = &fine.record.jumps;
    assert!(jumps.len() > 2 && jumps.iter().all(|j| j.control != j.mean_displacement));
    let errors = Reference::new([fine.clone(), fine, long]).errors;
    assert!(errors.stress < 1e-6 && errors.jumps < 2e-5, "{errors:?}");
}

#[test]
fn a_cancelled_chart_keeps_what_was_measured() {
    let (cancel, mut seen) = (Cancel::default(), 0);
    let token = cancel.clone();
    let chart = run(&tiny(), Effort::Quick, &cancel, &mut |news| {
        if let News::Measured(_) = news {
            seen += 1;
            token.request();
        }
    })
    .unwrap();
    assert!(chart.cancelled && chart.rows.len() == 1 && seen == 1 && chart.reference.is_some());
    let at_once = run(&tiny(), Effort::Quick, &cancel, &mut |_| {}).unwrap();
    assert!(at_once.cancelled && at_once.rows.is_empty() && at_once.reference.is_none());
}

#[test]
fn without_time_every_point_is_skipped_and_said_to_be() {
    let mut told = 0;
    let chart = run(
        &tiny(),
        Effort::Full { seconds: 1e-9 },
        &Cancel::default(),
        &mut |news| {
            told += usize::from(matches!(news, News::Skipped(_)));
        },
    )
    .unwrap();
    assert!(chart.rows.is_empty() && !chart.cancelled);
    assert_eq!(told, chart.skipped.len());
    assert!(
        told > 20
            && chart
                .skipped
                .iter()
                .all(|s| s.predicted_seconds > s.allowed_seconds)
    );
    assert!(
        !chart.reference.unwrap().finest.is_complete(),
        "not even the reference had time"
    );
}

proptest! {
    /// Against the sweep: in order of cost, a point is on the front if its error is the least so
    /// far.
    #[test]
    fn the_front_is_what_a_sweep_over_rising_cost_finds(
        points in prop::collection::vec((0_u8..12, prop_oneof![8 => (0_u8..12).prop_map(f64::from), 1 => Just(f64::NAN)]), 0..30)
    ) {
        let points: Vec<(f64, f64)> = points.into_iter().map(|(cost, error)| (f64::from(cost), error)).collect();
        let mut order: Vec<usize> = (0..points.len()).filter(|&i| points[i].1.is_finite()).collect();
        order.sort_by(|&i, &j| points[i].0.total_cmp(&points[j].0).then(points[i].1.total_cmp(&points[j].1)));
        let mut expected = vec![false; points.len()];
        let mut best: Option<(f64, f64)> = None;
        for i in order {
            if best.is_none_or(|b| points[i].1 < b.1 || points[i] == b) {
                expected[i] = true;
                best = Some(points[i]);
            }
        }
        prop_assert_eq!(front(&points), expected);
    }
}

fn chart_command(scene: &str, out: &Path, more: &[&str]) -> Output {
    perform(&[&["chart", scene], more].concat(), out)
}

/// The cells of a line of CSV whose quotes are not doubled.
fn cells(line: &str) -> Vec<String> {
    let pieces = line.split('"').enumerate();
    let masked: String = pieces
        .map(|(i, piece)| {
            if i % 2 == 1 {
                piece.replace(',', "\u{1}")
            } else {
                piece.to_owned()
            }
        })
        .collect();
    masked
        .split(',')
        .map(|cell| cell.replace('\u{1}', ","))
        .collect()
}

#[test]
fn the_command_writes_a_table_whose_every_row_parses() {
    let home = folder();
    let (scene, out) = (home.path().join("tiny.toml"), home.path().join("out"));
    fs::write(&scene, TINY).expect("written");
    let output = chart_command(&scene.display().to_string(), &out, &["--quick"]);
    done(&output);
    says(
        &errors(&output),
        &["FAILED: ", "states above the tolerance"],
    );
    let table = content(out.join("chart.csv"));
    let mut lines = table.lines();
    assert_eq!(lines.next(), Some(CHART_COLUMNS));
    let columns: Vec<&str> = CHART_COLUMNS.split(',').collect();
    let rows: Vec<Vec<String>> = lines.map(cells).collect();
    let methods = MethodKind::ALL.map(MethodKind::word);
    for (i, row) in rows.iter().enumerate() {
        assert_eq!(row.len(), columns.len(), "{row:?}");
        let of = |column: &str| &row[columns.iter().position(|c| *c == column).expect("a column")];
        assert_eq!(of("method") == "reference", i + 1 == rows.len(), "{row:?}");
        assert!(
            i + 1 == rows.len() || methods.contains(&of("method").as_str()),
            "{row:?}"
        );
        for number in &columns[5..13] {
            assert!(of(number).parse::<f64>().is_ok(), "{number} in {row:?}");
        }
        assert!(["none", "transforms", "time", "both"].contains(&of("pareto").as_str()));
        assert!(of("plan").parse::<bool>().is_ok() && of("paper_budget").parse::<bool>().is_ok());
        assert!(
            !of("outcome").is_empty() && (of("outcome") == "done" || !of("message").is_empty()),
            "{row:?}"
        );
    }
    assert!(
        rows.iter().any(|row| row[0] == "gfmd" && row[16] != "done"),
        "the failure is in the table"
    );
    let short: serde_json::Value =
        serde_json::from_str(&content(out.join("chart.json"))).expect("JSON");
    assert_eq!(
        short["counts"]["points"].as_u64(),
        Some(rows.len() as u64 - 1)
    );
    assert!(short["counts"]["failed"].as_u64() > Some(0));
    assert!(
        short["pareto_transforms"]
            .as_array()
            .is_some_and(|front| !front.is_empty()),
        "{}",
        short["pareto_transforms"]
    );
    let picture = content(out.join("chart.svg"));
    assert!(
        rows.iter()
            .filter(|row| row[16] != "done")
            .all(|row| picture.contains(&row[16])),
        "and in the picture"
    );
    assert!(is_png(&out.join("chart.png")));
}

#[test]
fn a_wrong_scene_or_option_of_the_chart_is_refused() {
    let home = folder();
    for (scene, more) in [
        ("fig22", ["--quick"].as_slice()),
        ("fig2", &["--seconds", "many"]),
        ("fig2", &["--quick", "--seconds", "3"]),
    ] {
        let out = home.path().join("out");
        let output = chart_command(scene, &out, more);
        assert_eq!(output.status.code(), Some(2), "{scene} {more:?}");
        assert!(!out.exists());
    }
}
