//! The gallery of scenes: a picture of the loop and the ground of each, its title, and one question
//! to take along.

use super::action::Action;
use super::grounds;
use super::theme::{self, Palette};
use super::view_state::ViewState;
use super::widgets::named;
use crate::follow::record::Direction;
use crate::plot::typeset::plain;
use crate::scene::Scene;
use crate::storage::presets::{self, Preset};
use egui::{
    Align, Button, Id, Layout, Painter, Popup, PopupCloseBehavior, Rect, RichText, ScrollArea,
    Sense, Stroke, StrokeKind, Ui, pos2, vec2,
};
use std::sync::LazyLock;

/// Size of a card, of its picture, and the room between two cards (points).
const CARD: egui::Vec2 = vec2(236.0, 156.0);
const PICTURE: f32 = 76.0;
const GAP: f32 = 8.0;
/// Most cards in a row.
const COLUMNS: usize = 4;
/// Width from which the button has a title.
const TITLED: f32 = 90.0;

/// The scenes of the presets, in their order.
static SCENES: LazyLock<Vec<Option<Scene>>> = LazyLock::new(|| {
    presets::all()
        .iter()
        .map(|preset| preset.scene().ok())
        .collect()
});

/// The button of this width, with the title of the present scene; it opens the gallery.
pub fn button(ui: &mut Ui, state: &ViewState, width: f32, actions: &mut Vec<Action>) {
    let title = plain(&state.scene.title);
    let face = if width < TITLED {
        "▦".to_owned()
    } else {
        format!("▦  {title}")
    };
    let button = Button::new(face).truncate().min_size(vec2(width, 28.0));
    let response = ui.add_sized(vec2(width, 28.0), button);
    let response =
        named(response, "Preset").on_hover_text(format!("{title}\n{}", state.scene.source));
    Popup::menu(&response)
        .close_behavior(PopupCloseBehavior::CloseOnClickOutside)
        .show(|ui| cards(ui, state, actions));
}

fn cards(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let screen = ui.ctx().content_rect().size();
    let columns = (((screen.x - 40.0) / (CARD.x + GAP)) as usize).clamp(1, COLUMNS);
    ui.set_width(columns as f32 * (CARD.x + GAP) + 6.0);
    let opened = presets::titled(state.title_opened());
    ScrollArea::vertical()
        .max_height(screen.y - 90.0)
        .min_scrolled_height(screen.y - 90.0)
        .show(ui, |ui| {
            ui.spacing_mut().item_spacing = vec2(GAP, GAP);
            for (row, presets) in presets::all().chunks(columns).enumerate() {
                ui.horizontal(|ui| {
                    for (column, preset) in presets.iter().enumerate() {
                        let index = row * columns + column;
                        if card(ui, preset, index, opened == Some(preset)) {
                            actions.push(Action::LoadPreset(index));
                            ui.close();
                        }
                    }
                });
            }
        });
}

/// One scene; true when it was chosen.
fn card(ui: &mut Ui, preset: &Preset, index: usize, chosen: bool) -> bool {
    let (_, rect) = ui.allocate_space(CARD);
    let response = ui.interact(rect, Id::unique(("gallery", index)), Sense::click());
    let title = plain(preset.title());
    let response = named(response, &format!("Preset {}: {title}", preset.name));
    let visuals = ui.style().interact_selectable(&response, chosen);
    let palette = theme::palette(ui);
    let edge = if chosen || response.has_focus() {
        Stroke::new(2.0, palette.approach)
    } else {
        visuals.bg_stroke
    };
    let fill = ui.visuals().extreme_bg_color;
    let painter = ui.painter().with_clip_rect(rect.intersect(ui.clip_rect()));
    painter.rect(rect.shrink(1.0), 6.0, fill, edge, StrokeKind::Inside);
    let picture = Rect::from_min_size(rect.min, vec2(CARD.x, PICTURE));
    thumbnail(preset, index, &painter, picture, &palette);
    let mut top = rect.top() + PICTURE;
    let key = if index < 9 {
        format!("{}  ", index + 1)
    } else {
        String::new()
    };
    for (words, size, colour) in [
        (
            format!("{key}{}", preset.title()),
            theme::TICK,
            ui.visuals().strong_text_color(),
        ),
        (
            preset.question(),
            theme::LEAST,
            ui.visuals().weak_text_color(),
        ),
    ] {
        let mut words = theme::set(&words, size, colour);
        words.wrap.max_width = CARD.x - 20.0;
        let galley = painter.layout_job(words);
        let height = galley.size().y;
        painter.galley(pos2(rect.left() + 10.0, top), galley, colour);
        top += height + 3.0;
    }
    response.clicked()
}

/// The loop on the left, the ground on the right.
fn thumbnail(preset: &Preset, index: usize, painter: &Painter, rect: Rect, palette: &Palette) {
    let inside = rect.shrink2(vec2(10.0, 8.0));
    let split = inside.left() + 0.62 * inside.width();
    let plot = Rect::from_min_max(inside.min, pos2(split, inside.bottom()));
    for (direction, points) in preset.thumbnail() {
        let colour = match direction {
            Direction::Approach => palette.approach,
            Direction::Retraction => palette.retraction,
        };
        let at = |[x, y]: [f32; 2]| {
            pos2(
                plot.left() + x * plot.width(),
                plot.bottom() - y * plot.height(),
            )
        };
        painter.line(
            points.into_iter().map(at).collect(),
            Stroke::new(1.8, colour),
        );
    }
    if let Some(Some(scene)) = SCENES.get(index) {
        let ground = Rect::from_min_max(pos2(split + 8.0, inside.top()), inside.max);
        grounds::sketch(&scene.indenter, painter, ground, palette);
    }
}

/// A button to what there is to see in the preset that was opened, if it was one.
pub fn look_for(ui: &mut Ui, state: &ViewState) {
    let Some(preset) = presets::titled(state.title_opened()) else {
        return;
    };
    let card = ui.menu_button("ℹ", |ui| {
        ui.set_width(360.0);
        // A menu's own layout justifies its lines.
        ui.with_layout(Layout::top_down(Align::LEFT), |ui| {
            let strong = ui.visuals().strong_text_color();
            ui.label(theme::set(state.title_opened(), theme::BODY, strong));
            let plain = ui.visuals().text_color();
            ui.label(theme::set(&preset.look_for(), theme::TICK, plain));
            ui.label(RichText::new(&state.scene.source).small().weak());
        });
    });
    named(card.response, "What to look for").on_hover_text("what to look for in this preset");
}
