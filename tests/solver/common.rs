//! Fig. 2 and its patterns, for all the cases.

use crate::loops::{go, preset_on, reach, start};
use rand::SeedableRng;
use rand_pcg::Pcg64;
use std::sync::OnceLock;
use tackscope::follow::run::{LoopRun, Outcome, run_loop};
use tackscope::follow::walk::{Walk, WalkOptions};
use tackscope::numerics::threads::Cancel;
use tackscope::physics::indenter::Indenter;
use tackscope::physics::law::{Law, Morse, Shape};
use tackscope::physics::mesh::Grid;
use tackscope::physics::pattern::{Pattern, classify};
use tackscope::physics::system::System;
use tackscope::scene::{Part, Points, Scene};
use tackscope::solver::mechanics::{Mechanics, Slides};
use tackscope::solver::method::{Equilibrium, History, Lost, Method, Stop};
use tackscope::solver::methods::MethodKind;
use tackscope::solver::stability::Tracker;

/// Points of the mesh on which patterns are looked at: the coarsest that does not trap them.
pub const N: usize = 48;

/// Fig. 2 on n x n points.
pub fn fig2(n: usize, step: f64) -> Scene {
    let mut scene = preset_on("fig2", Points::Square(n));
    scene.drive.step = step;
    scene
}

/// Its law, all lengths in ranges.
pub const LAW: Law = Law {
    shape: Shape::Morse(Morse),
    surface_energy: 0.15,
    range: 1.0,
};

/// Mechanics without a walk around it.
pub struct Bench {
    pub mechanics: Mechanics,
}

impl Bench {
    /// Fig. 2.
    pub fn new() -> Self {
        Self::of(LAW, N)
    }

    pub fn of(law: Law, n: usize) -> Self {
        let system = System::new(Grid::square(256.0, n), law, &Indenter::Flat);
        Self {
            mechanics: Mechanics::new(system, Slides::Freely),
        }
    }

    /// One increment of `method` from the newest state of `branch`.
    pub fn follow(
        &mut self,
        method: &mut dyn Method,
        branch: &History,
        from: &Equilibrium,
        u0: f64,
    ) -> Result<Equilibrium, Lost> {
        method.follow(&mut self.mechanics, branch, from, u0)
    }

    /// The same without a past.
    pub fn relax(
        &mut self,
        method: &mut dyn Method,
        from: &Equilibrium,
        u0: f64,
    ) -> Result<Equilibrium, Lost> {
        self.follow(method, &History::starting(&from.state), from, u0)
    }

    /// Whatever the amplitudes `z` are at `u0`, as a state to start from.
    pub fn state(&mut self, z: Vec<f64>, u0: f64) -> Equilibrium {
        let at = self.mechanics.at(z, u0);
        let residual = self.mechanics.residual(&at);
        Equilibrium::unmeasured(at, residual, Stop::NotConverged, Default::default())
    }

    /// Checks its stability and labels it, as the walk does.
    pub fn label(&mut self, state: &mut Equilibrium) {
        let mut tracker = Tracker::new(Pcg64::seed_from_u64(7));
        let (stiffness, mode) =
            tracker.check(&mut self.mechanics, &state.state.amplitudes, &state.fields);
        state.measured(stiffness, mode);
    }

    /// The pattern that a state shows.
    pub fn pattern(&self, state: &Equilibrium) -> Pattern {
        let law = self.mechanics.system.law();
        classify(state.fields.gap.view(), law, true)
    }
}

/// A walk on the whole cell by a method of one's own.
pub fn walk_by(scene: &Scene, method: impl Method + 'static) -> Walk {
    Walk::start_by(
        Box::new(method),
        scene,
        WalkOptions::default(),
        &Cancel::default(),
    )
    .unwrap()
}

/// The loop of a scene by one of the methods.
pub fn looped(scene: &Scene, method: MethodKind) -> LoopRun {
    let run = run_loop(scene, method.into(), &Cancel::default(), &mut |_| {}).unwrap();
    assert_eq!(run.outcome, Outcome::Completed, "{method:?}");
    run
}

/// Three states of a pattern of Fig. 2, the newest last, as the walk reached them going to `target`
/// by way of `turn`.
fn reached(turn: f64, target: f64, pattern: Pattern) -> Vec<Equilibrium> {
    let mut walk = start(&fig2(N, 0.05), Part::Whole);
    go(&mut walk, turn);
    let mut states = Vec::new();
    for back in [0.1, 0.05, 0.0] {
        let u0 = if turn < target {
            target - back
        } else {
            target + back
        };
        reach(&mut walk, u0);
        states.push(walk.here().clone());
    }
    assert_eq!(walk.record().pattern, pattern);
    states
}

/// A dimple on retraction, short of its limit at 2.228.
pub fn dimple() -> &'static [Equilibrium] {
    static STATES: OnceLock<Vec<Equilibrium>> = OnceLock::new();
    STATES.get_or_init(|| reached(0.3, 2.2, Pattern::Dimple))
}

/// A bulge on retraction, short of its fold at 3.974.
pub fn bulge() -> &'static [Equilibrium] {
    static STATES: OnceLock<Vec<Equilibrium>> = OnceLock::new();
    STATES.get_or_init(|| reached(3.0, 3.95, Pattern::Bulge))
}

/// A ridge on approach.
pub fn ridge() -> &'static [Equilibrium] {
    static STATES: OnceLock<Vec<Equilibrium>> = OnceLock::new();
    STATES.get_or_init(|| reached(4.2, 2.4, Pattern::Ridge))
}

/// The branch of those states.
pub fn history(states: &[Equilibrium]) -> History {
    let mut history = History::default();
    for state in states {
        history.push(&state.state);
    }
    history
}
