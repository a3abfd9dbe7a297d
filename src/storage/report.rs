//! The report: every figure with its words and findings, the tables, the errata, as one HTML page
//! that needs nothing else.

use super::drawing::{escaped, page_svg};
use super::{Failure, VERSION, files};
use crate::paper::errata::Erratum;
use crate::paper::figure::{Figure, Finding, Table};
use crate::plot::typeset::{Script, number, runs};
use std::fmt::Write;
use std::path::Path;

/// What the report holds.
#[derive(Default)]
pub struct Report<'a> {
    /// The figures with what to look for in each.
    pub figures: Vec<(&'a Figure, &'a str)>,
    /// The tables.
    pub tables: Vec<&'a Table>,
    /// What the print got wrong.
    pub errata: &'a [Erratum],
    /// What is missing, in words, and why.
    pub missing: Vec<String>,
}

const STYLE: &str = "\
body { font: 16px/1.5 'DejaVu Sans', Verdana, sans-serif; color: #222; background: #fff; \
    max-width: 60rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.7rem; } h2 { font-size: 1.25rem; margin-top: 2.5rem; \
    border-bottom: 1px solid #ccc; }
figure { margin: 1rem 0; } figure svg { width: 100%; height: auto; }
.look { color: #555; font-style: italic; } .missing { color: #a02020; }
table { border-collapse: collapse; font-size: 0.85rem; margin: 0.8rem 0; width: 100%; }
th, td { text-align: left; padding: 0.25rem 0.7rem 0.25rem 0; \
    border-bottom: 1px solid #ddd; vertical-align: top; }
th { border-bottom: 1.5px solid #222; } td.number { font-variant-numeric: tabular-nums; \
    white-space: nowrap; }
.yes { color: #116b3a; } .no { color: #a02020; font-weight: bold; } .stated { color: #777; }
sub, sup { line-height: 0; font-size: 0.72em; }
nav { columns: 2; font-size: 0.9rem; } nav ul { margin: 0; }
@media print {
  body { font-size: 10.5pt; max-width: none; margin: 0; } h2 { break-after: avoid; }
  section.figure { break-inside: avoid-page; } figure { break-inside: avoid; } \
  tr { break-inside: avoid; } thead { display: table-header-group; }
  nav { display: none; } a { color: inherit; text-decoration: none; }
}
";

/// Writes the page.
///
/// # Errors
/// A file that cannot be written.
pub fn write_report(path: &Path, report: &Report<'_>) -> Result<(), Failure> {
    files::write_whole(path, page(report).as_bytes())
}

fn page(report: &Report<'_>) -> String {
    let mut out = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta \
         name=\"viewport\" content=\"width=device-width\">\n\
         <title>Modeling adhesive hysteresis, figure by \
         figure</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
         <h1>Modeling adhesive hysteresis, figure by figure</h1>\n\
         <p>The figures of Wang, Zhou and Müser (<i>Lubricants</i> 9 (2021) 17, doi \
         10.3390/lubricants9020017), computed anew by \
         Tackscope {}, beside theory and print.</p>\n",
        VERSION
    );
    summary(&mut out, report);
    for (figure, look_for) in &report.figures {
        self::figure(&mut out, figure, look_for);
    }
    for table in &report.tables {
        self::table(&mut out, table);
    }
    errata(&mut out, report.errata);
    out.push_str("</body>\n</html>\n");
    out
}

/// How many findings agree, what is missing, and where to find what.
fn summary(out: &mut String, report: &Report<'_>) {
    let all = || {
        report
            .figures
            .iter()
            .flat_map(|(f, _)| &f.findings)
            .chain(report.tables.iter().flat_map(|t| &t.findings))
    };
    let judged = all().filter(|f| f.agrees().is_some()).count();
    let agree = all().filter(|f| f.agrees() == Some(true)).count();
    let _ = writeln!(
        out,
        "<p>{} numbers are compared; {judged} of them with a promise how near they must be, and of \
         those {agree} agree. Curves: broad lines and symbols are computed equilibria, thin solid \
         lines theory, dashed lines the print.</p>",
        all().count()
    );
    for missing in &report.missing {
        let _ = writeln!(out, "<p class=\"missing\">Missing: {}</p>", set(missing));
    }
    out.push_str("<nav><ul>\n");
    for (figure, _) in &report.figures {
        let _ = writeln!(
            out,
            "<li><a href=\"#figure-{0}\">Fig. {0}: {1}</a></li>",
            figure.number,
            set(&figure.title)
        );
    }
    for table in &report.tables {
        let _ = writeln!(
            out,
            "<li><a href=\"#table-{0}\">Table {0}: {1}</a></li>",
            table.number,
            set(&table.title)
        );
    }
    if !report.errata.is_empty() {
        out.push_str("<li><a href=\"#errata\">What the print got wrong</a></li>\n");
    }
    out.push_str("</ul></nav>\n");
}

fn figure(out: &mut String, figure: &Figure, look_for: &str) {
    let number = figure.number;
    let _ = writeln!(
        out,
        "<section class=\"figure\" id=\"figure-{number}\">\n<h2>Fig. {number}: {}</h2>",
        set(&figure.title)
    );
    let _ = writeln!(out, "<p class=\"look\">{}</p>", set(look_for));
    let _ = writeln!(out, "<figure>\n{}</figure>", page_svg(&figure.page()));
    paragraph(out, &figure.words);
    findings(out, &figure.findings);
    out.push_str("</section>\n");
}

fn table(out: &mut String, table: &Table) {
    let number = table.number;
    let _ = writeln!(
        out,
        "<section id=\"table-{number}\">\n<h2>Table {number}: {}</h2>",
        set(&table.title)
    );
    head(out, &table.columns);
    for row in &table.rows {
        let cells: String = row
            .iter()
            .map(|cell| format!("<td>{}</td>", set(cell)))
            .collect();
        let _ = writeln!(out, "<tr>{cells}</tr>");
    }
    out.push_str("</tbody>\n</table>\n");
    paragraph(out, &table.words);
    findings(out, &table.findings);
    out.push_str("</section>\n");
}

/// The beginning of a table: its columns.
fn head(out: &mut String, columns: &[impl AsRef<str>]) {
    let cell = |column: &_| format!("<th>{}</th>", set(AsRef::as_ref(column)));
    let cells: String = columns.iter().map(cell).collect();
    let _ = writeln!(out, "<table>\n<thead><tr>{cells}</tr></thead>\n<tbody>");
}

fn paragraph(out: &mut String, words: &str) {
    if !words.is_empty() {
        let _ = writeln!(out, "<p>{}</p>", set(words));
    }
}

fn findings(out: &mut String, findings: &[Finding]) {
    if findings.is_empty() {
        return;
    }
    head(
        out,
        &[
            "quantity",
            "found",
            "expected",
            "source",
            "deviation",
            "agrees",
        ],
    );
    for finding in findings {
        let (class, word) = match finding.agrees() {
            Some(true) => ("yes", "yes"),
            Some(false) => ("no", "no"),
            None => ("stated", "stated only"),
        };
        let [found, expected, deviation] = [
            finding.found,
            finding.expected,
            finding.found - finding.expected,
        ]
        .map(number);
        let _ = writeln!(
            out,
            "<tr><td>{}</td><td class=\"number\">{found}</td><td \
             class=\"number\">{expected}</td><td>{}</td><td class=\"number\">{deviation}</td><td \
             class=\"{class}\">{word}</td></tr>",
            set(&finding.quantity),
            set(&finding.source)
        );
    }
    out.push_str("</tbody>\n</table>\n");
}

fn errata(out: &mut String, errata: &[Erratum]) {
    if errata.is_empty() {
        return;
    }
    out.push_str("<section id=\"errata\">\n<h2>What the print got wrong</h2>\n");
    out.push_str(
        "<p>The evidence is computed without either formula: by finding roots, integrating, \
         measuring, running a loop.</p>\n",
    );
    for erratum in errata {
        let _ = writeln!(
            out,
            "<h3>{}</h3>\n<p>Printed: {}<br>Right: {}<br>{}</p>",
            set(erratum.place),
            set(erratum.printed),
            set(erratum.right),
            set(erratum.because)
        );
        if erratum.evidence.is_empty() {
            continue;
        }
        head(out, &["evidence", "found", "by the print", "right"]);
        for evidence in &erratum.evidence {
            let [found, printed, right] =
                [evidence.found, evidence.printed, evidence.right].map(number);
            let _ = writeln!(
                out,
                "<tr><td>{}</td><td class=\"number\">{found}</td><td \
                 class=\"number\">{printed}</td><td class=\"number\">{right}</td></tr>",
                set(evidence.quantity)
            );
        }
        out.push_str("</tbody>\n</table>\n");
    }
    out.push_str("</section>\n");
}

/// Text with its formulas set, safe inside HTML.
fn set(text: &str) -> String {
    let mut out = String::new();
    for run in runs(text) {
        let text = escaped(&run.text);
        let _ = match run.script {
            Script::Base => write!(out, "{text}"),
            Script::Sub => write!(out, "<sub>{text}</sub>"),
            Script::Super => write!(out, "<sup>{text}</sup>"),
        };
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paper::errata::Evidence;

    fn finding(found: f64, tolerance: Option<f64>) -> Finding {
        Finding::new("u_c/rho <b>", found, 1.0, "Eq. 8 & more", tolerance)
    }

    #[test]
    fn the_page_holds_everything_escaped_and_needs_nothing_else() {
        let figure = Figure {
            number: 4,
            title: "a < b".to_owned(),
            words: "<script>alert(1)</script>".to_owned(),
            findings: vec![
                finding(1.01, Some(0.1)),
                finding(1.5, Some(0.1)),
                finding(2.0, None),
            ],
            ..Figure::default()
        };
        let table = Table {
            number: 1,
            rows: vec![vec!["<i>".to_owned()]],
            ..Table::default()
        };
        let evidence = vec![Evidence {
            quantity: "vhat_c",
            found: 0.400643,
            printed: 0.4204,
            right: 0.400643,
            tolerance: 1e-6,
        }];
        let errata = [Erratum {
            place: "Eq. 24",
            printed: "<0.42>",
            right: "0.40",
            because: "",
            evidence,
        }];
        let report = Report {
            figures: vec![(&figure, "look <here>")],
            tables: vec![&table],
            errata: &errata,
            missing: vec!["Fig. 5: <x>".to_owned()],
        };
        let page = page(&report);
        for part in [
            "<svg",
            "&lt;script&gt;",
            "u<sub>c</sub>/ρ &lt;b&gt;",
            "Eq. 8 &amp; more",
            "class=\"yes\"",
            "class=\"no\"",
            "stated only",
            "look &lt;here&gt;",
            "&lt;i&gt;",
            "&lt;0.42&gt;",
            "Fig. 5: &lt;x&gt;",
            "3 numbers are compared; 2 of them",
            "of those 1 agree",
            "@media print",
            "0.4204",
        ] {
            assert!(page.contains(part), "{part} is missing");
        }
        for foreign in ["<script", "<b>", "<i>\u{20}", "http-equiv", "src=", "<link"] {
            assert!(!page.contains(foreign), "{foreign}");
        }
        for tag in ["section", "table", "tbody", "figure", "nav", "ul", "tr"] {
            let (open, close) = (
                page.matches(&format!("<{tag}>")).count()
                    + page.matches(&format!("<{tag} ")).count(),
                page.matches(&format!("</{tag}>")).count(),
            );
            assert_eq!(open, close, "{tag}");
        }
    }
}
