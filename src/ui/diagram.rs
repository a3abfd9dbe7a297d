//! A diagram as a plot of the window: the same value that `storage` draws to file, in the same
//! colours, strokes and symbols.

use super::theme::{self, append, set};
use super::words::explain;
use crate::plot::panel::{
    Along, Axis, Colour, Dash, Fill, Label, Look, Panel, Role, Series, Symbol, entries,
};
use crate::plot::scale::{Scale, label, scales, ticks};
use crate::plot::style::{Ground, MARKS, marked, pointing, stroke};
use crate::plot::typeset::plain;
use egui::emath::Rangef;
use egui::text::LayoutJob;
use egui::{Align, Align2, AsIdSalt, Color32, FontId, Rect, RichText, Ui, Vec2, vec2};
use egui_plot::{
    Arrows, AxisHints, FilledArea, GridMark, HoverPosition, Line, LineStyle, MarkerShape, Plot,
    PlotBounds, PlotPoint, PlotPoints, PlotResponse, PlotUi, Points, Text,
};

/// Radius of the ring around the present point.
const RING: f32 = 7.5;
/// Below this height the names of the axes give way.
const NAMED: f32 = 130.0;

/// Room below and on the left of a plot without names.
const BARE: [f32; 2] = [14.0, 30.0];
/// Room of short numbers along x and y.
const NUMBERS: [f32; 2] = [14.0, 26.0];
/// Height of an axis' name with the gap at it, as the plot draws it, over that of its text.
const NAME: f32 = 1.25;

/// A plot whose axes no gesture moves, with so much room at least below and on the left.
fn fixed<'a>(id: impl AsIdSalt, [below, left]: [f32; 2]) -> Plot<'a> {
    // Numbers down to a narrow window; they are short here.
    let x_axis = AxisHints::new_x()
        .label_spacing(Rangef::new(32.0, 40.0))
        .min_thickness(below);
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
        .y_axis_min_width(left)
}

/// Where the pointer is.
fn pointed(at: &HoverPosition<'_>) -> [f64; 2] {
    let (HoverPosition::NearDataPoint { position, .. } | HoverPosition::Elsewhere { position }) =
        at;
    [position.x, position.y]
}

/// A line of this colour and width.
fn line<'a>(name: &str, points: &[[f64; 2]], colour: Color32, width: f32) -> Line<'a> {
    let line =
        Line::new(name, PlotPoints::from(points.to_vec())).stroke(egui::Stroke::new(width, colour));
    // Bands for dense data fill the corners of stairs.
    line.allow_band(false).allow_hover(false)
}

/// The numbers of an axis, as the plot takes them: places, words, and the power of ten they are to
/// be multiplied by.
struct Numbers {
    list: Vec<(f64, String)>,
    factor: i32,
    span: f64,
}

impl Numbers {
    /// At most so many of them, evenly left out.
    fn new(scale: Scale, most: f32) -> Self {
        let (list, factor) = ticks(&scale);
        let span = scale.high - scale.low;
        let list: Vec<(f64, String)> = list
            .into_iter()
            .filter_map(|tick| Some((scale.low + tick.at * span, plain(&tick.label?))))
            .collect();
        let every = (list.len() as f32 / most.max(1.0)).ceil() as usize;
        let list = list.into_iter().step_by(every.max(1)).collect();
        Self { list, factor, span }
    }

    fn grid(&self) -> Vec<GridMark> {
        self.list
            .iter()
            .map(|(value, _)| GridMark {
                value: *value,
                step_size: self.span,
            })
            .collect()
    }

    fn word(&self, mark: GridMark) -> String {
        self.list
            .iter()
            .find(|(at, _)| (at - mark.value).abs() < 1e-6 * self.span)
            .map_or(String::new(), |(_, word)| word.clone())
    }

    fn named(&self, axis: &Axis) -> String {
        if self.factor == 0 {
            axis.label.clone()
        } else {
            format!("{} (×10^{{{}}})", axis.label, self.factor)
        }
    }
}

/// Room of a number along each axis, in screen points.
const ACROSS: f32 = 36.0;
const UP: f32 = 20.0;

/// Shows a diagram of this height; `hover` says in words where the pointer is (x, y).
pub fn show(
    ui: &mut Ui,
    panel: &Panel,
    id: impl AsIdSalt,
    height: f32,
    hover: impl Fn(f64, f64) -> Option<String>,
) -> PlotResponse<()> {
    let text = ui.visuals().text_color();
    let ground = theme::ground(ui);
    let [x, y] = scales(panel);
    let (across, up) = (
        Numbers::new(x, ui.available_width() / ACROSS),
        Numbers::new(y, height / UP),
    );
    let (across_grid, up_grid) = (across.grid(), up.grid());
    let name = |numbers: &Numbers, axis: &Axis| set(&numbers.named(axis), theme::TICK, text);
    let names = (height >= NAMED).then(|| [name(&across, &panel.x), name(&up, &panel.y)]);
    // The plot itself learns of a name's room only in the frame after, and draws it over numbers first.
    let room = |name: LayoutJob| NAME * ui.painter().layout_job(name).size().y;
    let least = names
        .clone()
        .map_or(BARE, |[x, y]| [NUMBERS[0] + room(x), NUMBERS[1] + room(y)]);
    let mut plot = fixed(id, least)
        .height(height)
        .grid_color(text.gamma_multiply(0.3));
    if let Some([x, y]) = names {
        plot = plot.x_axis_label(x).y_axis_label(y);
    }
    plot.x_grid_spacer(move |_| across_grid.clone())
        .y_grid_spacer(move |_| up_grid.clone())
        .x_axis_formatter(move |mark, _| across.word(mark))
        .y_axis_formatter(move |mark, _| up.word(mark))
        .label_formatter(move |at| {
            let [across, up] = pointed(at);
            hover(x.spread.value(across), y.spread.value(up))
        })
        .show(ui, |plot| {
            plot.set_plot_bounds(PlotBounds::from_min_max([x.low, y.low], [x.high, y.high]));
            draw(plot, panel, ground);
        })
}

/// Of the `marks` of a diagram that is drawn, each with its place on the plot, the one nearest to the
/// pointer, if that is `within` so many screen points.
pub fn nearest<M>(
    drawn: &PlotResponse<()>,
    within: f32,
    marks: impl Iterator<Item = (M, [f64; 2])>,
) -> Option<M> {
    let pointer = drawn.response.hover_pos()?;
    let far = |[x, y]: [f64; 2]| {
        let place = drawn.transform.position_from_point(&PlotPoint::new(x, y));
        place.distance(pointer)
    };
    marks
        .map(|(mark, at)| (mark, far(at)))
        .filter(|(_, far)| *far <= within)
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(mark, _)| mark)
}

/// A convex quadrangle, its corners in order, between two curves over x: x, below and above.
fn over_x(corners: [[f64; 2]; 4]) -> [Vec<f64>; 3] {
    let mut x = corners.map(|corner| corner[0]);
    x.sort_by(f64::total_cmp);
    let sides = || corners.iter().zip(corners.iter().cycle().skip(1));
    let heights = |x: f64| {
        sides().filter_map(move |(a, b)| {
            let share = if a[0] == b[0] {
                0.0
            } else {
                (x - a[0]) / (b[0] - a[0])
            };
            let within = (x - a[0]) * (x - b[0]) <= 0.0;
            within.then_some(a[1] + share * (b[1] - a[1]))
        })
    };
    let extreme =
        |of: fn(f64, f64) -> f64, from: f64| x.map(|x| heights(x).fold(from, of)).to_vec();
    let (below, above) = (
        extreme(f64::min, f64::INFINITY),
        extreme(f64::max, f64::NEG_INFINITY),
    );
    [x.to_vec(), below, above]
}

/// Draws what a diagram shows into a plot, whose coordinates are values as they are shown.
fn draw(plot: &mut PlotUi<'_>, panel: &Panel, ground: Ground) {
    let at = |p: [f64; 2]| [panel.x.spread.shown(p[0]), panel.y.spread.shown(p[1])];
    for area in &panel.areas {
        let colour = colour(area.colour, ground);
        for piece in area
            .spans
            .split(|span| !span.iter().all(|v| v.is_finite()))
            .filter(|piece| piece.len() > 1)
        {
            let edge = |k: usize| -> Vec<[f64; 2]> {
                piece.iter().map(|span| at(area.edge(span, k))).collect()
            };
            let (low, high) = (edge(1), edge(2));
            let of = |edge: &[[f64; 2]], k: usize| edge.iter().map(|p| p[k]).collect::<Vec<_>>();
            let fill = colour.gamma_multiply(ground.opacity() as f32);
            // The toolkit fills between two curves over x alone; other areas span by span. (Its
            // polygons have soft edges, which stand out far at sharp corners.)
            if area.along == Along::X {
                plot.add(
                    FilledArea::new(&area.name, &of(&low, 0), &of(&low, 1), &of(&high, 1))
                        .fill_color(fill)
                        .allow_hover(false),
                );
            } else {
                for (low, high) in low.windows(2).zip(high.windows(2)) {
                    let [x, bottom, top] = over_x([low[0], high[0], high[1], low[1]]);
                    plot.add(
                        FilledArea::new(&area.name, &x, &bottom, &top)
                            .fill_color(fill)
                            .allow_hover(false),
                    );
                }
            }
            for edge in [low, high] {
                plot.line(line(&area.name, &edge, colour, 0.8));
            }
        }
    }
    for role in Role::ORDER {
        for series in panel
            .series
            .iter()
            .filter(|s| s.role == role && s.symbol.is_none())
        {
            let placed: Vec<[f64; 2]> = series.points.iter().copied().map(at).collect();
            draw_line(plot, series, &placed, ground);
        }
    }
    for series in &panel.series {
        let Some(symbol) = series.symbol else {
            continue;
        };
        let placed: Vec<[f64; 2]> = series
            .points
            .iter()
            .copied()
            .map(at)
            .filter(|p| p.iter().all(|v| v.is_finite()))
            .collect();
        plot.points(
            symbols(&series.name, symbol, placed, series.fill).color(colour(series.colour, ground)),
        );
    }
    for arrow in &panel.arrows {
        let (tail, tip) = (
            PlotPoints::from(vec![at(arrow.tail)]),
            PlotPoints::from(vec![at(arrow.head)]),
        );
        plot.arrows(
            Arrows::new("jump", tail, tip)
                .color(colour(arrow.colour, ground))
                .tip_length(8.0)
                .allow_hover(false),
        );
    }
    let rings = panel
        .series
        .iter()
        .filter(|series| series.symbol == Some(Symbol::Ring));
    let mut taken: Vec<Rect> = rings
        .flat_map(|series| &series.points)
        .map(|p| {
            let [x, y] = at(*p);
            let centre = plot.screen_from_plot(PlotPoint::new(x, y));
            Rect::from_center_size(centre, Vec2::splat(2.0 * RING))
        })
        .collect();
    for label in &panel.labels {
        let [x, y] = at(label.at);
        if x.is_finite() && y.is_finite() {
            draw_label(plot, label, PlotPoint::new(x, y), &mut taken, ground);
        }
    }
}

/// Draws a word at a place, on its own side or on another one, so that it is clear of what is `taken`
/// (the present point, and other words) and stays within the frame, into which it is moved if it has
/// to; one that has no clear place is left out.
fn draw_label(
    plot: &mut PlotUi<'_>,
    label: &Label,
    at: PlotPoint,
    taken: &mut Vec<Rect>,
    ground: Ground,
) {
    let (words, colour) = (
        format!(" {} ", plain(&label.text)),
        colour(label.colour, ground),
    );
    let size = plot.ctx().fonts_mut(|fonts| {
        let font = FontId::proportional(theme::LEAST);
        fonts.layout_no_wrap(words.clone(), font, colour).size()
    });
    let (frame, place) = (
        plot.transform().frame().x_range(),
        plot.screen_from_plot(at),
    );
    // An anchor is the side of the word at the place: the other one than that on which the word
    // stands; and places count upwards, letters downwards.
    let along = |side: i8| match side {
        1 => Align::Min,
        0 => Align::Center,
        _ => Align::Max,
    };
    let [x, y] = label.side;
    let anchors = [[x, y], [-x, -y], [x, -y], [-x, y]].map(|[x, y]| Align2([along(x), along(-y)]));
    let moved = |anchor: &Align2| {
        let area = anchor.anchor_size(place, size);
        (frame.min - area.left()).max(0.0) + (frame.max - area.right()).min(0.0)
    };
    let area = |anchor: &Align2| anchor.anchor_size(place + vec2(moved(anchor), 0.0), size);
    let clear = |anchor: &&Align2| !taken.iter().any(|taken| taken.intersects(area(anchor)));
    let mut free = anchors.iter().filter(clear);
    let inside = free.clone().find(|anchor| moved(anchor) == 0.0);
    let Some(anchor) = inside.or(free.next()).copied() else {
        return;
    };
    taken.push(area(&anchor));
    let at = plot.plot_from_screen(place + vec2(moved(&anchor), 0.0));
    let text = Text::new("label", at, RichText::new(words).small()).color(colour);
    plot.text(text.anchor(anchor).allow_hover(false));
}

/// Draws a line through places of the plot, broken where one is not finite.
fn draw_line(plot: &mut PlotUi<'_>, series: &Series, placed: &[[f64; 2]], ground: Ground) {
    let stroke = stroke(series.role, series.colour, ground);
    let colour = theme::rgb(stroke.colour);
    let style = stroke
        .dash
        .map_or(LineStyle::Solid, |[on, _]| LineStyle::Dashed {
            length: on as f32,
        });
    let every = plot.plot_bounds().width() / MARKS;
    for piece in placed
        .split(|p| !p.iter().all(|v| v.is_finite()))
        .filter(|piece| piece.len() > 1)
    {
        plot.line(line(&plain(&series.name), piece, colour, stroke.width as f32).style(style));
        if let Some(direction) = series.direction {
            let marks = symbols(
                &series.name,
                pointing(direction),
                marked(piece, every).collect(),
                Fill::Filled,
            );
            plot.points(marks.color(colour));
        }
    }
}

fn symbols<'a>(name: &str, symbol: Symbol, at: Vec<[f64; 2]>, fill: Fill) -> Points<'a> {
    let (shape, radius) = match symbol {
        Symbol::Circle => (MarkerShape::Circle, 4.0),
        Symbol::Square => (MarkerShape::Square, 4.0),
        Symbol::Diamond => (MarkerShape::Diamond, 5.0),
        Symbol::Triangle => (MarkerShape::Up, 4.5),
        Symbol::Down => (MarkerShape::Down, 4.5),
        Symbol::Left => (MarkerShape::Left, 4.5),
        Symbol::Right => (MarkerShape::Right, 4.5),
        Symbol::Cross => (MarkerShape::Cross, 4.0),
        Symbol::Plus => (MarkerShape::Plus, 5.0),
        Symbol::Dot => (MarkerShape::Circle, 2.5),
        Symbol::Ring => (MarkerShape::Circle, RING),
        Symbol::Frame => (MarkerShape::Square, 7.5),
    };
    let filled =
        fill == Fill::Filled || matches!(symbol, Symbol::Dot | Symbol::Cross | Symbol::Plus);
    Points::new(plain(name), at)
        .shape(shape)
        .filled(filled)
        .radius(radius)
        .allow_hover(false)
}

/// The legend: every name once.
pub fn legend(ui: &mut Ui, panel: &Panel) {
    let ground = theme::ground(ui);
    let entries: Vec<(&str, Color32, String)> = entries(panel)
        .into_iter()
        .map(|(name, look)| {
            let (face, rgb) = match look {
                Look::Symbol(symbol, colour, fill) => (face(symbol, fill), colour.on(ground)),
                Look::Area(colour) => ("■", colour.on(ground)),
                Look::Arrow(colour) => ("↕", colour.on(ground)),
                Look::Line(role, colour, direction) => {
                    let plain = match role {
                        Role::Simulation => "▬",
                        Role::Kept(dash) => self::dash(dash),
                        Role::Printed | Role::Unstable => "┅",
                        Role::Theory | Role::Forecast | Role::Guide => "—",
                    };
                    let face = direction
                        .map_or(plain, |direction| face(pointing(direction), Fill::Filled));
                    (face, stroke(role, colour, ground).colour)
                }
            };
            (face, theme::rgb(rgb), name)
        })
        .collect();
    ui.scope(|ui| {
        // Rows as high as the letters.
        ui.spacing_mut().interact_size.y = 0.0;
        ui.spacing_mut().item_spacing = vec2(4.0, 2.0);
        rows(ui, &entries);
    });
}

/// Symbols, colours and names, in as many rows as they need.
fn rows(ui: &mut Ui, entries: &[(&str, Color32, String)]) {
    let text = ui.visuals().text_color();
    ui.horizontal_wrapped(|ui| {
        for (face, colour, name) in entries {
            // One label, so that no line is broken between a symbol and its name.
            let mut words = set(face, theme::LEAST, *colour);
            append(&mut words, &format!(" {name}"), theme::LEAST, text);
            explain(ui.add(egui::Label::new(words).extend()), name);
            ui.add_space(6.0);
        }
    });
}

/// A letter that looks like the line of a kept loop.
pub fn dash(dash: Dash) -> &'static str {
    match dash {
        Dash::Solid => "▬",
        Dash::Long => "┅",
        Dash::Dotted => "┈",
    }
}

/// A letter that looks like a symbol.
fn face(symbol: Symbol, fill: Fill) -> &'static str {
    match (symbol, fill) {
        (Symbol::Circle, Fill::Hollow) => "○",
        (Symbol::Circle, Fill::Filled) => "●",
        (Symbol::Square, Fill::Hollow) => "□",
        (Symbol::Square, Fill::Filled) => "■",
        (Symbol::Diamond, Fill::Hollow) => "◇",
        (Symbol::Diamond, Fill::Filled) => "◆",
        (Symbol::Triangle, Fill::Hollow) => "△",
        (Symbol::Triangle, Fill::Filled) => "▲",
        (Symbol::Down, Fill::Hollow) => "▽",
        (Symbol::Down, Fill::Filled) => "▼",
        (Symbol::Left, _) => "◀",
        (Symbol::Right, _) => "▶",
        (Symbol::Cross, _) => "✖",
        (Symbol::Plus, _) => "✚",
        (Symbol::Dot, _) => "•",
        (Symbol::Ring, _) => "◯",
        (Symbol::Frame, _) => "▢",
    }
}

fn colour(colour: Colour, ground: Ground) -> Color32 {
    theme::rgb(colour.on(ground))
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui_kittest::Harness;
    use proptest::prelude::*;

    #[test]
    fn the_names_of_axes_have_their_room_in_the_frame_in_which_they_come() {
        let panel = Panel {
            x: Axis::linear("u_0").from_to(0.0, 4.0),
            y: Axis::linear("sigma").from_to(-0.4, 1.0),
            ..Panel::default()
        };
        let shown = |ui: &mut Ui, (height, room): &mut (f32, [f32; 2])| {
            let drawn = show(ui, &panel, "plot", *height, |_, _| None);
            let frame = drawn.transform.frame();
            *room = [frame.left(), *height - frame.bottom()];
        };
        let mut window = Harness::new_ui_state(shown, (0.9 * NAMED, [0.0; 2]));
        window.run_steps(3);
        let rooms = [NAMED, 0.9 * NAMED].map(|height| {
            window.state_mut().0 = height;
            [0; 2].map(|_| {
                window.run_steps(1);
                window.state().1
            })
        });
        let [[came, named], [_, bare]] = rooms;
        for i in 0..2 {
            let all = named[i] - bare[i];
            assert!(all > 10.0 && named[i] - came[i] < 0.25 * all, "{rooms:?}");
        }
    }

    fn area(corners: &[[f64; 2]]) -> f64 {
        let sides = corners.iter().zip(corners.iter().cycle().skip(1));
        0.5 * sides
            .map(|(a, b)| a[0] * b[1] - b[0] * a[1])
            .sum::<f64>()
            .abs()
    }

    proptest! {
        /// Trapezia between two spans, one of which may be a point.
        #[test]
        fn between_two_curves_over_x_lies_the_area_of_the_quadrangle(
            low in prop::array::uniform2(-2.0..2.0_f64), width in prop::array::uniform2(0.0..3.0_f64),
            tip in any::<bool>(),
        ) {
            let width = if tip { [width[0], 0.0] } else { width };
            let high = [low[0] + width[0], low[1] + width[1]];
            let corners = [[low[0], 0.0], [high[0], 0.0], [high[1], 0.5], [low[1], 0.5]];
            let [x, below, above] = over_x(corners);
            let heights: Vec<f64> = below.iter().zip(&above).map(|(a, b)| b - a).collect();
            let found: f64 = (1..4)
                .map(|i| 0.5 * (x[i] - x[i - 1]) * (heights[i] + heights[i - 1]))
                .sum();
            prop_assert!((found - area(&corners)).abs() < 1e-12, "{found} {}", area(&corners));
        }
    }
}
