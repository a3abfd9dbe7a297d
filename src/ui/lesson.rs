//! The panel of a lesson: its text, its question, its task, what is explained, and where it is.

use super::action::{Action, LessonAct};
use super::theme;
use super::view_state::ViewState;
use super::widgets::{Entry, described, named, radio};
use crate::lessons::{self, Lesson, Progress, Question, Stage};
use egui::{Frame, RichText, ScrollArea, Ui};

/// Size of the words.
const WORDS: f32 = 15.0;
/// A step of a guess by key, in ranges; with Shift a tenth of it.
pub const STEP: f64 = 0.1;

/// Draws the panel's contents in this share of its height; they scroll where the window is low.
pub fn show(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>, share: f32) {
    let Some((lesson, progress)) = state.lesson() else {
        return;
    };
    let height = ui.available_height();
    let mut acts = Vec::new();
    head(ui, lesson, progress, &mut acts);
    ScrollArea::vertical()
        .id_salt("lesson")
        .max_height(share * height - 60.0)
        .auto_shrink([false, share < 1.0])
        .show(ui, |ui| match progress.step(lesson) {
            Some(step) => {
                paragraphs(ui, &progress.filled(&step.text));
                if let Some(question) = &step.question {
                    ask(ui, state, (question, progress), &mut acts);
                }
                if let Some(task) = step
                    .task
                    .as_ref()
                    .filter(|_| progress.stage != Stage::Asking)
                {
                    let done = progress.stage == Stage::Explained;
                    do_it(ui, &task.words, done);
                }
                if let Some(words) = progress.explanation(lesson) {
                    explain(ui, &words);
                }
                ui.add_space(6.0);
                onwards(ui, lesson, progress, &mut acts);
            }
            None => end(ui, lesson, progress, &mut acts),
        });
    actions.extend(acts.into_iter().map(Action::Lesson));
}

/// Title, place and score.
fn head(ui: &mut Ui, lesson: &Lesson, progress: &Progress, acts: &mut Vec<LessonAct>) {
    ui.horizontal(|ui| {
        ui.label(RichText::new(&lesson.title).heading().strong());
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if named(ui.small_button("✖"), "Leave the lesson").clicked() {
                acts.push(LessonAct::Leave);
            }
        });
    });
    let (step, steps) = (
        progress.step.min(lesson.steps.len() - 1),
        lesson.steps.len(),
    );
    let [score, most] = progress.score;
    let mut words = format!("Step {} of {steps}", step + 1);
    if most > 0 {
        words += &format!(" · {score} of {most} points");
    }
    ui.label(RichText::new(words).weak());
    ui.separator();
}

/// A text whose paragraphs are parted by an empty line.
fn paragraphs(ui: &mut Ui, text: &str) {
    for paragraph in text.split("\n\n") {
        let words = paragraph.split_whitespace().collect::<Vec<_>>().join(" ");
        ui.label(RichText::new(words).size(WORDS));
        ui.add_space(4.0);
    }
}

fn ask(
    ui: &mut Ui,
    state: &ViewState,
    (question, progress): (&Question, &Progress),
    acts: &mut Vec<LessonAct>,
) {
    let waits = progress.stage == Stage::Asking;
    let (Question::Guess { asks, .. } | Question::Choice { asks, .. }) = question;
    ui.label(RichText::new(asks).size(WORDS).strong());
    match question {
        Question::Choice { options, .. } => {
            for (index, option) in options.iter().enumerate() {
                let answer = Some(index as f64);
                let words = RichText::new(format!("{}  {option}", index + 1)).size(WORDS);
                // Also to be read afterwards.
                if radio(ui, &progress.answer, &answer, words).clicked() && waits {
                    acts.push(LessonAct::Choose(index as f64));
                }
            }
        }
        Question::Guess { .. } => {
            let [low, high] = guessable(state);
            let entry = Entry {
                name: "Your guess",
                value: progress.answer.unwrap_or(0.5 * (low + high)),
                range: low..=high,
                speed: 0.01,
                decimals: 2,
                suffix: " ρ",
            };
            ui.horizontal(|ui| {
                let label = ui.label("Your guess u₀");
                let shown = ui.add_enabled_ui(waits, |ui| entry.show(ui));
                let (guess, response) = shown.inner;
                response.labelled_by(label.id);
                acts.extend(guess.map(LessonAct::Choose));
            });
        }
    }
    if waits {
        let button = ui.add_enabled(
            progress.answer.is_some(),
            egui::Button::new("That is my answer"),
        );
        if button.on_hover_text("Enter").clicked() {
            acts.push(LessonAct::Commit);
        }
    }
    ui.add_space(6.0);
}

/// Between which values u0 can be guessed (ranges).
pub fn guessable(state: &ViewState) -> [f64; 2] {
    let ([left, _], [right, _]) = state.axes();
    [left.max(0.0), right]
}

fn do_it(ui: &mut Ui, words: &str, done: bool) {
    let palette = theme::palette(ui);
    let (mark, colour) = if done {
        ("✔", palette.good)
    } else {
        ("▶", palette.retraction)
    };
    ui.horizontal_top(|ui| {
        ui.label(RichText::new(mark).size(WORDS).color(colour));
        ui.add(egui::Label::new(RichText::new(words).size(WORDS)).wrap());
    });
    ui.add_space(4.0);
}

/// What is said at the end of a step; a screen reader says it by itself.
fn explain(ui: &mut Ui, words: &str) {
    let fill = ui.visuals().faint_bg_color;
    let shown = Frame::group(ui.style()).fill(fill).show(ui, |ui| {
        let words = words.split_whitespace().collect::<Vec<_>>().join(" ");
        ui.label(RichText::new(words).size(WORDS))
    });
    ui.ctx().accesskit_node_builder(shown.inner.id, |node| {
        node.set_live(egui::accesskit::Live::Polite);
    });
}

fn onwards(ui: &mut Ui, lesson: &Lesson, progress: &Progress, acts: &mut Vec<LessonAct>) {
    ui.horizontal(|ui| {
        let back = ui.add_enabled(progress.step > 0, egui::Button::new("Back"));
        if named(back, "Back one step")
            .on_hover_text("Backspace")
            .clicked()
        {
            acts.push(LessonAct::Back);
        }
        let done = progress.stage == Stage::Explained;
        let (face, hover) = match done {
            true if progress.step + 1 == lesson.steps.len() => ("Finish", "Enter"),
            true => ("Next", "Enter"),
            false => ("Skip this step", "go on without it"),
        };
        let button = egui::Button::new(face).selected(done);
        if ui.add(button).on_hover_text(hover).clicked() {
            acts.push(LessonAct::Next);
        }
    });
}

fn end(ui: &mut Ui, lesson: &Lesson, progress: &Progress, acts: &mut Vec<LessonAct>) {
    paragraphs(ui, &lesson.teaches);
    let [score, most] = progress.score;
    let words = format!("The end. You have {score} of {most} points.");
    let label = ui.label(RichText::new(&words).size(WORDS).strong());
    described(&label, &words);
    let all = lessons::all();
    let next = all.iter().position(|other| other.name == lesson.name);
    let next = next.map_or(0, |index| index + 1);
    ui.horizontal(|ui| {
        if ui.button("Back").clicked() {
            acts.push(LessonAct::Back);
        }
        if let Some(other) = all.get(next)
            && ui.button(format!("Next lesson: {}", other.title)).clicked()
        {
            acts.push(LessonAct::Start(next));
        }
        if ui.button("Leave").clicked() {
            acts.push(LessonAct::Leave);
        }
    });
}
