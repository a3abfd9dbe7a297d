//! What stands below the plot: one of several views behind a strip of tabs.
//!
//! A tab is a file of the folder `tabs` and an entry of [`Tabs::default`]. It holds its state, its
//! job and what was asked of it; what other panels show of it, it puts into the [`ViewState`].

mod accuracy;
mod branches;
mod equations;
mod event_list;
mod ground;
mod kept;
mod landscape;
mod map;
mod paper;
mod relief;
mod stability;
mod study;
mod why;

use super::action::{Action, ViewOptions};
use super::diagram;
use super::view_state::ViewState;
use super::widgets::{choosable, menu, progress};
use super::words::explain;
use crate::plot::panel::Panel;
use crate::worker::SolverHandle;
use crate::worker::job::Job;
use egui::{Color32, Context, Label, RichText, Role, TextStyle, Ui, Vec2};
use egui_plot::PlotResponse;

/// What a tab is called, and the room that it wants.
#[derive(Clone, Copy, Debug)]
pub struct Title {
    /// Its name.
    pub name: &'static str,
    /// Its name in the strip.
    pub short: &'static str,
    /// What it shows, while the pointer rests on it.
    pub what: &'static str,
    /// It wants more room than the plot above.
    pub tall: bool,
}

impl Title {
    const fn new(name: &'static str, what: &'static str) -> Self {
        Self {
            name,
            short: name,
            what,
            tall: false,
        }
    }

    const fn tall(name: &'static str, what: &'static str) -> Self {
        Self {
            tall: true,
            ..Self::new(name, what)
        }
    }
}

/// What a tab works with, once a frame.
pub struct Update<'a> {
    /// What the window shows.
    pub state: &'a mut ViewState,
    /// Who begins its job.
    pub solver: &'a dyn SolverHandle,
    /// The tab is the chosen one.
    pub seen: bool,
}

/// A view behind the strip. Its methods are called whether it is the chosen one or not, but for
/// `show`.
pub trait Tab {
    /// What it is called.
    fn title(&self) -> Title;

    /// Draws it, and notes what is asked of it: `update` acts.
    fn show(&mut self, ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>);

    /// Once a frame, before anything is drawn: does what was asked of it, takes in what its job has
    /// found, and begins one if somebody looks.
    fn update(&mut self, _with: Update<'_>) {}

    /// Draws what floats over the panels.
    fn float(&mut self, _ctx: &Context, _state: &ViewState, _actions: &mut Vec<Action>) {}

    /// The diagrams that it shows, for a file.
    fn panels(&self, _state: &ViewState) -> Vec<Panel> {
        Vec::new()
    }

    /// What it does beyond being shown, by names for the palette of commands.
    fn commands(&self) -> Vec<String> {
        Vec::new()
    }

    /// Is asked for the command of this index.
    fn command(&mut self, _index: usize) {}

    /// Shows things as at first.
    fn restore(&mut self) {}
}

/// The tabs in order.
pub struct Tabs(Vec<Box<dyn Tab>>);

impl Default for Tabs {
    fn default() -> Self {
        Self(vec![
            Box::<why::Why>::default(),
            Box::new(event_list::EventList),
            Box::new(kept::KeptTab),
            Box::<stability::Stability>::default(),
            Box::<branches::Branches>::default(),
            Box::<landscape::LandscapeTab>::default(),
            Box::<map::Map>::default(),
            Box::<relief::Relief>::default(),
            Box::<ground::GroundTab>::default(),
            Box::<accuracy::Accuracy>::default(),
            Box::<study::StudyTab>::default(),
            Box::new(equations::Equations),
            Box::<paper::Paper>::default(),
        ])
    }
}

impl Tabs {
    /// The diagrams of the chosen tab, and its name.
    pub fn panels(&self, state: &ViewState) -> (&'static str, Vec<Panel>) {
        let tab = self.0.get(state.view.tab);
        tab.map_or(("", Vec::new()), |tab| {
            (tab.title().name, tab.panels(state))
        })
    }

    /// Once a frame, before anything is drawn.
    pub fn update(&mut self, state: &mut ViewState, solver: &dyn SolverHandle) {
        for (index, tab) in self.0.iter_mut().enumerate() {
            let seen = state.view.tab == index;
            tab.update(Update {
                state,
                solver,
                seen,
            });
        }
    }

    /// The height of legend and plot above: the rest of the column goes to the tab.
    pub fn plot_height(&self, ui: &Ui, state: &ViewState) -> f32 {
        let whole = ui.available_height();
        let tall = self
            .0
            .get(state.view.tab)
            .is_some_and(|tab| tab.title().tall);
        let (share, least) = match tall {
            true => (0.36, 215.0),
            false if whole < 600.0 => (0.46, 190.0),
            false => (0.6, 260.0),
        };
        (share * whole).max(least)
    }

    /// The strip, and the chosen view in the rest of the space.
    pub fn show(&mut self, ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
        let titles: Vec<Title> = self.titles().collect();
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 2.0;
            ui.spacing_mut().button_padding.x = 5.0;
            let shown = shown(ui, &titles, state.view.tab);
            for &index in &shown {
                offer(ui, state, (index, &titles[index]), actions);
            }
            if shown.len() == titles.len() {
                return;
            }
            menu(ui, MORE, ["More tabs", "the other tabs"], |ui| {
                let rest = titles.iter().enumerate();
                for tab in rest.filter(|(index, _)| !shown.contains(index)) {
                    if offer(ui, state, tab, actions) {
                        ui.close();
                    }
                }
            });
        });
        if let Some(tab) = self.0.get_mut(state.view.tab) {
            tab.show(ui, state, actions);
        }
    }

    /// Draws what floats over the panels.
    pub fn float(&mut self, ctx: &Context, state: &ViewState, actions: &mut Vec<Action>) {
        for tab in &mut self.0 {
            tab.float(ctx, state, actions);
        }
    }

    /// For the palette: the name of each tab and of what it does, with the actions.
    pub fn commands(&self, state: &ViewState) -> Vec<(String, Vec<Action>)> {
        let titles = self.titles().enumerate();
        let choices =
            titles.map(|(tab, title)| (format!("Tab: {}", title.name), vec![choose(tab, state)]));
        let own = self.0.iter().enumerate().flat_map(|(tab, held)| {
            let named = held.commands().into_iter().enumerate();
            named.map(move |(index, name)| {
                let command = Action::CommandTab { tab, index };
                (name, vec![choose(tab, state), command])
            })
        });
        choices.chain(own).collect()
    }

    /// Asks a tab for its command of this index.
    pub fn command(&mut self, tab: usize, index: usize) {
        if let Some(tab) = self.0.get_mut(tab) {
            tab.command(index);
        }
    }

    /// Shows things as at first.
    pub fn restore(&mut self) {
        self.0.iter_mut().for_each(|tab| tab.restore());
    }

    /// The place of the tab of this name.
    pub fn index(&self, name: &str) -> Option<usize> {
        self.titles().position(|title| title.name == name)
    }

    fn titles(&self) -> impl Iterator<Item = Title> + '_ {
        self.0.iter().map(|tab| tab.title())
    }
}

/// The face of the menu of the tabs that have no room.
const MORE: &str = "⋯";

/// The tabs of a strip in one row: as many as it has room for, the `chosen` one among them.
fn shown(ui: &Ui, titles: &[Title], chosen: usize) -> Vec<usize> {
    let font = TextStyle::Button.resolve(ui.style());
    let (padding, gap) = (
        2.0 * ui.spacing().button_padding.x,
        ui.spacing().item_spacing.x,
    );
    let width = |words: &str| {
        let galley = ui
            .painter()
            .layout_no_wrap(words.to_owned(), font.clone(), Color32::WHITE);
        galley.size().x + padding + gap
    };
    let widths: Vec<f32> = titles.iter().map(|title| width(title.short)).collect();
    let room = ui.available_width();
    if widths.iter().sum::<f32>() <= room {
        return (0..titles.len()).collect();
    }
    let mut left = room - width(MORE) - widths.get(chosen).copied().unwrap_or_default();
    let mut shown = Vec::new();
    for (index, width) in widths
        .iter()
        .enumerate()
        .filter(|(index, _)| *index != chosen)
    {
        left -= width;
        if left < 0.0 {
            break;
        }
        shown.push(index);
    }
    shown.push(chosen);
    shown.sort_unstable();
    shown
}

/// A tab to choose; true when it was.
fn offer(
    ui: &mut Ui,
    state: &ViewState,
    (index, title): (usize, &Title),
    actions: &mut Vec<Action>,
) -> bool {
    let chosen = state.view.tab == index;
    let response = ui
        .selectable_label(chosen, title.short)
        .on_hover_text(title.what);
    choosable(&response, Role::Tab, chosen, &format!("{} tab", title.name));
    let asked = response.clicked() && !chosen;
    if asked {
        actions.push(choose(index, state));
    }
    asked
}

/// What is said of a button that ends a measurement.
const STAYS: &str = "what is measured stays";

fn choose(tab: usize, state: &ViewState) -> Action {
    Action::SetView(ViewOptions { tab, ..state.view })
}

/// What a job is doing, small, cut where there is no room.
fn doing<T>(ui: &mut Ui, job: &Job<T>) {
    ui.add(Label::new(RichText::new(&job.doing).small()).truncate())
        .on_hover_text(&job.doing);
}

/// How far a job is and what it does, or why it could not be finished.
fn under_way<T>(ui: &mut Ui, job: &Job<T>) {
    if job.is_running() {
        progress(ui, job);
        doing(ui, job);
    } else if let Some(why) = &job.failed {
        ui.label(RichText::new(why).small());
    }
}

/// One of several diagrams in a tab, in so much room, under these words.
fn small(ui: &mut Ui, panel: &Panel, words: &str, size: Vec2) -> PlotResponse<()> {
    ui.allocate_ui(size, |ui| {
        ui.vertical(|ui| {
            explain(ui.small(words), words);
            let height = ui.available_height().max(60.0);
            diagram::show(ui, panel, words, height, |_, _| None)
        })
        .inner
    })
    .inner
}

/// Takes in what a measurement has found; one that ends early says why.
fn take_in<T>(job: &mut Job<T>, state: &mut ViewState) {
    if let Some(Err(why)) = job.poll() {
        let message = format!("The measurement ended early: {why}.");
        state.messages.fail(message, "What was measured stands.");
    }
}
