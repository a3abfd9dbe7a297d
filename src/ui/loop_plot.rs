//! Stress against mean displacement: approach, retraction, the flat state, jumps, the dissipated area, and where we are now.

use super::action::Action;
use super::curves::Curve;
use super::inspect;
use super::theme::{self, Palette};
use super::view_state::ViewState;
use crate::experiment::plan::promise;
use crate::experiment::record::{Branch, JumpRecord};
use crate::paper::ticks::{self, label};
use egui::emath::Rangef;
use egui::{AsIdSalt, Color32, Response, RichText, Role, Stroke, Ui, WidgetInfo, vec2};
use egui_plot::{
    Arrows, AxisHints, FilledArea, GridInput, GridMark, HoverPosition, Line, LineStyle, MarkerShape, Plot, PlotBounds, PlotPoint,
    PlotPoints, PlotUi, Points, Text,
};

/// A click this near to a state means it, in screen points.
const CLICK: f64 = 14.0;

/// Draws heading, legend and plot, of this height in all. `axes_seen` remembers which axes the plot has been given.
pub fn show(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>, height: f32, axes_seen: &mut u64) {
    let palette = theme::palette(ui.visuals().dark_mode);
    heading(ui, state, actions, &palette);
    let theory = state.overlay();
    legend(ui, state, !theory.is_empty(), &palette);
    let (words, doubt) = dissipated(state);
    ui.horizontal(|ui| {
        if let Some(doubt) = doubt {
            ui.label(RichText::new("⚠").color(palette.warn).strong()).on_hover_text(&doubt);
            ui.add(egui::Label::new(RichText::new(format!("{words}: {doubt}")).color(palette.warn).strong()).truncate());
        } else {
            ui.add(egui::Label::new(RichText::new(words).strong()).truncate());
        }
    });
    let mut new_axes = None;
    if *axes_seen != state.axes_version {
        *axes_seen = state.axes_version;
        new_axes = Some(state.axes());
    }
    let grid = ui.visuals().text_color().gamma_multiply(0.45);
    let height = (height - 88.0).max(120.0);
    // As many numbers as stand clear of each other.
    let count = f64::from((height - 30.0) / 28.0).min(8.0);
    let response = fixed("loop")
        // Its own, so that the axes outlast the panel around it, which is another one in a window of another width.
        .id(egui::Id::unique("stress against u0"))
        .height(height)
        .x_axis_label("u₀ / ρ")
        .y_axis_label("stress / σₘₐₓ")
        .grid_color(grid)
        .x_grid_spacer(|input| ticks(input, 7.0))
        .y_grid_spacer(move |input| ticks(input, count))
        .label_formatter(|at| {
            let p = match at {
                HoverPosition::NearDataPoint { position, .. } | HoverPosition::Elsewhere { position } => *position,
            };
            Some(format!("u₀ {:.3} ρ\nstress {:.3} σₘₐₓ", p.x, p.y))
        })
        .show(ui, |plot| {
            if let Some((low, high)) = new_axes {
                plot.set_plot_bounds(PlotBounds::from_min_max(low, high));
            }
            draw(plot, state, &theory, &palette);
        });
    let (response, transform) = (response.response, response.transform);
    if let Some(pointer) = response.interact_pointer_pos().filter(|_| response.clicked()) {
        let at = transform.value_from_position(pointer);
        let scale = transform.dpos_dvalue();
        let reach = [CLICK / scale[0].abs(), CLICK / scale[1].abs()];
        actions.push(Action::SelectState { at: [at.x, at.y], reach });
    }
    inspect::show(ui, state, response.rect, actions);
    let sentence = sentence(state);
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &sentence));
}

/// A plot whose axes no gesture moves.
pub fn fixed<'a>(id: impl AsIdSalt) -> Plot<'a> {
    // Numbers down to a narrow window; they are short here.
    let x_axis = AxisHints::new_x().label_spacing(Rangef::new(32.0, 40.0));
    Plot::new(id)
        .custom_x_axes(vec![x_axis])
        // The plot's own words round a tick of 0.5 to 0.
        .x_axis_formatter(|mark, _| label(mark.value, mark.step_size))
        .y_axis_formatter(|mark, _| label(mark.value, mark.step_size))
        .allow_drag(false)
        .allow_scroll(false)
        .allow_zoom(false)
        .allow_axis_zoom_drag(false)
        .allow_boxed_zoom(false)
        .allow_double_click_reset(false)
        .auto_bounds(false)
        .show_crosshair(false)
        .y_axis_min_width(30.0)
}

/// Such a plot in the rest of the space; its axes lose their names where there is little of it.
pub fn small<'a>(ui: &Ui, id: &'static str, x: &'static str, y: &'static str) -> Plot<'a> {
    let height = ui.available_height().max(80.0);
    let plot = fixed(id).height(height);
    if height < 130.0 { plot } else { plot.x_axis_label(x).y_axis_label(y) }
}

fn heading(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>, palette: &Palette) {
    ui.horizontal(|ui| {
        ui.label(RichText::new("Stress against u₀").heading().strong());
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if state.fit.is_some() && ui.button("Scene axes").clicked() {
                actions.push(Action::Fit(false));
            }
            let leaves = state.data_leave_view();
            let text = if leaves { RichText::new("Fit").color(palette.warn).strong() } else { RichText::new("Fit") };
            let hover = if leaves { "Data lie outside the axes" } else { "Fit the axes to the data" };
            if ui.button(text).on_hover_text(hover).clicked() {
                actions.push(Action::Fit(true));
            }
        });
    });
}

fn legend(ui: &mut Ui, state: &ViewState, theory: bool, palette: &Palette) {
    let more = usize::from(state.kept.is_some()) + usize::from(!state.ghosts.is_empty()) + usize::from(theory);
    let wide = ui.available_width() > 380.0 + 60.0 * more as f32;
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = vec2(4.0, 1.0);
        entry(ui, palette.approach, "◀", "approach");
        entry(ui, palette.retraction, "▶", "retraction");
        entry(ui, palette.jump, "↕", "jump");
        if !state.flat_state.is_empty() {
            entry(ui, palette.flat, "┄", if wide { "flat (dashed unstable)" } else { "flat" });
        }
        if state.live.as_ref().is_some_and(|live| !live.pieces.is_empty()) {
            entry(ui, palette.live, "—", "live");
        }
        if theory {
            entry(ui, palette.now, "—", "theory");
        }
        if let Some(kept) = &state.kept {
            entry(ui, palette.ghost, "▬", "kept").on_hover_text(&kept.title);
        }
        if !state.ghosts.is_empty() {
            entry(ui, palette.ghost, "—", "earlier");
        }
    });
}

fn entry(ui: &mut Ui, colour: Color32, mark: &str, word: &str) -> Response {
    ui.label(RichText::new(mark).color(colour).small().strong());
    let response = ui.label(RichText::new(word).small());
    ui.add_space(6.0);
    response
}

/// The dissipated energy in words, of a walked loop, or else of the live one; and what speaks against it.
fn dissipated(state: &ViewState) -> (String, Option<String>) {
    if let Some(closed) = &state.closed_loop {
        let ledger = &closed.summary.ledger;
        let contested = contested(&state.record.jumps);
        let words = match (ledger.dissipated_energy(), &ledger.open) {
            (Some(loss), _) if contested.is_some() => format!("∮ dissipated {loss:.4}{} γ", or_else(state, loss)),
            (Some(loss), _) => {
                format!("∮ dissipated {loss:.4} γ, {}", promise(ledger.stated_error(state.predicted_error())))
            }
            (None, Some(_)) => "loop not closed".to_owned(),
            (None, None) => "dissipated energy not available".to_owned(),
        };
        let open = ledger.open.as_ref().map(|open| format!("{}; {}", open.reason, open.remedy));
        return (words, open.or_else(|| ledger.warning()).or(contested));
    }
    let Some(Ok(live)) = state.live.as_ref().map(|live| &live.state.found) else {
        return ("Play loop to see what one cycle dissipates.".to_owned(), None);
    };
    let loss = live.dissipated_energy;
    if let Some(contested) = contested(&live.jumps) {
        return (format!("∮ live loop: {loss:.4}{} γ", or_else(state, loss)), Some(contested));
    }
    (format!("∮ live loop: {loss:.4} γ lost in {} jumps, {}", live.jumps.len(), promise(Some(live.predicted_error))), None)
}

/// Where a surface may land that has several places to land.
fn contested(jumps: &[JumpRecord]) -> Option<String> {
    jumps.iter().find_map(JumpRecord::contested_words)
}

/// What a loop that loses `loss` would lose by its other landing, as the live loop knows it: " or 0.1292".
fn or_else(state: &ViewState, loss: f64) -> String {
    let Some(Ok(live)) = state.live.as_ref().map(|live| &live.state.found) else { return String::new() };
    let mut known: Vec<f64> = live.rivals.iter().filter_map(|rival| rival.dissipated_energy).collect();
    if known.is_empty() {
        return String::new();
    }
    // The live loop may take the other of two; of both values the farther one is not this loop's.
    known.push(live.dissipated_energy);
    let other = known.into_iter().max_by(|a, b| (a - loss).abs().total_cmp(&(b - loss).abs()));
    other.map_or_else(String::new, |other| format!(" or {other:.4}"))
}

fn draw(plot: &mut PlotUi<'_>, state: &ViewState, lines: &[TheoryLine], palette: &Palette) {
    if let Some(closed) =
        state.closed_loop.as_ref().filter(|closed| closed.summary.ledger.open.is_none() && closed.shade.x.len() > 1)
    {
        let shade = &closed.shade;
        plot.add(FilledArea::new("dissipated", &shade.x, &shade.low, &shade.high).fill_color(palette.shade).allow_hover(false));
    }
    for (stable, points) in &state.flat_state {
        let style = if *stable { LineStyle::Solid } else { LineStyle::dashed_dense() };
        plot.line(line("flat state", points, palette.flat, 1.0).style(style).allow_hover(false));
    }
    for points in state.kept.iter().flat_map(|kept| &kept.lines) {
        plot.line(line("kept", points, palette.ghost, 2.5).allow_hover(false));
    }
    for ghost in &state.ghosts {
        for piece in &ghost.pieces {
            plot.line(line("earlier", &piece.points, palette.ghost, 1.0).allow_hover(false));
        }
    }
    live(plot, state, palette);
    theory(plot, lines, palette);
    curve(plot, &state.curve, palette);
    pattern_names(plot, &state.curve, palette);
    jumps(plot, state, palette);
    if let Some(selection) = &state.selection {
        let at = vec![[selection.state.mean_displacement / state.rho(), selection.state.stress_over_max]];
        let mark = Points::new("selected", at).shape(MarkerShape::Square).radius(7.0).filled(false);
        plot.points(mark.color(palette.now).allow_hover(false));
    }
    if let Some(now) = &state.state {
        let at = vec![[now.mean_displacement / state.rho(), now.stress_over_max]];
        plot.points(
            Points::new("now", at.clone())
                .radius(7.0)
                .shape(MarkerShape::Circle)
                .color(palette.now)
                .filled(false)
                .allow_hover(false),
        );
        plot.points(Points::new("now", at).radius(3.5).shape(MarkerShape::Circle).color(palette.now).allow_hover(false));
    }
}

/// The loop of the atlas, thin, with a glow where a walked curve lies upon it, its jumps dotted; and where the surface will stand at the target, before the walk is there.
fn live(plot: &mut PlotUi<'_>, state: &ViewState, palette: &Palette) {
    let Some(live) = &state.live else { return };
    let glow = state.curve.points().nth(2).is_some();
    for (_, points) in &live.pieces {
        if glow {
            plot.line(line("live", points, palette.live.gamma_multiply(0.3), 7.0).allow_hover(false));
        }
        plot.line(line("live", points, palette.live, 1.2).allow_hover(false));
    }
    for (u0, [from, to]) in &live.jumps {
        let style = LineStyle::dotted_dense();
        plot.line(line("live", &[[*u0, *from], [*u0, *to]], palette.live, 1.2).style(style).allow_hover(false));
    }
    if let Some((pattern, sample)) = state.foreseen() {
        let at = [sample.mean_displacement / state.rho(), sample.stress / state.model.law.traction_max()];
        let mark = Points::new("foreseen", vec![at]).shape(MarkerShape::Diamond).radius(7.0).filled(false);
        plot.points(mark.color(palette.live).allow_hover(false));
        let text = RichText::new(format!(" {pattern} ahead ")).small();
        let word = Text::new("foreseen", PlotPoint::new(at[0], at[1]), text);
        plot.text(word.color(palette.live).anchor(egui::Align2::LEFT_BOTTOM).allow_hover(false));
    }
}

/// Name and points of a theory line.
type TheoryLine = (&'static str, Vec<[f64; 2]>);

/// What theory says of this scene, thin, with its names on the curves.
fn theory(plot: &mut PlotUi<'_>, lines: &[TheoryLine], palette: &Palette) {
    let bounds = plot.plot_bounds();
    // Names stand on different parts of curves that lie close together.
    let shares = [("dimple", 0.12), ("ridge", 0.75), ("bulge", 0.4), ("JKR", 0.85), ("JKR, periodic", 0.99)];
    for (name, points) in lines {
        plot.line(line("theory", points, palette.now.gamma_multiply(0.75), 1.2).allow_hover(false));
        let inside = |p: &&[f64; 2]| (0..2).all(|k| p[k] > bounds.min()[k] && p[k] < bounds.max()[k]);
        let seen: Vec<&[f64; 2]> = points.iter().filter(inside).collect();
        let share = shares.iter().find(|(known, _)| known == name).map(|(_, share)| share * seen.len() as f64);
        if let Some(at) = share.and_then(|index| seen.get(index as usize)) {
            let word = Text::new("theory", PlotPoint::new(at[0], at[1]), RichText::new(format!(" {name} ")).small());
            let side = if *name == "bulge" { egui::Align2::RIGHT_TOP } else { egui::Align2::LEFT_BOTTOM };
            plot.text(word.color(palette.now).anchor(side).allow_hover(false));
        }
    }
}

/// A line of this colour and width.
pub fn line<'a>(name: &str, points: &[[f64; 2]], colour: Color32, width: f32) -> Line<'a> {
    Line::new(name, PlotPoints::from(points.to_vec())).stroke(Stroke::new(width, colour))
}

/// Grid lines at 1, 2 or 5 and a power of ten; the plot's own raster of tens leaves short axes without a number.
pub fn ticks(input: GridInput, count: f64) -> Vec<GridMark> {
    let (values, step_size) = ticks::within(input.bounds.0, input.bounds.1, count);
    values.into_iter().map(|value| GridMark { value, step_size }).collect()
}

/// The recorded path: a line, and triangles that point the way it was gone, one every few per cent of the axis.
pub fn curve(plot: &mut PlotUi<'_>, curve: &Curve, palette: &Palette) {
    let every = plot.plot_bounds().width() / 22.0;
    for piece in &curve.pieces {
        let (colour, shape, name) = match piece.branch {
            Branch::Approach => (palette.approach, MarkerShape::Left, "approach"),
            Branch::Retraction => (palette.retraction, MarkerShape::Right, "retraction"),
        };
        plot.line(line(name, &piece.points, colour, 2.0));
        let mut marks = Vec::new();
        for p in &piece.points {
            // A fixed raster, so that marks do not wander while the curve grows.
            let slot = (p[0] / every).floor();
            if marks.last().is_none_or(|(s, _): &(f64, [f64; 2])| *s != slot) {
                marks.push((slot, *p));
            }
        }
        let marks: Vec<[f64; 2]> = marks.into_iter().skip(1).map(|(_, p)| p).collect();
        plot.points(Points::new(name, marks).shape(shape).color(colour).radius(4.5).allow_hover(false));
    }
}

/// The pattern of every stretch that is long enough to carry its name: above the retraction, below the approach.
fn pattern_names(plot: &mut PlotUi<'_>, curve: &Curve, palette: &Palette) {
    let bounds = plot.plot_bounds();
    let mut named: Vec<(Branch, &str, f64)> = Vec::new();
    for piece in curve.pieces.iter().rev() {
        let (Some(first), Some(last)) = (piece.points.first(), piece.points.last()) else { continue };
        let name = piece.pattern.word();
        let x = 0.5 * (first[0] + last[0]);
        let near = |(branch, word, at): &(Branch, &str, f64)| {
            *branch == piece.branch && *word == name && (at - x).abs() < 0.2 * bounds.width()
        };
        if (first[0] - last[0]).abs() < 0.09 * bounds.width() || named.iter().any(near) {
            continue;
        }
        let y = piece.points.iter().min_by(|a, b| (a[0] - x).abs().total_cmp(&(b[0] - x).abs())).map_or(first[1], |p| p[1]);
        let gap = 0.02 * bounds.height();
        let (anchor, y, colour) = match piece.branch {
            Branch::Approach => (egui::Align2::RIGHT_TOP, y - gap, palette.approach),
            Branch::Retraction => (egui::Align2::LEFT_BOTTOM, y + gap, palette.retraction),
        };
        plot.text(Text::new("pattern", PlotPoint::new(x, y), RichText::new(name)).color(colour).anchor(anchor).allow_hover(false));
        named.push((piece.branch, name, x));
    }
}

fn jumps(plot: &mut PlotUi<'_>, state: &ViewState, palette: &Palette) {
    let max = state.model.law.traction_max();
    let latest = state.record.jumps.len().saturating_sub(24);
    for jump in &state.record.jumps[latest..] {
        let x = jump.mean_displacement / state.rho();
        let (from, to) = (jump.stress_before / max, jump.stress_after / max);
        let (tail, tip) = (PlotPoints::from(vec![[x, from]]), PlotPoints::from(vec![[x, to]]));
        plot.arrows(Arrows::new("jump", tail, tip).color(palette.jump).tip_length(7.0).allow_hover(false));
    }
}

/// The plot in one sentence.
fn sentence(state: &ViewState) -> String {
    let Some(now) = &state.state else { return "Stress against u0: nothing recorded yet".to_owned() };
    let mut words = format!(
        "Stress against u0: {} at u0 {:.3} rho, stress {:.3} sigma_max, {}",
        now.pattern,
        now.mean_displacement / state.rho(),
        now.stress_over_max,
        state.record.tally()
    );
    if let Some(closed) = &state.closed_loop {
        words.push_str(&match closed.summary.ledger.dissipated_energy() {
            Some(loss) => format!(", dissipated {loss:.4} gamma"),
            None => ", loop not closed".to_owned(),
        });
    }
    words
}
