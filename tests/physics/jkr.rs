//! The tip without range of adhesion: closed forms, and what the images of a periodic cell change.

use tackscope::physics::theory::jkr::Jkr;
use tackscope::physics::theory::jkr_periodic::PeriodicJkr;
use tackscope::physics::theory::{tabor, tabor_of_mesh};

const TIP: Jkr = Jkr {
    radius: 1.0,
    surface_energy: 0.5859e-3,
};

/// a, u0, F (positive in compression), energy, for gamma = 0.5859e-3 and R = 1.
///
/// Rows of the project's reference file jkr.csv, printed with ten digits.
const JKR: [[f64; 4]; 8] = [
    [
        0.02757445738,
        0.009314883976,
        -0.0005276832477,
        1.126395414e-06,
    ],
    [
        0.07077085175,
        0.01113242919,
        -0.001812007501,
        2.537438449e-06,
    ],
    [
        0.106374401,
        0.008473322711,
        -0.002605143212,
        -3.667113967e-06,
    ],
    [
        0.1419779502,
        0.002704151836,
        -0.002675829448,
        -1.936777548e-05,
    ],
    [
        0.1775814994,
        -0.005966966096,
        -0.001614131849,
        -3.867990815e-05,
    ],
    [
        0.2131850486,
        -0.01743354691,
        0.00097393956,
        -4.340072827e-05,
    ],
    [
        0.2487885978,
        -0.03163242205,
        0.005473597898,
        8.998588105e-07,
    ],
    [
        0.2630300175,
        -0.03806731575,
        0.007893909089,
        4.379260236e-05,
    ],
];

/// a, u0, F (positive in compression) in a cell with L = R = 1, gamma = 0.5859e-3.
///
/// Rows of the project's reference file jkr_periodic.csv: a boundary-element solution in a periodic
/// cell.
const PERIODIC: [[f64; 3]; 9] = [
    [0.03, 0.00887189811057886, -0.0005945721460208984],
    [0.05, 0.009595104480502846, -0.0011903285044406638],
    [0.08, 0.008223627806900754, -0.0020651654144588755],
    [0.10, 0.006123191619080121, -0.002508904114522827],
    [0.1275, 0.002063710389927288, -0.0027723190607387036],
    [0.15, -0.0020540229238825793, -0.002567049064273668],
    [0.175, -0.00727266445780219, -0.0017574785018206326],
    [0.2, -0.0129971270400224, -0.00019273005272526546],
    [0.24, -0.022824899893930654, 0.004275903036636601],
];

fn close(found: f64, expected: f64, share: f64) {
    assert!(
        (found / expected - 1.0).abs() <= share,
        "{found:e} for {expected:e}: {:.1e}",
        found / expected - 1.0
    );
}

#[test]
fn the_branch_is_that_of_the_reference_table() {
    for [a, u0, force, energy] in JKR {
        let state = TIP.contact(a);
        // Ten digits are printed, of a as well, with which u0 and so the energy change.
        let slope = 2.0 * a + 0.5 * TIP.opening(a) / a;
        close(state.displacement, u0, 1e-8);
        close(-state.force, force, 1e-8);
        let rounding = 5e-11 * force.abs() * slope + 5e-10 * energy.abs();
        assert!(
            (state.energy - energy).abs() < rounding,
            "{:e} for {energy:e}: {rounding:e}",
            state.energy
        );
    }
}

#[test]
fn the_ends_of_the_branch_are_the_reference_ones() {
    // The project's reference constants.json, where they were evaluated and checked by a second
    // method.
    close(TIP.pull_off_force(), 0.0027609887036073896, 1e-14);
    close(TIP.end_under_force().radius, 0.12746040606187442, 1e-14);
    close(TIP.end_under_force().force, TIP.pull_off_force(), 1e-14);
    let end = TIP.end_of_displacement();
    close(end.radius, 0.06127657195798206, 1e-13);
    close(end.displacement, 0.011264454812765255, 1e-13);
    close(end.force / TIP.pull_off_force(), 5.0 / 9.0, 1e-13);
    let touch = TIP.touch();
    close(touch.radius, 0.15440728575051899, 1e-13);
    assert!(touch.displacement.abs() < 1e-16);
    close(touch.force / TIP.pull_off_force(), 8.0 / 9.0, 1e-13);
    close(TIP.zero_load().radius, 0.20233078266691332, 1e-13);
    close(TIP.jump_in(), 2.633056623598085e-05, 1e-13);
    close(TIP.snap_off(), 2.7645362213636223e-6, 1e-13);
    close(
        TIP.dissipation() / TIP.surface_energy.powf(5.0 / 3.0),
        7.092195971863964,
        1e-13,
    );
}

#[test]
fn force_is_the_slope_of_the_energy_and_the_ends_are_where_they_claim() {
    let tip = Jkr {
        radius: 3.0,
        surface_energy: 0.02,
    };
    for a in [0.3, 0.6, 1.1] {
        let (less, more) = (tip.contact(a * (1.0 - 1e-5)), tip.contact(a * (1.0 + 1e-5)));
        close(
            (more.energy - less.energy) / (more.displacement - less.displacement),
            tip.contact(a).force,
            1e-7,
        );
    }
    let beside = |a: f64| [a * 0.999, a * 1.001].map(|a| tip.contact(a));
    let end = tip.end_of_displacement();
    assert!(
        beside(end.radius)
            .iter()
            .all(|s| s.displacement < end.displacement)
    );
    let end = tip.end_under_force();
    assert!(beside(end.radius).iter().all(|s| s.force < end.force));
}

#[test]
fn lifted_as_a_whole_by_point_images_it_is_the_reference_constant_to_all_digits() {
    // The project's reference constants.json, "periodic_L=1_simple" and so on.
    for (length, a, u0, loss) in [
        (
            1.0,
            0.049277991353502616,
            0.009590544599505446,
            0.817210791091659,
        ),
        (
            2.0,
            0.05511772407057656,
            0.010370401904150601,
            0.9095642431209379,
        ),
        (
            4.0,
            0.05817600123431682,
            0.010802905722941139,
            0.955055239294218,
        ),
    ] {
        let periodic = PeriodicJkr {
            tip: TIP,
            length,
            order: 0,
        };
        // The place of a maximum of u0 is known to the root of rounding.
        close(periodic.end_of_displacement().radius, a, 1e-8);
        close(periodic.end_of_displacement().mean_displacement, u0, 1e-12);
        close(periodic.dissipation() / TIP.dissipation(), loss, 1e-9);
    }
}

#[test]
fn with_all_images_it_is_the_boundary_element_solution() {
    let periodic = PeriodicJkr::new(TIP, 1.0);
    let pull = TIP.pull_off_force();
    for [a, u0, force] in PERIODIC {
        let state = periodic.contact(a);
        // The fourfold part of the images' field, left out here, grows as (a/L)^5 in its effect on
        // either.
        let share = 1e-11 + a.powi(9);
        assert!(
            (state.mean_displacement - u0).abs() <= 0.01 * share,
            "{a}: {state:?}"
        );
        assert!(
            (-state.force - force).abs() <= pull * share,
            "{a}: {state:?}"
        );
    }
    // The project's reference constants.json, "jkr_periodic_L=R".
    let (end, touch, most) = (
        periodic.end_of_displacement(),
        periodic.touch(),
        periodic.pull_off(),
    );
    close(most.force / pull, 1.0041178332721226, 1e-7);
    close(end.mean_displacement, 0.009595754290978606, 1e-7);
    // Where a maximum lies is known only to the root of that.
    close(end.radius, 0.04937931019061623, 1e-5);
    close(touch.radius, 0.13920152365514307, 1e-7);
    close(touch.force, 0.0027204406239467677, 1e-7);
    close(
        periodic.dissipation() / TIP.dissipation(),
        0.8210065848790686,
        1e-7,
    );
}

#[test]
fn each_further_order_of_the_images_changes_less() {
    let loss = |order| {
        PeriodicJkr {
            tip: TIP,
            length: 1.0,
            order,
        }
        .dissipation()
            / TIP.dissipation()
    };
    let losses: Vec<f64> = (0..=6).map(loss).collect();
    let changes: Vec<f64> = losses.windows(2).map(|l| (l[1] - l[0]).abs()).collect();
    assert!(changes.windows(2).all(|c| c[1] < 0.2 * c[0]), "{changes:?}");
}

#[test]
fn a_large_cell_has_no_images() {
    let periodic = PeriodicJkr::new(TIP, 1e6);
    let alone = TIP.contact(0.1);
    let state = periodic.contact(0.1);
    // The nearest images are 1e6 away and lift the surface by 3.9 F/(pi L) = 3e-9.
    assert!((state.mean_displacement - alone.displacement).abs() < 4e-9);
    close(state.force, alone.force, 1e-13);
}

#[test]
fn the_tabor_parameter_of_a_mesh_is_equation_32() {
    // 0.5785 is printed in the project's physics notes, 0.579 in the paper.
    close(
        tabor_of_mesh(1.0, 1.0, TIP.surface_energy, 1.0),
        0.5785406937032278,
        1e-14,
    );
    for (mu, n) in [(0.5, 32.0), (1.0, 256.0_f64)] {
        let range = (TIP.surface_energy / n).sqrt() / (2.0 * mu);
        close(
            tabor(1.0, TIP.surface_energy, range),
            tabor_of_mesh(mu, 1.0, TIP.surface_energy, n),
            1e-14,
        );
    }
    // R and gamma scale as they should: mu_T has no dimension.
    close(
        tabor(5.0, 5.0 * TIP.surface_energy, 5.0 * 0.002),
        tabor(1.0, TIP.surface_energy, 0.002),
        1e-14,
    );
}
