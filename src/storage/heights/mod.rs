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

use super::{Failure, files};
use crate::physics::topography::{Topography, Unit};
use ndarray::Array2;
use std::collections::HashMap;
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
            sdf(words)
        } else {
            table(words)
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

/// Words for what was not measured.
const MISSING: [&str; 9] = ["", "nan", "bad", "***", "-", "--", "na", "masked", "nodata"];

/// How far a place may be from the regular grid, as a share of its spacing.
const OFF_GRID: f64 = 0.05;

/// Remedy of a cell that is no number.
const CELLS: &str = "write numbers as in -1.5e-3, and NaN where nothing was measured";

/// A row of the table with its line, from 1.
type Row = (usize, Vec<f64>);

/// What a header says, by lower-case keys.
type Header = HashMap<String, String>;

/// A matrix, or places and heights in columns.
fn table(words: &str) -> Result<Map, Fault> {
    let (header, rows) = rows(words)?;
    let Some((first, columns)) = rows.first().map(|(line, cells)| (*line, cells.len())) else {
        let remedy = "give a matrix of heights, or columns x, y, height";
        return Err(Fault::new("there is not one number in it", remedy));
    };
    if let Some((line, cells)) = rows.iter().find(|(_, cells)| cells.len() != columns) {
        let reason = format!(
            "line {line} has {} numbers where line {first} has {columns}",
            cells.len()
        );
        return Err(Fault::new(
            reason,
            "give every row as many, with one separator",
        ));
    }
    let (lateral, vertical, unit) = units(&header)?;
    let scaled = |size: [f64; 2]| size.map(|side| side * lateral);
    match columns {
        1 => {
            let column = rows.iter().map(|(_, cells)| vertical * cells[0]).collect();
            let size = size(&header)?;
            Map::new("text, a profile", [rows.len(), 1], column, size, unit)
        }
        2 | 3 if rows.len() > 1 => {
            let x = Axis::of(&rows, 0)?;
            let y = if columns == 3 {
                Axis::of(&rows, 1)?
            } else {
                Axis::single(rows.len())
            };
            let mut heights = vec![f64::NAN; points(x.count, y.count)?];
            for (row, (line, cells)) in rows.iter().enumerate() {
                let place = &mut heights[y.places[row] * x.count + x.places[row]];
                if place.is_finite() {
                    let reason = format!("line {line}: a second height at the same place");
                    return Err(Fault::new(reason, "give each place once"));
                }
                *place = vertical * cells[columns - 1];
            }
            let size = scaled([x.size(), y.size()]);
            let size = if columns == 3 { size } else { [size[0]; 2] };
            Map::new(
                "text, places and heights",
                [x.count, y.count],
                heights,
                Some(size),
                unit,
            )
        }
        _ => {
            points(columns, rows.len())?;
            let matrix = rows.iter().flat_map(|(_, cells)| cells);
            let matrix = matrix.map(|h| vertical * h).collect();
            let size = size(&header)?;
            Map::new("text, a matrix", [columns, rows.len()], matrix, size, unit)
        }
    }
}

/// The header's words, and every row of numbers. Lines before the first number are a header, and
/// so is what follows a # or %.
fn rows(words: &str) -> Result<(Header, Vec<Row>), Fault> {
    let (mut header, mut rows) = (Header::new(), Vec::<Row>::new());
    let mut separator = None;
    for (at, line) in words.trim_start_matches('\u{feff}').lines().enumerate() {
        let line = line.trim_matches([' ', '\r']);
        let said = line.trim_start_matches(['#', '%', ';', ' ']);
        let commented = line.starts_with(['#', '%']);
        if line.trim().is_empty() {
            continue;
        }
        let split = separator.unwrap_or_else(|| separator_of(line));
        let cells = cells(line, split);
        let is_number = |cell: &&str| number(cell, split).is_some();
        if commented || rows.is_empty() && !cells.first().is_some_and(is_number) {
            if let Some((key, value)) = said.split_once([':', '=']) {
                header.insert(key.trim().to_lowercase(), value.trim().to_owned());
            }
            continue;
        }
        separator = Some(split);
        let numbers = cells.iter().enumerate().map(|(column, cell)| {
            number(cell, split).ok_or_else(|| {
                let cell: String = cell.chars().take(20).collect();
                let (line, column) = (at + 1, column + 1);
                let reason = format!("line {line}, column {column}: \"{cell}\" is no number");
                Fault::new(reason, CELLS)
            })
        });
        rows.push((at + 1, numbers.collect::<Result<_, _>>()?));
        points(rows[0].1.len(), rows.len())?;
    }
    Ok((header, rows))
}

/// What stands between the numbers of a line: a semicolon, a tabulator or a comma, or else blanks.
/// Commas inside of words that blanks part are decimal commas.
fn separator_of(line: &str) -> char {
    let mut words = line.split_whitespace();
    let decimal = words.clone().count() > 1 && words.all(|word| !word.ends_with(','));
    let known = [';', '\t', ','].into_iter();
    let mut known = known.filter(|sign| line.contains(*sign) && !(*sign == ',' && decimal));
    known.next().unwrap_or(' ')
}

fn cells(line: &str, separator: char) -> Vec<&str> {
    if separator == ' ' {
        return line.split_whitespace().collect();
    }
    let mut cells: Vec<&str> = line.split(separator).map(str::trim).collect();
    // Some programs end each row with one.
    if cells.len() > 1 && cells.last() == Some(&"") {
        cells.pop();
    }
    cells
}

/// A number, NaN for what was not measured; with a decimal comma where commas part nothing.
fn number(cell: &str, separator: char) -> Option<f64> {
    if MISSING.contains(&cell.to_lowercase().as_str()) {
        return Some(f64::NAN);
    }
    let cell = if separator == ',' {
        cell.to_owned()
    } else {
        cell.replace(',', ".")
    };
    cell.parse().ok()
}

/// A length and its unit, as in `10.0 um`.
fn length(word: &str) -> Result<(f64, Option<f64>), Fault> {
    let end = word.find(|c: char| c.is_whitespace()).unwrap_or(word.len());
    let (number, unit) = word.split_at(end);
    let number = number.replace(',', ".").parse().map_err(|_| {
        let reason = format!("\"{word}\" in the header is no length");
        Fault::new(reason, "write it as in: # width = 10.0 um")
    })?;
    let unit = unit.trim();
    let known = metres(unit);
    if !unit.is_empty() && known.is_none() {
        let reason = format!("the unit \"{unit}\" in the header is not known");
        return Err(Fault::new(reason, "write m, mm, um, nm, pm or A"));
    }
    Ok((number, known))
}

/// Sides by `width` and `height` (which is a square's width where it is missing), in metres if they
/// have a unit.
fn size(header: &Header) -> Result<Option<[f64; 2]>, Fault> {
    let Some(width) = header.get("width") else {
        return Ok(None);
    };
    let (lateral, ..) = units(header)?;
    let side = |word: &str| {
        let (number, unit) = length(word)?;
        Ok::<_, Fault>(number * unit.unwrap_or(lateral))
    };
    let x = side(width)?;
    Ok(Some([
        x,
        header.get("height").map_or(Ok(x), |word| side(word))?,
    ]))
}

/// Metres in a number along x, in a height, and whether any unit was told: by `unit`, by that of
/// `width`, and for heights by `value units`.
fn units(header: &Header) -> Result<(f64, f64, Unit), Fault> {
    let told = |key: &str| {
        let word = header.get(key);
        word.map(|unit| Ok::<_, Fault>(length(&format!("1 {unit}"))?.1))
            .transpose()
    };
    let of_width = header.get("width").map(|word| length(word)).transpose()?;
    let lateral = told("unit")?
        .flatten()
        .or(of_width.and_then(|(_, unit)| unit));
    let vertical = told("value units")?.flatten().or(lateral);
    Ok(match (lateral, vertical) {
        (Some(lateral), Some(vertical)) => (lateral, vertical, Unit::Metre),
        _ => (1.0, 1.0, Unit::Scene),
    })
}

/// The regular grid of one coordinate, and where each row lies on it.
struct Axis {
    count: usize,
    pitch: f64,
    places: Vec<usize>,
}

impl Axis {
    fn of(rows: &[Row], column: usize) -> Result<Self, Fault> {
        let name = ["x", "y"][column];
        let remedy = "give heights at equal steps of x and of y, in any order";
        let at = |row: &Row| row.1[column];
        if let Some((line, _)) = rows.iter().find(|row| !at(row).is_finite()) {
            return Err(Fault::new(
                format!("line {line}: {name} is not given"),
                remedy,
            ));
        }
        let mut sorted: Vec<f64> = rows.iter().map(at).collect();
        sorted.sort_by(f64::total_cmp);
        let (low, span) = (sorted[0], sorted[sorted.len() - 1] - sorted[0]);
        // What differs by less is the same place, written with few digits.
        let same = span * 0.1 / sorted.len() as f64;
        let steps = sorted.windows(2).map(|pair| pair[1] - pair[0]);
        let least = steps
            .filter(|step| *step > same)
            .fold(f64::INFINITY, f64::min);
        if !least.is_finite() {
            return Ok(Self::single(rows.len()));
        }
        let count = (span / least).round() as usize + 1;
        let pitch = span / (count - 1) as f64;
        let place = |row: &Row| {
            let exact = (at(row) - low) / pitch;
            if (exact - exact.round()).abs() <= OFF_GRID {
                return Ok(exact.round() as usize);
            }
            let (line, x) = (row.0, at(row));
            let reason =
                format!("line {line}: {name} = {x} is not on the grid of {count} steps of {pitch}");
            Err(Fault::new(reason, remedy))
        };
        Ok(Self {
            places: rows.iter().map(place).collect::<Result<_, _>>()?,
            count,
            pitch,
        })
    }

    /// One place.
    fn single(rows: usize) -> Self {
        Self {
            count: 1,
            pitch: 1.0,
            places: vec![0; rows],
        }
    }

    fn size(&self) -> f64 {
        self.count as f64 * self.pitch
    }
}

/// ISO 25178-71 as text: a header of `key = value` up to an asterisk, the heights row by row, an
/// asterisk.
fn sdf(words: &str) -> Result<Map, Fault> {
    let (head, rest) = words.split_once('*').unwrap_or((words, ""));
    let mut header = Header::new();
    for line in head.lines() {
        if let Some((key, value)) = line.split_once('=') {
            header.insert(key.trim().to_lowercase(), value.trim().to_owned());
        }
    }
    let value = |key: &str| -> Result<f64, Fault> {
        let word = header.get(&key.to_lowercase());
        let number = word.and_then(|word| word.parse().ok());
        number.ok_or_else(|| {
            let found = word.map_or("nothing", String::as_str);
            Fault::broken(format!("{key} in the header: \"{found}\" is no number"))
        })
    };
    let sides = [value("NumPoints")? as usize, value("NumProfiles")? as usize];
    let [dx, dy, dz] = [value("Xscale")?, value("Yscale")?, value("Zscale")?];
    let wanted = points(sides[0], sides[1])?;
    let data = rest.split('*').next().unwrap_or_default();
    // The rest of the asterisk's own line comes first.
    let first = head.lines().count() + 1;
    let mut heights = Vec::with_capacity(wanted);
    for (at, line) in data.lines().enumerate() {
        for (column, word) in line.split_whitespace().enumerate() {
            let height = number(word, ',').ok_or_else(|| {
                let (line, column) = (first + at, column + 1);
                let reason = format!("line {line}, column {column}: \"{word}\" is no number");
                Fault::new(reason, "write numbers, and BAD where nothing was measured")
            })?;
            heights.push(dz * height);
        }
    }
    let size = Some([dx * sides[0] as f64, dy * sides[1] as f64]);
    Map::new("SDF", sides, heights, size, Unit::Metre)
}
