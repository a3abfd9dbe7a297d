//! The films of the jumps of a run, and the picture that is shown.

use super::ViewState;
use crate::worker::protocol::{Film, Frame};
use std::collections::VecDeque;
use std::sync::Arc;

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
        let selected = self
            .run
            .selection
            .as_ref()
            .and_then(|selection| selection.jump);
        selected.or_else(|| self.run.record.jumps.len().checked_sub(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;

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
