//! The ground as tables: its numbers, its spectrum, its heights as a height file.

use super::{number, push_row, write_rows};
use crate::physics::topography::Statistics;
use crate::storage::summary::{Number, write_json};
use crate::storage::{Failure, files};
use crate::study::ground::GroundReport;
use serde::Serialize;
use std::path::Path;

/// First line of `spectrum.csv`.
pub const SPECTRUM_COLUMNS: &str = "wave_number,power";

/// `ground.json`.
#[derive(Serialize)]
struct Told<'a> {
    /// Root mean squares of the ground on the mesh, which is periodic.
    mesh: Numbers,
    /// The file, if the ground was measured.
    file: Option<File<'a>>,
    /// Wave numbers (1/length) that cut the spectrum off.
    cutoffs: serde_json::Map<String, serde_json::Value>,
    /// Of lengths, where it is known.
    unit: Option<&'static str>,
    warnings: &'a [String],
}

/// Named as SurfaceTopography's.
#[derive(Serialize)]
struct Numbers {
    rms_height_from_area: Number,
    rms_gradient: Number,
    rms_laplacian: Number,
    rms_curvature_from_area: Number,
    span: Number,
}

#[derive(Serialize)]
struct File<'a> {
    path: &'a str,
    format: &'static str,
    points: [usize; 2],
    side: f64,
    filled_points: usize,
    points_outside_the_square: usize,
    /// Before it was made periodic.
    before: Numbers,
    /// One period.
    after: Numbers,
}

impl Numbers {
    fn of(statistics: &Statistics) -> Self {
        Self {
            rms_height_from_area: Number(statistics.height),
            rms_gradient: Number(statistics.gradient),
            rms_laplacian: Number(statistics.laplacian),
            rms_curvature_from_area: Number(0.5 * statistics.laplacian),
            span: Number(statistics.span),
        }
    }
}

/// Writes the numbers as JSON.
///
/// # Errors
/// A file that cannot be written.
pub fn write_ground_json(path: &Path, report: &GroundReport) -> Result<(), Failure> {
    let file = report.file.as_ref().map(|file| File {
        path: &file.path,
        format: file.format,
        points: file.points,
        side: file.side,
        filled_points: file.filled,
        points_outside_the_square: file.cut,
        before: Numbers::of(&file.before),
        after: Numbers::of(&file.after),
    });
    let cutoffs = report.cutoffs.iter();
    let told = Told {
        mesh: Numbers::of(&report.cell),
        file,
        unit: report.unit,
        cutoffs: cutoffs
            .map(|(name, q)| ((*name).to_owned(), (*q).into()))
            .collect(),
        warnings: &report.words,
    };
    write_json(path, &told)
}

/// Writes the power spectrum by rings.
///
/// # Errors
/// A file that cannot be written.
pub fn write_spectrum_csv(path: &Path, report: &GroundReport) -> Result<(), Failure> {
    let row = |[q, power]: &[f64; 2]| vec![number(*q), number(*power)];
    write_rows(path, SPECTRUM_COLUMNS, report.spectrum.iter().map(row))
}

/// Writes the heights above the mean as a height file: a matrix, the first row at y = 0, with its
/// side in the header.
///
/// # Errors
/// A file that cannot be written.
pub fn write_heights_csv(path: &Path, report: &GroundReport) -> Result<(), Failure> {
    let mut text = format!("# width = {}\n", number(report.grid.length));
    for row in report.height.rows() {
        let cells: Vec<String> = row.iter().map(|h| number(*h)).collect();
        push_row(&mut text, &cells);
    }
    files::write_whole(path, text.as_bytes())
}
