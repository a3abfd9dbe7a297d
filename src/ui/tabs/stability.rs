//! How stable the surface is: its smallest eigenvalue along the path, and where the next jump is
//! expected; and which time steps GFMD survives.

use super::{STAYS, Tab, Title, Update, take_in};
use crate::follow::record::Direction;
use crate::physics::parameter::Dimension;
use crate::plot::loop_panel::branches;
use crate::plot::panel::{Along, Area, Axis, Colour, Label, Panel, Role, Series, Symbol};
use crate::scene::parameter::fixed;
use crate::solver::gfmd::GfmdBudget;
use crate::study::forecast::{Forecast, forecast};
use crate::study::time_step_map::TimeStepMap;
use crate::ui::action::{Action, ViewOptions};
use crate::ui::diagram;
use crate::ui::view_state::{Told, ViewState};
use crate::ui::widgets::{checkbox, described, progress, radio_value};
use crate::ui::words::explain;
use crate::worker::background;
use crate::worker::job::Job;
use crate::worker::protocol::RunId;
use egui::{RichText, Ui};

/// Lower end of the axis (E*/L): a strip of the unstable side is always in sight.
const LOWEST: f64 = -0.4;

/// The tab.
#[derive(Default)]
pub struct Stability {
    of: Of,
    /// The measurement of the time-step map, and in which run.
    time_steps: Option<(RunId, Job<TimeStepMap>)>,
    /// It is to begin.
    measure: bool,
}

/// Stability of what.
#[derive(Clone, Copy, PartialEq, Default)]
enum Of {
    /// Of the equilibria: the smallest eigenvalue against u0.
    #[default]
    States,
    /// Of GFMD: which time steps it survives.
    TimeSteps,
}

impl Tab for Stability {
    fn title(&self) -> Title {
        let what = "how far the next jump is, and which time steps GFMD survives";
        Title::new("Stability", what)
    }

    fn show(&mut self, ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
        let before = self.of;
        let mut view: ViewOptions = state.view;
        ui.horizontal_wrapped(|ui| {
            for (of, word) in [(Of::States, "states"), (Of::TimeSteps, "time steps")] {
                explain(radio_value(ui, &mut self.of, of, word), word);
            }
            checkbox(ui, &mut view.soft_mode, "soft mode on map")
                .on_hover_text("contours of the mode that gives way first");
        });
        match before {
            Of::States => eigenvalue(ui, state),
            Of::TimeSteps => self.time_steps(ui, state),
        }
        if view != state.view {
            actions.push(Action::SetView(view));
        }
    }

    fn panels(&self, state: &ViewState) -> Vec<Panel> {
        if self.of == Of::TimeSteps {
            let map = self.map().map(|map| time_step_panel(map, state));
            return map.into_iter().collect();
        }
        vec![eigenvalues(state)]
    }

    fn update(&mut self, Update { state, solver, .. }: Update<'_>) {
        self.time_steps.take_if(|(run, _)| *run != state.run.id);
        if std::mem::take(&mut self.measure) {
            let input = (state.scene.clone(), state.limits.0);
            let job = solver.job(input, background::time_steps);
            state.measure(&job);
            self.time_steps = Some((state.run.id, job));
        }
        if let Some((_, job)) = &mut self.time_steps {
            take_in(job, state);
        }
    }

    fn restore(&mut self) {
        self.of = Of::default();
    }
}

fn eigenvalue(ui: &mut Ui, state: &ViewState) {
    let ahead = forecast(&state.run.record, &state.model);
    let words = foreseen(state, ahead.as_ref());
    explain(ui.label(RichText::new(&words).strong()), "The next jump");
    let unit = state.model.unit(Dimension::Length);
    let hover = |x, eigenvalue| {
        let (u0, eigenvalue) = (unit.say(x, 3, "ρ"), fixed(eigenvalue, 4));
        Some(format!("u₀ {u0}\neigenvalue {eigenvalue} E*/L"))
    };
    let height = ui.available_height().max(80.0);
    let panel = shown(state, ahead.as_ref());
    let drawn = diagram::show(ui, &panel, "eigenvalue", height, hover);
    let sentence = format!(
        "Smallest eigenvalue against u0: {}; {words}",
        present(state)
    );
    described(&drawn.response, &sentence);
}

/// The smallest eigenvalue along the path.
fn eigenvalues(state: &ViewState) -> Panel {
    let (left, right) = (state.axes().0[0], state.axes().1[0]);
    let unit = state.model.unit(Dimension::Length);
    Panel {
        x: Axis::of(&unit, "u_0/rho", "u_0").from_to(left, right),
        y: Axis::signed("smallest eigenvalue (E*/L)").from_to(LOWEST, highest(state)),
        series: branches(&state.run.stiffness),
        ..Panel::default()
    }
}

/// The same with the unstable side, where the next jump is expected, and the present state.
fn shown(state: &ViewState, ahead: Option<&Forecast>) -> Panel {
    let mut panel = eigenvalues(state);
    panel.y.label = "eigenvalue, E*/L".to_owned();
    let (left, right) = (state.axes().0[0], state.axes().1[0]);
    let (rho, high) = (state.rho(), highest(state));
    panel.areas.push(Area {
        colour: Colour::Red,
        spans: [left, right].map(|x| [x, LOWEST, 0.0]).to_vec(),
        ..Area::default()
    });
    // Where what is driven is not u0, words say where.
    if let Some(ahead) = ahead.filter(|_| !state.scene.control().frees_mean()) {
        let ends = [ahead.nearest / rho, ahead.farthest / rho];
        let [a, b] = [ends[0].min(ends[1]), ends[0].max(ends[1])];
        panel.areas.push(Area {
            name: "next jump".to_owned(),
            colour: Colour::JUMP,
            spans: [LOWEST, high].map(|y| [y, a, b]).to_vec(),
            along: Along::Y,
        });
    }
    let word = |at, text: &str, colour, side| Label {
        at,
        text: text.to_owned(),
        colour,
        side,
    };
    panel.labels = vec![
        word([left, 0.4 * LOWEST], "unstable", Colour::Red, [1, 0]),
        word([right, high], &present(state), Colour::Ink, [-1, -1]),
    ];
    if let Some(now) = &state.run.state {
        let (x, of) = (now.mean_displacement / rho, now.stiffness_min);
        let error = [of - now.stiffness_error, of + now.stiffness_error];
        let error = error.map(|end| [x, end]).to_vec();
        let error = Series::line("", Role::Theory, Colour::Ink, error);
        panel.series.push(error);
        let here = [x, of.clamp(LOWEST, high)];
        panel.series.extend(Series::here(Some(here)));
    }
    panel
}

/// The upper end of the axis: the flat state pressed as hard as the drive does.
fn highest(state: &ViewState) -> f64 {
    let length = state.model.grid.length;
    let law = &state.model.law;
    let stiffness = |gap: f64| law.at(gap).stiffness;
    let pressed = stiffness(state.limits.0).max(stiffness(law.equilibrium_gap()));
    1.6 * (std::f64::consts::PI + length * pressed)
}

/// The present eigenvalue with its error.
fn present(state: &ViewState) -> String {
    match &state.run.state {
        None => "nothing recorded yet".to_owned(),
        Some(now) if now.stiffness_error > 0.0 => format!(
            "now {} ± {:.4} E*/L",
            fixed(now.stiffness_min, 4),
            now.stiffness_error
        ),
        Some(now) => format!("now {} E*/L", fixed(now.stiffness_min, 4)),
    }
}

/// The forecast in one line.
fn foreseen(state: &ViewState, ahead: Option<&Forecast>) -> String {
    let Told {
        symbol,
        suffix,
        unit,
        ..
    } = state.told();
    let way = match state.run.direction {
        Direction::Approach => "down",
        Direction::Retraction => "up",
    };
    match ahead {
        None => format!("no jump foreseen going {way}"),
        Some(f) if f.nearest == f.farthest => {
            format!(
                "next jump at {symbol} = {}{suffix} going {way} (exact)",
                fixed(f.nearest / unit, 4)
            )
        }
        Some(f) => {
            let (a, b) = (
                f.nearest.min(f.farthest) / unit,
                f.nearest.max(f.farthest) / unit,
            );
            let digits = if b - a < 0.02 { 4 } else { 2 };
            let [a, b] = [a, b].map(|end| fixed(end, digits));
            format!("next jump between {symbol} = {a} and {b}{suffix} going {way}")
        }
    }
}

/// How far the axis of time steps goes beyond the first and the last, as a factor.
const BEYOND: f64 = 1.15;

impl Stability {
    /// What was measured of the time steps.
    fn map(&self) -> Option<&TimeStepMap> {
        self.time_steps.as_ref()?.1.so_far.as_ref()
    }

    /// Which time steps GFMD survives.
    fn time_steps(&mut self, ui: &mut Ui, state: &ViewState) {
        ui.horizontal_wrapped(|ui| {
            let job = self.time_steps.as_ref().map(|(_, job)| job);
            if let Some(job) = job.filter(|job| job.is_running()) {
                progress(ui, job).on_hover_text(STAYS);
            } else {
                let what = "let a tiny perturbation go at states along the approach";
                self.measure = ui.button("Measure").on_hover_text(what).clicked();
            }
        });
        let Some(map) = self.map() else {
            let words = "Which time steps does GFMD survive on the way down? Measure, and compare \
                with the bound.";
            ui.label(RichText::new(words).weak());
            return;
        };
        let panel = time_step_panel(map, state);
        diagram::legend(ui, &panel);
        let unit = state.model.unit(Dimension::Length);
        let hover = |x, step| Some(format!("u₀ {}\ntime step {step:.3}", unit.say(x, 3, "ρ")));
        let height = ui.available_height().max(80.0);
        let drawn = diagram::show(ui, &panel, "time steps", height, hover);
        let unstable = map.stable.iter().filter(|stable| !**stable).count();
        let sentence = format!(
            "Time steps of GFMD against u0: {} cells measured, {unstable} of them unstable",
            map.stable.len()
        );
        described(&drawn.response, &sentence);
    }
}

/// Measured crosses and dots over u0, with the bound that predicts them.
fn time_step_panel(map: &TimeStepMap, state: &ViewState) -> Panel {
    let (rho, unit) = (state.rho(), state.model.unit(Dimension::Length));
    let (left, right) = (state.axes().0[0], state.axes().1[0]);
    let columns = || map.displacements.iter().map(|u0| u0 / rho).enumerate();
    let cells = |stable: bool| -> Vec<[f64; 2]> {
        let rows = || map.time_steps.iter().enumerate();
        let all = columns().flat_map(|(i, x)| rows().map(move |(j, step)| ([i, j], [x, *step])));
        let of = all.filter(|([column, row], _)| map.at(*column, *row) == Some(stable));
        of.map(|(_, at)| at).collect()
    };
    let bound = columns()
        .zip(&map.bounds)
        .map(|((_, x), bound)| [x, *bound]);
    let paper = GfmdBudget::default().time_step;
    let (first, last) = (map.time_steps[0], map.time_steps[map.time_steps.len() - 1]);
    Panel {
        x: Axis::of(&unit, "u_0/rho", "u_0").from_to(left, right),
        y: Axis::logarithmic("time step").from_to(first / BEYOND, BEYOND * last),
        series: vec![
            Series::symbols("stable", Symbol::Dot, Colour::Green, cells(true)),
            Series::symbols("unstable", Symbol::Cross, Colour::Red, cells(false)),
            Series::line("bound", Role::Theory, Colour::Ink, bound.collect()),
            Series::line(
                "the paper's",
                Role::Printed,
                Colour::Grey,
                vec![[left, paper], [right, paper]],
            ),
        ],
        ..Panel::default()
    }
}
