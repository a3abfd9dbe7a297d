//! Measured ground.
//!
//! A height map is levelled, its holes are filled, it is made periodic, and what a mesh shows of it
//! are the waves that the mesh can tell apart: h(r) = sum_q Re(a_q e^{i q r}) - crest, as of rough
//! ground. All that follows from the map and the choices alone, and is worked out once, when it is
//! first asked for.

use super::wave::{Component, below_crest};
use super::{Ground, Indenter};
use crate::numerics::fourier::amplitudes;
use crate::physics::law::Law;
use crate::physics::mesh::{Grid, POINTS_MAX};
use crate::physics::parameter::{
    Dimension, LENGTHS, Own, Parameter, Refusal, Value, number, parameter,
};
use crate::physics::topography::{Detrend, Levelled, Periodic, Topography, Unit};
use ndarray::Array2;
use rustfft::num_complex::Complex;
use std::f64::consts::{PI, TAU};
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

/// A measured height map as ground.
#[derive(Clone, Debug)]
pub struct Measured {
    /// The map, as its file has it.
    topography: Arc<Topography>,
    /// Side along x of the whole map (length); 0 is as the file says.
    size: f64,
    /// What heights are multiplied by.
    height_scale: f64,
    /// Which of [`UNITS`] the scene's lengths are, where the file has metres.
    unit: usize,
    /// What is taken away from the heights.
    detrend: Detrend,
    /// How it becomes periodic.
    periodic: Periodic,
    /// Waves shorter than this are left out (length); 0 leaves none out.
    shortest: f64,
    worked: Arc<OnceLock<Result<Worked, Refusal>>>,
}

/// What follows from a map and the choices.
#[derive(Clone, Debug)]
pub struct Worked {
    /// The map without trend and holes.
    pub levelled: Levelled,
    waves: Vec<Component>,
    /// Mean square of q h_q by the larger of both wave numbers, of all waves that shall be shown.
    rings: Vec<f64>,
    relief: f64,
}

/// Units that the scene's lengths may be.
const UNITS: &[&str] = &["m", "mm", "um", "nm"];
/// In metres.
const METRES: [f64; 4] = [1.0, 1e-3, 1e-6, 1e-9];
/// Micrometres, what most maps are told in.
const UM: usize = 2;

/// Largest wave number along a side that is kept, of a map and of a profile: more than the meshes
/// show that a loop can be computed on.
const WAVES_MAP: usize = 511;
const WAVES_PROFILE: usize = POINTS_MAX / 2 - 1;

/// Share of the mean square slope that may be left out unsaid.
const UNSAID: f64 = 0.01;

/// Amplitude over the largest height that rounding leaves of a wave that is not there.
const ROUNDING: f64 = 1e-13;

/// How far `cell.length` may be from the period, as a share: it is written by hand.
const LENGTH_TOLERANCE: f64 = 1e-6;

impl PartialEq for Measured {
    fn eq(&self, other: &Self) -> bool {
        self.values() == other.values()
            && (Arc::ptr_eq(&self.topography, &other.topography)
                || self.topography == other.topography)
    }
}

/// A choice by its word, with the one of its default.
const fn choice(
    key: &'static str,
    label: &'static str,
    (chosen, words): (usize, &'static [&'static str]),
    hint: &'static str,
) -> Parameter {
    parameter!(
        key,
        label,
        "",
        Dimension::Pure(""),
        0.0..=0.0,
        Some(Value::Choice { chosen, words }),
        hint
    )
}

/// No map at all, which [`Own::check`] refuses.
impl Default for Measured {
    fn default() -> Self {
        Self::new(Topography {
            file: PathBuf::new(),
            format: "",
            heights: Array2::zeros((4, 4)),
            size: None,
            unit: Unit::Scene,
        })
    }
}

impl Own for Measured {
    const PARAMETERS: &'static [Parameter] = &[
        parameter!(
            "indenter.size",
            "Measured side",
            "",
            Dimension::Length,
            0.0..=1e110,
            Some(Value::Number(0.0)),
            "the side along x of the whole map, {range}, or 0: as the file says"
        ),
        parameter!(
            "indenter.height_scale",
            "Height scale",
            "",
            Dimension::Pure(""),
            1e-12..=1e12,
            Some(Value::Number(1.0)),
            "a number above 0 that heights are multiplied by, {range}"
        ),
        choice(
            "indenter.unit",
            "Unit",
            (UM, UNITS),
            "what one length of the scene is, for a file in metres: \"m\", \"mm\", \"um\" or \
                \"nm\"",
        ),
        choice(
            "indenter.detrend",
            "Detrend",
            (Detrend::None as usize, Detrend::WORDS),
            "what is taken away by least squares: \"none\", \"tilt\" or \"curvature\"",
        ),
        choice(
            "indenter.periodic",
            "Periodic",
            (Periodic::Mirror as usize, Periodic::WORDS),
            "how the map is continued: \"mirror\" (a cell of twice the side), \"window\" \
                (faded to its mean over the outer eighths) or \"as_is\"",
        ),
        parameter!(
            "indenter.shortest",
            "Shortest wave",
            "",
            Dimension::Length,
            0.0..=*LENGTHS.end(),
            Some(Value::Number(0.0)),
            "a wavelength below which waves are left out, {range}; 0 leaves none out"
        ),
    ];

    fn values(&self) -> Vec<Value> {
        let choice = |chosen, words| Value::Choice { chosen, words };
        vec![
            Value::Number(self.size),
            Value::Number(self.height_scale),
            choice(self.unit, UNITS),
            choice(self.detrend as usize, Detrend::WORDS),
            choice(self.periodic as usize, Periodic::WORDS),
            Value::Number(self.shortest),
        ]
    }

    fn with(&self, values: &[Value]) -> Self {
        Self {
            topography: Arc::clone(&self.topography),
            size: values[0].number(),
            height_scale: values[1].number(),
            unit: values[2].chosen(),
            detrend: Detrend::ALL[values[3].chosen()],
            periodic: Periodic::ALL[values[4].chosen()],
            shortest: values[5].number(),
            worked: Arc::default(),
        }
    }

    fn check(&self) -> Result<(), Refusal> {
        if self.topography.file.as_os_str().is_empty() {
            let allowed = "the path of a height file";
            return Err(Refusal::new("indenter.file", "\"\"", allowed));
        }
        if !self.side().is_normal() || !LENGTHS.contains(&self.side()) {
            let allowed =
                "the side along x of the whole map: the file does not say how large it is";
            return Err(Refusal::new("indenter.size", number(self.size), allowed));
        }
        self.worked().as_ref().map(drop).map_err(Refusal::clone)
    }
}

impl Measured {
    /// A map with the default choices.
    pub fn new(topography: Topography) -> Self {
        Self {
            topography: Arc::new(topography),
            size: 0.0,
            height_scale: 1.0,
            unit: UM,
            detrend: Detrend::None,
            periodic: Periodic::Mirror,
            shortest: 0.0,
            worked: Arc::default(),
        }
    }

    /// Another map with the same choices.
    pub fn of(&self, topography: Topography) -> Self {
        Self {
            topography: Arc::new(topography),
            worked: Arc::default(),
            ..self.clone()
        }
    }

    /// The same map continued in another way.
    pub fn continued(&self, periodic: Periodic) -> Self {
        Self {
            periodic,
            worked: Arc::default(),
            ..self.clone()
        }
    }

    /// The same, with a size by which its period is `length`, where nothing tells its size.
    pub fn filling(self, length: f64) -> Self {
        if self.side() > 0.0 {
            return self;
        }
        let (rows, columns) = self.topography.heights.dim();
        // Of square pixels; the square out of the middle is what repeats.
        let side = if rows == 1 {
            1.0
        } else {
            columns as f64 / rows.min(columns) as f64
        };
        let size = side * length / self.periods();
        Self {
            size,
            worked: Arc::default(),
            ..self
        }
    }

    /// Which of m, mm, um and nm a length of the scene is taken for; `None` where the file has no metres.
    pub fn unit(&self) -> Option<&'static str> {
        (self.topography.unit == Unit::Metre).then_some(UNITS[self.unit])
    }

    /// The same with a length of the scene taken for the unit `word`, if that is one of those.
    pub fn in_unit(self, word: &str) -> Self {
        let unit = UNITS.iter().position(|unit| *unit == word);
        Self {
            unit: unit.unwrap_or(self.unit),
            worked: Arc::default(),
            ..self
        }
    }

    /// The map, as its file has it.
    pub fn topography(&self) -> &Topography {
        &self.topography
    }

    /// How it becomes periodic.
    pub fn periodic(&self) -> Periodic {
        self.periodic
    }

    /// Waves shorter than this are left out (length); 0 leaves none out.
    pub fn shortest(&self) -> f64 {
        self.shortest
    }

    /// Lengths of the scene in a unit of the file.
    fn lengths(&self) -> f64 {
        match self.topography.unit {
            Unit::Scene => 1.0,
            Unit::Metre => 1.0 / METRES[self.unit],
        }
    }

    /// Side along x of the whole map (length); 0 where nothing says.
    fn side(&self) -> f64 {
        let told = self.topography.size.map_or(0.0, |[x, _]| x);
        if self.size > 0.0 {
            self.size
        } else {
            told * self.lengths()
        }
    }

    /// What follows from the map and the choices.
    ///
    /// # Errors
    /// A map that is too small, or less than half of which was measured.
    pub fn worked(&self) -> &Result<Worked, Refusal> {
        self.worked.get_or_init(|| self.work())
    }

    fn work(&self) -> Result<Worked, Refusal> {
        let scale = self.height_scale * self.lengths();
        let levelled = self.topography.level(self.side(), scale, self.detrend)?;
        let field = levelled.periodic(self.periodic);
        let (ny, nx) = field.dim();
        let length = self.periods() * levelled.side;
        let shortest = self.shortest * (1.0 - 1e-9);
        let amplitudes = amplitudes(&field);
        // Points of a mirrored map lie half a spacing off the mirror, which is the cell's corner.
        let shift = |k: i64, n: usize| match self.periodic {
            Periodic::Mirror if n > 1 => -PI * k as f64 / n as f64,
            _ => 0.0,
        };
        let signed = |k: usize, n: usize| {
            if 2 * k > n {
                k as i64 - n as i64
            } else {
                k as i64
            }
        };
        let most = if ny == 1 { WAVES_PROFILE } else { WAVES_MAP };
        let given = self.topography.heights.iter();
        let largest = given.fold(0.0, |most: f64, h| most.max((scale * h).abs()));
        let (mut waves, mut rings) = (Vec::new(), vec![0.0; nx.max(ny) / 2 + 1]);
        for ((l, k), amplitude) in amplitudes.indexed_iter() {
            let (x, y) = (signed(k, nx), signed(l, ny));
            let q = TAU / length * (x as f64).hypot(y as f64);
            // Half of the plane holds all; beyond the shortest wave nothing is wanted.
            if x < 0 || x == 0 && y <= 0 || q * shortest > TAU {
                continue;
            }
            let mut amplitude = 2.0 * amplitude * Complex::cis(shift(x, nx) + shift(y, ny));
            if self.periodic == Periodic::Mirror {
                amplitude.im = 0.0;
            }
            let ring = x.max(y.abs()) as usize;
            rings[ring] += 0.5 * amplitude.norm_sqr() * q * q;
            // What rounding leaves of none would hold patterns that slide.
            if amplitude.norm() <= ROUNDING * largest {
                continue;
            }
            // The last wave of an even number of points has no phase, and is no wave of a finer mesh.
            let told = 2 * x < nx as i64 && 2 * y.abs() < ny.max(2) as i64;
            if ring <= most && told {
                let wave = [x, y];
                waves.push(Component { wave, amplitude });
            }
        }
        let heights = &levelled.heights;
        let highest = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let relief = highest - heights.sum() / heights.len() as f64;
        Ok(Worked {
            levelled,
            waves,
            rings,
            relief,
        })
    }

    /// Sides of the map along a side of the cell.
    fn periods(&self) -> f64 {
        match self.periodic {
            Periodic::Mirror => 2.0,
            Periodic::Window | Periodic::AsIs => 1.0,
        }
    }

    /// The waves that the points of `grid` can tell from longer ones, seen from `shift` spacings
    /// along x and y off the corner of the cell.
    fn shown(&self, grid: &Grid, shift: f64) -> Vec<Component> {
        let Ok(worked) = self.worked() else {
            return Vec::new();
        };
        let mut waves = worked.waves.clone();
        waves.retain(|wave| wave.is_shown(grid));
        for Component { wave, amplitude } in &mut waves {
            let turns = (wave[0] + wave[1]) as f64 * shift / grid.nx as f64;
            *amplitude *= Complex::cis(TAU * turns);
        }
        waves
    }

    /// Share of the mean square slope in waves too short for `grid`; NaN on a plane.
    fn lost(&self, grid: &Grid) -> f64 {
        let Ok(worked) = self.worked() else {
            return f64::NAN;
        };
        let first = grid.nx.div_ceil(2).min(worked.rings.len());
        worked.rings[first..].iter().sum::<f64>() / worked.rings.iter().sum::<f64>()
    }
}

impl Ground for Measured {
    fn name(&self) -> &'static str {
        "measured"
    }

    /// The map is what it is: only a file is another one.
    fn suited(&self, _law: &Law, _grid: &Grid) -> Indenter {
        Indenter::Measured(self.clone())
    }

    fn at(&self, _x: f64, _y: f64, _length: f64) -> f64 {
        unreachable!("its waves are summed over a mesh")
    }

    /// The waves that the mesh can show.
    fn height(&self, grid: &Grid) -> Option<Array2<f64>> {
        Some(below_crest(&self.shown(grid, 0.0), grid))
    }

    fn even_height(&self, grid: &Grid) -> Option<Array2<f64>> {
        let middle = self.shown(grid, 0.5 * grid.nx as f64 + 0.5);
        let whole = below_crest(&middle, grid);
        let (rows, columns) = (grid.ny.div_ceil(2), grid.nx / 2);
        Some(Array2::from_shape_fn((rows, columns), |at| whole[at]))
    }

    fn is_even(&self) -> bool {
        self.periodic == Periodic::Mirror
    }

    fn points_needed(&self, length: f64) -> usize {
        if self.shortest > 0.0 {
            (4.0 * length / self.shortest).ceil().min(1e9) as usize
        } else {
            0
        }
    }

    fn is_uniform(&self) -> [bool; 2] {
        let waves = self.worked().as_ref().map(|worked| &worked.waves);
        [0, 1].map(|axis| waves.is_ok_and(|waves| waves.iter().all(|w| w.wave[axis] == 0)))
    }

    /// The highest point of the file above its mean.
    fn relief(&self, _law: &Law) -> f64 {
        self.worked().as_ref().map_or(0.0, |worked| worked.relief)
    }

    fn period(&self) -> Option<f64> {
        let worked = self.worked().as_ref().ok()?;
        Some(self.periods() * worked.levelled.side)
    }

    fn check_in(&self, length: f64) -> Result<(), Refusal> {
        let period = self.period().unwrap_or(length);
        if (length / period - 1.0).abs() <= LENGTH_TOLERANCE {
            return Ok(());
        }
        let allowed = format!(
            "{period}, the period of the measured ground with indenter.periodic = \"{}\"",
            self.periodic.word()
        );
        Err(Refusal::new("cell.length", number(length), &allowed))
    }

    fn check_on(&self, grid: &Grid) -> Result<(), Refusal> {
        if grid.is_line() && !self.is_uniform()[1] {
            let allowed = "a number of points: a line cell takes a profile, not a map";
            let points = format!("[{}, 1]", grid.nx);
            return Err(Refusal::new("cell.points", points, allowed));
        }
        Ok(())
    }

    fn left_out(&self, grid: &Grid) -> Option<String> {
        let lost = self.lost(grid);
        (lost > UNSAID).then(|| {
            format!(
                "the mesh is too coarse for the finest waves of the measured ground: what it leaves \
                 out has {:.0} % of the mean square slope",
                100.0 * lost
            )
        })
    }
}
