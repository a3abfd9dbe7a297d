//! Jumps that belong to the mesh.

use super::common::looped;
use std::process::{Command, Stdio};
use tackscope::follow::run::Outcome;
use tackscope::scene::{Points, Range, Scene};
use tackscope::solver::methods::MethodKind;
use tackscope::storage::{presets, scene_file};

/// A line of 16 points with the range that `mu_rho` gives.
fn line(mu_rho: f64) -> Scene {
    let mut scene =
        scene_file::parse(presets::find("ridge-line").unwrap().text, "ridge-line").unwrap();
    scene.cell.points = Points::Line(16);
    scene.law.range = Range::MuRho(mu_rho);
    let range = scene.model().unwrap().law.range;
    scene.drive.start = 4.0 * range + 3.0;
    scene.drive.step = 0.02 * range;
    scene
}

#[test]
fn mesh_trapping_begins_above_one_half_and_the_model_says_so() {
    let mut extra = Vec::new();
    for mu_rho in [0.5, 0.75, 1.0, 1.5] {
        let scene = line(mu_rho);
        let run = looped(&scene, MethodKind::NewtonKrylov);
        assert_eq!(run.outcome, Outcome::Completed);
        // The snap into contact, the closing, and their way back are physics: four jumps.
        extra.push(run.record.jumps.len().saturating_sub(4));
        let warning = scene.model().unwrap().warning();
        assert_eq!(warning.is_some(), mu_rho > 0.5, "{mu_rho}: {warning:?}");
        assert!(warning.is_none_or(|words| words.contains("belong to the mesh")));
    }
    assert_eq!(extra[0], 0, "{extra:?}");
    // A line of 16 points can let go of them one by one on the way down and on the way up.
    assert!(extra[1..].iter().all(|jumps| *jumps >= 10), "{extra:?}");
}

#[test]
fn a_run_on_too_coarse_a_mesh_says_so() {
    let home = tempfile::tempdir().unwrap();
    let path = home.path().join("coarse.toml");
    std::fs::write(&path, scene_file::to_text(&line(1.0))).unwrap();
    let run = |points: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_tackscope"));
        command
            .arg("run")
            .arg(&path)
            .args(["--points", points, "--out"])
            .arg(home.path().join("out"))
            .stdin(Stdio::null());
        let output = command.output().unwrap();
        assert_eq!(output.status.code(), Some(0));
        let summary: serde_json::Value =
            serde_json::from_slice(&std::fs::read(home.path().join("out/summary.json")).unwrap())
                .unwrap();
        (
            String::from_utf8(output.stderr).unwrap(),
            summary["plan"]["warning"].clone(),
        )
    };
    let (told, written) = run("16");
    assert!(told.contains("jumps may belong to the mesh"), "{told}");
    assert!(
        written
            .as_str()
            .is_some_and(|words| words.contains("mu_rho = 1.000")),
        "{written}"
    );
}
