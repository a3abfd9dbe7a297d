//! The map of patterns: the loop of the scene while its range goes, with the present scene as a
//! cross; a click opens the scene there.

use super::{Tab, Title, Update, doing};
use crate::physics::control::Control;
use crate::physics::parameter::Parameter;
use crate::plot::map_panel::map_panels;
use crate::plot::panel::{Colour, Panel, Series, Symbol};
use crate::scene::{Model, Scene, edit, parameter};
use crate::study::map::{PatternMap, Row, Vary};
use crate::ui::action::Action;
use crate::ui::diagram;
use crate::ui::view_state::ViewState;
use crate::ui::widgets::{described, progress};
use crate::worker::job::{Job, Reporter};
use egui::{RichText, Ui};
use std::sync::Arc;

/// Values of a first, coarse map and of the fine one after it.
const ROWS: [usize; 2] = [9, 73];
/// How far the parameter goes to either side, as a factor.
const REACH: f64 = 2.0;

/// What may go.
static KEYS: [&Parameter; 3] = [
    &parameter::RANGE,
    &parameter::LENGTH,
    &parameter::SURFACE_ENERGY,
];

/// Their values in a model.
fn values(model: &Model) -> [f64; 3] {
    let law = &model.law;
    [law.range, model.grid.length, law.surface_energy]
}

/// The tab.
#[derive(Default)]
pub struct Map {
    /// Which of the parameters goes.
    key: usize,
    /// The map, around which model and under which machine.
    job: Option<(Around, Job<Arc<PatternMap>>)>,
    missing: Option<String>,
    /// The value whose scene is to be opened.
    open: Option<f64>,
}

/// Around what a map is made.
struct Around {
    model: Model,
    control: Control,
    key: usize,
}

impl Map {
    /// The newest map, if it holds what is shown.
    fn shown(&self, state: &ViewState) -> Option<&PatternMap> {
        let (around, job) = self.job.as_ref()?;
        let map = job.so_far.as_ref()?;
        around.holds(state, self.key).then_some(map)
    }
}

impl Around {
    /// True if the scene differs in no more than what goes, and what follows it.
    fn holds(&self, state: &ViewState, key: usize) -> bool {
        let (here, there) = (&self.model, &state.model);
        let (own, other) = (values(here), values(there));
        let same = |i: usize| i == key || own[i] == other[i];
        key == self.key
            && state.scene.control() == self.control
            && (here.law.shape, here.indenter) == (there.law.shape, there.indenter)
            && (0..KEYS.len()).all(same)
            && (1.0 / REACH..=REACH).contains(&(other[key] / own[key]))
    }
}

impl Tab for Map {
    fn title(&self) -> Title {
        Title {
            tall: true,
            ..Title::new(
                "Map",
                "which pattern stands where, while one parameter goes",
            )
        }
    }

    fn show(&mut self, ui: &mut Ui, state: &ViewState, _: &mut Vec<Action>) {
        ui.horizontal_wrapped(|ui| {
            for (key, parameter) in KEYS.iter().enumerate() {
                ui.radio_value(&mut self.key, key, parameter.label.to_lowercase());
            }
            match (&self.job, &self.missing) {
                (Some((_, job)), _) if job.is_running() => {
                    progress(ui, job);
                    doing(ui, job);
                }
                (_, Some(why)) => {
                    ui.label(RichText::new(why).small());
                }
                _ => {}
            }
        });
        let Some(map) = self.shown(state) else {
            let words = "The loop of this scene while one parameter goes.";
            ui.label(RichText::new(words).weak());
            return;
        };
        let [mut approach, mut retraction, loss] = map_panels(map);
        let value = values(&state.model)[self.key];
        let now = state.run.state.as_ref();
        let here = now.map(|now| [now.mean_displacement / state.rho(), value]);
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
        let mut clicked = None;
        ui.horizontal_top(|ui| {
            let one = |ui: &mut Ui, mut panel: Panel, name: &str, share: f32| {
                panel.x.label = if name == "loss" {
                    "loss / γ"
                } else {
                    "u₀ / ρ"
                }
                .to_owned();
                if name != "approach" {
                    panel.y.label.clear();
                }
                let size = egui::vec2(share * size.x - 6.0, size.y - 4.0);
                ui.allocate_ui(size, |ui| {
                    ui.vertical(|ui| {
                        ui.small(name);
                        let height = ui.available_height().max(60.0);
                        let drawn = diagram::show(ui, &panel, name, height, |_, _| None);
                        let place = drawn.response.hover_pos();
                        let place = place.map(|p| drawn.transform.value_from_position(p).y);
                        if drawn.response.clicked() {
                            let geometric = panel.y.logarithmic;
                            return place.map(|y| if geometric { 10f64.powf(y) } else { y });
                        }
                        described(&drawn.response, &format!("Map of patterns: {name}"));
                        None
                    })
                    .inner
                })
                .inner
            };
            for (panel, name, share) in [
                (approach, "approach", 0.38),
                (retraction, "retraction", 0.35),
                (loss, "loss", 0.27),
            ] {
                clicked = one(ui, panel, name, share).or(clicked);
            }
        });
        self.open = clicked;
    }

    fn update(
        &mut self,
        Update {
            state,
            solver,
            seen,
        }: Update<'_>,
    ) {
        if let Some(value) = self.open.take() {
            let edited =
                edit::with_parameter(&state.scene, &state.model, KEYS[self.key].key, value);
            if let Ok(scene) = edited {
                state.edit_scene(scene);
            }
        }
        let holds = |(around, _): &(Around, _)| around.holds(state, self.key);
        if !self.job.as_ref().is_some_and(holds) {
            (self.job, self.missing) = (None, None);
            if seen {
                let around = Around {
                    model: state.model.clone(),
                    control: state.scene.control(),
                    key: self.key,
                };
                let job = solver.job((state.scene.clone(), self.key), compute);
                self.job = Some((around, job));
            }
        }
        if let Some((_, job)) = &mut self.job
            && let Some(Err(why)) = job.poll()
        {
            self.missing = Some(why);
        }
    }
}

/// A coarse map first, then a fine one.
fn compute(
    (scene, key): &(Arc<Scene>, usize),
    report: &Reporter<Arc<PatternMap>>,
) -> Result<(), String> {
    let model = scene.model().map_err(|error| error.to_string())?;
    let (key, value) = (KEYS[*key].key, values(&model)[*key]);
    let vary = Vary {
        key: key.to_owned(),
        from: value / REACH,
        to: value * REACH,
    };
    for count in ROWS {
        let mut tell = |row: &Row, done: f64| {
            if report.is_due() {
                report.progress(done, &format!("{} = {:.4}", vary.key, row.value));
            }
        };
        let map = PatternMap::of(scene, &vary, count, &report.cancel, &mut tell);
        let map = map.map_err(|error| error.to_string())?;
        if map.cancelled {
            return Ok(());
        }
        report.result(Arc::new(map));
    }
    Ok(())
}
