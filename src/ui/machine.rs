//! The machine: what drives the body, as a picture to choose from; in what its control is told; and
//! its line through the present point of the plot.

use super::action::Action;
use super::theme::Palette;
use super::view_state::ViewState;
use super::widgets::{card, given};
use crate::physics::control::Control;
use crate::physics::parameter::Dimension;
use crate::plot::panel::{Colour, Role, Series};
use crate::scene::edit;
use crate::scene::parameter;
use crate::scene::units::Unit;
use egui::{Painter, Rect, Stroke, StrokeKind, Ui, pos2, vec2};
use std::f64::consts::PI;

/// Stiffness of a spring that is chosen anew, over that of the softest wave of the body: soft
/// enough that patterns are skipped.
const SOFT: f64 = 3.0;

/// In what the control is told.
#[derive(Clone, Debug)]
pub struct Told {
    /// Its name.
    pub name: &'static str,
    /// Its letter.
    pub symbol: &'static str,
    /// What stands behind its numbers.
    pub suffix: String,
    /// What is 1 (length; E* of a load).
    pub unit: f64,
    /// That beside the natural unit.
    pub measure: Unit,
}

impl Told {
    /// A value with its unit, in as fine steps as with so many `decimals` of natural units.
    pub fn say(&self, value: f64, decimals: usize) -> String {
        let natural = value / self.unit / self.measure.scale;
        self.measure.number(natural, decimals) + &self.suffix
    }
}

/// In what the control of this scene is told.
pub fn told(state: &ViewState) -> Told {
    let law = &state.model.law;
    let name = match state.scene.control() {
        Control::Displacement => "Mean displacement",
        Control::Spring { .. } => "Stage",
        Control::Load => "Load",
    };
    let (of, natural, one) = if state.scene.control() == Control::Load {
        (Dimension::Stress, "σₘₐₓ", law.traction_max())
    } else {
        (Dimension::Length, "ρ", law.range)
    };
    let measure = state.model.unit(of);
    let (suffix, unit) = (format!(" {}", measure.name(natural)), one / measure.scale);
    Told {
        name,
        symbol: state.scene.control().symbol(),
        suffix,
        unit,
        measure,
    }
}

/// The choice, and the stiffness of a spring.
pub fn show(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let (scene, model) = (&state.scene, &state.model);
    let present = scene.drive.control;
    let wave = PI / model.equivalent_length;
    let mut asked = None;
    let width = (ui.available_width() - 12.0) / 3.0;
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 6.0;
        for kind in Control::all(SOFT * wave) {
            let (name, what) = match kind {
                Control::Displacement => ("stiff", "the mean displacement is driven"),
                Control::Spring { .. } => ("spring", "a stage pulls through a spring"),
                Control::Load => ("weight", "the load is driven: a dead weight"),
            };
            let chosen = kind.word() == present.word();
            let size = vec2(width, 62.0);
            let drawn = |painter: &Painter, rect: Rect, palette: &Palette| {
                sketch(kind, painter, rect, palette);
            };
            let response = card(ui, ("machine", name), chosen, size, drawn);
            if response.on_hover_text(what).clicked() && !chosen {
                asked = Some(kind);
            }
        }
    });
    if let Control::Spring { stiffness } = present {
        let range = 1e-9..=1e9;
        let wanted = given(ui, actions, scene, &parameter::STIFFNESS, stiffness, range);
        asked = asked.or(wanted.map(|stiffness| Control::Spring { stiffness }));
        ui.small(if scene.control().stiffness() < wave {
            "Softer than the body's softest wave: it snaps as one block."
        } else {
            "The spring's line in the plot touches the curve where it snaps."
        });
    }
    if let Some(control) = asked {
        actions.push(Action::edit(edit::with_control(scene, model, control)));
    }
}

/// A stage above, the body below, and what is between.
fn sketch(kind: Control, painter: &Painter, rect: Rect, palette: &Palette) {
    let stroke = Stroke::new(1.8, palette.retraction);
    let (x, top, low) = (rect.center().x, rect.top() + 9.0, rect.bottom() - 30.0);
    let body = Rect::from_min_max(
        pos2(rect.left() + 12.0, low),
        pos2(rect.right() - 12.0, low + 9.0),
    );
    painter.rect_filled(body, 2.0, palette.elastomer);
    let stage = |y: f32| {
        painter.hline(
            rect.x_range().shrink(16.0),
            y,
            Stroke::new(3.0, palette.approach),
        )
    };
    match kind {
        Control::Displacement => {
            stage(top);
            painter.vline(x, top..=low, Stroke::new(5.0, palette.retraction));
        }
        Control::Spring { .. } => {
            stage(top);
            let turns = 7;
            let zigzag = (0..=turns).map(|i| {
                let side = match i {
                    0 => 0.0,
                    i if i == turns => 0.0,
                    i if i % 2 == 0 => -6.0,
                    _ => 6.0,
                };
                pos2(x + side, top + (low - top) * i as f32 / turns as f32)
            });
            painter.line(zigzag.collect(), stroke);
        }
        Control::Load => {
            // Over a pulley.
            let (left, right) = (x - 8.0, x + 8.0);
            painter.circle_stroke(pos2(x, top + 4.0), 8.0, stroke);
            painter.vline(left, top + 4.0..=low, stroke);
            painter.vline(right, top + 4.0..=low - 10.0, stroke);
            let weight = Rect::from_center_size(pos2(right, low - 6.0), vec2(10.0, 9.0));
            painter.rect(
                weight,
                1.0,
                palette.approach,
                Stroke::NONE,
                StrokeKind::Inside,
            );
        }
    }
}

/// What the machine allows at the present value of the control: stress = k (w - u0) under a spring,
/// stress = F under a load; from one side of the plot to the other.
pub fn line(state: &ViewState, [left, right]: [f64; 2]) -> Option<Series> {
    let (control, law) = (state.scene.control(), &state.model.law);
    let value = state.run.state.as_ref()?.control;
    let stress = |u0: f64| match control {
        Control::Displacement => None,
        Control::Spring { stiffness } => Some(stiffness * (value - u0)),
        Control::Load => Some(value),
    };
    let points = [left, right].map(|x| Some([x, stress(x * law.range)? / law.traction_max()]));
    let points: Vec<[f64; 2]> = points.into_iter().flatten().collect();
    (!points.is_empty()).then(|| Series::line("machine", Role::Theory, Colour::MACHINE, points))
}
