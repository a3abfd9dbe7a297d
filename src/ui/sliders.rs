//! What the controls paint themselves. The two sliders: what is driven, beside the map, and the mesh
//! number mu_rho; and the pictures of a law, a ground and a machine to choose from.

use super::action::Action;
use super::theme::{self, Palette};
use super::view_state::{Told, ViewState};
use super::widgets::{Asks, Entry, named};
use super::words::explain;
use crate::physics::control::Control;
use crate::physics::indenter::Indenter;
use crate::physics::law::{self, Law};
use crate::plot::scale;
use crate::scene::edit::{self, MU_RHO, TICKS};
use egui::accesskit::{Action as Ask, ActionData};
use egui::{
    Align2, Button, EventFilter, FontId, Id, Mesh, Painter, Pos2, Rect, Response, Role, Sense,
    Shape, Stroke, StrokeKind, TextStyle, Ui, UiBuilder, WidgetInfo, pos2, vec2,
};

/// Accessible name of the slider of the mesh.
const MESH_NUMBER: &str = "mesh number mu_rho";

/// Id of the slider of what is driven: its keys work while it has the focus.
pub fn driven_id() -> Id {
    Id::unique("driven_slider")
}

/// Tells a screen reader of a slider with this value between two ends; the value it asks for.
fn speak(
    ui: &Ui,
    response: &Response,
    value: f64,
    (low, high): (f64, f64),
    name: &str,
) -> Option<f64> {
    response.widget_info(|| WidgetInfo::slider(true, value, name));
    ui.ctx().accesskit_node_builder(response.id, |node| {
        node.set_min_numeric_value(low);
        node.set_max_numeric_value(high);
        node.add_action(Ask::SetValue);
    });
    ui.input(|input| {
        let requests = input.accesskit_action_requests(response.id, Ask::SetValue);
        let value = |data: &Option<ActionData>| match data {
            Some(ActionData::NumericValue(value)) => Some(*value),
            _ => None,
        };
        requests.filter_map(|request| value(&request.data)).last()
    })
}

/// Lets these keys reach the slider that has the focus; else they would move the focus away.
fn keep(ui: &Ui, response: &Response, keys: EventFilter) {
    if response.has_focus() {
        ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, keys));
    }
}

/// Height of the row above and below the slider (points).
const ROW: f32 = 30.0;
/// Room of the numbers at its left.
const NUMBERS: f32 = 34.0;
/// Length of the arrow at the place where the surface is.
const ARROW: f32 = 9.0;
/// Width from which its marks have names.
const NAMED: f32 = 90.0;

/// The slider of what is driven, in the whole of the space: above it the target to be typed, below
/// it one step down and up.
pub fn driven(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let told = state.told();
    let rect = ui.max_rect();
    let row = |top: f32| Rect::from_min_size(pos2(rect.left(), top), vec2(rect.width() - 6.0, ROW));
    let mut above = ui.new_child(UiBuilder::new().max_rect(row(rect.top())));
    target(&mut above, state, &told, actions);
    let mut below = ui.new_child(UiBuilder::new().max_rect(row(rect.bottom() - ROW)));
    below.horizontal(|ui| {
        for (face, name, hover, step) in [
            (
                "−",
                "step down",
                "one increment down (← ↓); Shift: fine",
                -1.0,
            ),
            ("+", "step up", "one increment up (→ ↑); Shift: fine", 1.0),
        ] {
            let button = ui.add(Button::new(face).min_size(vec2(26.0, 24.0)));
            named(button, name)
                .on_hover_text(hover)
                .asks(actions, Action::Step(step));
        }
    });
    rail(ui, state, &told, actions, rect.shrink2(vec2(0.0, ROW)));
}

/// The target, to be typed.
fn target(ui: &mut Ui, state: &ViewState, told: &Told, actions: &mut Vec<Action>) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 3.0;
        ui.spacing_mut().button_padding.x = 4.0;
        ui.style_mut().drag_value_text_style = TextStyle::Small;
        ui.label(told.symbol).on_hover_text(told.name);
        let unit = told.unit;
        let field = Entry {
            name: "Target",
            value: state.target / unit,
            range: state.limits.0 / unit..=state.limits.1 / unit,
            speed: 0.01 * told.measure.scale,
            decimals: 4,
            suffix: &told.suffix,
        };
        let (entered, response) = field.show(ui);
        let response = explain(response, "Target");
        ui.ctx()
            .accesskit_node_builder(response.id, |node| node.set_label("Target"));
        actions.extend(entered.map(|value| Action::SetTarget(value * unit)));
    });
}

/// Up is away, so dragging down lowers the body. Two marks: where it should go, and where it is.
fn rail(ui: &Ui, state: &ViewState, told: &Told, actions: &mut Vec<Action>, rect: Rect) {
    let response = ui.interact(rect, driven_id(), Sense::click_and_drag());
    let rail = Rect::from_min_max(
        pos2(rect.left() + NUMBERS, rect.top() + 10.0),
        pos2(rect.left() + NUMBERS + 9.0, rect.bottom() - 10.0),
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
    speak_driven(ui, state, told, actions, &response);

    let palette = theme::palette(ui);
    ticks_of(ui, state, told.unit, rail, &y_of);
    let painter = ui.painter();
    painter.rect_filled(rail, 4.0, ui.visuals().widgets.inactive.bg_fill);
    let walked = Rect::from_min_max(
        pos2(rail.left(), y_of(state.run.actual)),
        rail.right_bottom(),
    );
    painter.rect_filled(walked, 4.0, palette.elastomer);
    let actual = y_of(state.run.actual);
    let tip = pos2(rail.center().x + 16.0, actual);
    let arrow = vec![tip, tip + vec2(ARROW, -6.0), tip + vec2(ARROW, 6.0)];
    painter.add(Shape::convex_polygon(
        arrow,
        palette.retraction,
        Stroke::NONE,
    ));
    let visuals = ui.style().interact(&response);
    let thumb = Rect::from_center_size(pos2(rail.center().x, y_of(state.target)), vec2(28.0, 13.0));
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
    let [target, now] = [state.target, state.run.actual].map(|value| told.say(value, 4));
    response.on_hover_text(format!("{}: target {target}, now {now}", told.name));
    if rect.width() > NAMED {
        marks(ui, rail, thumb.center(), tip, state);
    }
}

/// "target" and "actual" beside their marks, pushed apart where they would overlap.
fn marks(ui: &Ui, rail: Rect, target: Pos2, actual: Pos2, state: &ViewState) {
    let palette = theme::palette(ui);
    let x = rail.center().x + 19.0;
    let (mut target_y, mut actual_y) = (target.y, actual.y);
    // Each beside its mark's outer edge.
    if (target_y - actual_y).abs() < 20.0 {
        let middle = 0.5 * (target_y + actual_y);
        let up = if target_y <= actual_y { -11.0 } else { 11.0 };
        (target_y, actual_y) = (middle + up, middle - up);
    }
    let over = (target_y.max(actual_y) - rail.bottom()).max(0.0);
    (target_y, actual_y) = (target_y - over, actual_y - over);
    // Beside the arrow where it stands at the same height.
    let arrow = if (actual_y - actual.y).abs() < ARROW {
        ARROW
    } else {
        0.0
    };
    ui.painter().text(
        pos2(x, target_y),
        Align2::LEFT_CENTER,
        "target",
        FontId::proportional(theme::LEAST),
        palette.approach,
    );
    let word = if state.run.paused {
        "paused"
    } else if state.run.is_busy() {
        "now …"
    } else {
        "now"
    };
    ui.painter().text(
        pos2(x + arrow, actual_y),
        Align2::LEFT_CENTER,
        word,
        FontId::proportional(theme::LEAST),
        palette.retraction,
    );
}

fn ticks_of(ui: &Ui, state: &ViewState, unit: f64, rail: Rect, y_of: &dyn Fn(f64) -> f32) {
    let (low, high) = (state.limits.0 / unit, state.limits.1 / unit);
    let most = f64::from(rail.height() / 28.0).clamp(2.0, 9.0);
    let (values, spacing) = scale::within(low, high, most);
    let colour = ui.visuals().weak_text_color();
    for value in values {
        let y = y_of(value * unit);
        ui.painter().hline(
            rail.left() - 8.0..=rail.left() - 4.0,
            y,
            Stroke::new(1.0, colour),
        );
        let text = scale::label(value, spacing);
        ui.painter().text(
            pos2(rail.left() - 11.0, y),
            Align2::RIGHT_CENTER,
            text,
            theme::small(),
            colour,
        );
    }
}

/// The slider for a screen reader, and what it asks for.
fn speak_driven(
    ui: &Ui,
    state: &ViewState,
    told: &Told,
    actions: &mut Vec<Action>,
    response: &Response,
) {
    let unit = told.unit;
    let limits = (state.limits.0 / unit, state.limits.1 / unit);
    let symbol = told.symbol.replace('₀', "0");
    let name = format!("{} {symbol}", told.name.to_lowercase());
    let wanted = speak(ui, response, state.target / unit, limits, &name);
    actions.extend(wanted.map(|value| Action::SetTarget(value * unit)));
    ui.ctx().accesskit_node_builder(response.id, |node| {
        node.set_role(Role::Slider);
        node.set_numeric_value_step(state.scene.drive.step / unit);
        node.add_action(Ask::Increment);
        node.add_action(Ask::Decrement);
    });
    let steps = ui.input(|input| {
        input.num_accesskit_action_requests(response.id, Ask::Increment) as f64
            - input.num_accesskit_action_requests(response.id, Ask::Decrement) as f64
    });
    if steps != 0.0 {
        actions.push(Action::Step(steps));
    }
    let arrows = EventFilter {
        horizontal_arrows: true,
        vertical_arrows: true,
        ..EventFilter::default()
    };
    keep(ui, response, arrows);
}

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

/// The slider of mu_rho: logarithmic, with the named meshes of Table 1 beneath and a hatched zone
/// where the mesh lies.
pub fn mu_rho(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let width = ui.available_width();
    let (_, rect) = ui.allocate_space(vec2(width, 80.0));
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
    speak_mu_rho(ui, state, &response, &mut wanted);
    paint(ui, state, rail, &x_of, &response);
    for ((name, mu), place) in TICKS.into_iter().zip(PLACES) {
        if tick(ui, rail, x_of(mu), (name, mu), place) {
            wanted = Some(mu);
        }
    }
    explain(response, "Mesh number μᵨ");
    if let Some(mu) = wanted {
        let scene = edit::with_mu_rho(&state.scene, &state.model, mu, state.follows);
        actions.push(Action::edit(scene));
    }
}

fn paint(ui: &Ui, state: &ViewState, rail: Rect, x_of: &dyn Fn(f64) -> f32, response: &Response) {
    let palette = theme::palette(ui);
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
    let y = rail.bottom() + 13.0 + 16.0 * row as f32;
    let (anchor, at) = if right {
        (Align2::LEFT_CENTER, pos2(x + 3.0, y))
    } else {
        (Align2::RIGHT_CENTER, pos2(x - 3.0, y))
    };
    let galley = ui.painter().layout_no_wrap(
        name.to_owned(),
        FontId::proportional(theme::LEAST),
        ui.visuals().weak_text_color(),
    );
    let area = anchor.anchor_size(at, galley.size());
    let response = ui.interact(area, Id::unique(("mu_rho_tick", name)), Sense::click());
    response
        .widget_info(|| WidgetInfo::labeled(Role::Button, true, format!("mu_rho of {name}, {mu}")));
    let colour = if response.hovered() || response.has_focus() {
        ui.visuals().strong_text_color()
    } else {
        ui.visuals().weak_text_color()
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

/// The slider for a screen reader and for the arrow keys, and what they ask for.
fn speak_mu_rho(ui: &Ui, state: &ViewState, response: &Response, wanted: &mut Option<f64>) {
    let clamped = |mu: f64| mu.clamp(MU_RHO.0, MU_RHO.1);
    let mu = state.model.mu_rho;
    let asked = speak(ui, response, mu, MU_RHO, MESH_NUMBER);
    *wanted = asked.map(clamped).or(*wanted);
    let arrows = EventFilter {
        horizontal_arrows: true,
        ..EventFilter::default()
    };
    keep(ui, response, arrows);
    if response.has_focus() {
        let steps = ui.input(|i| {
            i.num_presses(egui::Key::ArrowRight) as f64 - i.num_presses(egui::Key::ArrowLeft) as f64
        });
        if steps != 0.0 {
            *wanted = Some(clamped(mu * 1.02f64.powf(steps)));
        }
    }
}

/// The law's traction against the gap.
pub fn traction(shape: law::Shape, painter: &Painter, rect: Rect, palette: &Palette) {
    let law = Law {
        shape,
        surface_energy: 1.0,
        range: 1.0,
    };
    let (top, axis) = (rect.top() + 7.0, rect.bottom() - 17.0);
    painter.hline(
        rect.x_range().shrink(6.0),
        axis,
        Stroke::new(1.0, palette.flat),
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
}

/// Points of an outline.
const OUTLINE: usize = 48;

/// The outline of a kind of ground, filled to below. Without its numbers: it stands for the kind.
pub fn sketch(kind: &Indenter, painter: &Painter, rect: Rect, palette: &Palette) {
    let (left, right) = (rect.left() + 8.0, rect.right() - 8.0);
    let (top, low) = (rect.top() + 8.0, rect.bottom() - 20.0);
    let mut filled = Mesh::default();
    let mut line = Vec::new();
    for i in 0..=OUTLINE {
        let x = i as f32 / OUTLINE as f32;
        let height = kind.ground().outline(f64::from(x)) as f32;
        let at = pos2(left + x * (right - left), low - height * (low - top));
        filled.colored_vertex(at, palette.indenter);
        filled.colored_vertex(pos2(at.x, low + 2.0), palette.indenter);
        line.push(at);
    }
    for k in 0..OUTLINE as u32 {
        filled.add_triangle(2 * k, 2 * k + 1, 2 * k + 2);
        filled.add_triangle(2 * k + 1, 2 * k + 2, 2 * k + 3);
    }
    painter.add(filled);
    if matches!(kind, Indenter::Measured(_)) {
        // The points of a measurement.
        for at in line.iter().step_by(6) {
            painter.circle_filled(*at, 2.2, palette.approach);
        }
    } else {
        painter.line(line, Stroke::new(1.4, palette.now));
    }
}

/// A stage above, the body below, and what is between.
pub fn machine(kind: Control, painter: &Painter, rect: Rect, palette: &Palette) {
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
