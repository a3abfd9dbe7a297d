//! The real binary, as a user or a script meets it: files, sentences and exit codes.

use crate::binary::{
    answer, content, done, errors, fig2_with, folder, is_png, perform, refuses, run, said, says,
    summary, tackscope, with, without_display,
};
use std::fs;
use tackscope::storage;

/// Runs, expects exit code 2 and one sentence with all these parts, and no results.
#[track_caller]
fn refused(scene: &str, more: &[&str], parts: &[&str]) {
    let out = folder();
    refuses(&run(scene, &out.path().join("out"), more), parts);
    assert!(
        !out.path().join("out").exists(),
        "nothing is written for a refused scene"
    );
}

#[test]
fn a_missing_file_is_named_with_the_presets() {
    refused(
        "nowhere/mine.toml",
        &[],
        &[
            "nowhere/mine.toml",
            "no such preset or scene file",
            "fig2, fig3, no-hysteresis",
        ],
    );
    refused("fig22", &[], &["fig22", "did you mean fig2"]);
}

#[test]
fn a_scene_file_is_refused_with_its_name() {
    let (file, _kept) = fig2_with(&[("length = 256.0", "length = = 256.0")]);
    refused(&file, &[], &[&file, "line 9", "column 10", "not TOML"]);
}

#[test]
fn a_value_of_an_option_is_refused_as_that_of_the_scene_would_be() {
    let above_zero = ["--step NaN", "drive.step = NaN", "a finite number above 0"];
    refused("fig2", &["--step", "nan"], &above_zero);
    let parts = [
        "fig2 with --points",
        "cell.points = 63",
        "an even number from 4 to 4096",
    ];
    refused("fig2", &["--points", "63"], &parts);
}

#[test]
fn a_negative_step_is_refused_by_the_scene_and_a_bad_option_by_the_command_line() {
    refused(
        "fig2",
        &["--step", "-0.1"],
        &["drive.step = -0.1", "above 0"],
    );
    for bad in [
        ["--seed", "-1"],
        ["--method", "magic"],
        ["--points", "many"],
    ] {
        assert_eq!(
            run("fig2", folder().path(), &bad).status.code(),
            Some(2),
            "{bad:?}"
        );
    }
    assert_eq!(
        tackscope().arg("run").output().expect("runs").status.code(),
        Some(2)
    );
    refused(
        "fig2",
        &["--yardstick", "--method", "gfmd"],
        &["--yardstick", "leave one of the two out"],
    );
}

#[test]
fn a_folder_that_cannot_be_written_is_refused_before_anything_is_computed() {
    let home = folder();
    let file = home.path().join("file");
    fs::write(&file, "in the way").expect("written");
    for out in [file.clone(), file.join("below")] {
        let parts = [&*out.display().to_string(), "cannot be written"];
        refuses(&run("fig2", &out, &[]), &parts);
    }
    assert_eq!(content(&file), "in the way");
}

#[test]
fn a_run_writes_every_file_and_one_closing_line() {
    let home = folder();
    let out = home.path().join("a").join("b");
    let output = run("no-hysteresis", &out, &[]);
    let line = done(&output);
    assert!(
        line.contains("dissipated energy 0.0000 gamma") && line.lines().count() == 1,
        "{line}"
    );
    let loop_csv = content(out.join("loop.csv"));
    assert!(loop_csv.starts_with(
        "branch,mean_displacement,stress,stress_over_max,contact_area,pattern,residual,stiffness_min,energy,model,milliseconds,control\n"
    ));
    assert!(loop_csv.lines().count() > 400);
    let events = content(out.join("events.csv"));
    assert_eq!(
        events,
        "branch,mean_displacement,from,to,released_energy,cause,control,mean_displacement_after\n"
    );
    let summary = summary(&out);
    assert_eq!(summary["completed"], true);
    assert_eq!(summary["stop"], "completed");
    assert!(
        summary["dissipated_energy"]
            .as_f64()
            .expect("a number")
            .abs()
            < 1e-6
    );
    assert_eq!(summary["ledger_mismatch"], "not available");
    assert_eq!(summary["counts"]["jumps"], 0);
    let scene = summary["scene"]["toml"].as_str().expect("the scene");
    assert_eq!(
        tackscope::storage::scene_file::parse(scene, "summary"),
        storage::preset("no-hysteresis").expect("built in").scene()
    );
    assert!(content(out.join("loop.svg")).contains("no jumps"));
    assert!(is_png(&out.join("loop.png")));
    let hidden = fs::read_dir(&out)
        .expect("listed")
        .flatten()
        .filter(|e| e.file_name().to_string_lossy().starts_with('.'));
    assert_eq!(hidden.count(), 0, "no temporary file is left");
}

#[test]
fn a_diagram_writes_its_files_and_one_closing_line() {
    let home = folder();
    let out = home.path().join("branches");
    let output = perform(&["diagram", "ridge-line"], &out);
    let line = done(&output);
    assert!(line.starts_with("2 branches, 2 folds,"), "{line}");
    let table = |name: &str| content(out.join(name));
    let branches = table("branches.csv");
    let first = "branch,point,mean_displacement,stress,energy,index,pattern,kind,residual,control";
    assert_eq!(branches.lines().next(), Some(first));
    let named = |name: &str| branches.lines().filter(|row| row.starts_with(name)).count();
    assert!(named("flat,") > 100 && named("ridge,") > 20);
    let points = table("points.csv");
    let first = "kind,branch,mean_displacement,stress,energy,index_before,index_after,control";
    assert_eq!(points.lines().next(), Some(first));
    let kinds = [
        "fold,ridge,",
        "bifurcation,flat,",
        "equal_energy,flat/ridge,",
    ];
    for (kind, count) in kinds.into_iter().zip([2, 6, 2]) {
        let found = points.lines().filter(|row| row.starts_with(kind)).count();
        assert_eq!(found, count, "{kind}");
    }
    assert!(table("diagram.svg").contains("bifurcation"));
    assert!(is_png(&out.join("diagram.png")));
}

#[test]
fn a_diagram_that_is_not_complete_says_what_is_missing() {
    // So low that the first state of the drive is not at rest on this ground.
    let (file, home) = with("wavy", &[("start = 1.5", "start = 0.79")]);
    let out = home.path().join("out");
    let output = perform(&["diagram", &file], &out);
    let words = errors(&output);
    assert_eq!(output.status.code(), Some(3), "{words}");
    assert!(words.contains("missing: the first state"), "{words}");
    assert!(out.join("points.csv").is_file());
}

#[test]
fn an_atlas_is_refused_where_the_scene_has_none() {
    refused(
        "hertz",
        &["--model", "atlas"],
        &["--model = atlas", "uneven ground", "leave --model out"],
    );
    refused(
        "ridge-line",
        &["--model", "atlas"],
        &["--model = atlas", "line cell"],
    );
    refused(
        "fig2",
        &["--points", "6", "--model", "atlas"],
        &["--model = atlas", "6 points"],
    );
}

#[test]
fn the_loss_comes_with_its_check_and_a_check_that_fails_is_told_everywhere() {
    let home = folder();
    let told = run("fig2", home.path(), &[]);
    says(
        &said(&told),
        &[
            "dissipated energy 0.1175 gamma, expected error 0.0",
            "8 jumps",
        ],
    );
    let good = summary(home.path());
    assert_eq!(good["warnings"], serde_json::json!([]));
    assert_eq!(
        (
            &good["closed"],
            &good["counts"]["jumps"],
            &good["counts"]["transitions"]
        ),
        (&true.into(), &8.into(), &0.into())
    );
    let number = |summary: &serde_json::Value, key: &str| summary[key].as_f64().unwrap_or(f64::NAN);
    assert_eq!(
        number(&good, "dissipated_energy"),
        number(&good, "released_energy_sum")
    );
    assert!(
        (number(&good, "loop_integral") / number(&good, "dissipated_energy") - 1.0).abs() < 1e-4
    );
    assert!(number(&good, "released_energy_error") > 0.0 && number(&good, "stated_error") < 1e-3);
    let told = run("fig2", home.path(), &["--step", "5"]);
    says(&errors(&told), &["the loop integral"]);
    let rough = summary(home.path());
    assert!(
        (number(&rough, "dissipated_energy") - number(&good, "dissipated_energy")).abs() < 1e-6
    );
    says(
        rough["warnings"][0].as_str().expect("a warning"),
        &["a smaller drive.step"],
    );
}

#[test]
fn an_open_loop_says_so_and_gives_no_loss_and_an_unstable_start_is_not_driven() {
    let home = folder();
    let ends = [("start = 4.2", "start = 3.5"), ("turn = 0.2", "turn = 1.8")];
    let (scene, _kept) = fig2_with(&ends);
    let open = run(&scene, home.path(), &[]);
    assert!(done(&open).starts_with("loop not closed"));
    says(&errors(&open), &["loop not closed: ", "raise drive.start"]);
    let told = summary(home.path());
    assert_eq!(
        (&told["completed"], &told["closed"]),
        (&true.into(), &false.into())
    );
    assert!(told["open_reason"].is_string() && told["open_remedy"].is_string());
    for key in [
        "dissipated_energy",
        "loop_integral",
        "ledger_mismatch",
        "stated_error",
    ] {
        assert_eq!(told[key], "not available", "{key}");
    }
    assert!(content(home.path().join("loop.svg")).contains("Loop not closed"));
    let open = run(&scene, home.path(), &["--verify"]);
    says(&errors(&open), &["nothing to verify"]);
    assert_eq!(summary(home.path())["measured_error"], "not available");
    let (scene, _kept) = fig2_with(&[("start = 4.2", "start = 2.5")]);
    let unstable = run(&scene, home.path(), &[]);
    assert_eq!(unstable.status.code(), Some(3));
    says(&errors(&unstable), &["the first state is unstable"]);
    assert_eq!(summary(home.path())["dissipated_energy"], "not available");
}

#[test]
fn gap_pictures_of_an_earlier_run_go_and_other_files_stay() {
    let home = folder();
    let gaps = home.path().join("gaps");
    fs::create_dir_all(&gaps).expect("made");
    for name in ["7-approach-bulge.png", "notes.txt"] {
        fs::write(gaps.join(name), "old").expect("written");
    }
    assert_eq!(
        run("no-hysteresis", home.path(), &["--quiet"])
            .status
            .code(),
        Some(0)
    );
    assert!(!gaps.join("7-approach-bulge.png").exists() && gaps.join("notes.txt").exists());
}

#[test]
fn progress_is_plain_lines_where_there_is_no_terminal_and_quiet_is_silent() {
    let home = folder();
    let told = errors(&run("no-hysteresis", home.path(), &[]));
    says(&told, &[" 10 %  approach at u0 = 3.4", "100 %"]);
    assert!(
        told.lines().count() <= 12 && !told.contains('\u{1b}'),
        "{told}"
    );
    let quiet = run("no-hysteresis", home.path(), &["--quiet"]);
    assert!(quiet.stdout.is_empty() && quiet.stderr.is_empty());
}

#[test]
fn options_replace_values_of_the_scene_and_the_summary_keeps_them() {
    let home = folder();
    let output = run(
        "no-hysteresis",
        home.path(),
        &[
            "--quiet",
            "--points",
            "16",
            "--step",
            "0.1",
            "--seed",
            "7",
            "--yardstick",
        ],
    );
    done(&output);
    let summary = summary(home.path());
    assert_eq!(summary["plan"]["points"], serde_json::json!([16, 16]));
    let scene = summary["scene"]["toml"].as_str().expect("the scene");
    says(scene, &["points = 16\n", "step = 0.1\n", "seed = 7\n"]);
    assert_eq!(summary["method"], "newton");
    assert_eq!(summary["yardstick"]["method"], "gfmd");
    assert!(
        summary["yardstick"]["processor_time_ratio"]
            .as_f64()
            .is_some_and(|ratio| ratio > 0.0)
    );
    assert_eq!(
        run(
            "ridge-line",
            home.path(),
            &["--quiet", "--points", "32", "--step", "0.2"]
        )
        .status
        .code(),
        Some(0)
    );
    assert_eq!(
        self::summary(home.path())["plan"]["points"],
        serde_json::json!([32, 1]),
        "a line stays a line"
    );
}

#[test]
fn a_file_of_ones_own_runs_like_a_preset() {
    let (file, home) = with("no-hysteresis", &[]);
    let out = home.path().join("out");
    done(&run(&file, &out, &["--quiet"]));
    assert_eq!(summary(&out)["scene"]["given"], file);
}

#[test]
fn presets_are_listed_with_title_and_facts() {
    says(
        &answer(&["presets"]),
        &[
            "fig2 ",
            "Fig. 2: four patterns",
            "64 x 64 points",
            "mu_rho = 0.387",
            "ridge-line",
            "256 x 1 points",
            "What to look for",
        ],
    );
}

#[test]
fn the_help_names_the_commands_that_exist_and_no_others() {
    says(
        &answer(&["--help"]),
        &[
            "run", "diagram", "chart", "figure", "table", "presets", "130",
        ],
    );
}

#[test]
fn without_a_display_it_says_so_in_one_line_and_runs_the_default_scene() {
    let home = folder();
    let output = without_display(home.path()).output().expect("runs");
    done(&output);
    let told = errors(&output);
    let first = told.lines().next().unwrap_or_default();
    says(first, &["no window here", "tackscope-out/"]);
    assert_eq!(
        summary(&home.path().join("tackscope-out"))["scene"]["given"],
        "fig2"
    );
}

#[test]
fn a_target_that_is_not_met_is_said_with_the_mesh_that_comes_closer() {
    let home = folder();
    let lines = [
        ("points = 64", "points = 40"),
        ("target = 0.01", "target = 1e-5"),
        ("step = 0.02", "step = 0.2"),
    ];
    let (scene, _kept) = fig2_with(&lines);
    let told = errors(&run(&scene, home.path(), &[]));
    says(
        &told,
        &[
            "accuracy.target = 0.00001 is not met (expected error 0.",
            "cell.points = 64",
        ],
    );
    let summary = summary(home.path());
    assert!(
        summary["predicted_error"]
            .as_f64()
            .is_some_and(|error| error > 1e-5 && error < 1e-2)
    );
    assert!(
        summary["warnings"][0]
            .as_str()
            .is_some_and(|warning| told.contains(warning))
    );
}
