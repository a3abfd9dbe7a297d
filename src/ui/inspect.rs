//! The numbers of a stored state, on a card in the corner of the plot.

use super::action::Action;
use super::controls::named;
use super::theme;
use super::view_state::ViewState;
use egui::{Frame, Rect, RichText, Ui, UiBuilder, vec2};

/// Width of the card.
const WIDTH: f32 = 178.0;

/// The card, in the upper corner of `plot` away from the state.
pub fn show(ui: &mut Ui, state: &ViewState, plot: Rect, actions: &mut Vec<Action>) {
    let Some(selection) = &state.selection else { return };
    let s = &selection.state;
    let palette = theme::palette(ui.visuals().dark_mode);
    let (low, high) = (state.axes().0[0], state.axes().1[0]);
    let on_the_right = s.mean_displacement / state.rho() > 0.5 * (low + high);
    let left = if on_the_right { plot.left() + 44.0 } else { plot.right() - WIDTH - 6.0 };
    let area = Rect::from_min_size(egui::pos2(left, plot.top() + 6.0), vec2(WIDTH, plot.height()));
    ui.scope_builder(UiBuilder::new().max_rect(area), |ui| {
        let fill = ui.visuals().window_fill.gamma_multiply(0.94);
        Frame::popup(ui.style()).fill(fill).inner_margin(6.0).show(ui, |ui| {
            ui.set_width(WIDTH - 14.0);
            ui.spacing_mut().item_spacing.y = 1.0;
            ui.horizontal(|ui| {
                ui.label(RichText::new(format!("{} on {}", s.pattern, s.branch)).strong());
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    if named(ui.small_button("✖"), "Close the card").clicked() {
                        actions.push(Action::ClearSelection);
                    }
                });
            });
            for line in numbers(state) {
                ui.label(RichText::new(line).small());
            }
            if let Some(jump) = selection.jump.and_then(|i| state.record.jumps.get(i)) {
                let words = format!("{} → {}: {:.4} γ released", jump.from, jump.to, jump.released_energy);
                ui.label(RichText::new(words).small().color(palette.jump));
            }
            if ui.small_button("Walk to this u₀").clicked() {
                actions.push(Action::SetTarget(s.mean_displacement));
            }
        });
    });
}

/// The numbers, one a line.
fn numbers(state: &ViewState) -> Vec<String> {
    let Some(selection) = &state.selection else { return Vec::new() };
    let s = &selection.state;
    vec![
        format!("u₀ {:.5} ρ", s.mean_displacement / state.rho()),
        format!("stress {:.5} σₘₐₓ", s.stress_over_max),
        format!("eigenvalue {:.4} ± {:.4} E*/L", s.stiffness_min, s.stiffness_error),
        format!("energy {:.5} γ", s.energy / state.model.law.surface_energy),
        format!("contact {:.1} %, residual {:.0e}", 100.0 * s.contact_area, s.residual),
        format!("{}: {} iterations, {:.1} ms", s.model, s.iterations, s.milliseconds),
    ]
}
