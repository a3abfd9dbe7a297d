//! Which time steps GFMD survives: measured crosses and dots over u0, with the bound that predicts
//! them.

use super::action::{Action, Measurement};
use super::diagram::{grid, line, small};
use super::theme::{self, Palette};
use super::view_state::ViewState;
use crate::solver::gfmd::GfmdBudget;
use crate::study::time_step_map::TimeStepMap;
use egui::{ProgressBar, RichText, Role, Ui, WidgetInfo};
use egui_plot::{
    GridMark, HLine, HoverPosition, LineStyle, MarkerShape, PlotBounds, PlotUi, Points,
};

/// Marks of the axis of time steps.
const MARKS: [f64; 5] = [0.1, 0.2, 0.5, 1.0, 2.0];

/// Button, progress and map.
pub fn show(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let palette = theme::palette(theme::ground(ui));
    let job = state.run.time_steps.as_ref();
    ui.horizontal_wrapped(|ui| {
        if let Some(job) = job.filter(|job| job.is_running()) {
            if ui
                .button("Cancel")
                .on_hover_text("what is measured stays")
                .clicked()
            {
                actions.push(Action::StopMeasuring);
            }
            ui.add(
                ProgressBar::new(job.fraction as f32)
                    .desired_width(56.0)
                    .desired_height(14.0),
            );
        } else if ui
            .button("Measure")
            .on_hover_text("let a tiny perturbation go at states along the approach")
            .clicked()
        {
            actions.push(Action::Measure(Measurement::TimeSteps));
        }
        legend(ui, &palette);
    });
    let Some(map) = job.and_then(|job| job.so_far.as_ref()) else {
        ui.label(
            RichText::new(
                "Which time steps does GFMD survive on the way down? Measure, and \
            compare with the bound.",
            )
            .weak(),
        );
        return;
    };
    let (left, right) = (state.axes().0[0], state.axes().1[0]);
    let ends = (
        map.time_steps[0].log10() - 0.06,
        map.time_steps[map.time_steps.len() - 1].log10() + 0.06,
    );
    let response = small(ui, "time steps", "u₀ / ρ", "time step")
        .x_grid_spacer(|input| grid(input, 7.0))
        .y_grid_spacer(|_| {
            MARKS
                .map(|step| GridMark {
                    value: step.log10(),
                    step_size: 1.0,
                })
                .to_vec()
        })
        .y_axis_formatter(|mark, _| format!("{}", (10f64.powf(mark.value) * 1e3).round() / 1e3))
        .label_formatter(|at| {
            let p = match at {
                HoverPosition::NearDataPoint { position, .. }
                | HoverPosition::Elsewhere { position } => *position,
            };
            Some(format!("u₀ {:.3} ρ\ntime step {:.3}", p.x, 10f64.powf(p.y)))
        })
        .show(ui, |plot| {
            plot.set_plot_bounds(PlotBounds::from_min_max([left, ends.0], [right, ends.1]));
            draw(plot, state, map, &palette);
        })
        .response;
    let unstable = map.stable.iter().filter(|stable| !**stable).count();
    let sentence = format!(
        "Time steps of GFMD against u0: {} cells measured, {unstable} of them unstable",
        map.stable.len()
    );
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &sentence));
}

fn legend(ui: &mut Ui, palette: &Palette) {
    ui.spacing_mut().item_spacing.x = 4.0;
    for (mark, colour, word) in [
        ("●", palette.good, "stable"),
        ("✖", palette.warn, "unstable"),
        ("—", palette.now, "bound"),
        ("┄", palette.flat, "the paper's"),
    ] {
        ui.label(RichText::new(mark).color(colour).small());
        ui.label(RichText::new(word).small());
    }
}

fn draw(plot: &mut PlotUi<'_>, state: &ViewState, map: &TimeStepMap, palette: &Palette) {
    let rho = state.rho();
    let (mut stable, mut unstable) = (Vec::new(), Vec::new());
    for (column, u0) in map.displacements.iter().enumerate() {
        for (row, step) in map.time_steps.iter().enumerate() {
            match map.at(column, row) {
                Some(true) => stable.push([u0 / rho, step.log10()]),
                Some(false) => unstable.push([u0 / rho, step.log10()]),
                None => {}
            }
        }
    }
    plot.points(
        Points::new("stable", stable)
            .shape(MarkerShape::Circle)
            .radius(1.8)
            .color(palette.good),
    );
    plot.points(
        Points::new("unstable", unstable)
            .shape(MarkerShape::Cross)
            .radius(3.0)
            .color(palette.warn),
    );
    let paper = GfmdBudget::default().time_step.log10();
    plot.hline(
        HLine::new("the paper's", paper)
            .color(palette.flat)
            .width(1.5)
            .style(LineStyle::dashed_dense())
            .allow_hover(false),
    );
    let bound: Vec<[f64; 2]> = map
        .displacements
        .iter()
        .zip(&map.bounds)
        .map(|(u0, bound)| [u0 / rho, bound.log10()])
        .collect();
    plot.line(line("bound", &bound, palette.now, 2.0));
}
