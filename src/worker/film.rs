//! Makes the film of each jump out of the pictures of a walk.

use super::protocol::{Film, Frame};
use std::sync::Arc;

/// Most pictures of the moving surface in one film.
const MOVING_MAX: usize = 64;

/// What was seen since the surface last rested.
#[derive(Debug, Default)]
pub struct Recorder {
    before: Option<Arc<Frame>>,
    moving: Vec<Arc<Frame>>,
    /// Pictures since the last one that was kept, and of how many one is kept.
    passed: usize,
    every: usize,
    jumped: bool,
}

impl Recorder {
    /// The surface moves.
    pub fn moves(&mut self, frame: &Arc<Frame>) {
        self.passed += 1;
        if self.passed < self.every {
            return;
        }
        self.passed = 0;
        self.moving.push(frame.clone());
        if self.moving.len() == MOVING_MAX {
            self.moving = std::mem::take(&mut self.moving)
                .into_iter()
                .step_by(2)
                .collect();
            // The newest has gone too.
            self.passed = self.every.max(1);
            self.every = 2 * self.passed;
        }
    }

    /// The motion is a jump; where it landed follows.
    pub fn jumps(&mut self) {
        self.jumped = true;
    }

    /// The surface rests; the film of the jump that led here, if one did.
    pub fn rests(&mut self, frame: &Arc<Frame>) -> Option<Film> {
        let ended = std::mem::replace(
            self,
            Self {
                before: Some(frame.clone()),
                ..Self::default()
            },
        );
        let before = ended.before.filter(|_| ended.jumped)?;
        Some(Film {
            before,
            moving: ended.moving,
            after: frame.clone(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;

    fn frame(u0: f64, gap: f64, mode: Option<f64>) -> Arc<Frame> {
        let field = |value: f64| Arc::new(Array2::from_elem((1, 4), value));
        Arc::new(Frame {
            soft_mode: mode.map(field),
            ..Frame::of_a_branch(u0, [u0, 0.0], field(gap))
        })
    }

    #[test]
    fn a_film_has_both_ends_and_an_even_choice_of_what_is_between() {
        let mut recorder = Recorder::default();
        assert!(recorder.rests(&frame(3.0, 3.0, Some(1.0))).is_none());
        let seen = 5 * MOVING_MAX;
        for i in 0..seen {
            recorder.moves(&frame(3.0, i as f64, None));
        }
        recorder.jumps();
        let film = recorder.rests(&frame(3.0, -1.0, None)).expect("it jumped");
        assert_eq!(film.count(), film.frames().count());
        let kept: Vec<f64> = film.moving.iter().map(|f| f.gap[(0, 0)]).collect();
        assert!(
            kept.len() < MOVING_MAX && kept.len() >= MOVING_MAX / 4,
            "{kept:?}"
        );
        let step = kept[1] - kept[0];
        assert!(kept.windows(2).all(|w| w[1] - w[0] == step), "{kept:?}");
        assert!(seen as f64 - kept[kept.len() - 1] <= 2.0 * step, "{kept:?}");
    }

    #[test]
    fn a_motion_that_was_no_jump_leaves_no_film() {
        let mut recorder = Recorder::default();
        recorder.rests(&frame(3.0, 3.0, None));
        recorder.moves(&frame(3.0, 2.0, None));
        assert!(recorder.rests(&frame(3.0, 2.9, None)).is_none());
        recorder.jumps();
        let film = recorder.rests(&frame(3.0, 1.0, None)).expect("it jumped");
        assert_eq!((film.moving.len(), film.before.gap[(0, 0)]), (0, 2.9));
    }

    #[test]
    fn the_soft_mode_points_the_way_the_surface_went() {
        let [before, after] = [frame(3.0, 3.0, Some(1.0)), frame(3.0, 1.0, None)];
        let film = Film {
            before,
            moving: Vec::new(),
            after,
        };
        assert_eq!(film.soft_mode().expect("a mode")[(0, 0)], -1.0);
    }
}
