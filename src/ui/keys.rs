//! The keys. They do not fire while something is being typed, nor take the arrows away from a
//! focused widget other than the slider of what is driven.

use super::action::{Action, FileTask, KeepFrom, LessonAct};
use super::view_state::ViewState;
use super::{lesson, sliders};
use crate::lessons::{Question, Stage};
use crate::storage::presets;
use egui::{Context, Event, Key, Modifiers, Popup};

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

/// Turns this frame's key presses into actions. `dialog_open` leaves only what concerns the dialog.
pub fn collect(ctx: &Context, state: &ViewState, dialog_open: bool, actions: &mut Vec<Action>) {
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
            command(key, modifiers).filter(|action| free || !of_text(action))
        } else if dialog_open {
            (key == Key::Escape).then_some(Action::CloseDialog)
        } else if free && let Some(act) = in_lesson(key, modifiers, state) {
            Some(Action::Lesson(act))
        } else if free {
            held(key, modifiers).or_else(|| if repeat { None } else { pressed(key, state) })
        } else {
            None
        };
        actions.extend(action);
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
            let [low, high] = lesson::guessable(state);
            let step = lesson::STEP * if modifiers.shift { 0.1 } else { 1.0 };
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

fn command(key: Key, modifiers: Modifiers) -> Option<Action> {
    match key {
        Key::O => Some(Action::AskFile(FileTask::OpenScene)),
        Key::S => Some(Action::AskFile(FileTask::SaveScene)),
        Key::Q => Some(Action::Quit),
        Key::K => Some(Action::ToggleCommands),
        Key::Z if !modifiers.shift => Some(Action::Undo),
        Key::Z | Key::Y => Some(Action::Redo),
        _ => None,
    }
}

/// Keys that go on while they are held down.
fn held(key: Key, modifiers: Modifiers) -> Option<Action> {
    let fine = if modifiers.shift { 0.1 } else { 1.0 };
    Some(match key {
        Key::ArrowLeft | Key::ArrowDown => Action::Step(-fine),
        Key::ArrowRight | Key::ArrowUp => Action::Step(fine),
        Key::PageDown => Action::Step(-COARSE),
        Key::PageUp => Action::Step(COARSE),
        Key::Period => Action::Increment,
        Key::J => Action::StepJump(1),
        Key::K => Action::StepJump(-1),
        Key::OpenBracket => Action::StepState(-1),
        Key::CloseBracket => Action::StepState(1),
        _ => return None,
    })
}

fn pressed(key: Key, state: &ViewState) -> Option<Action> {
    Some(match key {
        Key::Home => Action::SetTarget(state.limits.1),
        Key::End => Action::SetTarget(state.limits.0),
        Key::Space => Action::TogglePlay,
        Key::R => Action::Reverse,
        Key::L => Action::Keep(KeepFrom::Best),
        Key::G => Action::GoOn,
        Key::S => Action::AskFile(FileTask::ExportLoopPng),
        Key::Escape if state.run.selection.is_some() && !state.run.is_busy() => {
            Action::ClearSelection
        }
        Key::Escape if state.run.is_busy() => Action::Stop,
        Key::Escape if state.messages.failure.is_some() => Action::DismissFailure,
        Key::Escape if state.view.lecture => Action::ToggleLecture,
        Key::Escape => Action::Stop,
        Key::F11 => Action::ToggleLecture,
        Key::F1 => Action::ToggleHelp,
        _ => {
            let digits = [
                Key::Num1,
                Key::Num2,
                Key::Num3,
                Key::Num4,
                Key::Num5,
                Key::Num6,
                Key::Num7,
                Key::Num8,
                Key::Num9,
            ];
            let index = digits.iter().position(|&digit| digit == key)?;
            return (index < presets::all().len()).then_some(Action::LoadPreset(index));
        }
    })
}
