//! The top bar, one row at every width: the gallery of scenes, lessons, play, undo, files, lecture
//! mode, theme, help. What has no room goes into the menu at its end.

use super::action::{Action, FileTask, LessonAct, Page, ViewOptions};
use super::sliders;
use super::theme::{self, Palette};
use super::view_state::ViewState;
use super::widgets::{Asks, checkbox, menu, named, radio};
use super::words::explain;
use crate::follow::record::Direction;
use crate::lessons;
use crate::plot::typeset::plain;
use crate::scene::Scene;
use crate::storage::{self, Preset};
use crate::worker::protocol::{Speed, Sweep};
use egui::{
    Align, Button, Id, Layout, Painter, Popup, PopupCloseBehavior, Rect, RichText, ScrollArea,
    Sense, Stroke, StrokeKind, ThemePreference, Ui, pos2, vec2,
};
use std::sync::LazyLock;

/// Size of the faces of play, and of the other buttons without words.
const PLAY: f32 = 18.0;
/// Least and largest width of the button of the gallery (points).
const GALLERY: (f32, f32) = (44.0, 420.0);

/// Menus that stand in the bar or in another menu: their names, and what is in them.
const LESSONS: [&str; 2] = ["Lessons", "lessons of about five minutes"];
const SPEED: [&str; 2] = ["Speed", "how fast sweeps and jumps are shown"];
const FILES: [&str; 2] = ["Files", "open, save, export, copy"];

/// How much of the bar is shown, from all of it on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Room {
    /// Words on the buttons.
    Words,
    /// Faces alone.
    Faces,
    /// Only what plays; the rest is in the menu.
    Play,
    /// The least of that.
    Least,
}

impl Room {
    fn of(width: f32) -> Self {
        if width >= 1180.0 {
            Room::Words
        } else if width >= 840.0 {
            Room::Faces
        } else if width >= 430.0 {
            Room::Play
        } else {
            Room::Least
        }
    }
}

/// The bar; `pages` are what can be chosen where the panels are not all shown.
pub fn show(ui: &mut Ui, state: &ViewState, pages: &[Page], actions: &mut Vec<Action>) {
    let width = ui.available_width();
    let room = Room::of(width);
    // The gallery takes what the others left when the bar was last drawn like this.
    let id = Id::unique(("toolbar", room as u8, pages.len()));
    let others = ui.data(|data| data.get_temp::<f32>(id));
    let wide = (width - others.unwrap_or(0.7 * width)).clamp(GALLERY.0, GALLERY.1);
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        gallery(ui, state, wide, actions);
        let from = ui.min_rect().right();
        if room == Room::Least {
            menu(ui, "▤", ["Page", "what is shown"], |ui| {
                if choose_page(ui, state, pages, actions) {
                    ui.close();
                }
            });
        } else {
            choose_page(ui, state, pages, actions);
        }
        if room < Room::Play {
            look_for(ui, state);
            menu(ui, "Learn", LESSONS, |ui| learn(ui, actions));
            ui.separator();
        }
        play(ui, state, room, actions);
        if room < Room::Play {
            let face = short(state.view.speed);
            menu(ui, face, SPEED, |ui| speeds(ui, state, actions));
            reset(ui, actions);
            ui.separator();
            undo(ui, state, actions);
            menu(ui, "Files", FILES, |ui| files(ui, actions));
        }
        if room == Room::Words {
            looks(ui, actions);
        }
        let what = ["Menu", "everything else"];
        menu(ui, "☰", what, |ui| more(ui, state, room, actions));
        let used = ui.min_rect().right() - from + 2.0;
        if others.is_none_or(|others| (others - used).abs() > 0.5) {
            ui.data_mut(|data| data.insert_temp(id, used));
            ui.ctx()
                .request_discard("the gallery's width follows the rest of the bar");
        }
    });
}

/// What is shown where the panels are not all in sight; true when it was chosen.
fn choose_page(ui: &mut Ui, state: &ViewState, pages: &[Page], actions: &mut Vec<Action>) -> bool {
    let present = state.view.page;
    let mut asked = false;
    for page in pages {
        let chosen = present == *page || !pages.contains(&present) && *page == pages[0];
        if ui.selectable_label(chosen, page.word()).clicked() {
            let page = *page;
            actions.push(Action::SetView(ViewOptions { page, ..state.view }));
            asked = true;
        }
    }
    asked
}

/// The lessons.
fn learn(ui: &mut Ui, actions: &mut Vec<Action>) {
    for (index, lesson) in lessons::all().iter().enumerate() {
        let words = format!("{}  {} ({} min)", index + 1, lesson.title, lesson.minutes);
        ui.button(words)
            .on_hover_text(&lesson.teaches)
            .asks(actions, Action::Lesson(LessonAct::Start(index)));
    }
}

/// A button with a large face.
fn large(face: &str) -> Button<'_> {
    Button::new(RichText::new(face).size(PLAY)).min_size(vec2(32.0, 28.0))
}

fn play(ui: &mut Ui, state: &ViewState, room: Room, actions: &mut Vec<Action>) {
    for (face, word, name, sweep) in [
        ("▼", "Approach", "Play approach", Sweep::Approach),
        ("▲", "Retract", "Play retract", Sweep::Retract),
        ("⟳", "Loop", "Play loop", Sweep::Loop),
    ] {
        let face = if room == Room::Words {
            format!("{face} {word}")
        } else {
            face.to_owned()
        };
        let chosen = state.run.sweep() == Some(sweep);
        let button = ui.add(large(&face).selected(chosen));
        named(button, name)
            .on_hover_text(name)
            .asks(actions, Action::Play(sweep));
    }
    let (busy, paused) = (state.run.is_busy(), state.run.paused);
    let (face, name) = if paused {
        ("▶", "Go on")
    } else {
        ("⏸", "Pause")
    };
    for (face, name, key, enabled, action) in [
        (face, name, "Space", busy || paused, Action::Pause(!paused)),
        ("⏹", "Stop", "Esc", busy, Action::Stop),
    ] {
        if room == Room::Least && action == Action::Stop {
            continue;
        }
        let button = named(ui.add_enabled(enabled, large(face)), name);
        let words = format!("{name} ({key})");
        let button = button.on_disabled_hover_text(&words).on_hover_text(words);
        button.asks(actions, action);
    }
}

/// What each speed is called, short and in full.
pub const SPEEDS: [(Speed, &str, &str); 3] = [
    (Speed::Slow, "¼×", "slow motion"),
    (Speed::Normal, "1×", "normal speed"),
    (Speed::Full, "max", "as fast as it is computed"),
];

fn short(speed: Speed) -> &'static str {
    let found = SPEEDS.iter().find(|(of, ..)| *of == speed);
    found.map_or("", |(_, short, _)| short)
}

fn speeds(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    for (speed, short, words) in SPEEDS {
        if radio(ui, &state.view.speed, &speed, format!("{short}  {words}")).clicked() {
            let view = state.view;
            actions.push(Action::SetView(ViewOptions { speed, ..view }));
        }
    }
}

fn reset(ui: &mut Ui, actions: &mut Vec<Action>) {
    let button = ui.button("Reset");
    button
        .on_hover_text("Back to rest at the start")
        .asks(actions, Action::Reset);
}

fn undo(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let history = &state.history;
    for (face, name, keys, enabled, action) in [
        ("↶", "Undo", "Ctrl+Z", history.can_undo(), Action::Undo),
        ("↷", "Redo", "Ctrl+Y", history.can_redo(), Action::Redo),
    ] {
        let button = named(ui.add_enabled(enabled, large(face)), name);
        let words = format!("{name} ({keys})");
        let button = button.on_disabled_hover_text(&words).on_hover_text(words);
        button.asks(actions, action);
    }
}

/// Buttons one below the other, each with its keys; what is chosen closes the menu.
fn entries<const N: usize>(
    ui: &mut Ui,
    actions: &mut Vec<Action>,
    entries: [(&str, &str, Action); N],
) {
    for (face, keys, action) in entries {
        let keys = RichText::new(keys).small().weak();
        let button = named(ui.add(Button::new(face).right_text(keys)), face);
        if button.clicked() {
            actions.push(action);
            ui.close();
        }
    }
}

/// Everything that reads and writes files.
fn files(ui: &mut Ui, actions: &mut Vec<Action>) {
    ui.set_min_width(230.0);
    let ask = Action::AskFile;
    let list = [
        ("Open…", "Ctrl+O", ask(FileTask::OpenScene)),
        ("Save…", "Ctrl+S", ask(FileTask::SaveScene)),
        ("Measured ground…", "", ask(FileTask::OpenHeights)),
        ("Export data…", "", ask(FileTask::ExportLoopCsv)),
        ("Export picture…", "S", ask(FileTask::ExportLoopPng)),
        ("Copy scene", "Ctrl+C", Action::CopyScene),
        ("Copy picture", "", Action::CopyPicture),
    ];
    entries(ui, actions, list);
}

/// The other theme, with its face.
fn other_theme(ui: &Ui) -> (&'static str, Action) {
    let (face, theme) = if ui.visuals().dark_mode {
        ("☀", ThemePreference::Light)
    } else {
        ("☾", ThemePreference::Dark)
    };
    (face, Action::SetTheme(theme))
}

/// Lecture mode, light or dark, the sheet of keys.
fn looks(ui: &mut Ui, actions: &mut Vec<Action>) {
    let (theme, switch) = other_theme(ui);
    for (face, name, hover, action) in [
        (
            "🎓",
            "Lecture mode",
            "Lecture mode (F11)",
            Action::ToggleLecture,
        ),
        (theme, "Switch theme", "light or dark", switch),
        ("?", "Help", "keys and marks (?)", Action::ToggleHelp),
    ] {
        let button = named(ui.add(large(face)), name);
        button.on_hover_text(hover).asks(actions, action);
    }
}

/// The menu: what the bar has no room for, and what is seldom wanted.
fn more(ui: &mut Ui, state: &ViewState, room: Room, actions: &mut Vec<Action>) {
    ui.set_min_width(250.0);
    if room == Room::Least {
        entries(ui, actions, [("Stop", "Esc", Action::Stop)]);
    }
    if room >= Room::Play {
        menu(ui, "Learn", LESSONS, |ui| learn(ui, actions));
        menu(ui, "Files", FILES, |ui| files(ui, actions));
        menu(ui, "Speed", SPEED, |ui| speeds(ui, state, actions));
        let list = [
            ("Reset", "", Action::Reset),
            ("Undo", "Ctrl+Z", Action::Undo),
            ("Redo", "Ctrl+Y", Action::Redo),
        ];
        entries(ui, actions, list);
        ui.separator();
    }
    if room != Room::Words {
        let list = [
            ("Lecture mode", "F11", Action::ToggleLecture),
            ("Switch theme", "", other_theme(ui).1),
            ("Help", "?", Action::ToggleHelp),
        ];
        entries(ui, actions, list);
    }
    let list = [
        (
            "Theme of the system",
            "",
            Action::SetTheme(ThemePreference::System),
        ),
        ("Restore layout", "", Action::RestoreLayout),
        ("All commands…", "Ctrl+K", Action::ToggleCommands),
        ("Quit", "Ctrl+Q", Action::Quit),
    ];
    entries(ui, actions, list);
    let (mut click, what) = (state.messages.click, "Click at a snap");
    explain(checkbox(ui, &mut click, what), what).asks(actions, Action::SetClick(click));
    let size = theme::LEAST;
    ui.label(RichText::new("Ctrl + and Ctrl − make everything larger, smaller.").size(size));
}

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
    storage::presets()
        .iter()
        .map(|preset| preset.scene().ok())
        .collect()
});

/// The button of this width, with the title of the present scene; it opens the gallery.
fn gallery(ui: &mut Ui, state: &ViewState, width: f32, actions: &mut Vec<Action>) {
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
    let opened = storage::preset_titled(state.title_opened());
    ScrollArea::vertical()
        .max_height(screen.y - 90.0)
        .min_scrolled_height(screen.y - 90.0)
        .show(ui, |ui| {
            ui.spacing_mut().item_spacing = vec2(GAP, GAP);
            for (row, presets) in storage::presets().chunks(columns).enumerate() {
                ui.horizontal(|ui| {
                    for (column, preset) in presets.iter().enumerate() {
                        let index = row * columns + column;
                        if card(ui, preset, index, opened) {
                            actions.push(Action::LoadPreset(index));
                            ui.close();
                        }
                    }
                });
            }
        });
}

/// One scene; true when it was chosen.
fn card(ui: &mut Ui, preset: &Preset, index: usize, opened: Option<&Preset>) -> bool {
    let chosen = opened == Some(preset);
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
        sliders::sketch(&scene.indenter, painter, ground, palette);
    }
}

/// A button to what there is to see in the preset that was opened, if it was one.
fn look_for(ui: &mut Ui, state: &ViewState) {
    let Some(preset) = storage::preset_titled(state.title_opened()) else {
        return;
    };
    let what = ["What to look for", "what to look for in this preset"];
    menu(ui, "ℹ", what, |ui| {
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
}
