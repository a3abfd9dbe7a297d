//! Why did it snap? Pictures of the last jump (or of the one that is looked at), the criterion with
//! its numbers, what was released, and a replay. Before any jump: what can happen.

use super::{Tab, Title, Update};
use crate::follow::record::JumpRecord;
use crate::lessons::Hidden;
use crate::physics::parameter::Dimension;
use crate::plot::scale;
use crate::plot::style::Colours;
use crate::scene::Scene;
use crate::scene::parameter::fixed;
use crate::study::forecast::ahead;
use crate::study::why::{Evidence, Explanation, explain};
use crate::ui::action::Action;
use crate::ui::gap_picture::{self, GapPicture};
use crate::ui::theme;
use crate::ui::view_state::ViewState;
use crate::ui::widgets::{Asks, described, named};
use crate::ui::words;
use crate::worker::protocol::{Film, Frame, RunId};
use egui::{
    Align2, Context, FontId, Rect, RichText, ScrollArea, Sense, Slider, Stroke, StrokeKind,
    TextStyle, TextureHandle, Ui, WidgetInfo, vec2,
};
use std::sync::Arc;
use std::time::Duration;

/// Seconds that a replay takes, and between two of its pictures on the screen.
const REPLAY: f64 = 4.0;
const PICTURE: Duration = Duration::from_millis(33);
/// Least and largest side of a map, and the room between two (points).
const SIDE: (f32, f32) = (44.0, 120.0);
const GAP: f32 = 8.0;
/// Room of the buttons beside the maps, and the width from which they stand there.
const COLUMN: f32 = 190.0;
const BESIDE: f32 = 406.0;
/// Height of the tab below which maps and sentence have no room together.
const LOW: f32 = 150.0;
/// Height of the row that replays.
const ROW: f32 = 28.0;
/// Width and height of a map's name.
const NAME: egui::Vec2 = vec2(66.0, 17.0);

/// The tab.
#[derive(Default)]
pub struct Why {
    told: Option<Told>,
    replay: Option<Replay>,
}

/// A jump with what is said and shown of it.
struct Told {
    /// Of which run, and at which place among its jumps.
    run: RunId,
    index: usize,
    jump: JumpRecord,
    film: Option<Arc<Film>>,
    /// Of the pictures: the pattern in the middle, between mesh points as well, their colours.
    drawn: (bool, bool, Colours),
    why: Explanation,
    /// Before, soft mode, after.
    maps: Vec<Map>,
}

/// A small map: what it is, and what it shows.
struct Map {
    name: &'static str,
    shows: String,
    texture: TextureHandle,
    /// Whose contact has its edge drawn.
    picture: Option<GapPicture>,
}

/// A film that is looked at again.
struct Replay {
    film: Arc<Film>,
    /// The place in it, in pictures.
    at: f64,
    playing: bool,
    /// When the place was last moved on (seconds of the window).
    moved: f64,
    /// The window shows it.
    is_shown: bool,
}

impl Replay {
    fn index(&self) -> usize {
        (self.at as usize).min(self.film.count() - 1)
    }

    fn frame(&self) -> Option<&Arc<Frame>> {
        self.film.frames().nth(self.index())
    }
}

impl Tab for Why {
    fn title(&self) -> Title {
        Title::new("Why", "why it snapped, and what it set free")
    }

    fn show(&mut self, ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
        self.tell(ui.ctx(), state);
        self.play(ui);
        // Of another jump the beginning is seen first.
        let jump = self.told.as_ref().map(|told| (told.run, told.index));
        ScrollArea::vertical()
            .id_salt(("why", jump))
            .auto_shrink([false, false])
            .show(ui, |ui| match &self.told {
                None if state.hides(Hidden::Forecast) => {
                    ui.label("Where will it snap? Guess, then drag the body down and see.");
                }
                None => {
                    ui.label(ahead(&state.scene, &state.model, &state.run.record));
                }
                Some(told) => {
                    // In the least window the answer comes first, and the rest is scrolled to.
                    let low = ui.clip_rect().height() < LOW;
                    if low {
                        sentence(ui, &told.why.sentence);
                    }
                    headline(ui, told);
                    let whole = pictures(ui, state, told, actions);
                    if !low {
                        sentence(ui, &told.why.sentence);
                    }
                    replay(ui, state, told, &mut self.replay);
                    if !whole {
                        more(ui, state, told, actions);
                    }
                }
            });
    }

    fn update(&mut self, Update { state, seen, .. }: Update<'_>) {
        let film = state.told_jump().and_then(|jump| state.run.films.of(jump));
        // The surface has moved, or another jump is looked at.
        self.replay.take_if(|replay| {
            !seen
                || film.is_none_or(|film| !Arc::ptr_eq(film, &replay.film))
                || replay.is_shown && state.run.replayed.is_none()
        });
        state.run.replayed = self.replay.as_mut().and_then(|replay| {
            replay.is_shown = true;
            replay.frame().cloned()
        });
    }

    fn restore(&mut self) {
        self.replay = None;
    }
}

impl Why {
    /// Brings what is told up to date with the run.
    fn tell(&mut self, ctx: &Context, state: &ViewState) {
        let Some(index) = state.told_jump() else {
            self.told = None;
            return;
        };
        let film = state.run.films.of(index);
        let view = &state.view;
        let drawn = (view.centred, view.smooth, view.colours);
        let is_fresh = self.told.as_ref().is_some_and(|told| {
            let same = match (&told.film, film) {
                (Some(a), Some(b)) => Arc::ptr_eq(a, b),
                (None, None) => true,
                _ => false,
            };
            same && (told.run, told.index, told.drawn) == (state.run.id, index, drawn)
                && told.jump == state.run.record.jumps[index]
        });
        if !is_fresh {
            self.told = Some(Told::new(ctx, state, index, drawn));
        }
    }

    /// Moves a replay on.
    fn play(&mut self, ui: &Ui) {
        let Some(replay) = self.replay.as_mut().filter(|replay| replay.playing) else {
            return;
        };
        let now = ui.input(|input| input.time);
        let last = (replay.film.count() - 1) as f64;
        replay.at += (now - replay.moved) * last / REPLAY;
        replay.moved = now;
        if replay.at >= last {
            (replay.at, replay.playing) = (last, false);
        }
        ui.ctx().request_repaint_after(PICTURE);
    }
}

impl Told {
    fn new(ctx: &Context, state: &ViewState, index: usize, drawn: (bool, bool, Colours)) -> Self {
        let jump = state.run.record.jumps[index].clone();
        let film = state.run.films.of(index).cloned();
        let mode = film.as_ref().and_then(|film| film.soft_mode());
        let fields = film.as_ref().zip(mode.as_ref());
        let evidence = Evidence {
            jump: &jump,
            fields: fields.map(|(film, mode)| [&*film.before.gap, mode]),
        };
        let scene: &Scene = &state.scene;
        let why = explain(scene, &state.model, evidence);
        let maps = film.as_ref().map_or_else(Vec::new, |film| {
            let contact = state.model.law.contact_gap();
            let top = scale::gap_scale(scene, &state.model);
            let picture = |frame: &Frame, before| {
                let island = gap_picture::island(frame, contact, before);
                let roll = gap_picture::roll(&state.view, &state.model, &frame.gap, island);
                GapPicture::new(&frame.gap, contact, island, roll)
            };
            let before = picture(&film.before, None);
            let after = picture(&film.after, Some(before.island));
            let options = gap_picture::texture_options(&state.view);
            let map = |name, shows, image, picture: Option<&GapPicture>| Map {
                name,
                shows,
                texture: ctx.load_texture(name, image, options),
                picture: picture.cloned(),
            };
            let from = format!("Gap before the jump: {}", jump.from.words());
            let first = map("before", from, before.image(top, drawn.2), Some(&before));
            let to = format!("Gap after the jump: {}", jump.to.words());
            let last = map("after", to, after.image(top, drawn.2), Some(&after));
            let mode = mode.as_ref().map(|mode| {
                let [x, y] = why.wave.unwrap_or_default();
                let shows = format!(
                    "Soft mode, {x} × {y} waves to the cell: orange is lifted, purple lowered"
                );
                map("soft mode", shows, before.mode_image(mode), None)
            });
            std::iter::once(first).chain(mode).chain([last]).collect()
        });
        Self {
            run: state.run.id,
            index,
            jump,
            film,
            drawn,
            why,
            maps,
        }
    }
}

/// What happened.
fn headline(ui: &mut Ui, told: &Told) {
    let jump = &told.jump;
    let words = format!("{} on {}", jump.change(), jump.direction);
    words::explain(ui.label(RichText::new(words).strong()), "The jump");
}

/// The maps, and beside them, where there is room for it, what was released and what to look at next:
/// then true.
fn pictures(ui: &mut Ui, state: &ViewState, told: &Told, actions: &mut Vec<Action>) -> bool {
    let width = ui.available_width();
    let count = told.maps.len().max(1) as f32;
    let beside = width >= BESIDE;
    let room = if beside { width - COLUMN } else { width };
    // In a low window the sentence is seen with them.
    let most = SIDE.1.min(0.3 * ui.clip_rect().height()).max(SIDE.0);
    let side = ((room / count) - GAP).clamp(SIDE.0, most);
    ui.horizontal_top(|ui| {
        ui.spacing_mut().item_spacing.x = GAP;
        for map in &told.maps {
            small_map(ui, map, side);
        }
        if beside {
            ui.vertical(|ui| more(ui, state, told, actions));
        }
    });
    beside
}

/// The sentence, in small letters where others would hide its end or the replay.
fn sentence(ui: &mut Ui, words: &str) {
    let font = TextStyle::Body.resolve(ui.style());
    let width = ui.available_width();
    let (painter, ink) = (ui.painter(), ui.visuals().text_color());
    let height = painter.layout(words.to_owned(), font, ink, width).size().y;
    let room = ui.clip_rect().height() - ui.min_rect().height() - ROW;
    let words = RichText::new(words);
    ui.label(if height > room { words.small() } else { words });
}

/// A map under its name.
fn small_map(ui: &mut Ui, map: &Map, side: f32) {
    let (_, area) = ui.allocate_space(vec2(side.max(NAME.x), side + NAME.y));
    let corner = area.min + vec2(0.0, NAME.y);
    let square = Rect::from_min_size(corner, vec2(side, side));
    let response = ui.interact(area, egui::Id::unique(("why", map.name)), Sense::hover());
    described(&response, &map.shows);
    let on = (square, 1.2);
    gap_picture::draw(ui, &map.texture, on, map.picture.as_ref());
    let edge = ui.visuals().widgets.noninteractive.bg_stroke;
    ui.painter()
        .rect_stroke(square, 0.0, edge, StrokeKind::Inside);
    ui.painter().text(
        area.left_top(),
        Align2::LEFT_TOP,
        map.name,
        FontId::proportional(13.0),
        ui.visuals().text_color(),
    );
    response.on_hover_text(&map.shows);
}

/// What was released, and where to go on.
fn more(ui: &mut Ui, state: &ViewState, told: &Told, actions: &mut Vec<Action>) {
    let all = state.run.record.released_energy_sum() + 0.0;
    let this = told.jump.released_energy + 0.0;
    let unit = state.model.unit(Dimension::SurfaceEnergy);
    let (freed, sum) = (unit.number(this, 4), unit.say(all, 4, "γ"));
    ui.label(RichText::new(format!("{freed} of {sum} set free")).small())
        .on_hover_text("what this jump turned into heat, of what all jumps did so far");
    let (_, bar) = ui.allocate_space(vec2(ui.available_width().min(220.0), 12.0));
    let colour = theme::palette(ui).jump;
    let share = if all > 0.0 {
        (this / all).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let part = Rect::from_min_size(bar.min, vec2(share as f32 * bar.width(), bar.height()));
    let edge = Stroke::new(1.0, ui.visuals().text_color());
    ui.painter().rect_filled(part, 2.0, colour);
    ui.painter().rect_stroke(bar, 2.0, edge, StrokeKind::Inside);
    let response = ui.interact(bar, egui::Id::unique("released"), Sense::hover());
    let (this, all) = (fixed(this, 4), fixed(all, 4));
    let sentence = format!("{this} of {all} gamma released so far");
    described(&response, &sentence);
    let stiffness = ui.button(RichText::new("Show the stiffness").small());
    stiffness
        .on_hover_text("how it fell to zero: the tab Stability")
        .asks(actions, Action::OpenTab("Stability"));
    let branches = ui.button(RichText::new("What could it do instead?").small());
    branches
        .on_hover_text("every state of equilibrium, stable or not: the tab Branches")
        .asks(actions, Action::OpenTab("Branches"));
}

/// The film of the jump, played or moved by hand.
fn replay(ui: &mut Ui, state: &ViewState, told: &Told, replay: &mut Option<Replay>) {
    let Some(film) = &told.film else {
        ui.label(RichText::new("No pictures of this jump are kept.").weak());
        return;
    };
    let now = ui.input(|input| input.time);
    let rests = !state.run.is_busy() || state.run.paused;
    let last = film.count() - 1;
    let begun = |at: f64, playing: bool| Replay {
        film: film.clone(),
        at,
        playing,
        moved: now,
        is_shown: false,
    };
    ui.add_enabled_ui(rests, |ui| {
        ui.horizontal(|ui| {
            let playing = replay.as_ref().is_some_and(|replay| replay.playing);
            let (face, name) = if playing {
                ("⏸ Replay", "Hold the replay")
            } else {
                ("▶ Replay", "Replay the jump")
            };
            if named(ui.button(face), name).clicked() {
                let at = replay.as_ref().map_or(0.0, |replay| replay.at);
                // From its end it begins again.
                let at = if at < last as f64 { at } else { 0.0 };
                *replay = Some(begun(at, !playing));
                ui.ctx().request_repaint();
            }
            let mut place = replay.as_ref().map_or(0, Replay::index);
            let word = match replay {
                None => "".to_owned(),
                Some(_) if place == 0 => "before".to_owned(),
                Some(_) if place == last => "after".to_owned(),
                Some(_) => format!("{place} of {last}"),
            };
            ui.spacing_mut().slider_width = (ui.available_width() - 110.0).max(60.0);
            let slider = ui.add(Slider::new(&mut place, 0..=last).show_value(false));
            slider.widget_info(|| WidgetInfo::slider(rests, place as f64, "Moment of the jump"));
            let slider = words::explain(slider, "Moment of the jump");
            if slider.changed() {
                *replay = Some(begun(place as f64, false));
                ui.ctx().request_repaint();
            }
            let shown = replay.is_some();
            ui.add_enabled_ui(shown, |ui| {
                if named(ui.small_button("✖"), "Close the replay").clicked() {
                    *replay = None;
                    ui.ctx().request_repaint();
                }
            });
            let (_, area) = ui.allocate_space(vec2(62.0, 18.0));
            ui.painter().text(
                area.left_center(),
                Align2::LEFT_CENTER,
                word,
                FontId::proportional(13.0),
                ui.visuals().text_color(),
            );
        });
    });
}
