//! A diagram of the paper as a plot: the same value that `storage` draws to file.

use super::loop_plot::{fixed, line};
use super::typeset::set;
use crate::paper::extent::{Scale, scales};
use crate::paper::figure::{Colour, Content, Figure, Panel, Role, Series, Symbol};
use crate::paper::ticks::ticks;
use crate::paper::typeset::plain;
use crate::storage::picture::{common_scale, gap_image};
use egui::{Color32, ColorImage, Id, Rect, RichText, TextureHandle, TextureOptions, Ui, WidgetInfo, pos2, vec2};
use egui_plot::{Arrows, FilledArea, GridMark, LineStyle, MarkerShape, PlotBounds, PlotPoint, PlotPoints, PlotUi, Points, Text};
use std::collections::HashMap;

/// Least width of two diagrams side by side.
const TWO: f32 = 640.0;

/// Every diagram of a figure, with its legend beneath it.
pub fn figure(ui: &mut Ui, figure: &Figure) {
    let several = figure.panels.len() > 1;
    let columns = if several && ui.available_width() > TWO { 2 } else { 1 };
    for (row, panels) in figure.panels.chunks(columns).enumerate() {
        ui.columns(columns, |uis| {
            for (column, panel) in panels.iter().enumerate() {
                let index = row * columns + column;
                let letter = char::from(b'a' + (index % 26) as u8);
                let named = panel.title.is_empty() || panel.title.starts_with('(');
                let heading = match (several, named) {
                    (true, true) if panel.title.is_empty() => format!("({letter})"),
                    (true, false) => format!("({letter}) {}", panel.title),
                    _ => panel.title.clone(),
                };
                let name = format!("Fig. {} diagram {letter}", figure.number);
                self::panel(&mut uis[column], panel, &heading, &name, (figure.number, index));
            }
        });
    }
}

fn panel(ui: &mut Ui, panel: &Panel, heading: &str, name: &str, key: (usize, usize)) {
    let (text, dark) = (ui.visuals().text_color(), ui.visuals().dark_mode);
    if !heading.is_empty() {
        ui.label(set(heading, 12.5, text));
    }
    let [x, y] = scales(panel);
    let width = ui.available_width();
    let marks = |scale: Scale| {
        let (list, factor) = ticks(&scale);
        let span = scale.high - scale.low;
        let at = move |share: f64| scale.low + share * span;
        let list: Vec<(f64, String)> = list.into_iter().filter_map(|t| Some((at(t.at), plain(&t.label?)))).collect();
        (list, factor, span)
    };
    let ((x_ticks, x_factor, x_span), (y_ticks, y_factor, y_span)) = (marks(x), marks(y));
    let grid =
        |ticks: &[(f64, String)], span: f64| ticks.iter().map(|t| GridMark { value: t.0, step_size: span }).collect::<Vec<_>>();
    let (x_grid, y_grid) = (grid(&x_ticks, x_span), grid(&y_ticks, y_span));
    let word = |ticks: &[(f64, String)], span: f64, mark: GridMark| {
        ticks.iter().find(|t| (t.0 - mark.value).abs() < 1e-6 * span).map_or(String::new(), |t| t.1.clone())
    };
    let label = |text: &str, factor: i32| if factor == 0 { text.to_owned() } else { format!("{text} (×10^{{{factor}}})") };
    let value = |scale: Scale, shown: f64| if scale.logarithmic { 10f64.powf(shown) } else { shown };
    let shown =
        fixed(("paper", key))
            .height((0.66 * width).min(0.5 * ui.ctx().content_rect().height()).max(150.0))
            .grid_color(text.gamma_multiply(0.2))
            .x_axis_label(set(&label(&panel.x.label, x_factor), 12.0, text))
            .y_axis_label(set(&label(&panel.y.label, y_factor), 12.0, text))
            .x_grid_spacer(move |_| x_grid.clone())
            .y_grid_spacer(move |_| y_grid.clone())
            .x_axis_formatter(move |mark, _| word(&x_ticks, x_span, mark))
            .y_axis_formatter(move |mark, _| word(&y_ticks, y_span, mark))
            .label_formatter(move |at| {
                let (egui_plot::HoverPosition::NearDataPoint { position: p, .. }
                | egui_plot::HoverPosition::Elsewhere { position: p }) = at;
                let number = crate::paper::typeset::number;
                Some(format!("x {}\ny {}", number(value(x, p.x)), number(value(y, p.y))))
            })
            .show(ui, |plot| {
                plot.set_plot_bounds(PlotBounds::from_min_max([x.low, y.low], [x.high, y.high]));
                draw(plot, panel, [x, y], dark);
            });
    let curves = panel.series.len();
    let sentence = format!("{name}: {} against {}, {curves} curves", panel.y.label, panel.x.label);
    shown.response.widget_info(|| WidgetInfo::labeled(egui::Role::Image, true, &sentence));
    maps(ui, panel, *shown.transform.frame(), key);
    legend(ui, panel, dark);
    for (i, inset) in panel.insets.iter().enumerate() {
        if let Content::Diagram(inner) = &inset.content {
            let heading = format!("inset {}", inner.title);
            self::panel(ui, inner, heading.trim(), &format!("{name} inset {}", i + 1), (key.0, 100 * (key.1 + 1) + i));
        }
    }
}

fn draw(plot: &mut PlotUi<'_>, panel: &Panel, scales: [Scale; 2], dark: bool) {
    let at = |p: [f64; 2]| [scales[0].shown(p[0]), scales[1].shown(p[1])];
    for area in &panel.areas {
        for piece in area.spans.split(|span| !span.iter().all(|v| v.is_finite())).filter(|piece| piece.len() > 1) {
            let of = |k: usize, scale: Scale| piece.iter().map(|span| scale.shown(span[k])).collect::<Vec<_>>();
            let (x, low, high) = (of(0, scales[0]), of(1, scales[1]), of(2, scales[1]));
            let fill = shade(area.colour, dark).gamma_multiply(0.35);
            plot.add(FilledArea::new(&area.name, &x, &low, &high).fill_color(fill).allow_hover(false));
        }
    }
    for role in [Role::Guide, Role::Simulation, Role::Theory, Role::Printed] {
        for series in panel.series.iter().filter(|s| s.role == role && s.symbol.is_none()) {
            let (width, style) = match role {
                Role::Guide => (0.9, LineStyle::Solid),
                Role::Simulation => (3.2, LineStyle::Solid),
                Role::Theory => (1.4, LineStyle::Solid),
                Role::Printed => (1.6, LineStyle::dashed_loose()),
            };
            let colour = ink(series, dark);
            let placed: Vec<[f64; 2]> = series.points.iter().copied().map(at).collect();
            for piece in placed.split(|p| !p.iter().all(|v| v.is_finite())).filter(|piece| piece.len() > 1) {
                plot.line(line(&plain(&series.name), piece, colour, width).style(style).allow_hover(false));
            }
        }
    }
    for series in &panel.series {
        if let Some(symbol) = series.symbol {
            let (shape, filled, radius) = shape(symbol);
            let placed: Vec<[f64; 2]> = series.points.iter().copied().map(at).filter(|p| p.iter().all(|v| v.is_finite())).collect();
            let marks = Points::new(plain(&series.name), placed).shape(shape).filled(filled).radius(radius);
            plot.points(marks.color(ink(series, dark)));
        }
    }
    for arrow in &panel.arrows {
        let (tail, tip) = (PlotPoints::from(vec![at(arrow.tail)]), PlotPoints::from(vec![at(arrow.head)]));
        plot.arrows(Arrows::new("jump", tail, tip).color(shade(arrow.colour, dark)).tip_length(8.0).allow_hover(false));
    }
    for label in &panel.labels {
        let [x, y] = at(label.at);
        if x.is_finite() && y.is_finite() {
            let words = Text::new("label", PlotPoint::new(x, y), RichText::new(plain(&label.text)).small());
            plot.text(words.color(shade(Colour::Ink, dark)).allow_hover(false));
        }
    }
}

/// Textures of gap maps, by figure, diagram and inset.
type Pictures = HashMap<(usize, usize, usize), TextureHandle>;

/// The maps inside the frame of a plot.
fn maps(ui: &Ui, panel: &Panel, frame: Rect, key: (usize, usize)) {
    let gaps = panel.insets.iter().filter_map(|inset| match &inset.content {
        Content::Map { gap, .. } => Some(gap),
        Content::Diagram(_) => None,
    });
    // In the same colours, so that they can be compared.
    let colours = common_scale(gaps);
    for (i, inset) in panel.insets.iter().enumerate() {
        let Content::Map { letter, gap } = &inset.content else { continue };
        let store = Id::unique("paper maps");
        let known = ui.ctx().data_mut(|data| data.get_temp_mut_or_default::<Pictures>(store).get(&(key.0, key.1, i)).cloned());
        let texture = known.unwrap_or_else(|| {
            let image = gap_image(gap, colours);
            let size = [image.width() as usize, image.height() as usize];
            let picture = ColorImage::from_rgb(size, image.as_raw());
            let texture = ui.ctx().load_texture(format!("map {} {} {i}", key.0, key.1), picture, TextureOptions::LINEAR);
            ui.ctx().data_mut(|data| data.get_temp_mut_or_default::<Pictures>(store).insert((key.0, key.1, i), texture.clone()));
            texture
        });
        let [x, y, w, h] = inset.place.map(|v| v as f32);
        let room = vec2(w * frame.width(), h * frame.height());
        let corner = pos2(frame.left() + x * frame.width(), frame.bottom() - y * frame.height() - room.y);
        let size = texture.size_vec2();
        let scale = (room.x / size.x).min(room.y / size.y);
        let rect = Rect::from_min_size(corner, if gap.nrows() == 1 { room } else { size * scale });
        let painter = ui.painter().with_clip_rect(frame);
        painter.image(texture.id(), rect, Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0)), Color32::WHITE);
        let visuals = ui.visuals();
        painter.rect_stroke(rect, 0.0, egui::Stroke::new(1.0, visuals.text_color()), egui::StrokeKind::Outside);
        if letter.is_empty() {
            continue;
        }
        let galley = painter.layout_no_wrap(letter.clone(), egui::FontId::proportional(11.0), visuals.text_color());
        painter.rect_filled(Rect::from_min_size(rect.min, galley.size() + vec2(4.0, 0.0)), 0.0, visuals.extreme_bg_color);
        painter.galley(rect.min + vec2(2.0, 0.0), galley, visuals.text_color());
    }
}

fn legend(ui: &mut Ui, panel: &Panel, dark: bool) {
    let text = ui.visuals().text_color();
    let face = |series: &Series| match (series.symbol, series.role) {
        (Some(Symbol::Circle), _) => "○",
        (Some(Symbol::Square), _) => "□",
        (Some(Symbol::Diamond), _) => "◇",
        (Some(Symbol::Triangle), _) => "△",
        (Some(Symbol::Cross), _) => "✕",
        (Some(Symbol::Dot), _) => "•",
        (None, Role::Simulation) => "▬",
        (None, Role::Printed) => "┅",
        (None, Role::Theory | Role::Guide) => "—",
    };
    let series = panel.series.iter().map(|s| (face(s), ink(s, dark), s.name.as_str()));
    let areas = panel.areas.iter().map(|a| ("■", shade(a.colour, dark).gamma_multiply(0.6), a.name.as_str()));
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = vec2(4.0, 1.0);
        let mut told: Vec<&str> = Vec::new();
        for (face, colour, name) in series.chain(areas) {
            if !name.is_empty() && !told.contains(&name) {
                told.push(name);
                ui.label(RichText::new(face).small().strong().color(colour));
                ui.label(set(name, 11.0, text));
                ui.add_space(6.0);
            }
        }
    });
}

fn ink(series: &Series, dark: bool) -> Color32 {
    shade(if series.role == Role::Guide { Colour::Grey } else { series.colour }, dark)
}

fn shape(symbol: Symbol) -> (MarkerShape, bool, f32) {
    match symbol {
        Symbol::Circle => (MarkerShape::Circle, false, 3.5),
        Symbol::Square => (MarkerShape::Square, false, 3.5),
        Symbol::Diamond => (MarkerShape::Diamond, false, 4.5),
        Symbol::Triangle => (MarkerShape::Up, false, 4.0),
        Symbol::Cross => (MarkerShape::Cross, true, 3.5),
        Symbol::Dot => (MarkerShape::Circle, true, 2.0),
    }
}

/// The shade of a colour on light or dark ground.
fn shade(colour: Colour, dark: bool) -> Color32 {
    let pick = |light: u32, bright: u32| {
        let c = if dark { bright } else { light };
        Color32::from_rgb((c >> 16) as u8, (c >> 8) as u8, c as u8)
    };
    match colour {
        Colour::Ink => pick(0x22_2222, 0xe6_e6e6),
        Colour::Blue => pick(0x1f_5fb4, 0x6a_b0ff),
        Colour::Red => pick(0xc8_2a2a, 0xff_8278),
        Colour::Green => pick(0x14_844c, 0x52_d094),
        Colour::Orange => pick(0xd0_6a00, 0xff_a64d),
        Colour::Purple => pick(0x84_469c, 0xd0_98ea),
        Colour::Teal => pick(0x00_8690, 0x4c_d0d8),
        Colour::Grey => pick(0x8c_8c8c, 0x96_9ca6),
        Colour::Gold => pick(0xd0_a020, 0xe8_c860),
    }
}
