//! The surface pressed by hand, and what is said of it.

use super::ViewState;
use crate::follow::record::StateRecord;
use crate::follow::walk::Push;
use crate::study::landscape::Standing;
use crate::worker::protocol::Play;

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
