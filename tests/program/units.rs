//! Scenes with units: what their numbers mean, what is written of them, what is refused; and that
//! scenes without know nothing of it.

use crate::binary::{
    content, done, errors, folder, perform, run, says, summary, tackscope, text_with,
};
use proptest::prelude::*;
use std::fs;
use std::path::Path;
use tackscope::physics::control::Control;
use tackscope::physics::parameter::Dimension;
use tackscope::physics::theory::{critical_length, flat_limits};
use tackscope::scene::parameter::{LENGTH_UNITS, MODULUS_UNITS, SURFACE_ENERGY_UNITS, Units, say};
use tackscope::scene::{Model, Scene, Turn, edit};
use tackscope::storage::{self, scene_file};

/// The preset with these texts replaced.
fn rubber(replaced: &[(&str, &str)]) -> String {
    text_with("rubber", replaced)
}

fn parsed(text: &str) -> Scene {
    scene_file::parse(text, "mine.toml").unwrap_or_else(|failure| panic!("{failure}"))
}

fn near(found: f64, expected: f64) {
    assert!(
        (found / expected - 1.0).abs() < 1e-12,
        "{found} in place of {expected}"
    );
}

#[test]
fn a_rubber_of_two_megapascal_is_what_is_reckoned_by_hand() {
    // E* = 2 MPa, gamma = 50 mJ/m^2, L = 20 um, rho = 0.1 um:
    // gamma/E* = 0.05 N/m / 2e6 N/m^2 = 2.5e-8 m = 0.025 um.
    let scene = parsed(&rubber(&[]));
    near(scene.law.surface_energy, 0.025);
    assert_eq!(scene.cell.length, 20.0);
    let model = scene.model().unwrap();
    let units = scene.units.unwrap();
    // sigma_max = gamma/(2 rho) = 0.05 N/m / 2e-7 m = 250 kPa.
    near(
        model.law.traction_max() * units.si(Dimension::Stress),
        250e3,
    );
    // L_c = 4 pi rho^2 E*/gamma = 4 pi 1e-14 m^2 2e6 Pa / 0.05 N/m = 1.6 pi um.
    let critical = critical_length(&model.law) * units.si(Dimension::Length);
    near(critical, 1.6e-6 * std::f64::consts::PI);
    // gamma L^2 = 0.05 J/m^2 (20e-6 m)^2 = 2e-11 J, over 1.380649e-23 J/K 298.15 K.
    let kt = model.in_kt(model.law.surface_energy).unwrap();
    near(kt, 2e-11 / (1.380649e-23 * 298.15));
    // sigma_max L^2 = 250 kPa 4e-10 m^2 = 100 uN.
    let force = model.of_cell(model.law.traction_max()).unwrap();
    assert_eq!(
        units.say(Dimension::Force, force),
        "100 µN",
        "to three digits"
    );
}

#[test]
fn numbers_are_told_with_the_prefix_that_leaves_one_to_three_digits_before_the_point() {
    for (of, si, words) in [
        (Dimension::Length, 2e-8, "20.0 nm"),
        (Dimension::Length, 1e-9, "1.00 nm"),
        (Dimension::Length, 3e-10, "300 pm"),
        (Dimension::Stress, 2.5e5, "250 kPa"),
        (Dimension::Stress, -1.25e6, "-1.25 MPa"),
        (Dimension::SurfaceEnergy, 5.875e-3, "5.88 mJ/m²"),
        (Dimension::Energy, 4.7e-15, "4.70 fJ"),
        (Dimension::Force, 4.2e-4, "420 µN"),
        (Dimension::Force, 9.9996e-5, "100 µN"),
        (Dimension::Force, 0.0, "0.00 N"),
        (Dimension::Energy, 1e-30, "1.00e-9 zJ"),
    ] {
        assert_eq!(say(of, si), words);
    }
}

#[test]
fn a_unit_may_be_written_as_people_write_it() {
    let written = rubber(&[("\"um\"", "\"µm\""), ("\"mJ/m^2\"", "\"mJ/m²\"")]);
    let scene = parsed(&written);
    assert_eq!(scene, parsed(&rubber(&[])));
    let short = rubber(&[("energy = \"mJ/m^2\"\ntemperature = 298.15\n", "")]);
    assert_eq!(parsed(&short), scene, "what may be left out");
}

#[test]
fn units_that_are_none_are_refused_with_those_that_are() {
    let refused = |old: &str, new: &str| {
        let text = rubber(&[(old, new)]);
        scene_file::parse(&text, "mine.toml")
            .expect_err("refused")
            .to_string()
    };
    for (old, new, parts) in [
        (
            "length = \"um\"",
            "length = \"ym\"",
            &["units.length", "ym", "\"um\"", "\"nm\""][..],
        ),
        (
            "modulus = \"MPa\"",
            "modulus = \"mpa\"",
            &["units.modulus", "mpa", "\"MPa\""],
        ),
        (
            "energy = \"mJ/m^2\"",
            "energy = \"mJ\"",
            &["units.energy", "mJ", "\"mJ/m^2\""],
        ),
        (
            "length = \"um\"",
            "length = 1e-6",
            &["units.length", "0.000001", "\"um\""],
        ),
        (
            "length = \"um\"\n",
            "",
            &["units.length is missing", "\"um\""],
        ),
        (
            "contact_modulus = 2.0\n",
            "",
            &["body.contact_modulus is missing", "units.modulus", "[body]"],
        ),
        (
            "contact_modulus = 2.0",
            "contact_modulus = \"2 MPa\"",
            &["body.contact_modulus", "2 MPa", "a finite number"],
        ),
        (
            "surface_energy = 50.0",
            "surface_energy = -50.0",
            &["law.surface_energy = -50:", "above 0"],
        ),
        (
            "temperature",
            "temprature",
            &["units.temprature", "temperature"],
        ),
        ("[units]", "[uni]", &["uni", "units"]),
    ] {
        let sentence = refused(old, new);
        says(&sentence, &[&["mine.toml"], parts].concat());
    }
    let text = storage::preset("fig2").unwrap().text;
    let body = "[body]\nkind = \"half_space\"\ncontact_modulus = 2.0\n\n[law]";
    let failure = scene_file::parse(&text.replacen("[law]", body, 1), "mine.toml");
    let sentence = failure.expect_err("refused").to_string();
    assert!(
        sentence.contains("body.contact_modulus = 2.0") && sentence.contains("without [units]"),
        "{sentence}"
    );
}

#[test]
fn the_drive_of_a_load_is_refused_in_its_units() {
    let load = rubber(&[(
        "start = 0.55\nturn = 0.02",
        "control = \"load\"\nstart = 0.3\nturn = 0.4",
    )]);
    let sentence = scene_file::parse(&load, "mine.toml")
        .expect_err("refused")
        .to_string();
    assert!(
        sentence.contains("drive.turn = 0.4") && sentence.contains("drive.start = 0.3"),
        "{sentence}"
    );
}

#[test]
fn another_modulus_leaves_the_numbers_of_the_file_what_they_are() {
    let spring = rubber(&[(
        "start = 0.55",
        "control = \"spring\"\nstiffness = 3.0\nstart = 0.55",
    )]);
    let scene = parsed(&spring);
    let model = scene.model().unwrap();
    let stiffer = edit::with_parameter(&scene, &model, "body.contact_modulus", 4.0).unwrap();
    near(stiffer.law.surface_energy, 0.0125);
    let text = scene_file::to_text(&stiffer);
    for line in [
        "contact_modulus = 4.0",
        "surface_energy = 50.0",
        "stiffness = 3.0",
    ] {
        assert!(text.contains(line), "{line} in {text}");
    }
    let softer = edit::with_parameter(&scene, &model, "law.surface_energy", 25.0).unwrap();
    near(softer.law.surface_energy, 0.0125);
    let held = edit::with_parameter(&scene, &model, "drive.stiffness", 1.0).unwrap();
    assert_eq!(held.drive.control, Control::Spring { stiffness: 0.5 });
}

/// What a scene is, whatever it is measured in.
fn pure(scene: &Scene, model: &Model) -> Vec<f64> {
    let (gamma, rho) = (model.law.surface_energy, model.law.range);
    let limits = flat_limits(&model.law, model.grid.length).expect("it snaps");
    let length = match scene.drive.control {
        Control::Load => 1.0,
        _ => rho,
    };
    let stiffness = match scene.drive.control {
        Control::Spring { stiffness } => stiffness * rho,
        _ => 0.0,
    };
    let turn = match scene.drive.turn {
        Turn::At(turn) => turn / length,
        Turn::ZeroLoad => f64::NAN,
    };
    vec![
        gamma / rho,
        model.grid.length / rho,
        model.mu_rho,
        limits.0 / rho,
        limits.1 / rho,
        scene.drive.start / length,
        turn,
        scene.drive.step / length,
        stiffness + 1.0,
        model.in_kt(gamma).expect("units"),
    ]
}

/// A scene in these units that is the rubber of the preset, under one of three machines.
fn same_in(units: [usize; 3], machine: usize) -> String {
    let powers = [
        [0, -3, -6, -9, -10, -12],
        [0, 3, 6, 9, 0, 0],
        [0, -3, -6, 0, 0, 0],
    ];
    let [l, m, g] = [0, 1, 2].map(|k| 10f64.powi(powers[k][units[k]]));
    let length = |si: f64| si / l;
    let (drive, stiffness) = match machine {
        0 => (
            ["0.55e-6", "0.02e-6", "2e-9"].map(|x| length(x.parse().unwrap())),
            String::new(),
        ),
        1 => (
            ["0.55e-6", "0.02e-6", "2e-9"].map(|x| length(x.parse().unwrap())),
            format!("control = \"spring\"\nstiffness = {:e}\n", 3e12 / m * l),
        ),
        _ => (
            [3e5 / m, -1e5 / m, 2e3 / m],
            "control = \"load\"\n".to_owned(),
        ),
    };
    let [start, turn, step] = drive;
    format!(
        "format = 1\n[cell]\nlength = {:e}\npoints = 64\n[body]\nkind = \"half_space\"\n\
         contact_modulus = {:e}\n[law]\nkind = \"morse\"\nsurface_energy = {:e}\nrange = {:e}\n\
         [drive]\n{stiffness}start = {start:e}\nturn = {turn:e}\nstep = {step:e}\n\
         [units]\nlength = \"{}\"\nmodulus = \"{}\"\nenergy = \"{}\"\n",
        length(20e-6),
        2e6 / m,
        0.05 / g,
        length(0.1e-6),
        LENGTH_UNITS[units[0]].word,
        MODULUS_UNITS[units[1]].word,
        SURFACE_ENERGY_UNITS[units[2]].word,
    )
}

proptest! {
    #[test]
    fn the_same_scene_in_other_units_is_the_same_physics(
        length in 0..LENGTH_UNITS.len(), modulus in 0..MODULUS_UNITS.len(), energy in 0..SURFACE_ENERGY_UNITS.len(), machine in 0..3usize,
    ) {
        let [here, there] = [[2, 2, 1], [length, modulus, energy]].map(|units| {
            let scene = parsed(&same_in(units, machine));
            pure(&scene, &scene.model().unwrap())
        });
        for (a, b) in here.iter().zip(&there) {
            prop_assert!((a - b).abs() <= 1e-12 * b.abs(), "{:?} and {:?}", here, there);
        }
    }

    #[test]
    fn a_scene_with_units_comes_back_from_its_text_to_the_last_bit(
        modulus in 1e-3..1e3f64, gamma in 1.0..500.0f64, machine in 0..3usize, temperature in 1.0..1e3f64, drive in 0.5..2.0f64,
    ) {
        let text = rubber(&[
            ("contact_modulus = 2.0", &format!("contact_modulus = {modulus}")),
            ("surface_energy = 50.0", &format!("surface_energy = {gamma}")),
            ("temperature = 298.15", &format!("temperature = {temperature}")),
            ("start = 0.55", &[
                format!("start = {}", 0.55 * drive),
                format!("control = \"spring\"\nstiffness = {drive}\nstart = {}", 0.55 * drive),
                format!("control = \"load\"\nstart = {}", 0.55 * drive),
            ][machine]),
        ]);
        let scene = parsed(&text);
        let written = scene_file::to_text(&scene);
        prop_assert_eq!(&parsed(&written), &scene);
        // What it says is what was to the digits that tell doubles apart.
        let table: toml::Table = written.parse().unwrap();
        let back = table["law"]["surface_energy"].as_float().unwrap();
        prop_assert!((back / gamma - 1.0).abs() < 4.0 * f64::EPSILON, "{back} of {gamma}");
        // With E* = 1 it is the scene without units that has the same numbers.
        let plain = Scene { units: None, ..scene.clone() };
        let (mut model, other) = (scene.model().unwrap(), plain.model().unwrap());
        model.units = None;
        prop_assert_eq!(model, other);
    }

    #[test]
    fn what_is_taken_is_given_again(modulus in 1e-6..1e6f64, x in 1e-9..1e9f64, k in 0..6usize) {
        let units = Units {
            length: &LENGTH_UNITS[k], modulus: &MODULUS_UNITS[k % 4], surface_energy: &SURFACE_ENERGY_UNITS[k % 3],
            contact_modulus: modulus, temperature: 300.0,
        };
        for of in [Dimension::Length, Dimension::Stress, Dimension::SurfaceEnergy, Dimension::Stiffness] {
            let back = units.given(of, units.taken(of, x));
            prop_assert!((back / x - 1.0).abs() < 3.0 * f64::EPSILON);
        }
    }
}

/// The tables of a run of this scene file, a coarse one.
fn tables(home: &Path, name: &str, text: &str) -> (Vec<Vec<String>>, serde_json::Value) {
    let path = home.join(format!("{name}.toml"));
    fs::write(&path, text).unwrap();
    let out = home.join(name);
    let more = ["--points", "32", "--quiet"];
    done(&run(&path.display().to_string(), &out, &more));
    let rows = content(out.join("loop.csv"));
    // A name with a comma is in quotes, and stands before what is compared from the right.
    let rows = rows
        .lines()
        .map(|row| row.split(',').map(str::to_owned).collect());
    (rows.collect(), summary(&out))
}

#[test]
fn a_run_in_units_is_the_run_without_times_the_modulus() {
    let home = folder();
    // The same numbers without units: 0.025 um is gamma/E*.
    let plain = rubber(&[
        ("contact_modulus = 2.0\n", ""),
        ("surface_energy = 50.0", "surface_energy = 0.025"),
        (
            "[units]\nlength = \"um\"\nmodulus = \"MPa\"\nenergy = \"mJ/m^2\"\ntemperature = 298.15\n",
            "",
        ),
    ]);
    let (with, told) = tables(home.path(), "with", &rubber(&[]));
    let (without, untold) = tables(home.path(), "without", &plain);
    assert_eq!(with[0], without[0], "the same columns");
    assert_eq!(with.len(), without.len());
    for (a, b) in with[1..].iter().zip(&without[1..]) {
        let cell = |row: &[String], k: usize| row[k].parse::<f64>().unwrap();
        assert_eq!((&a[0], &a[1], &a[3..8]), (&b[0], &b[1], &b[3..8]));
        assert_eq!(cell(a, 2), cell(b, 2) * 2.0, "MPa of 2 MPa");
        // 2 MPa times 1 um is 2 J/m^2.
        let energies = [cell(a, 8), cell(b, 8) * 2000.0];
        assert!((energies[0] - energies[1]).abs() <= 1e-12 * energies[1].abs());
    }
    assert_eq!(told["dissipated_energy"], untold["dissipated_energy"]);
    assert!(untold.get("units").is_none(), "nothing of units");
    let toml = untold["scene"]["toml"].as_str().unwrap();
    assert!(!toml.contains("[units]"), "{toml}");
    let si = |key: &str| told["units"][key].as_f64().unwrap();
    let loss = told["dissipated_energy"].as_f64().unwrap();
    near(si("loss_joule_per_square_metre"), 0.05 * loss);
    near(si("loss_joule"), 0.05 * loss * 4e-10);
    let pull = without[1..]
        .iter()
        .map(|row| row[2].parse::<f64>().unwrap());
    near(si("pull_off_pascal"), 2e6 * pull.fold(0.0, f64::max));
    near(si("pull_off_newton"), 4e-10 * si("pull_off_pascal"));
}

#[test]
fn the_scene_is_printed_for_programs_and_whether_it_is_real_for_people() {
    for (name, real) in [
        ("rubber", "Range: rho = 100 nm"),
        ("fig2", "Largest strain: sigma_max/E* = 0.0750; holds"),
    ] {
        let output = tackscope().args(["scene", name]).output().unwrap();
        let printed = done(&output);
        says(&errors(&output), &[real]);
        let scene = storage::resolve(name).unwrap();
        assert_eq!(parsed(&printed), scene, "all of it was decided");
        assert_eq!(printed.contains("[units]"), name == "rubber");
    }
}

#[test]
fn barriers_have_kt_where_there_are_units_and_no_column_more_where_not() {
    let home = folder();
    let barriers = |name: &str, text: &str| {
        let (path, out) = (
            home.path().join(name),
            home.path().join(format!("{name}-out")),
        );
        fs::write(&path, text).unwrap();
        let path = path.display().to_string();
        let more = ["--points", "32", "--barriers", "2", "--quiet"];
        perform(&[&["diagram", &path], &more[..]].concat(), &out);
        let text = content(out.join("barriers.csv"));
        text.lines().map(str::to_owned).collect::<Vec<_>>()
    };
    let with = barriers("with.toml", &rubber(&[]));
    assert!(
        with[0].ends_with("released_energy,barrier_kt"),
        "{}",
        with[0]
    );
    assert!(with.len() > 1, "there are saddles");
    for row in &with[1..] {
        let cells: Vec<&str> = row.split(',').collect();
        let [barrier, kt] = [5, 8].map(|k| cells[k].parse::<f64>().unwrap());
        // gamma L^2 is 2e-11 J.
        near(kt, barrier * 2e-11 / (1.380649e-23 * 298.15));
    }
    let fig2 = storage::preset("fig2").unwrap().text;
    let without = barriers("without.toml", fig2);
    assert!(without[0].ends_with(",released_energy"), "{}", without[0]);
}
