//! The slider of the mean displacement u0: up is away, so dragging down lowers the body. Two marks:
//! where it should go, and where it is.

use super::action::Action;
use super::theme;
use super::view_state::ViewState;
use crate::plot::ticks;
use egui::{Align2, Id, Pos2, Rect, Role, Sense, Shape, Stroke, Ui, WidgetInfo, pos2, vec2};

/// Accessible name of the slider.
pub const LABEL: &str = "mean displacement u0";

/// Id of the slider: the keys of u0 work while it has the focus.
pub fn id() -> Id {
    Id::unique("u0_slider")
}

/// Draws the slider and turns drags into targets.
pub fn show(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>, height: f32) {
    let (_, rect) = ui.allocate_space(vec2(122.0, height));
    let response = ui.interact(rect, id(), Sense::click_and_drag());
    let rail = Rect::from_min_max(
        pos2(rect.left() + 38.0, rect.top() + 10.0),
        pos2(rect.left() + 47.0, rect.bottom() - 10.0),
    );
    let (low, high) = state.limits;
    let y_of = |u0: f64| {
        rail.bottom() - ((u0 - low) / (high - low)).clamp(0.0, 1.0) as f32 * rail.height()
    };
    let u0_at =
        |y: f32| high - f64::from((y - rail.top()) / rail.height()).clamp(0.0, 1.0) * (high - low);

    if let Some(pointer) = response.interact_pointer_pos()
        // Not `dragged()`, which waits for six pixels: the thumb must move within the frame.
        && response.is_pointer_button_down_on()
    {
        response.request_focus();
        let fine = ui.input(|i| i.modifiers.shift);
        let moved = f64::from(ui.input(|i| i.pointer.delta().y) / rail.height()) * (high - low);
        let wanted = if fine {
            state.target - 0.1 * moved
        } else {
            u0_at(pointer.y)
        };
        actions.push(Action::SetTarget(wanted));
    }
    accessibility(ui, state, actions, &response);

    let palette = theme::palette(theme::ground(ui));
    ticks(ui, state, rail, &y_of);
    let painter = ui.painter();
    painter.rect_filled(rail, 4.0, ui.visuals().widgets.inactive.bg_fill);
    let walked = Rect::from_min_max(
        pos2(rail.left(), y_of(state.run.actual)),
        rail.right_bottom(),
    );
    painter.rect_filled(walked, 4.0, palette.elastomer);
    let actual = y_of(state.run.actual);
    let tip = pos2(rail.center().x + 18.0, actual);
    let arrow = vec![tip, tip + vec2(9.0, -6.0), tip + vec2(9.0, 6.0)];
    painter.add(Shape::convex_polygon(
        arrow,
        palette.retraction,
        Stroke::NONE,
    ));
    let visuals = ui.style().interact(&response);
    let thumb = Rect::from_center_size(pos2(rail.center().x, y_of(state.target)), vec2(30.0, 13.0));
    painter.rect(
        thumb,
        5.0,
        palette.approach,
        Stroke::new(1.5, visuals.fg_stroke.color),
        egui::StrokeKind::Outside,
    );
    painter.hline(
        thumb.x_range().shrink(7.0),
        thumb.center().y,
        Stroke::new(1.5, ui.visuals().panel_fill),
    );
    words(ui, rail, thumb.center(), tip, state);
}

/// "target" and "actual" beside their marks, pushed apart where they would overlap.
fn words(ui: &Ui, rail: Rect, target: Pos2, actual: Pos2, state: &ViewState) {
    let palette = theme::palette(theme::ground(ui));
    let x = rail.center().x + 31.0;
    let (mut target_y, mut actual_y) = (target.y, actual.y);
    if (target_y - actual_y).abs() < 14.0 {
        let middle = 0.5 * (target_y + actual_y);
        let up = if target_y <= actual_y { -7.0 } else { 7.0 };
        (target_y, actual_y) = (middle + up, middle - up);
    }
    ui.painter().text(
        pos2(x, target_y),
        Align2::LEFT_CENTER,
        "target",
        theme::small(),
        palette.approach,
    );
    let word = if state.run.paused {
        "paused"
    } else if state.run.is_busy() {
        "actual …"
    } else {
        "actual"
    };
    ui.painter().text(
        pos2(x, actual_y),
        Align2::LEFT_CENTER,
        word,
        theme::small(),
        palette.retraction,
    );
}

fn ticks(ui: &Ui, state: &ViewState, rail: Rect, y_of: &dyn Fn(f64) -> f32) {
    let rho = state.rho();
    let (low, high) = (state.limits.0 / rho, state.limits.1 / rho);
    let (values, spacing) = ticks::within(low, high, 9.0);
    let colour = ui.visuals().weak_text_color();
    for value in values {
        let y = y_of(value * rho);
        ui.painter().hline(
            rail.left() - 9.0..=rail.left() - 4.0,
            y,
            Stroke::new(1.0, colour),
        );
        let text = ticks::label(value, spacing);
        ui.painter().text(
            pos2(rail.left() - 15.0, y),
            Align2::RIGHT_CENTER,
            text,
            theme::small(),
            colour,
        );
    }
}

fn accessibility(ui: &Ui, state: &ViewState, actions: &mut Vec<Action>, response: &egui::Response) {
    let rho = state.rho();
    response.widget_info(|| WidgetInfo::slider(true, state.target / rho, LABEL));
    ui.ctx().accesskit_node_builder(response.id, |node| {
        node.set_role(Role::Slider);
        node.set_min_numeric_value(state.limits.0 / rho);
        node.set_max_numeric_value(state.limits.1 / rho);
        node.set_numeric_value_step(state.scene.drive.step / rho);
        for action in [
            egui::accesskit::Action::SetValue,
            egui::accesskit::Action::Increment,
            egui::accesskit::Action::Decrement,
        ] {
            node.add_action(action);
        }
    });
    ui.input(|input| {
        use egui::accesskit::{Action as Ask, ActionData};
        for request in input.accesskit_action_requests(response.id, Ask::SetValue) {
            if let Some(ActionData::NumericValue(value)) = request.data {
                actions.push(Action::SetTarget(value * rho));
            }
        }
        let steps = input.num_accesskit_action_requests(response.id, Ask::Increment) as f64
            - input.num_accesskit_action_requests(response.id, Ask::Decrement) as f64;
        if steps != 0.0 {
            actions.push(Action::Step(steps));
        }
    });
    if response.has_focus() {
        let keep = egui::EventFilter {
            horizontal_arrows: true,
            vertical_arrows: true,
            ..Default::default()
        };
        ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, keep));
    }
}
