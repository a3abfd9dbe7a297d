//! Heights in binary files: numpy, Digital Surf, ISO 25178-71 and -72, NetCDF.

use super::{Fault, Map, metres, points};
use crate::physics::topography::Unit;
use crate::storage::files;
use netcdf_reader::NcFile;
use npyz::{NpyFile, Order};
use roxmltree::{Document, Node};
use std::io::Cursor;
use zip::ZipArchive;

/// An array of numpy: one row is a profile.
pub(super) fn npy(bytes: &[u8]) -> Result<Map, Fault> {
    let (sides, values) = array(bytes)?;
    Map::new("NPY", sides, values, None, Unit::Scene)
}

/// Columns, rows and values of an array, whatever its order.
fn array(bytes: &[u8]) -> Result<([usize; 2], Vec<f64>), Fault> {
    let file = NpyFile::new(bytes).map_err(|error| Fault::broken(error.to_string()))?;
    let shape: Vec<usize> = file.shape().iter().map(|n| *n as usize).collect();
    let (ny, nx) = match shape[..] {
        [nx] => (1, nx),
        [ny, nx] => (ny, nx),
        _ => {
            let reason = format!("an array of the shape {shape:?}");
            return Err(Fault::new(reason, "save one of the shape (rows, columns)"));
        }
    };
    points(nx, ny)?;
    let fortran = file.order() == Order::Fortran;
    let dtype = file.dtype().descr();
    macro_rules! first_of {
        ($($number:ty, $real:expr;)*) => {
            $(if let Ok(values) = NpyFile::new(bytes).expect("as above").data::<$number>() {
                values.map(|value| value.map($real)).collect::<Result<Vec<f64>, _>>()
            } else)* {
                let reason = format!("an array of the type {dtype}");
                return Err(Fault::new(reason, "save real numbers, as float64"));
            }
        };
    }
    let values = first_of! {
        f64, |x| x; f32, f64::from; i32, f64::from; i16, f64::from; i8, f64::from;
        u32, f64::from; u16, f64::from; u8, f64::from;
        i64, |x| x as f64; u64, |x| x as f64;
    };
    let values = values.map_err(|error| Fault::broken(error.to_string()))?;
    let turned = |k: usize| values[(k % nx) * ny + k / nx];
    let values = if fortran && values.len() == nx * ny {
        (0..nx * ny).map(turned).collect()
    } else {
        values
    };
    Ok(([nx, ny], values))
}

type Archive<'a> = ZipArchive<Cursor<&'a [u8]>>;

/// An NPZ or an X3P.
pub(super) fn zipped(bytes: &[u8]) -> Result<Map, Fault> {
    let broken = |error: zip::result::ZipError| Fault::broken(error.to_string());
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(broken)?;
    let names = archive.file_names().map(|name| name.map(String::from));
    let names: Vec<String> = names.collect::<Result<_, _>>().map_err(broken)?;
    if names.iter().any(|name| name == "main.xml") {
        return x3p(&mut archive);
    }
    let known = ["heights.npy", "height.npy", "z.npy"];
    let name = known
        .into_iter()
        .find(|known| names.iter().any(|name| name == known));
    let name = name.or(match &names[..] {
        [only] if only.ends_with(".npy") => Some(only),
        _ => None,
    });
    let Some(name) = name else {
        let reason = format!("no array heights among {}", names.join(", "));
        return Err(Fault::new(
            reason,
            "save the heights as np.savez(file, heights=h)",
        ));
    };
    let (sides, values) = array(&entry(&mut archive, name)?)?;
    let size = if names.iter().any(|name| name == "size.npy") {
        match array_of_sizes(&entry(&mut archive, "size.npy")?)?[..] {
            [x] => Some([x, x * sides[1] as f64 / sides[0] as f64]),
            [x, y] => Some([x, y]),
            _ => return Err(Fault::broken("size is neither one number nor two")),
        }
    } else {
        None
    };
    Map::new("NPZ", sides, values, size, Unit::Scene)
}

/// One number, or a few.
fn array_of_sizes(bytes: &[u8]) -> Result<Vec<f64>, Fault> {
    let file = NpyFile::new(bytes).map_err(|error| Fault::broken(error.to_string()))?;
    let values = file.into_vec::<f64>();
    values.map_err(|error| Fault::new(format!("size: {error}"), "save size as float64"))
}

/// The bytes of an entry, not more than its map may have.
fn entry(archive: &mut Archive<'_>, name: &str) -> Result<Vec<u8>, Fault> {
    files::member(archive, name, super::BYTES_MAX).map_err(Fault::broken)
}

/// ISO 25178-72: `main.xml` tells the grid in metres, and where the heights are.
fn x3p(archive: &mut Archive<'_>) -> Result<Map, Fault> {
    let xml = String::from_utf8(entry(archive, "main.xml")?)
        .map_err(|_| Fault::broken("main.xml is not UTF-8"))?;
    let document = Document::parse(&xml).map_err(|e| Fault::broken(format!("main.xml: {e}")))?;
    let find = |path: &str| {
        path.split('/')
            .try_fold(document.root_element(), |node, name| {
                node.children()
                    .find(|child| child.tag_name().name() == name)
            })
    };
    let text = |path: &str| find(path).as_ref().and_then(Node::text).map(str::trim);
    let number = |path: &str| -> Result<f64, Fault> {
        let word = text(path);
        word.and_then(|word| word.parse().ok()).ok_or_else(|| {
            let found = word.unwrap_or("nothing");
            Fault::broken(format!("main.xml: {path} is \"{found}\", not a number"))
        })
    };
    if text("Record1/FeatureType") != Some("SUR") {
        let found = text("Record1/FeatureType").unwrap_or("nothing");
        let reason = format!("main.xml: FeatureType is \"{found}\"");
        return Err(Fault::new(
            reason,
            "export a surface (SUR) on a regular grid",
        ));
    }
    let sides = [
        number("Record3/MatrixDimension/SizeX")? as usize,
        number("Record3/MatrixDimension/SizeY")? as usize,
    ];
    let count = points(sides[0], sides[1])?;
    let pitch = [
        number("Record1/Axes/CX/Increment")?,
        number("Record1/Axes/CY/Increment")?,
    ];
    // Heights of a floating type may come without a step.
    let step = text("Record1/Axes/CZ/Increment")
        .and_then(|word| word.parse().ok())
        .unwrap_or(1.0);
    let link = text("Record3/DataLink/PointDataLink")
        .ok_or_else(|| Fault::new("main.xml has no PointDataLink", "export heights as binary"))?;
    let data = Bytes(&entry(archive, link)?);
    let kind = text("Record1/Axes/CZ/DataType").unwrap_or_default();
    let number = match kind {
        "I" => U16,
        "L" => U32,
        "F" => F32,
        "D" => F64,
        other => return Err(Fault::broken(format!("main.xml: DataType is \"{other}\""))),
    };
    let mut heights = data.numbers(0, number, count)?;
    if let Some(valid) = text("Record3/DataLink/ValidPointsLink") {
        // One bit a point, the lowest first.
        let bits = entry(archive, valid)?;
        let is_valid = |k: usize| bits.get(k / 8).is_none_or(|byte| byte >> (k % 8) & 1 == 1);
        for (k, height) in heights.iter_mut().enumerate() {
            *height = if is_valid(k) { *height } else { f64::NAN };
        }
    }
    heights.iter_mut().for_each(|height| *height *= step);
    let size = [pitch[0] * sides[0] as f64, pitch[1] * sides[1] as f64];
    Map::new("X3P", sides, heights, Some(size), Unit::Metre)
}

/// A kind of number in a file, least byte first.
#[derive(Clone, Copy)]
struct Number {
    bytes: usize,
    read: fn(&[u8]) -> f64,
}

macro_rules! numbers {
    ($($name:ident: $kind:ty),*) => {
        $(const $name: Number = Number {
            bytes: size_of::<$kind>(),
            read: |b| f64::from(<$kind>::from_le_bytes(b.try_into().expect("of so many bytes"))),
        };)*
    };
}
numbers! { I8: i8, U8: u8, I16: i16, U16: u16, I32: i32, U32: u32, F32: f32, F64: f64 }

/// A file as bytes.
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    /// So many numbers from a place on.
    fn numbers(&self, at: usize, kind: Number, count: usize) -> Result<Vec<f64>, Fault> {
        let Number { bytes: size, read } = kind;
        let end = count
            .checked_mul(size)
            .and_then(|length| at.checked_add(length));
        let bytes = end.and_then(|end| self.0.get(at..end)).ok_or_else(|| {
            let have = self.0.len();
            Fault::broken(format!(
                "it ends at byte {have}, within {count} numbers from byte {at}"
            ))
        })?;
        Ok(bytes.chunks_exact(size).map(read).collect())
    }

    fn number(&self, at: usize, kind: Number) -> Result<f64, Fault> {
        Ok(self.numbers(at, kind, 1)?[0])
    }

    /// A word of Latin-1, padded with blanks or zeros.
    fn word(&self, at: usize, length: usize) -> String {
        let bytes = self.0.get(at..at + length).unwrap_or_default();
        let word: String = bytes.iter().map(|byte| char::from(*byte)).collect();
        word.trim_matches([' ', '\0']).to_owned()
    }
}

/// Digital Surf: a header of 512 bytes, a comment, whole numbers.
pub(super) fn sur(bytes: &[u8]) -> Result<Map, Fault> {
    let file = Bytes(bytes);
    let whole = |at: usize| file.number(at, I32).map(|n| n.max(0.0) as usize);
    let short = |at: usize| file.number(at, U16);
    let sides = [whole(108)?, whole(112)?];
    let count = points(sides[0], sides[1])?;
    let unit = |at: usize| {
        let word = file.word(at, 16);
        metres(&word).ok_or_else(|| {
            Fault::new(
                format!("the unit \"{word}\" is not known"),
                "save it in um, nm, mm or m",
            )
        })
    };
    let scale = |at: usize, units: usize| Ok::<_, Fault>(file.number(at, F32)? * unit(units)?);
    let [dx, dy, dz] = [scale(120, 180)?, scale(124, 196)?, scale(128, 212)?];
    let kind = match short(98)? {
        16.0 => I16,
        32.0 => I32,
        other => {
            return Err(Fault::broken(format!(
                "heights of {other} bits, not 16 or 32"
            )));
        }
    };
    let data = 512 + short(334)? as usize + short(336)? as usize;
    // With special points, two below the least height says that nothing was measured.
    let unmeasured = file.number(100, I32)? - 2.0;
    let special = short(86)? == 1.0;
    let height = |z: f64| {
        if special && z == unmeasured {
            f64::NAN
        } else {
            dz * z
        }
    };
    let heights = file.numbers(data, kind, count)?.into_iter().map(height);
    let size = [dx * sides[0] as f64, dy * sides[1] as f64];
    Map::new(
        "Digital Surf",
        sides,
        heights.collect(),
        Some(size),
        Unit::Metre,
    )
}

/// ISO 25178-71, binary: a header of 81 bytes.
pub(super) fn sdf(bytes: &[u8]) -> Result<Map, Fault> {
    let file = Bytes(bytes);
    let sides = [42, 44].map(|at| file.number(at, U16));
    let [nx, ny] = sides;
    let sides = [nx? as usize, ny? as usize];
    let scale = |at: usize| file.number(at, F64);
    let [dx, dy, dz] = [scale(46)?, scale(54)?, scale(62)?];
    if file.number(78, U8)? != 0.0 {
        return Err(Fault::new(
            "it is compressed",
            "save it without compression",
        ));
    }
    // The value that says that nothing was measured, of whole numbers.
    let (kind, unmeasured) = match file.number(79, U8)? {
        0.0 => (U8, f64::NAN),
        1.0 => (U16, f64::from(u16::MAX)),
        2.0 => (U32, f64::from(u32::MAX)),
        3.0 => (F32, f64::NAN),
        4.0 => (I8, f64::NAN),
        5.0 => (I16, f64::from(i16::MIN)),
        6.0 => (I32, f64::from(i32::MIN)),
        7.0 => (F64, f64::NAN),
        other => {
            return Err(Fault::broken(format!(
                "heights of the type {other}, not 0 to 7"
            )));
        }
    };
    let height = |z: f64| if z == unmeasured { f64::NAN } else { dz * z };
    let heights = file
        .numbers(81, kind, points(sides[0], sides[1])?)?
        .into_iter()
        .map(height);
    let size = [dx * sides[0] as f64, dy * sides[1] as f64];
    Map::new("SDF", sides, heights.collect(), Some(size), Unit::Metre)
}

/// NetCDF classic with `heights` over (x, y), the attributes `length` and `length_unit` at the
/// variables `x` and `y`.
pub(super) fn netcdf(bytes: &[u8]) -> Result<Map, Fault> {
    let broken = |error: netcdf_reader::Error| Fault::broken(error.to_string());
    let file = NcFile::from_bytes(bytes).map_err(broken)?;
    let remedy = "save it by SurfaceTopography's to_netcdf, or as NPY";
    let variable = file
        .variable("heights")
        .map_err(|_| Fault::new("it has no variable heights", remedy))?;
    let shape: Vec<usize> = variable.shape().iter().map(|n| *n as usize).collect();
    let (nx, ny) = match shape[..] {
        [nx] => (nx, 1),
        [nx, ny] => (nx, ny),
        _ => {
            return Err(Fault::new(
                format!("heights of the shape {shape:?}"),
                remedy,
            ));
        }
    };
    let count = points(nx, ny)?;
    let values = file.read_variable_masked("heights").map_err(broken)?;
    let values: Vec<f64> = values.iter().copied().collect();
    if values.len() != count {
        return Err(Fault::broken(format!(
            "{} heights of {nx} x {ny}",
            values.len()
        )));
    }
    let said = |axis: &str, key: &str| {
        let variable = file.variable(axis).ok()?;
        variable
            .attribute(key)
            .map(|attribute| attribute.value.clone())
    };
    let side = |axis: &str| said(axis, "length").and_then(|value| value.as_f64());
    let unit = said("x", "length_unit").and_then(|value| metres(&value.as_string()?));
    let factor = unit.unwrap_or(1.0);
    let x = side("x").map(|x| factor * x);
    let size = x.map(|x| [x, side("y").map_or(x, |y| factor * y)]);
    let turned = |k: usize| factor * values[(k % nx) * ny + k / nx];
    let heights = (0..count).map(turned).collect();
    let unit = if unit.is_some() {
        Unit::Metre
    } else {
        Unit::Scene
    };
    Map::new("NetCDF", [nx, ny], heights, size, unit)
}
