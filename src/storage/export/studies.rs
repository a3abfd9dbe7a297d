//! What studies of a scene give, as tables: the diagram and the barriers between its states, the map of
//! patterns, the convergence with the mesh, the ground; `chart.json`: what the chart of speed against
//! accuracy says in short.

use super::{cells_of, number, quoted, write_matrix, write_rows};
use crate::follow::diagram::Diagram;
use crate::physics::parameter::Dimension;
use crate::physics::system::State;
use crate::physics::topography::Statistics;
use crate::scene::Scene;
use crate::storage::summary::{Number, SceneSummary, write_json};
use crate::storage::{Failure, VERSION};
use crate::study::chart::{Chart, Judged, Verdict};
use crate::study::ground::GroundReport;
use crate::study::landscape::{Ground, Saddle};
use crate::study::map::{Convergence, PatternMap};
use serde::Serialize;
use std::path::Path;

/// First line of `map.csv`.
pub const MAP_COLUMNS: &str =
    "value,kind,branch,mean_displacement,from,to,released_energy,cause,dissipated_energy";

/// Writes a map, row by row: its jumps in order, then u0 between which each visited pattern is
/// stable (kind `end`, the lower one from nothing, the upper one to nothing); a value without a
/// loop has one line that says why (kind `missing`), one whose loop has no jump a line of kind
/// `none`. u0 in the scene's length, energies per area in units of gamma.
///
/// # Errors
/// A file that cannot be written.
pub fn write_map_csv(path: &Path, map: &PatternMap) -> Result<(), Failure> {
    let empty = || String::new();
    let lines = map.rows.iter().flat_map(|row| {
        let value = number(row.value);
        let found = match &row.found {
            Ok(found) => found,
            Err(why) => {
                let blank = std::iter::repeat_n(empty(), 5);
                let head = [value, "missing".to_owned()].into_iter().chain(blank);
                return vec![head.chain([quoted(why), empty()]).collect()];
            }
        };
        let loss = number(found.dissipated_energy);
        let jumps = found.jumps.iter().map(|jump| {
            let head = [value.clone(), "jump".to_owned()].into_iter();
            head.chain(cells_of(jump)).chain([loss.clone()]).collect()
        });
        let end = |u0: f64, [from, to]: [String; 2]| {
            let head = [
                value.clone(),
                "end".to_owned(),
                empty(),
                number(u0),
                from,
                to,
            ];
            head.into_iter()
                .chain([empty(), empty(), loss.clone()])
                .collect()
        };
        let ends = found.extents.iter().flat_map(|(pattern, [low, high])| {
            let word = || pattern.to_string();
            [end(*low, [empty(), word()]), end(*high, [word(), empty()])]
        });
        let mut lines: Vec<Vec<String>> = jumps.chain(ends).collect();
        if found.jumps.is_empty() {
            let blank = std::iter::repeat_n(empty(), 6);
            let head = [value, "none".to_owned()].into_iter().chain(blank);
            lines.push(head.chain([loss]).collect());
        }
        lines
    });
    write_rows(path, MAP_COLUMNS, lines)
}

/// First line of `convergence.csv`.
const CONVERGENCE_COLUMNS: &str = "quantity,points,value,order,limit,error_bar";

/// Writes each number on each mesh, from coarse to fine, with the order that the last three meshes
/// show (`NaN` where they show none), the limit, and how far that may be off.
///
/// # Errors
/// A file that cannot be written.
pub fn write_convergence_csv(path: &Path, all: &[Convergence]) -> Result<(), Failure> {
    let rows = all.iter().flat_map(|one| {
        let estimate = one.estimate;
        let order = estimate.order.unwrap_or(f64::NAN);
        one.values.iter().map(move |[points, value]| {
            let numbers = [*value, order, estimate.limit, estimate.error_bar].map(number);
            let head = [one.quantity.clone(), points.to_string()];
            head.into_iter().chain(numbers).collect()
        })
    });
    write_rows(path, CONVERGENCE_COLUMNS, rows)
}

/// First line of `branches.csv`.
const BRANCH_COLUMNS: &str =
    "branch,point,mean_displacement,stress,energy,index,pattern,kind,residual,control";

/// First line of `points.csv`.
const POINT_COLUMNS: &str =
    "kind,branch,mean_displacement,stress,energy,index_before,index_after,control";

/// Writes every point of every branch in order along it: u0 in the scene's length, stress in E*,
/// energy per area of body and cohesion in E* times length. `index` is the number of negative
/// eigenvalues over all modes of the whole cell, and u0 where it is free, sliding ones left out; at
/// a fold or bifurcation the mode without stiffness is not counted.
///
/// # Errors
/// A file that cannot be written.
pub fn write_branches_csv(path: &Path, diagram: &Diagram, scene: &Scene) -> Result<(), Failure> {
    let given = |of, value| number(scene.number_given(of, value));
    let rows = diagram.branches.iter().flat_map(|branch| {
        branch.points.iter().enumerate().map(|(i, point)| {
            let State {
                mean_displacement,
                stress,
                control,
                ..
            } = point.state;
            vec![
                branch.name.clone(),
                i.to_string(),
                number(mean_displacement),
                given(Dimension::Stress, stress),
                given(
                    Dimension::SurfaceEnergy,
                    point.state.body_energy(diagram.control),
                ),
                point.index[0].min(point.index[1]).to_string(),
                point.pattern.to_string(),
                point.kind.to_string(),
                number(point.residual),
                given(Dimension::Driven, control),
            ]
        })
    });
    write_rows(path, BRANCH_COLUMNS, rows)
}

/// Writes folds and bifurcations in order along their branches, then equal energies: `branch` is
/// then the names of both, with a slash between them, and the numbers those of the first. Energies
/// are those of body and cohesion.
///
/// # Errors
/// A file that cannot be written.
pub fn write_points_csv(path: &Path, diagram: &Diagram, scene: &Scene) -> Result<(), Failure> {
    let given = |of, value| number(scene.number_given(of, value));
    // u0, stress, energy with that of the machine, and control.
    let row = |kind: &str, branch: &str, [u0, stress, energy, control]: [f64; 4], index| {
        let body = energy - diagram.control.energy(control, u0);
        let mut cells = [kind, branch].map(str::to_owned).to_vec();
        cells.extend([
            number(u0),
            given(Dimension::Stress, stress),
            given(Dimension::SurfaceEnergy, body),
        ]);
        cells.extend(<[usize; 2]>::map(index, |count| count.to_string()));
        cells.push(given(Dimension::Driven, control));
        cells
    };
    let events = diagram.events().map(|(branch, point)| {
        let State {
            mean_displacement,
            stress,
            energy,
            control,
            ..
        } = point.state;
        let numbers = [mean_displacement, stress, energy, control];
        row(&point.kind.to_string(), &branch.name, numbers, point.index)
    });
    let equal = diagram.equal_energies.iter().map(|equal| {
        let [u0, stress] = [equal.mean_displacements[0], equal.stresses[0]];
        let numbers = [u0, stress, equal.energy, equal.control];
        row("equal_energy", &equal.branches.join("/"), numbers, [0, 0])
    });
    write_rows(path, POINT_COLUMNS, events.chain(equal))
}

/// First line of `barriers.csv`.
pub const BARRIER_COLUMNS: &str =
    "control,mean_displacement,saddle,stress,from,barrier,to,released_energy";

/// What a scene with units adds to it: the barrier of a square cell in kT.
const BARRIER_COLUMN_OF_UNITS: &str = ",barrier_kt";

/// Writes two lines a saddle, one for each way over it: what is driven and the saddle's own u0 (in
/// the scene's length), the name of its branch and its stress (E*), the pattern that is left and
/// the barrier from there, the pattern beyond and what is released by going there; energies per
/// area in units of gamma, of a cell in gamma L^2; of a scene with units also in kT (NaN of a line
/// cell, which has no depth).
///
/// # Errors
/// A file that cannot be written.
pub fn write_barriers_csv(
    path: &Path,
    ground: Ground<'_>,
    saddles: &[(f64, Saddle)],
) -> Result<(), Failure> {
    let given = |of, value| number(ground.scene.number_given(of, value));
    let gamma = ground.model.law.surface_energy;
    let rows = saddles.iter().flat_map(|(control, saddle)| {
        let ends = saddle.sides.each_ref().map(|side| &side[side.len() - 1]);
        [[0, 1], [1, 0]].map(|ways| {
            let [from, to] = ways.map(|side| ends[side]);
            let [barrier, released] = [saddle.place.energy - from.energy, from.energy - to.energy];
            let mut cells = vec![
                given(Dimension::Driven, *control),
                number(saddle.place.mean_displacement),
                saddle.branch.clone(),
                given(Dimension::Stress, saddle.place.stress),
                ground.pattern(from, *control).to_string(),
                number(barrier / gamma),
                ground.pattern(to, *control).to_string(),
                number(released / gamma),
            ];
            let kt = |_| number(ground.model.in_kt(barrier).unwrap_or(f64::NAN));
            cells.extend(ground.model.units.map(kt));
            cells
        })
    });
    let more = ground.model.units.map_or("", |_| BARRIER_COLUMN_OF_UNITS);
    write_rows(path, &format!("{BARRIER_COLUMNS}{more}"), rows)
}

/// First line of `spectrum.csv`.
pub const SPECTRUM_COLUMNS: &str = "wave_number,power";

/// `ground.json`.
#[derive(Serialize)]
struct Told<'a> {
    /// Root mean squares of the ground on the mesh, which is periodic.
    mesh: Numbers,
    /// The file, if the ground was measured.
    file: Option<File<'a>>,
    /// Wave numbers (1/length) that cut the spectrum off.
    cutoffs: serde_json::Map<String, serde_json::Value>,
    /// Of lengths, where it is known.
    unit: Option<&'static str>,
    warnings: &'a [String],
}

/// Named as SurfaceTopography's.
#[derive(Serialize)]
struct Numbers {
    rms_height_from_area: Number,
    rms_gradient: Number,
    rms_laplacian: Number,
    rms_curvature_from_area: Number,
    span: Number,
}

#[derive(Serialize)]
struct File<'a> {
    path: &'a str,
    format: &'static str,
    points: [usize; 2],
    side: f64,
    filled_points: usize,
    points_outside_the_square: usize,
    /// Before it was made periodic.
    before: Numbers,
    /// One period.
    after: Numbers,
}

impl Numbers {
    fn of(statistics: &Statistics) -> Self {
        Self {
            rms_height_from_area: Number(statistics.height),
            rms_gradient: Number(statistics.gradient),
            rms_laplacian: Number(statistics.laplacian),
            rms_curvature_from_area: Number(0.5 * statistics.laplacian),
            span: Number(statistics.span),
        }
    }
}

/// Writes the numbers as JSON.
///
/// # Errors
/// A file that cannot be written.
pub fn write_ground_json(path: &Path, report: &GroundReport) -> Result<(), Failure> {
    let file = report.file.as_ref().map(|file| File {
        path: &file.path,
        format: file.format,
        points: file.points,
        side: file.side,
        filled_points: file.filled,
        points_outside_the_square: file.cut,
        before: Numbers::of(&file.before),
        after: Numbers::of(&file.after),
    });
    let cutoffs = report.cutoffs.iter();
    let told = Told {
        mesh: Numbers::of(&report.cell),
        file,
        unit: report.unit,
        cutoffs: cutoffs
            .map(|(name, q)| ((*name).to_owned(), (*q).into()))
            .collect(),
        warnings: &report.words,
    };
    write_json(path, &told)
}

/// Writes the power spectrum by rings.
///
/// # Errors
/// A file that cannot be written.
pub fn write_spectrum_csv(path: &Path, report: &GroundReport) -> Result<(), Failure> {
    let row = |[q, power]: &[f64; 2]| vec![number(*q), number(*power)];
    write_rows(path, SPECTRUM_COLUMNS, report.spectrum.iter().map(row))
}

/// Writes the heights above the mean as a height file: a matrix, the first row at y = 0, with its
/// side in the header.
///
/// # Errors
/// A file that cannot be written.
pub fn write_heights_csv(path: &Path, report: &GroundReport) -> Result<(), Failure> {
    let head = format!("# width = {}\n", number(report.grid.length));
    write_matrix(path, &head, &report.height)
}

#[derive(Serialize)]
struct Short<'a> {
    tackscope: &'static str,
    scene: SceneSummary,
    completed: bool,
    reference: Option<ReferenceShort>,
    counts: Counts,
    pareto_transforms: Vec<PointShort<'a>>,
    pareto_processor_seconds: Vec<PointShort<'a>>,
    plan: Vec<PointShort<'a>>,
    paper_budget: Vec<PointShort<'a>>,
    skipped: Vec<String>,
}

#[derive(Serialize)]
struct ReferenceShort {
    what: String,
    dissipated_energy: Number,
    loop_integral: Number,
    jumps: usize,
    error_dissipated_energy: Number,
    error_jumps: Number,
    error_stress: Number,
    transforms: usize,
    processor_seconds: Number,
    outcome: String,
}

#[derive(Serialize)]
struct Counts {
    points: usize,
    done: usize,
    failed: usize,
    skipped: usize,
}

#[derive(Serialize)]
struct PointShort<'a> {
    method: &'a str,
    model: &'a str,
    points: usize,
    precision: &'a str,
    step: Number,
    error_dissipated_energy: Number,
    transforms: usize,
    processor_seconds: Number,
    outcome: String,
}

/// Writes the chart's summary; `given` is the word on the command line.
///
/// # Errors
/// A file that cannot be written.
pub fn write_chart_json(
    path: &Path,
    given: &str,
    scene: &Scene,
    chart: &Chart,
) -> Result<(), Failure> {
    let of = |which: fn(&Judged) -> bool| {
        chart
            .rows
            .iter()
            .filter(|row| which(row))
            .map(short)
            .collect()
    };
    let count =
        |which: fn(&Verdict) -> bool| chart.rows.iter().filter(|row| which(&row.verdict)).count();
    let told = Short {
        tackscope: VERSION,
        scene: SceneSummary::new(given, scene),
        completed: !chart.cancelled,
        reference: chart.reference.as_ref().map(|reference| ReferenceShort {
            what: reference.point().to_string(),
            dissipated_energy: Number(reference.dissipated_energy),
            loop_integral: Number(reference.integral),
            jumps: reference.finest.record.tally().jumps,
            error_dissipated_energy: Number(reference.errors.dissipated_energy),
            error_jumps: Number(reference.errors.jumps),
            error_stress: Number(reference.errors.stress),
            transforms: reference.finest.counts.transforms,
            processor_seconds: Number(reference.finest.processor_seconds),
            outcome: reference.judged().verdict.to_string(),
        }),
        counts: Counts {
            points: chart.rows.len(),
            done: count(|verdict| *verdict == Verdict::Done),
            failed: count(|verdict| matches!(verdict, Verdict::Failed { .. })),
            skipped: chart.skipped.len(),
        },
        pareto_transforms: of(|row| row.pareto_transforms),
        pareto_processor_seconds: of(|row| row.pareto_time),
        plan: of(|row| row.plan),
        paper_budget: of(|row| row.paper_budget),
        skipped: chart
            .skipped
            .iter()
            .map(|skipped| skipped.point.to_string())
            .collect(),
    };
    write_json(path, &told)
}

fn short(row: &Judged) -> PointShort<'_> {
    PointShort {
        method: row.point.method.word(),
        model: row.point.model_word(),
        points: row.point.points,
        precision: row.point.precision.word(),
        step: Number(row.point.step),
        error_dissipated_energy: Number(row.errors.dissipated_energy),
        transforms: row.transforms,
        processor_seconds: Number(row.processor_seconds),
        outcome: row.verdict.to_string(),
    }
}
