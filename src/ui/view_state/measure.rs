//! Measurements beside the walk, and what follows from them.

use super::ViewState;
use crate::experiment::chart::{Effort, Model};
use crate::experiment::part::{Part, Road};
use crate::experiment::scene::{Points, Range};
use crate::ui::action::Measurement;
use crate::worker::protocol::{Command, Errand};

/// Processor seconds of a full chart.
const FULL: f64 = 120.0;

impl ViewState {
    /// Begins a measurement; one under way is dropped.
    pub fn measure(&mut self, what: Measurement) {
        self.measuring = Some(what);
        let scene = self.scene.clone();
        let errand = match what {
            Measurement::TimeSteps => {
                self.time_steps = None;
                Errand::TimeSteps { scene, turn: self.limits.0 }
            }
            Measurement::QuickChart | Measurement::FullChart => {
                self.chart = None;
                let effort = if what == Measurement::QuickChart { Effort::Quick } else { Effort::Full { seconds: FULL } };
                Errand::Chart { scene, effort }
            }
        };
        self.outbox.push(Command::Measure { run: self.run, errand });
    }

    /// Drops the measurement under way.
    pub fn stop_measuring(&mut self) {
        self.measuring = None;
        self.outbox.push(Command::StopMeasuring);
    }

    /// Makes the settings of a row of the chart the scene's: method, mesh, step. The chart stays: it is of the same loop.
    pub fn use_chart_row(&mut self, index: usize) {
        let chart = self.chart.clone();
        let Some(row) = chart.as_ref().and_then(|chart| chart.rows.get(index)) else { return };
        let point = row.point;
        let mut scene = (*self.scene).clone();
        scene.law.range = Range::Length(self.model.law.range);
        scene.cell.points = if point.line { Points::Line(point.points) } else { Points::Square(point.points) };
        scene.drive.step = point.step;
        self.edit_scene(scene);
        self.set_method(point.method);
        self.set_road(match point.model {
            Road::WHOLE => Some(Road::WHOLE),
            Road::QUARTER => Some(Road::QUARTER),
            _ => None,
        });
        self.chart = chart;
        self.notice = Some(match point.model {
            Road::Walk(_) => format!("the scene now runs as {point}"),
            _ => format!("the scene now runs as {point}; the walk solves what is shown, the atlas says what is ahead"),
        });
    }
}
