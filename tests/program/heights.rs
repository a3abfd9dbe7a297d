//! Height files of every format through the reader to a loop; and built-in ground that is written to
//! a file and read back.

use crate::binary::{content, done, folder, perform, refuses, says, tackscope};
use crate::height_formats::*;
use ndarray::Array2;
use std::fs;
use std::path::Path;
use tackscope::follow::run::{LoopRun, Outcome};
use tackscope::numerics::threads::Cancel;
use tackscope::paper::{GALLERY, Size, Task};
use tackscope::scene::{Points, Scene};
use tackscope::solver::methods::MethodKind;
use tackscope::storage::heights::read;
use tackscope::storage::{self, Opened, export, open, scene_file};
use tackscope::study::ground::GroundReport;
use tackscope::study::plan::{plan, run_planned};

/// A scene of measured ground.
fn scene_text(file: &str, more: &str) -> String {
    format!(
        "format = 1\n[cell]\nlength = 8.0\npoints = 32\n[law]\nkind = \"morse\"\n\
         surface_energy = 1.0\nrange = 0.55\n[indenter]\nkind = \"measured\"\nfile = \"{file}\"\n\
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

/// Largest difference of u0 at the jumps of two loops with as many, and of what they release.
#[track_caller]
fn jumps_off(a: &LoopRun, b: &LoopRun) -> f64 {
    let (a, b) = (&a.record.jumps, &b.record.jumps);
    assert_eq!(a.len(), b.len());
    let off = a.iter().zip(b).map(|(a, b)| {
        let place = (a.mean_displacement - b.mean_displacement).abs();
        place.max((a.released_energy - b.released_energy).abs())
    });
    off.fold(0.0, f64::max)
}

/// The same, and of the stress at the states, of which there must be as many.
#[track_caller]
fn difference(a: &LoopRun, b: &LoopRun) -> f64 {
    let states = (&a.record.states, &b.record.states);
    assert_eq!(states.0.len(), states.1.len());
    let off = states.0.iter().zip(states.1);
    let off = off.map(|(a, b)| (a.stress - b.stress).abs());
    off.fold(jumps_off(a, b), f64::max)
}

#[test]
fn a_map_of_each_format_comes_to_the_same_heights_and_the_same_loop() {
    let home = folder();
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
        let off = jumps_off(&run, reference);
        assert!(off < 1e-7, "{name}: {off}");
    }
}

/// A coarse built-in scene, and the same on ground that was written to a file and read back.
fn written_back(name: &str, home: &Path) -> [Scene; 2] {
    let mut scene = storage::resolve(name).unwrap();
    scene.cell.points = scene.cell.points.resized(32);
    (scene.drive.step, scene.law.range) = (0.1, tackscope::scene::Range::MuRho(0.45));
    let model = scene.model().unwrap();
    scene.law.range = tackscope::scene::Range::Length(model.law.range);
    let report = GroundReport::of(&model.indenter, &model.grid, None).unwrap();
    let file = home.join(format!("{name}.csv"));
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
    [scene, back]
}

#[test]
fn built_in_ground_written_to_a_file_and_read_back_has_the_same_loop() {
    let home = folder();
    for name in ["rough", "wavy"] {
        let [scene, back] = written_back(name, home.path());
        let [built_in, measured] = [&scene, &back].map(|scene| {
            let model = scene.model().unwrap();
            model.indenter.height(&model.grid).unwrap()
        });
        for (a, b) in built_in.iter().zip(&measured) {
            assert!((a - b).abs() < 1e-9, "{name}: {a} {b}");
        }
        let off = difference(&loop_of(&scene), &loop_of(&back));
        assert!(off < 1e-6, "{name}: {off}");
    }
}

#[test]
fn the_law_of_figure_14_measured_on_a_file_is_that_of_the_ground_it_was_written_from() {
    let home = folder();
    let cancel = Cancel::default();
    let [own, read] = written_back("rough", home.path()).map(|scene| {
        let entry = GALLERY.iter().find(|entry| entry.number == 14).unwrap();
        let mut observe = |_: f64, _: &str| {};
        let mut task = Task::new(Size::Full, &cancel, &mut observe).of(Some(&scene));
        (entry.compute)(&mut task).unwrap()
    });
    let [a, b] = [&own, &read].map(|figure| &figure.panels[0].series);
    assert_eq!(a.len(), b.len());
    // Both ways, and the fit.
    assert!(a.len() >= 3, "{}", own.words);
    for (a, b) in a.iter().zip(b) {
        assert_eq!(a.points.len(), b.points.len());
        for (a, b) in a.points.iter().zip(&b.points) {
            assert!(
                (a[0] - b[0]).abs() < 1e-6 && (a[1] - b[1]).abs() < 1e-5,
                "{a:?} {b:?}"
            );
        }
    }
    assert!(read.words.contains("rough.csv"), "{}", read.words);
    assert!(
        own.findings
            .iter()
            .all(|finding| finding.agrees() == Some(true))
    );
    // Another scene than the paper's goes with this figure alone, and with ground that has heights.
    for (figure, scene, words) in [
        ("2", "rough", "--scene = rough: goes with figure 14 alone"),
        (
            "14",
            "fig2",
            "fig2: indenter.kind = flat: ground with heights",
        ),
    ] {
        let out = home.path().join("refused");
        let refused = perform(&["figure", figure, "--scene", scene], &out);
        refuses(&refused, &[words]);
    }
}

#[test]
fn a_scene_finds_its_file_from_its_own_folder_and_is_written_with_the_path_that_stays() {
    let home = folder();
    let (inside, other) = (home.path().join("a/maps"), home.path().join("b"));
    fs::create_dir_all(&inside).unwrap();
    fs::create_dir_all(&other).unwrap();
    fs::write(inside.join("m.csv"), csv()).unwrap();
    let path = home.path().join("a/scene.toml");
    fs::write(&path, scene_text("maps/m.csv", "detrend = \"tilt\"")).unwrap();
    let scene = scene_file::load(&path).unwrap();
    let again = home.path().join("a/again.toml");
    scene_file::save(&again, &scene).unwrap();
    assert!(content(&again).contains("file = \"maps/m.csv\""));
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
    let home = folder();
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
                    .replacen("*\n400", "*\nfour", 1),
            ),
            &["line 13, column 1", "\"four\""],
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
        says(&sentence, parts);
    }
}

#[test]
fn what_a_scene_says_wrongly_of_its_map_is_refused_with_key_value_and_remedy() {
    let home = folder();
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
        says(&sentence, parts);
    }
}

#[test]
fn holes_are_filled_and_counted_and_a_profile_runs_on_a_line_cell() {
    let home = folder();
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
    let line = scene_text("profile.txt", "").replace("points = 32", "points = [32, 1]");
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
        scene_text("holes.csv", "").replace("points = 32", "points = [32, 1]"),
    )
    .unwrap();
    let sentence = scene_file::load(&path).unwrap_err().to_string();
    assert!(sentence.contains("cell.points = [32, 1]"), "{sentence}");
}

/// The numbers that `tackscope ground` writes.
fn looked_at(what: &str, out: &Path, more: &[&str]) -> serde_json::Value {
    done(&perform(&[&["ground", what], more].concat(), out));
    for name in ["ground.svg", "ground.png", "spectrum.csv", "heights.csv"] {
        assert!(out.join(name).exists(), "{name}");
    }
    serde_json::from_str(&content(out.join("ground.json"))).unwrap()
}

#[test]
fn the_ground_of_a_scene_is_looked_at_and_what_it_writes_is_a_height_file() {
    let home = folder();
    let (first, again) = (home.path().join("first"), home.path().join("again"));
    let told = looked_at("rough", &first, &["--points", "32"]);
    let height = told["mesh"]["rms_height_from_area"].as_f64().unwrap();
    // The preset's own rms, all of whose waves 32 points show.
    assert!((height - 1.0).abs() < 1e-10, "{height}");
    let file = first.join("heights.csv").display().to_string();
    let back = looked_at(&file, &again, &[]);
    let before = back["file"]["before"]["rms_height_from_area"].as_f64();
    assert!((before.unwrap() - height).abs() < 1e-12);
    assert_eq!(back["file"]["side"].as_f64(), Some(16.0));
    let flat = perform(&["ground", "fig2"], &home.path().join("flat"));
    refuses(&flat, &["indenter.kind"]);
}

#[test]
fn a_scene_from_standard_input_finds_its_file_from_the_working_folder() {
    let home = folder();
    fs::write(home.path().join("m.csv"), csv()).unwrap();
    fs::write(home.path().join("scene.toml"), scene_text("m.csv", "")).unwrap();
    let scene = fs::File::open(home.path().join("scene.toml")).unwrap();
    let mut command = tackscope();
    command
        .args(["scene", "-"])
        .current_dir(home.path())
        .stdin(scene);
    let output = command.output().expect("the binary runs");
    let printed = done(&output);
    let path = fs::canonicalize(home.path()).unwrap().join("m.csv");
    assert!(
        printed.contains(&format!("file = \"{}\"", path.display())),
        "{printed}"
    );
}
