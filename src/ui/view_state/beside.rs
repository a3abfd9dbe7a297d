//! A | B: the scene of a kept loop beside the present one, at the same u0 and on a drive in the same
//! direction, read off its atlas.

use super::{Foresight, Kept, ViewState};
use crate::follow::record::Direction;
use crate::scene::part::Part;
use crate::scene::units::fixed;
use crate::study::live_loop::Spot;
use crate::ui::action::Scales;
use crate::worker::SolverHandle;
use crate::worker::background::{Wanted, live_loop};
use crate::worker::job::Job;
use crate::worker::protocol::{Frame, LiveState};
use std::sync::Arc;

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
            // Of a wish that is no longer one nothing is shown.
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
        let closed = self.run.closed_loop.as_ref();
        let walked = closed.and_then(|closed| closed.summary.ledger.dissipated_energy());
        let a = walked.or(self.live().map(|live| live.dissipated_energy))?;
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
