//! Pictures of an invented loop: drawn, written, and looked into.

use super::curves::Curves;
use super::{write_gap_png, write_loop_png, write_loop_svg};
use crate::experiment::record::{Branch, Cause, JumpRecord, LoopRecord, StateRecord};
use crate::physics::law::{Law, Morse, Shape};
use crate::physics::pattern::Pattern;
use crate::solver::Stop;
use ndarray::Array2;

fn law() -> Law {
    Law { shape: Shape::Morse(Morse), surface_energy: 0.15, range: 1.0 }
}

fn state(branch: Branch, pattern: Pattern, u0: f64) -> StateRecord {
    let law = law();
    let over_max = match pattern {
        Pattern::Flat => law.at(u0).traction / law.traction_max(),
        Pattern::Bulge => 0.12 + 0.05 * u0,
        Pattern::Ridge => 0.2 + 0.06 * u0,
        _ => 0.55 * u0.powf(0.6),
    };
    StateRecord {
        branch,
        mean_displacement: u0,
        stress: over_max * law.traction_max(),
        stress_over_max: over_max,
        contact_area: 0.0,
        pattern,
        residual: 0.0,
        stiffness_min: 1.0,
        stiffness_error: 0.0,
        energy: 0.0,
        model: "invented",
        stop: Stop::Stable,
        iterations: 1,
        transforms: 2,
        milliseconds: 0.0,
    }
}

/// A loop like that of Fig. 2, with invented stresses.
fn invented_loop() -> LoopRecord {
    use Pattern::{Bulge, Dimple, Flat, Ridge};
    let approach = [(Flat, 4.2, 3.1), (Bulge, 3.1, 2.6), (Ridge, 2.6, 1.7), (Dimple, 1.7, 0.8), (Flat, 0.8, 0.2)];
    let retraction = [(Flat, 0.2, 0.8), (Dimple, 0.8, 2.3), (Ridge, 2.3, 3.5), (Bulge, 3.5, 3.8), (Flat, 3.8, 4.2)];
    let mut record = LoopRecord::default();
    for (branch, legs) in [(Branch::Approach, approach), (Branch::Retraction, retraction)] {
        for (k, (pattern, from, to)) in legs.into_iter().enumerate() {
            if let Some(before) = record.states.last().filter(|_| k > 0).cloned() {
                let after = state(branch, pattern, from);
                record.jumps.push(JumpRecord {
                    branch,
                    mean_displacement: from,
                    from: before.pattern,
                    to: pattern,
                    stress_before: before.stress,
                    stress_after: after.stress,
                    released_energy: 0.1,
                    release_error: 1e-5,
                    cause: Cause::Fold,
                    landings: Vec::new(),
                });
            }
            let first = usize::from(branch == Branch::Retraction && k == 0);
            record.states.extend((first..=20).map(|i| state(branch, pattern, from + (to - from) * i as f64 / 20.0)));
        }
    }
    record
}

#[test]
fn a_loop_is_cut_at_its_jumps_and_its_area_is_the_work() {
    let record = invented_loop();
    let curves = Curves::new(&record, &law());
    assert!(!curves.loss.is_empty() && curves.flat.is_some());
    assert_eq!(curves.lines_of(Branch::Approach).count(), 5);
    assert_eq!(curves.lines_of(Branch::Retraction).count(), 5);
    assert_eq!(curves.names(Branch::Approach).iter().map(|name| name.1).collect::<Vec<_>>(), ["bulge", "ridge", "dimple"]);
    let shoelace = |p: &Vec<(f64, f64)>| {
        let next = p.iter().cycle().skip(1);
        0.5 * p.iter().zip(next).map(|(a, b)| a.0 * b.1 - b.0 * a.1).sum::<f64>()
    };
    let drawn: f64 = curves.loss.iter().map(shoelace).sum::<f64>() * law().traction_max() * law().range;
    // Drawn with straight lines from state to state.
    let pieces =
        record.states.windows(2).map(|s| 0.5 * (s[0].stress + s[1].stress) * (s[1].mean_displacement - s[0].mean_displacement));
    let work: f64 = pieces.sum();
    assert!((drawn.abs() - work).abs() < 1e-5, "drawn {drawn}, work {work}");
}

#[test]
fn a_loop_becomes_an_svg_and_a_png() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (svg, png) = (folder.path().join("loop.svg"), folder.path().join("loop.png"));
    let record = invented_loop();
    write_loop_svg(&svg, &record, &law(), "Fig. 2: four patterns <&>", Some(0.01)).expect("an SVG");
    write_loop_png(&png, &record, &law(), "Fig. 2: four patterns <&>", Some(0.01)).expect("a PNG");
    let text = std::fs::read_to_string(&svg).expect("text");
    assert!(text.contains("Dissipated energy") && text.contains("&lt;&amp;&gt;") && text.contains("retraction"));
    let picture = image::ImageReader::open(&png).expect("the PNG").decode().expect("a picture").into_rgb8();
    assert_eq!(picture.dimensions(), (1600, 1000));
    let blue = picture.pixels().filter(|p| p.0[2] > 150 && p.0[0] < 90).count();
    let red = picture.pixels().filter(|p| p.0[0] > 150 && p.0[2] < 90 && p.0[1] < 90).count();
    assert!(blue > 2000 && red > 2000, "approach {blue} and retraction {red} pixels");
}

#[test]
fn the_ticks_of_a_narrow_drive_are_told_apart() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (middle, width) in [(3.1, 1e-6), (0.0, 1e-9), (2e6, 1.0), (0.004, 1e-3), (3.0, 4.0)] {
        let mut record = LoopRecord::default();
        record
            .states
            .extend((0..=20).map(|i| state(Branch::Approach, Pattern::Bulge, middle + width * (0.5 - f64::from(i) / 20.0))));
        let path = folder.path().join("narrow.svg");
        write_loop_svg(&path, &record, &law(), "", None).expect("an SVG");
        let text = std::fs::read_to_string(&path).expect("text");
        // The numbers below the x axis stand centred under their ticks.
        let lines: Vec<&str> = text.lines().collect();
        let centred = lines.windows(2).filter(|pair| pair[0].contains("text-anchor=\"middle\"") && !pair[0].contains("rotate"));
        let mut numbers: Vec<&str> = centred.map(|pair| pair[1]).filter(|word| !word.contains("displacement")).collect();
        let all = numbers.len();
        numbers.dedup();
        assert!(all >= 4 && numbers.len() == all, "{middle} +- {width}: {numbers:?}");
    }
}

#[test]
fn pictures_of_nothing_and_of_broken_numbers_are_drawn_too() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let empty = LoopRecord::default();
    write_loop_png(&folder.path().join("empty.png"), &empty, &law(), "", None).expect("a picture");
    let mut one = LoopRecord::default();
    one.states.push(state(Branch::Approach, Pattern::Flat, 4.0));
    write_loop_svg(&folder.path().join("one.svg"), &one, &law(), "bell \u{7}", Some(0.01)).expect("a picture");
    let mut broken = invented_loop();
    broken.states[7].stress_over_max = f64::NAN;
    broken.states[9].mean_displacement = f64::INFINITY;
    broken.jumps[0].stress_after = f64::NAN;
    write_loop_svg(&folder.path().join("broken.svg"), &broken, &law(), "broken", Some(0.01)).expect("a picture");
    write_gap_png(&folder.path().join("deep").join("gap.png"), &Array2::from_elem((4, 4), f64::NAN)).expect("a picture");
}
