//! The guide's table of an explorer names only tests and pictures that exist.

use crate::binary::content;
use crate::floors::files_under;
use std::collections::BTreeSet;
use std::path::Path;

const PAGE: &str = "assets/guide/explorer.md";
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
