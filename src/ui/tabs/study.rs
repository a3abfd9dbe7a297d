//! A study of the scene: its loop at many values of one number, a mark each as it is computed; a
//! click opens the scene of a mark.

use super::map::Around;
use super::{Tab, Title, Update};
use crate::physics::parameter::{Parameter, Value, number};
use crate::plot::panel::Panel;
use crate::plot::study_panel::sweep_panel;
use crate::scene::parameter::fixed;
use crate::scene::{edit, parameter};
use crate::study::sweep::{COLUMNS, Point, Row, Study};
use crate::study::sweep::{Spacing, Span, grid};
use crate::ui::action::Action;
use crate::ui::diagram;
use crate::ui::view_state::ViewState;
use crate::ui::widgets::{Entry, checkbox, described, named_as, progress};
use crate::ui::words::explain;
use crate::worker::job::{Job, Reporter};
use egui::{ComboBox, RichText, Role, Ui};
use std::sync::Arc;

/// Loops, as long as nobody chooses, and at most.
const COUNT: usize = 15;
const COUNT_MAX: usize = 1000;
/// How far the number goes to either side, as a factor, as long as nobody chooses.
const REACH: f64 = 1.4;
/// How near to a mark the pointer must be (screen points).
const NEAR: f32 = 12.0;
/// What can be drawn, with its name for people.
const QUANTITIES: [(&str, &str); 8] = [
    ("dissipated_energy", "loss / γ"),
    ("approach_jumps", "jumps on approach, u₀"),
    ("retraction_jumps", "jumps on retraction, u₀"),
    ("jumps", "number of jumps"),
    ("pull_off_stress", "pull-off stress"),
    ("predicted_error", "error to be expected"),
    ("points", "points of the mesh"),
    ("seconds", "seconds"),
];

type Rows = Arc<Vec<Row>>;

/// The tab.
pub struct StudyTab {
    /// What goes, and the value around which its ends were chosen; `None` until somebody looks.
    goes: Option<(&'static Parameter, Span)>,
    count: usize,
    /// Index of what is drawn.
    quantity: usize,
    running: Option<Running>,
    asked: Option<Asked>,
}

/// A study under way or done.
struct Running {
    study: Arc<Study>,
    around: Around,
    job: Job<Rows>,
    /// What is drawn of it, as of so many rows and of which quantity.
    drawn: Option<(Rows, usize, Panel)>,
}

/// What was asked of the tab.
enum Asked {
    Compute,
    Open(Vec<f64>),
}

impl Default for StudyTab {
    fn default() -> Self {
        Self {
            goes: None,
            count: COUNT,
            quantity: 0,
            running: None,
            asked: None,
        }
    }
}

/// The numbers of the scene that may go, with their values.
fn numbers(state: &ViewState) -> Vec<(&'static Parameter, f64)> {
    let decided = edit::decided(&state.scene, &state.model);
    let numbers = decided.numbers().into_iter();
    let numbers = numbers.filter_map(|(parameter, value)| match value {
        Value::Number(x) => Some((parameter, x)),
        Value::Whole(n) => Some((parameter, n as f64)),
        _ => None,
    });
    numbers
        .filter(|(parameter, _)| *parameter.key != *parameter::TARGET.key)
        .collect()
}

/// Values around a number.
fn around((parameter, value): (&'static Parameter, f64)) -> (&'static Parameter, Span) {
    let (from, to) = match value {
        _ if parameter.key == parameter::SEED.key => (value, value + (COUNT - 1) as f64),
        value if value > 0.0 => (value / REACH, value * REACH),
        value => (value - 1.0, value + 1.0),
    };
    // Short numbers, which people read and change.
    let short = |x: f64| format!("{x:.2e}").parse().unwrap_or(x);
    let spacing = Spacing::Linear;
    let (from, to) = (short(from), short(to));
    (parameter, Span { from, to, spacing })
}

impl Tab for StudyTab {
    fn title(&self) -> Title {
        Title::tall(
            "Study",
            "the loop at many values of one number, as marks to open",
        )
    }

    fn show(&mut self, ui: &mut Ui, state: &ViewState, _: &mut Vec<Action>) {
        ui.horizontal_wrapped(|ui| {
            self.choices(ui, state);
            let job = self.running.as_ref().map(|running| &running.job);
            if let Some(job) = job.filter(|job| job.is_running()) {
                progress(ui, job);
            } else {
                let distinct = self.goes.is_some_and(|(_, span)| span.from != span.to);
                let button = ui.add_enabled(distinct, egui::Button::new("Compute"));
                if explain(button, "Compute").clicked() {
                    self.asked = Some(Asked::Compute);
                }
            }
            if let Some(running) = &self.running {
                let why = running.job.failed.clone();
                ui.label(RichText::new(why.unwrap_or_else(|| running.words())).small());
            }
        });
        let Some(running) = &mut self.running else {
            let words = "The loop of this scene at many values of one number.";
            ui.label(RichText::new(words).weak());
            return;
        };
        if let Some(values) = running.clicked(ui, self.quantity) {
            self.asked = Some(Asked::Open(values));
        }
    }

    fn panels(&self, _: &ViewState) -> Vec<Panel> {
        let drawn = self
            .running
            .as_ref()
            .and_then(|running| running.drawn.as_ref());
        drawn.map(|(.., panel)| panel.clone()).into_iter().collect()
    }

    fn update(
        &mut self,
        Update {
            state,
            solver,
            seen,
        }: Update<'_>,
    ) {
        if seen {
            let known = numbers(state);
            let goes = |(parameter, _): &(&Parameter, Span)| {
                known.iter().any(|(known, _)| known.key == parameter.key)
            };
            if !self.goes.as_ref().is_some_and(goes) {
                let range = known
                    .iter()
                    .find(|(known, _)| known.key == parameter::RANGE.key);
                self.goes = range.copied().map(around);
            }
        }
        match self.asked.take() {
            Some(Asked::Compute) => {
                if let Some(study) = self.study(state) {
                    let (key, study) = (study.0, Arc::new(study.1));
                    self.running = Some(Running {
                        around: Around::of(state, key),
                        job: solver.job(study.clone(), compute),
                        study,
                        drawn: None,
                    });
                }
            }
            Some(Asked::Open(values)) => {
                let running = self.running.as_ref();
                let scene = running.map(|running| running.study.scene_at(&values));
                match scene {
                    Some(Ok(scene)) => state.edit_scene(scene),
                    Some(Err(why)) => state.messages.fail(why.to_string(), "The scene stays."),
                    None => {}
                }
            }
            None => {}
        }
        // What is shown belongs to this scene.
        let holds = |running: &Running| {
            let key = &running.study.keys[0];
            running.around.holds(state, key, f64::INFINITY)
        };
        self.running.take_if(|running| !holds(running));
        if let Some(running) = &mut self.running {
            running.job.poll();
        }
    }
}

impl StudyTab {
    /// What is asked for, with the key of what goes.
    fn study(&self, state: &ViewState) -> Option<(&'static str, Study)> {
        let (parameter, span) = self.goes?;
        let key = parameter.key;
        let spacing = if span.from.min(span.to) > 0.0 {
            span.spacing
        } else {
            Spacing::Linear
        };
        let study = Study {
            title: state.scene.title.clone(),
            scene: (*state.scene).clone(),
            keys: vec![key.to_owned()],
            places: grid(&[Span { spacing, ..span }.values(self.count)]),
            record: COLUMNS.iter().collect(),
            plot: [key, QUANTITIES[0].0].map(str::to_owned),
        };
        Some((key, study))
    }

    /// What goes, between which ends, how often, and what is drawn.
    fn choices(&mut self, ui: &mut Ui, state: &ViewState) {
        ui.spacing_mut().item_spacing.x = 4.0;
        let Some((parameter, span)) = &mut self.goes else {
            return;
        };
        let before = parameter.key;
        let combo = ComboBox::from_id_salt("study number")
            .width(90.0)
            .selected_text(parameter.label.to_lowercase());
        let mut chosen = None;
        let combo = combo.show_ui(ui, |ui| {
            for known in numbers(state) {
                let label = known.0.label.to_lowercase();
                if ui.selectable_label(known.0.key == before, label).clicked() {
                    chosen = Some(known);
                }
            }
        });
        named_as(Role::ComboBox, combo.response, "Number that goes");
        let speed = 0.01 * (span.to - span.from).abs().max(1e-6);
        for (name, end) in [("from", &mut span.from), ("to", &mut span.to)] {
            let label = explain(ui.label(name), name);
            let entry = Entry {
                name,
                value: *end,
                range: parameter.range.clone(),
                speed,
                decimals: 6,
                suffix: "",
            };
            let (entered, response) = entry.show(ui);
            explain(response.labelled_by(label.id), name);
            *end = entered.unwrap_or(*end);
        }
        let label = explain(ui.label("loops"), "loops");
        let entry = Entry {
            name: "loops",
            value: self.count as f64,
            range: 2.0..=COUNT_MAX as f64,
            speed: 0.1,
            decimals: 0,
            suffix: "",
        };
        let (entered, response) = entry.show(ui);
        explain(response.labelled_by(label.id), "loops");
        self.count = entered.map_or(self.count, |count| count as usize);
        let mut logarithmic = span.spacing == Spacing::Logarithmic;
        explain(checkbox(ui, &mut logarithmic, "log"), "log");
        span.spacing = if logarithmic {
            Spacing::Logarithmic
        } else {
            Spacing::Linear
        };
        let combo = ComboBox::from_id_salt("study quantity")
            .width(120.0)
            .selected_text(QUANTITIES[self.quantity].1);
        let combo = combo.show_ui(ui, |ui| {
            for (i, (_, name)) in QUANTITIES.iter().enumerate() {
                ui.selectable_value(&mut self.quantity, i, *name);
            }
        });
        named_as(Role::ComboBox, combo.response, "Quantity that is drawn");
        if let Some(known) = chosen {
            self.goes = Some(around(known));
        }
    }
}

impl Running {
    fn rows(&self) -> Rows {
        self.job.so_far.clone().unwrap_or_default()
    }

    /// How many loops there are, and how many failed.
    fn words(&self) -> String {
        let rows = self.rows();
        let failed = rows.iter().filter(|row| !row.is_complete()).count();
        let mut words = format!("{} of {} loops", rows.len(), self.study.places.len());
        if failed > 0 {
            words.push_str(&format!(", {failed} failed"));
        }
        if !rows.is_empty() {
            words.push_str("; a click opens one");
        }
        words
    }

    /// Draws the marks; returns the values of the one that was clicked.
    fn clicked(&mut self, ui: &mut Ui, quantity: usize) -> Option<Vec<f64>> {
        let rows = self.rows();
        let fresh = |(drawn, of, _): &mut (Rows, usize, Panel)| {
            !Arc::ptr_eq(drawn, &rows) || *of != quantity
        };
        self.drawn.take_if(fresh);
        let (name, title) = QUANTITIES[quantity];
        let names = [self.study.keys[0].clone(), name.to_owned()];
        let (.., panel) = self.drawn.get_or_insert_with(|| {
            let mut panel = sweep_panel(&self.study, &rows, &names);
            panel.y.label = title.to_owned();
            (rows.clone(), quantity, panel)
        });
        diagram::legend(ui, panel);
        let height = ui.available_height().max(80.0);
        let shown = diagram::show(ui, panel, "study", height, |_, _| None);
        let marks = rows.iter().flat_map(|row| {
            let numbers = self.study.numbers(row, name);
            numbers.into_iter().map(move |y| (row, [row.values[0], y]))
        });
        let placed = marks.map(|(row, [x, y])| {
            (
                (row, [x, y]),
                [panel.x.spread.shown(x), panel.y.spread.shown(y)],
            )
        });
        let pointed = diagram::nearest(&shown, NEAR, placed);
        let response = shown.response;
        let sentence = format!("Study of {}: {}", self.study.keys[0], self.words());
        described(&response, &sentence);
        let (row, [x, y]) = pointed?;
        ui.ctx().set_cursor_icon(egui::CursorIcon::PointingHand);
        let words = format!(
            "{} = {}: {title} {}",
            self.study.keys[0],
            number(x),
            fixed(y, 6)
        );
        let clicked = response.clicked();
        response.on_hover_text_at_pointer(words);
        clicked.then(|| row.values.clone())
    }
}

/// The loops, told as they are found.
fn compute(study: &Arc<Study>, report: &Reporter<Rows>) -> Result<(), String> {
    study.check().map_err(|why| why.to_string())?;
    let points = study.points();
    let all: Vec<&Point> = points.iter().collect();
    let mut rows: Vec<Row> = Vec::new();
    study.compute(&all, &report.cancel, &mut |row, done| {
        rows.push(row);
        if report.is_due() {
            report.progress(done, &format!("{} of {} loops", rows.len(), points.len()));
            report.result(Arc::new(rows.clone()));
        }
    });
    report.result(Arc::new(rows));
    Ok(())
}
