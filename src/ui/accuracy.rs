//! Speed against accuracy: every method on the scene's loop, one mark each, and what nothing else
//! beats.

use super::action::{Action, Measurement, ViewOptions};
use super::diagram;
use super::view_state::ViewState;
use super::widgets::{described, progress};
use crate::plot::chart_panel::{ChartPanel, Cost};
use crate::study::chart::{Judged, Verdict};
use egui::{PopupAnchor, Pos2, RichText, Tooltip, Ui};
use egui_plot::PlotPoint;

/// A pointer this near to a mark means it, in screen points.
const NEAR: f32 = 10.0;

/// The tab.
pub fn show(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    controls(ui, state, actions);
    let Some(chart) = state.chart.as_ref().and_then(|job| job.so_far.as_ref()) else {
        ui.label(
            RichText::new(
                "Every method on this scene's loop, against a finer solution. Quick \
            takes half a minute.",
            )
            .weak(),
        );
        return;
    };
    let drawn = ChartPanel::new(&chart.rows, chart.floor, state.view.cost);
    let mut panel = drawn.panel();
    panel.y.label = "error of the loss".to_owned();
    diagram::legend(ui, &panel);
    let height = ui.available_height().max(80.0);
    let shown = diagram::show(ui, &panel, "accuracy", height, |_, _| None);
    let (response, transform) = (shown.response, shown.transform);
    let distance = |row: &Judged, at: Pos2| {
        let [x, y] = drawn.place(row)?.map(f64::log10);
        Some(
            transform
                .position_from_point(&PlotPoint::new(x, y))
                .distance(at),
        )
        .filter(|distance| *distance <= NEAR)
    };
    let near = |at: Pos2| {
        chart
            .rows
            .iter()
            .enumerate()
            .filter_map(move |(i, row)| Some((i, distance(row, at)?)))
    };
    let nearest = |at: Pos2| near(at).min_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i);
    if let Some(index) = response.hover_pos().and_then(nearest) {
        if response.clicked() {
            actions.push(Action::UseChartRow(index));
        }
        ui.ctx().set_cursor_icon(egui::CursorIcon::PointingHand);
        // At once, and not when the pointer has rested: the marks are close together.
        let tip = Tooltip::always_open(
            ui.ctx().clone(),
            response.layer_id,
            response.id,
            PopupAnchor::Pointer,
        );
        tip.show(|ui| ui.label(words(&chart.rows[index])));
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
}

fn controls(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        if let Some(job) = state.chart.as_ref().filter(|job| job.is_running()) {
            progress(ui, job, Action::StopMeasuring, actions);
            ui.add(egui::Label::new(RichText::new(&job.doing).small()).truncate());
            return;
        }
        for (word, what, hover) in [
            (
                "Run quick",
                Measurement::QuickChart,
                "coarse meshes and long steps, about half a minute",
            ),
            (
                "Run full",
                Measurement::FullChart,
                "several meshes and steps of every method, two minutes of processor time",
            ),
        ] {
            if ui.button(word).on_hover_text(hover).clicked() {
                actions.push(Action::Measure(what));
            }
        }
        let mut view: ViewOptions = state.view;
        ui.radio_value(&mut view.cost, Cost::Time, "time");
        ui.radio_value(&mut view.cost, Cost::Transforms, "transforms");
        if view != state.view {
            actions.push(Action::SetView(view));
        }
    });
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
