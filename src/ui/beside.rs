//! The map of the scene that stands beside the present one.

use super::action::Action;
use super::flick;
use super::grip;
use super::map_cache::MapCache;
use super::theme;
use super::view_state::ViewState;
use super::widgets::described;
use crate::scene::units::fixed;
use egui::{Align2, Color32, Galley, Rect, Sense, Stroke, StrokeKind, Ui, vec2};
use std::sync::Arc;

/// Draws it in its place; dragged it drives both.
pub fn show(
    ui: &mut Ui,
    state: &ViewState,
    cache: &MapCache,
    map: Rect,
    actions: &mut Vec<Action>,
) {
    let Some((beside, kept)) = state.beside() else {
        return;
    };
    let response = ui.interact(map, egui::Id::unique("map_b"), Sense::click_and_drag());
    ui.painter()
        .rect_filled(map, 0.0, ui.visuals().extreme_bg_color);
    let words = match &beside.shown {
        Ok(frame) => {
            let pattern = frame.state.as_ref().map_or("at rest", |s| s.pattern.word());
            let u0 = frame.mean_displacement / kept.model.law.range;
            cache.draw(ui, map);
            format!("{pattern}, u₀ {} ρ", fixed(u0, 3))
        }
        Err(why) => why.clone(),
    };
    described(&response, &format!("B, {}: {words}", kept.name));
    let edge = Stroke::new(2.5, theme::rgb(kept.look().0.on(theme::ground(ui))));
    ui.painter()
        .rect_stroke(map, 0.0, edge, StrokeKind::Outside);
    letter(ui, map, &format!("B: {}", kept.name), Align2::LEFT_TOP);
    letter(ui, map, &words, Align2::LEFT_BOTTOM);
    // It is the present surface that is pressed.
    if !flick::is_on(ui, state) {
        let per_point = (state.limits.1 - state.limits.0) / f64::from(map.height());
        grip::drag(ui, state, &response, per_point, actions);
    }
}

/// Words in a corner of a map, cut where they are too long.
pub fn letter(ui: &Ui, map: Rect, words: &str, corner: Align2) {
    let galley: Arc<Galley> = ui.painter().layout(
        words.to_owned(),
        theme::small(),
        Color32::WHITE,
        map.width() - 22.0,
    );
    let size = galley.size() + vec2(12.0, 6.0);
    let area = corner.align_size_within_rect(size, map.shrink(4.0));
    ui.painter()
        .rect_filled(area, 5.0, Color32::from_black_alpha(170));
    let at = area.min + vec2(6.0, 3.0);
    ui.painter().galley(at, galley, Color32::WHITE);
}
