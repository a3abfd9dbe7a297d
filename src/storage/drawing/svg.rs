//! A sheet that is drawn on: an SVG that grows mark by mark, in units with y downwards. A PNG is
//! this SVG rendered. Numbers have two decimals, so that the same drawing is the same text. What
//! lies outside a frame is cut off.

use crate::plot::panel::{Colour, Fill, Symbol};
use crate::plot::style::{Ground, Rgb, Stroke};
use crate::plot::typeset::{Run, Script, runs};
use crate::storage::line;
use crate::storage::picture::encode_png;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::RgbImage;
use resvg::{tiny_skia, usvg};
use skrifa::instance::{LocationRef, Size};
use skrifa::{FontRef, MetadataProvider};
use std::fmt::Write;
use std::sync::{Arc, LazyLock};

/// The font of every picture.
static FONT: &[u8] = include_bytes!(concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/assets/DejaVuSans.ttf"
));

/// Pictures are on paper.
pub(super) const GROUND: Ground = Ground::Light;
pub(super) const GRID: Rgb = [0xe8; 3];
pub(super) const RULE: Rgb = [0xb4; 3];

pub(super) fn ink() -> Rgb {
    Colour::Ink.on(GROUND)
}

/// Size of a sub- or superscript beside its line, and how far it is moved (in sizes of the line,
/// downwards).
const SMALLER: f64 = 0.72;
fn drop_of(script: Script) -> f64 {
    match script {
        Script::Base => 0.0,
        Script::Sub => 0.22,
        Script::Super => -0.36,
    }
}

pub(super) type Place = [f64; 2];

/// A solid line.
pub(super) const fn solid(colour: Rgb, width: f64) -> Stroke {
    Stroke {
        colour,
        width,
        dash: None,
    }
}

/// Which end of a text is at its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// The drawing.
#[derive(Clone, Debug)]
pub(super) struct Sheet {
    pub(super) width: f64,
    pub(super) height: f64,
    marks: String,
}

impl Sheet {
    pub(super) fn new(width: f64, height: f64) -> Self {
        Self {
            width,
            height,
            marks: String::new(),
        }
    }

    pub(super) fn line(&mut self, points: &[Place], stroke: Stroke) {
        let dash = stroke.dash.map_or(String::new(), |[on, off]| {
            format!(" stroke-dasharray=\"{} {}\"", number(on), number(off))
        });
        let _ = writeln!(
            self.marks,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" \
             stroke-linejoin=\"round\"{dash}/>",
            places(points),
            hex(stroke.colour),
            number(stroke.width)
        );
    }

    pub(super) fn fill(&mut self, points: &[Place], colour: Rgb, opacity: f64) {
        let (points, colour, opacity) = (places(points), hex(colour), number(opacity));
        let _ = writeln!(
            self.marks,
            "<polygon points=\"{points}\" fill=\"{colour}\" fill-opacity=\"{opacity}\"/>"
        );
    }

    /// A symbol of about `radius`.
    pub(super) fn symbol(
        &mut self,
        symbol: Symbol,
        at: Place,
        colour: Rgb,
        radius: f64,
        fill: Fill,
    ) {
        for stroke in symbol.strokes() {
            let corners: Vec<Place> = stroke
                .iter()
                .map(|c| [at[0] + radius * c[0], at[1] - radius * c[1]])
                .collect();
            if fill == Fill::Filled && corners.len() > 2 || symbol == Symbol::Dot {
                self.fill(&corners, colour, 1.0);
            } else {
                self.line(&corners, solid(colour, 0.35 * radius));
            }
        }
    }

    /// The image over a place given by left, top, width, height.
    pub(super) fn picture(&mut self, place: [f64; 4], image: &RgbImage) {
        let [x, y, width, height] = place.map(number);
        let bytes = encode_png(image)
            .map(|bytes| STANDARD.encode(bytes))
            .unwrap_or_default();
        let _ = writeln!(
            self.marks,
            "<image x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" \
             preserveAspectRatio=\"none\" href=\"data:image/png;base64,{bytes}\"/>"
        );
    }

    /// Text whose middle height is at `at`.
    pub(super) fn words(
        &mut self,
        at: Place,
        text: &[Run],
        size: f64,
        colour: Rgb,
        anchor: Anchor,
    ) {
        let share = match anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => 0.5,
            Anchor::End => 1.0,
        };
        self.text(
            [at[0] - share * width(text, size), at[1] + 0.36 * size],
            text,
            size,
            colour,
            "",
        );
    }

    /// Text from the bottom to the top, its middle at `at`.
    pub(super) fn upright(&mut self, at: Place, text: &[Run], size: f64, colour: Rgb) {
        let at = [at[0] + 0.36 * size, at[1] + 0.5 * width(text, size)];
        let turn = format!(
            " transform=\"rotate(-90 {} {})\"",
            number(at[0]),
            number(at[1])
        );
        self.text(at, text, size, colour, &turn);
    }

    /// Text with the left end of its base line at `at`.
    fn text(&mut self, [x, y]: Place, runs: &[Run], size: f64, colour: Rgb, turn: &str) {
        let (x, y, out) = (number(x), number(y), &mut self.marks);
        let _ = write!(
            out,
            "<text x=\"{x}\" y=\"{y}\" font-size=\"{}\" fill=\"{}\"{turn}>",
            number(size),
            hex(colour)
        );
        // Simple viewers place the pieces of a line badly; most lines have but one.
        if let [
            Run {
                text,
                script: Script::Base,
            },
        ] = runs
        {
            let _ = writeln!(out, "{}</text>", escaped(text));
            return;
        }
        let mut level = 0.0;
        for run in runs {
            let now = drop_of(run.script) * size;
            let (dy, small) = (number(now - level), number(size_of(run, size)));
            let _ = write!(
                out,
                "<tspan dy=\"{dy}\" font-size=\"{small}\">{}</tspan>",
                escaped(&run.text)
            );
            level = now;
        }
        out.push_str("</text>\n");
    }

    /// The whole as an SVG.
    pub(super) fn svg(&self) -> String {
        let (width, height) = (number(self.width), number(self.height));
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" \
             font-family=\"DejaVu Sans, Verdana, sans-serif\" xml:space=\"preserve\">\n\
             <rect width=\"{width}\" height=\"{height}\" fill=\"{}\"/>\n{}</svg>\n",
            hex(GROUND.colour()),
            self.marks
        )
    }

    /// The whole as pixels, at least 1800 across and 1.5 for each unit.
    ///
    /// # Errors
    /// Why the SVG cannot be rendered.
    pub(super) fn pixels(&self) -> Result<RgbImage, usvg::Error> {
        /// The font known to the renderer, read once: it takes some milliseconds.
        static OPTIONS: LazyLock<usvg::Options<'static>> = LazyLock::new(|| {
            let mut options = usvg::Options::default();
            Arc::make_mut(&mut options.fontdb).load_font_data(FONT.to_vec());
            options
        });
        let tree = usvg::Tree::from_str(&self.svg(), &OPTIONS)?;
        let scale = (1800.0 / self.width).max(1.5);
        let (across, down) = (
            (self.width * scale).round().max(1.0) as u32,
            (self.height * scale).round().max(1.0) as u32,
        );
        let mut pixmap = tiny_skia::Pixmap::new(across, down).ok_or(usvg::Error::InvalidSize)?;
        resvg::render(
            &tree,
            tiny_skia::Transform::from_scale(scale as f32, scale as f32),
            &mut pixmap.as_mut(),
        );
        // The sheet covers everything, so that no pixel is transparent.
        let pixels = pixmap.data().chunks_exact(4);
        let opaque = pixels.flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]);
        RgbImage::from_raw(across, down, opaque.collect()).ok_or(usvg::Error::InvalidSize)
    }
}

/// A line of text with its formulas set.
pub(super) fn set(text: &str) -> Vec<Run> {
    runs(&line(text))
}

fn size_of(run: &Run, size: f64) -> f64 {
    if run.script == Script::Base {
        size
    } else {
        SMALLER * size
    }
}

/// Width of a line of text.
pub(super) fn width(runs: &[Run], size: f64) -> f64 {
    // A font that cannot be read draws nothing either.
    let Ok(font) = FontRef::new(FONT) else {
        return 0.0;
    };
    let (letters, metrics) = (
        font.charmap(),
        font.glyph_metrics(Size::new(1000.0), LocationRef::default()),
    );
    // An accent stands on its letter and takes no room; a sign that the font lacks is drawn as a
    // box.
    let wide = |c: char| {
        if ('\u{300}'..='\u{36f}').contains(&c) {
            0.0
        } else {
            metrics
                .advance_width(letters.map(c).unwrap_or_default())
                .unwrap_or(0.0)
        }
    };
    runs.iter()
        .map(|run| {
            run.text.chars().map(|c| f64::from(wide(c))).sum::<f64>() * size_of(run, size) / 1000.0
        })
        .sum()
}

/// The corners of a rectangle given by left, top, right, bottom.
pub(super) fn rectangle([left, top, right, bottom]: [f64; 4]) -> [Place; 4] {
    [[left, top], [right, top], [right, bottom], [left, bottom]]
}

/// The outline of a rectangle, closed.
pub(super) fn frame(sides: [f64; 4]) -> [Place; 5] {
    let [a, b, c, d] = rectangle(sides);
    [a, b, c, d, a]
}

fn places(points: &[Place]) -> String {
    let pairs: Vec<String> = points
        .iter()
        .map(|[x, y]| format!("{},{}", number(*x), number(*y)))
        .collect();
    pairs.join(" ")
}

/// Two decimals at most.
fn number(value: f64) -> String {
    let text = format!("{value:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" {
        "0".to_owned()
    } else {
        text.to_owned()
    }
}

fn hex([red, green, blue]: Rgb) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// Text on one line as it may stand in XML and HTML, also between quotes.
pub(in crate::storage) fn escaped(text: &str) -> String {
    let mut out = String::new();
    for c in line(text).chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            c => out.push(c),
        }
    }
    out
}

/// Left, top, right, bottom.
pub(super) type Sides = [f64; 4];

/// The pieces of a broken line inside the frame; `None` breaks the line.
pub(super) fn cut_line(
    points: impl Iterator<Item = Option<Place>>,
    frame: Sides,
) -> Vec<Vec<Place>> {
    let mut pieces: Vec<Vec<Place>> = Vec::new();
    let mut before: Option<Place> = None;
    for point in points {
        if let (Some(a), Some(b)) = (before, point)
            && let Some((a, b)) = cut_segment(a, b, frame)
        {
            match pieces.last_mut() {
                Some(piece) if piece.last() == Some(&a) => piece.push(b),
                _ => pieces.push(vec![a, b]),
            }
        }
        before = point;
    }
    pieces
}

/// The part of a segment inside the frame (Liang and Barsky).
pub(super) fn cut_segment(
    a: Place,
    b: Place,
    [left, top, right, bottom]: Sides,
) -> Option<(Place, Place)> {
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for (k, low, high) in [(0, left, right), (1, top, bottom)] {
        let step = b[k] - a[k];
        if step == 0.0 {
            if a[k] < low || a[k] > high {
                return None;
            }
            continue;
        }
        let (enters, leaves) = ((low - a[k]) / step, (high - a[k]) / step);
        from = from.max(enters.min(leaves));
        to = to.min(enters.max(leaves));
    }
    let at = |t: f64| [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
    // An end inside stays the very number it was, so that pieces join.
    (from <= to).then(|| {
        (
            if from == 0.0 { a } else { at(from) },
            if to == 1.0 { b } else { at(to) },
        )
    })
}

/// The part of a polygon inside the frame (Sutherland and Hodgman).
pub(super) fn cut_polygon(points: &[Place], [left, top, right, bottom]: Sides) -> Vec<Place> {
    let mut shape = points.to_vec();
    for (k, edge, sign) in [
        (0, left, 1.0),
        (0, right, -1.0),
        (1, top, 1.0),
        (1, bottom, -1.0),
    ] {
        let inside = |p: &Place| sign * (p[k] - edge) >= 0.0;
        let mut cut = Vec::new();
        for (i, b) in shape.iter().enumerate() {
            let a = &shape[(i + shape.len() - 1) % shape.len()];
            if inside(a) != inside(b) {
                let t = (edge - a[k]) / (b[k] - a[k]);
                cut.push([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]);
            }
            if inside(b) {
                cut.push(*b);
            }
        }
        shape = cut;
    }
    shape
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_cannot_break_out_of_its_place() {
        assert_eq!(
            escaped("<a href=\"x\">&'\u{7}"),
            "&lt;a href=&quot;x&quot;&gt;&amp;&#39;\\u{7}"
        );
    }

    #[test]
    fn words_are_as_wide_as_they_are_drawn() {
        for text in [
            "mean displacement u_0/rho",
            "p\u{303} = 10^{\u{2212}3}",
            "WWW iii",
        ] {
            let mut sheet = Sheet::new(900.0, 60.0);
            let wide = width(&set(text), 30.0);
            sheet.words([450.0, 30.0], &set(text), 30.0, [0; 3], Anchor::Middle);
            let picture = sheet.pixels().expect("a picture");
            let columns = picture
                .enumerate_pixels()
                .filter(|(.., p)| p.0[0] < 128)
                .map(|(x, ..)| f64::from(x) / 2.0);
            let (left, right) =
                columns.fold((f64::INFINITY, 0.0_f64), |(a, b), x| (a.min(x), b.max(x)));
            // Letters stand a little inside their widths.
            let (before, after) = (left - (450.0 - 0.5 * wide), 450.0 + 0.5 * wide - right);
            assert!(
                (-1.0..6.0).contains(&before) && (-1.0..6.0).contains(&after),
                "{text}: {before} {after}"
            );
        }
    }

    const FRAME: Sides = [0.0, 0.0, 10.0, 10.0];

    #[test]
    fn a_line_is_cut_at_the_frame_and_broken_where_it_has_no_place() {
        let points = [
            Some([-5.0, 5.0]),
            Some([5.0, 5.0]),
            Some([5.0, 20.0]),
            None,
            Some([1.0, 1.0]),
            Some([2.0, 1.0]),
        ];
        assert_eq!(
            cut_line(points.into_iter(), FRAME),
            [
                vec![[0.0, 5.0], [5.0, 5.0], [5.0, 10.0]],
                vec![[1.0, 1.0], [2.0, 1.0]]
            ]
        );
        assert!(cut_line([Some([-1.0, 5.0]), Some([5.0, 50.0])].into_iter(), FRAME).is_empty());
    }

    #[test]
    fn a_line_across_the_whole_frame_is_seen_though_no_point_is_inside() {
        assert_eq!(
            cut_line(
                [Some([-10.0, -10.0]), Some([20.0, 20.0])].into_iter(),
                FRAME
            ),
            [vec![[0.0, 0.0], [10.0, 10.0]]]
        );
    }

    #[test]
    fn an_area_keeps_what_is_inside() {
        let cut = cut_polygon(&[[5.0, 5.0], [15.0, 5.0], [15.0, 15.0], [5.0, 15.0]], FRAME);
        let next = cut.iter().cycle().skip(1);
        let area: f64 = cut
            .iter()
            .zip(next)
            .map(|(a, b)| 0.5 * (a[0] * b[1] - b[0] * a[1]))
            .sum();
        assert!((area.abs() - 25.0).abs() < 1e-12, "{cut:?}");
        assert!(cut_polygon(&[[-5.0, -5.0], [-1.0, -5.0], [-1.0, -1.0]], FRAME).is_empty());
    }
}
