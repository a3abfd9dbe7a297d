//! The ground before anything runs: its heights on the mesh, how they are distributed, their power
//! spectrum with what cuts it off, and its root mean squares beside those of the file.

use crate::numerics::fourier::amplitudes;
use crate::physics::indenter::{Indenter, Measured};
use crate::physics::law::Law;
use crate::physics::mesh::Grid;
use crate::physics::topography::{Border, Statistics};
use crate::scene::parameter::Units;
use ndarray::Array2;
use std::f64::consts::{PI, TAU};

/// Steps of the distribution of heights.
const STEPS: usize = 60;

/// Rings of the spectrum: single wave numbers up to the first, from there as many to a decade.
const SINGLE: f64 = 8.0;
const PER_DECADE: f64 = 24.0;

/// Share of the mean square slope in waves shorter than the range that is worth a word.
const BELOW_RANGE: f64 = 0.01;

/// What the ground is on a mesh.
#[derive(Clone, Debug)]
pub struct GroundReport {
    /// Height above the mean (length), shape (ny, nx).
    pub height: Array2<f64>,
    /// The mesh.
    pub grid: Grid,
    /// The unit of lengths, where it is known.
    pub unit: Option<&'static str>,
    /// Root mean squares on the mesh, which is periodic.
    pub cell: Statistics,
    /// The height file, if it comes from one.
    pub file: Option<FileReport>,
    /// Height above the mean (length) and share of the area per height (1/length).
    pub distribution: Vec<[f64; 2]>,
    /// Wave number (1/length) and mean of C(q) over its ring: A |h_q|^2 (length^4) of a map, L
    /// |h_q|^2 (length^3) of a profile, so that the sum of C(q)/A is the mean square height.
    pub spectrum: Vec<[f64; 2]>,
    /// What cuts the spectrum off, by wave number (1/length).
    pub cutoffs: Vec<(&'static str, f64)>,
    /// What must be known of it, in sentences.
    pub words: Vec<String>,
}

/// What became of a height file.
#[derive(Clone, Debug)]
pub struct FileReport {
    /// Where it is.
    pub path: String,
    /// What kind of file.
    pub format: &'static str,
    /// Points along x and y of the square that is used.
    pub points: [usize; 2],
    /// Side of that square (length).
    pub side: f64,
    /// Points that were not measured, and filled.
    pub filled: usize,
    /// Points outside of the square.
    pub cut: usize,
    /// Root mean squares on the file's points, without trend, before it is made periodic.
    pub before: Statistics,
    /// The same of one period.
    pub after: Statistics,
}

impl GroundReport {
    /// Of a ground on a mesh that it is allowed on; `None` on flat ground, or without a map. The
    /// `law`, if there is one, tells which waves are shorter than its range.
    pub fn of(indenter: &Indenter, grid: &Grid, law: Option<&Law>) -> Option<Self> {
        let height = indenter.height(grid)?;
        let height = &height - height.mean()?;
        let pitch = [grid.spacing(); 2];
        let (spectrum, beyond) = spectrum(&height, grid, law.map_or(0.0, |law| law.range));
        let (file, unit) = match indenter {
            Indenter::Measured(measured) => (Some(FileReport::of(measured)?), measured.unit()),
            _ => (None, None),
        };
        let mut cutoffs = vec![("mesh", PI / grid.spacing())];
        if let Some(law) = law {
            cutoffs.push(("range", TAU / law.range));
        }
        if let Some(file) = &file {
            cutoffs.push(("file", PI * file.points[0] as f64 / file.side));
        }
        match indenter {
            Indenter::Measured(measured) if measured.shortest() > 0.0 => {
                cutoffs.push(("shortest", TAU / measured.shortest()));
            }
            Indenter::Rough(rough) => cutoffs.push(("shortest", TAU / rough.shortest)),
            _ => {}
        }
        let mut words: Vec<String> = file.iter().flat_map(|file| file.words(indenter)).collect();
        words.extend(indenter.ground().left_out(grid));
        if beyond > BELOW_RANGE {
            words.push(format!(
                "waves shorter than the range of the law have {:.0} % of the mean square slope: \
                 the law averages over them",
                100.0 * beyond
            ));
        }
        Some(Self {
            cell: Statistics::of(&height, pitch, Border::Periodic),
            distribution: distribution(&height),
            height,
            grid: *grid,
            unit,
            file,
            spectrum,
            cutoffs,
            words,
        })
    }

    /// The same of a scene with these units.
    pub fn in_units(self, units: Option<Units>) -> Self {
        let unit = units.map(|units| units.length.word);
        Self {
            unit: unit.or(self.unit),
            ..self
        }
    }

    /// The unit of lengths, or the word for any.
    pub fn length(&self) -> &'static str {
        self.unit.unwrap_or("length")
    }
}

impl FileReport {
    fn of(measured: &Measured) -> Option<Self> {
        let levelled = &measured.worked().as_ref().ok()?.levelled;
        let (ny, nx) = levelled.heights.dim();
        let pitch = levelled.pitch();
        let after = levelled.periodic(measured.periodic());
        Some(Self {
            path: measured.topography().file.display().to_string(),
            format: measured.topography().format,
            points: [nx, ny],
            side: levelled.side,
            filled: levelled.filled,
            cut: levelled.cut,
            before: Statistics::of(&levelled.heights, pitch, Border::Open),
            after: Statistics::of(&after, pitch, Border::Periodic),
        })
    }

    /// What was done to the map, and what that did to it.
    fn words(&self, indenter: &Indenter) -> Vec<String> {
        let [nx, ny] = self.points;
        let all = nx * ny;
        let mut words = Vec::new();
        if self.cut > 0 {
            words.push(format!(
                "a square of {nx} x {ny} points is used, {} points beside it are not",
                self.cut
            ));
        }
        if self.filled > 0 {
            words.push(format!(
                "{} of {all} points ({:.2} %) were not measured, and are filled by Laplace's \
                 equation",
                self.filled,
                100.0 * self.filled as f64 / all as f64
            ));
        }
        if let Indenter::Measured(measured) = indenter {
            let change = |before: f64, after: f64| 100.0 * (after / before - 1.0);
            words.push(format!(
                "made periodic by \"{}\": rms height {:+.1} %, rms slope {:+.1} %",
                measured.periodic().word(),
                change(self.before.height, self.after.height),
                change(self.before.gradient, self.after.gradient)
            ));
        }
        words
    }
}

/// How much of the area lies at which height.
fn distribution(height: &Array2<f64>) -> Vec<[f64; 2]> {
    let ends = |ends: [f64; 2], h: &f64| [ends[0].min(*h), ends[1].max(*h)];
    let [low, high] = height.iter().fold([f64::INFINITY, f64::NEG_INFINITY], ends);
    let step = (high - low) / STEPS as f64;
    if !(step > 0.0) {
        return Vec::new();
    }
    let mut counts = [0.0; STEPS];
    for h in height {
        counts[(((h - low) / step) as usize).min(STEPS - 1)] += 1.0;
    }
    let middle = |k: usize| low + (k as f64 + 0.5) * step;
    let counts = counts.iter().enumerate();
    counts
        .map(|(k, count)| [middle(k), count / (step * height.len() as f64)])
        .collect()
}

/// The spectrum by rings, and the share of the mean square slope in waves shorter than `range`.
fn spectrum(height: &Array2<f64>, grid: &Grid, range: f64) -> (Vec<[f64; 2]>, f64) {
    let (ny, nx) = height.dim();
    let area = if grid.is_line() {
        grid.length
    } else {
        grid.length.powi(2)
    };
    let signed = |k: usize, n: usize| k.min(n - k) as f64;
    // Number of the ring of a wave number, in units of the smallest.
    let ring = |k: f64| {
        if k < SINGLE {
            k.round() as usize
        } else {
            (SINGLE + PER_DECADE * (k / SINGLE).log10()) as usize
        }
    };
    let mut rings: Vec<[f64; 3]> = Vec::new();
    let mut slopes = [0.0; 2];
    for ((l, k), amplitude) in amplitudes(height).indexed_iter() {
        let wave = signed(k, nx).hypot(signed(l, ny));
        let (q, power) = (grid.q1() * wave, amplitude.norm_sqr());
        slopes[usize::from(q * range > TAU)] += q * q * power;
        // Corners of the square beyond the mesh's own cut-off are not whole rings.
        if wave == 0.0 || 2.0 * wave > nx as f64 {
            continue;
        }
        let at = ring(wave);
        rings.resize(rings.len().max(at + 1), [0.0; 3]);
        rings[at] = [
            rings[at][0] + 1.0,
            rings[at][1] + q,
            rings[at][2] + area * power,
        ];
    }
    let means = rings.iter().filter(|ring| ring[0] > 0.0);
    let means = means.map(|[count, q, power]| [q / count, power / count]);
    (means.collect(), slopes[1] / (slopes[0] + slopes[1]))
}
