//! Everything the window does, found by its name in the palette (Ctrl+K) or asked for by its keys.

use super::action::{Action, FILE_TASKS, KeepFrom, LessonAct, ProfileLine, ViewOptions};
use super::tabs::Tabs;
use super::toolbar::SPEEDS;
use super::view_state::{Told, ViewState};
use super::widgets;
use super::{grip, sliders};
use crate::lessons::{self, Question, Stage};
use crate::physics::law::Shape;
use crate::plot::style::Colours;
use crate::scene::{Strategy, edit};
use crate::solver::methods::MethodKind;
use crate::storage;
use crate::worker::protocol::Sweep;
use egui::text_edit::TextEditState;
use egui::{
    Align, Align2, Context, Event, Id, Key, Layout, Modifiers, Popup, RichText, ScrollArea,
    TextEdit, ThemePreference, Ui, Window,
};

/// Something that can be done now.
#[derive(Clone, Debug, PartialEq)]
pub struct Command {
    /// What it is called and found by.
    pub name: String,
    /// The keys that do the same, if there are any.
    pub keys: &'static str,
    /// What it asks for.
    pub actions: Vec<Action>,
}

impl Command {
    fn new(name: impl Into<String>, keys: &'static str, action: Action) -> Self {
        Self {
            name: name.into(),
            keys,
            actions: vec![action],
        }
    }
}

/// Commands by their names and keys.
fn rows<const N: usize>(rows: [(&str, &'static str, Action); N]) -> [Command; N] {
    rows.map(|(name, keys, action)| Command::new(name, keys, action))
}

/// Commands without keys, each under a word of a `group`.
fn of<T>(
    group: &str,
    choices: impl IntoIterator<Item = T>,
    choice: impl Fn(T) -> (String, Action),
) -> Vec<Command> {
    let choices = choices.into_iter().map(choice);
    choices
        .map(|(word, action)| Command::new(format!("{group} {word}"), "", action))
        .collect()
}

/// Everything that can be done in this state.
fn all(state: &ViewState, tabs: &Tabs) -> Vec<Command> {
    let mut list = motions(state);
    list.extend(pushes(state));
    list.extend(files());
    list.extend(rows([
        ("Undo", "Ctrl+Z", Action::Undo),
        ("Redo", "Ctrl+Y", Action::Redo),
    ]));
    list.extend(views(state));
    list.extend(looks(state));
    let titles = lessons::all().iter().enumerate();
    list.extend(of("Lesson:", titles, |(index, lesson)| {
        let start = Action::Lesson(LessonAct::Start(index));
        (lesson.title.clone(), start)
    }));
    list.push(Command::new("Quit", "Ctrl+Q", Action::Quit));
    list.extend(scenes(state));
    list.extend(choices(state));
    let of_tabs = tabs.commands(state).into_iter();
    list.extend(of_tabs.map(|(name, actions)| Command {
        name,
        keys: "",
        actions,
    }));
    list
}

/// What moves u0, and what goes along the loop.
fn motions(state: &ViewState) -> Vec<Command> {
    use Action::*;
    let (turn, start) = state.limits;
    let before = "A | B: compare with the scene before the last edit";
    rows([
        ("Play approach", "", Play(Sweep::Approach)),
        ("Play retract", "", Play(Sweep::Retract)),
        ("Play loop", "", Play(Sweep::Loop)),
        ("Play or pause", "Space", TogglePlay),
        ("Stop", "Esc", Stop),
        ("Reverse", "R", Reverse),
        ("One increment onwards", ".", Increment),
        ("Go to the start of the drive", "Home", SetTarget(start)),
        (
            "Go to the turning point of the drive",
            "End",
            SetTarget(turn),
        ),
        ("Reset to rest at the start", "", Reset),
        ("Look at the next jump", "J", StepJump(1)),
        ("Look at the jump before", "K", StepJump(-1)),
        ("Look at the stored state before", "[", StepState(-1)),
        ("Look at the stored state after", "]", StepState(1)),
        ("Go on from the stored state", "G", GoOn),
        ("Keep this loop on the plot", "L", Keep(KeepFrom::Best)),
        (
            "Keep what was walked on the plot",
            "",
            Keep(KeepFrom::Walked),
        ),
        ("Keep the live loop on the plot", "", Keep(KeepFrom::Live)),
        ("Bring the deleted loop back", "", BringKeptBack),
        (before, "", CompareWithBefore),
    ])
    .into()
}

/// Pushes into the middle of the cell.
fn pushes(state: &ViewState) -> [Command; 2] {
    [("bump", 1.0), ("dimple", -1.0)].map(|(what, sign)| Command {
        name: format!("Push: press a {what} into the middle and let go"),
        keys: "",
        actions: grip::press_command(state, sign),
    })
}

/// What reads and writes scenes and results.
fn files() -> impl Iterator<Item = Command> {
    let tasks = FILE_TASKS.into_iter().flatten().map(|row| {
        let [name, keys] = row.command;
        Command::new(name, keys, Action::AskFile(row.task))
    });
    let picture = "Copy the picture of the stress curve";
    tasks.chain(rows([
        ("Copy the scene as text", "Ctrl+C", Action::CopyScene),
        (picture, "", Action::CopyPicture),
    ]))
}

/// What changes how things are shown.
fn views(state: &ViewState) -> Vec<Command> {
    use Action::*;
    let (view, click, overlay) = (state.view, state.messages.click, state.plots.overlay);
    let on = |what: &str, is: bool| format!("{} {what}", if is { "Hide" } else { "Show" });
    let soft_mode = ViewOptions {
        soft_mode: !view.soft_mode,
        ..view
    };
    let snap = ["Click at a snap", "No click at a snap"][usize::from(click)];
    rows([
        ("Fit the axes to the data", "", FitData),
        ("Axes of the scene", "", FitScene),
        (
            &on("theory over the live plot", overlay),
            "",
            OverlayTheory(!overlay),
        ),
        (
            &on("the soft mode on the map", view.soft_mode),
            "",
            SetView(soft_mode),
        ),
        ("Theme: light", "", SetTheme(ThemePreference::Light)),
        ("Theme: dark", "", SetTheme(ThemePreference::Dark)),
        (
            "Theme: that of the system",
            "",
            SetTheme(ThemePreference::System),
        ),
        (snap, "", SetClick(!click)),
        ("Lecture mode", "F11", ToggleLecture),
        ("Restore layout", "", RestoreLayout),
        ("Keys and marks", "?", ToggleHelp),
    ])
    .into()
}

/// Where the profile is cut, and the colours of maps.
fn looks(state: &ViewState) -> Vec<Command> {
    let view = state.view;
    let cuts = [
        ("the middle of the pattern", ProfileLine::Auto),
        ("the middle of the map along x", ProfileLine::AlongX(0.5)),
        ("the middle of the map along y", ProfileLine::AlongY(0.5)),
    ];
    let mut list = of("Profile through", cuts, |(place, profile)| {
        let view = ViewOptions { profile, ..view };
        (place.to_owned(), Action::SetView(view))
    });
    list.extend(of("Colours:", Colours::ALL, |(colours, word)| {
        let view = ViewOptions { colours, ..view };
        (word.to_owned(), Action::SetView(view))
    }));
    list
}

/// The presets, and the scene with another law.
fn scenes(state: &ViewState) -> Vec<Command> {
    const KEYS: [&str; 9] = ["1", "2", "3", "4", "5", "6", "7", "8", "9"];
    let presets = storage::presets().iter().enumerate().map(|(i, preset)| {
        let (name, keys) = (format!("Preset {}", preset.name), KEYS.get(i));
        Command::new(name, keys.unwrap_or(&""), Action::LoadPreset(i))
    });
    let laws = of("Cohesive law:", Shape::all(), |shape| {
        let scene = edit::with_shape(&state.scene, &state.model, shape);
        (shape.word().replace('_', " "), Action::edit(scene))
    });
    presets.chain(laws).collect()
}

/// The speed, the model and the method of the walk.
fn choices(state: &ViewState) -> Vec<Command> {
    let models = [
        (None, "as planned"),
        (Some(Strategy::WHOLE), "whole cell"),
        (Some(Strategy::QUARTER), "quarter"),
    ];
    let mut list = of("Speed:", SPEEDS, |(speed, _, words)| {
        let view = ViewOptions {
            speed,
            ..state.view
        };
        (words.to_owned(), Action::SetView(view))
    });
    list.extend(of("Model:", models, |(asked, word)| {
        (word.to_owned(), Action::SetStrategy(asked))
    }));
    list.extend(of("Method:", MethodKind::ALL, |method| {
        (method.title().to_owned(), Action::SetMethod(method))
    }));
    list
}

/// What these words find: every word somewhere in the name. A number alone is a value of what is
/// driven, and in a lecture a guess of the first jump.
pub fn found(state: &ViewState, tabs: &Tabs, words: &str) -> Vec<Command> {
    let Told {
        symbol,
        suffix,
        unit,
        ..
    } = state.told();
    let (low, high) = (state.limits.0 / unit, state.limits.1 / unit);
    let place = widgets::parse(words).filter(|value| (low..=high).contains(value));
    let go = place.map(|value| {
        let name = format!("Go to {symbol} = {value}{suffix}");
        Command::new(name, "", Action::SetTarget(value * unit))
    });
    let wanted: Vec<String> = words.split_whitespace().map(str::to_lowercase).collect();
    let fits = |command: &Command| {
        let name = command.name.to_lowercase();
        wanted.iter().all(|word| name.contains(word.as_str()))
    };
    let guesses = state.view.lecture && state.run.record.jumps.is_empty();
    let guess = place.filter(|_| guesses && !state.scene.control().frees_mean());
    let guess = guess.map(|value| {
        let name = format!("Guess the first jump at {symbol} = {value}{suffix}");
        Command::new(name, "", Action::Guess(value * unit / state.rho()))
    });
    go.into_iter()
        .chain(guess)
        .chain(all(state, tabs).into_iter().filter(fits))
        .collect()
}

/// The sheet of keys: key, what it does.
pub const SHEET: [(&str, &str); 25] = [
    (
        "Ctrl+K",
        "everything by its name: laws, presets, figures, files",
    ),
    (
        "← → or ↓ ↑",
        "one step of u₀, w or F down, up (with Shift a tenth)",
    ),
    ("PgDn PgUp", "ten steps down, up"),
    ("Home End", "start, turning point"),
    ("Space", "play, pause"),
    (".", "one increment onwards"),
    ("R", "reverse"),
    ("Esc", "close what is on top; stop; back to the present"),
    ("1 … 9", "presets"),
    ("S", "export a picture"),
    ("J K", "next jump, jump before"),
    ("L", "keep this loop on the plot, to compare others with it"),
    (
        "Click or drag on curve or strip",
        "that stored state, everywhere",
    ),
    ("[ ]", "the stored state before, after"),
    ("G", "go on from the stored state that is shown"),
    ("Ctrl+C Ctrl+V", "copy the scene as text, open one"),
    ("Ctrl+O Ctrl+S", "open, save a scene"),
    ("Ctrl+Z Ctrl+Y", "undo, redo a scene edit (one drag is one)"),
    ("Enter Backspace", "in a lesson: answer and go on; back"),
    ("F11", "lecture mode"),
    ("Ctrl+Q", "quit"),
    ("Tab", "from control to control"),
    (
        "Alt while dragging on the map",
        "press a bump (down) or a dimple (up); wheel: width",
    ),
    ("Shift while dragging", "fine u₀; an upright profile line"),
    ("?", "this sheet"),
];

/// Coarse steps of PgUp and PgDn, in increments.
const COARSE: f64 = 10.0;

/// A step of a guess by key, in ranges; with Shift a tenth of it.
const GUESS: f64 = 0.1;

/// Turns this frame's key presses into actions. They do not fire while something is being typed, nor
/// take the arrows away from a focused widget other than the slider of what is driven; `dialog_open`
/// leaves only what concerns the dialog.
pub fn of_keys(
    ctx: &Context,
    with: (&ViewState, &Tabs),
    dialog_open: bool,
    actions: &mut Vec<Action>,
) {
    let focused = ctx.memory(egui::Memory::focused);
    let free = focused.is_none() || focused == Some(sliders::driven_id());
    let presses: Vec<(Key, Modifiers, bool)> = ctx.input(|input| {
        let pressed = |event: &Event| match event {
            Event::Key {
                key,
                pressed: true,
                repeat,
                modifiers,
                ..
            } => Some((*key, *modifiers, *repeat)),
            _ => None,
        };
        input.events.iter().filter_map(pressed).collect()
    });
    if free && !dialog_open {
        let said: Vec<Action> = ctx.input(|input| input.events.iter().filter_map(said).collect());
        actions.extend(said);
    }
    // A menu closes itself.
    let menu = Popup::is_any_open(ctx);
    for (key, modifiers, repeat) in presses {
        if menu && key == Key::Escape {
            continue;
        }
        // What is typed from here on is the palette's.
        if !dialog_open && actions.contains(&Action::ToggleCommands) {
            break;
        }
        let action = if modifiers.command {
            of_key((key, modifiers, repeat), with).filter(|action| free || !of_text(action))
        } else if dialog_open {
            (key == Key::Escape).then_some(Action::CloseDialog)
        } else if free && let Some(act) = in_lesson(key, modifiers, with.0) {
            Some(Action::Lesson(act))
        } else if free {
            of_key((key, modifiers, repeat), with)
        } else {
            None
        };
        actions.extend(action);
    }
}

/// Commands whose keys are not heard as keys, but as what they say.
const SAID: [&str; 2] = ["?", "Ctrl+C"];

/// What a key asks for, in a lesson or a dialog aside: the commands of the palette by their keys, and
/// what has no name there. Few go on while they are held down.
fn of_key(
    (key, modifiers, repeat): (Key, Modifiers, bool),
    (state, tabs): (&ViewState, &Tabs),
) -> Option<Action> {
    let (command, fine) = (modifiers.command, if modifiers.shift { 0.1 } else { 1.0 });
    match key {
        Key::K if command => return Some(Action::ToggleCommands),
        Key::Z if command && modifiers.shift => return Some(Action::Redo),
        _ if command => {}
        Key::ArrowLeft | Key::ArrowDown => return Some(Action::Step(-fine)),
        Key::ArrowRight | Key::ArrowUp => return Some(Action::Step(fine)),
        Key::PageDown => return Some(Action::Step(-COARSE)),
        Key::PageUp => return Some(Action::Step(COARSE)),
        Key::Escape | Key::F1 if repeat => return None,
        Key::F1 => return Some(Action::ToggleHelp),
        Key::Escape => return Some(escape(state)),
        _ => {}
    }
    let is_it = |known: &Command| {
        let name = known.keys.strip_prefix("Ctrl+");
        name.is_some() == command
            && Key::from_name(name.unwrap_or(known.keys)) == Some(key)
            && !SAID.contains(&known.keys)
    };
    let action = all(state, tabs).into_iter().find(is_it)?.actions.pop()?;
    let step = matches!(
        action,
        Action::Increment | Action::StepJump(_) | Action::StepState(_)
    );
    (!repeat || command || step).then_some(action)
}

/// What is on top.
fn escape(state: &ViewState) -> Action {
    let busy = state.run.is_busy();
    if state.run.selection.is_some() && !busy {
        Action::ClearSelection
    } else if state.messages.failure.is_some() && !busy {
        Action::DismissFailure
    } else if state.view.lecture && !busy {
        Action::ToggleLecture
    } else {
        Action::Stop
    }
}

/// What a key does in a lesson: the answer, and onwards or back.
fn in_lesson(key: Key, modifiers: Modifiers, state: &ViewState) -> Option<LessonAct> {
    let (_, progress) = state.lesson()?;
    let chosen = |index: f64| Some(LessonAct::Choose(index));
    match (key, state.asked()) {
        (Key::Enter, Some(_)) => Some(LessonAct::Commit),
        (Key::Enter, None) => (progress.stage == Stage::Explained).then_some(LessonAct::Next),
        (Key::Backspace, _) => Some(LessonAct::Back),
        (Key::Num1, Some((Question::Choice { .. }, _))) => chosen(0.0),
        (Key::Num2, Some((Question::Choice { .. }, _))) => chosen(1.0),
        (Key::Num3, Some((Question::Choice { .. }, _))) => chosen(2.0),
        (Key::ArrowLeft | Key::ArrowRight, Some((Question::Guess { .. }, answer))) => {
            let [low, high] = state.guessable();
            let step = GUESS * if modifiers.shift { 0.1 } else { 1.0 };
            let way = if key == Key::ArrowLeft { -step } else { step };
            let from = answer.unwrap_or(0.5 * (low + high));
            chosen((from + way).clamp(low, high))
        }
        _ => None,
    }
}

/// What is not told by keys: the clipboard, and the sign that opens the sheet, which lies on another
/// key of every layout.
fn said(event: &Event) -> Option<Action> {
    match event {
        Event::Text(text) if text == "?" => Some(Action::ToggleHelp),
        Event::Copy => Some(Action::CopyScene),
        Event::Paste(text) => Some(Action::PasteScene(text.clone())),
        _ => None,
    }
}

/// What a text field has of its own.
fn of_text(action: &Action) -> bool {
    matches!(action, Action::Undo | Action::Redo)
}

/// The open palette.
pub struct Palette {
    words: String,
    chosen: usize,
}

/// Its field.
fn field_id() -> Id {
    Id::unique("palette of commands")
}

/// What is typed in this frame.
fn typed(ctx: &Context) -> String {
    let text = |event: &Event| match event {
        Event::Text(text) => Some(text.clone()),
        _ => None,
    };
    ctx.input(|input| input.events.iter().filter_map(text).collect())
}

impl Palette {
    /// A palette that has heard what is typed in the frame in which it opens, and hears what comes
    /// in the next.
    pub fn new(ctx: &Context) -> Self {
        ctx.memory_mut(|memory| memory.request_focus(field_id()));
        Self {
            words: typed(ctx),
            chosen: 0,
        }
    }

    /// Draws it; what is run closes it first.
    pub fn show(
        &mut self,
        ctx: &Context,
        state: &ViewState,
        tabs: &Tabs,
        actions: &mut Vec<Action>,
    ) {
        Window::new("Commands")
            .title_bar(false)
            .resizable(false)
            .anchor(Align2::CENTER_TOP, [0.0, 60.0])
            .show(ctx, |ui| self.body(ui, state, tabs, actions));
    }

    fn body(&mut self, ui: &mut Ui, state: &ViewState, tabs: &Tabs, actions: &mut Vec<Action>) {
        ui.set_width((ui.ctx().content_rect().width() - 60.0).min(480.0));
        let (up, down, enter) = ui.input_mut(|input| {
            let mut pressed = |key| input.count_and_consume_key(Modifiers::NONE, key);
            (
                pressed(Key::ArrowUp),
                pressed(Key::ArrowDown),
                pressed(Key::Enter) > 0,
            )
        });
        let hint = "what to do, or a value of u₀ in ranges";
        let heard = ui.memory(|memory| memory.has_focus(field_id()));
        let field = ui.add(
            TextEdit::singleline(&mut self.words)
                .id(field_id())
                .hint_text(hint)
                .desired_width(f32::INFINITY),
        );
        field.widget_info(|| egui::WidgetInfo::labeled(egui::Role::TextInput, true, "Command"));
        if !heard {
            // What is typed before the field listens is not lost.
            self.words += &typed(ui.ctx());
            // Without a place of its own the cursor stands at the end.
            TextEditState::default().store(ui.ctx(), field_id());
            field.request_focus();
        }
        if field.changed() {
            self.chosen = 0;
        }
        let list = found(state, tabs, &self.words);
        let last = list.len().saturating_sub(1);
        self.chosen = (self.chosen + down).saturating_sub(up).min(last);
        let mut run = if enter { list.get(self.chosen) } else { None };
        let height = (ui.ctx().content_rect().height() - 140.0).clamp(100.0, 420.0);
        ScrollArea::vertical().max_height(height).show(ui, |ui| {
            ui.with_layout(Layout::top_down_justified(Align::LEFT), |ui| {
                for (index, command) in list.iter().enumerate() {
                    let keys = RichText::new(command.keys).small().weak();
                    let row = egui::Button::selectable(index == self.chosen, command.name.as_str())
                        .right_text(keys)
                        .truncate();
                    let row = ui.add(row);
                    if row.clicked() {
                        run = Some(command);
                    }
                    if up + down > 0 && index == self.chosen {
                        row.scroll_to_me(None);
                    }
                }
            });
            if list.is_empty() {
                ui.label(RichText::new("Nothing has all these words in its name.").weak());
            }
        });
        if let Some(command) = run {
            actions.push(Action::CloseDialog);
            actions.extend(command.actions.iter().cloned());
        }
    }
}
