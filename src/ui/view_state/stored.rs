//! The stored states of the path: looked at, scrubbed through, gone on from; the path as a strip of
//! patterns; the films of its jumps, and the picture that is shown.

use super::{Curve, Foresight, Ghost, Origin, ViewState};
use crate::follow::record::{Direction, LoopRecord, StateRecord};
use crate::physics::pattern::Pattern;
use crate::study::live_loop::LiveLoop;
use crate::worker::protocol::{Film, Frame, Stored};
use std::collections::VecDeque;
use std::sync::Arc;

/// Most bytes of stored states. Beyond it every second one of the older half goes.
const BYTES_MAX: usize = 1 << 28;

/// Most bytes of those of a path that was left.
const LEFT_MAX: usize = BYTES_MAX / 8;

/// Stored states by their place in the path, in order.
#[derive(Debug, Default)]
pub struct Store {
    kept: VecDeque<(usize, Arc<Stored>)>,
    bytes: usize,
    /// How many of the oldest states of the path the record no longer has.
    pub(super) forgotten: usize,
}

impl Store {
    /// These states, in order.
    pub(super) fn new(states: Vec<Arc<Stored>>) -> Self {
        let mut store = Self::default();
        states.into_iter().for_each(|stored| store.keep(stored));
        store
    }

    /// That of the state of this index in the record, if it is kept.
    pub fn at(&self, index: usize) -> Option<&Arc<Stored>> {
        let place = index + self.forgotten;
        let found = self.kept.binary_search_by_key(&place, |(place, _)| *place);
        found.ok().map(|index| &self.kept[index].1)
    }

    /// The newest.
    pub fn newest(&self) -> Option<&Arc<Stored>> {
        self.kept.back().map(|(_, stored)| stored)
    }

    /// All of them, in order.
    pub fn all(&self) -> impl Iterator<Item = &Arc<Stored>> {
        self.kept.iter().map(|(_, stored)| stored)
    }

    /// Keeps one more.
    pub(super) fn keep(&mut self, stored: Arc<Stored>) {
        self.bytes += stored.bytes();
        self.kept.push_back((stored.before[0], stored));
        if self.bytes > BYTES_MAX {
            self.thin();
        }
    }

    /// The path goes back to its first `states`; returns the others, as many as there is room for.
    pub(super) fn cut(&mut self, states: usize) -> Vec<Arc<Stored>> {
        let from = self.kept.partition_point(|(place, _)| *place < states);
        let mut left: Vec<_> = self.kept.drain(from..).map(|(_, stored)| stored).collect();
        self.weigh();
        while left.len() > 1 && left.iter().map(|stored| stored.bytes()).sum::<usize>() > LEFT_MAX {
            left = left.into_iter().step_by(2).collect();
        }
        left
    }

    fn thin(&mut self) {
        let half = self.kept.len() / 2;
        let mut index = 0;
        self.kept.retain(|_| {
            index += 1;
            index > half || index % 2 == 1
        });
        self.weigh();
    }

    fn weigh(&mut self) {
        self.bytes = self.kept.iter().map(|(_, stored)| stored.bytes()).sum();
    }
}

/// The span of one pattern along the control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Which way it was gone.
    pub direction: Direction,
    /// The control where it begins and where it ends.
    pub ends: [f64; 2],
    /// The pattern.
    pub pattern: Pattern,
}

impl Span {
    /// The letter of its pattern.
    pub fn letter(&self) -> &'static str {
        match self.pattern {
            Pattern::Flat => "F",
            Pattern::Bulge => "B",
            Pattern::Ridge => "R",
            Pattern::Dimple => "D",
            Pattern::Contact => "C",
            Pattern::Other => "–",
        }
    }
}

/// The patterns along a path, in order.
pub fn spans(record: &LoopRecord) -> Vec<Span> {
    let mut before: Option<f64> = None;
    let span = |piece: &[StateRecord]| {
        let [first, last] = [&piece[0], &piece[piece.len() - 1]];
        Span {
            direction: first.direction,
            ends: [
                before.replace(last.control).unwrap_or(first.control),
                last.control,
            ],
            pattern: first.pattern,
        }
    };
    record.pieces().map(span).collect()
}

/// The patterns that a live loop foresees.
pub fn foreseen(live: &LiveLoop) -> Vec<Span> {
    let legs = live.legs.iter();
    legs.map(|leg| Span {
        direction: leg.direction,
        ends: [leg.from, leg.to],
        pattern: live.segments[leg.segment].pattern,
    })
    .collect()
}

impl ViewState {
    /// Looks at the newest state of this direction whose control is nearest to a value; where nothing
    /// was walked, at the one that is foreseen there.
    pub fn select_on(&mut self, direction: Direction, control: f64) {
        if let Some(spot) = self.spot_ahead(direction, control) {
            return self.foresee(None, spot);
        }
        let states = self.run.record.states.iter().enumerate().rev();
        let off = |state: &StateRecord| (state.control - control).abs();
        let nearest = states
            .filter(|(_, state)| state.direction == direction)
            .min_by(|a, b| off(a.1).total_cmp(&off(b.1)));
        if let Some(index) = nearest.map(|(index, _)| index) {
            self.select(index);
        }
    }

    /// Looks at the state `by` further on along the path; from nowhere at the newest.
    pub fn step_state(&mut self, by: isize) {
        let Some(last) = self.run.record.states.len().checked_sub(1) else {
            return;
        };
        let index = match self.run.selection.as_ref().map(|selection| selection.of) {
            Some(Origin::Walked(index)) => index.saturating_add_signed(by).min(last),
            _ => last,
        };
        self.select(index);
    }

    /// The stored or foreseen state somebody looks at, if its picture is kept.
    pub fn looked_at(&self) -> Option<&Arc<Stored>> {
        match self.run.selection.as_ref()?.of {
            Origin::Walked(index) => self.run.store.at(index),
            Origin::Foreseen => self.run.foresight.found.as_ref(),
            Origin::Left([ghost, state]) => self.plots.ghosts.get(ghost)?.states.get(state),
        }
    }

    /// What the map shows in place of the present state, in a word.
    pub fn shown_word(&self) -> Option<&'static str> {
        let run = &self.run;
        match &run.selection {
            _ if run.replayed.is_some() => Some("replay"),
            _ if run.shown.is_none() => None,
            Some(selection) if selection.of == Origin::Foreseen => Some("foreseen"),
            _ => Some("stored"),
        }
    }

    /// Takes the state somebody looks at as the present one.
    pub fn go_on(&mut self) {
        if let Some(stored) = self.looked_at().cloned() {
            self.resume(stored);
        }
    }

    /// Takes a stored state of this scene as the present one; the solver is told at the end of the
    /// frame.
    pub(super) fn resume(&mut self, stored: Arc<Stored>) {
        self.target = self.held(stored.record.control);
        self.run.resume(stored, self.target);
    }

    /// The path goes back to its first states and jumps; all of it becomes a ghost.
    pub(super) fn cut(&mut self, states: usize, jumps: usize) {
        let run = &mut self.run;
        (run.selection, run.shown, run.replayed, run.closed_loop) = (None, None, None, None);
        run.foresight = Foresight::default();
        let left = states.saturating_sub(run.store.forgotten);
        let curve = std::mem::take(&mut run.curve);
        let ghost = Ghost {
            curve,
            states: run.store.cut(states),
        };
        if left < run.record.states.len() {
            self.plots.add_ghost(ghost);
        }
        let run = &mut self.run;
        run.record.states.truncate(left);
        run.record.jumps.truncate(jumps);
        let law = &self.model.law;
        run.curve = Curve::of(&run.record, law);
        run.stiffness = Curve::of_ordinate(&run.record, law, |s| s.stiffness_min);
        // What follows a jump that stays is added after it.
        if states > 0 {
            return;
        }
        (run.store.forgotten, run.films) = (0, Films::default());
        self.hint_afresh();
    }
}

/// Most numbers in all the films that are kept: 128 MB. The oldest go.
const VALUES_MAX: usize = 1 << 24;

/// Films by the index of their jump.
#[derive(Debug, Default)]
pub struct Films(VecDeque<(usize, Arc<Film>)>);

impl Films {
    /// These, with the index of their jump.
    pub(super) fn new(films: Vec<(usize, Arc<Film>)>) -> Self {
        Self(films.into())
    }

    /// All that are kept.
    pub(super) fn all(&self) -> impl Iterator<Item = (usize, Arc<Film>)> {
        self.0.iter().cloned()
    }

    /// That of a jump, if it is kept.
    pub fn of(&self, jump: usize) -> Option<&Arc<Film>> {
        let found = self.0.iter().find(|(index, _)| *index == jump);
        found.map(|(_, film)| film)
    }

    /// Keeps the film of a jump.
    pub(super) fn keep(&mut self, jump: usize, film: Arc<Film>) {
        self.0.push_back((jump, film));
        let size = |film: &Film| film.count() * film.after.gap.len();
        let mut all: usize = self.0.iter().map(|(_, film)| size(film)).sum();
        while self.0.len() > 1 && all > VALUES_MAX {
            all -= self.0.pop_front().map_or(0, |(_, film)| size(&film));
        }
    }
}

impl ViewState {
    /// The picture that map and profile show: a moment of a replay, a stored state, or the newest.
    pub fn pictured(&self) -> Option<&Arc<Frame>> {
        let old = self.run.replayed.as_ref().or(self.run.shown.as_ref());
        old.or(self.frame.as_ref())
    }

    /// The picture of the surface while it jumps.
    pub fn jumping(&self) -> Option<&Arc<Frame>> {
        self.frame.as_ref().filter(|frame| frame.relaxing)
    }

    /// The jump that is explained: the one that is looked at, or the newest.
    pub fn told_jump(&self) -> Option<usize> {
        let selected = self.run.selected_jump();
        selected.or_else(|| self.run.record.jumps.len().checked_sub(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::system::{Fields, State};
    use crate::scene::Part;
    use crate::solver::method::{Cost, Equilibrium, Stop};
    use ndarray::Array2;

    fn stored(place: usize, side: usize) -> Arc<Stored> {
        Arc::new(Stored {
            record: StateRecord::placeholder(place as f64),
            before: [place, 0],
            part: Part::Whole,
            surface: Equilibrium {
                state: State {
                    control: 0.0,
                    mean_displacement: 0.0,
                    amplitudes: Vec::new(),
                    energy: 0.0,
                    stress: 0.0,
                },
                fields: Fields::default(),
                residual: 0.0,
                stiffness_min: None,
                soft_mode: Vec::new(),
                stop: Stop::Stable,
                cost: Cost::default(),
            },
            gap: Array2::zeros((side, side)),
        })
    }

    #[test]
    fn a_full_store_keeps_the_newer_half_and_every_second_state_of_the_older_one() {
        // Eight of them fit.
        let side = ((BYTES_MAX / 8 - 4096) as f64 / 4.0).sqrt() as usize;
        let mut store = Store::default();
        (0..9).for_each(|place| store.keep(stored(place, side)));
        let kept: Vec<usize> = (0..9).filter(|place| store.at(*place).is_some()).collect();
        assert_eq!(kept, [0, 2, 4, 5, 6, 7, 8]);
        assert!(store.bytes <= BYTES_MAX);
        let left = store.cut(5);
        assert_eq!(left.len(), 1, "as many as an eighth of the room holds");
        assert_eq!(store.newest().map(|stored| stored.before[0]), Some(4));
    }

    #[test]
    fn the_oldest_films_go_when_they_fill_the_memory_and_the_newest_stays() {
        let frame = |n: usize| {
            Arc::new(Frame::of_a_branch(
                0.0,
                [0.0; 2],
                Arc::new(Array2::zeros((n, n))),
            ))
        };
        let film = |n: usize| {
            Arc::new(Film {
                before: frame(n),
                moving: Vec::new(),
                after: frame(n),
            })
        };
        let mut films = Films::default();
        // Two pictures each: three films of this size fit.
        let side = (VALUES_MAX as f64 / 6.0).sqrt() as usize;
        (0..5).for_each(|jump| films.keep(jump, film(side)));
        let kept: Vec<bool> = (0..5).map(|jump| films.of(jump).is_some()).collect();
        assert_eq!(kept, [false, false, true, true, true]);
        films.keep(5, film(3 * side));
        assert!(films.of(5).is_some() && films.of(4).is_none());
    }
}
