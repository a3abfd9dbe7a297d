//! What a session file keeps of the window beside the scene, and how it is taken up again.

use super::kept::SavedLoop;
use super::{Curve, Films, KeptLoops, Store, ViewState};
use crate::follow::record::LoopRecord;
use crate::plot::curve::eigenvalue_scale;
use crate::scene::Scene;
use crate::scene::part::Strategy;
use crate::solver::methods::MethodKind;
use crate::storage::session::Session;
use crate::worker::protocol::{Film, Stored};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// The run of a session: how it is computed, where it went, what is kept of it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Saved {
    method: MethodKind,
    asked: Option<Strategy>,
    record: LoopRecord,
    /// In the order of the path; the last one is where the surface stands.
    states: Vec<Arc<Stored>>,
    /// With the index of their jump.
    films: Vec<(usize, Arc<Film>)>,
    kept: Vec<SavedLoop>,
}

/// How much of a run is saved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// Everything that is kept.
    Whole,
    /// Records, and of the stored states the one where the surface stands: a picture carries that.
    Present,
}

impl Saved {
    /// Its states and jumps.
    pub fn record(&self) -> &LoopRecord {
        &self.record
    }

    /// How many of its states can be shown.
    pub fn states(&self) -> usize {
        self.states.len()
    }

    /// What contradicts itself or the scene, in words.
    fn fault(&self, scene: &Scene) -> Option<String> {
        let model = match scene.model() {
            Ok(model) => model,
            Err(refusal) => return Some(refusal.to_string()),
        };
        let mesh = (model.grid.ny, model.grid.nx);
        let films = self.films.iter().flat_map(|(_, film)| film.frames());
        let of_mesh = self.states.iter().all(|state| state.gap.dim() == mesh)
            && films.into_iter().all(|frame| frame.gap.dim() == mesh);
        if !of_mesh {
            return Some("its states are of another mesh than its scene".to_owned());
        }
        let LoopRecord { states, jumps, .. } = &self.record;
        let places = self.states.iter().map(|state| state.before[0]);
        let in_order = places.clone().is_sorted_by(|a, b| a < b);
        let last = self.states.last().map_or([0, 0], |state| state.before);
        let on_path = last[0] < states.len().max(1) && last[1] <= jumps.len();
        (!(in_order && on_path)).then(|| "its states are not those of its loop".to_owned())
    }
}

impl ViewState {
    /// The session as it is now, to be saved. Its states are those that `record` still has.
    pub fn session(&self, extent: Extent) -> Session<Saved> {
        let run = &self.run;
        let renumbered = |stored: &Arc<Stored>| {
            let place = stored.before[0].checked_sub(run.store.forgotten)?;
            if run.store.forgotten == 0 {
                return Some(stored.clone());
            }
            let mut stored = Stored::clone(stored);
            stored.before[0] = place;
            Some(Arc::new(stored))
        };
        let (states, films) = match extent {
            Extent::Whole => (run.store.all().collect(), run.films.all().collect()),
            Extent::Present => (run.store.newest().into_iter().collect(), Vec::new()),
        };
        let states: Vec<&Arc<Stored>> = states;
        Session {
            scene: (*self.scene).clone(),
            notes: self.notes.clone(),
            window: Saved {
                method: self.method,
                asked: self.asked,
                record: run.record.clone(),
                states: states.into_iter().filter_map(renumbered).collect(),
                films,
                kept: self.plots.kept.saved(),
            },
        }
    }

    /// Takes a session up where it was left.
    ///
    /// # Errors
    /// In words, where it contradicts itself; nothing has changed then.
    pub fn reopen(&mut self, session: Session<Saved>) -> Result<(), String> {
        let Session {
            scene,
            notes,
            window,
        } = session;
        if let Some(fault) = window.fault(&scene) {
            return Err(fault);
        }
        let Saved {
            method,
            asked,
            mut record,
            mut states,
            films,
            kept,
        } = window;
        (self.method, self.asked, self.notes) = (method, asked, notes);
        self.open_scene(scene);
        self.plots.kept = KeptLoops::new(kept);
        let Some(here) = states.pop() else {
            return Ok(());
        };
        // Where the surface stands is told by the solver.
        record.states.truncate(here.before[0]);
        record.jumps.truncate(here.before[1]);
        let (law, run) = (&self.model.law, &mut self.run);
        run.curve = Curve::of(&record, law);
        run.stiffness = Curve::of_ordinate(&record, law, |s| eigenvalue_scale(s.stiffness_min));
        run.record = record;
        run.store = Store::new(states);
        run.films = Films::new(films);
        self.resume(here);
        Ok(())
    }
}
