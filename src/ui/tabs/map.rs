//! The map of patterns: the loop of the scene while its range goes, with the present scene as a
//! cross; a click opens the scene there.

use super::{Tab, Title, Update, small, under_way};
use crate::physics::parameter::{Parameter, Value};
use crate::plot::panel::{Colour, Panel, Series, Symbol};
use crate::plot::study_panel::{loop_of, map_panels};
use crate::scene::{Scene, edit, parameter};
use crate::study::map::{PatternMap, Row, Vary};
use crate::ui::action::Action;
use crate::ui::diagram;
use crate::ui::view_state::ViewState;
use crate::ui::widgets::{described, radio_value};
use crate::ui::words::explain_parameter;
use crate::worker::job::{Job, Reporter};
use egui::{RichText, Ui};
use std::sync::Arc;

/// How many values.
const ROWS: usize = 73;
/// How far the parameter goes to either side, as a factor.
const REACH: f64 = 2.0;

/// What may go, with its value: the numbers of the scene that are above zero, but for those that
/// say how it is driven and computed.
fn numbers(state: &ViewState) -> Vec<(&'static Parameter, f64)> {
    let decided = edit::decided(&state.scene, &state.model);
    let goes = |parameter: &Parameter| match parameter.key.split_once('.') {
        Some(("drive" | "accuracy" | "units", _)) => parameter.key == parameter::STIFFNESS.key,
        _ => true,
    };
    let numbers = decided.numbers().into_iter();
    let positive = numbers.filter_map(|(parameter, value)| match value {
        Value::Number(value) if value > 0.0 => Some((parameter, value)),
        _ => None,
    });
    positive.filter(|(parameter, _)| goes(parameter)).collect()
}

/// Law, body, ground and machine.
fn kinds(state: &ViewState) -> [&'static str; 4] {
    let model = &state.model;
    [
        model.law.shape.word(),
        model.body.word(),
        model.indenter.word(),
        state.scene.drive.control.word(),
    ]
}

/// The tab.
pub struct Map {
    /// The key of the number that goes.
    key: &'static str,
    /// The map, around which model and under which machine.
    job: Option<(Around, Job<Arc<PatternMap>>)>,
    /// The value under the pointer, and whether its scene is to be opened.
    pointed: Option<(f64, bool)>,
}

impl Default for Map {
    fn default() -> Self {
        Self {
            key: parameter::RANGE.key,
            job: None,
            pointed: None,
        }
    }
}

/// Around what a map is made.
pub(super) struct Around {
    numbers: Vec<(&'static Parameter, f64)>,
    kinds: [&'static str; 4],
    key: &'static str,
}

impl Map {
    /// The newest map, if it holds what is shown.
    fn shown(&self, state: &ViewState) -> Option<&PatternMap> {
        let (around, job) = self.job.as_ref()?;
        let map = job.so_far.as_ref()?;
        around.holds(state, self.key, REACH).then_some(map)
    }

    /// What goes, with its present value.
    fn goes(&self, state: &ViewState) -> Option<(&'static Parameter, f64)> {
        let is_it = |(parameter, _): &(&Parameter, f64)| parameter.key == self.key;
        numbers(state).into_iter().find(is_it)
    }
}

impl Around {
    /// What is made around the present scene, of which the number of this key goes.
    pub(super) fn of(state: &ViewState, key: &'static str) -> Self {
        Self {
            numbers: numbers(state),
            kinds: kinds(state),
            key,
        }
    }

    /// True if the scene differs in no more than what goes, by a factor up to `reach`, and what
    /// follows it.
    pub(super) fn holds(&self, state: &ViewState, key: &str, reach: f64) -> bool {
        let now = numbers(state);
        let same = |((own, a), (other, b)): (&(&Parameter, f64), &(&Parameter, f64))| {
            let goes = own.key == key && (1.0 / reach..=reach).contains(&(b / a));
            own.key == other.key && (a == b || goes)
        };
        key == self.key
            && kinds(state) == self.kinds
            && now.len() == self.numbers.len()
            && self.numbers.iter().zip(&now).all(same)
    }
}

impl Tab for Map {
    fn title(&self) -> Title {
        Title::tall(
            "Map",
            "which pattern stands where, while one parameter goes",
        )
    }

    fn show(&mut self, ui: &mut Ui, state: &ViewState, _: &mut Vec<Action>) {
        ui.horizontal_wrapped(|ui| {
            for (parameter, _) in numbers(state) {
                let label = parameter.label.to_lowercase();
                let choice = radio_value(ui, &mut self.key, parameter.key, label);
                explain_parameter(choice, parameter);
            }
            if let Some((_, job)) = &self.job {
                under_way(ui, job);
            }
        });
        self.pointed = None;
        let Some(map) = self.shown(state) else {
            let words = "The loop of this scene while one parameter goes.";
            ui.label(RichText::new(words).weak());
            return;
        };
        let [mut approach, mut retraction, loss] = map_panels(map, state.scene.units);
        let now = state.run.state.as_ref().zip(self.goes(state));
        let here = now.map(|(now, (_, value))| [now.mean_displacement / state.rho(), value]);
        for panel in [&mut approach, &mut retraction] {
            let at = here.into_iter().collect();
            let here = Series::symbols("", Symbol::Plus, Colour::Ink, at);
            panel.series.push(here);
        }
        // Names would lie over each other in so little room.
        diagram::legend(ui, &approach);
        for panel in [&mut approach, &mut retraction] {
            panel.labels.clear();
        }
        let size = ui.available_size();
        let mut pointed = None;
        ui.horizontal_top(|ui| {
            let one = |ui: &mut Ui, mut panel: Panel, name: &str, share: f32| {
                panel.x.label = if name == "Loss" {
                    "loss / γ"
                } else {
                    "u₀ / ρ"
                }
                .to_owned();
                if name != "approach" {
                    panel.y.label.clear();
                }
                let size = egui::vec2(share * size.x - 6.0, size.y - 4.0);
                let drawn = small(ui, &panel, name, size);
                let place = drawn.response.hover_pos();
                let place = place.map(|p| drawn.transform.value_from_position(p).y);
                described(&drawn.response, &format!("Map of patterns: {name}"));
                place.map(|y| (panel.y.spread.value(y), drawn.response.clicked()))
            };
            for (panel, name, share) in [
                (approach, "approach", 0.38),
                (retraction, "retraction", 0.35),
                (loss, "Loss", 0.27),
            ] {
                pointed = one(ui, panel, name, share).or(pointed);
            }
        });
        self.pointed = pointed;
    }

    fn panels(&self, state: &ViewState) -> Vec<Panel> {
        let map = self.shown(state);
        map.map_or(Vec::new(), |map| map_panels(map, state.scene.units).into())
    }

    fn update(
        &mut self,
        Update {
            state,
            solver,
            seen,
        }: Update<'_>,
    ) {
        let pointed = self.pointed.take().filter(|_| seen);
        state.plots.preview = pointed.and_then(|(value, _)| {
            let row = self.shown(state)?.nearest(value)?;
            let (parameter, _) = self.goes(state)?;
            loop_of(row, &format!("{} = {:.4}", parameter.symbol, row.value))
        });
        if let Some((value, true)) = pointed {
            let edited = edit::with_parameter(&state.scene, &state.model, self.key, value);
            if let Ok(scene) = edited {
                state.edit_scene(scene);
            }
        }
        if self.goes(state).is_none() {
            self.key = parameter::RANGE.key;
        }
        let holds = |(around, _): &(Around, _)| around.holds(state, self.key, REACH);
        if !self.job.as_ref().is_some_and(holds) {
            self.job = None;
            if seen {
                let around = Around::of(state, self.key);
                let vary = self.goes(state).map(|(_, value)| Vary {
                    key: self.key.to_owned(),
                    from: value / REACH,
                    to: value * REACH,
                });
                let job = solver.job((state.scene.clone(), vary), compute);
                self.job = Some((around, job));
            }
        }
        if let Some((_, job)) = &mut self.job {
            job.poll();
        }
    }
}

/// The map, shown as far as it is known.
fn compute(
    (scene, vary): &(Arc<Scene>, Option<Vary>),
    report: &Reporter<Arc<PatternMap>>,
) -> Result<(), String> {
    let Some(vary) = vary else { return Ok(()) };
    let mut so_far = PatternMap {
        vary: vary.clone(),
        rows: Vec::new(),
        cancelled: false,
    };
    let mut tell = |row: &Row, done: f64| {
        so_far.insert(row.clone());
        if report.is_due() {
            report.progress(done, &format!("{} = {:.4}", vary.key, row.value));
            report.result(Arc::new(so_far.clone()));
        }
    };
    let map = PatternMap::of(scene, vary, ROWS, &report.cancel, &mut tell);
    let map = map.map_err(|error| error.to_string())?;
    if !map.cancelled {
        report.result(Arc::new(map));
    }
    Ok(())
}
