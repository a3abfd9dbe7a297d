//! A small map in every format of height files, written as their specifications say.

use ndarray::Array2;
use std::io::{Cursor, Write};

/// Side of the small map, in micrometres, and its points along a side.
pub const SIDE: f64 = 8.0;
pub const N: usize = 12;

/// A smooth map (micrometres) that whole nanometres tell exactly, without symmetry.
pub fn small_map() -> Array2<f64> {
    Array2::from_shape_fn((N, N), |(j, i)| {
        let turn = std::f64::consts::TAU / N as f64;
        let h = 0.4 * (turn * i as f64).cos() + 0.25 * (turn * (i as f64 + 2.0 * j as f64)).sin();
        (1000.0 * h).round() / 1000.0
    })
}

/// In whole nanometres.
pub fn nanometres() -> Vec<i32> {
    small_map()
        .iter()
        .map(|h| (1000.0 * h).round() as i32)
        .collect()
}

pub fn matrix(separator: &str, number: impl Fn(f64) -> String) -> String {
    let map = small_map();
    let rows = map.rows().into_iter().map(|row| {
        let cells: Vec<String> = row.iter().map(|h| number(*h)).collect();
        cells.join(separator) + "\n"
    });
    rows.collect()
}

pub fn csv() -> Vec<u8> {
    format!("# width = 8.0\n{}", matrix(",", |h| h.to_string())).into_bytes()
}

pub fn gwyddion() -> Vec<u8> {
    let head =
        "# Channel: Topography\n# Width: 8.0 \u{b5}m\n# Height: 8.0 \u{b5}m\n# Value units: m\n";
    format!("{head}{}", matrix("\t", |h| format!("{:e}", 1e-6 * h))).into_bytes()
}

pub fn decimal_commas() -> Vec<u8> {
    let commas = matrix("; ", |h| h.to_string().replace('.', ","));
    format!("width = 8,0 um\nHeights\n{commas}").into_bytes()
}

pub fn xyz() -> Vec<u8> {
    let map = small_map();
    let mut lines: Vec<String> = map
        .indexed_iter()
        .map(|((j, i), h)| {
            let [x, y] = [i, j].map(|k| 3.0 + (k as f64 + 0.5) * SIDE / N as f64);
            format!("{x:.6} {y:.6} {h}")
        })
        .collect();
    // In any order.
    lines.rotate_left(31);
    lines.swap(4, 60);
    format!("x y z\n{}\n", lines.join("\n")).into_bytes()
}

pub fn npy_of(values: &[f64], shape: &str, fortran: bool) -> Vec<u8> {
    let order = if fortran { "True" } else { "False" };
    let mut head = format!("{{'descr': '<f8', 'fortran_order': {order}, 'shape': {shape}, }}");
    while (10 + head.len() + 1) % 64 != 0 {
        head.push(' ');
    }
    head.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((head.len() as u16).to_le_bytes());
    bytes.extend(head.bytes());
    bytes.extend(values.iter().flat_map(|h| h.to_le_bytes()));
    bytes
}

pub fn npy() -> Vec<u8> {
    let turned: Vec<f64> = small_map().t().iter().copied().collect();
    npy_of(&turned, "(12, 12)", true)
}

pub fn zip(entries: &[(&str, Vec<u8>)], method: zip::CompressionMethod) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let options = zip::write::SimpleFileOptions::default().compression_method(method);
    for (name, bytes) in entries {
        archive.start_file(*name, options).unwrap();
        archive.write_all(bytes).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

pub fn npz() -> Vec<u8> {
    let heights: Vec<f64> = small_map().iter().copied().collect();
    let entries = [
        ("heights.npy", npy_of(&heights, "(12, 12)", false)),
        ("size.npy", npy_of(&[SIDE, SIDE], "(2,)", false)),
    ];
    zip(&entries, zip::CompressionMethod::Deflated)
}

pub fn x3p() -> Vec<u8> {
    let pitch = 1e-6 * SIDE / N as f64;
    let xml = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\
         <p:ISO5436_2 xmlns:p=\"http://www.opengps.eu/2008/ISO5436_2\"><Record1>\
         <Revision>ISO5436 - 2000</Revision><FeatureType>SUR</FeatureType><Axes>\
         <CX><AxisType>I</AxisType><DataType>D</DataType><Increment>{pitch}</Increment></CX>\
         <CY><AxisType>I</AxisType><DataType>D</DataType><Increment>{pitch}</Increment></CY>\
         <CZ><AxisType>A</AxisType><DataType>D</DataType></CZ></Axes></Record1><Record3>\
         <MatrixDimension><SizeX>{N}</SizeX><SizeY>{N}</SizeY><SizeZ>1</SizeZ></MatrixDimension>\
         <DataLink><PointDataLink>bindata/data.bin</PointDataLink></DataLink></Record3>\
         </p:ISO5436_2>"
    );
    let data = small_map()
        .iter()
        .flat_map(|h| (1e-6 * h).to_le_bytes())
        .collect();
    let entries = [("main.xml", xml.into_bytes()), ("bindata/data.bin", data)];
    zip(&entries, zip::CompressionMethod::Deflated)
}

pub fn put(bytes: &mut [u8], at: usize, value: &[u8]) {
    bytes[at..at + value.len()].copy_from_slice(value);
}

pub fn sur() -> Vec<u8> {
    let mut bytes = vec![0; 512];
    put(&mut bytes, 0, b"DIGITAL SURF");
    put(&mut bytes, 86, &1u16.to_le_bytes());
    put(&mut bytes, 98, &16u16.to_le_bytes());
    put(&mut bytes, 100, &(-700i32).to_le_bytes());
    put(&mut bytes, 104, &700i32.to_le_bytes());
    put(&mut bytes, 108, &(N as i32).to_le_bytes());
    put(&mut bytes, 112, &(N as i32).to_le_bytes());
    put(&mut bytes, 116, &((N * N) as u32).to_le_bytes());
    for at in [120, 124] {
        put(&mut bytes, at, &((SIDE / N as f64) as f32).to_le_bytes());
    }
    put(&mut bytes, 128, &1f32.to_le_bytes());
    for (at, unit) in [(180, b"\xb5m  "), (196, b"\xb5m  "), (212, b"nm  ")] {
        put(&mut bytes, at, unit);
    }
    put(&mut bytes, 334, &7u16.to_le_bytes());
    bytes.extend(b"comment");
    bytes.extend(nanometres().iter().flat_map(|h| (*h as i16).to_le_bytes()));
    bytes
}

pub fn sdf_text() -> Vec<u8> {
    let pitch = 1e-6 * SIDE / N as f64;
    let head = format!(
        "aISO-1.0\nManufacID = Tackscope\nNumPoints = {N}\nNumProfiles = {N}\nXscale = {pitch}\n\
         Yscale = {pitch}\nZscale = 1e-9\nZresolution = 0\nCompression = 0\nDataType = 6\n\
         CheckType = 0\n*\n"
    );
    let cells: Vec<String> = nanometres().iter().map(i32::to_string).collect();
    let rows: Vec<String> = cells.chunks(N).map(|row| row.join(" ")).collect();
    format!("{head}{}\n*\n", rows.join("\n")).into_bytes()
}

pub fn sdf_binary() -> Vec<u8> {
    let mut bytes = vec![b' '; 81];
    put(&mut bytes, 0, b"bISO-1.0");
    put(&mut bytes, 42, &(N as u16).to_le_bytes());
    put(&mut bytes, 44, &(N as u16).to_le_bytes());
    for (at, scale) in [
        (46, 1e-6 * SIDE / N as f64),
        (54, 1e-6 * SIDE / N as f64),
        (62, 1e-9),
        (70, 0.0),
    ] {
        put(&mut bytes, at, &scale.to_le_bytes());
    }
    put(&mut bytes, 78, &[0, 5, 0]);
    bytes.extend(nanometres().iter().flat_map(|h| (*h as i16).to_le_bytes()));
    bytes
}

/// NetCDF classic, written by hand: dimensions x and y, variables x, y and heights (x, y).
pub fn netcdf() -> Vec<u8> {
    let words = |bytes: &mut Vec<u8>, all: &[usize]| {
        bytes.extend(all.iter().flat_map(|n| (*n as u32).to_be_bytes()));
    };
    let word = |bytes: &mut Vec<u8>, n: usize| words(bytes, &[n]);
    let name = |bytes: &mut Vec<u8>, text: &str| {
        word(bytes, text.len());
        bytes.extend(text.bytes());
        bytes.resize(bytes.len().next_multiple_of(4), 0);
    };
    let mut bytes = b"CDF\x01".to_vec();
    word(&mut bytes, 0);
    words(&mut bytes, &[10, 2]);
    for axis in ["x", "y"] {
        name(&mut bytes, axis);
        word(&mut bytes, N);
    }
    words(&mut bytes, &[0, 0]);
    words(&mut bytes, &[11, 3]);
    let mut begins = Vec::new();
    for (variable, dimensions) in [("x", &[0][..]), ("y", &[1]), ("heights", &[0, 1])] {
        name(&mut bytes, variable);
        word(&mut bytes, dimensions.len());
        dimensions
            .iter()
            .for_each(|dimension| word(&mut bytes, *dimension));
        if variable == "heights" {
            words(&mut bytes, &[0, 0]);
        } else {
            words(&mut bytes, &[12, 2]);
            name(&mut bytes, "length");
            words(&mut bytes, &[6, 1]);
            bytes.extend(SIDE.to_be_bytes());
            name(&mut bytes, "length_unit");
            word(&mut bytes, 2);
            name(&mut bytes, "um");
        }
        word(&mut bytes, 6);
        let count = if variable == "heights" { N * N } else { N };
        word(&mut bytes, 8 * count);
        begins.push((bytes.len(), count));
        word(&mut bytes, 0);
    }
    let heights = small_map();
    for (at, count) in begins {
        let here = bytes.len();
        put(&mut bytes, at, &(here as u32).to_be_bytes());
        let values: Vec<f64> = if count == N {
            (0..N).map(|i| (i as f64 + 0.5) * SIDE / N as f64).collect()
        } else {
            heights.t().iter().copied().collect()
        };
        bytes.extend(values.iter().flat_map(|value| value.to_be_bytes()));
    }
    bytes
}
