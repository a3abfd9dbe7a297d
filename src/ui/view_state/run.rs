//! What belongs to one run of one scene: where it stands, what it recorded, how it is moved, by a drive or
//! pressed by hand, which of its states is looked at; and the hint to who has done nothing yet: to lower
//! the body, to pull it off, and what was lost.

use super::foresight::{Ahead, UPON};
use super::{Films, Foresight, Store, ViewState};
use crate::follow::record::{Direction, JumpRecord, LoopRecord, StateRecord};
use crate::follow::walk::Push;
use crate::physics::control::Control;
use crate::physics::indenter::Indenter;
use crate::physics::parameter::Dimension;
use crate::plot::curve::Curve;
use crate::plot::panel::Area;
use crate::scene::Scene;
use crate::scene::parameter::Unit;
use crate::study::forecast::calm;
use crate::study::landscape::Standing;
use crate::ui::action::Pick;
use crate::worker::protocol::{Frame, LoopSummary, Motion, Play, Ready, RunId, Stored, Sweep};
use std::sync::Arc;

/// A state this close to a jump (ranges) belongs to it: the walk brackets a jump to a
/// ten-thousandth.
const AT_JUMP: f64 = 2e-4;

/// One run; another scene, model or method begins another one.
#[derive(Debug)]
pub struct RunView {
    /// Its id, which its events carry.
    pub id: RunId,
    /// Facts of the scene, once the solver has sent them.
    pub ready: Option<Arc<Ready>>,
    /// Where u0 is.
    pub actual: f64,
    /// Direction of the last motion.
    pub direction: Direction,
    /// What the surface is doing.
    pub play: Play,
    /// Held.
    pub paused: bool,
    /// The newest motion asked for; a rest that ends an older one is stale.
    pub(super) motion: Motion,
    /// The newest equilibrium.
    pub state: Option<StateRecord>,
    /// Everything recorded in this run or loop.
    pub record: LoopRecord,
    /// The curve of `record`.
    pub curve: Curve,
    /// The smallest eigenvalue (E*/L) along `record`, as the stability tab draws it.
    pub stiffness: Curve,
    /// The last closed loop.
    pub closed_loop: Option<ClosedLoop>,
    /// The stored state somebody looks at.
    pub selection: Option<Selection>,
    /// The films of its jumps.
    pub films: Films,
    /// The moment of a jump that is replayed.
    pub replayed: Option<Arc<Frame>>,
    /// Its states, to be looked at and gone on from.
    pub store: Store,
    /// The picture of the stored state somebody looks at, until the surface moves.
    pub shown: Option<Arc<Frame>>,
    /// The last push, until the surface is driven on.
    pub push: Option<Pushed>,
    /// The search for states that nobody walked to.
    pub foresight: Foresight,
    /// The stored state that is to be the present one; the solver is told at the end of the frame.
    pub(super) from: Option<Arc<Stored>>,
}

/// A closed loop as it is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct ClosedLoop {
    /// Its numbers.
    pub summary: LoopSummary,
    /// Its area.
    pub loss: Vec<Area>,
}

/// Where a stored state is from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// Of the present path: its index in the record.
    Walked(usize),
    /// Of a path that was left: which of them, and which of its states.
    Left([usize; 2]),
    /// Of a live loop.
    Foreseen,
}

impl Origin {
    fn is_like(self, other: Self) -> bool {
        std::mem::discriminant(&self) == std::mem::discriminant(&other)
    }
}

/// A stored state that somebody looks at.
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    /// Where it comes from.
    pub of: Origin,
    /// The stored state.
    pub state: StateRecord,
    /// Index of the jump that led to it or away from it.
    pub jump: Option<usize>,
}

impl RunView {
    /// A run at rest at the start of its drive, from where it is asked to go to `target`.
    pub(super) fn new(id: RunId, scene: &Scene, target: f64) -> Self {
        let (start, control) = (scene.drive.start, scene.control());
        let mut run = Self {
            id,
            ready: None,
            actual: start,
            direction: Direction::Approach,
            play: Play::Rest,
            paused: false,
            motion: 0,
            state: None,
            record: LoopRecord::of(control),
            curve: Curve::default(),
            stiffness: Curve::default(),
            closed_loop: None,
            selection: None,
            films: Films::default(),
            replayed: None,
            store: Store::default(),
            shown: None,
            push: None,
            foresight: Foresight::default(),
            from: None,
        };
        if target != start {
            run.set(Play::ToTarget(target));
        }
        run
    }

    /// What the last closed loop lost (gamma), if that is known.
    pub fn loss(&self) -> Option<f64> {
        let closed = self.closed_loop.as_ref()?;
        closed.summary.ledger.dissipated_energy()
    }

    /// The jump that led to the state somebody looks at, or away from it.
    pub fn selected_jump(&self) -> Option<usize> {
        self.selection.as_ref()?.jump
    }

    /// True while the solver has something to do.
    pub fn is_busy(&self) -> bool {
        self.play != Play::Rest
    }

    /// The sweep under way.
    pub fn sweep(&self) -> Option<Sweep> {
        if let Play::Sweep(sweep) = self.play {
            Some(sweep)
        } else {
            None
        }
    }

    /// Asks for another motion; the solver is told at the end of the frame.
    pub(super) fn set(&mut self, play: Play) {
        if matches!(play, Play::ToTarget(_) | Play::Sweep(_)) {
            self.push = None;
        }
        self.play = play;
        self.paused = false;
        self.motion += 1;
    }

    /// Takes a stored state as the present one, and goes to `target`.
    pub(super) fn resume(&mut self, stored: Arc<Stored>, target: f64) {
        self.direction = stored.record.direction;
        self.from = Some(stored);
        self.set(Play::ToTarget(target));
    }
}

/// How u0 is moved: by hand, by key, by itself.
impl ViewState {
    /// A value of the control held inside the drive: behind a spring it may be a rounding beyond its
    /// end.
    pub(super) fn held(&self, control: f64) -> f64 {
        control.clamp(self.limits.0, self.limits.1)
    }

    /// Asks the solver to walk to `u0`, held inside the drive.
    pub fn set_target(&mut self, u0: f64) {
        let u0 = self.held(u0);
        if !u0.is_finite() || u0 == self.target && self.run.sweep().is_none() {
            return;
        }
        if u0 != self.run.actual {
            self.run.direction = if u0 < self.run.actual {
                Direction::Approach
            } else {
                Direction::Retraction
            };
        }
        self.target = u0;
        self.hint_after_motion();
        self.run.set(Play::ToTarget(u0));
    }

    /// Starts a sweep.
    pub fn play(&mut self, sweep: Sweep) {
        self.last_sweep = sweep;
        self.hint_after_motion();
        self.run.set(Play::Sweep(sweep));
    }

    /// Space: pause, go on, or start.
    pub fn toggle_play(&mut self) {
        if self.run.paused {
            self.run.paused = false;
        } else if self.run.is_busy() {
            self.run.paused = true;
        } else {
            self.play(self.last_sweep);
        }
    }

    /// Drops target and sweep; the thumb goes where the surface is.
    pub fn stop(&mut self) {
        self.target = self.held(self.run.actual);
        self.run.set(Play::Rest);
    }

    /// Moves the target by so many increments; further key presses add up although the solver is
    /// still on its way.
    pub fn step(&mut self, increments: f64) {
        self.set_target(self.target + increments * self.scene.drive.step);
    }

    /// One increment in the present direction.
    pub fn increment(&mut self) {
        self.step(if self.run.direction == Direction::Approach {
            -1.0
        } else {
            1.0
        });
    }

    /// Turns round.
    pub fn reverse(&mut self) {
        let (sweep, direction) = match self.run.direction {
            Direction::Approach => (Sweep::Retract, Direction::Retraction),
            Direction::Retraction => (Sweep::Approach, Direction::Approach),
        };
        if self.run.sweep().is_some() {
            self.play(sweep);
        }
        self.run.direction = direction;
    }
}

/// In what the control is told.
#[derive(Clone, Debug)]
pub struct Told {
    /// Its name.
    pub name: &'static str,
    /// Its letter.
    pub symbol: &'static str,
    /// What stands behind its numbers.
    pub suffix: String,
    /// What is 1 (length; E* of a load).
    pub unit: f64,
    /// That beside the natural unit.
    pub measure: Unit,
}

impl Told {
    /// A value with its unit, in as fine steps as with so many `decimals` of natural units.
    pub fn say(&self, value: f64, decimals: usize) -> String {
        let natural = value / self.unit / self.measure.scale;
        self.measure.number(natural, decimals) + &self.suffix
    }
}

impl ViewState {
    /// In what the control of this scene is told.
    pub fn told(&self) -> Told {
        let law = &self.model.law;
        let name = match self.scene.control() {
            Control::Displacement => "Mean displacement",
            Control::Spring { .. } => "Stage",
            Control::Load => "Load",
        };
        let (of, natural, one) = if self.scene.control() == Control::Load {
            (Dimension::Stress, "σₘₐₓ", law.traction_max())
        } else {
            (Dimension::Length, "ρ", law.range)
        };
        let measure = self.model.unit(of);
        let (suffix, unit) = (format!(" {}", measure.name(natural)), one / measure.scale);
        Told {
            name,
            symbol: self.scene.control().symbol(),
            suffix,
            unit,
            measure,
        }
    }
}

/// Which stored state is looked at.
impl ViewState {
    /// Looks at the state that is drawn nearest to (u0/rho, stress/sigma_max), walked or foreseen:
    /// `reach` along each axis is as far as a click may miss it.
    pub fn select_near(&mut self, at: [f64; 2], reach: [f64; 2], pick: Pick) {
        let rho = self.rho();
        let distance = |s: &StateRecord| {
            ((s.mean_displacement / rho - at[0]) / reach[0])
                .hypot((s.stress_over_max - at[1]) / reach[1])
        };
        let walked = self.run.record.states.iter().enumerate();
        let walked = walked.map(|(index, s)| (distance(s), Origin::Walked(index)));
        let ghosts = self.plots.ghosts.iter().enumerate();
        let left = ghosts.flat_map(|(ghost, left)| {
            let states = left.states.iter().enumerate();
            states.map(move |(state, s)| (distance(&s.record), Origin::Left([ghost, state])))
        });
        let nearer = |a: &(f64, Origin), b: &(f64, Origin)| a.0.total_cmp(&b.0);
        let ahead = self.nearest_ahead(at, reach);
        let foreseen = ahead.as_ref().map(|ahead| (ahead.off, Origin::Foreseen));
        // What was walked lies upon the rest.
        let mut near: Vec<(f64, Origin)> = walked.min_by(nearer).into_iter().collect();
        let beneath = left.min_by(nearer).into_iter().chain(foreseen);
        near.extend(beneath.map(|(off, of)| (off + UPON, of)));
        let present = self.run.selection.as_ref().map(|selection| selection.of);
        if let Some(present) = present.filter(|_| pick == Pick::Along) {
            near.retain(|(_, of)| of.is_like(present));
        }
        let found = near.into_iter().min_by(nearer);
        match found.filter(|(off, _)| pick != Pick::Click || *off <= 1.0) {
            Some((_, Origin::Walked(index))) => self.select(index),
            Some((_, of @ Origin::Left(_))) => self.look_at(of),
            Some((_, Origin::Foreseen)) => {
                if let Some(Ahead { kept, spot, .. }) = ahead {
                    self.foresee(kept, spot);
                }
            }
            None => self.select_nothing(),
        }
    }

    /// Looks at the state of this index, in numbers and, if it is kept, in pictures.
    pub(super) fn select(&mut self, index: usize) {
        self.look_at(Origin::Walked(index));
    }

    fn look_at(&mut self, of: Origin) {
        let (state, jump) = match of {
            Origin::Walked(index) => {
                let state = self.run.record.states.get(index).cloned();
                let jump = state.as_ref().and_then(|state| self.jump_at(state));
                (state, jump)
            }
            Origin::Left([ghost, state]) => {
                let ghost = self.plots.ghosts.get(ghost);
                let stored = ghost.and_then(|ghost| ghost.states.get(state));
                (stored.map(|stored| stored.record.clone()), None)
            }
            Origin::Foreseen => (None, None),
        };
        let Some(state) = state else {
            return;
        };
        self.run.foresight = Foresight::default();
        self.run.selection = Some(Selection { of, state, jump });
        self.run.shown = self.looked_at().map(|stored| Arc::new(stored.frame()));
    }

    /// Looks at the present state.
    pub fn select_nothing(&mut self) {
        (self.run.selection, self.run.shown) = (None, None);
        self.run.foresight = Foresight::default();
    }

    /// Selects the state after a jump.
    pub fn select_jump(&mut self, index: usize) {
        let Some(jump) = self.run.record.jumps.get(index) else {
            return;
        };
        let landed = |s: &StateRecord| s.direction == jump.direction && s.control == jump.control;
        let Some(state) = self.run.record.states.iter().rposition(landed) else {
            return self.select_nothing();
        };
        self.select(state);
        if let Some(selection) = &mut self.run.selection {
            selection.jump = Some(index);
        }
    }

    /// Selects the jump `by` further on, as far as there are any; from nowhere the first, or going
    /// back the last.
    pub fn step_jump(&mut self, by: isize) {
        let last = self.run.record.jumps.len().saturating_sub(1);
        self.select_jump(match self.run.selected_jump() {
            None if by < 0 => last,
            None => 0,
            Some(i) => i.saturating_add_signed(by).min(last),
        });
    }

    fn jump_at(&self, state: &StateRecord) -> Option<usize> {
        let off = |jump: &JumpRecord| (jump.control - state.control).abs();
        let near = |jump: &JumpRecord| {
            jump.direction == state.direction && off(jump) <= AT_JUMP * self.rho()
        };
        self.run.record.jumps.iter().rposition(near)
    }
}

/// A push and the state it was pressed into.
#[derive(Clone, Debug)]
pub struct Pushed {
    /// Energy per area of the pressed surface less that of the state (E* times length).
    pub energy: f64,
    /// The state.
    pub from: StateRecord,
}

/// Largest difference in energy (gamma) between two descriptions of one state.
const SAME: f64 = 1e-6;

impl ViewState {
    /// True while the surface can be pressed: it rests, or is pressed already.
    pub fn can_press(&self) -> bool {
        let rests = matches!(self.run.play, Play::Rest | Play::Pressed(_));
        rests && self.run.state.is_some() && (self.jumping().is_none() || self.is_pressed())
    }

    /// True while it is held pressed.
    pub fn is_pressed(&self) -> bool {
        matches!(self.run.play, Play::Pressed(_))
    }

    /// Presses a bump or a dimple into the surface.
    pub fn press(&mut self, push: Push) {
        if self.can_press() && self.run.play != Play::Pressed(push) {
            self.select_nothing();
            self.run.replayed = None;
            self.run.set(Play::Pressed(push));
        }
    }

    /// Lets the surface go.
    pub fn let_go(&mut self) {
        if let Play::Pressed(push) = self.run.play {
            let before = self.past();
            self.history.end_gesture();
            self.history.remember(before);
            self.target = self.run.actual;
            self.run.set(Play::LetGo(push));
        }
    }

    /// The solver says how much energy the push has.
    pub(super) fn take_pressed(&mut self, energy: f64) {
        let from = self.run.state.clone();
        self.run.push = from.map(|from| Pushed { energy, from });
    }

    /// The push in words: its energy, the barrier, and what came of it.
    pub fn push_in_words(&self) -> Option<String> {
        let Pushed { energy, from } = self.run.push.as_ref()?;
        let gamma = self.model.law.surface_energy;
        let say = |energy: f64| match self.model.in_kt(energy) {
            Some(kt) => format!("{:.2e} γL² ({kt:.2e} kT)", energy / gamma),
            None => format!("{:.2e} γL²", energy / gamma),
        };
        let here = Standing::of(from, self.scene.control());
        let barrier = self.plots.barrier.filter(|(of, _)| *of == here);
        let barrier = match barrier {
            Some((_, barrier)) => format!("the lowest barrier is {}", say(barrier)),
            None => "the tab Landscape tells the lowest barrier".to_owned(),
        };
        let now = self.run.state.as_ref()?;
        let came = match self.run.play {
            Play::Rest if now.pattern != from.pattern => {
                format!(" It snapped: {} → {}.", from.pattern, now.pattern)
            }
            Play::Rest if (now.energy - from.energy).abs() <= SAME * gamma => {
                " It went back.".to_owned()
            }
            Play::Rest => format!(" It went into another {}.", now.pattern),
            _ => String::new(),
        };
        Some(format!("The push has {}; {barrier}.{came}", say(*energy)))
    }
}

/// How far somebody is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hint {
    /// Nothing was moved yet.
    Grab,
    /// Nothing has snapped yet.
    Lower,
    /// It has snapped on the way down.
    PullOff,
    /// It is back where it was.
    Loss,
}

impl ViewState {
    /// The hint in words; `None` where there is none, a lesson says what to do, or the surface
    /// moves by itself.
    pub fn hint(&self) -> Option<String> {
        let hint = self.messages.hint?;
        let moves = self.run.sweep().is_some() || self.jumping().is_some();
        if self.lesson.is_some() || moves {
            return None;
        }
        Some(match hint {
            Hint::Grab | Hint::Lower => match calm(&self.scene, &self.model) {
                Some(calm) => format!("Here nothing snaps. {}", calm.remedy),
                None if self.model.indenter == Indenter::Flat => {
                    "Drag down slowly. Something will snap.".to_owned()
                }
                None => "Drag down slowly. Something may snap.".to_owned(),
            },
            Hint::PullOff => "Now pull it off again.".to_owned(),
            Hint::Loss if self.run.closed_loop.is_some() => {
                "The shaded area is what was lost.".to_owned()
            }
            Hint::Loss => "The jumps add up to what was lost.".to_owned(),
        })
    }

    /// Something was moved.
    pub(super) fn hint_after_motion(&mut self) {
        if self.messages.hint == Some(Hint::Grab) {
            self.messages.hint = Some(Hint::Lower);
        }
    }

    /// Another run: nothing has snapped in it.
    pub(super) fn hint_afresh(&mut self) {
        if self.messages.hint.is_some_and(|hint| hint != Hint::Grab) {
            self.messages.hint = Some(Hint::Lower);
        }
    }

    pub(super) fn hint_after_jump(&mut self, jump: &JumpRecord) {
        if jump.direction == Direction::Approach && self.messages.hint.is_some() {
            self.messages.hint = Some(Hint::PullOff);
        }
    }

    pub(super) fn hint_after_state(&mut self, state: &StateRecord) {
        let record = &self.run.record;
        let first = record.states.first().map(|first| first.pattern);
        let last = record.jumps.last().map(|jump| jump.direction);
        self.messages.hint = match (self.messages.hint, state.direction) {
            (Some(Hint::Loss), Direction::Approach) => None,
            // Who has been all the way down is told nothing new.
            (Some(Hint::Grab | Hint::Lower), _) if state.control <= self.limits.0 => None,
            (Some(Hint::PullOff), Direction::Retraction)
                if last == Some(Direction::Retraction) && first == Some(state.pattern) =>
            {
                Some(Hint::Loss)
            }
            (hint, _) => hint,
        };
    }
}
