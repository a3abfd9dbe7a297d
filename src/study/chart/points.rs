//! Which points a chart has, and what they may cost.

use super::Measured;
use crate::follow::atlas::Atlas;
use crate::numerics::precision::Precision;
use crate::physics::body::Body;
use crate::physics::control::Control;
use crate::physics::law::Law;
use crate::physics::mesh::{Grid, SAFE, is_safe, mu_rho, next_fast};
use crate::physics::parameter::Refusal;
use crate::scene::{Cell, LawChoice, Range, Scene, Strategy, Turn};
use crate::solver::methods::MethodKind;
use crate::study::plan::plan;
use std::collections::HashMap;
use std::fmt;

/// The share of the budget that the reference may take; by prediction it takes two thirds of it.
pub(super) const REFERENCE: f64 = 0.6;
/// The share of the budget that one loop may take.
pub(super) const SHARE: f64 = 0.3;
/// Processor seconds of one transform of N points with all that belongs to it, over N log2 N;
/// learnt anew from every loop.
const SECONDS: f64 = 1e-9;

/// One way to compute the loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// The relaxation method.
    pub method: MethodKind,
    /// How the loop is computed; where it is read off an atlas (flat ground, square cells) the step
    /// is that of the states read off.
    pub model: Strategy,
    /// True for a line cell.
    pub line: bool,
    /// Points along a side.
    pub points: usize,
    /// Of which numbers.
    pub precision: Precision,
    /// Largest step of u0 (length).
    pub step: f64,
}

impl Point {
    /// The name of its strategy on the screen: its method, or the atlas.
    pub fn strategy(&self) -> &'static str {
        if self.model == Strategy::Atlas {
            "atlas of branches"
        } else {
            self.method.title()
        }
    }

    /// The word of tables for what is solved.
    pub fn model_word(&self) -> &'static str {
        match self.model {
            Strategy::Walk(part) if self.line => part.of_line().word(),
            model => model.word(),
        }
    }
}

impl fmt::Display for Point {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}, {}, n = {}, {}, step {}",
            self.method.word(),
            self.model_word(),
            self.points,
            self.precision.word(),
            self.step
        )
    }
}

/// The longer step of the reference's third loop over that of the first: no small ratio, so that it
/// meets the jumps from elsewhere.
pub(super) const LONGER: f64 = 1.7;

/// How much trouble to take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Effort {
    /// Every method on several meshes and steps, within this many processor seconds.
    Full {
        /// The budget.
        seconds: f64,
    },
    /// Every method once or twice, on coarse meshes with long steps.
    Quick,
}

impl Effort {
    /// The budget in processor seconds.
    pub fn seconds(self) -> f64 {
        match self {
            Effort::Full { seconds } => seconds,
            Effort::Quick => 30.0,
        }
    }
}

/// The scene with its range as a length: it must not change with the mesh.
pub(super) fn with_fixed_law(scene: &Scene) -> Result<Scene, Refusal> {
    let model = scene.model()?;
    let points = scene.cell.points.resized(model.grid.nx);
    let law = LawChoice {
        range: Range::Length(model.law.range),
        ..scene.law
    };
    Ok(Scene {
        cell: Cell {
            points,
            ..scene.cell
        },
        law,
        ..scene.clone()
    })
}

/// The points of a chart, cheapest first, and the loops of its reference: with a finer mesh and
/// half the step of any point; the same on the finest mesh of the points; and with a longer step.
///
/// # Errors
/// The first value of the scene that is not allowed.
pub fn points(scene: &Scene, effort: Effort) -> Result<(Vec<Point>, [Point; 3]), Refusal> {
    let predictor = Predictor::new(scene)?;
    let grid = scene.model()?.grid;
    let (meshes, step) = affordable(scene, effort, &grid, &predictor);
    let most = most(&meshes, &grid);
    let mut list = Vec::new();
    for method in MethodKind::ALL {
        // The paper's method costs ten times as much and gains nothing from a finer mesh.
        let from = if method == MethodKind::Gfmd {
            meshes.len().saturating_sub(2)
        } else {
            0
        };
        list.extend(
            meshes[from..]
                .iter()
                .map(|&n| double(&grid, method, n, step)),
        );
        if matches!(effort, Effort::Full { .. }) {
            list.extend([2.0, 4.0, 8.0].map(|longer| double(&grid, method, most, longer * step)));
        }
    }
    list.extend(other_numbers(&grid, &meshes, step));
    let quarters = quarters(scene, &list);
    list.extend(quarters);
    list.extend(atlases(scene, &grid, &meshes, step));
    list.sort_by(|a, b| predictor.seconds(a).total_cmp(&predictor.seconds(b)));
    let finest = finest(scene, effort, &predictor, most, step);
    Ok((list, finest))
}

/// A point of double precision on the whole cell.
fn double(grid: &Grid, method: MethodKind, points: usize, step: f64) -> Point {
    Point {
        method,
        model: Strategy::WHOLE,
        line: grid.is_line(),
        points,
        precision: Precision::Double,
        step,
    }
}

/// How the reference is computed.
#[derive(Clone, Copy, PartialEq)]
enum Source {
    /// Off the atlas: its jumps are located directly, and the mesh is all that is left of its error.
    Atlas,
    /// Along the branches of a diagram, likewise, on so many times the points of the finest mesh.
    Branches(f64),
    /// By the walk, which locates its jumps to 1e-5 ranges.
    Walk,
}

/// Meshes of branches, over the finest of the points: where mu_rho = 0.5 on that, the error of the
/// loss of a tip falls below 1e-7 on the finer.
const FINER: [f64; 2] = [2.5, 2.0];
/// The mesh that tells how good such a one is, over it.
const COARSER: f64 = 0.8;
/// What a branch costs in increments of a walk on the whole cell.
const OF_BRANCHES: f64 = 120.0;

/// The loops of the reference of points on up to `most` points a side, with steps of `step`.
fn finest(
    scene: &Scene,
    effort: Effort,
    predictor: &Predictor,
    most: usize,
    step: f64,
) -> [Point; 3] {
    let source = source(scene, effort, predictor, most, step);
    reference(source, &predictor.grid, most, step)
}

fn source(scene: &Scene, effort: Effort, predictor: &Predictor, most: usize, step: f64) -> Source {
    if Atlas::refusal(scene).is_none() {
        return Source::Atlas;
    }
    // Of other ground there are many branches; with a law that is not smooth, or where the mesh
    // traps edges, many folds.
    let few = predictor.grid.is_line() || scene.indenter.ground().has_one_crest();
    let clean = predictor.law.is_smooth() && is_safe(predictor.mu_rho(most));
    let driven = scene.control() == Control::Displacement && scene.body == Body::HalfSpace;
    let sources = FINER.map(Source::Branches).into_iter();
    let found = sources.filter(|_| few && clean && driven).find(|source| {
        let loops = reference(*source, &predictor.grid, most, step);
        predictor.of_reference(&loops) < REFERENCE / 1.5 * effort.seconds()
    });
    found.unwrap_or(Source::Walk)
}

fn reference(source: Source, grid: &Grid, most: usize, step: f64) -> [Point; 3] {
    let finer = |share: f64| next_fast((share * most as f64 + 1.0).ceil() as usize);
    let (model, meshes) = match source {
        Source::Atlas => (Strategy::Atlas, [1.5, 1.25].map(finer)),
        Source::Branches(share) => (Strategy::Atlas, [1.0, COARSER].map(|s| finer(s * share))),
        Source::Walk => (Strategy::WHOLE, [finer(1.2), most]),
    };
    let step = step / 2.0;
    let mut loops = [
        (meshes[0], step),
        (meshes[1], step),
        (meshes[0], LONGER * step),
    ];
    if let Source::Branches(_) = source {
        // Where a jump is does not depend on the step: one loop tells of both.
        loops[1] = (meshes[1], LONGER * step);
        loops[2] = loops[1];
    }
    loops.map(|(n, step)| Point {
        model,
        ..double(grid, MethodKind::NewtonKrylov, n, step)
    })
}

/// The same by the walk, where no atlas is.
pub(super) fn walked(
    scene: &Scene,
    list: &[Point],
    finest: &[Point; 3],
) -> Result<[Point; 3], Refusal> {
    let grid = scene.model()?.grid;
    if Atlas::refusal(scene).is_none() {
        return Ok(*finest);
    }
    let most = list.iter().map(|point| point.points).max();
    let most = most.unwrap_or(grid.nx);
    Ok(reference(Source::Walk, &grid, most, 2.0 * finest[0].step))
}

/// The loop that tells along which branches a reference goes: the second of a walked one as
/// `tackscope run` would do it.
pub(super) fn coarse(scene: &Scene, walked: &Point) -> Result<Point, Refusal> {
    let [planned, _] = own(scene)?;
    Ok(Point {
        model: planned.model,
        step: 2.0 * walked.step,
        ..*walked
    })
}

/// Points along a side of the finest mesh.
fn most(meshes: &[usize], grid: &Grid) -> usize {
    meshes.last().copied().unwrap_or(grid.nx)
}

/// The meshes by growing points, and the step, whose reference is within the budget.
fn affordable(
    scene: &Scene,
    effort: Effort,
    grid: &Grid,
    predictor: &Predictor,
) -> (Vec<usize>, f64) {
    let mesh = |share: f64| {
        if share < 1.0 {
            next_fast((share * grid.nx as f64).ceil().max(16.0) as usize)
        } else {
            grid.nx
        }
    };
    let (mut meshes, mut step) = match effort {
        Effort::Full { .. } => (
            vec![mesh(0.375), mesh(0.5), mesh(0.75), mesh(1.0)],
            scene.drive.step,
        ),
        Effort::Quick => (vec![mesh(0.75), mesh(1.0)], 4.0 * scene.drive.step),
    };
    meshes.dedup();
    // Where even the reference is beyond the means the finest mesh goes, unless the next one traps
    // patterns; then steps get longer.
    let safe = |n: usize| predictor.mu_rho(n) <= SAFE;
    let dear = |meshes: &[usize], step: f64| {
        let loops = finest(scene, effort, predictor, most(meshes, grid), step);
        predictor.of_reference(&loops) > REFERENCE / 1.5 * effort.seconds()
    };
    while dear(&meshes, step) {
        match meshes.len() {
            2.. if safe(meshes[meshes.len() - 2]) || step > 8.0 * scene.drive.step => {
                meshes.pop();
            }
            _ if step <= 8.0 * scene.drive.step => step *= 2.0,
            _ => break,
        }
    }
    (meshes, step)
}

/// Points of other numbers, for the quickest method on the finer meshes.
fn other_numbers(grid: &Grid, meshes: &[usize], step: f64) -> Vec<Point> {
    let finer = &meshes[meshes.len().saturating_sub(2)..];
    let of = |precision| {
        finer.iter().map(move |&n| Point {
            precision,
            ..double(grid, MethodKind::NewtonKrylov, n, step)
        })
    };
    [Precision::Mixed, Precision::Single]
        .into_iter()
        .flat_map(of)
        .collect()
}

/// The same on a quarter of the cell, for the methods that gain most from it.
fn quarters(scene: &Scene, list: &[Point]) -> Vec<Point> {
    let reducible = |p: &&Point| {
        scene.indenter.ground().is_even()
            && p.precision == Precision::Double
            && p.points.is_multiple_of(4)
            && matches!(p.method, MethodKind::NewtonKrylov | MethodKind::Lbfgs)
    };
    list.iter()
        .filter(reducible)
        .map(|p| Point {
            model: Strategy::QUARTER,
            ..*p
        })
        .collect()
}

/// The same read off an atlas, where there is one, and on a mesh between those and the reference's.
fn atlases(scene: &Scene, grid: &Grid, meshes: &[usize], step: f64) -> Vec<Point> {
    if Atlas::refusal(scene).is_some() {
        return Vec::new();
    }
    let between = next_fast(9 * most(meshes, grid) / 8);
    let meshes = meshes.iter().copied().chain([between]);
    meshes
        .filter(|n| n.is_multiple_of(8))
        .map(|n| Point {
            model: Strategy::Atlas,
            ..double(grid, MethodKind::NewtonKrylov, n, step)
        })
        .collect()
}

/// What `tackscope run` would do, and the paper's 50 + 150 time steps per increment: both with the
/// scene's own step on its own mesh.
pub(super) fn own(scene: &Scene) -> Result<[Point; 2], Refusal> {
    let decided = scene.model()?;
    let (line, points, step) = (decided.grid.is_line(), decided.grid.nx, scene.drive.step);
    let own = |method, model| Point {
        method,
        model,
        line,
        points,
        precision: Precision::Double,
        step,
    };
    let planned = plan(scene, &decided, None).strategy;
    Ok([
        own(MethodKind::default(), planned),
        own(MethodKind::Gfmd, Strategy::WHOLE),
    ])
}

/// What the correction of a prediction depends on.
fn key(point: &Point) -> (MethodKind, Strategy, Precision) {
    (point.method, point.model, point.precision)
}

/// Predicts processor time: typical transforms per increment, corrected by what the method needed
/// last.
#[derive(Clone, Debug)]
pub(super) struct Predictor {
    /// Length of the loop in u0.
    way: f64,
    law: Law,
    grid: Grid,
    /// True if there is an atlas.
    atlas: bool,
    /// Measured over predicted, by what it depends on but the mesh and the step.
    correction: HashMap<(MethodKind, Strategy, Precision), f64>,
}

impl Predictor {
    pub(super) fn new(scene: &Scene) -> Result<Self, Refusal> {
        let model = scene.model()?;
        let depth = match scene.drive.turn {
            Turn::At(turn) => scene.drive.start - turn,
            // A tip is drawn in by about as much as it is lifted.
            Turn::ZeroLoad => 1.5 * scene.drive.start.abs(),
        };
        Ok(Self {
            way: 2.0 * depth,
            law: model.law,
            grid: model.grid,
            atlas: Atlas::refusal(scene).is_none(),
            correction: HashMap::new(),
        })
    }

    fn mu_rho(&self, points: usize) -> f64 {
        mu_rho(&self.law, self.grid.length / points as f64)
    }

    /// Processor seconds of a loop.
    pub(super) fn seconds(&self, point: &Point) -> f64 {
        self.typical(point) * self.correction.get(&key(point)).unwrap_or(&1.0)
    }

    /// Processor seconds of a loop of the reference, whose states are solved where there is an atlas.
    pub(super) fn of_reference_loop(&self, point: &Point) -> f64 {
        let (model, step) = match point.model {
            Strategy::Atlas if self.atlas => (Strategy::QUARTER, point.step),
            Strategy::Atlas => (Strategy::WHOLE, self.way / OF_BRANCHES),
            walk => (walk, point.step),
        };
        self.seconds(&Point {
            model,
            step,
            ..*point
        })
    }

    /// The same of three, of which two may be one.
    pub(super) fn of_reference(&self, loops: &[Point; 3]) -> f64 {
        let mut loops = loops.to_vec();
        loops.dedup();
        loops
            .iter()
            .map(|point| self.of_reference_loop(point))
            .sum()
    }

    pub(super) fn learn(&mut self, measured: &Measured) {
        let ratio = measured.processor_seconds / self.typical(&measured.point);
        if ratio.is_finite() && ratio > 0.0 && measured.is_complete() {
            // The cheapest so far: a coarse mesh that traps patterns says nothing about a finer
            // one.
            let known = self.correction.entry(key(&measured.point)).or_insert(ratio);
            *known = known.min(ratio);
        }
    }

    fn typical(&self, point: &Point) -> f64 {
        let per_increment = point.method.transforms();
        let n = point.points as f64;
        let all = if point.line { n } else { n * n };
        let (all, way) = match point.model {
            // A quarter of the points; what watches over the rest costs about as much again.
            Strategy::Walk(part) if part.is_even() => (all / 2.0, self.way),
            Strategy::Walk(_) => (all, self.way),
            // As many equilibria whatever the step.
            Strategy::Atlas => (all / 4.0, 40.0 * point.step),
        };
        // Many small jumps, each a release.
        let trapped = if self.mu_rho(point.points) > SAFE && point.method.build(0).locates() {
            8.0
        } else {
            1.0
        };
        SECONDS * trapped * per_increment * (way / point.step) * all * all.log2()
    }
}
