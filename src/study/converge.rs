//! How a number of a loop converges with the mesh: the same scene on a ladder of meshes, the order
//! that is observed, the limit after Richardson, and an error bar.
//!
//! Spectral meshes converge faster than any power of the spacing: the observed order then grows
//! along the ladder, and the limit that the last order gives is farther from the finest value than
//! the truth is. The error bar is on the safe side.

use super::sweep::{Column, Row, Study, column, grid};
use crate::follow::record::LOCATED;
use crate::physics::mesh_rule::next_fast;
use crate::physics::parameter::Refusal;
use crate::scene::{Scene, parameter};

/// Meshes of a ladder, as shares of the scene's own number of points: two coarser and two finer ones,
/// each with 1.4 times the points of the one before.
const RUNGS: [f64; 5] = [0.5, 0.707, 1.0, 1.414, 2.0];
/// The quarter of a cell needs a multiple of so many points.
const MULTIPLE: usize = 4;
/// The difference to the limit is stated so many times larger, as is usual for grids of three sizes
/// (Roache 1998, grid convergence index).
const SAFETY: f64 = 1.25;
/// Orders between which the observed one is looked for.
const ORDERS: [f64; 2] = [0.05, 60.0];

/// The loss, how well it is located, and the jumps.
const LOSS: &str = "dissipated_energy";
const OF_LOSS: &str = "released_energy_error";
const JUMPS: [&str; 2] = ["approach_jumps", "retraction_jumps"];

/// The study of a scene on a ladder of meshes around its own.
///
/// # Errors
/// A scene that is not allowed.
pub fn ladder(scene: &Scene) -> Result<Study, Refusal> {
    let n = scene.model()?.grid.nx as f64;
    let rung = |share: &f64| {
        let mut points = next_fast((share * n).round() as usize).max(2 * MULTIPLE);
        while !points.is_multiple_of(MULTIPLE) {
            points = next_fast(points + 1);
        }
        points as f64
    };
    let mut meshes: Vec<f64> = RUNGS.iter().map(rung).collect();
    meshes.dedup();
    let record = [LOSS, OF_LOSS, JUMPS[0], JUMPS[1], "seconds"];
    Ok(Study {
        title: format!("{}: convergence", scene.title),
        scene: scene.clone(),
        keys: vec![parameter::POINTS.key.to_owned()],
        places: grid(&[meshes]),
        record: record.into_iter().filter_map(column).collect(),
        plot: [parameter::POINTS.key.to_owned(), LOSS.to_owned()],
    })
}

/// A number on the meshes of a ladder.
#[derive(Clone, Debug, PartialEq)]
pub struct Convergence {
    /// What it is: a column, and of the jumps of a direction which one, from 1.
    pub quantity: String,
    /// Points along a side and the value there, from coarse to fine.
    pub values: Vec<[f64; 2]>,
    /// Where it goes.
    pub estimate: Estimate,
}

/// Where a number goes as the mesh is refined.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The exponent of the spacing with which the error falls on the finest three meshes whose
    /// differences are to be seen; `None` where these do not fall, or there are fewer.
    pub order: Option<f64>,
    /// The value on an infinitely fine mesh; the finest value where there is no order.
    pub limit: f64,
    /// How far the limit may be off; NaN of a single mesh.
    pub error_bar: f64,
}

/// The limit of values on meshes of so many points, from coarse to fine, each of which may be off by
/// `located` for other reasons than the mesh.
pub fn estimate(values: &[[f64; 2]], located: f64) -> Estimate {
    let finest = values.last().map_or(f64::NAN, |[_, value]| *value);
    let without = |order, off: f64| Estimate {
        order,
        limit: finest,
        error_bar: SAFETY * off + located,
    };
    let steps: Vec<f64> = values
        .windows(2)
        .map(|pair| pair[1][1] - pair[0][1])
        .collect();
    let [.., before, after] = steps[..] else {
        return without(None, steps.first().map_or(f64::NAN, |step| step.abs()));
    };
    // The finest meshes whose differences are to be seen.
    let seen = steps.windows(2).rposition(|pair| pair[1].abs() > located);
    let order = seen.and_then(|k| order(&values[k..k + 3]));
    let off = match order {
        // What is left of the mesh is not to be seen.
        _ if after.abs() <= located => return without(order, after.abs()),
        None => return without(None, before.abs().max(after.abs())),
        // From both sides: the limit is between the last two.
        Some(_) if before * after < 0.0 => return without(order, after.abs()),
        Some(order) => {
            let [.., [coarser, _], [finer, _]] = *values else {
                return without(None, f64::NAN);
            };
            after / ((finer / coarser).powf(order) - 1.0)
        }
    };
    Estimate {
        order,
        limit: finest + off,
        error_bar: SAFETY * off.abs() + located,
    }
}

/// The exponent of the spacing with which the differences of three values fall; `None` if they do
/// not.
fn order(values: &[[f64; 2]]) -> Option<f64> {
    let [[a, coarse], [b, middle], [c, fine]] = *values else {
        return None;
    };
    // Of errors that go as n^-p the differences have this ratio, which grows with p.
    let ratio = |p: f64| (a.powf(-p) - b.powf(-p)) / (b.powf(-p) - c.powf(-p));
    let seen = ((middle - coarse) / (fine - middle)).abs();
    let [mut low, mut high] = ORDERS;
    if !(seen > ratio(low)) {
        return None;
    }
    for _ in 0..60 {
        let order = 0.5 * (low + high);
        if ratio(order) < seen {
            low = order;
        } else {
            high = order;
        }
    }
    Some(low)
}

/// Every number of the rows of a ladder. Jumps are compared one by one where the finest meshes have
/// equally many; coarser ones that have others are left out, and said by having fewer values.
pub fn convergences(study: &Study, rows: &[Row]) -> Vec<Convergence> {
    let mut rows: Vec<&Row> = rows.iter().filter(|row| row.is_complete()).collect();
    rows.sort_by(|a, b| a.values[0].total_cmp(&b.values[0]));
    let (Some(finest), Ok(model)) = (rows.last(), study.scene.model()) else {
        return Vec::new();
    };
    let number = |name: &str| study.numbers(finest, name).first().copied();
    let of_loss = number(OF_LOSS).unwrap_or(0.0);
    let mut all = Vec::new();
    let wanted = |column: &Column| column.name == LOSS || JUMPS.contains(&column.name);
    for column in study.record.iter().filter(|column| wanted(column)) {
        let count = study.numbers(finest, column.name).len();
        for jump in 0..count {
            let values = rows.iter().rev().map_while(|row| {
                let numbers = study.numbers(row, column.name);
                (numbers.len() == count).then(|| [row.values[0], numbers[jump]])
            });
            let mut values: Vec<[f64; 2]> = values.collect();
            values.reverse();
            let (quantity, located) = match column.name {
                LOSS => (LOSS.to_owned(), of_loss),
                jumps => (format!("{jumps} {}", jump + 1), LOCATED * model.law.range),
            };
            all.push(Convergence {
                quantity,
                estimate: estimate(&values, located),
                values,
            });
        }
    }
    all
}

impl std::fmt::Display for Convergence {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Estimate {
            order,
            limit,
            error_bar,
        } = self.estimate;
        write!(f, "{}: {limit:.12}, +- {error_bar:.1e}", self.quantity)?;
        let meshes: Vec<String> = self.values.iter().map(|[n, _]| n.to_string()).collect();
        write!(f, " (n = {}; ", meshes.join(", "))?;
        match order {
            Some(order) => write!(f, "order {order:.1})"),
            None => f.write_str("no order)"),
        }
    }
}
