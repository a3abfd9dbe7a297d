//! The chart drawn, once for SVG and PNG: error of the dissipated energy against transforms and against processor time, log-log.

use super::marks::{colour, outline};
use super::words::{bounds, name, power};
use crate::experiment::chart::{Chart, Judged, Model, Point, Verdict};
use crate::experiment::plan::Reduction;
use crate::storage::picture::{register_font, write_png};
use crate::storage::{Failure, files, line};
use image::RgbImage;
use plotters::coord::Shift;
use plotters::coord::combinators::LogCoord;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::error::Error;
use std::ops::Range;
use std::path::Path;

/// Size of the drawing in units; the SVG has one pixel a unit.
const SIZE: (u32, u32) = (1200, 700);
/// Pixels drawn for each of the PNG's along a side (which smooths the edges), and pixels of the PNG for each unit.
const OVERSAMPLING: u32 = 2;
const PIXELS: f64 = 1.5;

/// Height of the strip at the top, as a factor of the error's axis.
const STRIP: f64 = 5.0;

pub(super) const INK: RGBColor = RGBColor(0x22, 0x22, 0x22);
const GRID: RGBColor = RGBColor(0xe6, 0xe6, 0xe6);
const STRIPE: RGBColor = RGBColor(0xf3, 0xf3, 0xf3);
const FLOOR: RGBColor = RGBColor(0x8c, 0x8c, 0x8c);
pub(super) const FRONT: RGBColor = RGBColor(0xe8, 0xc8, 0x60);

pub(super) type Drawn = Result<(), Box<dyn Error>>;
type Panel<'a, DB> = ChartContext<'a, DB, Cartesian2d<LogCoord<f64>, LogCoord<f64>>>;

/// A cost: its name on the axis, its value, and which rows are on its front.
type Cost = (&'static str, fn(&Judged) -> f64, fn(&Judged) -> bool);

const COSTS: [Cost; 2] = [
    ("Fourier transforms of the loop", |row| row.transforms as f64, |row| row.pareto_transforms),
    ("processor time of the loop / s", |row| row.processor_seconds, |row| row.pareto_time),
];

/// Writes the chart as an SVG.
///
/// # Errors
/// A file that cannot be written.
pub fn write_chart_svg(path: &Path, chart: &Chart, title: &str) -> Result<(), Failure> {
    let mut text = String::new();
    let backend = SVGBackend::with_string(&mut text, SIZE);
    Plot::new(chart, title, 1.0).draw(&backend.into_drawing_area()).map_err(|error| Failure::write(path, error))?;
    files::write_whole(path, text.as_bytes())
}

/// Writes the chart as a PNG of 1800 x 1050 pixels.
///
/// # Errors
/// A file that cannot be written.
pub fn write_chart_png(path: &Path, chart: &Chart, title: &str) -> Result<(), Failure> {
    let scale = PIXELS * f64::from(OVERSAMPLING);
    let (width, height) = ((f64::from(SIZE.0) * scale) as u32, (f64::from(SIZE.1) * scale) as u32);
    let mut image = RgbImage::new(width, height);
    let backend = BitMapBackend::with_buffer(&mut image, (width, height));
    Plot::new(chart, title, scale).draw(&backend.into_drawing_area()).map_err(|error| Failure::write(path, error))?;
    write_png(path, &image::imageops::thumbnail(&image, width / OVERSAMPLING, height / OVERSAMPLING))
}

pub(super) struct Plot<'a> {
    pub(super) chart: &'a Chart,
    title: String,
    /// Below this error nothing is told apart.
    floor: f64,
    errors: Range<f64>,
    /// Everything that failed, each once; the picture calls them a, b, c.
    pub(super) failures: Vec<String>,
    scale: f64,
}

impl<'a> Plot<'a> {
    fn new(chart: &'a Chart, title: &str, scale: f64) -> Self {
        register_font();
        let title = line(title).chars().take(90).collect();
        let floor = chart.reference.as_ref().map_or(f64::NAN, |r| r.errors.dissipated_energy);
        let floor = if floor.is_finite() { floor.max(1e-12) } else { 1e-12 };
        let errors = chart.rows.iter().map(|row| row.errors.dissipated_energy.max(floor));
        let (least, most) = bounds(errors.chain([floor].into_iter().filter(|f| *f > 1e-12)));
        let mut failures = Vec::new();
        for row in &chart.rows {
            if let Verdict::Failed { what, .. } = &row.verdict
                && !failures.contains(what)
            {
                failures.push(what.clone());
            }
        }
        // Room above for what has no error to show.
        Self { chart, title, floor, errors: least / 4.0..most * 2.0 * STRIP, failures, scale }
    }

    pub(super) fn px(&self, units: f64) -> i32 {
        (units * self.scale).round() as i32
    }

    pub(super) fn stroke(&self, colour: RGBColor, width: f64) -> ShapeStyle {
        colour.stroke_width((width * self.scale).round().max(1.0) as u32)
    }

    pub(super) fn text(&self, size: f64, colour: RGBColor) -> TextStyle<'static> {
        ("sans-serif", size * self.scale).into_font().color(&colour)
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Drawn
    where
        DB::ErrorType: 'static,
    {
        area.fill(&WHITE)?;
        let title = format!("Speed against accuracy: {}", self.title);
        area.draw_text(&title, &self.text(22.0, INK), (self.px(24.0), self.px(14.0)))?;
        area.draw_text(&self.caption(), &self.text(14.0, INK), (self.px(24.0), self.px(46.0)))?;
        self.legend(area)?;
        let (_, below) = area.split_vertically(self.px(self.head()));
        let panels = below.split_evenly((1, 2));
        for (panel, cost) in panels.iter().zip(&COSTS) {
            self.panel(panel, cost)?;
        }
        area.present()?;
        Ok(())
    }

    fn panel<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>, cost: &Cost) -> Drawn
    where
        DB::ErrorType: 'static,
    {
        let (least, most) = bounds(self.chart.rows.iter().map(cost.1));
        let mut panel = ChartBuilder::on(area)
            .margin(self.px(10.0))
            .margin_right(self.px(18.0))
            .x_label_area_size(self.px(52.0))
            .y_label_area_size(self.px(70.0))
            .build_cartesian_2d((least / 4.0..most * 3.0).log_scale(), self.errors.clone().log_scale())?;
        panel
            .configure_mesh()
            .x_desc(cost.0)
            .y_desc("relative error of dissipated energy")
            .axis_desc_style(self.text(15.0, INK))
            .label_style(self.text(13.0, INK))
            .x_label_formatter(&|value| power(*value))
            .y_label_formatter(&|value| power(*value))
            .x_labels(6)
            .y_labels(8)
            .axis_style(self.stroke(INK, 1.0))
            .bold_line_style(self.stroke(GRID, 1.0))
            .light_line_style(TRANSPARENT)
            .set_all_tick_mark_size(self.px(4.0))
            .draw()?;
        self.strip(&mut panel, least / 4.0, most * 3.0)?;
        if self.floor > 1e-12 {
            panel.draw_series([self.dashed(vec![(least / 4.0, self.floor), (most * 3.0, self.floor)])])?;
        }
        self.front(&mut panel, cost, most * 3.0)?;
        for row in &self.chart.rows {
            self.row(&mut panel, row, cost)?;
        }
        self.words(&mut panel, cost)
    }

    /// The place of loops that did not close.
    fn strip<DB: DrawingBackend>(&self, panel: &mut Panel<'_, DB>, left: f64, right: f64) -> Drawn
    where
        DB::ErrorType: 'static,
    {
        let bottom = self.errors.end / STRIP;
        panel.draw_series([Rectangle::new([(left, self.errors.end), (right, bottom)], STRIPE.filled())])?;
        let style = self.text(11.0, FLOOR).pos(Pos::new(HPos::Right, VPos::Bottom));
        panel.draw_series([
            EmptyElement::at((right, bottom)) + Text::new("loop not closed", (self.px(-6.0), self.px(-4.0)), style)
        ])?;
        Ok(())
    }

    /// Where a row is drawn: below the reference's own error at that error, without an error in the strip at the top.
    fn place(&self, row: &Judged, cost: &Cost) -> Option<(f64, f64)> {
        let error = row.errors.dissipated_energy;
        let x = (cost.1)(row);
        (x.is_finite() && x > 0.0)
            .then(|| (x, if error.is_finite() { error.max(self.floor) } else { self.errors.end / STRIP.sqrt() }))
    }

    /// The front as stairs: to the right of a point nothing cheaper is better.
    fn front<DB: DrawingBackend>(&self, panel: &mut Panel<'_, DB>, cost: &Cost, end: f64) -> Drawn
    where
        DB::ErrorType: 'static,
    {
        let mut points: Vec<_> = self.chart.rows.iter().filter(|r| (cost.2)(r)).filter_map(|r| self.place(r, cost)).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let Some(last) = points.last().copied() else { return Ok(()) };
        let corners = points.windows(2).flat_map(|w| [w[0], (w[1].0, w[0].1)]);
        let stairs: Vec<_> = corners.chain([last, (end, last.1)]).collect();
        panel.draw_series([PathElement::new(stairs, self.stroke(FRONT, 5.0))])?;
        Ok(())
    }

    fn row<DB: DrawingBackend>(&self, panel: &mut Panel<'_, DB>, row: &Judged, cost: &Cost) -> Drawn
    where
        DB::ErrorType: 'static,
    {
        let Some(place) = self.place(row, cost) else { return Ok(()) };
        let size = if row.point.model == Model::Walk(Reduction::Quarter) { 4.0 } else { 6.0 };
        if row.verdict == Verdict::Done {
            panel.draw_series([EmptyElement::at(place) + self.filled(&row.point, size)])?;
        } else {
            panel.draw_series([EmptyElement::at(place) + self.hollow(&row.point, size)])?;
        }
        if row.errors.dissipated_energy < self.floor {
            let stem = vec![(0, self.px(size)), (0, self.px(size + 9.0))];
            panel.draw_series([EmptyElement::at(place) + PathElement::new(stem, self.stroke(colour(&row.point), 1.5))])?;
        }
        if row.plan {
            panel.draw_series([EmptyElement::at(place) + Circle::new((0, 0), self.px(10.0), self.stroke(INK, 2.0))])?;
        }
        if row.paper_budget {
            panel.draw_series([EmptyElement::at(place) + self.square(10.0)])?;
        }
        Ok(())
    }

    /// The letter of what failed beside its mark; the mesh and the step of what is on the front.
    fn words<DB: DrawingBackend>(&self, panel: &mut Panel<'_, DB>, cost: &Cost) -> Drawn
    where
        DB::ErrorType: 'static,
    {
        let mut told = Vec::new();
        for row in &self.chart.rows {
            let Some(place) = self.place(row, cost) else { continue };
            if let Verdict::Failed { what, .. } = &row.verdict
                && let Some(letter) = self.failures.iter().position(|known| known == what)
            {
                let style = self.text(11.0, colour(&row.point)).pos(Pos::new(HPos::Left, VPos::Center));
                panel.draw_series([EmptyElement::at(place)
                    + Text::new(
                        name(letter),
                        (self.px(if row.plan || row.paper_budget { 15.0 } else { 9.0 }), self.px(-4.0)),
                        style,
                    )])?;
            }
            let settings = (row.point.points, row.point.step);
            if (cost.2)(row) && !told.contains(&settings) {
                told.push(settings);
                let word = format!("n = {}, step {}", row.point.points, row.point.step);
                let style = self.text(11.0, INK).pos(Pos::new(HPos::Right, VPos::Top));
                panel.draw_series([EmptyElement::at(place) + Text::new(word, (self.px(-6.0), self.px(7.0)), style)])?;
            }
        }
        Ok(())
    }

    fn corners(&self, point: &Point, size: f64) -> Vec<(i32, i32)> {
        outline(point).into_iter().map(|(x, y)| (self.px(size * x), self.px(size * y))).collect()
    }

    pub(super) fn filled(&self, point: &Point, size: f64) -> Polygon<(i32, i32)> {
        Polygon::new(self.corners(point, size), colour(point).filled())
    }

    fn hollow(&self, point: &Point, size: f64) -> PathElement<(i32, i32)> {
        let mut corners = self.corners(point, size);
        corners.extend_from_within(..1);
        PathElement::new(corners, self.stroke(colour(point), 1.6))
    }

    pub(super) fn square(&self, half: f64) -> Rectangle<(i32, i32)> {
        Rectangle::new([(self.px(-half), self.px(-half)), (self.px(half), self.px(half))], self.stroke(INK, 2.0))
    }

    pub(super) fn dashed<P: Clone>(&self, points: Vec<P>) -> DashedPathElement<std::vec::IntoIter<P>, i32> {
        DashedPathElement::new(points, self.px(6.0), self.px(4.0), self.stroke(FLOOR, 1.5))
    }
}
