//! The card of a stored or foreseen state in a corner of the plot: its numbers, and what can be done
//! with it.

use super::action::Action;
use super::headline::energy;
use super::theme;
use super::view_state::ViewState;
use super::widgets::named;
use crate::follow::record::StateRecord;
use crate::physics::parameter::Dimension;
use egui::{Area, Frame, Id, Order, Rect, RichText, Ui, pos2};

/// Width of the card.
const WIDTH: f32 = 216.0;

/// The numbers of a stored state, on a card in an upper corner of `plot`.
pub fn show(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>, plot: Rect) {
    let Some(selection) = &state.run.selection else {
        return;
    };
    let s = &selection.state;
    let palette = theme::palette(ui);
    // In the corner that the curve of a loop leaves free, unless the state itself is there.
    let ([left, bottom], [right, top]) = state.axes();
    let there = s.mean_displacement / state.rho() > 0.5 * (left + right)
        && s.stress_over_max > 0.45 * (bottom + top);
    let x = if there {
        plot.left() + 46.0
    } else {
        plot.right() - WIDTH - 6.0
    };
    let area = Area::new(Id::unique("inspected"))
        .order(Order::Middle)
        .fixed_pos(pos2(x, plot.top() + 6.0));
    area.constrain(false).show(ui.ctx(), |ui| {
        let fill = ui.visuals().window_fill.gamma_multiply(0.94);
        Frame::popup(ui.style())
            .fill(fill)
            .inner_margin(6.0)
            .show(ui, |ui| {
                ui.set_width(WIDTH - 14.0);
                ui.spacing_mut().item_spacing.y = 1.0;
                ui.horizontal(|ui| {
                    let words = format!("{} on {}", s.pattern.words(), s.direction);
                    ui.label(RichText::new(words).strong());
                    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                        if named(ui.small_button("✖"), "Close the card").clicked() {
                            actions.push(Action::ClearSelection);
                        }
                    });
                });
                if selection.index.is_none() {
                    ui.label(
                        RichText::new("foreseen, solved on this mesh")
                            .small()
                            .color(palette.live),
                    );
                }
                for line in numbers(state, s) {
                    ui.label(RichText::new(line).small());
                }
                if let Some(jump) = selection.jump.and_then(|i| state.run.record.jumps.get(i)) {
                    let words = format!(
                        "{} released {}",
                        jump.change(),
                        energy(state, jump.released_energy)
                    );
                    ui.label(RichText::new(words).small().color(palette.jump));
                }
                ui.vertical(|ui| {
                    let kept = state.looked_at().is_some();
                    let button = ui.add_enabled(kept, egui::Button::new("Go on from here"));
                    let button = button.on_hover_text(
                        "G: the surface is put back into this state; what came after it becomes \
                         a grey line",
                    );
                    let gone = "its picture is no longer kept: memory is bounded";
                    if button.on_disabled_hover_text(gone).clicked() {
                        actions.push(Action::GoOn);
                    }
                    if ui.small_button("Walk to this u₀").clicked() {
                        actions.push(Action::SetTarget(s.control));
                    }
                    let copy = named(ui.small_button("Copy"), "Copy these numbers");
                    if copy.clicked() {
                        actions.push(Action::CopyText(numbers(state, s).join("\n")));
                    }
                });
            });
    });
}

/// The numbers, one a line.
fn numbers(state: &ViewState, s: &StateRecord) -> [String; 6] {
    let [length, stress] = [Dimension::Length, Dimension::Stress].map(|of| state.model.unit(of));
    let unit = state.model.unit(Dimension::SurfaceEnergy);
    let gamma = state.model.law.surface_energy;
    [
        format!(
            "u₀ {}",
            length.say(s.mean_displacement / state.rho(), 5, "ρ")
        ),
        format!("stress {}", stress.say(s.stress_over_max, 5, "σₘₐₓ")),
        format!(
            "eigenvalue {:.3} ± {:.3} E*/L",
            s.stiffness_min, s.stiffness_error
        ),
        format!("energy {}", unit.say(s.energy / gamma, 5, "γ")),
        format!(
            "contact {:.1} %, residual {:.0e}",
            100.0 * s.contact_area,
            s.residual
        ),
        format!(
            "{}, {} iterations, {:.0} ms",
            s.part, s.iterations, s.milliseconds
        ),
    ]
}
