//! Height files: measured topographies, told apart by their content.
//!
//! | format | told by | size and unit |
//! |---|---|---|
//! | text | anything that is UTF-8: a matrix, or columns x, z or x, y, z on a regular grid | of the header, as Gwyddion writes it, or of x and y |
//! | NPY, NPZ | numpy's signature, `heights.npy` in a zip | `size` in the NPZ |
//! | SUR | `DIGITAL SURF`, not compressed | both |
//! | SDF | ISO 25178-71, text or binary, also as `BCR` | metres |
//! | X3P | ISO 25178-72, `main.xml` in a zip | metres |
//! | NetCDF | classic, `heights` as SurfaceTopography writes it | both, if given |

mod binary;
mod text;

use super::{Failure, files};
use crate::physics::topography::{Topography, Unit};
use ndarray::Array2;
use std::path::Path;

/// Longest height file that is read, in bytes.
pub(super) const BYTES_MAX: u64 = 1 << 28;

/// Most points of a map: their waves take the memory of sixteen such maps.
const POINTS_MAX: usize = 1 << 22;

/// What is wrong with the content of a file, and how to mend it.
struct Fault {
    reason: String,
    remedy: &'static str,
}

/// Remedy where a file does not hold what its format promises.
const BROKEN: &str = "write it anew with the program that made it, or as text or NPY";

impl Fault {
    fn new(reason: impl Into<String>, remedy: &'static str) -> Self {
        let reason = reason.into();
        Self { reason, remedy }
    }

    /// Of a file that is broken.
    fn broken(reason: impl Into<String>) -> Self {
        Self::new(reason, BROKEN)
    }
}

/// What a file holds.
struct Map {
    format: &'static str,
    heights: Array2<f64>,
    size: Option<[f64; 2]>,
    unit: Unit,
}

impl Map {
    /// `values` row by row, `ny` rows of `nx`.
    fn new(
        format: &'static str,
        [nx, ny]: [usize; 2],
        values: Vec<f64>,
        size: Option<[f64; 2]>,
        unit: Unit,
    ) -> Result<Self, Fault> {
        let count = values.len();
        let heights = Array2::from_shape_vec((ny, nx), values)
            .map_err(|_| Fault::broken(format!("{count} heights of {nx} x {ny} points")))?;
        if size.is_some_and(|sides| sides.iter().any(|side| !(side.is_normal() && *side > 0.0))) {
            return Err(Fault::broken(format!(
                "sides of {:?}",
                size.unwrap_or_default()
            )));
        }
        Ok(Self {
            format,
            heights,
            size,
            unit,
        })
    }
}

/// Number of points of a map that may be read.
fn points(nx: usize, ny: usize) -> Result<usize, Fault> {
    match nx.checked_mul(ny) {
        Some(0) => Err(Fault::broken("it has no points")),
        Some(n) if n <= POINTS_MAX => Ok(n),
        _ => Err(Fault::new(
            format!("{nx} x {ny} points, more than {POINTS_MAX}"),
            "cut a part out of it, or thin it out",
        )),
    }
}

/// Reads a height file.
///
/// # Errors
/// A file that cannot be read, is of no known format, or is broken: with the place and what was
/// expected there.
pub fn read(path: &Path) -> Result<Topography, Failure> {
    of_bytes(path, &files::read_regular(path, BYTES_MAX)?)
}

/// The heights in the bytes of a file.
pub(super) fn of_bytes(path: &Path, bytes: &[u8]) -> Result<Topography, Failure> {
    let map =
        map_of(bytes).map_err(|fault| Failure::unreadable(path, &fault.reason, fault.remedy))?;
    Ok(Topography {
        file: std::path::absolute(path).unwrap_or_else(|_| path.to_owned()),
        format: map.format,
        heights: map.heights,
        size: map.size,
        unit: map.unit,
    })
}

fn map_of(bytes: &[u8]) -> Result<Map, Fault> {
    let begins = |magic: &[u8]| bytes.starts_with(magic);
    if begins(b"\x93NUMPY") {
        binary::npy(bytes)
    } else if begins(b"PK\x03\x04") {
        binary::zipped(bytes)
    } else if begins(b"DIGITAL SURF") {
        binary::sur(bytes)
    } else if begins(b"bISO-1.0") || begins(b"bBCR-1.0") {
        binary::sdf(bytes)
    } else if begins(b"CDF") {
        binary::netcdf(bytes)
    } else if begins(b"DSCOMPRESSED") || begins(b"\x89HDF") {
        let reason = "a compressed Digital Surf file, or HDF5 (NetCDF-4)";
        Err(Fault::new(
            reason,
            "save it without compression, as X3P, NetCDF classic or NPY",
        ))
    } else {
        let words = std::str::from_utf8(bytes).map_err(|_| {
            let reason =
                "no known format of heights: text, NPY, NPZ, SUR, SDF, X3P, NetCDF classic";
            Fault::new(reason, "save it as one of them; text must be UTF-8")
        })?;
        let first = words.lines().next().unwrap_or_default().trim();
        if first == "aISO-1.0" || first == "aBCR-1.0" {
            text::sdf(words)
        } else {
            text::table(words)
        }
    }
}

/// A unit of length in metres.
fn metres(word: &str) -> Option<f64> {
    Some(match word.trim() {
        "m" => 1.0,
        "cm" => 1e-2,
        "mm" => 1e-3,
        "um" | "\u{b5}m" | "\u{3bc}m" | "micron" | "~m" => 1e-6,
        "nm" => 1e-9,
        "pm" => 1e-12,
        "A" | "\u{c5}" | "\u{212b}" => 1e-10,
        _ => return None,
    })
}
