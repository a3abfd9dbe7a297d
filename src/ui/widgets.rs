//! What panels are made of: numbers as people type them and the fields they are typed into, buttons
//! and pictures with a name, jobs under way.

use super::action::Action;
use super::theme::{self, Palette};
use super::words::{explain, explain_parameter};
use crate::physics::parameter::{Dimension, Parameter, Value, number as plain};
use crate::scene::parameter::unsigned_zero;
use crate::scene::{Model, Scene};
use crate::worker::job::Job;
use egui::emath::format_with_decimals_in_range;
use egui::{
    Align, Align2, DragValue, FontId, Id, IntoAtoms, Label, Layout, Painter, ProgressBar, Rect,
    Response, Role, Sense, Stroke, StrokeKind, Tooltip, Ui, Vec2, WidgetInfo, WidgetText, pos2,
};
use std::cell::RefCell;
use std::ops::RangeInclusive;
use std::time::Duration;

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

/// Seconds for which a refusal stays at its field.
const REFUSED: f64 = 6.0;

/// A field for a number, typed or dragged. What is typed is taken exactly, or refused at the field in
/// words; a field that is left as it stood rounds nothing.
pub struct Entry<'a> {
    /// What it is called in a refusal.
    pub name: &'a str,
    /// The present value.
    pub value: f64,
    /// What is allowed.
    pub range: RangeInclusive<f64>,
    /// How much a point of a drag is.
    pub speed: f64,
    /// Most decimals that are shown; 0 for whole numbers.
    pub decimals: usize,
    /// What stands behind the number.
    pub suffix: &'a str,
}

impl Entry<'_> {
    /// Draws it; the new value, if there is one.
    pub fn show(self, ui: &mut Ui) -> (Option<f64>, Response) {
        let (shown, refused) = (RefCell::new(String::new()), RefCell::new(None));
        let mut edited = self.value;
        let format = |value: f64, decimals: RangeInclusive<usize>| {
            let text = unsigned_zero(format_with_decimals_in_range(value, decimals));
            shown.replace(text.clone());
            text
        };
        let read = |text: &str| {
            if text == *shown.borrow() {
                return None;
            }
            let whole = |x: &f64| self.decimals > 0 || x.fract() == 0.0;
            let number = parse(text).filter(|x| whole(x) && self.range.contains(x));
            if number.is_none() {
                refused.replace(Some(self.refusal(text)));
            }
            number
        };
        let drag = DragValue::new(&mut edited)
            .custom_formatter(format)
            .custom_parser(read)
            .update_while_editing(false)
            .range(self.range.clone())
            .clamp_existing_to_range(false)
            .speed(self.speed)
            .max_decimals(self.decimals)
            .suffix(self.suffix);
        let response = ui.add(drag);
        say_refusal(ui, &response, refused.take());
        let changed = response.changed() && edited != self.value;
        (changed.then_some(edited), response)
    }

    fn refusal(&self, text: &str) -> String {
        let end = |x: &f64| {
            plain(if x.abs() < 1e-3 {
                *x
            } else {
                (x * 1e6).round() / 1e6
            })
        };
        let (low, high) = (end(self.range.start()), end(self.range.end()));
        let kind = if self.decimals == 0 {
            "a whole number"
        } else {
            "a number"
        };
        let what = if parse(text).is_some() {
            ""
        } else {
            "no number: "
        };
        format!(
            "{} = {}: {what}allowed is {kind} from {low} to {high}{}",
            self.name,
            text.trim(),
            self.suffix
        )
    }
}

/// Shows why a value was refused, at its field, until it is taken or some seconds have passed.
fn say_refusal(ui: &Ui, response: &Response, refused: Option<String>) {
    let (id, now) = (response.id.with("refused"), ui.input(|input| input.time));
    if let Some(words) = refused {
        ui.data_mut(|data| data.insert_temp(id, (words, now)));
    } else if response.changed() {
        ui.data_mut(|data| data.remove::<(String, f64)>(id));
    }
    let Some((words, since)) = ui.data(|data| data.get_temp::<(String, f64)>(id)) else {
        return;
    };
    let left = REFUSED - (now - since);
    if left <= 0.0 {
        return ui.data_mut(|data| data.remove::<(String, f64)>(id));
    }
    let colour = theme::palette(ui).warn;
    let (ctx, layer) = (ui.ctx().clone(), response.layer_id);
    Tooltip::always_open(ctx, layer, id, response.rect).show(|ui| ui.colored_label(colour, words));
    ui.ctx()
        .request_repaint_after(Duration::from_secs_f64(left));
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
    let named = format!("{group} {name}");
    choosable(&response, Role::RadioButton, chosen, &named);
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
    let (font, ink) = (
        FontId::proportional(theme::LEAST),
        ui.visuals().strong_text_color(),
    );
    let words = |name: &str| painter.layout_no_wrap(name.to_owned(), font.clone(), ink);
    let mut galley = words(name);
    if galley.size().x > rect.width() - 4.0 {
        // A long name gives its last word in short.
        let short = name.rsplit_once(' ').map(|(first, last)| {
            let last: String = last.chars().take(3).collect();
            format!("{first} {last}.")
        });
        galley = words(short.as_deref().unwrap_or(name));
    }
    let place = pos2(rect.center().x, rect.bottom() - 2.0);
    let area = Align2::CENTER_BOTTOM.anchor_size(place, galley.size());
    painter.galley(area.min, galley, ink);
    response
}

/// A value with a name; a double click on the name brings back what it is in the scene that was
/// opened.
pub fn number(
    ui: &mut Ui,
    actions: &mut Vec<Action>,
    parameter: &Parameter,
    value: f64,
    range: RangeInclusive<f64>,
    unit: &str,
) -> Option<f64> {
    let suffix = if unit.is_empty() {
        String::new()
    } else {
        format!(" {unit}")
    };
    let entry = Entry {
        name: &parameter.title(),
        value,
        range,
        speed: (value.abs() * 0.005).max(1e-4),
        decimals: 6,
        suffix: &suffix,
    };
    entered(ui, actions, parameter, entry)
}

/// The row of a parameter's field.
fn entered(
    ui: &mut Ui,
    actions: &mut Vec<Action>,
    parameter: &Parameter,
    entry: Entry<'_>,
) -> Option<f64> {
    let mut entered = None;
    let explained = |response| explain_parameter(response, parameter);
    let label = row(ui, entry.name, explained, |ui| {
        let (value, response) = entry.show(ui);
        entered = value;
        response
    });
    if label.double_clicked() {
        actions.push(Action::BringBack(parameter.key));
    }
    entered
}

/// The same of a number with E* = 1, which is shown as the scene's file gives it.
pub fn given(
    ui: &mut Ui,
    actions: &mut Vec<Action>,
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
    number(ui, actions, parameter, shown, range, &word).map(|new| scene.number_taken(of, new))
}

/// What only a law or a ground has, lengths as those of the gap; `None` while nothing is edited. A value that
/// is refused beside the others is said to be by the scene.
pub fn own(
    ui: &mut Ui,
    actions: &mut Vec<Action>,
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
                let range = low / unit..=high / unit;
                *x = number(ui, actions, parameter, *x / unit, range, word)
                    .map_or(*x, |new| new * unit);
            }
            Value::Whole(n) => {
                let named = (parameter, &*parameter.title());
                *n = whole(ui, actions, named, *n, low as u64..=most).unwrap_or(*n);
            }
            Value::Counts(both) => {
                for (count, axis) in both.iter_mut().zip(["x", "y"]) {
                    let name = format!("{} along {axis}", parameter.label);
                    *count = whole(
                        ui,
                        actions,
                        (parameter, &name),
                        *count as u64,
                        low as u64..=most,
                    )
                    .map_or(*count, |new| new as usize);
                }
            }
            Value::Flag(flag) => {
                explain_parameter(checkbox(ui, flag, parameter.label), parameter);
            }
            Value::Choice { chosen, words } => {
                let explained = |response| explain_parameter(response, parameter);
                row(ui, parameter.label, explained, |ui| {
                    let combo = egui::ComboBox::from_id_salt(parameter.key)
                        .width(84.0)
                        .selected_text(words[*chosen].replace('_', " "));
                    let combo = combo.show_ui(ui, |ui| {
                        for (i, word) in words.iter().enumerate() {
                            ui.selectable_value(chosen, i, word.replace('_', " "));
                        }
                    });
                    combo.response
                });
            }
        }
    }
    (edited != values).then_some(edited)
}

/// The same for a whole number, at most [`SEED_MAX`], under this name.
pub fn whole(
    ui: &mut Ui,
    actions: &mut Vec<Action>,
    (parameter, name): (&Parameter, &str),
    value: u64,
    range: RangeInclusive<u64>,
) -> Option<u64> {
    let entry = Entry {
        name,
        value: value as f64,
        range: *range.start() as f64..=*range.end() as f64,
        speed: 0.05,
        decimals: 0,
        suffix: "",
    };
    entered(ui, actions, parameter, entry).map(|value| value as u64)
}

/// A name on the left, and on the right what it names.
pub fn labelled(ui: &mut Ui, name: impl Into<WidgetText>, add: impl FnOnce(&mut Ui) -> Response) {
    let name = name.into();
    let word = name.text().to_owned();
    row(ui, name, |response| explain(response, &word), add);
}

fn row(
    ui: &mut Ui,
    name: impl Into<WidgetText>,
    explained: impl Fn(Response) -> Response,
    add: impl FnOnce(&mut Ui) -> Response,
) -> Response {
    ui.horizontal(|ui| {
        // Names are no stops of the keyboard.
        let name = Label::new(name).selectable(false).sense(Sense::CLICK);
        let label = explained(ui.add(name));
        at_right(ui, |ui| {
            explained(add(ui).labelled_by(label.id));
        });
        label
    })
    .inner
}

/// Draws boxes and circles of choices with an edge.
fn edged(ui: &mut Ui, add: impl FnOnce(&mut Ui) -> Response) -> Response {
    let (plain, edge) = (ui.visuals().widgets.inactive, theme::edge(ui.visuals()));
    ui.visuals_mut().widgets.inactive.bg_stroke = edge;
    let response = add(ui);
    ui.visuals_mut().widgets.inactive = plain;
    response
}

/// A box to be ticked.
pub fn checkbox<'a>(ui: &mut Ui, ticked: &'a mut bool, text: impl IntoAtoms<'a>) -> Response {
    edged(ui, |ui| ui.checkbox(ticked, text))
}

/// One of several choices, chosen if its value is the present one.
pub fn radio<'a, V: PartialEq>(
    ui: &mut Ui,
    present: &V,
    value: &V,
    text: impl IntoAtoms<'a>,
) -> Response {
    edged(ui, |ui| ui.radio(present == value, text))
}

/// The same, which becomes the present one by a click.
pub fn radio_value<'a, V: PartialEq>(
    ui: &mut Ui,
    present: &mut V,
    value: V,
    text: impl IntoAtoms<'a>,
) -> Response {
    let mut response = radio(ui, present, &value, text);
    if response.clicked() && *present != value {
        *present = value;
        response.mark_changed();
    }
    response
}

/// What is clicked asks for something.
pub trait Asks {
    /// Asks for it where it was clicked.
    fn asks<A>(&self, asked: &mut Vec<A>, for_what: A);
}

impl Asks for Response {
    fn asks<A>(&self, asked: &mut Vec<A>, for_what: A) {
        if self.clicked() {
            asked.push(for_what);
        }
    }
}

/// What stands at the right of a row.
pub fn at_right(ui: &mut Ui, add: impl FnOnce(&mut Ui)) {
    ui.with_layout(Layout::right_to_left(Align::Center), add);
}

/// A button of this name that opens a menu.
pub fn menu<'a>(
    ui: &mut Ui,
    face: impl IntoAtoms<'a>,
    [name, hover]: [&str; 2],
    add: impl FnOnce(&mut Ui),
) {
    named(ui.menu_button(face, add).response, name).on_hover_text(hover);
}

/// Gives a button a name that says more than its face.
pub fn named(button: Response, name: &str) -> Response {
    named_as(Role::Button, button, name)
}

/// The same of a widget of another kind.
pub fn named_as(role: Role, widget: Response, name: &str) -> Response {
    widget.widget_info(|| WidgetInfo::labeled(role, widget.enabled(), name));
    explain(widget, name)
}

/// Gives something that is chosen or not a name.
pub fn choosable(widget: &Response, role: Role, chosen: bool, name: &str) {
    widget.widget_info(|| WidgetInfo::selected(role, true, chosen, name));
}

/// Says in a sentence what a picture shows.
pub fn described(picture: &Response, sentence: &str) {
    picture.widget_info(|| WidgetInfo::labeled(Role::Image, true, sentence));
}

/// How far a job is, beside a button that stops it, which is returned.
pub fn progress<T>(ui: &mut Ui, job: &Job<T>) -> Response {
    let button = explain(ui.button("Cancel"), "Cancel");
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
