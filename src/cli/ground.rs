//! `tackscope ground`: the ground of a scene, or of a height file, before anything runs.

use super::{DONE, GroundArguments, failures, scene_with_points, warn};
use crate::physics::grid::Grid;
use crate::physics::indenter::{Indenter, Measured};
use crate::physics::parameter::{Own, Refusal};
use crate::plot::ground_panel::page;
use crate::storage::export::{write_ground_json, write_heights_csv, write_spectrum_csv};
use crate::storage::{Failure, Opened, drawing, files, open, presets, scene_file};
use crate::study::ground::GroundReport;
use std::path::Path;

/// What is written.
const FILES: [&str; 5] = [
    "ground.json",
    "spectrum.csv",
    "heights.csv",
    "ground.svg",
    "ground.png",
];
/// Room that the files need, in bytes.
const ROOM: u64 = 40_000_000;

/// Looks at the ground, writes its files and returns the exit code.
///
/// # Errors
/// A scene or a height file that is refused, flat ground, a folder that cannot be written, or a
/// standard output that cannot.
pub(super) fn ground(arguments: &GroundArguments) -> Result<u8, Failure> {
    let (report, title) = report(arguments)?;
    let output = &arguments.output;
    let folder = output.claim(&[], ROOM, |name| FILES.contains(&name))?;
    let [json, spectrum, heights, picture, _] = FILES.map(|name| folder.join(name));
    let page = page(&report, &title);
    let tables = [
        write_ground_json(&json, &report),
        write_spectrum_csv(&spectrum, &report),
        write_heights_csv(&heights, &report),
    ];
    let written = tables
        .into_iter()
        .chain(drawing::write_page(&picture, &page));
    if !output.quiet {
        report.words.iter().for_each(warn);
    }
    output.close(&failures(written), DONE, &page.caption[0])
}

/// The report with its title: on the mesh of the scene, or on the points of the file.
fn report(arguments: &GroundArguments) -> Result<(GroundReport, String), Failure> {
    let word = arguments.scene.as_str();
    let path = files::typed(Path::new(word))?;
    if presets::find(word).is_none()
        && path.exists()
        && let Opened::Heights(topography) = open(&path)?
    {
        let measured = Measured::new(topography);
        let refused = |error: Refusal| scene_file::refused(word, error);
        measured.check().map_err(refused)?;
        let line = measured.topography().heights.nrows() == 1;
        let n = arguments.points.unwrap_or_else(|| own_points(&measured));
        let indenter = Indenter::Measured(measured);
        let length = indenter.ground().period().unwrap_or(1.0);
        let grid = if line {
            Grid::line(length, n)
        } else {
            Grid::square(length, n)
        };
        let report = GroundReport::of(&indenter, &grid, None);
        return Ok((report.expect("there is a map"), word.to_owned()));
    }
    let (scene, place) = scene_with_points(word, arguments.points)?;
    let model = scene
        .model()
        .map_err(|error| scene_file::refused(&place, error))?;
    let report = GroundReport::of(&model.indenter, &model.grid, Some(&model.law));
    let report = report.ok_or_else(|| {
        let allowed = "allowed is ground with heights; flat ground has none to look at";
        Failure::value(&place, "indenter.kind", "\"flat\"", allowed)
    })?;
    Ok((report.in_units(scene.units), scene.title))
}

/// An even number of points that shows all that a file has.
fn own_points(measured: &Measured) -> usize {
    let worked = measured.worked().as_ref();
    let periodic = worked.map(|worked| worked.levelled.periodic(measured.periodic()).dim());
    periodic.map_or(0, |(ny, nx)| nx.max(ny).next_multiple_of(2))
}
