//! The energy well: the energy along the softest mode, with the state as a ball in it.

use super::{Tab, Title, Update};
use crate::follow::walk::EnergyWell;
use crate::ui::action::Action;
use crate::ui::diagram::{grid, line, small};
use crate::ui::theme;
use crate::ui::view_state::ViewState;
use crate::ui::widgets::described;
use egui::{RichText, Stroke, Ui, vec2};
use egui_plot::{LineStyle, PlotBounds, PlotPoint};

/// Radius of the ball, in screen points.
const BALL: f32 = 7.0;

/// The tab.
pub struct Well;

impl Tab for Well {
    fn title(&self) -> Title {
        Title {
            short: "Well",
            ..Title::new("Energy well", "the energy along the softest mode")
        }
    }

    fn show(&mut self, ui: &mut Ui, state: &ViewState, _: &mut Vec<Action>) {
        show(ui, state);
    }

    fn update(&mut self, with: Update<'_>) {
        with.state.watched = with.seen;
    }
}

fn show(ui: &mut Ui, state: &ViewState) {
    let palette = theme::palette(ui);
    let Some(well) = &state.run.well else {
        ui.label(RichText::new("No well yet: it is measured where the surface rests.").weak());
        return;
    };
    let (rho, gamma) = (state.rho(), state.model.law.surface_energy);
    let jumping = state.frame.as_ref().is_some_and(|frame| frame.relaxing);
    let at = format!("u₀ = {:.3} ρ", well.mean_displacement / rho);
    let words = if jumping {
        format!("Jumping; this was the well at {at}.")
    } else {
        format!("At {at}: {}", barrier(well, rho, gamma))
    };
    ui.label(RichText::new(&words).strong());
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        ui.label(RichText::new("—").color(palette.approach).strong());
        ui.label(RichText::new("energy").small());
        ui.add_space(6.0);
        ui.label(RichText::new("┄").color(palette.flat).strong());
        ui.label(RichText::new("parabola of the smallest eigenvalue").small());
    });
    let reach = well.offsets.last().copied().unwrap_or(1.0) / rho;
    let energies: Vec<[f64; 2]> = well
        .offsets
        .iter()
        .zip(&well.energies)
        .map(|(a, e)| [a / rho, e / gamma])
        .collect();
    let parabola: Vec<[f64; 2]> = well
        .offsets
        .iter()
        .map(|a| [a / rho, 0.5 * well.curvature * a * a / gamma])
        .collect();
    let top = state.plots.well_scale;
    let shown = small(
        ui,
        "well",
        ["offset along the soft mode / ρ", "energy / γ"],
        |x, y| format!("offset {x:.3} ρ\nenergy {y:.6} γ"),
    )
    .x_grid_spacer(|input| grid(input, 8.0))
    .y_grid_spacer(|input| grid(input, 5.0))
    .show(ui, |plot| {
        plot.set_plot_bounds(PlotBounds::from_min_max([-reach, -0.5 * top], [reach, top]));
        plot.line(line("parabola", &parabola, palette.flat, 1.5).style(LineStyle::dashed_dense()));
        plot.line(line("energy", &energies, palette.approach, 2.2));
    });
    let foot = shown
        .transform
        .position_from_point(&PlotPoint::new(0.0, 0.0));
    let fill = if jumping {
        palette.flat
    } else {
        palette.retraction
    };
    let painter = ui.painter().with_clip_rect(shown.response.rect);
    painter.circle(
        foot - vec2(0.0, BALL + 1.0),
        BALL,
        fill,
        Stroke::new(1.5, palette.now),
    );
    described(&shown.response, &format!("Energy well: {words}"));
}

/// What holds the ball, in one line.
fn barrier(well: &EnergyWell, rho: f64, gamma: f64) -> String {
    match lower_barrier(well) {
        Some((offset, height)) => format!(
            "barrier of {:.1e} γ at offset {:.2} ρ",
            height / gamma,
            offset / rho
        ),
        None => {
            let reach = well.offsets.last().copied().unwrap_or(0.0) / rho;
            format!("no barrier within {reach:.1} ρ")
        }
    }
}

/// Offset and height of the lower of the two barriers around the state, if there is one in sight.
fn lower_barrier(well: &EnergyWell) -> Option<(f64, f64)> {
    let middle = well.offsets.len() / 2;
    let crest = |i: usize| {
        let e = &well.energies;
        i > 0 && i + 1 < e.len() && e[i] > e[i - 1] && e[i] >= e[i + 1]
    };
    let left = (0..middle).rev().find(|i| crest(*i));
    let right = (middle + 1..well.energies.len()).find(|i| crest(*i));
    let barriers = left
        .into_iter()
        .chain(right)
        .map(|i| (well.offsets[i], well.energies[i]));
    barriers.min_by(|a, b| a.1.total_cmp(&b.1))
}
