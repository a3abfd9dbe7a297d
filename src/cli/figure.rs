//! `tackscope figure` and `tackscope table`: the paper's figures and its table, computed anew.

use super::progress::Teller;
use super::{BAD_INPUT, DONE, FigureArguments, INTERRUPTED, NOT_CONVERGED, TableArguments, cancel_on_interrupt, say};
use crate::numerics::cancel::Cancel;
use crate::paper::errata::errata;
use crate::paper::figure::Finding;
use crate::paper::{self, Entry, Figure, GALLERY, Size, Stopped, TABLES, Table, Task};
use crate::storage::report::{Report, write_report};
use crate::storage::{Failure, figure as paint, files};
use crate::worker::crew::{self, News};
use std::path::Path;

/// Computes the figures, writes their files and returns the exit code.
pub(super) fn figure(arguments: &FigureArguments) -> u8 {
    told(try_figure(arguments))
}

/// Computes a table, writes its files and returns the exit code.
pub(super) fn table(arguments: &TableArguments) -> u8 {
    told(try_table(arguments))
}

fn told(result: Result<u8, Failure>) -> u8 {
    result.unwrap_or_else(|failure| {
        eprintln!("tackscope: {failure}");
        BAD_INPUT
    })
}

/// The entries that a word names, the longest first so that none is left alone at the end.
fn chosen(word: &str) -> Result<Vec<&'static Entry>, Failure> {
    if word == "all" {
        return Ok(paper::longest_first());
    }
    let number = word.parse::<usize>().ok();
    match GALLERY.iter().find(|entry| Some(entry.number) == number) {
        Some(entry) => Ok(vec![entry]),
        None => Err(unknown("figure", word, GALLERY.iter().map(|entry| entry.number), " or all")),
    }
}

fn unknown(what: &str, word: &str, numbers: impl Iterator<Item = usize>, more: &str) -> Failure {
    let list: Vec<String> = numbers.map(|n| n.to_string()).collect();
    Failure::Value {
        file: "command line".to_owned(),
        key: what.to_owned(),
        value: word.to_owned(),
        allowed: format!("{}{more}", list.join(", ")),
    }
}

/// What came of the figures.
#[derive(Default)]
struct Harvest {
    figures: Vec<(&'static Entry, Figure)>,
    missing: Vec<(usize, Stopped)>,
    unwritten: Option<Failure>,
}

fn try_figure(arguments: &FigureArguments) -> Result<u8, Failure> {
    let entries = chosen(&arguments.figure)?;
    let out = &arguments.out;
    files::prepare_folder(out)?;
    let size = if arguments.quick { Size::Quick } else { Size::Full };
    let cancel = cancel_on_interrupt();
    let what = if entries.len() == 1 { "1 figure".to_owned() } else { format!("{} figures", entries.len()) };
    let teller = Teller::new(arguments.quiet, &format!("{what} of the paper, computed anew into {}", out.display()));
    let mut harvest = gather(&entries, size, &cancel, &teller, out);
    teller.finish();
    if let Some(failure) = harvest.unwritten {
        return Err(failure);
    }
    harvest.figures.sort_by_key(|(entry, _)| entry.number);
    harvest.missing.sort_by_key(|(number, _)| *number);
    if arguments.report {
        report(&harvest, size, &cancel, out)?;
    }
    for (number, why) in harvest.missing.iter().filter(|(_, why)| *why != Stopped::Cancelled) {
        eprintln!("tackscope: Fig. {number}: {why}");
    }
    if !arguments.quiet {
        say(&closing_words(&harvest, out));
    }
    let code = exit_code(&harvest.missing);
    if code == INTERRUPTED {
        eprintln!("tackscope: interrupted; what was computed is in {}", out.display());
    }
    Ok(code)
}

fn exit_code(missing: &[(usize, Stopped)]) -> u8 {
    match missing {
        [] => DONE,
        _ if missing.iter().any(|(_, why)| *why == Stopped::Cancelled) => INTERRUPTED,
        _ => NOT_CONVERGED,
    }
}

/// Computes, and writes each figure as soon as it is there.
fn gather(entries: &[&'static Entry], size: Size, cancel: &Cancel, teller: &Teller, out: &Path) -> Harvest {
    let mut harvest = Harvest::default();
    let mut shares = vec![0.0; entries.len()];
    crew::compute(entries, size, cancel, &mut |news| match news {
        News::Progress { index, done, what } => {
            shares[index] = done;
            teller.fraction(shares.iter().sum::<f64>() / shares.len() as f64);
            teller.now(&format!("Fig. {}: {what}", entries[index].number));
        }
        News::Done { index, figure, seconds } => {
            shares[index] = 1.0;
            teller.fraction(shares.iter().sum::<f64>() / shares.len() as f64);
            let entry = entries[index];
            match figure {
                Ok(figure) => {
                    let words = findings_in_words(&figure.findings);
                    teller.note(&format!("Fig. {}: {} ({seconds:.1} s{words})", entry.number, entry.title));
                    if let Err(failure) = write_figure(out, &figure) {
                        harvest.unwritten.get_or_insert(failure);
                        cancel.request();
                    }
                    harvest.figures.push((entry, figure));
                }
                Err(why) => harvest.missing.push((entry.number, why)),
            }
        }
    });
    harvest
}

/// Writes `report.html` and `findings.csv` about what there is, also after a request to stop.
fn report(harvest: &Harvest, size: Size, cancel: &Cancel, out: &Path) -> Result<(), Failure> {
    let mut missing: Vec<String> = harvest.missing.iter().map(|(number, why)| format!("Fig. {number}: {why}")).collect();
    let mut tables = Vec::new();
    for entry in TABLES {
        match (entry.compute)(&mut Task::new(size, cancel, &mut |_, _| {})) {
            Ok(table) => tables.push(table),
            Err(why) => missing.push(format!("Table {}: {why}", entry.number)),
        }
    }
    let errata = errata(&mut Task::new(size, cancel, &mut |_, _| {})).unwrap_or_else(|why| {
        missing.push(format!("errata: {why}"));
        Vec::new()
    });
    let of_figures =
        harvest.figures.iter().flat_map(|(_, f)| f.findings.iter().map(|finding| (format!("Fig. {}", f.number), finding)));
    let of_tables = tables.iter().flat_map(|t| t.findings.iter().map(|finding| (format!("Table {}", t.number), finding)));
    paint::write_findings_csv(&out.join("findings.csv"), of_figures.chain(of_tables))?;
    let figures = harvest.figures.iter().map(|(entry, figure)| (figure, entry.look_for)).collect();
    write_report(&out.join("report.html"), &Report { figures, tables: tables.iter().collect(), errata: &errata, missing })
}

/// ", 3 of 4 findings agree", or nothing.
fn findings_in_words(findings: &[Finding]) -> String {
    let judged: Vec<bool> = findings.iter().filter_map(Finding::agrees).collect();
    let agree = judged.iter().filter(|agrees| **agrees).count();
    if judged.is_empty() { String::new() } else { format!(", {agree} of {} findings agree", judged.len()) }
}

fn write_figure(out: &Path, figure: &Figure) -> Result<(), Failure> {
    let name = |end: &str| out.join(format!("figure-{:02}.{end}", figure.number));
    paint::write_figure_csv(&name("csv"), figure)?;
    paint::write_figure_svg(&name("svg"), figure)?;
    paint::write_figure_png(&name("png"), figure)
}

/// The one line on standard output.
fn closing_words(harvest: &Harvest, out: &Path) -> String {
    let findings: Vec<Finding> = harvest.figures.iter().flat_map(|(_, figure)| figure.findings.clone()).collect();
    let words = findings_in_words(&findings);
    let missing = if harvest.missing.is_empty() { String::new() } else { format!(", {} missing", harvest.missing.len()) };
    let count = harvest.figures.len();
    format!("{count} figure{}{missing}{words}: written to {}", if count == 1 { "" } else { "s" }, out.display())
}

fn try_table(arguments: &TableArguments) -> Result<u8, Failure> {
    let number = arguments.table.parse::<usize>().ok();
    let entry = TABLES.iter().find(|entry| Some(entry.number) == number);
    let entry = entry.ok_or_else(|| unknown("table", &arguments.table, TABLES.iter().map(|entry| entry.number), ""))?;
    let out = &arguments.out;
    files::prepare_folder(out)?;
    let cancel = cancel_on_interrupt();
    match (entry.compute)(&mut Task::new(Size::Full, &cancel, &mut |_, _| {})) {
        Ok(table) => {
            write_table(out, &table)?;
            if !arguments.quiet {
                say(&format!(
                    "Table {}: {}{}: written to {}",
                    entry.number,
                    entry.title,
                    findings_in_words(&table.findings),
                    out.display()
                ));
            }
            Ok(DONE)
        }
        Err(Stopped::Cancelled) => Ok(INTERRUPTED),
        Err(why) => {
            eprintln!("tackscope: Table {}: {why}", entry.number);
            Ok(NOT_CONVERGED)
        }
    }
}

fn write_table(out: &Path, table: &Table) -> Result<(), Failure> {
    let name = |end: &str| out.join(format!("table-{}.{end}", table.number));
    paint::write_table_csv(&name("csv"), table)?;
    paint::write_table_svg(&name("svg"), table)?;
    paint::write_table_png(&name("png"), table)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_decides_on_the_exit_code() {
        let failed = (5, Stopped::Failed("no convergence".to_owned()));
        let codes = [vec![], vec![failed.clone()], vec![failed, (6, Stopped::Cancelled)]].map(|missing| exit_code(&missing));
        assert_eq!(codes, [0, 3, 130]);
    }
}
