//! Speed against accuracy: every method on the scene's loop, one mark each, and what nothing else beats.

use super::action::{Action, CostOf, Measurement, ViewOptions};
use super::loop_plot::{line, small};
use super::theme::{self, Palette};
use super::view_state::ViewState;
use crate::experiment::chart::{self, Judged, Model, Point, Verdict};
use crate::experiment::plan::Reduction;
use crate::solver::method::MethodKind;
use crate::worker::protocol::ChartSoFar;
use egui::{Color32, PopupAnchor, Pos2, ProgressBar, RichText, Role, Tooltip, Ui, WidgetInfo};
use egui_plot::{GridInput, GridMark, LineStyle, MarkerShape, PlotBounds, PlotPoint, PlotTransform, PlotUi, Points, Text};

/// A pointer this near to a mark means it, in screen points.
const NEAR: f32 = 10.0;
/// The least error that is told apart, so that zero has a place on a logarithmic axis.
const LEAST: f64 = 1e-8;

/// The tab.
pub fn show(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    controls(ui, state, actions);
    let Some(chart) = &state.chart else {
        ui.label(RichText::new("Every method on this scene's loop, against a finer solution. Quick takes half a minute.").weak());
        return;
    };
    let palette = theme::palette(ui.visuals().dark_mode);
    let dark = ui.visuals().dark_mode;
    let marks: Vec<[f64; 2]> = chart.rows.iter().map(|row| place(row, state.view.cost, chart)).collect();
    let bounds = bounds(&marks, &chart.rows);
    let cost = match state.view.cost {
        CostOf::Time => "processor seconds",
        CostOf::Transforms => "transforms",
    };
    let shown = small(ui, "accuracy", cost, "error of the loss")
        .grid_color(ui.visuals().text_color().gamma_multiply(0.45))
        .x_grid_spacer(decades)
        .y_grid_spacer(decades)
        // The corner and the right edge have no room for a number.
        .x_axis_formatter(|mark, shown| if mark.value >= shown.end() - 0.1 { String::new() } else { power(mark.value) })
        .y_axis_formatter(|mark, shown| if mark.value <= shown.start() + 0.1 { String::new() } else { power(mark.value) })
        .label_formatter(|_| None)
        .show(ui, |plot| {
            plot.set_plot_bounds(bounds);
            draw(plot, chart, &marks, state.view.cost, &palette, dark);
        });
    let (response, transform) = (shown.response, shown.transform);
    if let Some(index) = response.hover_pos().and_then(|at| nearest(&transform, &marks, &chart.rows, bounds, at)) {
        if response.clicked() {
            actions.push(Action::UseChartRow(index));
        }
        ui.ctx().set_cursor_icon(egui::CursorIcon::PointingHand);
        // At once, and not when the pointer has rested: the marks are close together.
        let tip = Tooltip::always_open(ui.ctx().clone(), response.layer_id, response.id, PopupAnchor::Pointer);
        tip.show(|ui| ui.label(words(&chart.rows[index])));
    }
    let failed = chart.rows.iter().filter(|row| matches!(row.verdict, Verdict::Failed { .. })).count();
    let sentence = format!("Speed against accuracy: {} points measured, {failed} of them failed", chart.rows.len());
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &sentence));
}

fn controls(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let charting = matches!(state.measuring, Some(Measurement::QuickChart | Measurement::FullChart));
        if charting {
            if ui.button("Cancel").on_hover_text("what is measured stays").clicked() {
                actions.push(Action::StopMeasuring);
            }
            let chart = state.chart.as_ref();
            ui.add(ProgressBar::new(chart.map_or(0.0, |c| c.fraction) as f32).desired_width(60.0).desired_height(14.0));
            let now = chart.map_or("beginning", |c| c.now.as_str());
            ui.add(egui::Label::new(RichText::new(now).small()).truncate());
            return;
        }
        for (word, what, hover) in [
            ("Run quick", Measurement::QuickChart, "coarse meshes and long steps, about half a minute"),
            ("Run full", Measurement::FullChart, "several meshes and steps of every method, two minutes of processor time"),
        ] {
            if ui.button(word).on_hover_text(hover).clicked() {
                actions.push(Action::Measure(what));
            }
        }
        let mut view: ViewOptions = state.view;
        ui.radio_value(&mut view.cost, CostOf::Time, "time");
        ui.radio_value(&mut view.cost, CostOf::Transforms, "transforms");
        if view != state.view {
            actions.push(Action::SetView(view));
        }
    });
    let Some(chart) = &state.chart else { return };
    let dark = ui.visuals().dark_mode;
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = egui::vec2(3.0, 1.0);
        let mut named: Vec<&str> = Vec::new();
        for row in &chart.rows {
            let road = row.point.road();
            if !named.contains(&road) {
                named.push(road);
                let (colour, _, face) = mark(&row.point, dark);
                ui.label(RichText::new(face).small().color(colour));
                ui.label(RichText::new(road).small());
                ui.add_space(4.0);
            }
        }
    });
}

/// Where a row stands: logarithms of cost and error.
fn place(row: &Judged, cost: CostOf, chart: &ChartSoFar) -> [f64; 2] {
    let cost = match cost {
        CostOf::Time => row.processor_seconds,
        CostOf::Transforms => row.transforms as f64,
    };
    let error = row.errors.dissipated_energy.abs().max(chart.floor.unwrap_or(0.0)).max(LEAST);
    [cost.max(1e-6).log10(), error.log10()]
}

fn done(row: &Judged) -> bool {
    row.verdict == Verdict::Done
}

/// Whole decades around everything, with room for the failures above.
fn bounds(marks: &[[f64; 2]], rows: &[Judged]) -> PlotBounds {
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for (mark, row) in marks.iter().zip(rows) {
        for k in 0..if done(row) { 2 } else { 1 } {
            low[k] = low[k].min(mark[k]);
            high[k] = high[k].max(mark[k]);
        }
    }
    for k in 0..2 {
        if !(low[k] <= high[k]) {
            (low[k], high[k]) = ([-2.0, -5.0][k], [1.0, -1.0][k]);
        }
        low[k] = (low[k] - 0.15).floor();
        high[k] = (high[k] + 0.15).ceil();
    }
    PlotBounds::from_min_max(low, [high[0], high[1] + 0.08 * (high[1] - low[1])])
}

/// A failure has no error: it stands on the top edge, at its cost.
fn seen(mark: [f64; 2], row: &Judged, bounds: &PlotBounds) -> [f64; 2] {
    if done(row) { mark } else { [mark[0], bounds.max()[1] - 0.04 * bounds.height()] }
}

fn nearest(transform: &PlotTransform, marks: &[[f64; 2]], rows: &[Judged], bounds: PlotBounds, at: Pos2) -> Option<usize> {
    let distance = |i: usize| {
        let p = seen(marks[i], &rows[i], &bounds);
        transform.position_from_point(&PlotPoint::new(p[0], p[1])).distance(at)
    };
    (0..rows.len()).filter(|i| distance(*i) <= NEAR).min_by(|a, b| distance(*a).total_cmp(&distance(*b)))
}

fn draw(plot: &mut PlotUi<'_>, chart: &ChartSoFar, marks: &[[f64; 2]], cost: CostOf, palette: &Palette, dark: bool) {
    let bounds = plot.plot_bounds();
    front(plot, chart, marks, cost, palette);
    for (row, mark) in chart.rows.iter().zip(marks) {
        let at = seen(*mark, row, &bounds);
        let (colour, shape, _) = self::mark(&row.point, dark);
        let filled = row.point.model != Model::Walk(Reduction::Quarter);
        let shape = if done(row) { shape } else { MarkerShape::Cross };
        let points = Points::new("row", vec![at]).shape(shape).radius(4.5).filled(filled).color(colour);
        plot.points(points.allow_hover(false));
        for (is, word) in [(row.plan, "plan"), (row.paper_budget, "paper")] {
            if is {
                let ring = Points::new(word, vec![at]).shape(MarkerShape::Circle).radius(9.0).filled(false);
                plot.points(ring.color(palette.now).allow_hover(false));
                let text = Text::new(word, PlotPoint::new(at[0], at[1]), RichText::new(format!("   {word}")).small());
                plot.text(text.color(palette.now).anchor(egui::Align2::LEFT_CENTER).allow_hover(false));
            }
        }
    }
}

/// What nothing else beats, as a staircase.
fn front(plot: &mut PlotUi<'_>, chart: &ChartSoFar, marks: &[[f64; 2]], cost: CostOf, palette: &Palette) {
    let value = |row: &Judged| match cost {
        CostOf::Time => row.processor_seconds,
        CostOf::Transforms => row.transforms as f64,
    };
    let floor = chart.floor.unwrap_or(0.0);
    let error = |row: &Judged| if done(row) { row.errors.dissipated_energy.max(floor) } else { f64::NAN };
    let pairs: Vec<(f64, f64)> = chart.rows.iter().map(|row| (value(row), error(row))).collect();
    let on = chart::front(&pairs);
    let mut best: Vec<[f64; 2]> = marks.iter().zip(on).filter(|(_, on)| *on).map(|(mark, _)| *mark).collect();
    best.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let steps: Vec<[f64; 2]> =
        best.windows(2).flat_map(|pair| [pair[0], [pair[1][0], pair[0][1]]]).chain(best.last().copied()).collect();
    plot.line(line("front", &steps, palette.live, 1.5).style(LineStyle::dashed_dense()).allow_hover(false));
}

/// Colour, shape and a letter-like face of a road: Okabe and Ito's colours, lifted where the ground is dark.
fn mark(point: &Point, dark: bool) -> (Color32, MarkerShape, &'static str) {
    let pick = |light: u32, bright: u32| {
        let c = if dark { bright } else { light };
        Color32::from_rgb((c >> 16) as u8, (c >> 8) as u8, c as u8)
    };
    match point.method {
        _ if point.model == Model::Atlas => (pick(0x1a7fb8, 0x56b4e9), MarkerShape::Plus, "✚"),
        MethodKind::NewtonKrylov => (pick(0x0072b2, 0x6aa9ff), MarkerShape::Circle, "●"),
        MethodKind::Lbfgs => (pick(0x00805c, 0x2ecfa0), MarkerShape::Square, "■"),
        MethodKind::ConjugateGradients => (pick(0xa06a00, 0xf0c040), MarkerShape::Up, "▲"),
        MethodKind::Fire => (pick(0xc24a00, 0xff8a4a), MarkerShape::Diamond, "◆"),
        MethodKind::GfmdTuned => (pick(0x9a4a80, 0xe08cc4), MarkerShape::Down, "▼"),
        MethodKind::Gfmd => (pick(0x444444, 0xc4c4c4), MarkerShape::Asterisk, "✱"),
    }
}

fn words(row: &Judged) -> String {
    let mut words = row.point.to_string();
    match &row.verdict {
        Verdict::Failed { message, .. } => words.push_str(&format!("\nfailed: {message}")),
        verdict => words.push_str(&format!("\n{verdict}: error {:.1e}", row.errors.dissipated_energy)),
    }
    words.push_str(&format!("\n{:.2} s of the processor, {} transforms", row.processor_seconds, row.transforms));
    words.push_str("\nClick: the scene runs with these settings.");
    words
}

fn decades(input: GridInput) -> Vec<GridMark> {
    let (low, high) = input.bounds;
    let every = ((high - low) / 6.0).ceil().max(1.0);
    let first = (low / every).ceil();
    (0..40)
        .map(|i| (first + f64::from(i)) * every)
        .take_while(|x| *x <= high)
        .map(|value| GridMark { value, step_size: high - low })
        .collect()
}

/// A power of ten.
fn power(exponent: f64) -> String {
    let exponent = exponent.round() as i32;
    match exponent {
        -2..=3 => format!("{}", 10f64.powi(exponent)),
        _ => format!("1e{exponent}"),
    }
}
