//! The numbers of a stored state, on a card in the corner of the plot.

use super::action::Action;
use super::controls::named;
use super::theme;
use super::view_state::ViewState;
use egui::{Area, Frame, Id, Order, Rect, RichText, Ui, pos2};

/// Width of the card.
const WIDTH: f32 = 216.0;

/// The card, in an upper corner of `plot`.
pub fn show(ui: &mut Ui, state: &ViewState, plot: Rect, actions: &mut Vec<Action>) {
    let Some(selection) = &state.run.selection else {
        return;
    };
    let s = &selection.state;
    let palette = theme::palette(theme::ground(ui));
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
                    ui.label(RichText::new(format!("{} on {}", s.pattern, s.direction)).strong());
                    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                        if named(ui.small_button("✖"), "Close the card").clicked() {
                            actions.push(Action::ClearSelection);
                        }
                    });
                });
                for line in numbers(state) {
                    ui.label(RichText::new(line).small());
                }
                if let Some(jump) = selection.jump.and_then(|i| state.run.record.jumps.get(i)) {
                    let words = format!(
                        "{} → {} released {:.4} γ",
                        jump.from, jump.to, jump.released_energy
                    );
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
    let Some(selection) = &state.run.selection else {
        return Vec::new();
    };
    let s = &selection.state;
    vec![
        format!("u₀ {:.5} ρ", s.mean_displacement / state.rho()),
        format!("stress {:.5} σₘₐₓ", s.stress_over_max),
        format!(
            "eigenvalue {:.3} ± {:.3} E*/L",
            s.stiffness_min, s.stiffness_error
        ),
        format!("energy {:.5} γ", s.energy / state.model.law.surface_energy),
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
