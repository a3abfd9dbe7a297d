//! How stable the surface is: its smallest eigenvalue along the path, and where the next jump is
//! expected; and which time steps GFMD survives.

use super::{STAYS, Tab, Title, Update, take_in};
use crate::follow::record::Direction;
use crate::physics::parameter::Dimension;
use crate::plot::curve::{eigenvalue_at, eigenvalue_scale};
use crate::plot::loop_panel::branches;
use crate::plot::panel::{Axis, Colour, Panel, Role, Series, Symbol};
use crate::plot::style::Ground;
use crate::plot::ticks::label;
use crate::scene::units::fixed;
use crate::solver::gfmd::GfmdBudget;
use crate::study::forecast::{Forecast, forecast};
use crate::study::time_step_map::TimeStepMap;
use crate::ui::action::{Action, ViewOptions};
use crate::ui::diagram::{self, along, line, small};
use crate::ui::machine::{self, Told};
use crate::ui::theme::{self, Palette};
use crate::ui::view_state::ViewState;
use crate::ui::widgets::{described, progress};
use crate::ui::words::explain;
use crate::worker::background;
use crate::worker::job::Job;
use crate::worker::protocol::RunId;
use egui::{RichText, Ui};
use egui_plot::{
    FilledArea, GridInput, GridMark, HLine, LineStyle, MarkerShape, PlotBounds, PlotPoint, PlotUi,
    Points, Text,
};

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
                explain(ui.radio_value(&mut self.of, of, word), word);
            }
            ui.checkbox(&mut view.soft_mode, "soft mode on map")
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
        let mut series = branches(&state.run.stiffness);
        for point in series.iter_mut().flat_map(|series| &mut series.points) {
            point[1] = eigenvalue_at(point[1]);
        }
        vec![Panel {
            x: Axis::of(&state.model.unit(Dimension::Length), "u0/rho", "u0"),
            y: Axis::linear("smallest eigenvalue (E*/L)"),
            series,
            ..Panel::default()
        }]
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
    let ground = theme::ground(ui);
    let ahead = forecast(&state.run.record, &state.model);
    let words = foreseen(state, ahead.as_ref());
    explain(ui.label(RichText::new(&words).strong()), "The next jump");
    let (left, right) = (state.axes().0[0], state.axes().1[0]);
    let (low, high) = (eigenvalue_scale(LOWEST), eigenvalue_scale(highest(state)));
    let unit = state.model.unit(Dimension::Length);
    let hover = |x, y| {
        let u0 = unit.say(x, 3, "ρ");
        format!("u₀ {u0}\neigenvalue {} E*/L", fixed(eigenvalue_at(y), 4))
    };
    let names = [&*unit.label("u₀ / ρ", "u₀"), "eigenvalue, E*/L"];
    let response = along(small(ui, "eigenvalue", names, hover), unit.scale)
        .y_grid_spacer(decades)
        .y_axis_formatter(|mark, _| decade(eigenvalue_at(mark.value)))
        .show(ui, |plot| {
            plot.set_plot_bounds(PlotBounds::from_min_max([left, low], [right, high]));
            draw(plot, state, ahead.as_ref(), ground);
        })
        .response;
    let sentence = format!(
        "Smallest eigenvalue against u0: {}; {words}",
        present(state)
    );
    described(&response, &sentence);
}

/// The upper end of the axis: the flat state pressed as hard as the drive does.
fn highest(state: &ViewState) -> f64 {
    let length = state.model.grid.length;
    let pressed = state.model.law.at(state.limits.0).stiffness.max(
        state
            .model
            .law
            .at(state.model.law.equilibrium_gap())
            .stiffness,
    );
    1.6 * (std::f64::consts::PI + length * pressed)
}

/// Marks at zero and at the powers of ten of either sign.
fn decades(input: GridInput) -> Vec<GridMark> {
    let (low, high) = input.bounds;
    [
        -100.0, -10.0, -1.0, -0.1, 0.0, 0.1, 1.0, 10.0, 100.0, 1e3, 1e4,
    ]
    .into_iter()
    .map(|eigenvalue| GridMark {
        value: eigenvalue_scale(eigenvalue),
        step_size: high - low,
    })
    .filter(|mark| (low..=high).contains(&mark.value))
    .collect()
}

/// A power of ten without the noise of its last digits.
fn decade(eigenvalue: f64) -> String {
    label(eigenvalue, eigenvalue.abs())
}

fn draw(plot: &mut PlotUi<'_>, state: &ViewState, ahead: Option<&Forecast>, ground: Ground) {
    let palette = &theme::palette_on(ground);
    let (low, high) = (plot.plot_bounds().min(), plot.plot_bounds().max());
    let (left, right) = (low[0], high[0]);
    let below = FilledArea::new("unstable", &[left, right], &[low[1]; 2], &[0.0; 2]);
    plot.add(
        below
            .fill_color(palette.warn.gamma_multiply(0.2))
            .allow_hover(false),
    );
    plot.hline(
        HLine::new("zero", 0.0)
            .color(palette.warn)
            .width(1.2)
            .allow_hover(false),
    );
    let word = Text::new(
        "unstable",
        PlotPoint::new(left + 0.01 * (right - left), 0.55 * low[1]),
        RichText::new("unstable").small(),
    );
    plot.text(
        word.color(palette.warn)
            .anchor(egui::Align2::LEFT_CENTER)
            .allow_hover(false),
    );
    // Where what is driven is not u0, words say where.
    if let Some(ahead) = ahead.filter(|_| !state.scene.control().frees_mean()) {
        bracket(plot, state, ahead, palette);
    }
    let panel = Panel {
        series: branches(&state.run.stiffness),
        ..Panel::default()
    };
    diagram::draw(plot, &panel, ground);
    let corner = PlotPoint::new(
        right - 0.01 * (right - left),
        high[1] - 0.02 * (high[1] - low[1]),
    );
    let value = Text::new("value", corner, RichText::new(present(state)).small());
    plot.text(
        value
            .color(palette.now)
            .anchor(egui::Align2::RIGHT_TOP)
            .allow_hover(false),
    );
    let Some(now) = &state.run.state else { return };
    let x = now.mean_displacement / state.rho();
    let place = |e: f64| eigenvalue_scale(e).clamp(low[1], high[1]);
    if now.stiffness_error > 0.0 {
        let (a, b) = (
            now.stiffness_min - now.stiffness_error,
            now.stiffness_min + now.stiffness_error,
        );
        plot.line(
            line("error", &[[x, place(a)], [x, place(b)]], palette.now, 1.5).allow_hover(false),
        );
    }
    let at = vec![[x, place(now.stiffness_min)]];
    let mark = |name: &str| {
        Points::new(name, at.clone())
            .shape(MarkerShape::Circle)
            .color(palette.now)
            .allow_hover(false)
    };
    plot.points(mark("now").radius(6.0).filled(false));
    plot.points(mark("now").radius(3.0));
}

/// Where the next jump is expected: a strip, or a line where it is known exactly.
fn bracket(plot: &mut PlotUi<'_>, state: &ViewState, ahead: &Forecast, palette: &Palette) {
    let bounds = plot.plot_bounds();
    let (low, high) = (bounds.min()[1], bounds.max()[1]);
    let ends = [ahead.nearest / state.rho(), ahead.farthest / state.rho()];
    let strip = FilledArea::new(
        "next jump",
        &[ends[0].min(ends[1]), ends[0].max(ends[1])],
        &[low; 2],
        &[high; 2],
    );
    plot.add(
        strip
            .fill_color(palette.jump.gamma_multiply(0.22))
            .allow_hover(false),
    );
    for x in ends {
        let style = LineStyle::dashed_dense();
        plot.line(
            line("next jump", &[[x, low], [x, high]], palette.jump, 1.2)
                .style(style)
                .allow_hover(false),
        );
    }
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
    } = machine::told(state);
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
