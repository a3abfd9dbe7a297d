//! The smallest eigenvalue looked for on a coarser mesh, against the same on the mesh itself.

use super::common::LAW;
use crate::loops::{preset_on, reach, start};
use proptest::prelude::*;
use rand::SeedableRng;
use rand_pcg::Pcg64;
use tackscope::physics::indenter::Indenter;
use tackscope::physics::mesh::Grid;
use tackscope::physics::pattern::Pattern;
use tackscope::physics::system::{System, carried};
use tackscope::scene::{Part, Points};
use tackscope::solver::mechanics::{Mechanics, Slides};
use tackscope::solver::stability::{Tracker, random_smooth};

const LENGTH: f64 = 256.0;

fn system(n: usize) -> System {
    System::new(Grid::square(LENGTH, n), LAW, &Indenter::Flat)
}

/// The state of Fig. 2 on n = 64 at this place on approach.
fn state(place: f64) -> (Pattern, Vec<f64>) {
    let mut walk = start(&preset_on("fig2", Points::Square(64)), Part::Whole);
    reach(&mut walk, place);
    let amplitudes = walk.here().state.amplitudes.clone();
    (walk.record().pattern, amplitudes)
}

/// Value and error on 128 x 128 points, by way of `coarse` points if given; transforms spent on the
/// fine mesh.
fn smallest(z: &[f64], u0: f64, coarse: Option<usize>) -> (f64, f64, usize) {
    let mut fine = Mechanics::new(system(128), Slides::Freely);
    let at = fine.at(carried(z, &system(64), &fine.system), u0);
    fine.refresh(&at.fields);
    let mut tracker = Tracker::new(Pcg64::seed_from_u64(7));
    if let Some(n) = coarse {
        tracker = tracker.with_coarse(Mechanics::new(system(n), Slides::Freely));
    }
    let before = fine.transforms();
    let (found, mode) = tracker.check(&mut fine, &at.state.amplitudes, &at.fields);
    assert_eq!(mode.len(), at.gradient.len());
    (
        found.value * LENGTH,
        found.error * LENGTH,
        fine.transforms() - before,
    )
}

#[test]
fn a_coarser_mesh_finds_the_same_smallest_eigenvalue_for_one_product_on_the_fine_one() {
    for (pattern, u0) in [
        (Pattern::Bulge, 3.0),
        (Pattern::Ridge, 2.0),
        (Pattern::Ridge, 1.345),
        (Pattern::Dimple, 0.8),
    ] {
        let (found, z) = state(u0);
        assert_eq!(found, pattern);
        let (value, error, there) = smallest(&z, u0, None);
        let (coarse, bound, here) = smallest(&z, u0, Some(88));
        assert!(
            (coarse - value).abs() < 1e-3 * value.abs().max(0.1),
            "{pattern} at {u0}: {coarse} against {value}"
        );
        // From below to a third of the value on either mesh, and next to an end to its sign.
        let share = if value < 0.005 * std::f64::consts::TAU {
            1.0
        } else {
            0.36
        };
        assert!(
            bound <= share * coarse * 1.001 && error <= share * value,
            "{pattern}: {bound} {error}"
        );
        assert!(
            here <= 2 && there > 20,
            "{pattern}: {here} and {there} transforms"
        );
    }
}

/// A quarter of a cell is bounded from above, and checked only where the whole cell is softer: both
/// by way of the same coarse mesh.
#[test]
fn a_bound_from_above_and_a_check_share_the_modes_of_a_coarse_mesh() {
    let (u0, (_, z)) = (3.0, state(3.0));
    let mut fine = Mechanics::new(system(128), Slides::Freely);
    let at = fine.at(carried(&z, &system(64), &fine.system), u0);
    fine.refresh(&at.fields);
    let coarse = Mechanics::new(system(88), Slides::Freely);
    let mut tracker = Tracker::new(Pcg64::seed_from_u64(7)).with_coarse(coarse);
    let before = fine.transforms();
    let (above, _) = tracker.above(&mut fine, &at.state.amplitudes, &at.fields);
    let (checked, _) = tracker.check(&mut fine, &at.state.amplitudes, &at.fields);
    let spent = fine.transforms() - before;
    assert!(spent <= 4, "{spent} transforms of the fine mesh");
    let off = (above.value - checked.value).abs();
    assert!(
        off <= above.error.max(checked.error),
        "{above:?} {checked:?}"
    );
}

#[test]
fn where_the_coarse_mesh_does_not_resolve_the_mode_the_fine_one_goes_on() {
    // The edge of a bulge on twelve points is no edge.
    let (u0, (_, z)) = (3.0, state(3.0));
    let (value, ..) = smallest(&z, u0, None);
    let (coarse, bound, here) = smallest(&z, u0, Some(12));
    assert!(
        (coarse - value).abs() < 0.02 * value.abs(),
        "{coarse} against {value}"
    );
    assert!(
        here > 20 && bound <= 0.36 * coarse,
        "{here} transforms, error {bound}"
    );
}

proptest! {
    #[test]
    fn a_field_carried_to_a_finer_mesh_is_the_same_field_and_comes_back(seed: u64, n in 3usize..9, more in 1usize..5) {
        let (coarse, fine) = (system(4 * n), system(4 * n * more));
        let mut z = random_smooth(&coarse, &mut Pcg64::seed_from_u64(seed));
        // Without the shortest waves, which the finer mesh shows in another way.
        z = carried(&carried(&z, &coarse, &system(4 * n - 2)), &system(4 * n - 2), &coarse);
        let up = carried(&z, &coarse, &fine);
        prop_assert_eq!(&carried(&up, &fine, &coarse), &z);
        let (few, many) = (coarse.gap_field(&z, 0.3), fine.gap_field(&up, 0.3));
        for ((j, i), g) in few.indexed_iter() {
            prop_assert!((g - many[(j * more, i * more)]).abs() < 1e-12);
        }
    }
}
