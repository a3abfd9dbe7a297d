//! The ledger of loops: the loss is the sum of releases and within its error; the integral is its
//! check; a loop that does not close has none.

use crate::loops::{driven, on, planned, preset, preset_on, start, walked};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::PI;
use tackscope::follow::record::{Cause, Direction, JumpRecord, LoopRecord, StateRecord};
use tackscope::follow::run::{Outcome, run_loop};
use tackscope::follow::walk::{Observed, Progress, Stuck};
use tackscope::numerics::threads::Cancel;
use tackscope::physics::control::Control;
use tackscope::physics::indenter::{Hertz, Indenter};
use tackscope::physics::law::{Cosine, Law, Mie, Morse, Shape};
use tackscope::physics::pattern::Pattern;
use tackscope::physics::theory::flat_limits;
use tackscope::scene::{Part, Points, Scene, Turn};
use tackscope::solver::Stop;

/// A line cell of 64 points and `ratio` L_c, its law and its length.
fn line(shape: Shape, ratio: f64) -> (Scene, Law, f64) {
    let mut scene = crate::loops::flat_ground(shape, ratio, Points::Line(64));
    scene.drive.step = 0.02;
    let (law, length) = (scene.model().unwrap().law, scene.cell.length);
    (scene, law, length)
}

/// The even ridge of a line cell by dense Newton steps at fixed first amplitude, with u0 among the
/// unknowns: it goes through its fold.
struct Ridge {
    law: Law,
    length: f64,
    n: usize,
}

impl Ridge {
    fn cosine(&self, k: usize, i: usize) -> f64 {
        (2.0 * PI * (k * i) as f64 / self.n as f64).cos()
    }

    /// Elastic stiffness of the amplitude of cos(k q1 x); the shortest wave of the mesh has no sine
    /// beside it.
    fn elastic(&self, k: usize) -> f64 {
        let q = 2.0 * PI * k as f64 / self.length;
        if 2 * k == self.n { 0.5 * q } else { 0.25 * q }
    }

    fn gap(&self, x: &[f64], i: usize) -> f64 {
        x[0] + (1..=self.n / 2)
            .map(|k| x[k] * self.cosine(k, i))
            .sum::<f64>()
    }

    /// `x` = u0 and the amplitudes 1, 2, .. of the waves; the first wave's is kept. Also du0/da1
    /// along the branch. `None` where Newton's method, for which the law has an end at zero gap,
    /// does not find it.
    fn solve(&self, mut x: Vec<f64>) -> Option<(Vec<f64>, f64)> {
        let waves = self.n / 2;
        for _ in 0..60 {
            let at: Vec<_> = (0..self.n).map(|i| self.law.at(self.gap(&x, i))).collect();
            let mean = |f: &dyn Fn(usize) -> f64| (0..self.n).map(f).sum::<f64>() / self.n as f64;
            let force = DVector::from_fn(waves, |k, _| {
                self.elastic(k + 1) * x[k + 1] + mean(&|i| at[i].traction * self.cosine(k + 1, i))
            });
            let entry = |k: usize, j: usize| {
                let own = if k == j { self.elastic(k) } else { 0.0 };
                own + mean(&|i| at[i].stiffness * self.cosine(k, i) * self.cosine(j, i))
            };
            // The column of the first wave is that of u0 instead.
            let jacobian = DMatrix::from_fn(waves, waves, |k, j| {
                entry(k + 1, if j == 0 { 0 } else { j + 1 })
            });
            let lu = jacobian.lu();
            let step = lu.solve(&force)?;
            for (j, dx) in step.iter().enumerate() {
                x[if j == 0 { 0 } else { j + 1 }] -= dx;
            }
            if step.norm() < 1e-12 {
                let slope = lu.solve(&DVector::from_fn(waves, |k, _| -entry(k + 1, 1)))?[0];
                return Some((x, slope));
            }
        }
        None
    }

    fn energy(&self, x: &[f64]) -> f64 {
        let elastic: f64 = (1..=self.n / 2)
            .map(|k| 0.5 * self.elastic(k) * x[k] * x[k])
            .sum();
        elastic
            + (0..self.n)
                .map(|i| self.law.at(self.gap(x, i)).energy)
                .sum::<f64>()
                / self.n as f64
    }

    /// By bisection in the first amplitude: where `before` turns false, from a state where it is
    /// true.
    fn locate(&self, from: &[f64], step: f64, before: impl Fn(&[f64], f64) -> bool) -> Vec<f64> {
        let (mut x, mut step) = (from.to_vec(), step);
        while step > 1e-9 {
            let mut trial = x.clone();
            trial[1] += step;
            match self
                .solve(trial)
                .filter(|(trial, slope)| before(trial, *slope))
            {
                Some((trial, _)) => x = trial,
                None => step *= 0.5,
            }
        }
        x
    }
}

/// u0 and release of flat to ridge at the upper limit, and of ridge to flat at the fold, in units
/// of gamma.
fn exact_jumps(law: Law, length: f64) -> [(f64, f64); 2] {
    let ridge = Ridge { law, length, n: 64 };
    let (_, limit) = flat_limits(&law, length).unwrap();
    let mut faint = vec![0.0; 33];
    (faint[0], faint[1]) = (limit, 0.02);
    let (faint, _) = ridge.solve(faint).expect("a faint ridge");
    let fold = ridge.locate(&faint, 0.02, |_, slope| slope > 0.0);
    let landed = ridge.locate(&fold, 0.02, |x, _| x[0] > limit);
    let released = |x: &[f64]| (law.at(x[0]).energy - ridge.energy(x)) / law.surface_energy;
    [(limit, released(&landed)), (fold[0], -released(&fold))]
}

#[test]
fn releases_of_a_line_cell_are_exact_within_their_stated_error() {
    for (shape, ratio) in [
        (Shape::Morse(Morse), 1.6),
        (Shape::Morse(Morse), 2.0),
        (Shape::Mie(Mie { m: 12.0, n: 6.0 }), 1.5),
        (Shape::Mie(Mie { m: 8.0, n: 2.0 }), 2.5),
    ] {
        let (scene, law, length) = line(shape, ratio);
        let run = planned(&scene);
        let [limit, fold] = exact_jumps(law, length);
        let jump = |branch, from| {
            let of = |j: &&JumpRecord| {
                (j.direction, j.from) == (branch, from) && j.cause != Cause::Transition
            };
            run.record
                .jumps
                .iter()
                .rfind(of)
                .unwrap_or_else(|| panic!("{shape:?} {ratio}: {:?}", run.record.jumps))
        };
        for (jump, (at, released)) in [
            (jump(Direction::Approach, Pattern::Flat), limit),
            (jump(Direction::Retraction, Pattern::Ridge), fold),
        ] {
            println!(
                "{shape:?} {ratio}: at {} ({at}), {} ({released}) +- {:e}",
                jump.mean_displacement, jump.released_energy, jump.release_error
            );
            assert!((jump.mean_displacement - at).abs() <= 1e-4, "{jump:?} {at}");
            assert!(
                (jump.released_energy - released).abs() <= jump.release_error + 1e-8,
                "{jump:?} {released}"
            );
            assert!(jump.release_error < 2e-5, "{jump:?}");
        }
    }
}

/// The loss of Fig. 2 by the walk and the atlas at steps of 0.02 and less, to its last digit.
const FIG_2: f64 = 0.11746;

#[test]
fn the_loss_does_not_depend_on_how_deep_or_in_which_steps_the_loop_goes() {
    let shallow = preset("fig2");
    let mut deep = preset("fig2");
    deep.drive.turn = Turn::At(-20.0);
    let stepped = [0.5, 1.0, 5.0].map(|step| {
        let mut scene = shallow.clone();
        scene.drive.step = step;
        scene
    });
    for scene in [&shallow, &deep].into_iter().chain(&stepped) {
        let ledger = planned(scene).ledger(scene.law.surface_energy).unwrap();
        let loss = ledger.dissipated_energy().unwrap();
        assert!((loss - FIG_2).abs() < 5e-6, "{:?}: {loss}", scene.drive);
        // The check follows as far as the steps allow, and says so where they do not.
        let checked = ledger.mismatch().unwrap() < 1e-3;
        assert_eq!(
            (checked, ledger.warning().is_none()),
            (scene.drive.step < 0.1, scene.drive.step < 0.1),
            "{:?} {ledger:?}",
            scene.drive
        );
    }
    let ledger = walked(&deep, Part::Quarter).ledger(0.15).unwrap();
    assert!(
        (ledger.dissipated_energy().unwrap() - FIG_2).abs() < 2e-5
            && ledger.mismatch().unwrap() < 1e-4,
        "{ledger:?}"
    );
}

/// As in loops along the curves of an atlas or a diagram.
#[test]
fn the_ends_of_branches_among_the_states_change_no_loop_integral() {
    let scene = preset_on("fig2", Points::Square(48));
    let run = walked(&scene, Part::Quarter);
    let mut with_ends = run.record.clone();
    for jump in &run.record.jumps {
        let landing = |s: &StateRecord| s.direction == jump.direction && s.control == jump.control;
        let states = &mut with_ends.states;
        let i = states.iter().rposition(landing).unwrap();
        let end = StateRecord {
            stress: jump.stress_before,
            ..states[i].clone()
        };
        states.insert(i, end);
    }
    assert_eq!(run.record.jumps.len(), 8);
    let off = with_ends.work() / run.record.work() - 1.0;
    assert!(off.abs() < 1e-12, "{off:e}");
}

#[test]
fn an_integral_that_misses_something_is_told_with_the_loss() {
    let mut run = planned(&preset("fig2"));
    run.record.jumps[3].released_energy += 0.01;
    let ledger = run.ledger(0.15).unwrap();
    assert!(
        ledger
            .warning()
            .is_some_and(|words| words.contains("energy is missing")),
        "{ledger:?}"
    );
}

#[test]
fn patterns_that_come_and_go_continuously_do_so_at_the_limits_and_release_nothing() {
    let mie = Shape::Mie(Mie { m: 12.0, n: 6.0 });
    for (shape, ratio) in [
        (Shape::Morse(Morse), 1.05),
        (mie, 1.05),
        (Shape::Morse(Morse), 1.35),
        (mie, 1.35),
        (Shape::Morse(Morse), 1.6),
        (mie, 1.6),
    ] {
        let (scene, law, length) = line(shape, ratio);
        let run = planned(&scene);
        let (tally, ledger) = (run.record.tally(), run.ledger(law.surface_energy).unwrap());
        println!("{shape:?} {ratio}: {tally}, {ledger:?}");
        assert!(
            tally.jumps.is_multiple_of(2)
                && tally.transitions.is_multiple_of(2)
                && tally.transitions > 0,
            "{tally}"
        );
        let (lower, upper) = flat_limits(&law, length).unwrap();
        for jump in &run.record.jumps {
            assert!(jump.released_energy >= 0.0, "{jump:?}");
            if jump.cause == Cause::Transition {
                let off = [lower, upper].map(|limit| (jump.mean_displacement - limit).abs());
                assert!(
                    off[0].min(off[1]) < 1e-4 && jump.released_energy == 0.0,
                    "{jump:?} {lower} {upper}"
                );
                assert_ne!(jump.from == Pattern::Flat, jump.to == Pattern::Flat);
            }
        }
        assert_eq!(
            tally.transitions,
            if ratio < 1.1 { 4 } else { 2 },
            "{:?}",
            run.record.jumps
        );
        // Below 1.1 L_c both limits are supercritical: patterns, but no hysteresis.
        assert_eq!(ratio < 1.1, tally.jumps == 0, "{tally}");
        assert!(
            ratio > 1.1
                || ledger.loop_integral.abs() < ledger.integral_error
                    && ledger.integral_error < 1e-4,
            "{ledger:?}"
        );
    }
}

/// gamma'' of the cosine law jumps from nothing where it ends, and all waves are soft at once: a ridge
/// grows in proportion to the way from there.
#[test]
fn where_the_stiffness_of_a_law_jumps_a_ridge_grows_from_nothing() {
    let cosine = Shape::Cosine(Cosine { smooth: false });
    for ratio in [1.1, 1.4] {
        let (mut scene, law, length) = line(cosine, ratio);
        scene.cell.points = Points::Line(16);
        let (_, end) = flat_limits(&law, length).unwrap();
        scene.drive.start = end + 0.2 * law.range;
        let run = planned(&scene);
        assert_eq!(run.outcome, Outcome::Completed, "{ratio}");
        for (direction, [from, to]) in [
            (Direction::Approach, [Pattern::Flat, Pattern::Ridge]),
            (Direction::Retraction, [Pattern::Ridge, Pattern::Flat]),
        ] {
            let is_it = |jump: &&JumpRecord| {
                (jump.direction, jump.from, jump.to) == (direction, from, to)
                    && (jump.mean_displacement - end).abs() < 1e-4 * law.range
            };
            let told: Vec<_> = run.record.jumps.iter().filter(is_it).collect();
            assert_eq!(told.len(), 1, "{ratio} {:?}", run.record.jumps);
            assert_eq!(told[0].released_energy, 0.0);
        }
        // The stress is that of a linear problem next to there.
        let near = run.record.states.iter().filter(|state| {
            let way = (end - state.mean_displacement) / law.range;
            state.direction == Direction::Approach && (1e-3..1e-2).contains(&way)
        });
        let rates: Vec<f64> = near
            .map(|state| state.stress / (end - state.mean_displacement))
            .collect();
        let (least, most) = (
            rates.iter().copied().fold(f64::INFINITY, f64::min),
            rates.iter().copied().fold(0.0, f64::max),
        );
        assert!(rates.len() > 2 && most < 1.02 * least, "{rates:?}");
    }
}

#[test]
fn faint_patterns_of_a_square_cell_that_change_their_names_are_no_events() {
    let (mut scene, ..) = line(Shape::Morse(Morse), 1.05);
    scene.cell.points = Points::Square(16);
    let run = walked(&scene, Part::Quarter);
    let tally = run.record.tally();
    assert_eq!(
        (tally.jumps, tally.of_the_mesh, tally.transitions),
        (0, 0, 4),
        "{:?}",
        run.record.jumps
    );
}

#[test]
fn a_loop_that_ends_in_another_state_than_it_began_with_is_open_and_loses_nothing_that_is_known() {
    let mut scene = preset_on("fig2", Points::Square(32));
    scene.drive.step = 0.05;
    for (start, turn) in [(3.5, 1.8), (3.5, 0.2), (3.2, 2.0)] {
        (scene.drive.start, scene.drive.turn) = (start, Turn::At(turn));
        let ledger = planned(&scene).ledger(0.15).unwrap();
        let open = ledger
            .open
            .as_ref()
            .unwrap_or_else(|| panic!("{start} {turn}: {ledger:?}"));
        assert!(
            open.reason.contains("began as flat") && open.remedy.contains("drive.start"),
            "{open:?}"
        );
        assert_eq!(
            (
                ledger.dissipated_energy(),
                ledger.mismatch(),
                ledger.stated_error(1e-4)
            ),
            (None, None, None)
        );
    }
    scene.drive.start = 4.2;
    assert!(planned(&scene).ledger(0.15).unwrap().open.is_none());
}

#[test]
fn a_drive_never_starts_from_a_state_that_is_unstable_or_not_found() {
    let tip = Indenter::Hertz(Hertz { radius: 256.0 });
    for (indenter, start) in [
        (Indenter::Flat, 2.5),
        (Indenter::Flat, 0.9),
        (tip.clone(), -60.0),
        (tip, -400.0),
    ] {
        let scene = preset_on("fig2", Points::Square(16));
        let mut scene = driven(scene, Control::Displacement, [start, start - 0.1, 0.02]);
        scene.indenter = indenter.clone();
        for part in [Part::Quarter, Part::Whole] {
            let run = run_loop(&scene, on(part), &Cancel::default(), &mut |_| {}).unwrap();
            let first = &run.record.states[0];
            let sound =
                first.stop == Stop::Stable && first.stress.is_finite() && first.energy.is_finite();
            println!("{indenter:?} {start}: {:?} {:?}", first.stop, run.outcome);
            match &run.outcome {
                Outcome::NotConverged { reason, .. } if !sound => {
                    assert!(matches!(reason, Stuck::NoStart { .. }), "{reason}");
                }
                outcome => assert!(sound, "{outcome:?}"),
            }
            assert!(indenter != Indenter::Flat || !sound, "{start}");
            if run.outcome == Outcome::Completed {
                assert!(
                    run.record
                        .states
                        .iter()
                        .all(|s| s.stress.is_finite() && s.energy.is_finite())
                );
            }
        }
    }
}

#[test]
fn jumps_of_the_mesh_are_told_apart_and_vanish_with_refinement() {
    let coarse = preset("coarse-mesh");
    let run = walked(&coarse, Part::Whole);
    let tally = run.record.tally();
    assert!(tally.of_the_mesh > 50 && tally.jumps < 10, "{tally}");
    let jumps = run.record.jumps.iter();
    for jump in jumps.filter(|jump| jump.cause == Cause::Mesh) {
        // The jump into contact releases a tenth of gamma and more.
        assert!(
            jump.from == jump.to && jump.released_energy < 0.05,
            "{jump:?}"
        );
    }
    // The same law on a mesh that is safe for it: nothing of the kind.
    let mut fine = preset("fig2");
    fine.drive.step = 0.1;
    assert_eq!(walked(&fine, Part::Whole).record.tally().of_the_mesh, 0);
}

/// By hand nobody stops just where he began: up to there the way is the one gone before.
#[test]
fn a_loop_made_by_hand_is_closed_where_it_meets_its_own_way_and_loses_what_any_loop_does() {
    let mut scene = preset("fig2");
    scene.drive.step = 0.05;
    let gamma = scene.law.surface_energy;
    let whole = walked(&scene, Part::Quarter).record.ledger(gamma);
    let cancel = Cancel::default();
    let mut walk = start(&scene, Part::Quarter);
    let mut record = LoopRecord::of(scene.control());
    record.states.push(walk.record().clone());
    let mut closed_at = Vec::new();
    // Down past the first jump, back a little, to the ground, and up to where it is flat again.
    for target in [2.7, 3.0, 0.41, 4.03] {
        walk.set_target(target);
        while walk.step(&cancel, &mut |observed| match observed {
            Observed::State(state) => {
                record.states.push(state);
                if let Some(closed) = record.closed() {
                    let u0 = record.states.last().unwrap().mean_displacement;
                    closed_at.push((u0, closed.ledger(gamma)));
                }
            }
            Observed::Jump(jump) => record.jumps.push(jump),
            Observed::Moving { .. } => {}
        }) == Progress::Working
        {}
    }
    let last = record.jumps.last().unwrap().mean_displacement;
    let (u0, ledger) = &closed_at[0];
    assert!((last..last + 0.1).contains(u0), "{u0} {last}");
    assert_eq!(ledger.open, None);
    let loss = ledger.dissipated_energy().unwrap();
    let off = loss - whole.dissipated_energy().unwrap();
    assert!(off.abs() < 1e-6, "{off}");
    let missing = (ledger.loop_integral - loss).abs();
    assert!(missing < ledger.integral_error + 1e-6, "{ledger:?}");
}
