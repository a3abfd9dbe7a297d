//! The cohesive laws as cards, each with a sketch of its traction against the gap.

use super::action::Action;
use super::theme;
use super::view_state::ViewState;
use crate::physics::law::{Law, Shape};
use crate::scene::edit;
use egui::{Align2, Id, Role, Sense, Stroke, Ui, WidgetInfo, pos2, vec2};

/// A row of cards, two by two.
pub fn show(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let present = state.scene.law.shape;
    let shapes = Shape::all();
    let width = (ui.available_width() - 6.0) / 2.0;
    for pair in shapes.chunks(2) {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 6.0;
            for &shape in pair {
                let same = shape.word() == present.word();
                let drawn = if same { present } else { shape };
                if card(ui, drawn, same, width) && !same {
                    actions.push(Action::EditScene(Box::new(edit::with_shape(
                        &state.scene,
                        &state.model,
                        shape,
                    ))));
                }
            }
        });
    }
}

fn card(ui: &mut Ui, shape: Shape, selected: bool, width: f32) -> bool {
    let (_, rect) = ui.allocate_space(vec2(width, 56.0));
    let response = ui.interact(rect, Id::unique(("law", shape.word())), Sense::click());
    let name = shape.word().replace('_', " ");
    response.widget_info(|| {
        WidgetInfo::selected(Role::RadioButton, true, selected, format!("law {name}"))
    });
    let visuals = ui.style().interact_selectable(&response, selected);
    let palette = theme::palette(theme::ground(ui));
    let painter = ui.painter().with_clip_rect(rect.intersect(ui.clip_rect()));
    let fill = if selected {
        ui.visuals().selection.bg_fill.gamma_multiply(0.55)
    } else {
        ui.visuals().faint_bg_color
    };
    painter.rect(
        rect.shrink(0.5),
        5.0,
        fill,
        Stroke::new(
            1.0,
            if selected {
                palette.approach
            } else {
                visuals.bg_stroke.color
            },
        ),
        egui::StrokeKind::Inside,
    );
    let law = Law {
        shape,
        surface_energy: 1.0,
        range: 1.0,
    };
    let (top, axis) = (rect.top() + 7.0, rect.bottom() - 17.0);
    painter.hline(
        rect.x_range().shrink(6.0),
        axis,
        Stroke::new(1.0, ui.visuals().weak_text_color()),
    );
    let points = (0..=60)
        .map(|i| f64::from(i) / 60.0)
        .filter_map(|t| {
            let traction = law.at(0.02 + 3.4 * t).traction / law.traction_max();
            (traction > -0.15).then(|| {
                pos2(
                    rect.left() + 6.0 + t as f32 * (rect.width() - 12.0),
                    axis - traction as f32 * (axis - top),
                )
            })
        })
        .collect();
    painter.line(points, Stroke::new(1.8, palette.retraction));
    painter.text(
        pos2(rect.center().x, rect.bottom() - 2.0),
        Align2::CENTER_BOTTOM,
        name,
        theme::small(),
        ui.visuals().strong_text_color(),
    );
    response.clicked()
}
