//! Stress against mean displacement: approach, retraction, the flat state, jumps, the dissipated
//! area, where we are now; and in a corner the card of the stored or foreseen state that is looked
//! at: its numbers, and what can be done with it.

use super::action::{Action, LessonAct, Pick, Scales};
use super::headline::{self, energy, residual};
use super::view_state::{Beside, Ghost, Origin, ViewState};
use super::widgets::{Asks, at_right, described, named};
use super::{diagram, theme};
use crate::follow::record::StateRecord;
use crate::lessons::{Hidden, Question};
use crate::physics::parameter::Dimension;
use crate::plot::loop_panel::{self, place};
use crate::plot::panel::{Axis, Colour, Label, Panel, Role, Series, Symbol};
use crate::scene::Model;
use crate::scene::parameter::{Unit, fixed};
use crate::study::forecast::{Forecast, forecast};
use crate::worker::protocol::Frame as Picture;
use egui::{
    Align2, Area, AreaState, Frame, Id, Order, PointerButton, Pos2, Rect, Response, RichText, Ui,
    UiBuilder, Vec2, pos2, vec2,
};
use egui_plot::PlotTransform;
use std::iter::once;
use std::sync::Arc;

/// Points of the wheel that make the axes shorter by a factor e.
const WHEEL: f32 = 200.0;
/// How much shorter, and how much longer, than those of the scene the axes may be.
const CLOSEST: f64 = 1e4;
const FARTHEST: f64 = 4.0;

/// A click this near to a state means it, in screen points.
const CLICK: f64 = 14.0;

/// Letters of a kept loop's name in the plot, and most loops that have theirs at their curves.
const NAME_MAX: usize = 26;
const NAMED_MAX: usize = 3;

/// Most jumps that are shown, the newest.
const JUMPS_MAX: usize = 24;

/// Height of a row of the legend, and in how many it is drawn: so many are reserved.
const LEGEND: f32 = 19.0;
const ROWS: (f32, f32) = (2.0, 3.0);
/// Width of the column from which the smaller number does.
const WIDE: f32 = 400.0;
/// Height below which there is no room for more.
const LOW: f32 = 300.0;

/// Draws headline, legend and plot in this height.
pub fn show(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>, height: f32) {
    let top = ui.cursor().top();
    headline::loss(ui, state, actions);
    let panel = panel(state);
    let wide = ui.available_width() >= WIDE;
    let rows = if wide || height < LOW { ROWS.0 } else { ROWS.1 };
    let mut inside = ui.new_child(UiBuilder::new().max_rect(ui.available_rect_before_wrap()));
    if wide {
        diagram::legend(&mut inside, &panel);
    } else {
        diagram::legend(&mut inside, &without_branches(state, &panel));
    }
    // The plot stays where it is when an entry comes, as long as the rows hold it.
    let needed = inside.min_rect().height().max(rows * LEGEND);
    ui.allocate_space(vec2(ui.available_width(), needed));
    let height = (height - (ui.cursor().top() - top)).max(120.0);
    let [length, stress] = told(state);
    let hover = |x: f64, y: f64| {
        let (u0, stress) = (length.say(x, 3, "ρ"), stress.say(y, 3, "σₘₐₓ"));
        Some(format!("u₀ {u0}\nstress {stress}"))
    };
    let shown = diagram::show(ui, &panel, "loop", height, hover);
    let (response, transform) = (shown.response, shown.transform);
    actions.extend(other_axes(ui, state, &response, &transform).map(Action::SetAxes));
    let scrubs =
        response.dragged_by(PointerButton::Primary) && response.drag_delta() != egui::Vec2::ZERO;
    if let Some(pointer) = response
        .interact_pointer_pos()
        .filter(|_| response.clicked() || scrubs)
    {
        let at = transform.value_from_position(pointer);
        let scale = transform.dpos_dvalue();
        let reach = [CLICK / scale[0].abs(), CLICK / scale[1].abs()];
        let pick = match (response.drag_started(), scrubs) {
            (true, _) => Pick::Drag,
            (false, true) => Pick::Along,
            (false, false) => Pick::Click,
        };
        let at = [at.x, at.y];
        actions.push(match state.asked() {
            Some((Question::Guess { .. }, _)) => Action::Lesson(LessonAct::Choose(at[0])),
            _ if state.view.lecture && state.run.record.jumps.is_empty() => Action::Guess(at[0]),
            _ => Action::SelectState { at, reach, pick },
        });
    }
    card(ui, state, actions, response.rect);
    let sentence = sentence(state);
    described(&response, &sentence);
}

/// What the legend names in a narrow column: with the branches beneath, which their own tab names, it
/// would leave no room for the plot.
fn without_branches(state: &ViewState, panel: &Panel) -> Panel {
    let mut named = panel.clone();
    let beneath = &state.plots.beneath;
    named
        .series
        .retain(|series| beneath.iter().all(|line| line.name != series.name));
    named
}

/// The axes after a turn of the wheel or a pinch at the pointer, or a drag with the second button.
fn other_axes(
    ui: &Ui,
    state: &ViewState,
    response: &Response,
    transform: &PlotTransform,
) -> Option<[[f64; 2]; 2]> {
    let ((low, high), whole) = (state.axes(), state.scene_axes());
    let turned = if response.contains_pointer() {
        // Nothing beneath scrolls with it.
        let wheel = ui.input_mut(|input| std::mem::take(&mut input.smooth_scroll_delta).y);
        (wheel / WHEEL).exp() * ui.input(egui::InputState::zoom_delta)
    } else {
        1.0
    };
    if turned != 1.0 {
        let at = transform.value_from_position(response.hover_pos()?);
        let about = |k: usize, at: f64| {
            let (now, scene) = (high[k] - low[k], whole.1[k] - whole.0[k]);
            let then = (now / f64::from(turned)).clamp(scene / CLOSEST, scene * FARTHEST);
            [low[k], high[k]].map(|end| at + (end - at) * then / now)
        };
        let [[left, right], [bottom, top]] = [about(0, at.x), about(1, at.y)];
        return Some([[left, bottom], [right, top]]);
    }
    let moved = response.drag_delta();
    let dragged = response.dragged_by(PointerButton::Secondary) && moved != egui::Vec2::ZERO;
    dragged.then(|| {
        let scale = transform.dpos_dvalue();
        let by = [f64::from(moved.x) / scale[0], f64::from(moved.y) / scale[1]];
        [low, high].map(|end| [end[0] - by[0], end[1] - by[1]])
    })
}

/// In what u0 and the stress are told.
fn units(model: &Model) -> [Unit; 2] {
    [Dimension::Length, Dimension::Stress].map(|of| model.unit(of))
}

/// In what the plot tells them: with absolute scales in the lengths of the scene's file, and E*.
fn told(state: &ViewState) -> [Unit; 2] {
    let (model, law) = (&state.model, &state.model.law);
    match (state.view.scales, model.units) {
        (Scales::Absolute, None) => {
            [("length", law.range), ("E*", law.traction_max())].map(|(word, scale)| Unit {
                word: Some(word.to_owned()),
                scale,
            })
        }
        _ => units(model),
    }
}

/// The axes of stress against u0 with short names.
pub fn axes(model: &Model) -> [Axis; 2] {
    let [length, stress] = units(model);
    [
        Axis::of(&length, "u₀ / ρ", "u₀"),
        Axis::of(&stress, "stress / σ_max", "stress"),
    ]
}

/// Everything that is shown, on the axes of the scene.
pub fn panel(state: &ViewState) -> Panel {
    let ([left, bottom], [right, top]) = state.axes();
    let law = &state.model.law;
    let latest = state.run.record.jumps.len().saturating_sub(JUMPS_MAX);
    let closed = state
        .run
        .closed_loop
        .as_ref()
        .filter(|closed| closed.summary.ledger.open.is_none());
    let theory = theory(state, [[left, right], [bottom, top]]);
    let [length, stress] = told(state);
    let x = Axis::of(&length, "u₀ / ρ", "u₀");
    let y = Axis::of(&stress, "stress / σ_max", "stress");
    let mut panel = Panel {
        x: x.from_to(left, right),
        y: y.from_to(bottom, top),
        areas: closed.map_or_else(Vec::new, |closed| closed.loss.clone()),
        series: loop_panel::branches(&state.run.curve),
        arrows: loop_panel::jumps(&state.run.record.jumps[latest..], law),
        labels: loop_panel::names(&state.run.curve, right - left),
        ..Panel::default()
    };
    if !state.hides(Hidden::Forecast) {
        foretold(state, &mut panel);
    }
    panel.series.extend(state.plots.preview.clone());
    panel
        .series
        .extend(theory.iter().map(|(line, _)| line.clone()));
    panel
        .labels
        .extend(theory.into_iter().filter_map(|(_, label)| label));
    panel.series.extend(earlier(state));
    if !state.hides_kept() {
        kept(state, &mut panel);
    }
    panel.series.extend(state.machine_line([left, right]));
    guesses(state, &mut panel);
    let foreseen = state.run.foresight.wanted().and_then(|wanted| {
        let (.., sample) = wanted.live.found.as_ref().ok()?.at(wanted.spot);
        Some(place(sample.mean_displacement, sample.stress, law))
    });
    let of_state = |s: &StateRecord| [s.mean_displacement / law.range, s.stress_over_max];
    let of_frame = |frame: &Arc<Picture>| place(frame.mean_displacement, frame.stress, law);
    let selected = state.run.selection.as_ref();
    let selected = foreseen.or(selected.map(|selection| of_state(&selection.state)));
    let replayed = state.run.replayed.as_ref().map(of_frame);
    // While it jumps the point goes down the drop.
    let now = state.run.state.as_ref().map(of_state);
    let now = state.jumping().map(of_frame).or(now);
    let marks = [
        Series::framed(selected, Colour::Ink),
        Series::framed(replayed, Colour::JUMP),
    ];
    let marks = marks.into_iter().chain(Series::here(now));
    panel
        .series
        .extend(marks.filter(|series| !series.points.is_empty()));
    panel
}

/// What tells of what was not walked yet.
fn foretold(state: &ViewState, panel: &mut Panel) {
    panel.series.extend(state.plots.beneath.iter().cloned());
    panel.series.extend(state.plots.flat_state.iter().cloned());
    panel.series.extend(live(state));
    next_jump(state, panel);
    ahead(state, panel);
}

/// Where somebody guesses the next jump to be.
fn guesses(state: &ViewState, panel: &mut Panel) {
    let lesson = state.lesson().and_then(|(lesson, progress)| {
        let question = progress.step(lesson)?.question.as_ref()?;
        let guess = matches!(question, Question::Guess { .. });
        progress.answer.filter(|_| guess)
    });
    let [low, high] = panel.y.range.unwrap_or_default();
    for &guess in state.plots.guesses.iter().chain(&lesson) {
        let points = vec![[guess, low], [guess, high]];
        panel
            .series
            .push(Series::line("guess", Role::Forecast, Colour::Gold, points));
    }
}

/// Pieces as one broken line.
fn joined<'a>(pieces: impl IntoIterator<Item = &'a [[f64; 2]]>) -> Vec<[f64; 2]> {
    pieces
        .into_iter()
        .flat_map(|piece| piece.iter().copied().chain(once([f64::NAN; 2])))
        .collect()
}

/// Earlier paths, thin and grey.
fn earlier(state: &ViewState) -> Vec<Series> {
    let line = |ghost: &Ghost| {
        let pieces = ghost
            .curve
            .pieces
            .iter()
            .map(|piece| piece.points.as_slice());
        Series::line("earlier", Role::Guide, Colour::Grey, joined(pieces))
    };
    state.plots.ghosts.iter().map(line).collect()
}

/// The loops that are kept, each with its name at a height of its own where it reaches highest.
fn kept(state: &ViewState, panel: &mut Panel) {
    let (beside, count) = (state.beside(), state.plots.kept.drawn().count());
    let [left, right] = panel.x.range.unwrap_or_default();
    for (k, kept) in state.plots.kept.drawn().enumerate() {
        let ((colour, dash), lines) = (kept.look(), state.lines_of(kept));
        let is_b = beside.is_some_and(|(_, b)| b.id == kept.id);
        let name = if is_b {
            format!("B: {}", kept.name)
        } else {
            kept.name.clone()
        };
        let name: String = name.chars().take(NAME_MAX).collect();
        // A share of the axis each, so that names do not lie on each other.
        let x = left + (right - left) * (k as f64 + 0.5) / count as f64;
        // Above the upper of the two curves there.
        let close = 0.02 * (right - left);
        let there = lines.iter().flatten();
        let there = there.filter(|p| (p[0] - x).abs() < close);
        let near = there.max_by(|a, b| a[1].total_cmp(&b[1]));
        panel
            .labels
            .extend(near.filter(|_| count <= NAMED_MAX).map(|at| Label {
                at: *at,
                text: name.clone(),
                colour,
                side: [0, 1],
            }));
        let points = joined(lines.iter().map(Vec::as_slice));
        panel
            .series
            .push(Series::line(&name, Role::Kept(dash), colour, points));
    }
    if let Some((
        Beside {
            shown: Ok(frame), ..
        },
        kept,
    )) = beside
    {
        let [u0, stress] = state.units_of(kept);
        let at = vec![[frame.mean_displacement / u0, frame.stress / stress]];
        let symbol = Series::symbols("", Symbol::Diamond, kept.look().0, at);
        panel.series.push(symbol.filled());
    }
}

/// The live loop, thin, with its jumps dashed.
fn live(state: &ViewState) -> Vec<Series> {
    let Some(live) = state
        .plots
        .live
        .as_ref()
        .filter(|live| !live.pieces.is_empty())
    else {
        return Vec::new();
    };
    let line = joined(live.pieces.iter().map(Vec::as_slice));
    let jumps = joined(live.jumps.iter().map(<[[f64; 2]; 2]>::as_slice));
    vec![
        Series::line("live", Role::Forecast, Colour::LIVE, line),
        Series::line("", Role::Unstable, Colour::LIVE, jumps),
    ]
}

/// Where the surface will stand at the target, before the walk is there.
fn ahead(state: &ViewState, panel: &mut Panel) {
    let Some((pattern, sample)) = state.foreseen() else {
        return;
    };
    let at = place(sample.mean_displacement, sample.stress, &state.model.law);
    panel
        .series
        .push(Series::symbols("", Symbol::Diamond, Colour::LIVE, vec![at]));
    panel.labels.push(Label {
        at,
        text: format!("{pattern} ahead"),
        colour: Colour::LIVE,
        side: [1, 1],
    });
}

/// A band for the next jump wider than this share of the axis says nothing, and hides the rest.
const WIDEST: f64 = 0.1;

/// Where the next jump is to be expected: a band, or a line where it is known exactly. Under a
/// spring it is known of the stage, and the plot is of u0.
fn next_jump(state: &ViewState, panel: &mut Panel) {
    if state.scene.control().frees_mean() {
        return;
    }
    let Some(Forecast { nearest, farthest }) = forecast(&state.run.record, &state.model) else {
        return;
    };
    let [low, high] = panel.y.range.unwrap_or_default();
    let ends = [nearest, farthest].map(|u0| u0 / state.rho());
    let [left, right] = panel.x.range.unwrap_or_default();
    if (ends[1] - ends[0]).abs() > WIDEST * (right - left) {
        return;
    }
    let edges = ends.map(|x| vec![[x, low], [x, high]]);
    if nearest != farthest {
        panel.areas.push(crate::plot::panel::Area {
            colour: Colour::JUMP,
            spans: vec![[ends[0], low, high], [ends[1], low, high]],
            ..Default::default()
        });
    }
    let edge = |points| Series::line("next jump", Role::Unstable, Colour::JUMP, points);
    panel.series.extend(edges.map(edge));
}

/// What theory says of this scene, thin, with names on the parts of the curves that are seen.
fn theory(state: &ViewState, axes: [[f64; 2]; 2]) -> Vec<(Series, Option<Label>)> {
    // Names stand on different parts of curves that lie close together.
    const SHARES: [(&str, f64); 5] = [
        ("dimple", 0.12),
        ("ridge", 0.75),
        ("bulge", 0.4),
        ("JKR", 0.85),
        ("JKR, periodic", 0.99),
    ];
    let lines = state.overlay().into_iter();
    lines
        .map(|(name, points)| {
            let inside = |p: &&[f64; 2]| (0..2).all(|k| p[k] > axes[k][0] && p[k] < axes[k][1]);
            let seen: Vec<&[f64; 2]> = points.iter().filter(inside).collect();
            let share = SHARES
                .iter()
                .find(|(known, _)| *known == name)
                .map(|(_, share)| share * seen.len() as f64);
            let label = share
                .and_then(|index| seen.get(index as usize))
                .map(|at| Label {
                    at: **at,
                    text: name.to_owned(),
                    side: if name == "bulge" { [-1, -1] } else { [1, 1] },
                    ..Label::default()
                });
            (
                Series::line("theory", Role::Theory, Colour::Ink, points),
                label,
            )
        })
        .collect()
}

/// The plot in one sentence.
fn sentence(state: &ViewState) -> String {
    let [length, stress] = units(&state.model);
    if let Some(frame) = state.jumping() {
        return format!(
            "Stress against u0: jumping at u0 {}, stress {}",
            length.say(frame.mean_displacement / state.rho(), 3, "rho"),
            stress.say(
                frame.stress / state.model.law.traction_max(),
                3,
                "sigma_max"
            )
        );
    }
    let Some(now) = &state.run.state else {
        return "Stress against u0: nothing recorded yet".to_owned();
    };
    let mut words = format!(
        "Stress against u0: {} at u0 {}, stress {}, {}",
        now.pattern,
        length.say(now.mean_displacement / state.rho(), 3, "rho"),
        stress.say(now.stress_over_max, 3, "sigma_max"),
        state.run.record.tally()
    );
    if let Some(closed) = &state.run.closed_loop {
        words.push_str(&match closed.summary.ledger.dissipated_energy() {
            Some(loss) => {
                let unit = state.model.unit(Dimension::SurfaceEnergy);
                format!(", dissipated {}", unit.say(loss, 4, "gamma"))
            }
            None => ", loop not closed".to_owned(),
        });
    }
    words
}

/// Width of the card, and about its height: low, so that above or below it the state is seen.
const WIDTH: f32 = 296.0;
const HEIGHT: f32 = 124.0;

/// The numbers of a stored state, on a card in an upper corner of `plot`.
fn card(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>, plot: Rect) {
    let Some(selection) = &state.run.selection else {
        return;
    };
    let s = &selection.state;
    let palette = theme::palette(ui);
    let id = Id::unique("inspected");
    let known = AreaState::load(ui.ctx(), id).map(|area| area.size);
    let size = known.flatten().unwrap_or(vec2(WIDTH, HEIGHT));
    let area = Area::new(id)
        .order(Order::Middle)
        .fixed_pos(corner(state, s, plot, size));
    area.constrain(false).show(ui.ctx(), |ui| {
        let fill = ui.visuals().window_fill.gamma_multiply(0.94);
        Frame::popup(ui.style())
            .fill(fill)
            .inner_margin(6.0)
            .show(ui, |ui| {
                ui.set_width(WIDTH.min(plot.width() - 12.0) - 14.0);
                ui.spacing_mut().item_spacing.y = 1.0;
                ui.horizontal(|ui| {
                    let words = format!("{} on {}", s.pattern.words(), s.direction);
                    ui.label(RichText::new(words).strong());
                    at_right(ui, |ui| {
                        named(ui.small_button("✖"), "Close the card")
                            .asks(actions, Action::ClearSelection);
                    });
                });
                let (words, colour) = match selection.of {
                    Origin::Walked(_) => ("", palette.now),
                    Origin::Left(_) => ("on a path that was left", palette.flat),
                    Origin::Foreseen => ("foreseen, solved on this mesh", palette.live),
                };
                if !words.is_empty() {
                    ui.label(RichText::new(words).small().color(colour));
                }
                ui.label(RichText::new(numbers(state, s).join("  ·  ")).small());
                if let Some(jump) = selection.jump.and_then(|i| state.run.record.jumps.get(i)) {
                    let words = format!(
                        "{} released {}",
                        jump.change(),
                        energy(state, jump.released_energy)
                    );
                    ui.label(RichText::new(words).small().color(palette.jump));
                }
                ui.horizontal_wrapped(|ui| {
                    let kept = state.looked_at().is_some();
                    let button = ui.add_enabled(kept, egui::Button::new("Go on from here"));
                    let button = button.on_hover_text(
                        "G: the surface is put back into this state; what came after it becomes \
                         a grey line",
                    );
                    let gone = "its picture is no longer kept: memory is bounded";
                    button
                        .on_disabled_hover_text(gone)
                        .asks(actions, Action::GoOn);
                    if ui.button("Walk to it").clicked() {
                        actions.push(Action::SetTarget(s.control));
                    }
                    let copy = named(ui.button("Copy"), "Copy these numbers");
                    copy.asks(actions, Action::CopyText(numbers(state, s).join("\n")));
                });
            });
    });
}

/// Where a card of this size lets the state be seen: the corner that the curve of a loop leaves
/// free, or another one.
fn corner(state: &ViewState, s: &StateRecord, plot: Rect, size: Vec2) -> Pos2 {
    let ([left, bottom], [right, top]) = state.axes();
    let share = |value: f64, low: f64, high: f64| ((value - low) / (high - low)) as f32;
    let point = pos2(
        egui::lerp(
            plot.x_range(),
            share(s.mean_displacement / state.rho(), left, right),
        ),
        egui::lerp(plot.y_range(), 1.0 - share(s.stress_over_max, bottom, top)),
    );
    let room = plot.shrink(6.0);
    let corners = [
        Align2::RIGHT_TOP,
        Align2::LEFT_TOP,
        Align2::RIGHT_BOTTOM,
        Align2::LEFT_BOTTOM,
    ];
    let mut places = corners
        .map(|corner| corner.align_size_within_rect(size, room))
        .into_iter();
    let first = places.clone().next().map_or(room.min, |place| place.min);
    let free = places.find(|place| !place.expand(6.0).contains(point));
    free.map_or(first, |place| place.min)
}

/// The numbers, one a line.
fn numbers(state: &ViewState, s: &StateRecord) -> [String; 6] {
    let [length, stress] = [Dimension::Length, Dimension::Stress].map(|of| state.model.unit(of));
    let unit = state.model.unit(Dimension::SurfaceEnergy);
    let gamma = state.model.law.surface_energy;
    let plural = if s.iterations == 1 { "" } else { "s" };
    [
        format!(
            "u₀ {}",
            length.say(s.mean_displacement / state.rho(), 5, "ρ")
        ),
        format!("stress {}", stress.say(s.stress_over_max, 5, "σₘₐₓ")),
        format!(
            "eigenvalue {} ± {:.3} E*/L",
            fixed(s.stiffness_min, 3),
            s.stiffness_error
        ),
        format!("energy {}", unit.say(s.energy / gamma, 5, "γ")),
        format!("contact {:.1} %, {}", 100.0 * s.contact_area, residual(s)),
        format!(
            "{}, {} iteration{plural}, {:.0} ms",
            s.part, s.iterations, s.milliseconds
        ),
    ]
}
