//! Patterns are told by topology: against drawn shapes, an independent search in the unrolled
//! plane, and every symmetry.

use ndarray::{Array2, Axis, concatenate, s};
use proptest::prelude::*;
use std::collections::{HashMap, VecDeque};
use std::f64::consts::TAU;
use tackscope::physics::law::{Law, Morse, Shape};
use tackscope::physics::pattern::{
    Pattern, classify, contact_area, contact_set, moves_by_a_spacing,
};

const LAW: Law = Law {
    shape: Shape::Morse(Morse),
    surface_energy: 0.15,
    range: 1.0,
};

/// A gap field: 0.1 in contact, 3 elsewhere; `#` is contact.
fn drawn(rows: &[&str]) -> Array2<f64> {
    let field: Vec<f64> = rows
        .iter()
        .flat_map(|row| row.chars())
        .map(|c| if c == '#' { 0.1 } else { 3.0 })
        .collect();
    Array2::from_shape_vec((rows.len(), rows[0].len()), field).unwrap()
}

fn on_flat(gap: &Array2<f64>) -> Pattern {
    classify(gap.view(), &LAW, true)
}

/// The field cyclically moved by (dy, dx).
fn moved(gap: &Array2<f64>, dy: usize, dx: usize) -> Array2<f64> {
    let rows = concatenate![Axis(0), gap.slice(s![dy.., ..]), gap.slice(s![..dy, ..])];
    concatenate![Axis(1), rows.slice(s![.., dx..]), rows.slice(s![.., ..dx])]
}

#[test]
fn an_island_is_a_bulge_even_when_the_edge_cuts_it() {
    let gap = drawn(&["......", "..##..", "..##..", "......"]);
    for (dy, dx) in [(0, 0), (2, 3), (1, 4), (3, 5)] {
        assert_eq!(on_flat(&moved(&gap, dy, dx)), Pattern::Bulge);
    }
}

#[test]
fn a_line_around_the_cell_is_a_ridge_in_any_direction() {
    assert_eq!(
        on_flat(&drawn(&["....", "####", "....", "...."])),
        Pattern::Ridge
    );
    assert_eq!(
        on_flat(&drawn(&[".#..", ".#..", ".#..", ".#.."])),
        Pattern::Ridge
    );
    assert_eq!(
        on_flat(&drawn(&["##..", ".##.", "..##", "#..#"])),
        Pattern::Ridge
    );
    assert_eq!(
        on_flat(&drawn(&["..##", ".##.", "##..", "#..#"])),
        Pattern::Ridge
    );
}

#[test]
fn an_undulating_line_that_crosses_the_edge_twice_is_still_one_ridge() {
    assert_eq!(
        on_flat(&drawn(&["##....", ".#....", ".#....", "##...#", "#....#"])),
        Pattern::Ridge
    );
}

#[test]
fn a_steep_spiral_is_a_ridge_because_all_its_loops_are_parallel() {
    // Winds three times along x while it winds once along y.
    let gap = Array2::from_shape_fn(
        (18, 18),
        |(j, i)| if (i + 3 * j) % 18 < 6 { 0.1 } else { 3.0 },
    );
    assert_eq!(on_flat(&gap), Pattern::Ridge);
}

#[test]
fn a_net_of_contact_around_an_island_of_air_is_a_dimple() {
    let gap = drawn(&["######", "##..##", "##..##", "######"]);
    for (dy, dx) in [(0, 0), (2, 3), (1, 4), (3, 5)] {
        assert_eq!(on_flat(&moved(&gap, dy, dx)), Pattern::Dimple);
    }
    assert_eq!(
        on_flat(&drawn(&["#...", "####", "#...", "#..."])),
        Pattern::Dimple
    );
}

#[test]
fn a_loop_is_not_forgotten_when_a_larger_piece_takes_it_in() {
    // The full first row is one run; the island of many runs meets it only below the last row.
    assert_eq!(
        on_flat(&drawn(&[
            "######", "......", ".#.#..", ".###..", ".#.#..", ".#...."
        ])),
        Pattern::Ridge
    );
    // The comb has more runs than row and column together when they meet; the loop along y closes
    // afterwards.
    let comb = [
        "#########",
        "#........",
        "#.#.#.#..",
        "#.#.#.#..",
        "#.#.#.#..",
        "#.#####..",
        "#######..",
        "#........",
    ];
    assert_eq!(on_flat(&drawn(&comb)), Pattern::Dimple);
}

#[test]
fn several_islands_are_a_bulge_and_a_line_among_islands_is_a_ridge() {
    assert_eq!(
        on_flat(&drawn(&["#...", "..#.", "....", "...."])),
        Pattern::Bulge
    );
    assert_eq!(
        on_flat(&drawn(&["####", "....", ".#..", "....", "..#.", "...."])),
        Pattern::Ridge
    );
}

#[test]
fn points_that_touch_only_by_a_corner_are_not_connected() {
    assert_eq!(
        on_flat(&drawn(&["#...", ".#..", "..#.", "...#"])),
        Pattern::Bulge
    );
}

#[test]
fn a_uniform_gap_is_flat_and_a_hair_of_noise_does_not_matter() {
    let noise = Array2::from_shape_fn((8, 8), |(j, i)| {
        2.0 + 9e-5 * ((3 * i + 5 * j) % 7) as f64 / 6.0
    });
    assert_eq!(on_flat(&noise), Pattern::Flat);
    assert_eq!(on_flat(&(noise * 1.2)), Pattern::Bulge);
    assert_eq!(on_flat(&Array2::from_elem((8, 8), -1.0)), Pattern::Flat);
}

#[test]
fn a_faint_shape_on_one_side_of_the_contact_gap_is_told_by_its_shape() {
    let wave = |i: usize| (TAU * i as f64 / 32.0).cos();
    let ridge = |mean: f64| Array2::from_shape_fn((32, 32), |(_, i)| mean - 0.1 * wave(i));
    // Morse: contact below ln 2 = 0.69; these lie wholly above, or wholly below.
    for mean in [2.5, -1.0] {
        assert_eq!(on_flat(&ridge(mean)), Pattern::Ridge);
    }
    // A peaked cap: more than half of its height only near its tip.
    let cap = Array2::from_shape_fn((32, 32), |(j, i)| {
        2.5 - 0.1 * (2.0 * (wave(i) + wave(j))).exp()
    });
    assert_eq!(on_flat(&cap), Pattern::Bulge);
    assert_eq!(on_flat(&(cap.mapv(|g| -g))), Pattern::Dimple);
}

#[test]
fn on_a_line_cell_whatever_is_not_flat_is_a_ridge() {
    assert_eq!(on_flat(&drawn(&["..##.."])), Pattern::Ridge);
    assert_eq!(on_flat(&drawn(&["##..##"])), Pattern::Ridge);
    assert_eq!(on_flat(&drawn(&["......"])), Pattern::Flat);
}

#[test]
fn on_uneven_ground_only_contact_is_asked_for() {
    let touching = drawn(&["......", "..##..", "......"]);
    assert_eq!(classify(touching.view(), &LAW, false), Pattern::Contact);
    assert_eq!(
        classify(drawn(&["......"]).view(), &LAW, false),
        Pattern::Other
    );
    assert_eq!(
        classify(drawn(&["######"]).view(), &LAW, false),
        Pattern::Contact
    );
}

#[test]
fn a_field_with_a_nan_or_without_points_is_no_pattern() {
    let mut gap = drawn(&["......", "..##..", "......"]);
    gap[[0, 3]] = f64::NAN;
    assert_eq!(on_flat(&gap), Pattern::Other);
    assert_eq!(classify(gap.view(), &LAW, false), Pattern::Other);
    assert_eq!(on_flat(&Array2::zeros((0, 0))), Pattern::Other);
}

#[test]
fn the_contact_area_is_the_share_of_points_below_the_gap_of_the_largest_traction() {
    let gap = drawn(&["......", "..##..", "......"]);
    assert_eq!(contact_area(gap.view(), &LAW), 2.0 / 18.0);
    assert_eq!(
        contact_set(gap.view(), 1.0).iter().filter(|&&c| c).count(),
        2
    );
    let edge = Array2::from_elem((2, 2), LAW.contact_gap());
    assert_eq!(
        contact_area(edge.view(), &LAW),
        0.0,
        "the gap of the largest traction itself is not contact"
    );
}

#[test]
fn a_field_seen_through_a_transposed_or_reversed_view_is_read_right() {
    let gap = drawn(&["....", "####", "....", "...."]);
    assert_eq!(classify(gap.t(), &LAW, true), Pattern::Ridge);
    assert_eq!(
        classify(gap.slice(s![..;-1, ..;-1]), &LAW, true),
        Pattern::Ridge
    );
}

/// The pattern by another strategy: a search in the plane that the torus unrolls into. From a
/// starting point, every copy of it that can be reached is a winding vector.
fn searched(contact: &Array2<bool>) -> Pattern {
    let (ny, nx) = contact.dim();
    let (ny, nx) = (ny as i64, nx as i64);
    let mut rank = 0;
    for ((j, i), _) in contact.indexed_iter().filter(|&(_, &c)| c) {
        let start = (j as i64, i as i64);
        let mut seen = HashMap::from([(start, ())]);
        let mut queue = VecDeque::from([start]);
        let mut windings: Vec<(i64, i64)> = Vec::new();
        while let Some((y, x)) = queue.pop_front() {
            for (y, x) in [(y + 1, x), (y - 1, x), (y, x + 1), (y, x - 1)] {
                let home = (y.rem_euclid(ny), x.rem_euclid(nx));
                let near = (y - start.0).abs() <= 5 * ny && (x - start.1).abs() <= 5 * nx;
                if !near
                    || !contact[[home.0 as usize, home.1 as usize]]
                    || seen.insert((y, x), ()).is_some()
                {
                    continue;
                }
                if home == start {
                    windings.push(((y - start.0) / ny, (x - start.1) / nx));
                }
                queue.push_back((y, x));
            }
        }
        let independent = windings
            .iter()
            .any(|a| windings.iter().any(|b| a.0 * b.1 != a.1 * b.0));
        rank = rank.max(if independent {
            2
        } else {
            usize::from(!windings.is_empty())
        });
    }
    [Pattern::Bulge, Pattern::Ridge, Pattern::Dimple][rank]
}

/// Random fields about the percolation threshold, where islands, lines and nets are all common.
fn random_field() -> impl Strategy<Value = Array2<f64>> {
    (2_usize..8, 2_usize..8, 0.2..0.9_f64).prop_flat_map(|(ny, nx, share)| {
        prop::collection::vec(prop::bool::weighted(share), ny * nx).prop_map(move |points| {
            let gaps = points.iter().map(|&c| if c { 0.1 } else { 3.0 }).collect();
            Array2::from_shape_vec((ny, nx), gaps).unwrap()
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn the_topology_agrees_with_a_search_in_the_unrolled_plane(gap in random_field()) {
        let contact = contact_set(gap.view(), LAW.contact_gap());
        let some = contact.iter().any(|&c| c) && contact.iter().any(|&c| !c);
        let expected = if some { searched(&contact) } else { Pattern::Flat };
        prop_assert_eq!(on_flat(&gap), expected);
    }

    #[test]
    fn translation_reflection_and_swapping_x_and_y_change_nothing(gap in random_field(), dy in 0_usize..8, dx in 0_usize..8) {
        let pattern = on_flat(&gap);
        let (ny, nx) = gap.dim();
        prop_assert_eq!(on_flat(&moved(&gap, dy % ny, dx % nx)), pattern);
        prop_assert_eq!(on_flat(&gap.slice(s![..;-1, ..]).to_owned()), pattern);
        prop_assert_eq!(on_flat(&gap.slice(s![.., ..;-1]).to_owned()), pattern);
        prop_assert_eq!(on_flat(&gap.t().to_owned()), pattern);
        let area = contact_area(gap.view(), &LAW);
        prop_assert_eq!(contact_area(moved(&gap, dy % ny, dx % nx).view(), &LAW), area);
    }

    #[test]
    fn the_unit_of_length_changes_nothing(gap in random_field(), scale in 1e-3..1e3_f64) {
        let law = Law { range: scale, surface_energy: 0.15 * scale, ..LAW };
        prop_assert_eq!(classify((&gap * scale).view(), &law, true), on_flat(&gap));
    }
}

/// A disc of this radius (spacings) about a point of a torus of 24 x 24.
fn disc(radius: f64, centre: [f64; 2]) -> Array2<bool> {
    let away = |i: usize, c: f64| (i as f64 - c + 36.0).rem_euclid(24.0) - 12.0;
    Array2::from_shape_fn((24, 24), |(y, x)| {
        away(y, centre[0]).hypot(away(x, centre[1])) < radius
    })
}

#[test]
fn an_edge_that_moves_by_a_spacing_is_told_from_one_that_moves_farther_and_from_an_island_of_its_own()
 {
    let here = disc(6.3, [0.0, 0.0]);
    assert!(moves_by_a_spacing(&here, &here));
    assert!(
        moves_by_a_spacing(&here, &disc(7.2, [0.0, 0.0]))
            && moves_by_a_spacing(&here, &disc(5.4, [0.0, 0.0]))
    );
    assert!(
        moves_by_a_spacing(&here, &disc(6.3, [1.0, 0.0])),
        "it slides"
    );
    assert!(
        !moves_by_a_spacing(&here, &disc(9.5, [0.0, 0.0]))
            && !moves_by_a_spacing(&here, &disc(6.3, [3.0, 0.0]))
    );
    let mut island = here.clone();
    island[[12, 12]] = true;
    assert!(
        !moves_by_a_spacing(&here, &island),
        "one point alone, but not at the edge"
    );
    let nothing = Array2::from_elem((24, 24), false);
    assert!(!moves_by_a_spacing(&nothing, &nothing), "no edge");
}
