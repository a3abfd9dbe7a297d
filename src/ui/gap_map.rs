//! The gap map: one texture, its colour bar, the contact line, and what is under the pointer; and beside
//! it the map of another scene.

use super::action::{Action, ProfileLine, ViewOptions};
use super::gap_picture::{GapPicture, MapCache, Maps, Segment};
use super::view_state::ViewState;
use super::widgets::{described, named};
use super::{grip, headline, sliders, theme};
use crate::lessons::Hidden;
use crate::physics::parameter::Dimension;
use crate::plot::scale;
use crate::scene::parameter::fixed;
use egui::{
    Align2, Color32, CursorIcon, Galley, Pos2, Rect, Sense, Shape, Stroke, StrokeKind, Ui,
    UiBuilder, Vec2, pos2, vec2,
};
use std::sync::Arc;

/// Width of the colour bar with its numbers, and where there is less room.
const BAR: (f32, f32) = (80.0, 50.0);
/// Room between two maps.
const BESIDE: f32 = 10.0;
/// Radius of the grip of the profile line.
const GRIP: f32 = 7.0;
/// Seconds in which a picture that is no longer true fades out.
const FADE: f32 = 0.2;
/// What stands in its place.
const WAITING: &str = "waiting for the solver …";

/// Height of the line below the map, and what the profile takes of the column.
const READING: f32 = 22.0;
const PROFILE: f32 = 0.24;
/// Height of the strip below the profile, with its margins.
pub const STRIP: f32 = 54.0;
/// The least height of the profile.
const PROFILE_LEAST: f32 = 84.0;
/// Width of the slider beside the map, and where there is less room.
const SLIDER: (f32, f32) = (122.0, 88.0);
/// Width of the column from which the first holds.
const WIDE: f32 = 420.0;

/// The headline, the slider of what is driven, the map, with one beside it that of another scene,
/// and their reading; what is left of the column is the profile's.
pub fn show(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>, maps: &Maps) {
    let cache = &maps.a;
    headline::surface(ui, state, actions);
    let width = ui.available_width();
    let (slider, bar) = if width < WIDE {
        (SLIDER.1, BAR.1)
    } else {
        (SLIDER.0, BAR.0)
    };
    let beside = state.beside();
    // Two maps take what a profile can spare.
    let profile = beside.map_or(PROFILE * ui.available_height(), |_| 0.0);
    let below = profile.max(PROFILE_LEAST) + STRIP + READING + 12.0;
    let room = vec2(width - slider - bar, ui.available_height() - below);
    // Beside the other one or above it, whichever makes both larger.
    let [row, column] = [vec2(1.0, 0.0), vec2(0.0, 1.0)].map(|way| {
        let way = beside.map_or(Vec2::ZERO, |_| way);
        let left = room - BESIDE * way;
        (way, (left / (way + Vec2::splat(1.0))).min_elem().max(80.0))
    });
    let (way, side) = if column.1 > row.1 { column } else { row };
    let size = side * (way + Vec2::splat(1.0)) + BESIDE * way;
    let (_, area) = ui.allocate_space(vec2(width, size.y));
    let column = Rect::from_min_size(area.min, vec2(slider, size.y));
    let mut driven = ui.new_child(UiBuilder::new().max_rect(column));
    sliders::driven(&mut driven, state, actions);
    let left = area.left() + slider + ((room.x - size.x) / 2.0).max(0.0);
    let map = Rect::from_min_size(pos2(left, area.top()), vec2(side, side));
    let last = map.translate((side + BESIDE) * way);
    let response = ui.interact(map, egui::Id::unique("gap_map"), Sense::click_and_drag());
    let sentence = sentence(state, cache);
    described(&response, &sentence);

    // A line cell is the same everywhere along y: it fills the square.
    let band = map;
    ui.painter()
        .rect_filled(map, 0.0, ui.visuals().extreme_bg_color);
    if cache.draw(ui, band)
        && let Some(picture) = &cache.picture
    {
        soft_mode(ui, state, cache, picture, band);
        profile_line(ui, state, picture, band);
    }
    waiting(ui, state, map);
    ui.painter()
        .rect_stroke(map, 0.0, frame_stroke(ui, state), StrokeKind::Outside);
    colour_bar(ui, state, cache, map.union(last));
    if beside.is_some() {
        letter(ui, map, "A", Align2::LEFT_TOP);
        show_beside(ui, state, &maps.b, last, actions);
    }
    overlays(ui, state, map);
    let per_point = (state.limits.1 - state.limits.0) / f64::from(map.height());
    if grip::presses(ui, state) {
        if let Some(picture) = &cache.picture {
            let on = (&response, band);
            grip::press(ui, state, on, picture, per_point, actions);
        }
    } else {
        grip::drag(ui, state, &response, per_point, actions);
        if let Some(picture) = &cache.picture {
            line_grip(ui, state, picture, band, actions);
        }
    }
    let reading = cache.picture.as_ref().and_then(|picture| {
        let on_the_map = response.hover_pos().filter(|at| band.contains(*at));
        let place = on_the_map.map(|at| {
            let share = (at - band.left_bottom()) / band.size();
            [share.x, -share.y]
        });
        let place = place.or_else(|| over_profile(ui, &state.view, picture))?;
        Some(reading(state, picture, place))
    });
    let reading = state.push_in_words().or(reading);
    reading_line(ui, state, reading.or_else(|| state.losses_in_words()));
}

/// The line below the map: what is under the pointer, or what is ahead, or how to use it.
fn reading_line(ui: &mut Ui, state: &ViewState, reading: Option<String>) {
    let mut colour = ui.visuals().text_color();
    let words = reading.or_else(|| {
        let (pattern, sample) = state
            .foreseen()
            .filter(|_| !state.hides(Hidden::Forecast))?;
        colour = theme::palette(ui).live;
        let stress = sample.stress / state.model.law.traction_max();
        let unit = state.model.unit(Dimension::Stress);
        let stress = unit.say(stress, 3, "σₘₐₓ");
        Some(format!("ahead: {}, stress {stress}", pattern.words()))
    });
    let words = words.unwrap_or_else(|| "Point at map or profile to read it.".to_owned());
    let words = egui::RichText::new(words).small().color(colour);
    ui.add(egui::Label::new(words).truncate()).on_hover_text(
        "Drag the map up and down to move the body, and the profile line by its grip.",
    );
}

/// The soft mode: solid lines where it lifts the surface, dotted ones where it lowers it, and what
/// they mean in the corner.
fn soft_mode(ui: &Ui, state: &ViewState, cache: &MapCache, picture: &GapPicture, band: Rect) {
    let of_a_branch = state.pictured().is_some_and(|f| f.is_of_a_branch());
    if !(state.view.soft_mode || of_a_branch && cache.mode.is_some()) {
        return;
    }
    let painter = ui.painter().with_clip_rect(band.intersect(ui.clip_rect()));
    let colour = theme::over_maps().jump;
    let segment = |s: &Segment, width: f32, colour: Color32| {
        painter.line_segment(
            s.map(|p| picture.to_screen(band, p)),
            Stroke::new(width, colour),
        );
    };
    if let Some(lines) = &cache.mode {
        // Every second mesh square or so, whichever way the line runs.
        let dotted = || {
            lines.down.iter().filter(|s| {
                (s[0][0].min(s[1][0]) as usize + 2 * s[0][1].min(s[1][1]) as usize) % 4 < 2
            })
        };
        for (width, ink) in [(3.2, Color32::from_black_alpha(110)), (1.5, colour)] {
            let all = lines.up.iter().chain(dotted());
            all.for_each(|s| segment(s, width, ink));
        }
    }
    let words = match &cache.mode {
        Some(_) if picture.min == picture.max => {
            "soft mode (one of the equal first waves): — up  ┈ down"
        }
        Some(_) if of_a_branch => "unstable mode: — up  ┈ down",
        Some(_) => "soft mode: — up  ┈ down",
        None if of_a_branch => "stable: no mode gives way",
        None => "no soft mode while jumping",
    };
    let galley = painter.layout_no_wrap(words.to_owned(), theme::small(), colour);
    let area = Rect::from_min_size(
        band.left_bottom() + vec2(6.0, -galley.size().y - 12.0),
        galley.size() + vec2(12.0, 6.0),
    );
    painter.rect_filled(area, 5.0, Color32::from_black_alpha(190));
    painter.galley(area.min + vec2(6.0, 3.0), galley, colour);
}

/// Id of the profile: what lies under the pointer there is read below the map as well, where it
/// covers nothing.
pub fn profile_id() -> egui::Id {
    egui::Id::unique("profile")
}

/// The place of the cell under the pointer over the profile, in shares from the lower left corner.
fn over_profile(ui: &Ui, view: &ViewOptions, picture: &GapPicture) -> Option<[f32; 2]> {
    let profile = ui.ctx().read_response(profile_id())?;
    let share = (profile.hover_pos()?.x - profile.rect.left()) / profile.rect.width();
    let ((ny, nx), (along_x, index)) = (picture.gap.dim(), cut(view, picture));
    let across = |n: usize| (index as f32 + 0.5) / n as f32;
    Some(if along_x {
        [share, across(ny)]
    } else {
        [across(nx), share]
    })
}

/// The line of the profile: (along x, index of row or column).
pub fn cut(view: &ViewOptions, picture: &GapPicture) -> (bool, usize) {
    let (ny, nx) = picture.gap.dim();
    let index = |share: f64, n: usize| ((share * n as f64) as usize).min(n - 1);
    match view.profile {
        _ if ny == 1 => (true, 0),
        ProfileLine::Auto => {
            let (row, column, along_x) = picture.middle();
            (along_x, if along_x { row } else { column })
        }
        ProfileLine::AlongX(share) => (true, index(share, ny)),
        ProfileLine::AlongY(share) => (false, index(share, nx)),
    }
}

/// The two ends of the profile line; `None` where the cell is a line itself.
fn line_ends(state: &ViewState, picture: &GapPicture, band: Rect) -> Option<[Pos2; 2]> {
    let (along_x, index) = cut(&state.view, picture);
    let (ny, nx) = picture.gap.dim();
    let at = index as f32 + 0.5;
    let ends = if along_x {
        [[0.0, at], [nx as f32, at]]
    } else {
        [[at, 0.0], [at, ny as f32]]
    };
    (ny > 1).then(|| ends.map(|p| picture.to_screen(band, p)))
}

fn profile_line(ui: &Ui, state: &ViewState, picture: &GapPicture, band: Rect) {
    let Some(ends) = line_ends(state, picture, band) else {
        return;
    };
    let colour = theme::over_maps().retraction;
    for (width, ink) in [(3.0, Color32::from_black_alpha(120)), (1.5, colour)] {
        let line = Shape::dashed_line(&ends, Stroke::new(width, ink), 7.0, 5.0);
        ui.painter().extend(line);
    }
}

fn colour_bar(ui: &Ui, state: &ViewState, cache: &MapCache, map: Rect) {
    let bar = Rect::from_min_max(
        pos2(map.right() + 10.0, map.top() + 26.0),
        pos2(map.right() + 22.0, map.bottom() - 2.0),
    );
    let unit = state.model.unit(Dimension::Length);
    let one = state.rho() / unit.scale;
    let top = scale::gap_scale(&state.scene, &state.model) / one;
    let (steps, colours) = (64, state.view.colours);
    for i in 0..steps {
        let (a, b) = (i as f32 / steps as f32, (i + 1) as f32 / steps as f32);
        let stripe = Rect::from_x_y_ranges(
            bar.x_range(),
            bar.bottom() - b * bar.height() - 0.5..=bar.bottom() - a * bar.height(),
        );
        ui.painter().rect_filled(
            stripe,
            0.0,
            theme::rgb(colours.at(f64::from(0.5 * (a + b)))),
        );
    }
    let text = ui.visuals().text_color();
    ui.painter().text(
        pos2(bar.left() - 2.0, map.top()),
        Align2::LEFT_TOP,
        unit.label("gap / ρ", "gap"),
        theme::small(),
        text,
    );
    let y_of = |value: f64| bar.bottom() - (value / top) as f32 * bar.height();
    let contact = y_of(state.model.law.contact_gap() / one);
    let named = ui.clip_rect().right() > bar.right() + 58.0;
    let most = f64::from(bar.height() / 28.0).clamp(2.0, 8.0);
    let (values, spacing) = scale::within(0.0, top * 1.001, most);
    for value in values {
        let y = y_of(value);
        ui.painter()
            .hline(bar.right()..=bar.right() + 4.0, y, Stroke::new(1.0, text));
        // The contact's own tick goes before the number beside it.
        if named && (y - contact).abs() < 15.0 {
            continue;
        }
        let above = value + spacing > top * 1.001
            && cache.picture.as_ref().is_some_and(|p| p.max / one > top);
        let label = format!(
            "{}{}",
            if above { "≥" } else { "" },
            scale::label(value, spacing)
        );
        ui.painter().text(
            pos2(bar.right() + 7.0, y),
            Align2::LEFT_CENTER,
            label,
            theme::small(),
            text,
        );
    }
    ui.painter()
        .hline(bar.x_range(), contact, Stroke::new(1.6, Color32::WHITE));
    if named {
        let font = egui::FontId::proportional(theme::LEAST);
        let at = pos2(bar.right() + 4.0, contact);
        ui.painter()
            .text(at, Align2::LEFT_CENTER, "contact", font, text);
    }
}

/// The border of map and profile: that of a replay, or of a stored or foreseen state, stands out.
pub fn frame_stroke(ui: &Ui, state: &ViewState) -> Stroke {
    if state.run.replayed.is_some() {
        Stroke::new(2.5, theme::palette(ui).jump)
    } else if state.run.shown.is_some() {
        let palette = theme::palette(ui);
        let is_foreseen = state.shown_word() == Some("foreseen");
        Stroke::new(
            2.5,
            if is_foreseen {
                palette.live
            } else {
                palette.now
            },
        )
    } else {
        ui.visuals().widgets.noninteractive.bg_stroke
    }
}

/// The word "jumping" while the surface is no equilibrium, and "replay", "stored" or "foreseen"
/// while another one than the present is shown.
fn overlays(ui: &Ui, state: &ViewState, map: Rect) {
    let Some(word) = state.shown_word().or(grip::press_word(state)) else {
        return;
    };
    let size = if map.width() > 330.0 { 17.0 } else { 13.0 };
    let galley = ui.painter().layout(
        word.to_owned(),
        egui::FontId::proportional(size),
        Color32::WHITE,
        map.width() - 32.0,
    );
    let centre = pos2(map.center().x, map.top() + 30.0);
    let area = Rect::from_center_size(centre, galley.size() + vec2(24.0, 12.0));
    ui.painter()
        .rect_filled(area, 8.0, Color32::from_black_alpha(170));
    ui.painter()
        .galley(area.center() - galley.size() / 2.0, galley, Color32::WHITE);
}

/// Fades the last run's picture out while the solver has said nothing of this one. An answer within
/// a few frames is no flicker.
fn waiting(ui: &Ui, state: &ViewState, map: Rect) {
    let waits = state.is_waiting();
    let share = ui.ctx().animate_bool_with_time(
        egui::Id::unique("waiting"),
        waits,
        if waits { FADE } else { 0.0 },
    );
    if share > 0.0 {
        ui.painter().rect_filled(
            map,
            0.0,
            ui.visuals().extreme_bg_color.gamma_multiply(0.85 * share),
        );
    }
    if waits {
        let colour = ui.visuals().text_color().gamma_multiply(share.max(0.3));
        let words = if state.messages.failure.is_some() {
            "no picture of this scene"
        } else {
            WAITING
        };
        ui.painter().text(
            map.center(),
            Align2::CENTER_CENTER,
            words,
            theme::small(),
            colour,
        );
    }
}

/// The grip at the end of the profile line: dragged it moves the line, with Shift an upright one; a
/// double click frees it.
fn line_grip(
    ui: &Ui,
    state: &ViewState,
    picture: &GapPicture,
    band: Rect,
    actions: &mut Vec<Action>,
) {
    let Some([end, _]) = line_ends(state, picture, band) else {
        return;
    };
    let centre = band.shrink(GRIP + 2.0).clamp(end);
    let area = Rect::from_center_size(centre, vec2(2.6 * GRIP, 2.6 * GRIP));
    let id = egui::Id::unique("profile_line");
    let response = ui.interact(area, id, Sense::click_and_drag());
    let response = named(response, "Profile line");
    let colour = theme::over_maps().retraction;
    let edge = Stroke::new(2.0, Color32::from_black_alpha(190));
    ui.painter().circle(centre, GRIP, colour, edge);
    let upright = ui.input(|i| i.modifiers.shift);
    if response.hovered() || response.dragged() {
        let flat = (cut(&state.view, picture).0) != upright;
        ui.ctx().set_cursor_icon(if flat {
            CursorIcon::ResizeVertical
        } else {
            CursorIcon::ResizeHorizontal
        });
    }
    let mut view = state.view;
    if response.double_clicked() {
        view.profile = ProfileLine::Auto;
    } else if response.dragged()
        && let Some(at) = response.interact_pointer_pos()
    {
        let x = f64::from((at.x - band.left()) / band.width()).clamp(0.0, 1.0);
        let y = f64::from((band.bottom() - at.y) / band.height()).clamp(0.0, 1.0);
        view.profile = if upright {
            ProfileLine::AlongY(x)
        } else {
            ProfileLine::AlongX(y)
        };
    }
    if view != state.view {
        actions.push(Action::SetView(view));
    }
    response.on_hover_text(
        "drag: the line of the profile (with Shift an upright one); double-click: through the \
         middle of the pattern again",
    );
}

/// Gap and traction at a place, in shares of the cell from its lower left corner.
fn reading(state: &ViewState, picture: &GapPicture, [x, y]: [f32; 2]) -> String {
    let (ny, nx) = picture.gap.dim();
    let index = |share: f32, n: usize| ((share * n as f32) as usize).min(n - 1);
    let gap = picture.gap[(index(y, ny), index(x, nx))];
    let (rho, length) = (state.rho(), state.model.grid.length);
    let traction = state.model.law.at(gap).traction / state.model.law.traction_max();
    let (model, across) = (&state.model, state.model.unit_across());
    let force = if traction >= 0.0 { "pulls" } else { "pushes" };
    format!(
        "x {}   y {}   gap {}   {force} {}",
        across.say(f64::from(x) * length / rho, 1, "ρ"),
        across.say(f64::from(y) * length / rho, 1, "ρ"),
        model.unit(Dimension::Length).say(gap / rho, 3, "ρ"),
        model.unit(Dimension::Stress).say(traction.abs(), 3, "σₘₐₓ")
    )
}

/// The map in one sentence.
fn sentence(state: &ViewState, cache: &MapCache) -> String {
    let Some(picture) = cache.picture.as_ref().filter(|_| !state.is_waiting()) else {
        return format!("Gap map: {WAITING}");
    };
    let (kind, shown) = match (&state.run.shown, state.shown_word()) {
        (Some(frame), Some(word)) if state.run.replayed.is_none() => {
            (format!("{word} "), frame.state.as_ref())
        }
        _ => (String::new(), state.run.state.as_ref()),
    };
    let pattern = shown.map_or("at rest", |s| s.pattern.words());
    let unit = state.model.unit(Dimension::Length);
    format!(
        "Gap map: {kind}{pattern}, gap from {} to {}",
        unit.number(picture.min / state.rho(), 3),
        unit.say(picture.max / state.rho(), 3, "rho")
    )
}

/// Draws the map of the scene beside in its place; dragged it drives both.
fn show_beside(
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
    if !grip::presses(ui, state) {
        let per_point = (state.limits.1 - state.limits.0) / f64::from(map.height());
        grip::drag(ui, state, &response, per_point, actions);
    }
}

/// Words in a corner of a map, cut where they are too long.
fn letter(ui: &Ui, map: Rect, words: &str, corner: Align2) {
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
