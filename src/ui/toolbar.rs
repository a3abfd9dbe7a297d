//! The top bar: preset, play, files, theme, help.

use super::action::{Action, FileTask, LessonAct, ViewOptions};
use super::theme::set;
use super::view_state::ViewState;
use super::widgets::named;
use crate::lessons;
use crate::plot::typeset::plain;
use crate::storage::presets;
use crate::worker::protocol::{Speed, Sweep};
use egui::{Align, ComboBox, Layout, RichText, Ui, vec2};

/// Width of the button beside the presets, with its gap (points).
const INFO: f32 = 26.0;

/// The bar; it wraps where the window is narrow.
pub fn show(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        preset(ui, state, actions);
        learn(ui, actions);
        ui.separator();
        play(ui, state, actions);
        ui.separator();
        for (face, hover, action) in [
            ("Open…", "Ctrl+O", Action::AskFile(FileTask::OpenScene)),
            ("Save…", "Ctrl+S", Action::AskFile(FileTask::SaveScene)),
            (
                "Export CSV…",
                "states or jumps of what is recorded",
                Action::AskFile(FileTask::ExportLoopCsv),
            ),
            ("Export PNG…", "S", Action::AskFile(FileTask::ExportLoopPng)),
            (
                "Copy scene",
                "the scene as text on the clipboard (Ctrl+C); Ctrl+V opens one",
                Action::CopyScene,
            ),
        ] {
            if ui.button(face).on_hover_text(hover).clicked() {
                actions.push(action);
            }
        }
        let theme = if ui.visuals().dark_mode { "☀" } else { "☾" };
        let history = &state.history;
        let layout = "panels, axes and view as they were at first";
        for (face, name, hover, enabled, action) in [
            ("↶", "Undo", "Undo", history.can_undo(), Action::Undo),
            ("↷", "Redo", "Redo", history.can_redo(), Action::Redo),
            (
                theme,
                "Switch theme",
                "light or dark",
                true,
                Action::ToggleTheme,
            ),
            ("▣", "Restore layout", layout, true, Action::RestoreLayout),
            ("?", "Help", "keys and marks (?)", true, Action::ToggleHelp),
        ] {
            let button = ui.add_enabled(enabled, egui::Button::new(face));
            if named(button, name).on_hover_text(hover).clicked() {
                actions.push(action);
            }
        }
    });
}

fn preset(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let label = ui.label("Preset");
    let opened = presets::titled(state.title_opened());
    // The button beside it takes its room from it: the bar is full.
    let room = if ui.ctx().content_rect().width() < 1000.0 {
        130.0
    } else {
        140.0
    };
    let width = if opened.is_some() { room - INFO } else { room };
    let title = plain(&state.scene.title);
    // A width of its own bounds a combo box from below only; a long title must not push the bar
    // into a second row.
    let size = vec2(width, ui.spacing().interact_size.y);
    ui.allocate_ui_with_layout(size, Layout::left_to_right(Align::Center), |ui| {
        let combo = ComboBox::from_id_salt("preset")
            .width(width)
            .selected_text(title.as_str())
            .truncate()
            .show_ui(ui, |ui| {
                for (i, preset) in presets::all().iter().enumerate() {
                    let key = if i < 9 {
                        format!("{}  {}", i + 1, preset.name)
                    } else {
                        preset.name.to_owned()
                    };
                    if ui.selectable_label(false, key).clicked() {
                        actions.push(Action::LoadPreset(i));
                    }
                }
            });
        combo
            .response
            .labelled_by(label.id)
            .on_hover_text(format!("{title}\n{}", state.scene.source));
    });
    if let Some(preset) = opened {
        let card = ui.menu_button("ℹ", |ui| look_for(ui, preset, state));
        named(card.response, "What to look for").on_hover_text("what to look for in this preset");
    }
}

/// What the preset that was opened shows, on a card.
fn look_for(ui: &mut Ui, preset: &presets::Preset, state: &ViewState) {
    ui.set_width(340.0);
    // A menu's own layout justifies its lines.
    ui.with_layout(Layout::top_down(Align::LEFT), |ui| {
        ui.label(set(
            state.title_opened(),
            14.0,
            ui.visuals().strong_text_color(),
        ));
        ui.label(set(&preset.look_for(), 13.0, ui.visuals().text_color()));
        ui.label(RichText::new(&state.scene.source).small().weak());
    });
}

/// The lessons.
fn learn(ui: &mut Ui, actions: &mut Vec<Action>) {
    let menu = ui.menu_button("Learn", |ui| {
        for (index, lesson) in lessons::all().iter().enumerate() {
            let words = format!("{}  {} ({} min)", index + 1, lesson.title, lesson.minutes);
            if ui.button(words).on_hover_text(&lesson.teaches).clicked() {
                actions.push(Action::Lesson(LessonAct::Start(index)));
            }
        }
        ui.separator();
        if ui.button("Lecture mode (F11)").clicked() {
            actions.push(Action::ToggleLecture);
        }
    });
    named(menu.response, "Lessons").on_hover_text("lessons of about five minutes");
}

fn play(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    for (text, name, sweep) in [
        ("▼ Approach", "Play approach", Sweep::Approach),
        ("▲ Retract", "Play retract", Sweep::Retract),
        ("⟳ Loop", "Play loop", Sweep::Loop),
    ] {
        let button = egui::Button::new(text).selected(state.run.sweep() == Some(sweep));
        if named(ui.add(button), name).on_hover_text(name).clicked() {
            actions.push(Action::Play(sweep));
        }
    }
    let (face, name) = if state.run.paused {
        ("▶", "Go on")
    } else {
        ("⏸", "Pause")
    };
    let (busy, paused) = (state.run.is_busy(), state.run.paused);
    for (face, name, key, enabled, action) in [
        (face, name, "Space", busy || paused, Action::Pause(!paused)),
        ("⏹", "Stop", "Esc", busy, Action::Stop),
    ] {
        let button = named(ui.add_enabled(enabled, egui::Button::new(face)), name);
        if button.on_hover_text(format!("{name} ({key})")).clicked() {
            actions.push(action);
        }
    }
    speed(ui, state, actions);
    if ui
        .button("Reset")
        .on_hover_text("Back to rest at the start")
        .clicked()
    {
        actions.push(Action::Reset);
    }
}

/// What each speed is called, short and in full.
pub const SPEEDS: [(Speed, &str, &str); 3] = [
    (Speed::Slow, "¼×", "slow motion"),
    (Speed::Normal, "1×", "normal speed"),
    (Speed::Full, "max", "as fast as it is computed"),
];

fn speed(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let present = SPEEDS
        .iter()
        .find(|(speed, ..)| *speed == state.view.speed)
        .map_or("", |(_, short, _)| short);
    let combo = ComboBox::from_id_salt("speed")
        .width(44.0)
        .selected_text(present)
        .show_ui(ui, |ui| {
            for (speed, short, words) in SPEEDS {
                if ui
                    .selectable_label(speed == state.view.speed, format!("{short}  {words}"))
                    .clicked()
                {
                    actions.push(Action::SetView(ViewOptions {
                        speed,
                        ..state.view
                    }));
                }
            }
        });
    named(combo.response, "Speed").on_hover_text("how fast sweeps and jumps are shown");
}
