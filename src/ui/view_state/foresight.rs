//! States that a live loop foresees: asked for where it is clicked, found beside the walk, looked
//! at like stored ones.

use super::{Kept, Origin, Selection, ViewState};
use crate::follow::record::Direction;
use crate::lessons::Hidden;
use crate::scene::part::Part;
use crate::study::live_loop::{LiveLoop, Spot};
use crate::worker::SolverHandle;
use crate::worker::background::{Wanted, foreseen};
use crate::worker::job::Job;
use crate::worker::protocol::{LiveState, Stored};
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

/// The search for states of live loops, one at a time: the newest wish waits for the one before, so
/// that a hand that drags sees something on its way.
#[derive(Debug, Default)]
pub struct Foresight {
    wish: Option<Wanted>,
    job: Option<(Wanted, Job<Arc<Stored>>)>,
    /// The newest state that was found.
    pub found: Option<Arc<Stored>>,
}

impl Foresight {
    /// Asks for a state; a wish that still waits is dropped.
    pub fn ask(&mut self, wanted: Wanted) {
        self.wish = Some(wanted);
    }

    /// The place that is asked for.
    pub fn wish(&self) -> Option<&Wanted> {
        let searched = self.job.as_ref().map(|(wanted, _)| wanted);
        self.wish.as_ref().or(searched)
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
            let begin = |wish: Wanted| (wish.clone(), solver.job(wish, foreseen));
            self.job = self.wish.take().map(begin);
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
        let live = self.plots.live.as_ref();
        // That of an edited scene comes a moment later.
        let live = live.filter(|live| live.run == self.run.id && !self.hides(Hidden::Forecast));
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
