//! Height files of every format, written here as their specifications say, through the reader to a
//! loop; and built-in ground that is written to a file and read back.

use ndarray::Array2;
use std::fs;
use std::io::{Cursor, Write};
use std::path::Path;
use tackscope::follow::run::{LoopRun, Outcome};
use tackscope::numerics::cancel::Cancel;
use tackscope::scene::{Points, Scene};
use tackscope::solver::methods::MethodKind;
use tackscope::storage::heights::read;
use tackscope::storage::{Opened, export, open, presets, scene_file};
use tackscope::study::ground::GroundReport;
use tackscope::study::plan::{plan, run_planned};

/// Side of the small map, in micrometres, and its points along a side.
const SIDE: f64 = 8.0;
const N: usize = 12;

/// A smooth map (micrometres) that whole nanometres tell exactly, without symmetry.
fn small_map() -> Array2<f64> {
    Array2::from_shape_fn((N, N), |(j, i)| {
        let turn = std::f64::consts::TAU / N as f64;
        let h = 0.4 * (turn * i as f64).cos() + 0.25 * (turn * (i as f64 + 2.0 * j as f64)).sin();
        (1000.0 * h).round() / 1000.0
    })
}

/// In whole nanometres.
fn nanometres() -> Vec<i32> {
    small_map()
        .iter()
        .map(|h| (1000.0 * h).round() as i32)
        .collect()
}

fn matrix(separator: &str, number: impl Fn(f64) -> String) -> String {
    let map = small_map();
    let rows = map.rows().into_iter().map(|row| {
        let cells: Vec<String> = row.iter().map(|h| number(*h)).collect();
        cells.join(separator) + "\n"
    });
    rows.collect()
}

fn csv() -> Vec<u8> {
    format!("# width = 8.0\n{}", matrix(",", |h| h.to_string())).into_bytes()
}

fn gwyddion() -> Vec<u8> {
    let head =
        "# Channel: Topography\n# Width: 8.0 \u{b5}m\n# Height: 8.0 \u{b5}m\n# Value units: m\n";
    format!("{head}{}", matrix("\t", |h| format!("{:e}", 1e-6 * h))).into_bytes()
}

fn decimal_commas() -> Vec<u8> {
    let commas = matrix("; ", |h| h.to_string().replace('.', ","));
    format!("width = 8,0 um\nHeights\n{commas}").into_bytes()
}

fn xyz() -> Vec<u8> {
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

fn npy_of(values: &[f64], shape: &str, fortran: bool) -> Vec<u8> {
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

fn npy() -> Vec<u8> {
    let turned: Vec<f64> = small_map().t().iter().copied().collect();
    npy_of(&turned, "(12, 12)", true)
}

fn zip(entries: &[(&str, Vec<u8>)], method: zip::CompressionMethod) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let options = zip::write::SimpleFileOptions::default().compression_method(method);
    for (name, bytes) in entries {
        archive.start_file(*name, options).unwrap();
        archive.write_all(bytes).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

fn npz() -> Vec<u8> {
    let heights: Vec<f64> = small_map().iter().copied().collect();
    let entries = [
        ("heights.npy", npy_of(&heights, "(12, 12)", false)),
        ("size.npy", npy_of(&[SIDE, SIDE], "(2,)", false)),
    ];
    zip(&entries, zip::CompressionMethod::Deflated)
}

fn x3p() -> Vec<u8> {
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

fn put(bytes: &mut [u8], at: usize, value: &[u8]) {
    bytes[at..at + value.len()].copy_from_slice(value);
}

fn sur() -> Vec<u8> {
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

fn sdf_text() -> Vec<u8> {
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

fn sdf_binary() -> Vec<u8> {
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
fn netcdf() -> Vec<u8> {
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

/// A scene of measured ground.
fn scene_text(file: &str, more: &str) -> String {
    format!(
        "format = 1\n[cell]\nlength = 8.0\npoints = 16\n[law]\nkind = \"morse\"\n\
         surface_energy = 0.15\nrange = 1.0\n[indenter]\nkind = \"measured\"\nfile = \"{file}\"\n\
         periodic = \"as_is\"\n{more}\n[drive]\nstart = 5.0\nturn = -0.5\nstep = 0.25\n"
    )
}

/// The loop of a scene as planned, on this mesh.
fn loop_of(scene: &Scene) -> LoopRun {
    let plan = plan(scene, &scene.model().unwrap(), None);
    let method = MethodKind::NewtonKrylov;
    let run = run_planned(scene, method, &plan, &Cancel::default(), &mut |_| {}).unwrap();
    assert_eq!(run.outcome, Outcome::Completed, "{}", scene.title);
    run
}

/// Largest difference of u0 and stress between two loops with as many states and jumps.
#[track_caller]
fn difference(a: &LoopRun, b: &LoopRun) -> f64 {
    let (a, b) = (&a.record, &b.record);
    assert_eq!(a.states.len(), b.states.len());
    assert_eq!(a.jumps.len(), b.jumps.len());
    let states = a.states.iter().zip(&b.states);
    let states = states.map(|(a, b)| {
        (a.stress - b.stress)
            .abs()
            .max((a.mean_displacement - b.mean_displacement).abs())
    });
    let jumps = a.jumps.iter().zip(&b.jumps);
    let jumps = jumps.map(|(a, b)| (a.mean_displacement - b.mean_displacement).abs());
    states.chain(jumps).fold(0.0, f64::max)
}

#[test]
fn a_map_of_each_format_comes_to_the_same_heights_and_the_same_loop() {
    let home = tempfile::tempdir().unwrap();
    let formats: [(&str, Vec<u8>, &str); 11] = [
        ("a.csv", csv(), ""),
        ("gwyddion.txt", gwyddion(), ""),
        ("commas.txt", decimal_commas(), ""),
        ("places.xyz", xyz(), ""),
        ("a.npy", npy(), "size = 8.0"),
        ("a.npz", npz(), ""),
        ("a.sur", sur(), ""),
        ("a.sdf", sdf_text(), ""),
        ("b.sdf", sdf_binary(), ""),
        ("a.x3p", x3p(), ""),
        ("a.nc", netcdf(), ""),
    ];
    let mut first: Option<(Array2<f64>, LoopRun)> = None;
    for (name, bytes, more) in formats {
        let file = home.path().join(name);
        fs::write(&file, bytes).unwrap();
        assert!(matches!(open(&file), Ok(Opened::Heights(_))), "{name}");
        let path = home.path().join("scene.toml");
        fs::write(&path, scene_text(name, more)).unwrap();
        let scene = scene_file::load(&path).unwrap_or_else(|error| panic!("{error}"));
        let model = scene.model().unwrap();
        let report = GroundReport::of(&model.indenter, &model.grid, Some(&model.law)).unwrap();
        let run = loop_of(&scene);
        let Some((heights, reference)) = &first else {
            let jumps = run.record.jumps.len();
            assert!(jumps > 0, "a loop without a jump compares nothing");
            first = Some((report.height, run));
            continue;
        };
        // Single precision of SUR tells the pitch to 1e-7.
        for (a, b) in report.height.iter().zip(heights) {
            assert!((a - b).abs() < 1e-6, "{name}: {a} {b}");
        }
        let off = difference(&run, reference);
        assert!(off < 1e-4, "{name}: {off}");
    }
}

#[test]
fn built_in_ground_written_to_a_file_and_read_back_has_the_same_loop() {
    let home = tempfile::tempdir().unwrap();
    for name in ["rough", "wavy"] {
        let mut scene = presets::resolve(name).unwrap();
        scene.cell.points = scene.cell.points.resized(32);
        (scene.drive.step, scene.law.range) = (0.1, tackscope::scene::Range::MuRho(0.45));
        let model = scene.model().unwrap();
        scene.law.range = tackscope::scene::Range::Length(model.law.range);
        let report = GroundReport::of(&model.indenter, &model.grid, None).unwrap();
        let file = home.path().join(format!("{name}.csv"));
        export::write_heights_csv(&file, &report).unwrap();
        let mut back = scene.clone();
        let text = format!(
            "[indenter]\nkind = \"measured\"\nfile = \"{}\"\nperiodic = \"as_is\"\n",
            file.display()
        );
        let own = scene_file::to_text(&scene);
        let (before, rest) = own.split_once("[indenter]").unwrap();
        let (_, after) = rest.split_once("[drive]").unwrap();
        let read = scene_file::parse(&format!("{before}{text}[drive]{after}"), "back").unwrap();
        back.indenter = read.indenter.clone();
        assert_eq!(back, read);
        let built_in = model.indenter.height(&model.grid).unwrap();
        let measured = back.model().unwrap().indenter.height(&model.grid).unwrap();
        for (a, b) in built_in.iter().zip(&measured) {
            assert!((a - b).abs() < 1e-9, "{name}: {a} {b}");
        }
        let off = difference(&loop_of(&scene), &loop_of(&back));
        assert!(off < 1e-6, "{name}: {off}");
    }
}

#[test]
fn a_scene_finds_its_file_from_its_own_folder_and_is_written_with_the_path_that_stays() {
    let home = tempfile::tempdir().unwrap();
    let (inside, other) = (home.path().join("a/maps"), home.path().join("b"));
    fs::create_dir_all(&inside).unwrap();
    fs::create_dir_all(&other).unwrap();
    fs::write(inside.join("m.csv"), csv()).unwrap();
    let path = home.path().join("a/scene.toml");
    fs::write(&path, scene_text("maps/m.csv", "detrend = \"tilt\"")).unwrap();
    let scene = scene_file::load(&path).unwrap();
    let again = home.path().join("a/again.toml");
    scene_file::save(&again, &scene).unwrap();
    assert!(
        fs::read_to_string(&again)
            .unwrap()
            .contains("file = \"maps/m.csv\"")
    );
    assert_eq!(scene_file::load(&again).unwrap(), scene);
    // Elsewhere, and as text for anywhere, the whole path is what still finds it.
    scene_file::save(&other.join("scene.toml"), &scene).unwrap();
    assert_eq!(scene_file::load(&other.join("scene.toml")).unwrap(), scene);
    assert_eq!(
        scene_file::parse(&scene_file::to_text(&scene), "mail").unwrap(),
        scene
    );
    // Another content is another ground.
    fs::write(
        inside.join("m.csv"),
        format!("# width = 8\n{}", matrix(",", |h| (2.0 * h).to_string())),
    )
    .unwrap();
    assert_ne!(scene_file::load(&path).unwrap(), scene);
}

/// The sentence by which a height file is refused.
#[track_caller]
fn refusal(home: &Path, name: &str, bytes: &[u8]) -> String {
    let path = home.join(name);
    fs::write(&path, bytes).unwrap();
    let sentence = read(&path).unwrap_err().to_string();
    assert!(sentence.contains(name), "{sentence}");
    assert_eq!(sentence.lines().count(), 1, "{sentence}");
    sentence
}

#[test]
fn a_broken_height_file_is_refused_with_the_place_and_what_was_expected() {
    let home = tempfile::tempdir().unwrap();
    let text = |text: &str| text.as_bytes().to_vec();
    let cut = |mut bytes: Vec<u8>| {
        bytes.truncate(bytes.len() - 9);
        bytes
    };
    let mut strange = sur();
    put(&mut strange, 180, b"ell ");
    let cases: Vec<(&str, Vec<u8>, &[&str])> = vec![
        (
            "a.csv",
            text("1,2,3,4\n5,6,x7,8\n"),
            &["line 2, column 3", "\"x7\"", "NaN"],
        ),
        (
            "b.csv",
            text("h\n1,2,3,4\n\n5,6,7\n"),
            &["line 4 has 3", "line 2 has 4"],
        ),
        (
            "c.xyz",
            text("0 0 1\n1 0 2\n0 1 3\n1.4 1 4\n"),
            &["line", "x = ", "grid"],
        ),
        (
            "d.xyz",
            text("0 0 1\n1 0 2\n0 1 3\n1 1 4\n1 1 5\n"),
            &["line 5", "second height"],
        ),
        ("e.txt", text("no number at all\n"), &["not one number"]),
        (
            "f.txt",
            text("# width = wide\n1 2 3 4\n"),
            &["\"wide\"", "10.0 um"],
        ),
        ("g.bin", vec![0, 159, 146, 150], &["no known format", "X3P"]),
        ("h.sur", cut(sur()), &["ends at byte", "144 numbers"]),
        ("i.sur", strange, &["unit \"ell\""]),
        ("j.sdf", cut(sdf_binary()), &["ends at byte"]),
        (
            "k.sdf",
            text(
                &String::from_utf8(sdf_text())
                    .unwrap()
                    .replace("\n401", "\nfour"),
            ),
            &["column"],
        ),
        ("l.x3p", cut(x3p()), &["l.x3p"]),
        (
            "m.npz",
            zip(&[("a.txt", vec![1])], zip::CompressionMethod::Stored),
            &["no array heights", "a.txt"],
        ),
        (
            "n.npy",
            npy_of(&[1.0; 8], "(2, 2, 2)", false),
            &["[2, 2, 2]", "(rows, columns)"],
        ),
        ("o.npy", cut(npy()), &["o.npy"]),
        ("p.nc", cut(netcdf()), &["p.nc"]),
        ("q.nc", b"\x89HDF\r\n".to_vec(), &["HDF5", "NetCDF classic"]),
        (
            "r.sdf",
            text("aISO-1.0\nNumPoints = x\n*\n"),
            &["NumPoints", "\"x\""],
        ),
    ];
    for (name, bytes, parts) in cases {
        let sentence = refusal(home.path(), name, &bytes);
        for part in parts {
            assert!(
                sentence.contains(part),
                "{part:?} is missing in: {sentence}"
            );
        }
    }
}

#[test]
fn what_a_scene_says_wrongly_of_its_map_is_refused_with_key_value_and_remedy() {
    let home = tempfile::tempdir().unwrap();
    fs::write(home.path().join("m.csv"), csv()).unwrap();
    fs::write(home.path().join("bare.csv"), matrix(",", |h| h.to_string())).unwrap();
    let path = home.path().join("scene.toml");
    let cases: [(&str, &str, &[&str]); 7] = [
        (
            "m.csv",
            "detrend = \"titl\"",
            &["indenter.detrend", "titl", "did you mean tilt"],
        ),
        ("m.csv", "size = 9.0", &["cell.length = 8", "allowed is 9"]),
        ("nowhere.csv", "", &["nowhere.csv", "check the path"]),
        ("bare.csv", "", &["indenter.size = 0", "how large"]),
        ("m.csv", "unit = \"inch\"", &["indenter.unit", "\"um\""]),
        ("m.csv", "shortest = -1.0", &["indenter.shortest"]),
        ("m.csv", "hurst = 0.8", &["indenter.hurst", "height_scale"]),
    ];
    for (file, more, parts) in cases {
        fs::write(&path, scene_text(file, more)).unwrap();
        let sentence = scene_file::load(&path).unwrap_err().to_string();
        for part in parts {
            assert!(
                sentence.contains(part),
                "{part:?} is missing in: {sentence}"
            );
        }
    }
}

#[test]
fn holes_are_filled_and_counted_and_a_profile_runs_on_a_line_cell() {
    let home = tempfile::tempdir().unwrap();
    let holes = String::from_utf8(csv())
        .unwrap()
        .replacen("0.4,", "nan,", 1);
    fs::write(home.path().join("holes.csv"), holes).unwrap();
    let path = home.path().join("scene.toml");
    fs::write(&path, scene_text("holes.csv", "")).unwrap();
    let model = scene_file::load(&path).unwrap().model().unwrap();
    let report = GroundReport::of(&model.indenter, &model.grid, Some(&model.law)).unwrap();
    assert_eq!(report.file.as_ref().unwrap().filled, 1);
    assert!(
        report
            .words
            .iter()
            .any(|words| words.contains("1 of 144 points")),
        "{:?}",
        report.words
    );

    let profile: String = small_map()
        .row(0)
        .iter()
        .enumerate()
        .fold(String::new(), |text, (i, h)| {
            format!("{text}{}\t{h}\n", i as f64 * SIDE / N as f64)
        });
    fs::write(home.path().join("profile.txt"), profile).unwrap();
    let line = scene_text("profile.txt", "").replace("points = 16", "points = [32, 1]");
    fs::write(&path, line).unwrap();
    let mut scene = scene_file::load(&path).unwrap();
    let on_a_line = loop_of(&scene);
    // The same profile under a square cell is the same ground along y.
    scene.cell.points = Points::Square(32);
    let square = scene.model().unwrap();
    let height = square.indenter.height(&square.grid).unwrap();
    assert!(height.rows().into_iter().all(|row| row == height.row(0)));
    assert!(on_a_line.record.states.len() > 10);
    fs::write(
        &path,
        scene_text("holes.csv", "").replace("points = 16", "points = [16, 1]"),
    )
    .unwrap();
    let sentence = scene_file::load(&path).unwrap_err().to_string();
    assert!(sentence.contains("cell.points = [16, 1]"), "{sentence}");
}
