//! A sweep that is killed, shared among shards or begun twice gives the rows of one that is not,
//! and each row is what `run` says of the same scene.
//!
//! `TACKSCOPE_KILLS` says how often a sweep is killed (6 times if not given).

use crate::binary::{Running, ended, errors, folder, said, says, tackscope};
use rand::{Rng, SeedableRng};
use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use std::thread::sleep;
use std::time::{Duration, Instant};
use tackscope::storage::{scene_file, study_file};
use tackscope::study::sweep::{COLUMNS, Cell};

/// Fourteen loops, one of them refused, one twice, none of which knows the time.
const STUDY: &str = r#"
format = 1
scene = "fig2"
record = ["dissipated_energy", "predicted_error", "jumps", "approach_jumps", "retraction_jumps", "transforms"]

[set]
cell.points = "auto"
drive.step = 0.2

[[axis]]
key = "law.range"
values = [1.2, 1.0, 1.1, 0.9, 1.0, 1.3, -1.0]

[[axis]]
key = "cell.length"
linear = { from = 220.0, to = 256.0, count = 2 }
"#;
const ROWS: usize = 14;

fn write(home: &Path, text: &str) -> String {
    let path = home.join("study.toml");
    fs::write(&path, text).expect("written");
    path.display().to_string()
}

fn command(study: &str, out: &Path, more: &[&str]) -> Command {
    let mut command = tackscope();
    command.args(["sweep", study, "--out"]).arg(out).args(more);
    command
}

fn sweep(study: &str, out: &Path, more: &[&str]) -> Output {
    command(study, out, more).output().expect("the binary runs")
}

fn rows(folder: &Path) -> String {
    fs::read_to_string(folder.join("sweep.csv")).expect("sweep.csv")
}

/// Whole lines below the heading.
fn count(folder: &Path) -> usize {
    let text = fs::read_to_string(folder.join("sweep.csv")).unwrap_or_default();
    text.matches('\n').count().saturating_sub(1)
}

#[test]
fn a_sweep_that_is_killed_again_and_again_is_row_by_row_the_one_that_is_not() {
    let home = folder();
    let study = write(home.path(), STUDY);
    let [whole, killed] = ["whole", "killed"].map(|name| home.path().join(name));
    let began = Instant::now();
    let output = sweep(&study, &whole, &["--quiet"]);
    let takes = began.elapsed();
    ended(&output, 3);
    assert!(errors(&output).contains("2 of 14 loops failed, first row 13: law.range = -1"));
    assert_eq!(count(&whole), ROWS);
    let kills: usize =
        std::env::var("TACKSCOPE_KILLS").map_or(6, |count| count.parse().expect("a number"));
    let mut chance = rand_pcg::Pcg64::seed_from_u64(kills as u64);
    let (mut done, mut before) = (0, 0);
    for _ in 0..kills {
        let mut going = Running::spawn(command(&study, &killed, &["--quiet"]));
        sleep(takes.mul_f64(chance.random_range(0.03..0.22)));
        if going.is_going() {
            going.signal("KILL");
            done += 1;
        }
        going.end();
        let now = count(&killed);
        assert!(now >= before, "{before} rows, then {now}");
        before = now;
    }
    assert!(done > 0, "none was killed");
    println!("killed {done} times, with {before} of {ROWS} rows at last");
    ended(&sweep(&study, &killed, &["--quiet"]), 3);
    assert_eq!(rows(&killed), rows(&whole));
}

#[test]
fn a_request_to_stop_keeps_the_rows_and_the_same_command_goes_on() {
    let home = folder();
    let study = write(home.path(), STUDY);
    let [out, whole] = ["out", "whole"].map(|name| home.path().join(name));
    let going = Running::spawn(command(&study, &out, &[]));
    let began = Instant::now();
    while count(&out) < 4 && began.elapsed() < Duration::from_secs(60) {
        sleep(Duration::from_millis(5));
    }
    going.signal("TERM");
    let (code, told) = going.end();
    let kept = count(&out);
    if code == Some(130) {
        says(&told, &["rows to go; the same command goes on"]);
        assert!((4..ROWS).contains(&kept), "{kept}");
    } else {
        assert_eq!(code, Some(3), "it was faster: {told}");
    }
    ended(&sweep(&study, &out, &["--quiet"]), 3);
    sweep(&study, &whole, &["--quiet"]);
    assert_eq!(rows(&out), rows(&whole));
}

#[test]
fn shards_side_by_side_are_collected_into_the_table_of_one_sweep() {
    let home = folder();
    let study = write(home.path(), STUDY);
    let [whole, shared] = ["whole", "shared"].map(|name| home.path().join(name));
    sweep(&study, &whole, &["--quiet"]);
    let shard =
        |name: &str| Running::spawn(command(&study, &shared, &["--quiet", "--shard", name]));
    let both = [shard("1/3"), shard("3/3")];
    for going in both {
        let (code, told) = going.end();
        assert!(matches!(code, Some(0 | 3)), "{told}");
    }
    let early = sweep(&study, &shared, &["--collect"]);
    let words = ended(&early, 3);
    // Of the scenes in order, without the two that are there twice, every third.
    assert!(words.contains("4 rows are missing: 2, 5, 8, 13"), "{words}");
    assert_eq!(count(&shared), ROWS - 4);
    shard("2/3").end();
    let all = sweep(&study, &shared, &["--collect"]);
    assert_eq!(all.status.code(), Some(3), "two are refused");
    assert!(!errors(&all).contains("missing"));
    assert_eq!(rows(&shared), rows(&whole));
    // Another number of shards finds everything done.
    let again = sweep(&study, &shared, &["--shard", "1/2"]);
    says(&said(&again), &["6 loops, 0 of them now"]);
}

#[test]
fn a_line_that_was_not_finished_is_computed_anew() {
    let home = folder();
    let study = write(home.path(), STUDY);
    let out = home.path().join("out");
    sweep(&study, &out, &["--quiet"]);
    let whole = rows(&out);
    // A quoted comma, a number, a line break: wherever it ends.
    for cut in [1, 20, 200] {
        fs::write(out.join("sweep.csv"), &whole[..whole.len() - cut]).expect("written");
        let output = sweep(&study, &out, &[]);
        assert!(errors(&output).contains("was not finished, and is computed anew"));
        assert_eq!(rows(&out), whole, "cut by {cut}");
    }
    // Nothing but half a heading.
    fs::write(out.join("sweep.csv"), &whole[..10]).expect("written");
    sweep(&study, &out, &["--quiet"]);
    assert_eq!(rows(&out), whole);
}

#[test]
fn the_same_scene_is_computed_once_and_has_a_row_each_time() {
    let home = folder();
    let study = write(home.path(), STUDY);
    let out = home.path().join("out");
    let output = sweep(&study, &out, &[]);
    says(&said(&output), &["14 loops, 12 of them now"]);
    let text = rows(&out);
    let after = |row: usize| {
        text.lines()
            .nth(row)
            .expect("a row")
            .split_once(',')
            .expect("cells")
            .1
    };
    assert_eq!(after(3), after(9));
    assert_ne!(after(3), after(4));
    let again = sweep(&study, &out, &[]);
    says(&said(&again), &["14 loops, 0 of them now"]);
    assert_eq!(rows(&out), text);
}

#[test]
fn rows_of_other_scenes_are_left_out_and_another_study_is_refused() {
    let home = folder();
    let out = home.path().join("out");
    let short = STUDY.replace("[1.2, 1.0, 1.1, 0.9, 1.0, 1.3, -1.0]", "[1.2, 1.3]");
    sweep(&write(home.path(), &short), &out, &["--quiet"]);
    let shorter = short.replace("[1.2, 1.3]", "[1.3, 1.4]");
    let output = sweep(&write(home.path(), &shorter), &out, &[]);
    says(
        &errors(&output),
        &["2 rows of sweep.csv are of other scenes"],
    );
    assert_eq!(count(&out), 4);
    let other = shorter.replace("\"jumps\", ", "");
    let output = sweep(&write(home.path(), &other), &out, &[]);
    ended(&output, 2);
    assert!(errors(&output).contains("a study of other numbers, or with other columns"));
}

/// What `summary.json` has under a name, as it is written: parsers of JSON lose the last bit.
fn written<'a>(summary: &'a str, name: &str) -> &'a str {
    let key = format!("\"{name}\": ");
    let (_, rest) = summary.split_once(&key).expect("in the summary");
    let value = rest.split([',', '\n']).next().expect("a value");
    value.trim_matches('"')
}

/// The same in a row and in the summary.
fn same(row: &Cell, told: &str, what: &str) {
    match row {
        Cell::Number(x) if x.is_nan() => assert_eq!(told, "not available", "{what}"),
        Cell::Number(x) => assert_eq!(told.parse(), Ok(*x), "{what}"),
        Cell::Count(n) => assert_eq!(told.parse(), Ok(*n), "{what}"),
        Cell::Word(word) => assert_eq!(told, word, "{what}"),
        Cell::Numbers(_) => panic!("{what} is no number of the summary"),
    }
}

#[test]
fn a_row_is_the_summary_of_a_run_of_the_same_scene() {
    const NAMES: [&str; 12] = [
        "dissipated_energy",
        "predicted_error",
        "stated_error",
        "released_energy_sum",
        "loop_integral",
        "ledger_mismatch",
        "closed",
        "jumps",
        "mesh_jumps",
        "transitions",
        "states",
        "transforms",
    ];
    let home = folder();
    let record = format!("record = {NAMES:?}\nscene");
    let short = STUDY.lines().filter(|line| !line.starts_with("record"));
    let short = short.collect::<Vec<_>>().join("\n");
    let hertz = "format = 1\nscene = \"hertz\"\nset.cell.points = 32\nset.drive.step = 0.005\n\
        [[axis]]\nkey = \"noise.seed\"\nseeds = { from = 3, count = 1 }\n";
    for text in [&short, hertz] {
        let text = text.replacen("scene", &record, 1);
        let study = study_file::parse(&text, "study.toml").expect("a study");
        let points = study.points();
        for point in [&points[0], &points[points.len() / 2]] {
            let row = study
                .row(point, &Default::default())
                .expect("not cancelled");
            let scene = home.path().join("scene.toml");
            let decided = point.scene.as_ref().expect("a scene");
            fs::write(&scene, scene_file::to_text(decided)).expect("written");
            let out = home.path().join("run");
            let ran = crate::binary::run(&scene.display().to_string(), &out, &["--quiet"]);
            ended(&ran, 0);
            let told = fs::read_to_string(out.join("summary.json")).expect("summary.json");
            for (name, cell) in NAMES.iter().zip(&row.cells) {
                same(cell, written(&told, name), name);
            }
        }
    }
}

/// A line of the study, what it is replaced by, and parts of the sentence that refuses it.
const REFUSED: [(&str, &str, &[&str]); 14] = [
    (
        "scene = \"fig2\"",
        "scene = \"fig22\"",
        &["fig22", "did you mean fig2"],
    ),
    (
        "format = 1",
        "format = 2",
        &["study.toml: format = 2", "allowed is 1"],
    ),
    (
        "record",
        "recrd",
        &["recrd is not a key of this file, did you mean record"],
    ),
    (
        "\"jumps\"",
        "\"jmps\"",
        &["record = \"jmps\"", "did you mean jumps"],
    ),
    (
        "\"jumps\"",
        "\"transforms\"",
        &["record = \"transforms\"", "each column once"],
    ),
    (
        "\"law.range\"",
        "\"law.rage\"",
        &["axis.key = \"law.rage\"", "law.range, law.mu_rho"],
    ),
    (
        "\"law.range\"",
        "3",
        &["axis 1.key = 3", "a number of the scene"],
    ),
    (
        "\"cell.length\"",
        "\"law.range\"",
        &["axis 2.key = \"law.range\"", "each key once"],
    ),
    (
        "values = [1.2,",
        "values = [\"1.2\",",
        &["axis 1.values", "a list of numbers"],
    ),
    (
        "count = 2 }",
        "count = 1 }",
        &["linear.count = 1", "a whole number from 2"],
    ),
    (
        "to = 256.0",
        "to = 220.0",
        &["linear.to = 220.0", "another number than from"],
    ),
    (
        "linear = {",
        "logarithmic = { by = 1,",
        &["logarithmic.by is not a key"],
    ),
    (
        "cell.points = \"auto\"",
        "cell.pints = 4",
        &["cell.pints is not a key", "did you mean points"],
    ),
    (
        "[[axis]]",
        "[sobol]\ncount = 8\n[[axis]]",
        &["axis 1.values", "not together with [sobol]"],
    ),
];

#[test]
fn what_is_no_study_is_refused_in_words() {
    let home = folder();
    let out = home.path().join("out");
    for (line, replacement, parts) in REFUSED {
        assert!(STUDY.contains(line), "{line}");
        let study = write(home.path(), &STUDY.replacen(line, replacement, 1));
        let output = sweep(&study, &out, &[]);
        let words = errors(&output);
        assert_eq!(output.status.code(), Some(2), "{replacement}: {words}");
        assert_eq!(words.lines().count(), 1, "{words}");
        says(&words, parts);
        assert!(!out.exists(), "nothing is written for {replacement}");
    }
}

#[test]
fn an_option_that_means_nothing_is_refused_in_words() {
    let home = folder();
    let out = home.path().join("out");
    let study = write(home.path(), STUDY);
    for (more, part) in [
        (["--shard", "4/3"], "\"4/3\" is not I/N"),
        (["--plot", "law.range"], "allowed are two columns"),
        (
            ["--plot", "law.range,loss"],
            "allowed are two of law.range, cell.length, dissipated",
        ),
    ] {
        let output = sweep(&study, &out, &more);
        says(&ended(&output, 2), &[part]);
    }
}

#[test]
fn a_convergence_study_of_a_preset_says_order_limit_and_error_bar() {
    let home = folder();
    let out = home.path().join("out");
    let (scene, _kept) = crate::binary::fig2_with(&[
        ("points = 64", "points = 32"),
        ("step = 0.02", "step = 0.2"),
    ]);
    let output = sweep(&scene, &out, &["--converge", "points"]);
    let words = ended(&output, 0);
    assert!(words.contains("dissipated_energy: 0.1174"), "{words}");
    let text = fs::read_to_string(out.join("convergence.csv")).expect("convergence.csv");
    assert!(
        text.starts_with("quantity,points,value,order,limit,error_bar\n"),
        "{text}"
    );
    assert!(text.contains("\nretraction_jumps 4,64"), "{text}");
}

#[test]
fn the_guide_lists_every_column() {
    let guide =
        fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/guide/studies.md"));
    let guide = guide.expect("the guide");
    let rows = COLUMNS.iter();
    let rows = rows.map(|column| format!("| `{}` | {} |\n", column.name, column.what));
    let table = format!("| column | is |\n|---|---|\n{}", rows.collect::<String>());
    assert!(guide.contains(&table), "the guide's table must be\n{table}");
}
