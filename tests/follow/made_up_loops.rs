//! Ledgers of loops that are made up, whose areas are known by hand: what counts as closed, as lossy
//! between the jumps, and as integrated well enough.

use tackscope::follow::ledger::Ledger;
use tackscope::follow::record::{Cause, Direction, JumpRecord, LoopRecord, StateRecord};
use tackscope::physics::control::Control;
use tackscope::physics::pattern::Pattern;
use tackscope::scene::Part;
use tackscope::solver::Stop;

/// A branch from u0 = 3 to its fold at 1, and another from 0 to its fold at 2: towards a fold the
/// stress goes as a root.
fn upper(u0: f64) -> f64 {
    1.0 - (u0 - 1.0).sqrt()
}
fn lower(u0: f64) -> f64 {
    2.0 + (2.0 - u0).sqrt()
}
/// Of the difference, from 1 to 2.
const AREA: f64 = 7.0 / 3.0;
const STEP: f64 = 0.05;

fn state(direction: Direction, u0: f64, [stress, residual]: [f64; 2]) -> StateRecord {
    StateRecord {
        direction,
        control: u0,
        mean_displacement: u0,
        stress,
        stress_over_max: stress,
        contact_area: 0.0,
        pattern: Pattern::Flat,
        residual,
        stiffness_min: 1.0,
        stiffness_error: 0.0,
        energy: 0.0,
        part: Part::Whole,
        stop: Stop::Stable,
        iterations: 0,
        transforms: 0,
        milliseconds: 0.0,
    }
}

fn jump(direction: Direction, control: f64, [before, after]: [f64; 2], cause: Cause) -> JumpRecord {
    JumpRecord {
        direction,
        control,
        mean_displacement: control,
        mean_displacement_after: control,
        from: Pattern::Flat,
        to: Pattern::Flat,
        stress_before: before,
        stress_after: after,
        released_energy: 0.5 * AREA,
        release_error: 0.0,
        cause,
        landings: Vec::new(),
    }
}

/// The loop from 3 to 0 and back, gamma = 1, its states [`STEP`] apart.
fn made_up() -> LoopRecord {
    use Direction::{Approach, Retraction};
    let mut record = LoopRecord::of(Control::Displacement);
    let mut leg = |direction, from: i32, to: i32, stress: fn(f64) -> f64| {
        let way = if to > from { 1 } else { -1 };
        for k in 0..=(to - from).abs() {
            let u0 = STEP * f64::from(from + way * k);
            record.states.push(state(direction, u0, [stress(u0), 0.0]));
        }
    };
    leg(Approach, 60, 20, upper);
    leg(Approach, 20, 0, lower);
    leg(Retraction, 1, 40, lower);
    leg(Retraction, 40, 60, upper);
    record.jumps = vec![
        jump(Approach, 1.0, [upper(1.0), lower(1.0)], Cause::Fold),
        jump(Retraction, 2.0, [lower(2.0), upper(2.0)], Cause::Fold),
    ];
    record
}

fn ledger(record: &LoopRecord) -> Ledger {
    record.ledger(1.0)
}

#[test]
fn towards_folds_the_integral_is_that_of_roots() {
    let told = ledger(&made_up());
    assert_eq!((told.open.as_ref(), told.viscous), (None, false));
    assert!((told.loop_integral - AREA).abs() < 1e-9, "{told:?}");
    assert!((told.dissipated_energy().unwrap() - AREA).abs() < 1e-12);
    assert_eq!(told.warning(), None);
}

#[test]
fn a_transition_told_too_late_hides_no_jump() {
    let mut record = made_up();
    for at in [1.35, 1.75] {
        let kink = jump(Direction::Approach, at, [upper(at); 2], Cause::Transition);
        let jumps = &mut record.jumps;
        jumps.insert(
            jumps.len() - 2,
            JumpRecord {
                released_energy: 0.0,
                ..kink
            },
        );
    }
    let told = ledger(&record);
    // Before the fold the stress is smooth, and integrated as well as it says.
    let off = (told.loop_integral - AREA).abs();
    assert!(off < told.integral_error && off < 1e-5, "{told:?}");
}

#[test]
fn a_last_stress_off_by_a_thousandth_leaves_a_loop_open_unless_its_residual_is_as_large() {
    let off_by = |off: f64, residual: f64| {
        let mut record = made_up();
        let last = record.states.last_mut().unwrap();
        (last.stress_over_max, last.residual) = (last.stress_over_max + off, residual);
        ledger(&record)
    };
    assert_eq!(off_by(5e-5, 0.0).open, None);
    assert_eq!(off_by(1e-3, 2e-3).open, None);
    for (off, residual) in [(1e-3, 0.0), (1e-3, 1e-4), (f64::NAN, 0.0)] {
        let told = off_by(off, residual);
        assert!(told.open.is_some(), "{off} {residual}");
        assert_eq!(
            (told.dissipated_energy(), told.stated_error(0.0)),
            (None, None)
        );
    }
}

#[test]
fn energy_is_lost_between_jumps_where_a_state_was_not_at_rest() {
    let unfinished = |residual: f64| {
        let mut record = made_up();
        let state = &mut record.states[5];
        (state.stop, state.residual) = (Stop::NotConverged, residual);
        ledger(&record)
    };
    // Of such a state the stability alone was not decided.
    assert!(!unfinished(1e-6).viscous);
    for residual in [1e-4, f64::NAN] {
        let told = unfinished(residual);
        assert!(told.viscous);
        assert_eq!(told.dissipated_energy(), Some(told.loop_integral));
        assert_eq!((told.stated_error(0.0), told.mismatch()), (None, None));
    }
}

#[test]
fn the_stated_error_of_the_loss_is_that_of_the_mesh_and_of_the_ends() {
    let mut record = made_up();
    record
        .jumps
        .iter_mut()
        .for_each(|jump| jump.release_error = 1e-3 * AREA);
    let told = ledger(&record).stated_error(5e-3).unwrap();
    assert!((told - 7e-3).abs() < 1e-12, "{told}");
    assert_eq!(ledger(&record).stated_error(1.0), None);
}

#[test]
fn a_way_back_beside_the_way_gone_closes_no_loop() {
    let closed_after = |off: f64| {
        let mut record = made_up();
        // By hand the last state lies between two of the way gone before.
        let u0 = 2.5 * STEP + 2.5;
        record.states.truncate(record.states.len() - 9);
        let mut last = state(Direction::Retraction, u0, [upper(u0), 0.0]);
        last.stress_over_max += off;
        record.states.push(last);
        record.closed().map(|closed| ledger(&closed))
    };
    let told = closed_after(0.0).expect("it lies on it");
    assert_eq!(told.open, None);
    assert!((told.loop_integral - AREA).abs() < 1e-9, "{told:?}");
    assert!(closed_after(0.1).is_none());
}
