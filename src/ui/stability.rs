//! How stable the surface is: its smallest eigenvalue along the path, and where the next jump is
//! expected.

use super::action::{Action, StabilityOf, ViewOptions};
use super::diagram::{self, grid, line, small};
use super::theme::{self, Palette};
use super::time_steps;
use super::view_state::ViewState;
use crate::follow::record::Direction;
use crate::plot::curve::{eigenvalue_at, eigenvalue_scale};
use crate::plot::loop_panel::branches;
use crate::plot::panel::Panel;
use crate::plot::style::Ground;
use crate::plot::ticks::label;
use crate::study::forecast::{Forecast, forecast};
use egui::{RichText, Role, Ui, WidgetInfo};
use egui_plot::{
    FilledArea, GridInput, GridMark, HLine, HoverPosition, LineStyle, MarkerShape, PlotBounds,
    PlotPoint, PlotUi, Points, Text,
};

/// Lower end of the axis (E*/L): a strip of the unstable side is always in sight.
const LOWEST: f64 = -0.4;

/// The tab.
pub fn show(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let before = state.view;
    let mut view: ViewOptions = before;
    ui.horizontal_wrapped(|ui| {
        ui.radio_value(&mut view.stability, StabilityOf::States, "states");
        ui.radio_value(&mut view.stability, StabilityOf::TimeSteps, "time steps");
        ui.checkbox(&mut view.soft_mode, "soft mode on map")
            .on_hover_text("contours of the mode that gives way first");
    });
    match before.stability {
        StabilityOf::States => eigenvalue(ui, state),
        StabilityOf::TimeSteps => time_steps::show(ui, state, actions),
    }
    if view != before {
        actions.push(Action::SetView(view));
    }
}

fn eigenvalue(ui: &mut Ui, state: &ViewState) {
    let ground = theme::ground(ui);
    let ahead = forecast(&state.run.record, &state.model);
    let words = foreseen(state, ahead.as_ref());
    ui.label(RichText::new(&words).strong());
    let (left, right) = (state.axes().0[0], state.axes().1[0]);
    let (low, high) = (eigenvalue_scale(LOWEST), eigenvalue_scale(highest(state)));
    let response = small(ui, "eigenvalue", "u₀ / ρ", "eigenvalue, E*/L")
        .x_grid_spacer(|input| grid(input, 7.0))
        .y_grid_spacer(decades)
        .y_axis_formatter(|mark, _| decade(eigenvalue_at(mark.value)))
        .label_formatter(|at| {
            let p = match at {
                HoverPosition::NearDataPoint { position, .. }
                | HoverPosition::Elsewhere { position } => *position,
            };
            Some(format!(
                "u₀ {:.3} ρ\neigenvalue {:.4} E*/L",
                p.x,
                eigenvalue_at(p.y)
            ))
        })
        .show(ui, |plot| {
            plot.set_plot_bounds(PlotBounds::from_min_max([left, low], [right, high]));
            draw(plot, state, ahead.as_ref(), ground);
        })
        .response;
    response.widget_info(|| {
        WidgetInfo::labeled(
            Role::Image,
            true,
            format!(
                "Smallest eigenvalue against u0: {}; {words}",
                present(state)
            ),
        )
    });
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
    let palette = &theme::palette(ground);
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
    if let Some(ahead) = ahead {
        bracket(plot, state, ahead, palette);
    }
    let panel = Panel {
        series: branches(&state.run.stiffness).into(),
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
            "now {:.4} ± {:.4} E*/L",
            now.stiffness_min, now.stiffness_error
        ),
        Some(now) => format!("now {:.4} E*/L", now.stiffness_min),
    }
}

/// The forecast in one line.
fn foreseen(state: &ViewState, ahead: Option<&Forecast>) -> String {
    let rho = state.rho();
    let way = match state.run.direction {
        Direction::Approach => "down",
        Direction::Retraction => "up",
    };
    match ahead {
        None => format!("no jump foreseen going {way}"),
        Some(f) if f.nearest == f.farthest => {
            format!("next jump at {:.4} going {way} (exact)", f.nearest / rho)
        }
        Some(f) => {
            let (a, b) = (
                f.nearest.min(f.farthest) / rho,
                f.nearest.max(f.farthest) / rho,
            );
            let digits = if b - a < 0.02 { 4 } else { 2 };
            format!("next jump between {a:.digits$} and {b:.digits$} going {way}")
        }
    }
}
