//! The card of a stored or foreseen state in a corner of the plot: its numbers, and what can be done
//! with it.

use super::action::Action;
use super::headline::{energy, residual};
use super::theme;
use super::view_state::{Origin, ViewState};
use super::widgets::named;
use crate::follow::record::StateRecord;
use crate::physics::parameter::Dimension;
use crate::scene::units::fixed;
use egui::{Align2, Area, AreaState, Frame, Id, Order, Pos2, Rect, RichText, Ui, Vec2, pos2, vec2};

/// Width of the card, and about its height: low, so that above or below it the state is seen.
const WIDTH: f32 = 296.0;
const HEIGHT: f32 = 124.0;

/// The numbers of a stored state, on a card in an upper corner of `plot`.
pub fn show(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>, plot: Rect) {
    let Some(selection) = &state.run.selection else {
        return;
    };
    let s = &selection.state;
    let palette = theme::palette(ui);
    let id = Id::unique("inspected");
    let known = AreaState::load(ui.ctx(), id).map(|area| area.size);
    let size = known.flatten().unwrap_or(vec2(WIDTH, HEIGHT));
    let area = Area::new(id)
        .order(Order::Middle)
        .fixed_pos(corner(state, s, plot, size));
    area.constrain(false).show(ui.ctx(), |ui| {
        let fill = ui.visuals().window_fill.gamma_multiply(0.94);
        Frame::popup(ui.style())
            .fill(fill)
            .inner_margin(6.0)
            .show(ui, |ui| {
                ui.set_width(WIDTH.min(plot.width() - 12.0) - 14.0);
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
                let (words, colour) = match selection.of {
                    Origin::Walked(_) => ("", palette.now),
                    Origin::Left(_) => ("on a path that was left", palette.flat),
                    Origin::Foreseen => ("foreseen, solved on this mesh", palette.live),
                };
                if !words.is_empty() {
                    ui.label(RichText::new(words).small().color(colour));
                }
                ui.label(RichText::new(numbers(state, s).join("  ·  ")).small());
                if let Some(jump) = selection.jump.and_then(|i| state.run.record.jumps.get(i)) {
                    let words = format!(
                        "{} released {}",
                        jump.change(),
                        energy(state, jump.released_energy)
                    );
                    ui.label(RichText::new(words).small().color(palette.jump));
                }
                ui.horizontal_wrapped(|ui| {
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
                    if ui.button("Walk to it").clicked() {
                        actions.push(Action::SetTarget(s.control));
                    }
                    let copy = named(ui.button("Copy"), "Copy these numbers");
                    if copy.clicked() {
                        actions.push(Action::CopyText(numbers(state, s).join("\n")));
                    }
                });
            });
    });
}

/// Where a card of this size lets the state be seen: the corner that the curve of a loop leaves
/// free, or another one.
fn corner(state: &ViewState, s: &StateRecord, plot: Rect, size: Vec2) -> Pos2 {
    let ([left, bottom], [right, top]) = state.axes();
    let share = |value: f64, low: f64, high: f64| ((value - low) / (high - low)) as f32;
    let point = pos2(
        egui::lerp(
            plot.x_range(),
            share(s.mean_displacement / state.rho(), left, right),
        ),
        egui::lerp(plot.y_range(), 1.0 - share(s.stress_over_max, bottom, top)),
    );
    let room = plot.shrink(6.0);
    let corners = [
        Align2::RIGHT_TOP,
        Align2::LEFT_TOP,
        Align2::RIGHT_BOTTOM,
        Align2::LEFT_BOTTOM,
    ];
    let mut places = corners
        .map(|corner| corner.align_size_within_rect(size, room))
        .into_iter();
    let first = places.clone().next().map_or(room.min, |place| place.min);
    let free = places.find(|place| !place.expand(6.0).contains(point));
    free.map_or(first, |place| place.min)
}

/// The numbers, one a line.
fn numbers(state: &ViewState, s: &StateRecord) -> [String; 6] {
    let [length, stress] = [Dimension::Length, Dimension::Stress].map(|of| state.model.unit(of));
    let unit = state.model.unit(Dimension::SurfaceEnergy);
    let gamma = state.model.law.surface_energy;
    let plural = if s.iterations == 1 { "" } else { "s" };
    [
        format!(
            "u₀ {}",
            length.say(s.mean_displacement / state.rho(), 5, "ρ")
        ),
        format!("stress {}", stress.say(s.stress_over_max, 5, "σₘₐₓ")),
        format!(
            "eigenvalue {} ± {:.3} E*/L",
            fixed(s.stiffness_min, 3),
            s.stiffness_error
        ),
        format!("energy {}", unit.say(s.energy / gamma, 5, "γ")),
        format!("contact {:.1} %, {}", 100.0 * s.contact_area, residual(s)),
        format!(
            "{}, {} iteration{plural}, {:.0} ms",
            s.part, s.iterations, s.milliseconds
        ),
    ]
}
