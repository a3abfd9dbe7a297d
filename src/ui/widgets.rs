//! What panels are made of: numbers as people type them and the fields they are typed into, buttons
//! and pictures with a name, jobs under way.

use super::theme::{self, Palette};
use crate::physics::parameter::{Dimension, Parameter, Value};
use crate::scene::{Model, Scene};
use crate::worker::job::Job;
use egui::{
    Align, Align2, DragValue, Id, Layout, Painter, ProgressBar, Rect, Response, Role, Sense,
    Stroke, StrokeKind, Ui, Vec2, WidgetInfo, WidgetText, pos2,
};
use std::ops::RangeInclusive;

/// Largest seed that a number typed into a field still means exactly.
pub const SEED_MAX: u64 = 1 << 53;

/// The finite number that a text means: with a point or a comma before its decimals, blanks between
/// its digits, and either minus.
///
/// One comma alone is a decimal comma; with more, or beside a point, nobody can tell, and it is no
/// number.
pub fn parse(text: &str) -> Option<f64> {
    let plain: String = text
        .chars()
        .filter(|c| !c.is_whitespace())
        .map(|c| if c == '−' { '-' } else { c })
        .collect();
    let plain = if plain.matches(',').count() == 1 && !plain.contains('.') {
        plain.replace(',', ".")
    } else {
        plain
    };
    plain.parse().ok().filter(|number: &f64| number.is_finite())
}

/// A field for a number, typed or dragged, with a point or a comma before its decimals.
pub fn field<N: egui::emath::Numeric>(value: &mut N) -> DragValue<'_> {
    DragValue::new(value)
        .custom_parser(parse)
        .update_while_editing(false)
}

/// A card of one choice among several of a `group`: a sketch over its name.
pub fn card(
    ui: &mut Ui,
    (group, name): (&str, &str),
    chosen: bool,
    size: Vec2,
    sketch: impl FnOnce(&Painter, Rect, &Palette),
) -> Response {
    let (_, rect) = ui.allocate_space(size);
    let response = ui.interact(rect, Id::unique((group, name)), Sense::click());
    response.widget_info(|| {
        WidgetInfo::selected(Role::RadioButton, true, chosen, format!("{group} {name}"))
    });
    let palette = theme::palette(ui);
    let visuals = ui.style().interact_selectable(&response, chosen);
    let painter = ui.painter().with_clip_rect(rect.intersect(ui.clip_rect()));
    let (fill, edge) = if chosen {
        let fill = ui.visuals().selection.bg_fill.gamma_multiply(0.55);
        (fill, palette.approach)
    } else {
        (ui.visuals().faint_bg_color, visuals.bg_stroke.color)
    };
    let edge = Stroke::new(1.0, edge);
    painter.rect(rect.shrink(0.5), 5.0, fill, edge, StrokeKind::Inside);
    sketch(&painter, rect, &palette);
    painter.text(
        pos2(rect.center().x, rect.bottom() - 2.0),
        Align2::CENTER_BOTTOM,
        name,
        theme::small(),
        ui.visuals().strong_text_color(),
    );
    response
}

/// A value with a name, typed or dragged; what is typed is taken exactly.
pub fn number(
    ui: &mut Ui,
    parameter: &Parameter,
    value: f64,
    range: RangeInclusive<f64>,
    unit: &str,
) -> Option<f64> {
    let mut edited = value;
    let mut changed = false;
    let speed = (value.abs() * 0.005).max(1e-4);
    labelled(ui, parameter.title(), |ui| {
        let drag = field(&mut edited).range(range).speed(speed).max_decimals(6);
        let drag = drag
            .clamp_existing_to_range(false)
            .suffix(if unit.is_empty() {
                String::new()
            } else {
                format!(" {unit}")
            });
        let response = ui.add(drag);
        changed = response.changed();
        response
    });
    (changed && edited != value).then_some(edited)
}

/// The same of a number with E* = 1, which is shown as the scene's file gives it.
pub fn given(
    ui: &mut Ui,
    scene: &Scene,
    parameter: &Parameter,
    value: f64,
    range: RangeInclusive<f64>,
) -> Option<f64> {
    let of = parameter.unit;
    let word = scene.units.map_or_else(String::new, |units| {
        let word = units.word(of).replace("^2", "²");
        word.replace("um", "µm").replace("uJ", "µJ")
    });
    let shown = scene.number_given(of, value);
    number(ui, parameter, shown, range, &word).map(|new| scene.number_taken(of, new))
}

/// What only a law or a ground has, lengths as those of the gap; `None` while nothing is edited. A value that
/// is refused beside the others is said to be by the scene.
pub fn own(
    ui: &mut Ui,
    parameters: &[Parameter],
    values: &[Value],
    model: &Model,
) -> Option<Vec<Value>> {
    let length = model.unit(Dimension::Length);
    let mut edited = values.to_vec();
    for (parameter, value) in parameters.iter().zip(&mut edited) {
        let (low, high) = (*parameter.range.start(), *parameter.range.end());
        let (unit, word) = if parameter.unit == Dimension::Length {
            (model.law.range / length.scale, length.name("ρ"))
        } else {
            (1.0, "")
        };
        let most = (high as u64).min(SEED_MAX);
        match value {
            Value::Number(x) => {
                *x = number(ui, parameter, *x / unit, low / unit..=high / unit, word)
                    .map_or(*x, |new| new * unit);
            }
            Value::Whole(n) => {
                *n = whole(ui, &parameter.title(), *n, low as u64..=most).unwrap_or(*n);
            }
            Value::Counts(both) => {
                for (count, axis) in both.iter_mut().zip(["x", "y"]) {
                    let name = format!("{} along {axis}", parameter.label);
                    *count = whole(ui, &name, *count as u64, low as u64..=most)
                        .map_or(*count, |new| new as usize);
                }
            }
            Value::Flag(flag) => {
                ui.checkbox(flag, parameter.label);
            }
            Value::Choice { chosen, words } => {
                labelled(ui, parameter.label, |ui| {
                    let combo = egui::ComboBox::from_id_salt(parameter.key)
                        .width(84.0)
                        .selected_text(words[*chosen].replace('_', " "));
                    let combo = combo.show_ui(ui, |ui| {
                        for (i, word) in words.iter().enumerate() {
                            ui.selectable_value(chosen, i, word.replace('_', " "));
                        }
                    });
                    combo.response.on_hover_text(parameter.allowed())
                });
            }
        }
    }
    (edited != values).then_some(edited)
}

/// The same for a whole number.
pub fn whole(ui: &mut Ui, name: &str, value: u64, range: RangeInclusive<u64>) -> Option<u64> {
    let mut edited = value;
    labelled(ui, name, |ui| {
        ui.add(field(&mut edited).range(range).speed(0.05))
    });
    (edited != value).then_some(edited)
}

/// A name on the left, and on the right what it names.
pub fn labelled(ui: &mut Ui, name: impl Into<WidgetText>, add: impl FnOnce(&mut Ui) -> Response) {
    ui.horizontal(|ui| {
        let label = ui.label(name);
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            add(ui).labelled_by(label.id)
        });
    });
}

/// Gives a button a name that says more than its face.
pub fn named(button: Response, name: &str) -> Response {
    button.widget_info(|| WidgetInfo::labeled(Role::Button, button.enabled(), name));
    button
}

/// Says in a sentence what a picture shows.
pub fn described(picture: &Response, sentence: &str) {
    picture.widget_info(|| WidgetInfo::labeled(Role::Image, true, sentence));
}

/// How far a job is, beside a button that stops it, which is returned.
pub fn progress<T>(ui: &mut Ui, job: &Job<T>) -> Response {
    let button = ui.button("Cancel");
    if button.clicked() {
        job.stop();
    }
    let bar = ProgressBar::new(job.fraction as f32);
    ui.add(bar.desired_width(60.0).desired_height(14.0));
    button
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_decimal_comma_is_a_decimal_point() {
        assert_eq!(parse("0,15"), Some(0.15));
        assert_eq!(parse(" −1,5e−3 "), Some(-1.5e-3));
        assert_eq!(parse("1 000,5"), Some(1000.5));
        for unclear in [
            "1,000,000",
            "1,000.5",
            "",
            ",",
            "nan",
            "inf",
            "1e999",
            "three",
        ] {
            assert_eq!(parse(unclear), None, "{unclear}");
        }
    }

    proptest! {
        #[test]
        fn a_number_is_read_as_it_was_written_with_either_sign_of_decimals(
            x in any::<f64>().prop_filter("finite", |x| x.is_finite())
        ) {
            for text in [format!("{x}"), format!("{x:e}")] {
                prop_assert_eq!(parse(&text), Some(x));
                prop_assert_eq!(parse(&text.replace('.', ",")), Some(x));
            }
        }
    }
}
