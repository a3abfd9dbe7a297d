//! The top bar, one row at every width: the gallery of scenes, lessons, play, undo, files, lecture
//! mode, theme, help. What has no room goes into the menu at its end.

use super::action::{Action, FileTask, LessonAct, Page, ViewOptions};
use super::gallery;
use super::theme;
use super::view_state::ViewState;
use super::widgets::named;
use super::words::explain;
use crate::lessons;
use crate::worker::protocol::{Speed, Sweep};
use egui::{Button, Id, RichText, ThemePreference, Ui, vec2};

/// Size of the faces of play, and of the other buttons without words.
const PLAY: f32 = 18.0;
/// Least and largest width of the button of the gallery (points).
const GALLERY: (f32, f32) = (44.0, 420.0);

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
    let gallery = (width - others.unwrap_or(0.7 * width)).clamp(GALLERY.0, GALLERY.1);
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        gallery::button(ui, state, gallery, actions);
        let from = ui.min_rect().right();
        if room == Room::Least {
            let menu = ui.menu_button("▤", |ui| {
                if choose_page(ui, state, pages, actions) {
                    ui.close();
                }
            });
            named(menu.response, "Page").on_hover_text("what is shown");
        } else {
            choose_page(ui, state, pages, actions);
        }
        if room < Room::Play {
            gallery::look_for(ui, state);
            let menu = ui.menu_button("Learn", |ui| learn(ui, actions));
            named(menu.response, "Lessons").on_hover_text("lessons of about five minutes");
            ui.separator();
        }
        play(ui, state, room, actions);
        if room < Room::Play {
            let menu = ui.menu_button(short(state.view.speed), |ui| speeds(ui, state, actions));
            named(menu.response, "Speed").on_hover_text("how fast sweeps and jumps are shown");
            reset(ui, actions);
            ui.separator();
            undo(ui, state, actions);
            let menu = ui.menu_button("Files", |ui| files(ui, actions));
            named(menu.response, "Files").on_hover_text("open, save, export, copy");
        }
        if room == Room::Words {
            looks(ui, actions);
        }
        let menu = ui.menu_button("☰", |ui| more(ui, state, room, actions));
        named(menu.response, "Menu").on_hover_text("everything else");
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
        if ui.button(words).on_hover_text(&lesson.teaches).clicked() {
            actions.push(Action::Lesson(LessonAct::Start(index)));
        }
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
        if named(button, name).on_hover_text(name).clicked() {
            actions.push(Action::Play(sweep));
        }
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
        if button.clicked() {
            actions.push(action);
        }
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
        let chosen = speed == state.view.speed;
        if ui.radio(chosen, format!("{short}  {words}")).clicked() {
            let view = state.view;
            actions.push(Action::SetView(ViewOptions { speed, ..view }));
        }
    }
}

fn reset(ui: &mut Ui, actions: &mut Vec<Action>) {
    let button = ui.button("Reset");
    if button.on_hover_text("Back to rest at the start").clicked() {
        actions.push(Action::Reset);
    }
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
        if button.clicked() {
            actions.push(action);
        }
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
        if button.on_hover_text(hover).clicked() {
            actions.push(action);
        }
    }
}

/// The menu: what the bar has no room for, and what is seldom wanted.
fn more(ui: &mut Ui, state: &ViewState, room: Room, actions: &mut Vec<Action>) {
    ui.set_min_width(250.0);
    if room == Room::Least {
        entries(ui, actions, [("Stop", "Esc", Action::Stop)]);
    }
    if room >= Room::Play {
        named(
            ui.menu_button("Learn", |ui| learn(ui, actions)).response,
            "Lessons",
        );
        named(
            ui.menu_button("Files", |ui| files(ui, actions)).response,
            "Files",
        );
        let speed = ui.menu_button("Speed", |ui| speeds(ui, state, actions));
        named(speed.response, "Speed");
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
    let mut view = state.view;
    explain(
        ui.checkbox(&mut view.click, "Click at a snap"),
        "Click at a snap",
    );
    if view != state.view {
        actions.push(Action::SetView(view));
    }
    let size = theme::LEAST;
    ui.label(RichText::new("Ctrl + and Ctrl − make everything larger, smaller.").size(size));
}
