//! The diagram as tables: every branch, its special points, and the barriers between its states.

use super::{number, write_rows};
use crate::follow::diagram::Diagram;
use crate::physics::parameter::Dimension;
use crate::physics::system::State;
use crate::scene::Scene;
use crate::storage::Failure;
use crate::study::landscape::{Ground, Saddle};
use std::path::Path;

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
