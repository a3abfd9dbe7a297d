//! What the guide promises: its links lead somewhere; its table of an explorer names only tests and pictures that exist; and the
//! lessons can be done, say true numbers, and fail where their condition is made false.

use crate::binary::{content, says};
use crate::floors::files_under;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use tackscope::lessons::{
    Act, Condition, Facts, Lesson, Progress, Question, Stage, all, find, parse,
};
use tackscope::numerics::threads::Cancel;
use tackscope::physics::theory::{flat_limits, flat_stiffness};
use tackscope::scene::Scene;
use tackscope::storage;
use tackscope::worker::rehearse;

const PAGE: &str = "assets/guide/explorer.md";
const FOLDER: &str = "assets/guide";
/// Whose users expect it.
const EXPECTING: [&str; 6] = ["PhET", "VisualPDE", "XPPAUT", "Rerun", "Desmos", "GeoGebra"];

/// A row of a table: what one can do, who expects it, the answer, and what shows it.
struct Row {
    number: usize,
    can: String,
    expecting: Option<String>,
    answer: String,
    shown: String,
}

impl Row {
    fn of(line: &str) -> Option<Self> {
        let cells: Vec<String> = line
            .trim_matches('|')
            .split('|')
            .map(|cell| cell.trim().to_owned())
            .collect();
        let number = cells.first()?.parse().ok()?;
        let (can, rest) = (cells[1].clone(), &cells[2..]);
        let (expecting, rest) = match rest {
            [expecting, rest @ ..] if rest.len() == 2 => (Some(expecting.clone()), rest),
            rest => (None, rest),
        };
        let [answer, shown] = rest else {
            panic!("{line}: {} cells", cells.len())
        };
        Some(Self {
            number,
            can,
            expecting,
            answer: answer.clone(),
            shown: shown.clone(),
        })
    }

    /// What is named between `` ` ``.
    fn evidence(&self) -> Vec<&str> {
        self.shown.split('`').skip(1).step_by(2).collect()
    }
}

/// Both tables.
fn tables() -> [Vec<Row>; 2] {
    let page = content(PAGE);
    let (expected, own) = page.split_once("## What no other has").unwrap();
    [expected, own].map(|part| part.lines().filter_map(Row::of).collect())
}

/// The names of all tests.
fn tests() -> BTreeSet<String> {
    let name = |test: &str| {
        let (_, rest) = test.split_once("fn ")?;
        Some(rest.split_once('(')?.0.to_owned())
    };
    let files = ["src", "tests"].into_iter().flat_map(files_under);
    files
        .flat_map(|(_, text)| {
            let tests = text.split("#[test]").skip(1);
            tests.filter_map(name).collect::<Vec<_>>()
        })
        .collect()
}

#[test]
fn the_table_of_an_explorer_has_54_and_15_rows_each_once() {
    let [expected, own] = tables();
    assert_eq!((expected.len(), own.len()), (54, 15));
    for (rows, of_any) in [(&expected, true), (&own, false)] {
        for (index, row) in rows.iter().enumerate() {
            assert_eq!(row.number, index + 1, "{}", row.can);
            let known = |name: &String| EXPECTING.contains(&&**name);
            assert_eq!(
                row.expecting.as_ref().is_some_and(known),
                of_any,
                "{}",
                row.can
            );
        }
    }
    let page = content(PAGE);
    let count = |rows: &[Row], answer: &str| rows.iter().filter(|row| row.answer == answer).count();
    let [yes, partly, no] = ["yes", "partly", "no"].map(|answer| count(&expected, answer));
    let sum = format!("Of the 54 rows {yes} are so, {partly} partly and {no} not");
    let [yes, partly, no] = ["yes", "partly", "no"].map(|answer| count(&own, answer));
    let of_own = format!("of the 15 it is {yes}, {partly} and {no}.");
    assert!(
        page.contains(&format!("{sum}; {of_own}")),
        "{sum}; {of_own}"
    );
    let all = || expected.iter().chain(&own);
    let different: BTreeSet<&str> = all().map(|row| &*row.can).collect();
    assert_eq!(different.len(), all().count(), "a row stands there twice");
    let shown: Vec<&str> = all().flat_map(Row::evidence).collect();
    let once: BTreeSet<&str> = shown.iter().copied().collect();
    assert_eq!(once.len(), shown.len(), "one test shows one row");
}

#[test]
fn every_row_of_the_explorer_is_shown_by_a_test_or_picture_that_is_there_or_says_what_is_missing() {
    let tests = tests();
    assert!(
        tests.contains("flat_state_loses_stability_at_eq_8"),
        "the tests were not found"
    );
    for row in tables().into_iter().flatten() {
        let (shown, missing) = (!row.evidence().is_empty(), row.shown.contains("Missing: "));
        let fits = match &*row.answer {
            "yes" => shown && !missing,
            "partly" => shown && missing,
            "no" => !shown && missing,
            other => panic!("{}: {other}", row.can),
        };
        assert!(fits, "{}: {} and {}", row.can, row.answer, row.shown);
        for name in row.evidence() {
            let is_there = if name.ends_with(".png") {
                Path::new("tests/window/screens").join(name).is_file()
            } else {
                tests.contains(name)
            };
            assert!(is_there, "{}: there is no {name}", row.can);
        }
    }
}

/// The anchors of a page's headings, as GitHub makes them.
fn anchors(page: &str) -> BTreeSet<String> {
    let headings = page.lines().filter(|line| line.starts_with('#'));
    let words = headings.map(|line| line.trim_start_matches('#').trim().to_lowercase());
    words
        .map(|words| {
            let kept = words
                .chars()
                .filter(|c| c.is_alphanumeric() || " -".contains(*c));
            kept.collect::<String>().replace(' ', "-")
        })
        .collect()
}

#[test]
fn every_link_of_readme_and_guide_leads_somewhere_and_the_readme_links_every_page() {
    let pages: Vec<PathBuf> = fs::read_dir(FOLDER)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    let readme = PathBuf::from("README.md");
    let mut linked = BTreeSet::new();
    for page in pages.iter().chain([&readme]) {
        let text = content(page);
        let folder = page.parent().unwrap();
        let targets = text.split("](").skip(1);
        for target in targets.filter_map(|rest| Some(rest.split_once(')')?.0)) {
            if target.starts_with("http") {
                continue;
            }
            let (path, anchor) = target.split_once('#').unwrap_or((target, ""));
            let path = if path.is_empty() {
                page.clone()
            } else {
                folder.join(path)
            };
            assert!(path.exists(), "{}: {target}", page.display());
            let known = anchor.is_empty() || anchors(&content(&path)).contains(anchor);
            assert!(known, "{}: there is no heading {target}", page.display());
            if *page == readme {
                linked.insert(path);
            }
        }
    }
    for page in &pages {
        assert!(
            linked.contains(page),
            "the README does not link {}",
            page.display()
        );
    }
}

fn scene(name: &str) -> Result<Scene, String> {
    let preset = storage::preset(name).ok_or_else(|| name.to_owned())?;
    preset.scene().map_err(|failure| failure.to_string())
}

fn performed(lesson: &Lesson) -> Result<Vec<String>, String> {
    rehearse(lesson, &scene, &Cancel::default())
}

#[test]
fn every_lesson_can_be_done_and_fills_in_every_number() {
    assert_eq!(all().len(), 7);
    for lesson in all() {
        let told = performed(lesson).unwrap_or_else(|why| panic!("{why}"));
        assert_eq!(told.len(), lesson.steps.len(), "{}", lesson.name);
        assert!((5..=7).contains(&lesson.minutes));
    }
}

#[test]
fn what_a_lesson_says_is_what_the_theory_says() {
    let told = performed(find("first-snap").unwrap()).unwrap();
    let model = scene("fig2").unwrap().model().unwrap();
    let (lower, upper) = flat_limits(&model.law, model.grid.length).unwrap();
    let limit = format!("{:.3}", upper / model.law.range);
    assert!(
        told[1].contains(&format!("It snapped at {limit} ranges")),
        "{told:?}"
    );
    let told = performed(find("held-by-nothing").unwrap()).unwrap();
    let stiffness = flat_stiffness(&model.law, model.grid.length, 2.5);
    assert!(stiffness < 0.0 && lower < 2.5);
    assert!(
        told[1].contains(&format!("{stiffness:.2} E*/L. It is negative")),
        "{told:?}"
    );
}

#[test]
fn a_lesson_whose_condition_is_false_fails_and_says_where() {
    let lesson = find("four-patterns").unwrap();
    for (condition, acts) in [
        // Never met.
        (Some(Condition::Pattern("contact".to_owned())), None),
        (Some(Condition::JumpedBack("flat".to_owned())), None),
        (Some(Condition::MuRhoAbove(1.0)), None),
        (Some(Condition::Stable(false)), None),
        // Not by what is done.
        (None, Some(vec![Act::GoTo(4.0)])),
        // Met before anything is done.
        (Some(Condition::Pattern("flat".to_owned())), None),
    ] {
        let mut mutated = lesson.clone();
        let task = mutated.steps[0].task.as_mut().unwrap();
        if let Some(condition) = condition {
            task.until = vec![condition];
        }
        if let Some(acts) = acts {
            task.act = acts;
        }
        let why = performed(&mutated).expect_err("it cannot be done");
        assert!(
            why.starts_with("four-patterns, step 1: its condition"),
            "{why}"
        );
    }
    let mut mutated = lesson.clone();
    mutated.steps[1].explain = "a number that nobody knows: {temperature}".to_owned();
    let why = performed(&mutated).expect_err("it has no such number");
    says(&why, &["step 2: no number", "{temperature}"]);
}

#[test]
fn a_text_that_is_no_lesson_is_refused_with_its_place() {
    let text =
        "title = \"T\"\nteaches = \"t\"\nminutes = 5\n[[step]]\ntext = \"a\"\nquestoin = 1\n";
    let why = parse("mine", text).expect_err("a typing error");
    says(&why, &["mine.toml", "questoin"]);
    let text = "title = \"T\"\nteaches = \"t\"\nminutes = 5\nstep = []\n";
    assert!(parse("mine", text).is_err());
}

#[test]
fn a_guess_counts_by_how_near_it_is_and_progress_is_kept() {
    let lesson = find("first-snap").unwrap();
    let fig2 = scene("fig2").unwrap();
    let model = fig2.model().unwrap();
    let mut record = tackscope::follow::run::run_loop(
        &fig2,
        Default::default(),
        &Cancel::default(),
        &mut |_| {},
    )
    .unwrap()
    .record;
    record.jumps.truncate(1);
    let facts = Facts {
        scene: &fig2,
        model: &model,
        record: &record,
        loss: None,
    };
    let right = record.jumps[0].mean_displacement / model.law.range;
    for (off, points) in [(1.0, 3), (1.019, 3), (0.96, 2), (1.1, 1), (0.8, 0)] {
        let mut progress = Progress::new(lesson);
        assert!(progress.observe(lesson, &facts), "a text waits for nothing");
        progress.next(lesson);
        assert!(matches!(
            progress.asks(lesson),
            Some(Question::Guess { .. })
        ));
        progress.commit(lesson, &facts);
        assert_eq!(progress.stage, Stage::Asking, "no answer, no step");
        progress.answer = Some((off * right * 100.0).round() / 100.0);
        progress.commit(lesson, &facts);
        assert!(progress.observe(lesson, &facts));
        assert_eq!(progress.score, [points, 3], "{off}");
        let words = progress.explanation(lesson).unwrap();
        says(&words, &[&format!("({points} of 3 points)")]);
        let text = serde_json::to_string(&progress).unwrap();
        assert_eq!(serde_json::from_str::<Progress>(&text).unwrap(), progress);
        progress.next(lesson);
        progress.back(lesson);
        assert_eq!((progress.step, progress.stage), (1, Stage::Asking));
    }
}
