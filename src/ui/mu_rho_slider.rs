//! The slider of mu_rho: logarithmic, with the named meshes of Table 1 beneath and a hatched zone
//! where the mesh lies.

use super::action::Action;
use super::theme;
use super::view_state::ViewState;
use crate::scene::edit::{self, MU_RHO, TICKS};
use egui::{Align2, Id, Rect, Sense, Stroke, Ui, WidgetInfo, pos2, vec2};

/// Accessible name of the slider.
pub const LABEL: &str = "mesh number mu_rho";

/// Where each name of Table 1 stands: row beneath the rail, and on which side of its tick it is
/// written.
const PLACES: [(usize, bool); 7] = [
    (2, false),
    (0, false),
    (1, false),
    (2, true),
    (0, true),
    (1, true),
    (2, true),
];

/// Draws the slider and its ticks.
pub fn show(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let width = ui.available_width();
    let (_, rect) = ui.allocate_space(vec2(width, 72.0));
    let hit = Rect::from_min_max(rect.left_top(), pos2(rect.right(), rect.top() + 22.0));
    let response = ui.interact(hit, Id::unique("mu_rho_slider"), Sense::click_and_drag());
    let rail = Rect::from_min_max(
        pos2(rect.left() + 9.0, rect.top() + 8.0),
        pos2(rect.right() - 9.0, rect.top() + 14.0),
    );
    let x_of = |mu: f64| {
        rail.left()
            + ((mu / MU_RHO.0).ln() / (MU_RHO.1 / MU_RHO.0).ln()).clamp(0.0, 1.0) as f32
                * rail.width()
    };
    let mut wanted = None;
    if let Some(pointer) = response.interact_pointer_pos()
        && response.is_pointer_button_down_on()
    {
        let share = f64::from((pointer.x - rail.left()) / rail.width()).clamp(0.0, 1.0);
        wanted = Some(MU_RHO.0 * (MU_RHO.1 / MU_RHO.0).powf(share));
    }
    accessibility(ui, state, &response, &mut wanted);
    paint(ui, state, rail, &x_of, &response);
    for ((name, mu), place) in TICKS.into_iter().zip(PLACES) {
        if tick(ui, rail, x_of(mu), (name, mu), place) {
            wanted = Some(mu);
        }
    }
    if let Some(mu) = wanted {
        actions.push(Action::EditScene(Box::new(edit::with_mu_rho(
            &state.scene,
            &state.model,
            mu,
            state.follows,
        ))));
    }
}

fn paint(
    ui: &Ui,
    state: &ViewState,
    rail: Rect,
    x_of: &dyn Fn(f64) -> f32,
    response: &egui::Response,
) {
    let palette = theme::palette(theme::ground(ui));
    let painter = ui.painter();
    painter.rect_filled(rail, 3.0, ui.visuals().widgets.inactive.bg_fill);
    let zone = Rect::from_min_max(
        pos2(x_of(0.5), rail.top() - 4.0),
        pos2(rail.right(), rail.bottom() + 4.0),
    );
    painter.rect_filled(zone, 3.0, palette.warn.gamma_multiply(0.16));
    let clipped = painter.with_clip_rect(zone.intersect(ui.clip_rect()));
    let mut x = zone.left() - zone.height();
    while x < zone.right() {
        clipped.line_segment(
            [pos2(x, zone.bottom()), pos2(x + zone.height(), zone.top())],
            Stroke::new(1.0, palette.warn.gamma_multiply(0.75)),
        );
        x += 6.0;
    }
    let visuals = ui.style().interact(response);
    painter.circle(
        pos2(x_of(state.model.mu_rho), rail.center().y),
        8.0,
        palette.approach,
        Stroke::new(1.5, visuals.fg_stroke.color),
    );
}

/// One named tick, a button on its name; true when clicked.
fn tick(ui: &Ui, rail: Rect, x: f32, (name, mu): (&str, f64), (row, right): (usize, bool)) -> bool {
    let y = rail.bottom() + 12.0 + 14.0 * row as f32;
    let (anchor, at) = if right {
        (Align2::LEFT_CENTER, pos2(x + 3.0, y))
    } else {
        (Align2::RIGHT_CENTER, pos2(x - 3.0, y))
    };
    let galley = ui.painter().layout_no_wrap(
        name.to_owned(),
        theme::small(),
        ui.visuals().weak_text_color(),
    );
    let area = anchor.anchor_size(at, galley.size());
    let response = ui.interact(area, Id::unique(("mu_rho_tick", name)), Sense::click());
    response.widget_info(|| {
        WidgetInfo::labeled(egui::Role::Button, true, format!("mu_rho of {name}, {mu}"))
    });
    let colour = if response.hovered() || response.has_focus() {
        ui.visuals().strong_text_color()
    } else {
        ui.visuals().text_color().gamma_multiply(0.75)
    };
    ui.painter().vline(
        x,
        rail.bottom() + 3.0..=y + 5.0,
        Stroke::new(1.0, colour.gamma_multiply(0.6)),
    );
    ui.painter()
        .galley_with_override_text_color(area.min, galley, colour);
    response
        .on_hover_text(format!("{name}: mu_rho = {mu}"))
        .clicked()
}

fn accessibility(ui: &Ui, state: &ViewState, response: &egui::Response, wanted: &mut Option<f64>) {
    response.widget_info(|| WidgetInfo::slider(true, state.model.mu_rho, LABEL));
    ui.ctx().accesskit_node_builder(response.id, |node| {
        node.set_min_numeric_value(MU_RHO.0);
        node.set_max_numeric_value(MU_RHO.1);
        node.add_action(egui::accesskit::Action::SetValue);
    });
    ui.input(|input| {
        for request in
            input.accesskit_action_requests(response.id, egui::accesskit::Action::SetValue)
        {
            if let Some(egui::accesskit::ActionData::NumericValue(value)) = request.data {
                *wanted = Some(value.clamp(MU_RHO.0, MU_RHO.1));
            }
        }
    });
    if response.has_focus() {
        let keep = egui::EventFilter {
            horizontal_arrows: true,
            ..Default::default()
        };
        ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, keep));
        let steps = ui.input(|i| {
            i.num_presses(egui::Key::ArrowRight) as f64 - i.num_presses(egui::Key::ArrowLeft) as f64
        });
        if steps != 0.0 {
            *wanted = Some((state.model.mu_rho * 1.02f64.powf(steps)).clamp(MU_RHO.0, MU_RHO.1));
        }
    }
}
