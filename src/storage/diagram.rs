//! A diagram of branches as data: `branches.csv`, a row a point; `points.csv`, a row for each fold,
//! bifurcation and pair of equal energies.

use super::export::number;
use super::{Failure, files};
use crate::follow::diagram::{Diagram, Kind};
use std::fmt::Write;
use std::path::Path;

/// First line of `branches.csv`.
pub const BRANCH_COLUMNS: &str =
    "branch,point,mean_displacement,stress,energy,index,pattern,kind,residual";

/// First line of `points.csv`.
pub const POINT_COLUMNS: &str =
    "kind,branch,mean_displacement,stress,energy,index_before,index_after";

/// Writes every point of every branch in order along it: u0 in the scene's length, stress in E*,
/// energy per area in E* times length. `index` is the number of negative eigenvalues over all modes
/// of the whole cell, sliding ones left out; at a fold or bifurcation the mode without stiffness is
/// not counted.
///
/// # Errors
/// A file that cannot be written.
pub fn write_branches_csv(path: &Path, diagram: &Diagram) -> Result<(), Failure> {
    let mut text = format!("{BRANCH_COLUMNS}\n");
    for branch in &diagram.branches {
        for (i, point) in branch.points.iter().enumerate() {
            let state = &point.state;
            let [u0, stress, energy, residual] = [
                state.mean_displacement,
                state.stress,
                state.energy,
                point.residual,
            ]
            .map(number);
            let index = point.index[0].min(point.index[1]);
            let _ = writeln!(
                text,
                "{},{i},{u0},{stress},{energy},{index},{},{},{residual}",
                branch.name, point.pattern, point.kind
            );
        }
    }
    files::write_whole(path, text.as_bytes())
}

/// Writes folds and bifurcations in order along their branches, then equal energies: `branch` is
/// then the names of both, with a slash between them.
///
/// # Errors
/// A file that cannot be written.
pub fn write_points_csv(path: &Path, diagram: &Diagram) -> Result<(), Failure> {
    let mut text = format!("{POINT_COLUMNS}\n");
    let events = diagram.events().filter(|(_, p)| p.kind != Kind::Regular);
    for (branch, point) in events {
        let state = &point.state;
        let numbers = [state.mean_displacement, state.stress, state.energy].map(number);
        let [before, after] = point.index;
        let _ = writeln!(
            text,
            "{},{},{},{before},{after}",
            point.kind,
            branch.name,
            numbers.join(",")
        );
    }
    for equal in &diagram.equal_energies {
        let numbers = [equal.mean_displacement, equal.stresses[0], equal.energy].map(number);
        let _ = writeln!(
            text,
            "equal_energy,{},{},0,0",
            equal.branches.join("/"),
            numbers.join(",")
        );
    }
    files::write_whole(path, text.as_bytes())
}
