//! How the panels share the window: three beside each other, or two, or one at a time; and in lecture
//! mode map, curve and one line of words, large and on white, for a room.

use super::action::{Action, Page};
use super::gap_picture::Maps;
use super::headline::capital;
use super::tabs::Tabs;
use super::view_state::ViewState;
use super::widgets::described;
use super::{controls, gap_map, lesson, loop_plot, profile, status_bar, strip, toolbar};
use crate::lessons::Hidden;
use crate::scene::units::fixed;
use crate::solver::Stop;
use egui::scroll_area::ScrollSource;
use egui::{
    CentralPanel, Context, Label, Panel, RichText, ScrollArea, Theme, Ui, UiBuilder, Vec2, vec2,
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
    Panel::bottom("status").show(ui, |ui| status_bar::show(ui, state, actions));
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
        below.show(ui, |ui| lesson::show(ui, state, actions, 1.0));
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
        lesson::show(ui, state, actions, if hidden { 1.0 } else { LESSON });
    }
    if !hidden {
        controls::show(ui, state, actions);
    }
}

/// Map, profile and strip.
pub fn surface(ui: &mut Ui, state: &ViewState, maps: &Maps, actions: &mut Vec<Action>) {
    gap_map::show(ui, state, actions, maps);
    profile::show(ui, state, maps.a.picture.as_ref(), actions);
    strip::show(ui, state, actions);
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
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                if ui.small_button("Leave (F11)").clicked() {
                    actions.push(Action::ToggleLecture);
                }
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
    let closed = state.run.closed_loop.as_ref();
    let loss = closed.and_then(|closed| closed.summary.ledger.dissipated_energy());
    match (loss, jumps.last()) {
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
