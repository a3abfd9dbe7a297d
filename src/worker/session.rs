//! What the solver thread does, as a state machine without a thread: tests step it by hand, with a
//! clock they hold.

use super::protocol::{
    Command, Envelope, Event, Frame, LoopSummary, Motion, Play, Ready, Recorder, Resumed, RunId,
    Speed, Stored, Sweep,
};
use super::system::Instant;
use crate::follow::record::{Direction, LoopRecord, StateRecord};
use crate::follow::run::Itinerary;
use crate::follow::walk::{Observed, Progress, Push, Stuck, Walk, WalkOptions, Widened};
use crate::numerics::threads::Cancel;
use crate::physics::parameter::Refusal;
use crate::scene::{Part, Scene};
use crate::solver::methods::MethodKind;
use crate::study::plan::ModelChoice;
use std::sync::Arc;
use std::time::Duration;

/// Shortest time between two states of a sweep at normal speed, so that a loop can be watched.
const PACE_STATE: Duration = Duration::from_millis(12);
/// Shortest time between two pictures of a jump at normal speed, so that it is seen as a short
/// film.
const PACE_FILM: Duration = Duration::from_millis(16);

/// A scene with the way it is computed.
#[derive(Clone, Debug)]
struct Setup {
    scene: Arc<Scene>,
    method: MethodKind,
    /// The model in use.
    choice: ModelChoice,
}

impl Setup {
    /// A walk at rest at the start of the drive.
    fn walk(&self, cancel: &Cancel) -> Result<Walk, Refusal> {
        let options = WalkOptions {
            part: self.choice.part,
            ..self.method.into()
        };
        Walk::start(&self.scene, options, cancel)
    }

    /// A walk that stands on a stored state, on the part of the cell on which it was walked; `None`
    /// if it is not of this scene.
    fn resume(&mut self, from: &Stored) -> Option<Walk> {
        if self.choice.part != from.part {
            (self.choice.part, self.choice.because) = (from.part, None);
        }
        let walk = self.walk(&Cancel::default()).ok()?;
        let fits = walk.system().dimension() == from.surface.state.amplitudes.len();
        fits.then(|| walk.standing_on(from.surface.clone(), from.record.clone()))
    }

    /// Goes over to the whole cell, for the reason given. `None` if it was the whole cell already.
    fn widen(&mut self, walk: &mut Walk, because: &Stuck, cancel: &Cancel) -> Option<Widened> {
        let widened = walk.widen(because, &self.scene, cancel)?;
        self.choice.part = Part::Whole;
        self.choice.because = Some(because.to_string());
        Some(widened)
    }
}

/// A scene being played.
#[derive(Default)]
pub struct Session {
    run: RunId,
    /// The newest motion asked for.
    motion: Motion,
    setup: Option<Setup>,
    walk: Option<Walk>,
    /// Where the walk last stood, kept apart from it: after a panic the walk itself is not to be
    /// trusted.
    good: Option<Arc<Stored>>,
    play: Play,
    /// What is left of the sweep.
    itinerary: Itinerary,
    record: LoopRecord,
    /// Its loss was told.
    is_closed: bool,
    loop_began: Option<Instant>,
    /// Transforms the loop has spent on walks that were given up, and those of the present walk
    /// before the loop began.
    transforms_elsewhere: usize,
    transforms_before: usize,
    paused: bool,
    not_before: Option<Instant>,
    speed: Speed,
    recorder: Recorder,
}

impl Session {
    /// The run whose events it hands out.
    pub fn run(&self) -> RunId {
        self.run
    }

    /// True while there is somewhere to walk to and nobody holds it.
    fn is_walking(&self) -> bool {
        !matches!(self.play, Play::Rest | Play::Pressed(_)) && !self.paused
    }

    /// How long the thread may sleep: `None` until a command comes, zero if there is work now.
    pub fn wait(&self, now: Instant) -> Option<Duration> {
        if !self.is_walking() || self.walk.is_none() {
            return None;
        }
        Some(
            self.not_before
                .map_or(Duration::ZERO, |t| t.saturating_duration_since(now)),
        )
    }

    /// Takes a command; those of another run, and motions older than the newest, are stale and
    /// dropped.
    pub fn command(
        &mut self,
        command: Envelope<Command>,
        cancel: &Cancel,
        sink: &mut dyn FnMut(Event),
    ) {
        let Envelope { run, message } = command;
        let number = match &message {
            Command::Play { motion, .. } | Command::GoOn { motion, .. } => *motion,
            _ => self.motion,
        };
        let begins = matches!(message, Command::SetScene { .. });
        if !begins && (run != self.run || number < self.motion) {
            return;
        }
        self.motion = number;
        match message {
            Command::SetScene {
                scene,
                method,
                asked,
                from,
            } => match ModelChoice::of(&scene, method, asked) {
                Ok(choice) => {
                    let setup = Setup {
                        scene,
                        method,
                        choice,
                    };
                    self.begin(run, setup, from.as_deref(), cancel, sink);
                }
                Err(error) => self.refuse(run, error, sink),
            },
            Command::Play { play, .. } => match play {
                Play::Rest => self.rest(sink),
                Play::ToTarget(control) => self.go(play, control),
                Play::Sweep(sweep) => self.start_sweep(sweep, cancel, sink),
                Play::Pressed(push) => {
                    self.press(push, cancel, sink);
                }
                Play::LetGo(push) => {
                    if self.press(push, cancel, sink)
                        && let Some(walk) = &mut self.walk
                    {
                        walk.let_go(&push);
                        (self.play, self.not_before) = (play, None);
                    }
                }
            },
            Command::GoOn { from, .. } => self.go_on(&from, sink),
            Command::Pause { paused } => self.paused = paused,
            Command::SetSpeed { speed } => self.speed = speed,
            Command::Quit => {}
        }
    }

    /// Does one bounded piece of work.
    pub fn step(&mut self, now: Instant, cancel: &Cancel, sink: &mut dyn FnMut(Event)) {
        if !self.is_walking() {
            return;
        }
        let Some(mut walk) = self.walk.take() else {
            return;
        };
        let mut seen = Vec::new();
        let progress = walk.step(cancel, &mut |observed| seen.push(observed));
        let mut pace = Duration::ZERO;
        for observed in seen {
            match observed {
                Observed::Moving { stress } => {
                    pace = self.speed.pause(PACE_FILM);
                    let surface = walk.surface();
                    let at = [surface.mean_displacement, stress];
                    let gap = Arc::new(walk.gap());
                    let frame = Arc::new(Frame::moving(surface.control, at, gap));
                    self.recorder.moves(&frame);
                    sink(Event::Frame(frame));
                }
                Observed::Jump(jump) => {
                    self.recorder.jumps();
                    self.record.jumps.push(jump.clone());
                    sink(Event::Jump(jump));
                }
                Observed::State(state) => {
                    if matches!(self.play, Play::Sweep(_)) {
                        pace = self.speed.pause(PACE_STATE);
                    }
                    self.arrive(&mut walk, state, sink);
                }
            }
        }
        self.walk = Some(walk);
        // A sweep of a loop says by itself when it is closed.
        if self.play != Play::Sweep(Sweep::Loop)
            && !self.is_closed
            && let Some(closed) = self.record.closed()
        {
            self.close_loop(Some(&closed), now, sink);
        }
        self.not_before = Some(now + pace);
        self.follow_up(progress, now, cancel, sink);
    }

    /// After a panic: rests on the last good state, or at the start of the scene if there is none.
    pub fn recover(&mut self) {
        let Self {
            run,
            motion,
            setup,
            good,
            record,
            speed,
            ..
        } = std::mem::take(self);
        *self = Self {
            run,
            motion,
            setup,
            record,
            speed,
            ..Self::default()
        };
        if let Some(setup) = &mut self.setup {
            self.walk = match good {
                Some(good) => setup.resume(&good),
                None => setup.walk(&Cancel::default()).ok(),
            };
        }
    }

    /// Takes a walk up where it stands.
    fn stand(&mut self, mut walk: Walk, sink: &mut dyn FnMut(Event)) {
        let state = walk.record().clone();
        self.arrive(&mut walk, state, sink);
        self.walk = Some(walk);
    }

    /// Records a state on which the walk has come to stand, and hands it out.
    fn arrive(&mut self, walk: &mut Walk, state: StateRecord, sink: &mut dyn FnMut(Event)) {
        let before = [self.record.states.len(), self.record.jumps.len()];
        self.record.states.push(state.clone());
        sink(Event::State(state.clone()));
        let here = (walk.record().direction, walk.record().control);
        if here == (state.direction, state.control) {
            let stored = self.stored(walk, before);
            sink(Event::Stored(stored.clone()));
            self.good = Some(stored);
        }
        show_rest(walk, &mut self.recorder, sink);
    }

    /// Where a walk stands, to be kept.
    fn stored(&self, walk: &Walk, before: [usize; 2]) -> Arc<Stored> {
        let part = self.setup.as_ref().map_or(Part::Whole, |s| s.choice.part);
        Arc::new(Stored::of(walk, part, before))
    }

    /// Takes a stored state as the present one. Of the path stays what led to it, if it is of this
    /// path.
    fn go_on(&mut self, from: &Stored, sink: &mut dyn FnMut(Event)) {
        let known = |s: &StateRecord| {
            let what = |s: &StateRecord| (s.direction, s.control, s.energy.to_bits());
            what(s) == what(&from.record)
        };
        let place = self.record.states.get(from.before[0]);
        let stay = if place.is_some_and(known) {
            from.before
        } else {
            [0, 0]
        };
        if !self.stand_on(from, stay, sink) {
            self.rest(sink);
        }
    }

    /// Stands on a stored state, after so many states and jumps of the path; false, and says so, if
    /// it is of another scene.
    fn stand_on(
        &mut self,
        from: &Stored,
        [states, jumps]: [usize; 2],
        sink: &mut dyn FnMut(Event),
    ) -> bool {
        let Some(setup) = &mut self.setup else {
            return false;
        };
        let part = setup.choice.part;
        let Some(walk) = setup.resume(from) else {
            let remedy = "Open that scene, and walk there.";
            sink(Event::failed("This state is of another scene.", remedy));
            return false;
        };
        if part != from.part {
            sink(Event::Remodelled(setup.choice.clone()));
        }
        let spent = self.walk.as_ref().map_or(0, |w| w.counts().transforms);
        self.transforms_elsewhere += spent.saturating_sub(self.transforms_before);
        self.transforms_before = 0;
        (self.paused, self.recorder) = (false, Recorder::default());
        self.cut([states, jumps], sink);
        self.stand(walk, sink);
        if let Some(closed) = self.record.closed() {
            self.close_loop(Some(&closed), Instant::now(), sink);
        }
        self.rest(sink);
        true
    }

    /// Holds the resting surface pressed, on the whole cell: a push has no symmetry. False where it
    /// cannot be: then it rests.
    fn press(&mut self, push: Push, cancel: &Cancel, sink: &mut dyn FnMut(Event)) -> bool {
        let rests = matches!(self.play, Play::Rest | Play::Pressed(_));
        let (Some(setup), Some(walk)) = (&mut self.setup, &mut self.walk) else {
            return false;
        };
        if !rests || walk.is_jumping() {
            self.rest(sink);
            return false;
        }
        if walk.system().is_even() {
            let spent = walk.counts().transforms;
            let part = setup.choice.part;
            match setup.widen(walk, &Stuck::Pushed, cancel) {
                Some(widened) if widened.stays => {
                    sink(Event::Remodelled(setup.choice.clone()));
                    self.go_on_with(widened, spent, sink);
                }
                _ => {
                    setup.choice.part = part;
                    sink(Event::failed(
                        "This state is one of a part of the cell alone, and a push has no symmetry.",
                        "Choose the whole cell under Advanced, walk here, and push then.",
                    ));
                    self.rest(sink);
                    return false;
                }
            }
        }
        let Some(walk) = &mut self.walk else {
            return false;
        };
        let pressed = walk.pressed(&push);
        let energy = pressed.state.energy - walk.here().state.energy;
        sink(Event::Pressed { energy });
        let at = [pressed.state.mean_displacement, pressed.state.stress];
        let gap = Arc::new(walk.system().unfolded(&pressed.fields.gap));
        let frame = Frame::moving(pressed.state.control, at, gap);
        sink(Event::Frame(Arc::new(frame)));
        self.play = Play::Pressed(push);
        true
    }

    /// Forgets the path but for its first states and jumps.
    fn cut(&mut self, [states, jumps]: [usize; 2], sink: &mut dyn FnMut(Event)) {
        self.record.states.truncate(states);
        self.record.jumps.truncate(jumps);
        self.is_closed = false;
        sink(Event::Cut { states, jumps });
    }

    /// Another run, of which nothing is known yet.
    fn afresh(&self, run: RunId) -> Self {
        Self {
            run,
            speed: self.speed,
            ..Self::default()
        }
    }

    fn begin(
        &mut self,
        run: RunId,
        setup: Setup,
        from: Option<&Resumed>,
        cancel: &Cancel,
        sink: &mut dyn FnMut(Event),
    ) {
        *self = self.afresh(run);
        match setup.walk(cancel) {
            Ok(walk) => {
                let system = walk.system();
                let height = system.height().map(|h| Arc::new(system.unfolded(h)));
                let ready = Arc::new(Ready {
                    model: walk.model().clone(),
                    height,
                    choice: setup.choice.clone(),
                });
                sink(Event::Ready(ready));
                self.setup = Some(setup);
                if let Some(Resumed { state, along }) = from {
                    let stay = [along.states.len(), along.jumps.len()];
                    self.record = along.clone();
                    if self.stand_on(state, stay, sink) {
                        return;
                    }
                }
                self.record = LoopRecord::of(walk.control());
                let control = walk.record().control;
                self.stand(walk, sink);
                sink(Event::Rest { motion: 0, control });
            }
            Err(error) => self.refuse(run, error, sink),
        }
    }

    fn refuse(&mut self, run: RunId, error: Refusal, sink: &mut dyn FnMut(Event)) {
        *self = self.afresh(run);
        let message = format!("This scene cannot run: {} = {}", error.key, error.value);
        sink(Event::failed(message, error.allowed));
    }

    fn go(&mut self, play: Play, target: f64) {
        if let Some(walk) = &mut self.walk {
            walk.set_target(target);
            self.play = play;
            self.not_before = None;
        }
    }

    fn start_sweep(&mut self, sweep: Sweep, cancel: &Cancel, sink: &mut dyn FnMut(Event)) {
        let Some(setup) = &self.setup else { return };
        self.itinerary = match sweep {
            Sweep::Approach => Itinerary::one_way(&setup.scene, Direction::Approach),
            Sweep::Retract => Itinerary::one_way(&setup.scene, Direction::Retraction),
            Sweep::Loop => Itinerary::closed(&setup.scene),
        };
        self.paused = false;
        if sweep == Sweep::Loop {
            // A loop is only closed if it begins at the start of the drive, with the scene's own
            // seed.
            let walk = setup.walk(cancel);
            self.cut([0, 0], sink);
            self.walk = None;
            if let Ok(walk) = walk {
                self.stand(walk, sink);
            }
            self.loop_began = Some(Instant::now());
            self.transforms_elsewhere = 0;
            self.transforms_before = self.walk.as_ref().map_or(0, |w| w.counts().transforms);
            if let Some((fault, remedy)) = self.record.states.first().and_then(StateRecord::fault) {
                sink(Event::failed(format!("No loop: {fault}."), remedy));
                return self.rest(sink);
            }
        }
        self.follow_itinerary(sweep);
    }

    /// Makes for the end of the present way; false if there is none left.
    fn follow_itinerary(&mut self, sweep: Sweep) -> bool {
        let target = self.itinerary.target();
        if let Some(target) = target {
            self.go(Play::Sweep(sweep), target);
        }
        target.is_some()
    }

    /// What comes after a step: nothing, the next way, or rest.
    fn follow_up(
        &mut self,
        progress: Progress,
        now: Instant,
        cancel: &Cancel,
        sink: &mut dyn FnMut(Event),
    ) {
        let (Some(setup), Some(walk)) = (&mut self.setup, &mut self.walk) else {
            return;
        };
        match &progress {
            Progress::Cancelled => {}
            Progress::Working | Progress::Resting => {
                let arrived = match self.play {
                    Play::Sweep(sweep) => {
                        self.itinerary.step(&progress, walk.record())
                            && !self.follow_itinerary(sweep)
                    }
                    _ => progress == Progress::Resting,
                };
                if arrived {
                    if self.play == Play::Sweep(Sweep::Loop) {
                        self.close_loop(None, now, sink);
                    }
                    self.rest(sink);
                }
            }
            Progress::Stuck(reason) => {
                let spent = walk.counts().transforms;
                if let Some(widened) = setup.widen(walk, reason, cancel) {
                    sink(Event::Remodelled(setup.choice.clone()));
                    return self.go_on_with(widened, spent, sink);
                }
                sink(Event::failed(
                    format!("Not converged: {reason}."),
                    "The last good state stays. Try a smaller step, a finer mesh (lower mu_rho), or \
                     another seed.",
                ));
                self.rest(sink);
            }
        }
    }

    /// Takes another walk up, which stands where the last one stood or is back at the start of the
    /// drive.
    fn go_on_with(
        &mut self,
        Widened { mut walk, stays }: Widened,
        spent: usize,
        sink: &mut dyn FnMut(Event),
    ) {
        self.transforms_elsewhere += spent - self.transforms_before;
        self.transforms_before = 0;
        if stays {
            let last = self.record.states.len().saturating_sub(1);
            self.good = Some(self.stored(&walk, [last, self.record.jumps.len()]));
            show_rest(&mut walk, &mut self.recorder, sink);
            self.walk = Some(walk);
            return;
        }
        self.cut([0, 0], sink);
        self.stand(walk, sink);
        if self.play == Play::Sweep(Sweep::Loop) {
            // Back at the start, a loop has all of its way ahead again.
            self.itinerary = self
                .setup
                .as_ref()
                .map(|setup| Itinerary::closed(&setup.scene))
                .unwrap_or_default();
            self.follow_itinerary(Sweep::Loop);
        }
    }

    /// Tells what a loop has lost: that of a `closed` record, or of the record as it is.
    fn close_loop(
        &mut self,
        closed: Option<&LoopRecord>,
        now: Instant,
        sink: &mut dyn FnMut(Event),
    ) {
        let Some(walk) = &self.walk else { return };
        let record = closed.unwrap_or(&self.record);
        self.is_closed = true;
        let summary = LoopSummary {
            ledger: record.ledger(walk.model().law.surface_energy),
            transforms: self.transforms_elsewhere + walk.counts().transforms
                - self.transforms_before,
            seconds: self
                .loop_began
                .map_or(0.0, |t| now.duration_since(t).as_secs_f64()),
        };
        sink(Event::Loop(summary));
    }

    fn rest(&mut self, sink: &mut dyn FnMut(Event)) {
        let before = std::mem::take(&mut self.play);
        if let Some(walk) = &mut self.walk {
            // What is no longer pressed is seen as it stands.
            if matches!(before, Play::Pressed(_) | Play::LetGo(_)) && !walk.is_jumping() {
                show_rest(walk, &mut self.recorder, sink);
            }
            let control = walk.surface().control;
            walk.set_target(control);
            sink(Event::Rest {
                motion: self.motion,
                control,
            });
        }
    }
}

/// Hands out the picture of where a walk stands, and the film of the jump that led there.
fn show_rest(walk: &mut Walk, recorder: &mut Recorder, sink: &mut dyn FnMut(Event)) {
    let frame = Arc::new(Frame {
        soft_mode: walk.soft_mode().map(Arc::new),
        ..Frame::at_rest(walk.record(), Arc::new(walk.gap_here()))
    });
    let film = recorder.rests(&frame);
    sink(Event::Frame(frame));
    if let Some(film) = film {
        sink(Event::Film(Arc::new(film)));
    }
}
