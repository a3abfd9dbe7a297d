//! The live loop of a soft machine, by the walk. Its landings are others than those at fixed u0,
//! which the atlas knows, and each would have to be released anew: the walk does just that, in
//! about a second on the mesh of the hand.

use super::{Leg, LiveLoop, SAME, SAMPLES, Sample, Segment, unmapped};
use crate::follow::atlas::Unmapped;
use crate::follow::record::{Direction, JumpRecord, StateRecord};
use crate::follow::run::{LoopRun, Outcome, Report, run_loop};
use crate::follow::walk::WalkOptions;
use crate::numerics::cancel::Cancel;
use crate::physics::pattern::Pattern;
use crate::scene::part::{Part, Strategy};
use crate::scene::{Model, Range, Scene};

/// The loop of a scene's drive on so many points a side of its quarter; `is_stale` interrupts it.
///
/// # Errors
/// Why there is none.
pub(super) fn walked(
    scene: &Scene,
    model: &Model,
    points: usize,
    cancel: &Cancel,
    is_stale: &dyn Fn() -> bool,
) -> Result<LiveLoop, Unmapped> {
    let mut coarser = scene.clone();
    let points = points.next_multiple_of(4);
    coarser.cell.points = scene.cell.points.resized(points);
    coarser.law.range = Range::Length(model.law.range);
    let way = scene.drive.start - scene.depth();
    coarser.drive.step = scene.drive.step.max(way / SAMPLES as f64);
    let options = WalkOptions {
        part: Part::Quarter,
        ..WalkOptions::default()
    };
    let cancel = cancel.part();
    // States before each jump.
    let (mut count, mut before) = (0, Vec::new());
    let run = run_loop(&coarser, options, &cancel, &mut |report| {
        match report {
            Report::State { index, .. } => count = index + 1,
            Report::Jump(_) => before.push(count),
        }
        if is_stale() {
            cancel.request();
        }
    })
    .map_err(|refusal| unmapped(&refusal.to_string()))?;
    match (&run.outcome, &run.deviation) {
        (Outcome::NotConverged { reason, .. }, _) => return Err(unmapped(&reason.to_string())),
        (Outcome::Cancelled, _) => return Err(unmapped("it was interrupted")),
        // Begun afresh on another part, and too slow to be live.
        (Outcome::Completed, Some(why)) => return Err(unmapped(why)),
        (Outcome::Completed, None) => {}
    }
    let ledger = run.record.ledger(model.law.surface_energy);
    let Some(dissipated_energy) = ledger.dissipated_energy() else {
        return Err(unmapped("the loop is not closed"));
    };
    let (control, length) = (scene.control(), model.grid.length);
    let mut this = LiveLoop::empty(&model.law, control, length, points, Strategy::QUARTER);
    this.dissipated_energy = dissipated_energy;
    for piece in pieces(&run, &before) {
        this.take(piece);
    }
    this.link();
    this.jumps = run.record.jumps;
    Ok(this)
}

/// States of one pattern and direction in a row.
struct Piece {
    direction: Direction,
    pattern: Pattern,
    samples: Vec<Sample>,
}

/// The pieces of a walk with jumps after so many states each.
fn pieces(run: &LoopRun, before: &[usize]) -> Vec<Piece> {
    let mut pieces: Vec<Piece> = Vec::new();
    let mut jumps = run.record.jumps.iter().zip(before).peekable();
    for (i, state) in run.record.states.iter().enumerate() {
        let sample = sample(state);
        while let Some((jump, _)) = jumps.next_if(|(_, before)| **before == i) {
            let [from, to] = ends(jump, sample.stiffness_min);
            if let Some(piece) = pieces.last_mut() {
                piece.samples.push(from);
            }
            pieces.push(Piece {
                direction: jump.direction,
                pattern: jump.to,
                samples: vec![to],
            });
        }
        let last = pieces.last_mut();
        let on = |piece: &&mut Piece| {
            (piece.direction, piece.pattern) == (state.direction, state.pattern)
        };
        let begin = last
            .as_ref()
            .and_then(|piece| piece.samples.last().copied());
        match last.filter(on) {
            Some(piece) => piece.samples.push(sample),
            None => pieces.push(Piece {
                direction: state.direction,
                pattern: state.pattern,
                samples: begin.into_iter().chain([sample]).collect(),
            }),
        }
    }
    pieces
}

fn sample(state: &StateRecord) -> Sample {
    Sample {
        control: state.control,
        mean_displacement: state.mean_displacement,
        stress: state.stress,
        stiffness_min: state.stiffness_min,
    }
}

/// The states before and after a jump; the second as stiff as the next one.
fn ends(jump: &JumpRecord, next: f64) -> [Sample; 2] {
    let at = |mean_displacement: f64, stress: f64, stiffness_min: f64| Sample {
        control: jump.control,
        mean_displacement,
        stress,
        stiffness_min,
    };
    [
        at(jump.mean_displacement, jump.stress_before, 0.0),
        at(jump.mean_displacement_after, jump.stress_after, next),
    ]
}

impl LiveLoop {
    /// Adds a piece to its branch, or as a new one.
    fn take(&mut self, piece: Piece) {
        let [from, to] = [0, piece.samples.len() - 1].map(|i| piece.samples[i].control);
        let new = Segment::of(piece.pattern, piece.samples);
        let same = |known: &Segment| {
            let ([a, b], [c, d]) = (known.extent().into(), <[f64; 2]>::from(new.extent()));
            let (low, high) = (a.max(c), b.min(d));
            let [p, q] = [known, &new].map(|segment| segment.at(0.5 * (low + high)));
            let apart = p.apart([q.mean_displacement, q.stress], &self.law);
            known.pattern == new.pattern && low <= high && apart < SAME
        };
        let known = self.segments.iter().position(same);
        let segment = known.unwrap_or(self.segments.len());
        match known {
            Some(i) => {
                let samples = [std::mem::take(&mut self.segments[i].samples), new.samples];
                self.segments[i] = Segment::of(new.pattern, samples.concat());
            }
            None => self.segments.push(new),
        }
        self.legs.push(Leg {
            direction: piece.direction,
            segment,
            from,
            to,
        });
    }
}

impl Segment {
    /// Of samples in any order.
    fn of(pattern: Pattern, mut samples: Vec<Sample>) -> Self {
        samples.sort_by(|a, b| a.control.total_cmp(&b.control));
        Self {
            pattern,
            samples,
            next: [None; 2],
        }
    }
}
