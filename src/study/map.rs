//! What a loop does while one of its numbers goes. The map of patterns: where every jump of a scene's
//! loop lies while one parameter goes, and what the loop loses. And how a number of a loop converges
//! with the mesh: the same scene on a ladder of meshes, the order that is observed, the limit after
//! Richardson, and an error bar.
//!
//! Of a map a few values come first, the others between them. On flat ground the atlas is carried from
//! value to value: a loop that is little different from the last is read off in milliseconds. Where
//! there is no atlas the loop is walked.
//!
//! Spectral meshes converge faster than any power of the spacing: the observed order then grows
//! along the ladder, and the limit that the last order gives is farther from the finest value than
//! the truth is. The error bar is on the safe side.

use super::live_loop::{Fineness, LiveLoop, LiveLoops};
use super::plan::{enclose, plan};
use super::sweep::{self, Column, Spacing, Span, Study, column, grid};
use crate::follow::atlas::Atlas;
use crate::follow::record::{Direction, JumpRecord, LOCATED};
use crate::follow::run::{LoopRun, run_loop};
use crate::follow::walk::WalkOptions;
use crate::numerics::threads::{Cancel, side_by_side};
use crate::physics::indenter::Indenter;
use crate::physics::law::Law;
use crate::physics::mesh::next_fast;
use crate::physics::parameter::Refusal;
use crate::physics::pattern::Pattern;
use crate::scene::{Model, Part, Scene, Strategy, Turn, edit, parameter};
use std::cmp::Reverse;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// From this ratio of its ends on a parameter goes by equal factors.
const DECADE: f64 = 2.0;
/// Step of a walk in place of an atlas, in ranges, at least.
const STEP: f64 = 0.1;
/// Rows that are computed by themselves in any case lie so far apart.
const APART: usize = 8;

/// A parameter of the scene file and the values between which it goes.
#[derive(Clone, Debug, PartialEq)]
pub struct Vary {
    /// Dotted key, as in `law.range`.
    pub key: String,
    /// The first value.
    pub from: f64,
    /// The last value.
    pub to: f64,
}

impl Vary {
    /// True if its values are equal factors apart.
    pub fn is_geometric(&self) -> bool {
        let ratio = self.to / self.from;
        self.from > 0.0 && self.to > 0.0 && ratio.max(1.0 / ratio) >= DECADE
    }

    /// So many values from end to end.
    pub fn values(&self, count: usize) -> Vec<f64> {
        let spacing = if self.is_geometric() {
            Spacing::Logarithmic
        } else {
            Spacing::Linear
        };
        let (from, to) = (self.from, self.to);
        Span { from, to, spacing }.values(count)
    }
}

impl std::str::FromStr for Vary {
    type Err = String;

    /// As in `law.range=0.5..2`.
    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('=').and_then(|(key, ends)| {
            let (from, to) = ends.split_once("..")?;
            let number = |text: &str| text.trim().parse::<f64>().ok().filter(|x| x.is_finite());
            Some((key.trim(), number(from)?, number(to)?))
        });
        match parts {
            Some((key, from, to)) if from != to => Ok(Self {
                key: key.to_owned(),
                from,
                to,
            }),
            _ => Err(format!(
                "\"{text}\" is not KEY=A..B with two different numbers, as in law.range=0.5..2"
            )),
        }
    }
}

/// The map: one row a value, in their order.
#[derive(Clone, Debug)]
pub struct PatternMap {
    /// What goes.
    pub vary: Vary,
    /// The rows.
    pub rows: Vec<Row>,
    /// True if somebody asked to stop: what was found until then stands.
    pub cancelled: bool,
}

/// The loop of one value.
#[derive(Clone, Debug)]
pub struct Row {
    /// The value.
    pub value: f64,
    /// The law, which scales lengths and stresses.
    pub law: Option<Law>,
    /// What the loop does, or why it is not known.
    pub found: Result<Found, String>,
}

/// What a loop does.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// Its pieces in order.
    pub legs: Vec<Leg>,
    /// Its jumps in order.
    pub jumps: Vec<JumpRecord>,
    /// The patterns it visits and u0 between which each is stable (length); none of a walk.
    pub extents: Vec<(Pattern, [f64; 2])>,
    /// What it loses (gamma per area).
    pub dissipated_energy: f64,
}

/// A piece of a loop in one direction, along which the pattern stays.
#[derive(Clone, Debug, PartialEq)]
pub struct Leg {
    /// Direction of the drive.
    pub direction: Direction,
    /// The pattern.
    pub pattern: Pattern,
    /// u0 (length) and mean stress (E*) in the order in which they are passed.
    pub points: Vec<[f64; 2]>,
}

impl Leg {
    /// u0 where it begins and ends (length).
    pub fn ends(&self) -> [f64; 2] {
        let u0 = |point: Option<&[f64; 2]>| point.map_or(f64::NAN, |[u0, _]| *u0);
        [u0(self.points.first()), u0(self.points.last())]
    }
}

impl PatternMap {
    /// The map of `scene` on so many values; `observe` is told of each row, of the first ones far
    /// apart.
    ///
    /// # Errors
    /// A key that is no number of this scene. Values that are not allowed are rows that say so.
    pub fn of(
        scene: &Scene,
        vary: &Vary,
        count: usize,
        cancel: &Cancel,
        observe: &mut Observer<'_>,
    ) -> Result<Self, Refusal> {
        let model = scene.model()?;
        edit::check_key(scene, &vary.key)?;
        let values = vary.values(count);
        let rows = vec![None; values.len()];
        let survey = Survey {
            scene,
            model,
            key: &vary.key,
            values,
            cancel,
            known: Mutex::new(Known { rows, observe }),
        };
        survey.all();
        let rows = std::mem::take(&mut survey.known().rows);
        Ok(Self {
            vary: vary.clone(),
            rows: rows.into_iter().flatten().collect(),
            cancelled: cancel.requested(),
        })
    }

    /// Takes in a row, in place of the one that was there.
    pub fn insert(&mut self, row: Row) {
        let before =
            |other: &Row| (other.value - row.value) * (self.vary.to - self.vary.from) < 0.0;
        let i = self.rows.partition_point(before);
        match self
            .rows
            .get_mut(i)
            .filter(|there| there.value == row.value)
        {
            Some(there) => *there = row,
            None => self.rows.insert(i, row),
        }
    }

    /// The row whose value is nearest to this one.
    pub fn nearest(&self, value: f64) -> Option<&Row> {
        let far = |row: &&Row| (row.value - value).abs();
        self.rows.iter().min_by(|a, b| far(a).total_cmp(&far(b)))
    }

    /// The values whose loop is not known, with the reason.
    pub fn missing(&self) -> impl Iterator<Item = (f64, &str)> {
        self.rows
            .iter()
            .filter_map(|row| Some((row.value, row.found.as_ref().err()?.as_str())))
    }
}

/// A map under way, by as many threads as there are.
struct Survey<'a> {
    scene: &'a Scene,
    model: Model,
    key: &'a str,
    values: Vec<f64>,
    cancel: &'a Cancel,
    known: Mutex<Known<'a>>,
}

/// The rows that are known, and who is told of them.
struct Known<'a> {
    rows: Vec<Option<Row>>,
    observe: &'a mut Observer<'a>,
}

/// Is told of a row and of the share that is done, 0 to 1.
pub type Observer<'a> = dyn FnMut(&Row, f64) + Send + 'a;

impl<'a> Survey<'a> {
    /// First every so many rows by themselves, from few to many. Between them the atlas is carried
    /// from row to row: a landing that is carried is not asked for again, and would be passed on
    /// for ever.
    fn all(&self) {
        let last = self.values.len() - 1;
        let rows: Vec<usize> = (0..last).step_by(APART).chain([last]).collect();
        let mut first: Vec<usize> = (0..rows.len()).collect();
        first.sort_by_key(|k| Reverse(k.trailing_zeros()));
        let learnt = side_by_side(first, |k| self.learnt(rows[k]));
        side_by_side(0..rows.len() - 1, |k| {
            self.between(rows[k], rows[k + 1], learnt[k].clone());
        });
    }

    /// The rows between two that were learnt, `loops` on the left: where these differ the middle
    /// is learnt too.
    fn between(&self, left: usize, right: usize, mut loops: LiveLoops) {
        if right - left < 2 || self.cancel.requested() {
            return;
        }
        let order = self.order(left);
        if order != self.order(right) {
            let middle = left + (right - left) / 2;
            let there = self.learnt(middle);
            self.between(left, middle, loops);
            return self.between(middle, right, there);
        }
        for i in left + 1..right {
            self.row(i, &mut loops);
            if self.order(i) != order {
                loops = self.learnt(i);
            }
        }
    }

    /// The row by itself, whatever the others are.
    fn learnt(&self, i: usize) -> LiveLoops {
        let mut loops = LiveLoops::obeying(self.cancel);
        self.row(i, &mut loops);
        loops
    }

    fn row(&self, i: usize, loops: &mut LiveLoops) {
        let value = self.values[i];
        let edited = edit::with_parameter(self.scene, &self.model, self.key, value);
        let decided = edited.and_then(|edited| Ok((edited.model()?, edited)));
        let (law, found) = match decided {
            Ok((model, edited)) => {
                let found = found(&edited, &model, loops, self.cancel);
                (Some(model.law), found)
            }
            Err(refusal) => (None, Err(refusal.to_string())),
        };
        let Known { rows, observe } = &mut *self.known();
        if self.cancel.requested() {
            return;
        }
        let row = Row { value, law, found };
        rows[i] = Some(row.clone());
        let known = rows.iter().flatten().count();
        observe(&row, known as f64 / rows.len() as f64);
    }

    fn known(&self) -> MutexGuard<'_, Known<'a>> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What the loop of a row does, one after the other; `None` where it is not known.
    fn order(&self, i: usize) -> Option<Vec<(Direction, Pattern)>> {
        let known = self.known();
        let found = known.rows[i].as_ref()?.found.as_ref().ok()?;
        let legs = found.legs.iter();
        Some(legs.map(|leg| (leg.direction, leg.pattern)).collect())
    }
}

/// Read off the atlas, or walked.
fn found(
    scene: &Scene,
    model: &Model,
    loops: &mut LiveLoops,
    cancel: &Cancel,
) -> Result<Found, String> {
    let mut wider = scene.clone();
    if model.indenter == Indenter::Flat {
        enclose(&mut wider, model);
    }
    if let Ok(live) = loops.next(&wider, model, Fineness::Coarse) {
        return Ok(read(&live));
    }
    // What has no atlas is walked as the plan would have it.
    let mut walk = wider;
    let part = match (Atlas::refusal(scene), plan(scene, model, None).strategy) {
        (Some(_), Strategy::Walk(part)) => part,
        // What an atlas finds that it does not hold, whatever the scene's own mesh is, as its
        // neighbours: on a finer one than theirs, on which an atlas has its ridges too.
        _ => {
            let points = Fineness::Fine.points(&model.law, model.grid.length);
            walk.cell.points = scene.cell.points.resized(points.next_multiple_of(4));
            walk.drive.step = scene.drive.step.max(STEP * model.law.range);
            Part::Quarter
        }
    };
    let options = WalkOptions {
        part,
        ..WalkOptions::default()
    };
    let run = run_loop(&walk, options, cancel, &mut |_| {}).map_err(|error| error.to_string())?;
    walked(&run, model, scene.drive.turn)
}

fn read(live: &LiveLoop) -> Found {
    let extent = |segment: &super::live_loop::Segment| {
        let (low, high) = segment.extent();
        (segment.pattern, [low, high])
    };
    let legs = live.legs.iter().map(|leg| Leg {
        direction: leg.direction,
        pattern: live.segments[leg.segment].pattern,
        points: live.points_of(leg),
    });
    Found {
        legs: legs.collect(),
        jumps: live.jumps.clone(),
        extents: live.segments.iter().map(extent).collect(),
        dissipated_energy: live.dissipated_energy,
    }
}

/// The pieces of a walk: states of one pattern and direction in a row.
fn walked(run: &LoopRun, model: &Model, turn: Turn) -> Result<Found, String> {
    let ledger = run.ledger(model.law.surface_energy);
    let loss = ledger.and_then(|ledger| ledger.dissipated_energy());
    let Some(dissipated_energy) = loss else {
        let to = match turn {
            Turn::At(_) => "",
            Turn::ZeroLoad => " to zero load",
        };
        return Err(format!("the loop{to} was not completed, or is not closed"));
    };
    let legs = run.record.pieces().map(|piece| Leg {
        direction: piece[0].direction,
        pattern: piece[0].pattern,
        points: piece
            .iter()
            .map(|state| [state.mean_displacement, state.stress])
            .collect(),
    });
    Ok(Found {
        legs: legs.collect(),
        jumps: run.record.jumps.clone(),
        extents: Vec::new(),
        dissipated_energy,
    })
}

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
pub fn convergences(study: &Study, rows: &[sweep::Row]) -> Vec<Convergence> {
    let mut rows: Vec<&sweep::Row> = rows.iter().filter(|row| row.is_complete()).collect();
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
