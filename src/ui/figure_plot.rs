//! The paper's figures in the window: their diagrams, with gap maps and smaller diagrams inside.

use super::diagram;
use super::theme::set;
use crate::paper::Figure;
use crate::plot::panel::{Content, Panel, letter};
use crate::plot::typeset::number;
use crate::storage::picture::{common_scale, gap_image};
use egui::{
    Color32, ColorImage, Id, Rect, TextureHandle, TextureOptions, Ui, WidgetInfo, pos2, vec2,
};
use std::collections::HashMap;

/// Least width of two diagrams side by side.
const TWO: f32 = 640.0;

/// Every diagram of a figure, with its legend beneath it.
pub fn figure(ui: &mut Ui, figure: &Figure) {
    let several = figure.panels.len() > 1;
    let columns = if several && ui.available_width() > TWO {
        2
    } else {
        1
    };
    for (row, panels) in figure.panels.chunks(columns).enumerate() {
        ui.columns(columns, |uis| {
            for (column, panel) in panels.iter().enumerate() {
                let index = row * columns + column;
                let heading = panel.heading(index, figure.panels.len());
                let name = format!("Fig. {} diagram {}", figure.number, letter(index));
                self::panel(
                    &mut uis[column],
                    panel,
                    &heading,
                    &name,
                    (figure.number, index),
                );
            }
        });
    }
}

fn panel(ui: &mut Ui, panel: &Panel, heading: &str, name: &str, key: (usize, usize)) {
    if !heading.is_empty() {
        ui.label(set(heading, 12.5, ui.visuals().text_color()));
    }
    let height = (0.66 * ui.available_width())
        .min(0.5 * ui.ctx().content_rect().height())
        .max(150.0);
    let shown = diagram::show(ui, panel, ("paper", key), height, |x, y| {
        Some(format!("x {}\ny {}", number(x), number(y)))
    });
    let curves = panel.series.len();
    let sentence = format!(
        "{name}: {} against {}, {curves} curves",
        panel.y.label, panel.x.label
    );
    shown
        .response
        .widget_info(|| WidgetInfo::labeled(egui::Role::Image, true, &sentence));
    maps(ui, panel, *shown.transform.frame(), key);
    diagram::legend(ui, panel);
    for (i, inset) in panel.insets.iter().enumerate() {
        if let Content::Diagram(inner) = &inset.content {
            let heading = format!("inset {}", inner.title);
            self::panel(
                ui,
                inner,
                heading.trim(),
                &format!("{name} inset {}", i + 1),
                (key.0, 100 * (key.1 + 1) + i),
            );
        }
    }
}

/// Textures of gap maps, by figure, diagram and inset.
type Pictures = HashMap<(usize, usize, usize), TextureHandle>;

/// The maps inside the frame of a plot.
fn maps(ui: &Ui, panel: &Panel, frame: Rect, key: (usize, usize)) {
    let gaps = panel
        .insets
        .iter()
        .filter_map(|inset| match &inset.content {
            Content::Map { gap, .. } => Some(gap),
            Content::Diagram(_) => None,
        });
    // In the same colours, so that they can be compared.
    let colours = common_scale(gaps);
    for (i, inset) in panel.insets.iter().enumerate() {
        let Content::Map { letter, gap } = &inset.content else {
            continue;
        };
        let store = Id::unique("paper maps");
        let known = ui.ctx().data_mut(|data| {
            data.get_temp_mut_or_default::<Pictures>(store)
                .get(&(key.0, key.1, i))
                .cloned()
        });
        let texture = known.unwrap_or_else(|| {
            let image = gap_image(gap, colours);
            let size = [image.width() as usize, image.height() as usize];
            let picture = ColorImage::from_rgb(size, image.as_raw());
            let texture = ui.ctx().load_texture(
                format!("map {} {} {i}", key.0, key.1),
                picture,
                TextureOptions::LINEAR,
            );
            ui.ctx().data_mut(|data| {
                data.get_temp_mut_or_default::<Pictures>(store)
                    .insert((key.0, key.1, i), texture.clone())
            });
            texture
        });
        let [x, y, w, h] = inset.place.map(|v| v as f32);
        let room = vec2(w * frame.width(), h * frame.height());
        let corner = pos2(
            frame.left() + x * frame.width(),
            frame.bottom() - y * frame.height() - room.y,
        );
        let size = texture.size_vec2();
        let scale = (room.x / size.x).min(room.y / size.y);
        let rect = Rect::from_min_size(corner, if gap.nrows() == 1 { room } else { size * scale });
        let painter = ui.painter().with_clip_rect(frame);
        painter.image(
            texture.id(),
            rect,
            Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0)),
            Color32::WHITE,
        );
        let visuals = ui.visuals();
        painter.rect_stroke(
            rect,
            0.0,
            egui::Stroke::new(1.0, visuals.text_color()),
            egui::StrokeKind::Outside,
        );
        if letter.is_empty() {
            continue;
        }
        let galley = painter.layout_no_wrap(
            letter.clone(),
            egui::FontId::proportional(11.0),
            visuals.text_color(),
        );
        painter.rect_filled(
            Rect::from_min_size(rect.min, galley.size() + vec2(4.0, 0.0)),
            0.0,
            visuals.extreme_bg_color,
        );
        painter.galley(rect.min + vec2(2.0, 0.0), galley, visuals.text_color());
    }
}
