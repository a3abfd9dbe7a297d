//! `tackscope figure` and `tackscope table`, as a user or a script meets them.

use crate::binary::{
    Running, command, content, done, errors, folder, is_png, perform, refuses, said, says,
};

#[test]
fn a_figure_becomes_data_and_pictures_and_one_closing_line() {
    let home = folder();
    let output = perform(&["figure", "4", "--quick"], home.path());
    let line = done(&output);
    assert!(
        line.starts_with("1 figure") && line.lines().count() == 1,
        "{line}"
    );
    says(
        &errors(&output),
        &["Fig. 4: Where the flat surface gives way"],
    );
    let csv = content(home.path().join("figure-04.csv"));
    assert!(csv.starts_with("# Fig. 4: ") && csv.contains("\npanel,series,role,x,y,x_to,y_to\n"));
    assert!(content(home.path().join("figure-04.svg")).starts_with("<svg"));
    assert!(is_png(&home.path().join("figure-04.png")));
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
        let output = perform(&arguments, &out);
        refuses(&output, &[arguments[1], allowed]);
        assert!(!out.exists(), "nothing is written for a refused number");
    }
}

#[test]
fn table_1_becomes_data_and_pictures() {
    let home = folder();
    let output = perform(&["table", "1"], home.path());
    done(&output);
    let csv = content(home.path().join("table-1.csv"));
    for row in [
        "Dugdale,1960,0.798,π/8,0.7979",
        "Popov,2015,0.729,0.47,0.7293",
    ] {
        assert!(csv.lines().any(|line| line == row), "{row} in {csv}");
    }
    for name in ["table-1.svg", "table-1.png"] {
        assert!(home.path().join(name).exists(), "{name}");
    }
    assert!(said(&output).contains("6 of 6 findings agree"));
}

#[test]
fn quiet_is_silent() {
    let output = perform(&["figure", "4", "--quick", "--quiet"], folder().path());
    assert!(output.status.success() && output.stdout.is_empty() && output.stderr.is_empty());
}

#[test]
fn a_report_is_one_page_with_picture_findings_table_and_errata() {
    let home = folder();
    let output = perform(
        &["figure", "4", "--quick", "--quiet", "--report"],
        home.path(),
    );
    done(&output);
    let page = content(home.path().join("report.html"));
    says(
        &page,
        &[
            "<svg",
            "Fig. 4",
            "Table 1",
            "Dugdale",
            "What the print got wrong",
            "0.400643",
            "</html>",
        ],
    );
    let findings = content(home.path().join("findings.csv"));
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
    let words = ["figure", "all", "--quick", "--report"];
    let mut going = Running::spawn(command(&words, home.path()));
    let mut done = String::new();
    while !done.starts_with("Fig. ") {
        done = going.line();
        assert!(!done.is_empty(), "it ended before a figure was done");
    }
    going.signal("INT");
    let (code, rest) = going.end();
    assert_eq!(code, Some(130), "{rest}");
    says(&rest, &["interrupted; what was computed is in"]);
    let number: usize = done[5..]
        .split(':')
        .next()
        .and_then(|n| n.parse().ok())
        .expect("its number");
    assert!(home.path().join(format!("figure-{number:02}.png")).exists());
    let page = content(home.path().join("report.html"));
    assert!(
        page.contains(&format!("id=\"figure-{number}\"")) && page.contains("stopped"),
        "the page says what is missing"
    );
}
