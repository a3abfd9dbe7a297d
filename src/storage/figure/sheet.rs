//! A drawing as a list of marks, in units with y downwards. It is made once, and becomes an SVG or pixels.

use crate::paper::typeset::{Run, Script, runs};
use crate::storage::line;
use crate::storage::picture::register_font;
use image::RgbImage;
use plotters::style::{IntoFont, RGBColor};

/// Size of a sub- or superscript beside its line, and how far it is moved (in sizes of the line, downwards).
pub(super) const SMALLER: f64 = 0.72;
pub(super) fn drop_of(script: Script) -> f64 {
    match script {
        Script::Base => 0.0,
        Script::Sub => 0.22,
        Script::Super => -0.36,
    }
}

/// Height of the font's lines over the size of its em, by which plotters measures fonts.
pub(super) const LINE_HEIGHT: f64 = 1.164;

pub(super) type Place = [f64; 2];

/// A stroke.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stroke {
    pub(super) colour: RGBColor,
    pub(super) width: f64,
    /// Lengths of dash and space.
    pub(super) dash: Option<[f64; 2]>,
}

impl Stroke {
    pub(super) const fn solid(colour: RGBColor, width: f64) -> Self {
        Self { colour, width, dash: None }
    }
}

/// Which end of a text is at its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// Something drawn.
#[derive(Clone, Debug)]
pub(super) enum Mark {
    Line {
        points: Vec<Place>,
        stroke: Stroke,
    },
    Fill {
        points: Vec<Place>,
        colour: RGBColor,
        opacity: f64,
    },
    /// `at` is the left end of the base line; upright text runs upwards from there.
    Words {
        at: Place,
        runs: Vec<Run>,
        size: f64,
        colour: RGBColor,
        upright: bool,
    },
    /// Left, top, width, height.
    Picture {
        place: [f64; 4],
        image: RgbImage,
    },
}

/// The drawing.
#[derive(Clone, Debug)]
pub(super) struct Sheet {
    pub(super) width: f64,
    pub(super) height: f64,
    pub(super) marks: Vec<Mark>,
}

impl Sheet {
    pub(super) fn new(width: f64, height: f64) -> Self {
        Self { width, height, marks: Vec::new() }
    }

    pub(super) fn line(&mut self, points: impl Into<Vec<Place>>, stroke: Stroke) {
        self.marks.push(Mark::Line { points: points.into(), stroke });
    }

    pub(super) fn fill(&mut self, points: impl Into<Vec<Place>>, colour: RGBColor, opacity: f64) {
        self.marks.push(Mark::Fill { points: points.into(), colour, opacity });
    }

    /// Text whose middle height is at `at`.
    pub(super) fn words(&mut self, at: Place, text: &[Run], size: f64, colour: RGBColor, anchor: Anchor) {
        let left = at[0] - share(anchor) * width(text, size);
        let runs = text.to_vec();
        self.marks.push(Mark::Words { at: [left, at[1] + 0.36 * size], runs, size, colour, upright: false });
    }

    /// Text from the bottom to the top, its middle at `at`.
    pub(super) fn upright(&mut self, at: Place, text: &[Run], size: f64, colour: RGBColor) {
        let bottom = at[1] + 0.5 * width(text, size);
        let runs = text.to_vec();
        self.marks.push(Mark::Words { at: [at[0] + 0.36 * size, bottom], runs, size, colour, upright: true });
    }
}

fn share(anchor: Anchor) -> f64 {
    match anchor {
        Anchor::Start => 0.0,
        Anchor::Middle => 0.5,
        Anchor::End => 1.0,
    }
}

/// A line of text with its formulas set.
pub(super) fn set(text: &str) -> Vec<Run> {
    runs(&line(text))
}

/// The accent that stands for itself, of one that combines with the letter before.
pub(super) fn spacing(c: char) -> Option<char> {
    match c {
        '\u{302}' => Some('\u{2c6}'),
        '\u{303}' => Some('\u{2dc}'),
        '\u{304}' => Some('\u{af}'),
        _ => None,
    }
}

/// Width of one run in a line of this size.
pub(super) fn width_of(run: &Run, size: f64) -> f64 {
    /// The font is measured in whole pixels: large ones.
    const LARGE: f64 = 400.0;
    register_font();
    let size = if run.script == Script::Base { size } else { SMALLER * size };
    // Accents stand on their letters and take no room.
    let text: String = run.text.chars().filter(|c| spacing(*c).is_none()).collect();
    let measured = ("sans-serif", LARGE * LINE_HEIGHT).into_font().box_size(&text);
    // Without a font nothing is drawn either, and says so.
    measured.map_or(0.0, |(width, _)| f64::from(width) * size / LARGE)
}

/// Width of a line of text.
pub(super) fn width(runs: &[Run], size: f64) -> f64 {
    runs.iter().map(|run| width_of(run, size)).sum()
}

/// The corners of a rectangle given by left, top, right, bottom.
pub(super) fn rectangle([left, top, right, bottom]: [f64; 4]) -> Vec<Place> {
    vec![[left, top], [right, top], [right, bottom], [left, bottom]]
}

/// The outline of a rectangle, closed.
pub(super) fn frame(sides: [f64; 4]) -> Vec<Place> {
    let mut points = rectangle(sides);
    points.push(points[0]);
    points
}
