//! The cohesive law that a loop on rough ground shows from far away: mean stress against mean gap
//! (Fig. 14).

mod fit;

pub use fit::{Fit, TwoExponentials, fit};

use crate::follow::record::{Direction, LoopRecord};

/// Mean stress against mean gap on both ways, at the same gaps.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeasuredLaw {
    /// One row for each mean gap, falling.
    pub rows: Vec<Row>,
}

/// What was measured at one mean gap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Mean gap u_g = u0 - mean(h) (length).
    pub gap: f64,
    /// Mean stress on approach, positive in tension (E*).
    pub approach: f64,
    /// The same on retraction.
    pub retraction: f64,
}

impl Row {
    /// The mean of both ways.
    pub fn mean(&self) -> f64 {
        0.5 * (self.approach + self.retraction)
    }
}

impl MeasuredLaw {
    /// Reads a closed loop on ground of mean height `mean_height`, at `count` equal steps of u0
    /// from its start to its turn.
    pub fn of(record: &LoopRecord, mean_height: f64, count: usize) -> Self {
        let curve = |way: Direction| {
            let states = record.states.iter().filter(|state| state.direction == way);
            let mut points: Vec<_> = states
                .map(|state| [state.mean_displacement, state.stress])
                .collect();
            points.sort_by(|a, b| a[0].total_cmp(&b[0]));
            points
        };
        let (down, up) = (curve(Direction::Approach), curve(Direction::Retraction));
        let (Some(turn), Some(start)) = (down.first(), down.last()) else {
            return Self::default();
        };
        let u0 = |i: usize| start[0] + (turn[0] - start[0]) * i as f64 / count as f64;
        let row = |u0: f64| Row {
            gap: u0 - mean_height,
            approach: between(&down, u0),
            retraction: between(&up, u0),
        };
        Self {
            rows: (0..=count).map(|i| row(u0(i))).collect(),
        }
    }

    /// Largest mean tensile stress (E*) and its mean gap (length).
    pub fn strongest(&self) -> (f64, f64) {
        let row = self
            .rows
            .iter()
            .max_by(|a, b| a.mean().total_cmp(&b.mean()));
        row.map_or((f64::NAN, f64::NAN), |row| (row.gap, row.mean()))
    }

    /// Mean gap and mean stress from the largest gap down to where the compression reaches `most`
    /// (E*).
    pub fn window(&self, most: f64) -> Vec<[f64; 2]> {
        self.rows
            .iter()
            .map(|row| [row.gap, row.mean()])
            .take_while(|[_, stress]| *stress > -most)
            .collect()
    }
}

/// The broken line through `points` of rising x.
fn between(points: &[[f64; 2]], x: f64) -> f64 {
    let i = points.partition_point(|p| p[0] < x);
    match (i.checked_sub(1).map(|i| points[i]), points.get(i)) {
        (Some(a), Some(b)) if b[0] > a[0] => a[1] + (b[1] - a[1]) * (x - a[0]) / (b[0] - a[0]),
        (_, Some(b)) => b[1],
        (Some(a), None) => a[1],
        (None, None) => f64::NAN,
    }
}
