//! How the panels share the window: three beside each other, or two, or one at a time, with that of a
//! lesson among them (its text, its question, its task, what is explained, and where it is); and in
//! lecture mode map, curve and one line of words, large and on white, for a room.

use super::action::{Action, LessonAct, Page};
use super::gap_picture::Maps;
use super::headline::capital;
use super::tabs::Tabs;
use super::view_state::ViewState;
use super::widgets::{Asks, Entry, at_right, described, named, radio};
use super::{controls, gap_map, headline, loop_plot, profile, theme, toolbar};
use crate::lessons::{self, Hidden, Lesson, Progress, Question, Stage};
use crate::scene::parameter::fixed;
use crate::solver::Stop;
use egui::scroll_area::ScrollSource;
use egui::{
    CentralPanel, Context, Frame, Label, Panel, RichText, ScrollArea, Theme, Ui, UiBuilder, Vec2,
    vec2,
};
use serde::{Deserialize, Serialize};

/// Widths from which three and two panels stand beside each other (points).
const THREE: f32 = 880.0;
const TWO: f32 = 540.0;
/// The least height of the panels; in a lower window they scroll.
const LOW: f32 = 300.0;
/// The share of the left panel that a lesson takes beside the controls, and that of a narrow window.
const LESSON: f32 = 0.55;
const BELOW: f32 = 0.4;

/// What can be chosen where the panels are not all shown.
fn pages(width: f32) -> &'static [Page] {
    if width >= THREE {
        &[]
    } else if width >= TWO {
        &[Page::Curve, Page::Scene]
    } else {
        &[Page::Surface, Page::Curve, Page::Scene]
    }
}

/// Everything but dialogs.
pub fn show(
    ui: &mut Ui,
    state: &ViewState,
    maps: &Maps,
    tabs: &mut Tabs,
    actions: &mut Vec<Action>,
) {
    let width = ui.available_width();
    let pages = pages(width);
    Panel::top("toolbar").show(ui, |ui| {
        ui.add_space(3.0);
        toolbar::show(ui, state, pages, actions);
        ui.add_space(3.0);
    });
    Panel::bottom("status").show(ui, |ui| headline::bar(ui, state, actions));
    let room = ui.available_size();
    if room.y >= LOW {
        return panels(ui, state, maps, tabs, actions);
    }
    // Dragging belongs to sliders, map and plots.
    ScrollArea::vertical()
        .id_salt("panels")
        .auto_shrink(false)
        .scroll_source(ScrollSource::SCROLL_BAR | ScrollSource::MOUSE_WHEEL)
        .show(ui, |ui| {
            let (_, rect) = ui.allocate_space(egui::vec2(ui.available_width(), LOW));
            let mut inside = ui.new_child(UiBuilder::new().max_rect(rect));
            panels(&mut inside, state, maps, tabs, actions);
        });
}

fn panels(ui: &mut Ui, state: &ViewState, maps: &Maps, tabs: &mut Tabs, actions: &mut Vec<Action>) {
    let width = ui.available_width();
    let page = state.view.page;
    // A width drawn by hand is kept for windows of about that size: one from a small window would
    // cut the lists of a large one.
    let about = (width / 200.0) as u32;
    if width >= THREE {
        let learns = state.lesson().is_some();
        let usual = if learns { 320.0 } else { 260.0 };
        let left = Panel::left(("controls", learns, about))
            .default_size((0.27 * width).min(usual))
            .size_range(220.0..=0.35 * width);
        left.show(ui, |ui| scene(ui, state, actions));
    } else if state.lesson().is_some() {
        let height = BELOW * ui.available_height();
        let below = Panel::bottom("lesson").exact_size(height);
        below.show(ui, |ui| lesson(ui, state, actions, 1.0));
    }
    if width < TWO {
        CentralPanel::default().show(ui, |ui| match page {
            Page::Surface => surface(ui, state, maps, actions),
            Page::Curve => curve(ui, state, tabs, actions),
            Page::Scene => scene(ui, state, actions),
        });
        return;
    }
    let rest = ui.available_width();
    let right = Panel::right(("curve", about))
        .default_size((0.43 * rest).clamp(250.0, 700.0))
        .size_range(230.0..=(0.6 * rest).max(240.0));
    right.show(ui, |ui| {
        if width < THREE && page == Page::Scene {
            scene(ui, state, actions);
        } else {
            curve(ui, state, tabs, actions);
        }
    });
    CentralPanel::default().show(ui, |ui| surface(ui, state, maps, actions));
}

/// The lesson where there is room for it, and what the scene is made of.
fn scene(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let hidden = state.hides(Hidden::Controls);
    if ui.ctx().content_rect().width() >= THREE {
        lesson(ui, state, actions, if hidden { 1.0 } else { LESSON });
    }
    if !hidden {
        controls::show(ui, state, actions);
    }
}

/// Map, profile and strip.
pub fn surface(ui: &mut Ui, state: &ViewState, maps: &Maps, actions: &mut Vec<Action>) {
    gap_map::show(ui, state, actions, maps);
    profile::show(ui, state, maps.a.picture.as_ref(), actions);
    profile::strip(ui, state, actions);
}

/// The plot, and below it the tabs.
fn curve(ui: &mut Ui, state: &ViewState, tabs: &mut Tabs, actions: &mut Vec<Action>) {
    if state.hides(Hidden::Tabs) {
        let height = ui.available_height() - 12.0;
        return loop_plot::show(ui, state, actions, height);
    }
    let height = tabs.plot_height(ui, state);
    loop_plot::show(ui, state, actions, height);
    ui.separator();
    tabs.show(ui, state, actions);
}

/// How much larger everything is at most: words of 15 points become 21, lines of 2 points 3.
const ZOOM: f32 = 1.4;
/// The size from which it is: in a smaller window there would be no room for map and curve.
const LARGE: Vec2 = vec2(880.0, 580.0);

/// How the window looked before.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Before {
    zoom: f32,
    dark: bool,
}

impl Before {
    /// Makes everything large and light; returns how it was.
    pub fn enlarge(ctx: &Context) -> Self {
        let before = Self {
            zoom: ctx.zoom_factor(),
            dark: ctx.theme() == Theme::Dark,
        };
        let share = ctx.content_rect().size() * before.zoom / LARGE;
        ctx.set_zoom_factor((ZOOM * share.min_elem()).clamp(1.0, ZOOM));
        ctx.set_theme(Theme::Light);
        before
    }

    /// Brings the look back.
    pub fn restore(self, ctx: &Context) {
        ctx.set_zoom_factor(self.zoom);
        ctx.set_theme(if self.dark { Theme::Dark } else { Theme::Light });
    }
}

/// Draws all of the window.
pub fn lecture(ui: &mut Ui, state: &ViewState, maps: &Maps, actions: &mut Vec<Action>) {
    Panel::bottom("words").show(ui, |ui| {
        ui.horizontal(|ui| {
            let words = words(state);
            let label = ui.add(Label::new(RichText::new(&words)).truncate());
            described(&label, &words);
            at_right(ui, |ui| {
                ui.small_button("Leave (F11)")
                    .asks(actions, Action::ToggleLecture);
            });
        });
    });
    let half = 0.5 * ui.available_width();
    Panel::right("lecture").exact_size(half).show(ui, |ui| {
        let height = ui.available_height() - 12.0;
        loop_plot::show(ui, state, actions, height);
    });
    CentralPanel::default().show(ui, |ui| surface(ui, state, maps, actions));
}

/// What there is to see, in one line.
fn words(state: &ViewState) -> String {
    let jumps = &state.run.record.jumps;
    if state.jumping().is_some() {
        return "It jumps.".to_owned();
    }
    let Some(now) = &state.run.state else {
        return "Waiting for the solver.".to_owned();
    };
    let stable = if now.stop == Stop::Stable {
        "stable"
    } else {
        "not stable"
    };
    let u0 = now.mean_displacement / state.rho();
    let mut words = format!(
        "{} at u₀ = {} ρ, {stable}.",
        capital(now.pattern.words()),
        fixed(u0, 2)
    );
    match (state.run.loss(), jumps.last()) {
        (Some(loss), _) => words += &format!(" The loop lost {} γ.", fixed(loss, 3)),
        (None, Some(jump)) => {
            words += &format!(
                " {} set free {} γ.",
                capital(&jump.change()),
                fixed(jump.released_energy, 3)
            );
        }
        (None, None) if state.plots.guesses.is_empty() => {
            words += " Where will it snap? Click your guesses into the plot.";
        }
        (None, None) => {
            let guesses: Vec<String> = state
                .plots
                .guesses
                .iter()
                .map(|g| format!("{g:.2}"))
                .collect();
            words += &format!(" Guesses: {} ρ.", guesses.join(", "));
        }
    }
    words
}

/// Size of the words.
const WORDS: f32 = 15.0;

/// Draws the panel's contents in this share of its height; they scroll where the window is low.
fn lesson(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>, share: f32) {
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
        at_right(ui, |ui| {
            named(ui.small_button("✖"), "Leave the lesson").asks(acts, LessonAct::Leave);
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
            let [low, high] = state.guessable();
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
        button.on_hover_text("Enter").asks(acts, LessonAct::Commit);
    }
    ui.add_space(6.0);
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
        named(back, "Back one step")
            .on_hover_text("Backspace")
            .asks(acts, LessonAct::Back);
        let done = progress.stage == Stage::Explained;
        let (face, hover) = match done {
            true if progress.step + 1 == lesson.steps.len() => ("Finish", "Enter"),
            true => ("Next", "Enter"),
            false => ("Skip this step", "go on without it"),
        };
        let button = egui::Button::new(face).selected(done);
        ui.add(button)
            .on_hover_text(hover)
            .asks(acts, LessonAct::Next);
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
        ui.button("Back").asks(acts, LessonAct::Back);
        if let Some(other) = all.get(next)
            && ui.button(format!("Next lesson: {}", other.title)).clicked()
        {
            acts.push(LessonAct::Start(next));
        }
        ui.button("Leave").asks(acts, LessonAct::Leave);
    });
}
