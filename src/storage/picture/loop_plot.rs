//! The loop as a diagram: mean stress against mean displacement, drawn once for SVG and PNG.

use super::write_png;
use crate::experiment::plan::promise;
use crate::experiment::record::{Branch, JumpRecord, LoopRecord};
use crate::paper::extent::Scale;
use crate::paper::figure::Axis;
use crate::paper::ticks::{Tick, ticks};
use crate::paper::typeset::plain;
use crate::physics::law::Law;
use crate::storage::{Failure, files, line};
use image::RgbImage;
use plotters::coord::Shift;
use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint};
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::error::Error;
use std::ops::Range;
use std::path::Path;
use std::sync::Once;

use super::curves::Curves;

/// Size of the drawing in units; the SVG has one pixel a unit.
const SIZE: (u32, u32) = (1000, 625);
/// Pixels of the PNG, and pixels drawn for each of them along a side (which smooths the edges).
const PNG_SIZE: (u32, u32) = (1600, 1000);
const OVERSAMPLING: u32 = 2;

const APPROACH: RGBColor = RGBColor(0x1f, 0x5f, 0xb4);
const RETRACTION: RGBColor = RGBColor(0xc8, 0x2a, 0x2a);
const FLAT: RGBColor = RGBColor(0x8c, 0x8c, 0x8c);
const INK: RGBColor = RGBColor(0x22, 0x22, 0x22);
const LOSS: RGBColor = RGBColor(0xe8, 0xc8, 0x60);

type Drawn = Result<(), Box<dyn Error>>;
type Chart<'a, DB> = ChartContext<'a, DB, Cartesian2d<Ticks, Ticks>>;

/// Writes the loop as an SVG; `error` is the relative error to be stated of its loss.
///
/// # Errors
/// A file that cannot be written.
pub fn write_loop_svg(path: &Path, record: &LoopRecord, law: &Law, title: &str, error: Option<f64>) -> Result<(), Failure> {
    let mut text = String::new();
    let plot = Plot::new(record, law, title, error).scaled(1.0);
    let backend = SVGBackend::with_string(&mut text, SIZE);
    plot.draw(&backend.into_drawing_area()).map_err(|error| Failure::write(path, error))?;
    files::write_whole(path, text.as_bytes())
}

/// Writes the loop as a PNG of 1600 x 1000 pixels; `error` is the relative error to be stated of its loss.
///
/// # Errors
/// A file that cannot be written.
pub fn write_loop_png(path: &Path, record: &LoopRecord, law: &Law, title: &str, error: Option<f64>) -> Result<(), Failure> {
    let (width, height) = (PNG_SIZE.0 * OVERSAMPLING, PNG_SIZE.1 * OVERSAMPLING);
    let mut image = RgbImage::new(width, height);
    let plot = Plot::new(record, law, title, error).scaled(f64::from(width) / f64::from(SIZE.0));
    let backend = BitMapBackend::with_buffer(&mut image, (width, height));
    plot.draw(&backend.into_drawing_area()).map_err(|error| Failure::write(path, error))?;
    write_png(path, &image::imageops::thumbnail(&image, PNG_SIZE.0, PNG_SIZE.1))
}

/// Makes the built-in font known to plotters, once.
pub(in crate::storage) fn register_font() {
    static ONCE: Once = Once::new();
    static FONT: &[u8] = include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/assets/DejaVuSans.ttf"));
    ONCE.call_once(|| {
        // A font that cannot be read shows as a drawing error at the first text.
        let _ = plotters::style::register_font("sans-serif", FontStyle::Normal, FONT);
    });
}

/// An axis with its ticks.
#[derive(Clone)]
struct Ticks {
    range: Range<f64>,
    list: Vec<Tick>,
    /// Power of ten by which the numbers are to be multiplied.
    factor: i32,
}

impl Ticks {
    fn new(range: &Range<f64>) -> Self {
        let (list, factor) = ticks(&Scale::new(&Axis::linear("").from_to(range.start, range.end), std::iter::empty()));
        Self { range: range.clone(), list, factor }
    }

    fn value(&self, tick: &Tick) -> f64 {
        self.range.start + tick.at * (self.range.end - self.range.start)
    }

    fn word(&self, value: f64) -> String {
        let near = |tick: &&Tick| (self.value(tick) - value).abs();
        let nearest = self.list.iter().min_by(|a, b| near(a).total_cmp(&near(b)));
        nearest.and_then(|tick| tick.label.clone()).unwrap_or_default()
    }

    fn named(&self, name: &str) -> String {
        if self.factor == 0 { name.to_owned() } else { plain(&format!("{name}  (\u{d7}10^{{{}}})", self.factor)) }
    }
}

impl Ranged for Ticks {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (start, end): (i32, i32)) -> i32 {
        let share = (value - self.range.start) / (self.range.end - self.range.start);
        (f64::from(start) + share * f64::from(end - start)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.list.iter().map(|tick| self.value(tick)).collect()
    }

    fn range(&self) -> Range<f64> {
        self.range.clone()
    }
}

struct Plot<'a> {
    curves: Curves,
    jumps: &'a [JumpRecord],
    law: &'a Law,
    title: String,
    caption: String,
    scale: f64,
}

impl<'a> Plot<'a> {
    fn new(record: &'a LoopRecord, law: &'a Law, title: &str, error: Option<f64>) -> Self {
        register_font();
        let curves = Curves::new(record, law);
        let caption = caption(record, law, error);
        let title = line(title).chars().take(90).collect();
        Self { curves, jumps: &record.jumps, law, title, caption, scale: 1.0 }
    }

    fn scaled(self, scale: f64) -> Self {
        Self { scale, ..self }
    }

    /// A length of the drawing in pixels.
    fn px(&self, units: f64) -> i32 {
        (units * self.scale).round() as i32
    }

    fn stroke(&self, colour: RGBColor, width: f64) -> ShapeStyle {
        colour.stroke_width((width * self.scale).round().max(1.0) as u32)
    }

    fn text(&self, size: f64, colour: RGBColor) -> TextStyle<'static> {
        ("sans-serif", size * self.scale).into_font().color(&colour)
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Drawn
    where
        DB::ErrorType: 'static,
    {
        area.fill(&WHITE)?;
        area.draw_text(&self.title, &self.text(23.0, INK), (self.px(24.0), self.px(16.0)))?;
        area.draw_text(&self.caption, &self.text(16.0, INK), (self.px(24.0), self.px(50.0)))?;
        let (_, below) = area.split_vertically(self.px(78.0));
        let [x, y] = [&self.curves.window.x, &self.curves.window.y].map(Ticks::new);
        let mut chart = ChartBuilder::on(&below)
            .margin(self.px(12.0))
            .margin_right(self.px(26.0))
            .x_label_area_size(self.px(56.0))
            .y_label_area_size(self.px(78.0))
            .build_cartesian_2d(x.clone(), y.clone())?;
        self.mesh(&mut chart, &x, &y)?;
        self.areas_and_curves(&mut chart)?;
        for jump in self.jumps {
            self.jump(&mut chart, jump)?;
        }
        self.names(&mut chart)?;
        self.legend(&mut chart)?;
        area.present()?;
        Ok(())
    }

    fn mesh<DB: DrawingBackend>(&self, chart: &mut Chart<'_, DB>, x: &Ticks, y: &Ticks) -> Drawn
    where
        DB::ErrorType: 'static,
    {
        chart
            .configure_mesh()
            .x_desc(x.named("mean displacement u\u{2080} / \u{3c1}  (\u{3c1}: range of the law)"))
            .y_desc(y.named("mean stress \u{3c3} / \u{3c3}_max  (tension positive)"))
            .axis_desc_style(self.text(17.0, INK))
            .label_style(self.text(15.0, INK))
            .x_label_formatter(&|value| x.word(*value))
            .y_label_formatter(&|value| y.word(*value))
            .axis_style(self.stroke(INK, 1.0))
            .bold_line_style(RGBColor(0xe6, 0xe6, 0xe6).stroke_width(self.px(1.0).max(1) as u32))
            .light_line_style(TRANSPARENT)
            .set_all_tick_mark_size(self.px(5.0))
            .draw()?;
        let x = &self.curves.window.x;
        chart.draw_series([PathElement::new(vec![(x.start, 0.0), (x.end, 0.0)], self.stroke(RGBColor(0xb4, 0xb4, 0xb4), 1.0))])?;
        Ok(())
    }

    fn areas_and_curves<DB: DrawingBackend>(&self, chart: &mut Chart<'_, DB>) -> Drawn
    where
        DB::ErrorType: 'static,
    {
        for strip in &self.curves.loss {
            chart.draw_series([Polygon::new(strip.clone(), LOSS.mix(0.45).filled())])?;
        }
        if let Some(flat) = &self.curves.flat {
            chart.draw_series([self.dashed(flat.clone(), self.stroke(FLAT, 1.5), (5.0, 4.0))])?;
        }
        for line in self.curves.lines_of(Branch::Approach) {
            chart.draw_series([PathElement::new(line.points.clone(), self.stroke(APPROACH, 3.0))])?;
        }
        for line in self.curves.lines_of(Branch::Retraction) {
            chart.draw_series([self.dashed(line.points.clone(), self.stroke(RETRACTION, 3.0), (11.0, 5.0))])?;
        }
        Ok(())
    }

    fn dashed<P: Clone>(
        &self,
        points: Vec<P>,
        style: ShapeStyle,
        (dash, space): (f64, f64),
    ) -> DashedPathElement<std::vec::IntoIter<P>, i32> {
        DashedPathElement::new(points, self.px(dash), self.px(space), style)
    }

    /// A thin dashed line from the stress before to the stress after, with an arrow head at its end.
    fn jump<DB: DrawingBackend>(&self, chart: &mut Chart<'_, DB>, jump: &JumpRecord) -> Drawn
    where
        DB::ErrorType: 'static,
    {
        let sigma_max = self.law.traction_max();
        let (x, from, to) =
            (jump.mean_displacement / self.law.range, jump.stress_before / sigma_max, jump.stress_after / sigma_max);
        if !(x.is_finite() && from.is_finite() && to.is_finite()) {
            return Ok(());
        }
        let colour = colour_of(jump.branch);
        chart.draw_series([self.dashed(vec![(x, from), (x, to)], self.stroke(colour, 1.5), (4.0, 3.0))])?;
        let (wide, long) = (self.px(4.5), self.px(11.0));
        let back = if to > from { long } else { -long };
        let head = Polygon::new(vec![(0, 0), (-wide, back), (wide, back)], colour.filled());
        chart.draw_series([EmptyElement::at((x, to)) + head])?;
        Ok(())
    }

    /// The pattern's name beside each piece of curve that is long enough to be told apart.
    fn names<DB: DrawingBackend>(&self, chart: &mut Chart<'_, DB>) -> Drawn
    where
        DB::ErrorType: 'static,
    {
        for branch in [Branch::Approach, Branch::Retraction] {
            for (place, word, rises) in self.curves.names(branch) {
                // Below the approach and above the retraction, on the side from which the curve bends away.
                let below = branch == Branch::Approach;
                let (h, dx) = if below == rises { (HPos::Left, 7.0) } else { (HPos::Right, -7.0) };
                let (v, dy) = if below { (VPos::Top, 5.0) } else { (VPos::Bottom, -5.0) };
                let style = self.text(15.0, colour_of(branch)).pos(Pos::new(h, v));
                chart.draw_series([EmptyElement::at(place) + Text::new(word, (self.px(dx), self.px(dy)), style)])?;
            }
        }
        Ok(())
    }

    fn legend<DB: DrawingBackend>(&self, chart: &mut Chart<'_, DB>) -> Drawn
    where
        DB::ErrorType: 'static,
    {
        let area = chart.plotting_area().strip_coord_spec();
        let (width, _) = area.dim_in_pixel();
        let mut entries = vec![("approach", APPROACH, 3.0, None), ("retraction", RETRACTION, 3.0, Some((11.0, 5.0)))];
        if !self.jumps.is_empty() {
            entries.push(("jump", APPROACH, 1.5, Some((4.0, 3.0))));
        }
        if self.curves.flat.is_some() {
            entries.push(("flat state", FLAT, 1.5, Some((5.0, 4.0))));
        }
        let left = width as i32 - self.px(172.0);
        let height = self.px(12.0 + 24.0 * entries.len() as f64);
        let frame = [(left - self.px(12.0), self.px(8.0)), (width as i32 - self.px(8.0), self.px(8.0) + height)];
        area.draw(&Rectangle::new(frame, WHITE.mix(0.85).filled()))?;
        area.draw(&Rectangle::new(frame, self.stroke(RGBColor(0xd0, 0xd0, 0xd0), 1.0)))?;
        for (i, (word, colour, stroke, dashes)) in entries.into_iter().enumerate() {
            let y = self.px(26.0 + 24.0 * i as f64);
            let line = vec![(left, y), (left + self.px(46.0), y)];
            let style = self.stroke(colour, stroke);
            match dashes {
                None => area.draw(&PathElement::new(line, style))?,
                Some(dashes) => area.draw(&self.dashed(line, style, dashes))?,
            }
            let middle = self.text(15.0, INK).pos(Pos::new(HPos::Left, VPos::Center));
            area.draw_text(word, &middle, (left + self.px(56.0), y))?;
        }
        Ok(())
    }
}

fn colour_of(branch: Branch) -> RGBColor {
    match branch {
        Branch::Approach => APPROACH,
        Branch::Retraction => RETRACTION,
    }
}

/// The numbers of the loop in one line.
fn caption(record: &LoopRecord, law: &Law, error: Option<f64>) -> String {
    let jumps = match record.jumps.is_empty() {
        true => "no jumps".to_owned(),
        false => format!("{}, releasing {} \u{3b3}", record.tally(), energy(record.released_energy_sum())),
    };
    let ledger = record.ledger(law.surface_energy);
    let loss = match (ledger.dissipated_energy(), &ledger.open) {
        _ if record.states.is_empty() => "No states were computed".to_owned(),
        (Some(loss), _) => {
            let accuracy = promise(error);
            format!("Dissipated energy {} \u{3b3} per area and loop ({accuracy})", energy(loss))
        }
        (None, Some(open)) => format!("Loop not closed: {}", open.reason),
        (None, None) => "Dissipated energy (not available)".to_owned(),
    };
    format!("{loss};  {jumps}.")
}

/// An energy with four digits, and zero where rounding leaves nothing.
fn energy(value: f64) -> String {
    if !value.is_finite() {
        return "(not available)".to_owned();
    }
    let text = format!("{value:.4}");
    if text == "-0.0000" { "0.0000".to_owned() } else { text.replace('-', "\u{2212}") }
}
