//! `tackscope figure` and `tackscope table`, as a user or a script meets them.

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Command, Output, Stdio};
use tackscope::paper::GALLERY;
use tempfile::TempDir;

fn tackscope(arguments: &[&str], out: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tackscope"));
    command
        .stdin(Stdio::null())
        .args(arguments)
        .arg("--out")
        .arg(out)
        .output()
        .expect("the binary runs")
}

fn folder() -> TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

fn errors(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).expect("UTF-8")
}

#[test]
fn a_figure_becomes_data_and_pictures_and_one_closing_line() {
    let home = folder();
    let output = tackscope(&["figure", "4", "--quick"], home.path());
    assert_eq!(output.status.code(), Some(0), "{}", errors(&output));
    let line = String::from_utf8(output.stdout.clone()).expect("UTF-8");
    assert!(
        line.starts_with("1 figure") && line.lines().count() == 1,
        "{line}"
    );
    assert!(
        errors(&output).contains("Fig. 4: Where the flat surface gives way"),
        "{}",
        errors(&output)
    );
    let csv = fs::read_to_string(home.path().join("figure-04.csv")).expect("figure-04.csv");
    assert!(csv.starts_with("# Fig. 4: ") && csv.contains("\npanel,series,role,x,y,x_to,y_to\n"));
    assert!(
        fs::read_to_string(home.path().join("figure-04.svg"))
            .expect("figure-04.svg")
            .starts_with("<svg")
    );
    assert!(
        fs::read(home.path().join("figure-04.png"))
            .expect("figure-04.png")
            .starts_with(b"\x89PNG")
    );
}

#[test]
fn an_unknown_figure_or_table_is_refused_with_what_there_is() {
    for (arguments, allowed) in [
        (["figure", "77"], "or all"),
        (["figure", "all4"], "4"),
        (["table", "2"], "1"),
    ] {
        let home = folder();
        let out = home.path().join("out");
        let output = tackscope(&arguments, &out);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        let told = errors(&output);
        assert!(
            told.contains(arguments[1]) && told.contains(allowed) && told.lines().count() == 1,
            "{told}"
        );
        assert!(!out.exists(), "nothing is written for a refused number");
    }
}

#[test]
fn table_1_becomes_data_and_pictures() {
    let home = folder();
    let output = tackscope(&["table", "1"], home.path());
    assert_eq!(output.status.code(), Some(0), "{}", errors(&output));
    let csv = fs::read_to_string(home.path().join("table-1.csv")).expect("table-1.csv");
    for row in [
        "Dugdale,1960,0.798,π/8,0.7979",
        "Popov,2015,0.729,0.47,0.7293",
    ] {
        assert!(csv.lines().any(|line| line == row), "{row} in {csv}");
    }
    for name in ["table-1.svg", "table-1.png"] {
        assert!(home.path().join(name).exists(), "{name}");
    }
    assert!(
        String::from_utf8(output.stdout)
            .expect("UTF-8")
            .contains("6 of 6 findings agree")
    );
}

#[test]
fn quiet_is_silent_and_the_gallery_is_in_the_papers_order() {
    let output = tackscope(&["figure", "4", "--quick", "--quiet"], folder().path());
    assert!(output.status.success() && output.stdout.is_empty() && output.stderr.is_empty());
    assert!(
        GALLERY
            .windows(2)
            .all(|pair| pair[0].number < pair[1].number)
    );
}

#[test]
fn a_report_is_one_page_with_picture_findings_table_and_errata() {
    let home = folder();
    let output = tackscope(
        &["figure", "4", "--quick", "--quiet", "--report"],
        home.path(),
    );
    assert_eq!(output.status.code(), Some(0), "{}", errors(&output));
    let page = fs::read_to_string(home.path().join("report.html")).expect("report.html");
    for part in [
        "<svg",
        "Fig. 4",
        "Table 1",
        "Dugdale",
        "What the print got wrong",
        "0.400643",
        "</html>",
    ] {
        assert!(page.contains(part), "{part} is missing");
    }
    let findings = fs::read_to_string(home.path().join("findings.csv")).expect("findings.csv");
    assert!(
        findings.starts_with("where,quantity,found,expected,source,deviation,tolerance,agrees\n")
    );
    assert!(
        findings
            .lines()
            .any(|line| line.starts_with("Table 1,") && line.ends_with(",yes")),
        "{findings}"
    );
}

#[test]
#[cfg(unix)]
fn ctrl_c_keeps_what_is_done_and_the_report_says_what_is_missing() {
    let home = folder();
    let mut command = Command::new(env!("CARGO_BIN_EXE_tackscope"));
    command
        .args(["figure", "all", "--quick", "--report", "--out"])
        .arg(home.path());
    let mut child = command
        .stderr(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("the binary runs");
    let mut told = BufReader::new(child.stderr.take().expect("a pipe"));
    let mut done = String::new();
    while !done.starts_with("Fig. ") {
        done.clear();
        assert!(
            told.read_line(&mut done).expect("a line") > 0,
            "it ended before a figure was done"
        );
    }
    let killed = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status()
        .expect("kill runs");
    assert!(killed.success(), "it is still going after its first figure");
    let mut rest = String::new();
    told.read_to_string(&mut rest).expect("text");
    assert_eq!(child.wait().expect("it ends").code(), Some(130), "{rest}");
    assert!(
        rest.contains("interrupted; what was computed is in"),
        "{rest}"
    );
    let number: usize = done[5..]
        .split(':')
        .next()
        .and_then(|n| n.parse().ok())
        .expect("its number");
    assert!(home.path().join(format!("figure-{number:02}.png")).exists());
    let page = fs::read_to_string(home.path().join("report.html")).expect("report.html");
    assert!(
        page.contains(&format!("id=\"figure-{number}\"")) && page.contains("stopped"),
        "the page says what is missing"
    );
}
