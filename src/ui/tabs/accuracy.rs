//! Speed against accuracy: every method on the scene's loop, one mark each, and what nothing else
//! beats.

use super::{STAYS, Tab, Title, Update, doing, take_in};
use crate::plot::chart_panel::{ChartPanel, Cost, headline};
use crate::plot::panel::Panel;
use crate::scene::{Model, Range, Strategy};
use crate::study::chart::{Effort, Judged, Point, Verdict};
use crate::ui::action::Action;
use crate::ui::diagram;
use crate::ui::view_state::ViewState;
use crate::ui::widgets::{described, progress, radio_value};
use crate::ui::words::explain;
use crate::worker::background::{self, ChartSoFar};
use crate::worker::job::Job;
use egui::{PopupAnchor, RichText, Tooltip, Ui};

/// A pointer this near to a mark means it, in screen points.
const NEAR: f32 = 10.0;

/// Processor seconds of a full chart.
const FULL: f64 = 120.0;

/// The tab.
#[derive(Default)]
pub struct Accuracy {
    /// The measurement, and of which model.
    chart: Option<(Model, Job<ChartSoFar>)>,
    cost: Cost,
    asked: Option<Asked>,
}

/// What was asked of the tab.
enum Asked {
    Measure(Effort),
    /// To make the settings of this point of the chart the scene's.
    Use(Point),
}

impl Tab for Accuracy {
    fn title(&self) -> Title {
        let what = "what every method costs, and how far off it is";
        Title {
            short: "Accuracy",
            ..Title::new("Speed and accuracy", what)
        }
    }

    fn show(&mut self, ui: &mut Ui, _: &ViewState, _: &mut Vec<Action>) {
        self.controls(ui);
        if let Some(chart) = self.chart.as_ref().and_then(|(_, job)| job.so_far.as_ref()) {
            if let Some(row) = clicked(ui, chart, self.cost) {
                self.asked = Some(Asked::Use(row.point));
            }
        } else {
            let words = "Every method on this scene's loop, against a finer solution. Quick takes \
                half a minute.";
            ui.label(RichText::new(words).weak());
        }
    }

    fn panels(&self, _: &ViewState) -> Vec<Panel> {
        let chart = self.chart.as_ref().and_then(|(_, job)| job.so_far.as_ref());
        let drawn =
            |chart: &ChartSoFar| ChartPanel::new(&chart.rows, chart.floor, self.cost).panel();
        chart.map(drawn).into_iter().collect()
    }

    fn update(&mut self, Update { state, solver, .. }: Update<'_>) {
        // Mesh and step are what a chart compares; another law or cell is another loop.
        let loop_of = |m: &Model| (m.law, m.grid.length, m.grid.is_line(), m.indenter.clone());
        self.chart
            .take_if(|(model, _)| loop_of(model) != loop_of(&state.model));
        let asked = self.asked.take();
        if let Some(Asked::Measure(effort)) = asked {
            let job = solver.job((state.scene.clone(), effort), background::chart);
            state.measure(&job);
            self.chart = Some((state.model.clone(), job));
        }
        let Some((model, job)) = &mut self.chart else {
            return;
        };
        if let Some(Asked::Use(point)) = asked {
            job.stop();
            run_as(state, point);
            // It is still a chart of this loop.
            *model = state.model.clone();
        }
        take_in(job, state);
    }

    fn restore(&mut self) {
        self.cost = Cost::default();
    }
}

/// Makes the settings of a point of the chart the scene's: method, mesh, step.
fn run_as(state: &mut ViewState, point: Point) {
    let mut scene = (*state.scene).clone();
    scene.law.range = Range::Length(state.model.law.range);
    scene.cell.points = scene.cell.points.resized(point.points);
    scene.drive.step = point.step;
    state.edit_scene(scene);
    state.set_method(point.method);
    state.set_strategy(Some(point.model).filter(|strategy| *strategy != Strategy::Atlas));
    let solves = match point.model {
        Strategy::Walk(_) => "",
        Strategy::Atlas => "; the walk solves what is shown, the atlas says what is ahead",
    };
    state.messages.notice = Some(format!("the scene now runs as {point}{solves}"));
}

/// Draws the chart; returns the row that was clicked.
fn clicked<'a>(ui: &mut Ui, chart: &'a ChartSoFar, cost: Cost) -> Option<&'a Judged> {
    let drawn = ChartPanel::new(&chart.rows, chart.floor, cost);
    let mut panel = drawn.panel();
    panel.y.label = "error of the loss".to_owned();
    diagram::legend(ui, &panel);
    for words in headline(&chart.rows, chart.floor) {
        ui.label(RichText::new(words).small());
    }
    let height = ui.available_height().max(80.0);
    let shown = diagram::show(ui, &panel, "accuracy", height, |_, _| None);
    let place = |row: &'a Judged| Some((row, drawn.place(row)?.map(f64::log10)));
    let pointed = diagram::nearest(&shown, NEAR, chart.rows.iter().filter_map(place));
    let response = shown.response;
    if let Some(row) = pointed {
        ui.ctx().set_cursor_icon(egui::CursorIcon::PointingHand);
        // At once, and not when the pointer has rested: the marks are close together.
        let tip = Tooltip::always_open(
            ui.ctx().clone(),
            response.layer_id,
            response.id,
            PopupAnchor::Pointer,
        );
        tip.show(|ui| ui.label(words(row)));
    }
    let failed = chart
        .rows
        .iter()
        .filter(|row| matches!(row.verdict, Verdict::Failed { .. }))
        .count();
    let sentence = format!(
        "Speed against accuracy: {} points measured, {failed} of them failed",
        chart.rows.len()
    );
    described(&response, &sentence);
    pointed.filter(|_| response.clicked())
}

impl Accuracy {
    fn controls(&mut self, ui: &mut Ui) {
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            if let Some((_, job)) = self.chart.as_ref().filter(|(_, job)| job.is_running()) {
                progress(ui, job).on_hover_text(STAYS);
                doing(ui, job);
                return;
            }
            for (word, effort, hover) in [
                (
                    "Run quick",
                    Effort::Quick,
                    "coarse meshes and long steps, about half a minute",
                ),
                (
                    "Run full",
                    Effort::Full { seconds: FULL },
                    "several meshes and steps of every method, two minutes of processor time",
                ),
            ] {
                if ui.button(word).on_hover_text(hover).clicked() {
                    self.asked = Some(Asked::Measure(effort));
                }
            }
            for (cost, word) in [(Cost::Time, "time"), (Cost::Transforms, "transforms")] {
                explain(radio_value(ui, &mut self.cost, cost, word), word);
            }
        });
    }
}

fn words(row: &Judged) -> String {
    let mut words = row.point.to_string();
    match &row.verdict {
        Verdict::Failed { message, .. } => words.push_str(&format!("\nfailed: {message}")),
        verdict => words.push_str(&format!(
            "\n{verdict}: error {:.1e}",
            row.errors.dissipated_energy
        )),
    }
    words.push_str(&format!(
        "\n{:.2} s of the processor, {} transforms",
        row.processor_seconds, row.transforms
    ));
    words.push_str("\nClick: the scene runs with these settings.");
    words
}
