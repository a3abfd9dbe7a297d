//! How the panels share the window: three beside each other, or two, or one at a time.

use super::action::{Action, Page};
use super::gap_map;
use super::gap_picture::Maps;
use super::tabs::Tabs;
use super::view_state::ViewState;
use super::{controls, lesson, loop_plot, profile, status_bar, strip, toolbar};
use crate::lessons::Hidden;
use egui::scroll_area::ScrollSource;
use egui::{CentralPanel, Panel, ScrollArea, Ui, UiBuilder};

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
