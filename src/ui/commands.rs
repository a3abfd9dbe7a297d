//! The palette of commands (Ctrl+K): everything the window does, found by its name and run from the
//! keyboard.

use super::action::{Action, FILE_TASKS, KeepFrom, LessonAct, ProfileLine, ViewOptions};
use super::grip;
use super::machine::{self, Told};
use super::tabs::Tabs;
use super::toolbar::SPEEDS;
use super::view_state::ViewState;
use super::widgets;
use crate::lessons;
use crate::physics::law::Shape;
use crate::plot::style::Colours;
use crate::scene::edit;
use crate::scene::part::Strategy;
use crate::solver::methods::MethodKind;
use crate::storage::presets;
use crate::worker::protocol::Sweep;
use egui::text_edit::TextEditState;
use egui::{
    Align, Align2, Context, Event, Id, Key, Layout, Modifiers, RichText, ScrollArea, TextEdit,
    ThemePreference, Ui, Window,
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
    fn new(name: &str, keys: &'static str, action: Action) -> Self {
        Self {
            name: name.to_owned(),
            keys,
            actions: vec![action],
        }
    }
}

/// Everything that can be done in this state.
fn all(state: &ViewState, tabs: &Tabs) -> Vec<Command> {
    let one = Command::new;
    let mut list = motions(state);
    list.extend(pushes(state));
    list.extend(files());
    list.extend([
        one("Undo", "Ctrl+Z", Action::Undo),
        one("Redo", "Ctrl+Y", Action::Redo),
    ]);
    list.extend(views(state));
    list.extend(profiles(state));
    list.extend(colours(state));
    let titles = lessons::all().iter().enumerate();
    list.extend(titles.map(|(index, lesson)| {
        let start = Action::Lesson(LessonAct::Start(index));
        one(&format!("Lesson: {}", lesson.title), "", start)
    }));
    list.push(one("Quit", "Ctrl+Q", Action::Quit));
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
    let one = Command::new;
    vec![
        one("Play approach", "", Action::Play(Sweep::Approach)),
        one("Play retract", "", Action::Play(Sweep::Retract)),
        one("Play loop", "", Action::Play(Sweep::Loop)),
        one("Play or pause", "Space", Action::TogglePlay),
        one("Stop", "Esc", Action::Stop),
        one("Reverse", "R", Action::Reverse),
        one("One increment onwards", ".", Action::Increment),
        one(
            "Go to the start of the drive",
            "Home",
            Action::SetTarget(state.limits.1),
        ),
        one(
            "Go to the turning point of the drive",
            "End",
            Action::SetTarget(state.limits.0),
        ),
        one("Reset to rest at the start", "", Action::Reset),
        one("Look at the next jump", "J", Action::StepJump(1)),
        one("Look at the jump before", "K", Action::StepJump(-1)),
        one(
            "Look at the stored state before",
            "[",
            Action::StepState(-1),
        ),
        one("Look at the stored state after", "]", Action::StepState(1)),
        one("Go on from the stored state", "G", Action::GoOn),
        one(
            "Keep this loop on the plot",
            "L",
            Action::Keep(KeepFrom::Best),
        ),
        one(
            "Keep what was walked on the plot",
            "",
            Action::Keep(KeepFrom::Walked),
        ),
        one(
            "Keep the live loop on the plot",
            "",
            Action::Keep(KeepFrom::Live),
        ),
        one("Bring the deleted loop back", "", Action::BringKeptBack),
        one(
            "A | B: compare with the scene before the last edit",
            "",
            Action::CompareWithBefore,
        ),
    ]
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
        (name, keys, Action::AskFile(row.task))
    });
    let picture = "Copy the picture of the stress curve";
    let copies = [
        ("Copy the scene as text", "Ctrl+C", Action::CopyScene),
        (picture, "", Action::CopyPicture),
    ];
    let all = tasks.chain(copies);
    all.map(|(name, keys, action)| Command::new(name, keys, action))
}

/// What changes how things are shown.
fn views(state: &ViewState) -> Vec<Command> {
    let one = Command::new;
    let click = state.messages.click;
    let view = Action::SetView;
    let on = |what: &str, is: bool| format!("{} {what}", if is { "Hide" } else { "Show" });
    vec![
        one("Fit the axes to the data", "", Action::FitData),
        one("Axes of the scene", "", Action::FitScene),
        one(
            &on("theory over the live plot", state.plots.overlay),
            "",
            Action::OverlayTheory(!state.plots.overlay),
        ),
        one(
            &on("the soft mode on the map", state.view.soft_mode),
            "",
            view(ViewOptions {
                soft_mode: !state.view.soft_mode,
                ..state.view
            }),
        ),
        one("Theme: light", "", Action::SetTheme(ThemePreference::Light)),
        one("Theme: dark", "", Action::SetTheme(ThemePreference::Dark)),
        one(
            "Theme: that of the system",
            "",
            Action::SetTheme(ThemePreference::System),
        ),
        one(
            if click {
                "No click at a snap"
            } else {
                "Click at a snap"
            },
            "",
            Action::SetClick(!click),
        ),
        one("Lecture mode", "F11", Action::ToggleLecture),
        one("Restore layout", "", Action::RestoreLayout),
        one("Keys and marks", "?", Action::ToggleHelp),
    ]
}

/// The colours of maps.
fn colours(state: &ViewState) -> [Command; 2] {
    Colours::ALL.map(|(colours, word)| {
        let view = ViewOptions {
            colours,
            ..state.view
        };
        Command::new(&format!("Colours: {word}"), "", Action::SetView(view))
    })
}

/// Where the profile is cut.
fn profiles(state: &ViewState) -> [Command; 3] {
    [
        ("the middle of the pattern", ProfileLine::Auto),
        ("the middle of the map along x", ProfileLine::AlongX(0.5)),
        ("the middle of the map along y", ProfileLine::AlongY(0.5)),
    ]
    .map(|(place, profile)| {
        let view = ViewOptions {
            profile,
            ..state.view
        };
        Command::new(
            &format!("Profile through {place}"),
            "",
            Action::SetView(view),
        )
    })
}

/// The presets, and the scene with another law.
fn scenes(state: &ViewState) -> Vec<Command> {
    let one = Command::new;
    let mut list = Vec::new();
    list.extend(presets::all().iter().enumerate().map(|(i, preset)| {
        const KEYS: [&str; 9] = ["1", "2", "3", "4", "5", "6", "7", "8", "9"];
        one(
            &format!("Preset {}", preset.name),
            KEYS.get(i).unwrap_or(&""),
            Action::LoadPreset(i),
        )
    }));
    list.extend(Shape::all().into_iter().map(|shape| {
        let scene = edit::with_shape(&state.scene, &state.model, shape);
        one(
            &format!("Cohesive law: {}", shape.word().replace('_', " ")),
            "",
            Action::edit(scene),
        )
    }));
    list
}

/// The speed, the model and the method of the walk.
fn choices(state: &ViewState) -> Vec<Command> {
    let one = Command::new;
    let view = Action::SetView;
    let mut list = Vec::new();
    list.extend(SPEEDS.map(|(speed, _, words)| {
        one(
            &format!("Speed: {words}"),
            "",
            view(ViewOptions {
                speed,
                ..state.view
            }),
        )
    }));
    let models = [
        (None, "as planned"),
        (Some(Strategy::WHOLE), "whole cell"),
        (Some(Strategy::QUARTER), "quarter"),
    ];
    list.extend(
        models.map(|(asked, word)| one(&format!("Model: {word}"), "", Action::SetStrategy(asked))),
    );
    list.extend(MethodKind::ALL.map(|method| {
        one(
            &format!("Method: {}", method.title()),
            "",
            Action::SetMethod(method),
        )
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
    } = machine::told(state);
    let (low, high) = (state.limits.0 / unit, state.limits.1 / unit);
    let place = widgets::parse(words).filter(|value| (low..=high).contains(value));
    let go = place.map(|value| {
        Command::new(
            &format!("Go to {symbol} = {value}{suffix}"),
            "",
            Action::SetTarget(value * unit),
        )
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
        Command::new(&name, "", Action::Guess(value * unit / state.rho()))
    });
    go.into_iter()
        .chain(guess)
        .chain(all(state, tabs).into_iter().filter(fits))
        .collect()
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
