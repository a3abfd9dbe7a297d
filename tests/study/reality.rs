//! Whether a scene is real: the numbers against those reckoned by hand, and what fails where it
//! must.

use crate::loops::preset;
use tackscope::physics::indenter::{Hertz, Indenter};
use tackscope::scene::parameter::{LENGTH_UNITS, MODULUS_UNITS, SURFACE_ENERGY_UNITS, Units};
use tackscope::scene::{Points, Range, Scene};
use tackscope::study::reality::{Check, Verdict, reality};

fn checks(scene: &Scene) -> Vec<Check> {
    reality(&scene.model().unwrap_or_else(|refusal| panic!("{refusal}")))
}

#[track_caller]
fn says(checks: &[Check], name: &str, verdict: Verdict, parts: &[&str]) {
    let check = checks.iter().find(|check| check.name == name);
    let check = check.unwrap_or_else(|| panic!("{name} is asked"));
    assert_eq!(check.verdict, verdict, "{check}");
    for part in parts {
        let words = check.to_string();
        assert!(words.contains(part), "{part:?} is missing in: {words}");
    }
}

#[test]
fn a_rubber_with_a_range_of_a_hundred_nanometres_is_doubtful_in_range_and_strength() {
    let checks = checks(&preset("rubber"));
    // 100 nm over 0.3 nm.
    says(&checks, "Range", Verdict::Doubtful, &["100 nm", "333 "]);
    // 50 mJ/m^2 over twice 0.3 nm is 83.3 MPa, 41.7 times E*.
    says(
        &checks,
        "Strength",
        Verdict::Doubtful,
        &["250 kPa", "83.3 MPa"],
    );
    // 250 kPa over 2 MPa.
    says(
        &checks,
        "Largest strain",
        Verdict::Doubtful,
        &["0.125", "41.7"],
    );
    // 20 um over 1.6 pi um; 1.6 pi um over 333.3^2 is 45 pm.
    let cell = ["3.98", "5.03 µm", "45.2 pm"];
    says(&checks, "Length of the cell", Verdict::Holds, &cell);
    // 20 um over 64.
    says(&checks, "Mesh", Verdict::Holds, &["312 nm"]);
    says(&checks, "No heat", Verdict::Holds, &["4.86e9 kT"]);
}

#[test]
fn a_scene_without_units_is_asked_for_no_metres() {
    let checks = checks(&preset("fig2"));
    let names: Vec<_> = checks.iter().map(|check| check.name).collect();
    assert_eq!(names, ["Largest strain", "Length of the cell", "Mesh"]);
    // gamma/(2 rho) = 0.075 E*; L/L_c of Fig. 2 is 3.06.
    says(&checks, "Largest strain", Verdict::Holds, &["0.0750"]);
    says(&checks, "Length of the cell", Verdict::Holds, &["3.06"]);
}

#[test]
fn what_cannot_be_is_said_to_fail() {
    let mut scene = preset("fig2");
    let units = Units {
        length: &LENGTH_UNITS[3],
        modulus: &MODULUS_UNITS[2],
        surface_energy: &SURFACE_ENERGY_UNITS[1],
        contact_modulus: 100.0,
        temperature: 298.15,
    };
    assert_eq!((units.length.word, units.modulus.word), ("nm", "MPa"));
    scene.units = Some(units);
    // rho = 1 nm, gamma = 0.15 of 100 MPa nm = 15 mJ/m^2.
    says(
        &checks(&scene),
        "Range",
        Verdict::Holds,
        &["1.00 nm", "3.33 "],
    );
    // (256 nm)^2 of 15 mJ/m^2 is 9.83e-16 J, 2.39e5 kT.
    says(&checks(&scene), "No heat", Verdict::Holds, &["2.39e5 kT"]);
    scene.units = Some(Units {
        length: &LENGTH_UNITS[5],
        ..units
    });
    let small = checks(&scene);
    says(&small, "Range", Verdict::Fails, &["1.00 pm"]);
    says(&small, "Strength", Verdict::Fails, &[]);
    says(&small, "Mesh", Verdict::Doubtful, &["4.00 pm"]);
    says(&small, "No heat", Verdict::Doubtful, &["kT at 298.15 K"]);
}

#[test]
fn a_tip_is_told_its_tabor_parameter_and_its_slope() {
    let mut scene = preset("fig2");
    scene.cell.points = Points::Square(64);
    scene.cell.length = 64.0;
    scene.law.range = Range::Length(1.0);
    scene.law.surface_energy = 0.1;
    scene.indenter = Indenter::Hertz(Hertz { radius: 100.0 });
    let checks = checks(&scene);
    // (R gamma^2)^(1/3)/rho is 1; (9 pi gamma/(2 R))^(1/3) = (0.01414)^(1/3) = 0.2418.
    says(
        &checks,
        "Tabor parameter",
        Verdict::Holds,
        &["1.00", "neither"],
    );
    says(&checks, "Slopes", Verdict::Doubtful, &["0.242"]);
}
