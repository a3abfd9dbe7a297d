//! Fig. 2 and its patterns, for all the cases.

use std::sync::OnceLock;
use tackscope::follow::record::{Direction, JumpRecord, StateRecord};
use tackscope::follow::run::{LoopRun, run_loop};
use tackscope::follow::walk::{Observed, Progress, Walk, WalkOptions};
use tackscope::numerics::threads::Cancel;
use tackscope::physics::indenter::Indenter;
use tackscope::physics::law::{Law, Morse, Shape};
use tackscope::physics::mesh::Grid;
use tackscope::physics::pattern::Pattern;
use tackscope::physics::system::System;
use tackscope::scene::{Points, Scene};
use tackscope::solver::Lost;
use tackscope::solver::branch::History;
use tackscope::solver::equilibrium::Equilibrium;
use tackscope::solver::mechanics::{Mechanics, Slides};
use tackscope::solver::method::Method;
use tackscope::solver::methods::MethodKind;
use tackscope::storage;

/// Points of the mesh on which patterns are looked at: the coarsest that does not trap them.
pub const N: usize = 48;

/// Fig. 2 on n x n points.
pub fn fig2(n: usize, step: f64) -> Scene {
    let mut scene = storage::resolve("fig2").unwrap();
    scene.cell.points = Points::Square(n);
    scene.drive.step = step;
    scene
}

/// Its law, all lengths in ranges.
pub fn law() -> Law {
    Law {
        shape: Shape::Morse(Morse),
        surface_energy: 0.15,
        range: 1.0,
    }
}

/// Mechanics without a walk around it.
pub struct Bench {
    pub mechanics: Mechanics,
}

impl Bench {
    /// Fig. 2.
    pub fn new() -> Self {
        Self::of(law(), N)
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
        Equilibrium::unmeasured(
            at,
            residual,
            tackscope::solver::Stop::NotConverged,
            Default::default(),
        )
    }

    /// Checks its stability and labels it, as the walk does.
    pub fn label(&mut self, state: &mut Equilibrium) {
        use rand::SeedableRng;
        let mut tracker =
            tackscope::solver::stability::Tracker::new(rand_pcg::Pcg64::seed_from_u64(7));
        let (stiffness, mode) =
            tracker.check(&mut self.mechanics, &state.state.amplitudes, &state.fields);
        state.measured(stiffness, mode);
    }

    /// The pattern that a state shows.
    pub fn pattern(&self, state: &Equilibrium) -> Pattern {
        tackscope::physics::pattern::classify(
            state.fields.gap.view(),
            self.mechanics.system.law(),
            true,
        )
    }
}

/// What a walk brought on its way to a target.
pub struct Way {
    pub states: Vec<StateRecord>,
    pub jumps: Vec<JumpRecord>,
    pub end: Progress,
}

/// Walks to `target`, or until it cannot go on.
pub fn go(walk: &mut Walk, target: f64) -> Way {
    walk.set_target(target);
    let (mut states, mut jumps) = (Vec::new(), Vec::new());
    loop {
        let end = walk.step(&Cancel::default(), &mut |observed| match observed {
            Observed::State(state) => states.push(state),
            Observed::Jump(jump) => jumps.push(jump),
            Observed::Moving { .. } => {}
        });
        if end != Progress::Working {
            return Way { states, jumps, end };
        }
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

pub fn looped(scene: &Scene, method: MethodKind) -> LoopRun {
    run_loop(scene, method.into(), &Cancel::default(), &mut |_| {}).unwrap()
}

/// Patterns visited on one direction.
pub fn visited(run: &LoopRun, direction: Direction) -> Vec<Pattern> {
    run.record
        .jumps
        .iter()
        .filter(|j| j.direction == direction)
        .map(|j| j.to)
        .collect()
}

/// Three states of a pattern of Fig. 2, the newest last, as the walk reached them going to `target`
/// by way of `turn`.
fn reached(turn: f64, target: f64, pattern: Pattern) -> Vec<Equilibrium> {
    let mut walk = Walk::start(
        &fig2(N, 0.05),
        MethodKind::NewtonKrylov.into(),
        &Cancel::default(),
    )
    .unwrap();
    go(&mut walk, turn);
    let mut states = Vec::new();
    for back in [0.1, 0.05, 0.0] {
        let u0 = if turn < target {
            target - back
        } else {
            target + back
        };
        assert_eq!(go(&mut walk, u0).end, Progress::Resting);
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
