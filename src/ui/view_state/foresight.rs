//! What is known of states that nobody has gone to. Those that a live loop foresees: asked for where
//! it is clicked, found beside the walk, looked at like stored ones. And A | B: the scene of a kept
//! loop beside the present one, at the same u0 and on a drive in the same direction, read off its
//! atlas.

use super::{Kept, Origin, Selection, ViewState};
use crate::follow::record::Direction;
use crate::lessons::Hidden;
use crate::scene::Part;
use crate::scene::parameter::fixed;
use crate::study::live_loop::{LiveLoop, Spot};
use crate::ui::action::Scales;
use crate::worker::SolverHandle;
use crate::worker::background::{Wanted, foreseen, live_loop};
use crate::worker::job::Job;
use crate::worker::protocol::{Frame, LiveState, Stored};
use std::sync::Arc;

/// How much nearer than what lies upon it a curve must be to be meant, in shares of the reach.
pub(super) const UPON: f64 = 0.4;

/// A place on a live loop or a kept one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ahead {
    /// How far away it is, in units of the reach.
    pub off: f64,
    /// Of which kept loop; `None` of the live one.
    pub kept: Option<usize>,
    /// Where on it.
    pub spot: Spot,
}

/// The search for states of live loops, one at a time: the newest request waits for the one before, so
/// that a hand that drags sees something on its way.
#[derive(Debug, Default)]
pub struct Foresight {
    next: Option<Wanted>,
    job: Option<(Wanted, Job<Arc<Stored>>)>,
    /// The newest state that was found.
    pub found: Option<Arc<Stored>>,
}

impl Foresight {
    /// Asks for a state; a request that still waits is dropped.
    pub fn ask(&mut self, wanted: Wanted) {
        self.next = Some(wanted);
    }

    /// The place that is asked for.
    pub fn wanted(&self) -> Option<&Wanted> {
        let searched = self.job.as_ref().map(|(wanted, _)| wanted);
        self.next.as_ref().or(searched)
    }

    /// Takes in what was found, and begins the next search. Tells what is new: a state, or why there
    /// is none.
    pub fn update(&mut self, solver: &dyn SolverHandle) -> Option<Result<Arc<Stored>, String>> {
        let mut news = None;
        if let Some((_, job)) = &mut self.job
            && let Some(end) = job.poll()
        {
            news = job.so_far.take().map(Ok).or(end.err().map(Err));
            self.job = None;
            if let Some(Ok(stored)) = &news {
                self.found = Some(stored.clone());
            }
        }
        if self.job.is_none() {
            let begin = |wanted: Wanted| (wanted.clone(), solver.job(wanted, foreseen));
            self.job = self.next.take().map(begin);
        }
        news
    }
}

impl ViewState {
    /// The live loop of this very scene, if it may be seen.
    pub fn live(&self) -> Option<&LiveLoop> {
        self.live_state()?.found.as_ref().ok()
    }

    fn live_state(&self) -> Option<&Arc<LiveState>> {
        let live = self.own_live().filter(|_| !self.hides(Hidden::Forecast));
        live.map(|live| &live.state)
    }

    /// What is drawn nearest to (u0/rho, stress/sigma_max) of the live loop, and of the kept ones
    /// where they do not lie beneath it.
    pub(super) fn nearest_ahead(&self, at: [f64; 2], reach: [f64; 2]) -> Option<Ahead> {
        let place = |found: &LiveLoop, units: [f64; 2], kept: Option<usize>| {
            let own = |p: [f64; 2]| [p[0] * units[0], p[1] * units[1]];
            let (off, spot) = found.nearest(own(at), own(reach))?;
            Some(Ahead { off, kept, spot })
        };
        let natural = [self.rho(), self.model.law.traction_max()];
        let live = self.live().and_then(|live| place(live, natural, None));
        let of_kept = |kept: &Kept| {
            let live = kept.live.as_ref()?.found.as_ref().ok()?;
            place(live, self.units_of(kept), Some(kept.id))
        };
        let kept = self.plots.kept.drawn().filter_map(of_kept);
        let kept = kept.min_by(|a, b| a.off.total_cmp(&b.off));
        match (live, kept) {
            (Some(live), Some(kept)) if kept.off + UPON >= live.off => Some(live),
            (live, kept) => kept.or(live),
        }
    }

    /// Asks for the state that is foreseen at a place; of a kept loop, where that is of this scene.
    pub(super) fn foresee(&mut self, kept: Option<usize>, spot: Spot) {
        let live = match kept.and_then(|id| self.plots.kept.get(id)) {
            None => self.live_state().cloned(),
            Some(kept) if kept.model != self.model || kept.scene.drive != self.scene.drive => {
                let words = format!(
                    "“{}” is of another scene: Open in the tab Loops goes there, A | B shows it \
                     beside this one",
                    kept.name
                );
                self.messages.notice = Some(words);
                None
            }
            Some(kept) => kept.live.clone(),
        };
        let Some(live) = live else {
            return;
        };
        let ready = self.run.ready.as_ref();
        self.run.foresight.ask(Wanted {
            scene: self.scene.clone(),
            part: ready.map_or(Part::Whole, |ready| ready.choice.part),
            live,
            spot,
        });
    }

    /// The place of the live loop that is foreseen in a direction of the drive, where nothing was
    /// walked.
    pub(super) fn spot_ahead(&self, direction: Direction, control: f64) -> Option<Spot> {
        let states = &self.run.record.states;
        let walked = |pair: &[crate::follow::record::StateRecord]| {
            let [a, b] = [pair[0].control, pair[1].control];
            pair[1].direction == direction && (a.min(b)..=a.max(b)).contains(&control)
        };
        if states.windows(2).any(walked) {
            return None;
        }
        self.live()?.spot(direction, control)
    }

    /// Once a frame: looks at a foreseen state that was found.
    pub fn update_foresight(&mut self, solver: &dyn SolverHandle) {
        match self.run.foresight.update(solver) {
            Some(Ok(stored)) => {
                self.run.selection = Some(Selection {
                    of: Origin::Foreseen,
                    state: stored.record.clone(),
                    jump: None,
                });
                self.run.shown = Some(Arc::new(stored.frame()));
            }
            Some(Err(why)) => self.messages.notice = Some(format!("nothing to show here: {why}")),
            None => {}
        }
    }
}

/// What stands beside the present scene.
#[derive(Debug)]
pub struct Beside {
    /// Which of the kept loops.
    pub of: usize,
    live: Option<Job<Arc<LiveState>>>,
    foresight: Foresight,
    /// The place last asked for.
    asked: Option<Spot>,
    /// Its surface, or why there is none.
    pub shown: Result<Arc<Frame>, String>,
}

impl Beside {
    fn new(of: usize) -> Self {
        Self {
            of,
            live: None,
            foresight: Foresight::default(),
            asked: None,
            shown: Err("its live loop is on its way".to_owned()),
        }
    }

    /// Finds its state at `u0` in this direction; `kept` learns its live loop.
    fn update(
        &mut self,
        kept: &mut Kept,
        (direction, u0): (Direction, f64),
        solver: &dyn SolverHandle,
    ) {
        let Some(live) = kept.live.clone() else {
            let job = self
                .live
                .get_or_insert_with(|| solver.job(kept.scene.clone(), live_loop));
            if let Some(Err(why)) = job.poll() {
                self.shown = Err(why);
            }
            if let Some(live) = job.so_far.take() {
                kept.foretold(live);
            }
            return;
        };
        let spot = match &live.found {
            Err(why) => Err(format!("it has no live loop: {why}")),
            Ok(found) => found.spot_of(direction, u0).ok_or_else(|| {
                let u0 = fixed(u0 / found.law.range, 3);
                format!("its drive does not come to u₀ = {u0} ρ on {direction}")
            }),
        };
        match spot {
            Err(why) => (self.shown, self.asked) = (Err(why), None),
            Ok(spot) if self.asked.replace(spot) != Some(spot) => {
                let even = kept.model.grid.nx.is_multiple_of(4);
                self.foresight.ask(Wanted {
                    scene: kept.scene.clone(),
                    part: if even { Part::Quarter } else { Part::Whole },
                    live,
                    spot,
                });
            }
            Ok(_) => {}
        }
        if let Some(news) = self.foresight.update(solver) {
            let frame = news.map(|stored| Arc::new(stored.frame()));
            // What is no longer asked for is not shown.
            if self.asked.is_some() {
                self.shown = frame;
            }
        }
    }
}

impl ViewState {
    /// The scene beside this one, with its kept loop.
    pub fn beside(&self) -> Option<(&Beside, &Kept)> {
        let beside = self.beside.as_ref().filter(|_| !self.hides_kept())?;
        Some((beside, self.plots.kept.get(beside.of)?))
    }

    /// Puts the scene of a kept loop beside this one, or takes it away.
    pub(super) fn put_beside(&mut self, id: usize) {
        let is_there = self.beside.as_ref().is_some_and(|beside| beside.of == id);
        self.beside = (!is_there).then(|| Beside::new(id));
    }

    /// Once a frame: what stands beside goes where the surface is that is shown.
    pub fn update_beside(&mut self, solver: &dyn SolverHandle) {
        let shown = self
            .run
            .shown
            .as_ref()
            .and_then(|frame| frame.state.as_ref());
        let Some(now) = shown.or(self.run.state.as_ref()) else {
            return;
        };
        let (direction, u0) = (now.direction, now.mean_displacement);
        let (rho, scales) = (self.rho(), self.view.scales);
        let Some(beside) = &mut self.beside else {
            return;
        };
        let Some(kept) = self.plots.kept.get_mut(beside.of) else {
            self.beside = None;
            return;
        };
        let ranges = match scales {
            Scales::Own => kept.model.law.range / rho,
            Scales::Absolute => 1.0,
        };
        beside.update(kept, (direction, u0 * ranges), solver);
    }

    /// What both scenes lose, in words; `None` while one of them is not known.
    pub fn losses_in_words(&self) -> Option<String> {
        let (_, kept) = self.beside()?;
        let a = self
            .run
            .loss()
            .or(self.live().map(|live| live.dissipated_energy))?;
        let b = kept.loss?;
        let energies = [self.model.law.surface_energy, kept.model.law.surface_energy];
        let ([a, b], unit) = match self.view.scales {
            Scales::Absolute if energies[0] != energies[1] => {
                ([a * energies[0], b * energies[1]], "E* times length")
            }
            _ => ([a, b], "γ"),
        };
        let more = b - a;
        let words = if more == 0.0 {
            "as much".to_owned()
        } else {
            let word = if more > 0.0 { "more" } else { "less" };
            format!(
                "{:.4} {unit} {word} ({:.1}\u{a0}%)",
                more.abs(),
                100.0 * (more / a).abs()
            )
        };
        let [a, b] = [a, b].map(|loss| fixed(loss, 4));
        Some(format!("A loses {a}, B {b} {unit}: B {words}"))
    }
}
