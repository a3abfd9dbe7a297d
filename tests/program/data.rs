//! What other programs read and send: scenes through a pipe, fields for numpy, films.

use crate::binary::{
    answer, content, done, errors, fig2_with, folder, perform, refuses, run, says, tackscope,
    text_with,
};
use ndarray::Array2;
use npyz::{Deserialize, NpyFile};
use std::fs::{self, File};
use std::io::{BufReader, Read, Write};
use std::path::Path;
use std::process::{Command, Output, Stdio};
use tackscope::physics::mesh::Grid;
use tackscope::physics::system::System;
use tackscope::plot::style::Colours;
use tackscope::scene::Model;
use tackscope::storage::picture::{FilmKind, Shot, write_film};
use tackscope::storage::{self, Failure, VERSION, scene_file};
use zip::ZipArchive;

/// The binary with a text on its standard input.
fn piped(arguments: &[&str], text: &str) -> Output {
    let mut child = tackscope()
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the binary runs");
    let mut input = child.stdin.take().expect("piped");
    input.write_all(text.as_bytes()).expect("it reads");
    drop(input);
    child.wait_with_output().expect("it ends")
}

/// A table of a run without its times.
fn table(folder: &Path, name: &str) -> Vec<Vec<String>> {
    let text = content(folder.join(name));
    let head: Vec<&str> = text.lines().next().unwrap_or_default().split(',').collect();
    // Quoted cells, which hold commas, stand before the times.
    let times = head
        .iter()
        .rev()
        .position(|column| *column == "milliseconds");
    text.lines()
        .map(|line| {
            let mut cells: Vec<String> = line.rsplit(',').map(str::to_owned).collect();
            times.map(|i| cells.remove(i));
            cells.reverse();
            cells
        })
        .collect()
}

const COARSE: [&str; 5] = ["--points", "16", "--step", "0.4", "--quiet"];

#[test]
fn a_scene_from_standard_input_has_the_loop_of_its_preset() {
    let home = folder();
    let (by_name, by_pipe) = (home.path().join("name"), home.path().join("pipe"));
    assert!(run("fig2", &by_name, &COARSE).status.success());
    let out = by_pipe.display().to_string();
    let arguments = [&["run", "-", "--out", &out], &COARSE[..]].concat();
    done(&piped(&arguments, storage::preset("fig2").unwrap().text));
    for name in ["loop.csv", "events.csv"] {
        assert_eq!(table(&by_pipe, name), table(&by_name, name));
    }
}

#[test]
fn a_refused_scene_from_standard_input_is_named_so() {
    let text = text_with("fig2", &[("length = 256.0", "length = -1")]);
    for command in ["run", "diagram", "chart"] {
        let output = piped(&[command, "-", "--out", "nowhere"], &text);
        refuses(&output, &["standard input", "cell.length = -1"]);
    }
}

/// What is printed holds numbers in place of what was left to the program, and opens to the same
/// model.
#[test]
fn a_printed_scene_is_decided_and_has_the_loop_of_the_one_it_was_made_of() {
    let auto = [("points = 64", "points = \"auto\"")];
    let coarse = [
        ("range = 1.0", "mu_rho = 0.5"),
        ("points = 64", "points = 16"),
    ];
    let layer = [
        (
            "[law]",
            "[body]\nkind = \"layer\"\nthickness = 90\npoisson = 0.5\n[law]",
        ),
        ("points = 64", "points = [32, 1]"),
    ];
    for replacements in [&auto[..], &coarse, &layer] {
        let (scene, home) = fig2_with(replacements);
        let given = scene_file::load(Path::new(&scene)).unwrap();
        let text = answer(&["scene", &scene]);
        assert!(!text.contains("auto") && !text.contains("mu_rho"), "{text}");
        let printed = scene_file::parse(&text, "printed").unwrap();
        let (old, new) = (given.model().unwrap(), printed.model().unwrap());
        assert_eq!((old.grid, old.law, old.body), (new.grid, new.law, new.body));
        assert_eq!((old.indenter, old.mu_rho), (new.indenter, new.mu_rho));
        assert_eq!((given.drive, given.seed), (printed.drive, printed.seed));
        assert_eq!(
            done(&piped(&["scene", "-"], &text)),
            text,
            "it prints itself"
        );
        let json = answer(&["scene", &scene, "--json"]);
        let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
        let toml: toml::Table = text.parse().unwrap();
        assert_eq!(json, serde_json::to_value(&toml).unwrap());
        if old.grid.nx > 32 {
            continue;
        }
        let (one, other) = (home.path().join("one"), home.path().join("other"));
        let step = ["--step", "0.4", "--quiet"];
        assert!(run(&scene, &one, &step).status.success());
        let arguments = [
            &["run", "-", "--out", &other.display().to_string()],
            &step[..],
        ];
        done(&piped(&arguments.concat(), &text));
        assert_eq!(table(&one, "loop.csv"), table(&other, "loop.csv"));
    }
}

/// An array of an archive: its shape and values.
fn array<T: Deserialize>(file: &Path, name: &str) -> (Vec<u64>, Vec<T>) {
    let mut archive = ZipArchive::new(File::open(file).unwrap()).unwrap();
    let mut bytes = Vec::new();
    let mut entry = archive.by_name(&format!("{name}.npy")).expect(name);
    entry.read_to_end(&mut bytes).unwrap();
    let array = NpyFile::new(&bytes[..]).unwrap();
    (array.shape().to_vec(), array.into_vec().unwrap())
}

fn text(file: &Path, name: &str) -> String {
    array(file, name).1.remove(0)
}

/// What the scene inside means.
fn model(file: &Path) -> Model {
    let scene = scene_file::parse(&text(file, "scene"), "fields.npz").unwrap();
    scene.model().unwrap()
}

/// The field of this number among `all`, of a shape.
fn field(all: &[f64], number: usize, shape: (usize, usize)) -> Array2<f64> {
    let mut fields = all.chunks_exact(shape.0 * shape.1);
    let field = fields.nth(number).expect("it is there");
    Array2::from_shape_vec(shape, field.to_vec()).unwrap()
}

/// A column of `loop.csv`, of the tables' last columns or first ones.
fn column(folder: &Path, index: usize) -> Vec<String> {
    let rows = table(folder, "loop.csv");
    rows[1..].iter().map(|row| row[index].clone()).collect()
}

#[test]
fn the_fields_of_every_state_are_in_equilibrium_and_have_its_stress() {
    for (replacements, points) in [
        (vec![("points = 64", "points = 16")], [16, 16]),
        (
            vec![
                (
                    "[law]",
                    "[body]\nkind = \"layer\"\nthickness = 40\npoisson = 0.4\n[law]",
                ),
                (
                    "kind = \"flat\"",
                    "kind = \"wave\"\namplitude = 0.5\nperiods = 2",
                ),
                ("points = 64", "points = [32, 1]"),
                ("start = 4.2", "start = 50.0"),
                ("turn = 0.2", "turn = -50.0"),
                ("step = 0.02", "step = 4.0"),
            ],
            [1, 32],
        ),
    ] {
        let (scene, home) = fig2_with(&replacements);
        let out = home.path().join("out");
        let more = ["--model", "whole", "--fields", "all", "--quiet"];
        let output = run(&scene, &out, &more);
        done(&output);
        let file = out.join("fields.npz");
        let (shape, gap): (_, Vec<f64>) = array(&file, "gap");
        let u0: Vec<f64> = array(&file, "mean_displacement").1;
        let stress: Vec<f64> = array(&file, "stress").1;
        let displacement: Vec<f64> = array(&file, "displacement").1;
        let traction: Vec<f64> = array(&file, "traction").1;
        let branch: Vec<String> = array(&file, "branch").1;
        assert_eq!(shape, [u0.len() as u64, points[0], points[1]]);
        assert_eq!(branch, column(&out, 0));
        let cells = column(&out, 1);
        let same = cells
            .iter()
            .zip(&u0)
            .all(|(cell, u0)| cell.parse() == Ok(*u0));
        assert!(same && cells.len() == u0.len());

        // The scene inside, and the archive's own stiffness of each wave.
        let model = model(&file);
        let system = System::new(model.grid, model.law, &model.indenter).with_body(model.body);
        let stiffness: Vec<f64> = array(&file, "wave_stiffness").1;
        let (ny, nx) = model.grid.shape();
        for k in 0..=nx / 2 {
            for l in 0..ny {
                let (a, b) = (system.elastic()[2 * (k * ny + l)], stiffness[l * nx + k]);
                assert!((a - b).abs() <= 1e-14 * a, "{k} {l}: {a} {b}");
            }
        }
        let mut ws = system.workspace();
        let of = |all: &[f64], i: usize| field(all, i, (ny, nx));
        for (i, u0) in u0.iter().enumerate() {
            let field = of(&displacement, i);
            assert!((field.mean().unwrap() - u0).abs() < 1e-12);
            let amplitudes = system.amplitudes(&field, &mut ws);
            let at = system.at(amplitudes, *u0, &mut ws);
            assert!(system.residual(&at, &mut ws) < 1e-6, "{u0}");
            assert!((at.state.stress - stress[i]).abs() < 1e-12, "{u0}");
            let off = &at.fields.gap - &of(&gap, i);
            assert!(off.iter().all(|off| off.abs() < 1e-10), "{u0}");
            assert!((of(&traction, i).mean().unwrap() - stress[i]).abs() < 1e-12);
        }
        assert_eq!(text(&file, "program"), format!("tackscope {VERSION}"));
        assert_eq!(array::<i64>(&file, "format"), (vec![], vec![1]));
        assert_eq!(array(&file, "length"), (vec![], vec![model.grid.length]));
    }
}

#[test]
fn every_nth_state_or_those_around_jumps_can_be_kept_instead() {
    let home = folder();
    let kept = |keep: &str, name: &str| {
        let out = home.path().join(name);
        let more = [&COARSE[..], &["--fields", keep]].concat();
        assert!(run("fig2", &out, &more).status.success());
        let file = out.join("fields.npz");
        let states: Vec<i64> = array(&file, "state").1;
        let events: Vec<bool> = array(&file, "event").1;
        let all = column(&out, 0).len();
        (states, events, all, table(&out, "events.csv").len() - 1)
    };
    let (states, _, all, _) = kept("every=7", "every");
    assert_eq!(states, (0..all as i64).step_by(7).collect::<Vec<_>>());
    let (states, events, _, jumps) = kept("jumps", "jumps");
    assert!(jumps > 3);
    assert_eq!(events.iter().filter(|event| **event).count(), jumps);
    for (pair, event) in states.windows(2).zip(&events[1..]) {
        assert!(!event || pair[1] == pair[0] + 1, "{states:?}");
    }
    let refused = run("fig2", &home.path().join("no"), &["--fields", "every=0"]);
    assert_eq!(refused.status.code(), Some(2));
    says(&errors(&refused), &["every=N"]);
}

/// The mode is held against the second difference of the energy along it.
#[test]
fn the_soft_mode_before_a_jump_has_the_stiffness_of_its_state() {
    let (scene, home) = fig2_with(&[
        ("points = 64", "points = 32"),
        ("step = 0.02", "step = 0.2"),
    ]);
    for model in ["whole", "plan"] {
        let out = home.path().join(model);
        let more = ["--fields", "jumps", "--quiet", "--model", model];
        let output = run(&scene, &out, &more);
        done(&output);
        let file = out.join("fields.npz");
        let (shape, modes): (_, Vec<f64>) = array(&file, "soft_mode");
        let of: Vec<i64> = array(&file, "soft_mode_state").1;
        let states: Vec<i64> = array(&file, "state").1;
        let displacement: Vec<f64> = array(&file, "displacement").1;
        let jumps = table(&out, "events.csv").len() - 1;
        assert!(jumps >= 6);
        assert_eq!(shape, [jumps as u64, 32, 32]);
        assert_eq!(of.len(), jumps);
        let decided = self::model(&file);
        let system = System::new(decided.grid, decided.law, &decided.indenter);
        let mut ws = system.workspace();
        let [u0s, stiffness] = [1, 7].map(|index| column(&out, index));
        for (i, &state) in of.iter().enumerate() {
            let row = states.iter().position(|s| *s == state).unwrap();
            let mode = field(&modes, i, (32, 32));
            assert!((mode.mapv(|v| v * v).mean().unwrap() - 1.0).abs() < 1e-9);
            let u0: f64 = u0s[state as usize].parse().unwrap();
            let told: f64 = stiffness[state as usize].parse().unwrap();
            let mut energy = |by: f64| {
                let moved = field(&displacement, row, (32, 32)) + &(&mode * by);
                let z = system.amplitudes(&moved, &mut ws);
                system.at(z, u0, &mut ws).state.energy
            };
            let by = 1e-3;
            let second = (energy(by) - 2.0 * energy(0.0) + energy(-by)) / (by * by);
            let found = second * decided.grid.length;
            assert!((found - told).abs() < 0.02, "{model} {u0}: {found} {told}");
        }
    }
}

#[test]
fn the_fields_of_a_diagram_are_in_equilibrium_on_every_branch() {
    let (scene, home) = fig2_with(&[("points = 64", "points = 48")]);
    let out = home.path().join("out");
    done(&perform(&["diagram", &scene, "--fields", "--quiet"], &out));
    let file = out.join("fields.npz");
    let branches: Vec<String> = array(&file, "branches").1;
    assert!(branches.len() >= 4, "{branches:?}");
    let model = model(&file);
    let rows = table(&out, "branches.csv").split_off(1);
    let mut rows = rows.iter();
    for branch in branches {
        let of = |what: &str| array::<f64>(&file, &format!("{branch}_{what}"));
        let (shape, displacement) = of("displacement");
        let [(_, gap), (_, u0s), (_, stress)] = ["gap", "mean_displacement", "stress"].map(of);
        let (ny, nx) = (shape[1] as usize, shape[2] as usize);
        let grid = if ny == 1 {
            Grid::line(model.grid.length, nx)
        } else {
            Grid::square(model.grid.length, nx)
        };
        let system = System::new(grid, model.law, &model.indenter);
        let mut ws = system.workspace();
        assert_eq!(shape[0] as usize, u0s.len());
        for (i, u0) in u0s.iter().enumerate() {
            let row = rows.next().expect("a row a point");
            assert_eq!((&row[0], row[2].parse()), (&branch, Ok(*u0)));
            let of = |all: &[f64]| field(all, i, (ny, nx));
            let amplitudes = system.amplitudes(&of(&displacement), &mut ws);
            let at = system.at(amplitudes, *u0, &mut ws);
            // Where a branch meets the ridge the state is known on the ridge's finer line, some of
            // whose waves a square mesh lacks.
            let meets = branch.starts_with("mixed") && [0, u0s.len() - 1].contains(&i);
            let [balance, pull] = if meets { [1e-3, 1e-5] } else { [1e-6, 1e-9] };
            assert!(system.residual(&at, &mut ws) < balance, "{branch} {u0}");
            assert!((at.state.stress - stress[i]).abs() < pull, "{branch} {u0}");
            let off = &at.fields.gap - &of(&gap);
            assert!(off.iter().all(|off| off.abs() < 1e-10));
        }
    }
    assert!(rows.next().is_none());
}

/// The lines of the guide, but for the picture.
#[test]
fn the_lines_of_python_in_the_guide_find_every_state_in_equilibrium() {
    let python = |script: &str, folder: &Path| {
        let mut python = Command::new("python3");
        python.args(["-c", script]).current_dir(folder).output()
    };
    let home = folder();
    if !python("import numpy", home.path()).is_ok_and(|output| output.status.success()) {
        eprintln!("skipped: there is no python3 with numpy");
        return;
    }
    let page = content("assets/guide/results.md");
    let (_, rest) = page.split_once("```python\n").expect("some Python");
    let (script, _) = rest.split_once("```").expect("its end");
    let lines: Vec<&str> = (script.lines())
        .filter(|line| !line.contains("plt"))
        .collect();
    assert!(lines.len() >= 4, "{script}");
    let more = [
        "--points", "32", "--step", "0.2", "--model", "whole", "--fields", "all",
    ];
    let output = run("fig2", &home.path().join("results"), &more);
    done(&output);
    let output = python(&lines.join("\n"), home.path()).expect("it runs");
    let found = String::from_utf8_lossy(&output.stdout).trim().to_owned();
    let residual: f64 = found
        .parse()
        .unwrap_or_else(|_| panic!("{found} {}", errors(&output)));
    // States are found to 1e-6 of sigma_max, to which the largest traction comes within 2 %.
    assert!(residual > 0.0 && residual < 1.02e-6, "{residual}");
}

const COUNT: usize = 5;
const TOP: f64 = 2.0;

/// A gap that rises to the right, and with each picture.
fn shots() -> impl Iterator<Item = Shot> {
    (0..COUNT).map(|k| Shot {
        gap: Array2::from_shape_fn((64, 64), |(_, i)| 0.02 * i as f64 + 0.1 * k as f64),
        place: k as f64 / (COUNT - 1) as f64,
    })
}

/// A film of the first `count` of them.
fn film(
    path: &Path,
    kind: FilmKind,
    count: usize,
    tell: &mut dyn FnMut(f64) -> bool,
) -> Result<(), Failure> {
    let look = (TOP, Colours::default());
    write_film(path, kind, (shots().take(count), count), look, tell)
}

/// Red, green and blue where the first picture has its point in this row and column.
fn wanted(row: usize, column: usize) -> [u8; 3] {
    let gap = shots().next().expect("a picture").gap[[row, column]];
    colorous::VIRIDIS.eval_continuous(gap / TOP).as_array()
}

/// Both colours, but for one of the 254 that the file has.
fn is_near(a: [u8; 3], b: [u8; 3]) -> bool {
    (0..3).all(|k| a[k].abs_diff(b[k]) <= 2)
}

#[test]
fn a_gif_has_every_picture_in_the_colours_of_the_map() {
    let folder = folder();
    let path = folder.path().join("film.gif");
    let mut shares = Vec::new();
    film(&path, FilmKind::Gif, COUNT, &mut |share| {
        shares.push(share);
        true
    })
    .unwrap();
    assert_eq!(shares, [0.2, 0.4, 0.6, 0.8, 1.0]);
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut film = options.read_info(File::open(&path).unwrap()).unwrap();
    let (width, height) = (film.width() as usize, film.height() as usize);
    assert!(width >= 256 && height > width, "{width} {height}");
    let mut pictures = Vec::new();
    while let Some(frame) = film.read_next_frame().unwrap() {
        assert_eq!(frame.delay, 5);
        pictures.push(frame.buffer.to_vec());
    }
    assert_eq!(pictures.len(), COUNT);
    for column in [0, 17, 40, 63] {
        let x = (2 * column + 1) * width / 128;
        let at = 4 * (10 * width + x);
        let seen = [0, 1, 2].map(|k| pictures[0][at + k]);
        assert!(is_near(seen, wanted(0, column)), "{column}: {seen:?}");
    }
    assert!(pictures.windows(2).all(|pair| pair[0] != pair[1]));
    // The bar's mark goes from the left to the right.
    let bright = |picture: &[u8]| {
        let row = &picture[4 * (height - 2) * width..][..4 * width];
        row.chunks(4).position(|p| p[0] == 255).expect("a mark")
    };
    let marks: Vec<usize> = pictures.iter().map(|picture| bright(picture)).collect();
    assert!(
        marks.is_sorted() && marks[0] < marks[COUNT - 1],
        "{marks:?}"
    );
}

#[test]
fn an_animated_png_has_every_picture() {
    let folder = folder();
    let path = folder.path().join("film.png");
    film(&path, FilmKind::Apng, COUNT, &mut |_| true).unwrap();
    let decoder = png::Decoder::new(BufReader::new(File::open(&path).unwrap()));
    let mut film = decoder.read_info().unwrap();
    let told = film.info().animation_control.expect("it is animated");
    assert_eq!((told.num_frames as usize, told.num_plays), (COUNT, 0));
    let mut buffer = vec![0; film.output_buffer_size().unwrap()];
    let mut pictures = Vec::new();
    for _ in 0..COUNT {
        film.next_frame(&mut buffer).unwrap();
        pictures.push(buffer.clone());
    }
    assert!(pictures.windows(2).all(|pair| pair[0] != pair[1]));
}

#[test]
fn of_a_film_that_is_given_up_nothing_is_left_and_what_was_there_stays() {
    let folder = folder();
    let path = folder.path().join("film.gif");
    fs::write(&path, "what was there").unwrap();
    let end = film(&path, FilmKind::Gif, COUNT, &mut |share| share < 0.5);
    assert!(end.unwrap_err().to_string().contains("given up"));
    assert_eq!(content(&path), "what was there");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    let end = film(&path, FilmKind::Apng, 0, &mut |_| true);
    assert!(end.unwrap_err().to_string().contains("nothing to show"));
}
