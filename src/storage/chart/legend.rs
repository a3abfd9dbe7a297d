//! What stands above the panels of the chart: caption, legend, and what failed.

use super::plot::{Drawn, FRONT, INK, Plot};
use super::words::{name, number, short};
use crate::experiment::chart::{Model, Point};
use crate::solver::method::MethodKind;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Where the lines begin that say what failed, and their distance.
const FAILURES: f64 = 134.0;
const LINE: f64 = 16.0;

impl Plot<'_> {
    /// Height of all this, in units.
    pub(super) fn head(&self) -> f64 {
        FAILURES + LINE * self.failure_lines().len() as f64
    }

    pub(super) fn caption(&self) -> String {
        let skipped = match self.chart.skipped.len() {
            0 => String::new(),
            n => format!("  {n} points were left out as too dear."),
        };
        let cut = if self.chart.cancelled { "  Interrupted: what was measured by then." } else { "" };
        match &self.chart.reference {
            None => format!("Interrupted before there was a reference.{skipped}"),
            Some(reference) => format!(
                "Reference: {} \u{3b3} lost, by n = {} and steps of {}; its own error {:.0e}.{skipped}{cut}",
                number(reference.dissipated_energy),
                reference.point().points,
                reference.point().step,
                reference.errors.dissipated_energy,
            ),
        }
    }

    /// What the letters mean, in lines that fit.
    fn failure_lines(&self) -> Vec<String> {
        let mut lines = Vec::new();
        for (i, what) in self.failures.iter().enumerate() {
            let word = format!("{}  {}     ", name(i), short(what));
            match lines.last_mut() {
                None => lines.push(format!("hollow: failed     {word}")),
                Some(line) if line.chars().count() + word.chars().count() > 180 => lines.push(word),
                Some(line) => line.push_str(&word),
            }
        }
        lines
    }

    /// A point of every kind that has its own mark, in the order of the legend.
    fn roads(&self) -> Vec<Point> {
        let mut roads: Vec<Point> = Vec::new();
        for row in &self.chart.rows {
            if !roads.iter().any(|known| known.road() == row.point.road()) {
                roads.push(row.point);
            }
        }
        roads.sort_by_key(|point| (point.model != Model::Atlas, MethodKind::ALL.iter().position(|method| *method == point.method)));
        roads
    }

    pub(super) fn legend<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Drawn
    where
        DB::ErrorType: 'static,
    {
        let middle = self.text(14.0, INK).pos(Pos::new(HPos::Left, VPos::Center));
        let mut x = 34.0;
        for point in self.roads() {
            let at = (self.px(x), self.px(84.0));
            area.draw(&(EmptyElement::at(at) + self.filled(&point, 6.0)))?;
            area.draw_text(point.road(), &middle, (self.px(x + 13.0), self.px(84.0)))?;
            x += 40.0 + 7.6 * point.road().chars().count() as f64;
        }
        let y = self.px(110.0);
        let words = [
            (34.0, "small: quarter of the cell"),
            (270.0, "Pareto front"),
            (402.0, "the plan's own choice"),
            (592.0, "the paper's budget"),
            (766.0, "reference's own error (with a stem: below it)"),
        ];
        for (x, word) in words {
            area.draw_text(word, &middle, (self.px(x + 13.0), y))?;
        }
        area.draw(&Circle::new((self.px(34.0), y), self.px(3.5), INK.filled()))?;
        let line = |x: f64| vec![(self.px(x - 18.0), y), (self.px(x + 6.0), y)];
        area.draw(&PathElement::new(line(270.0), self.stroke(FRONT, 5.0)))?;
        area.draw(&Circle::new((self.px(402.0), y), self.px(8.0), self.stroke(INK, 2.0)))?;
        area.draw(&(EmptyElement::at((self.px(592.0), y)) + self.square(8.0)))?;
        area.draw(&self.dashed(line(766.0)))?;
        let style = self.text(12.0, INK).pos(Pos::new(HPos::Left, VPos::Center));
        for (i, words) in self.failure_lines().iter().enumerate() {
            area.draw_text(words, &style, (self.px(26.0), self.px(FAILURES + LINE * i as f64)))?;
        }
        Ok(())
    }
}
