//! The energy landscape: the paths from the present state over its saddles, the ball where the
//! surface is, and how the barriers change along the control.

use super::{Tab, Title, Update, small};
use crate::follow::diagram::Diagram;
use crate::follow::record::StateRecord;
use crate::numerics::threads::Cancel;
use crate::physics::control::Control;
use crate::physics::law::Law;
use crate::plot::diagram_panel::{Extent, at, barrier_panel, landscape_panel};
use crate::plot::panel::{Colour, Panel, Series};
use crate::scene::Scene;
use crate::scene::parameter::significant;
use crate::solver::Lost;
use crate::study::landscape::{BEFORE, Ground, Landscape, Standing};
use crate::ui::action::Action;
use crate::ui::diagram;
use crate::ui::view_state::ViewState;
use crate::ui::widgets::{described, progress};
use crate::worker::job::{Job, Reporter};
use crate::worker::protocol::Frame;
use egui::{Align, Label, Layout, RichText, Ui, vec2};
use egui_plot::PlotResponse;
use std::sync::Arc;
use std::time::Duration;

/// The pointer this near to a path means a place of it, in screen points.
const NEAR: f32 = 30.0;
/// How long the ball rolls down after a jump, in seconds.
const FALL: f64 = 1.2;
/// The state that gave way is one of so many newest.
const RECENT: usize = 8;
/// Shares of the width: the paths, and the barriers.
const SHARES: [f32; 2] = [0.62, 0.38];

/// The tab.
#[derive(Default)]
pub struct LandscapeTab {
    /// The scene it speaks of.
    scene: Option<Arc<Scene>>,
    /// What is computed around which state.
    job: Option<(Standing, Job<Arc<Landscape>>)>,
    /// The job has told its passes.
    told: bool,
    /// The newest landscape.
    shown: Option<Arc<Landscape>>,
    /// How many jumps of the run are known, and the last one while the ball rolls.
    jumps: usize,
    fall: Option<Fall>,
    /// What both diagrams show, of any state of the scene.
    extent: Extent,
    /// The pass and the place of its path under the pointer.
    pointed: Option<[usize; 2]>,
    /// What is pictured of it, and what was pictured before.
    pictured: Option<[Arc<Frame>; 2]>,
}

/// A jump that is shown: the state that gave way, since when its landscape is seen (seconds of the
/// window), and whether the ball is down: there it stays until the next landscape is known.
struct Fall {
    from: Standing,
    began: Option<f64>,
    is_down: bool,
}

impl Tab for LandscapeTab {
    fn title(&self) -> Title {
        let what = "what holds the surface: the barriers around it, and the ways over them";
        Title::tall("Landscape", what)
    }

    fn show(&mut self, ui: &mut Ui, state: &ViewState, _: &mut Vec<Action>) {
        let words = self.words(state);
        let landscape = self.shown.clone().filter(|shown| !shown.passes.is_empty());
        let down = self.roll(ui);
        // Nothing moves when a job begins or ends.
        let row = vec2(ui.available_width(), ui.spacing().interact_size.y);
        ui.allocate_ui_with_layout(row, Layout::right_to_left(Align::Center), |ui| {
            if let Some((_, job)) = self.job.as_ref().filter(|(_, job)| job.is_running()) {
                progress(ui, job);
            }
            if landscape.is_some() {
                ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                    ui.add(Label::new(RichText::new(&words).strong()).truncate());
                });
            }
        });
        let before = self.pointed.take();
        let Some(landscape) = landscape else {
            // Below there is room for all of them.
            ui.strong(words);
            return;
        };
        let law = &state.model.law;
        let [mut paths, barriers] = self.diagrams(&landscape, state);
        paths.series.extend(ball(&landscape, law, down));
        let place = before.and_then(|[pass, place]| {
            let pass = landscape.passes.get(pass)?;
            Some(at(pass.path.get(place)?, pass, law))
        });
        paths.series.push(Series::framed(place, Colour::Ink));
        diagram::legend(ui, &paths);
        let size = ui.available_size();
        ui.horizontal_top(|ui| {
            for (k, panel) in [paths, barriers].into_iter().enumerate() {
                let size = vec2(SHARES[k] * size.x - 6.0, size.y - 4.0);
                let drawn = small(ui, &panel, &panel.title, size);
                described(&drawn.response, &format!("Landscape: {words}"));
                if k == 0 {
                    self.pointed = pointed(&drawn, &landscape, law);
                }
            }
        });
    }

    fn panels(&self, state: &ViewState) -> Vec<Panel> {
        let shown = self.shown.as_ref();
        shown.map_or(Vec::new(), |landscape| {
            self.diagrams(landscape, state).into()
        })
    }

    fn update(&mut self, with: Update<'_>) {
        let state = with.state;
        state.plots.wants_branches = with.seen;
        if self
            .scene
            .as_ref()
            .is_none_or(|s| !Arc::ptr_eq(s, &state.scene))
        {
            *self = Self {
                scene: Some(state.scene.clone()),
                ..Self::default()
            };
        }
        self.picture(state);
        if let Some((of, job)) = &mut self.job {
            job.poll();
            if let Some(found) = job.so_far.take() {
                let lowest = found.passes.first();
                state.plots.barrier = lowest.map(|pass| (*of, pass.barrier()));
                self.extent = self.extent.with(&found, &state.model.law);
                (self.shown, self.told) = (Some(found), true);
                self.fall.take_if(|fall| fall.is_down && fall.from != *of);
            }
        }
        let Some(diagram) = state.plots.branches.clone().filter(|_| with.seen) else {
            return;
        };
        self.hear_of_jumps(state);
        let falls = self.fall.as_ref().filter(|fall| !fall.is_down);
        let falls = falls.map(|fall| fall.from);
        let Some(here) = falls.or_else(|| {
            let now = state.run.state.as_ref();
            now.map(|now| Standing::of(now, state.scene.control()))
        }) else {
            return;
        };
        // While the surface is moved the passes of each state are waited for, and no more.
        let stale = self.job.as_ref();
        let stale = stale.is_none_or(|(of, job)| *of != here && (self.told || !job.is_running()));
        if stale {
            let input = (state.scene.clone(), diagram, here, self.shown.clone());
            self.job = Some((here, with.solver.job(input, compute)));
            self.told = false;
        }
    }
}

/// A scene with its branches, the state, and the landscape before.
type Asked = (Arc<Scene>, Arc<Diagram>, Standing, Option<Arc<Landscape>>);

/// The landscape around a state: the passes first, then their barriers along the control.
fn compute(
    (scene, diagram, state, before): &Asked,
    report: &Reporter<Arc<Landscape>>,
) -> Result<(), String> {
    let model = scene.model().map_err(|error| error.to_string())?;
    let cancel: &Cancel = &report.cancel;
    let ground = Ground {
        scene,
        model: &model,
        diagram,
        cancel,
    };
    let mut observe = |done: f64, so_far: &Landscape| {
        report.progress(done, "barriers along the drive");
        report.result(Arc::new(so_far.clone()));
    };
    match Landscape::around(ground, *state, before.as_deref(), &mut observe) {
        Ok(found) => report.result(Arc::new(found)),
        Err(Lost::Cancelled) => {}
        Err(lost) => return Err(format!("{lost:?}")),
    }
    Ok(())
}

impl LandscapeTab {
    /// The ways over the barriers, and how high these are along the drive.
    fn diagrams(&self, landscape: &Landscape, state: &ViewState) -> [Panel; 2] {
        let told = state.told();
        let label = match state.model.units {
            None => format!("{} /{}", told.symbol, told.suffix),
            Some(_) => format!("{} ({})", told.symbol, told.suffix.trim()),
        };
        let mut barriers = barrier_panel(landscape, &state.model, self.extent, (&label, told.unit));
        if state.scene.control() != Control::Load {
            let [left, right] = [state.axes().0[0], state.axes().1[0]];
            let ranges = state.rho() / told.unit;
            barriers.x = barriers.x.from_to(left * ranges, right * ranges);
        }
        [
            landscape_panel(landscape, &state.model, self.extent),
            barriers,
        ]
    }

    /// Begins a fall for the newest jump, from the state that gave way.
    fn hear_of_jumps(&mut self, state: &ViewState) {
        let record = &state.run.record;
        let new = record.jumps.len() > self.jumps;
        self.jumps = record.jumps.len();
        let Some(jump) = record.jumps.last().filter(|_| new) else {
            return;
        };
        let near = BEFORE * state.scene.control().unit(&state.model.law);
        let off = |state: &&StateRecord| (state.stress - jump.stress_before).abs();
        let before = record.states.iter().rev().take(RECENT);
        let before = before.filter(|state| (state.control - jump.control).abs() < near);
        let before = before.min_by(|a, b| off(a).total_cmp(&off(b)));
        self.fall = before.map(|before| Fall {
            from: Standing::of(before, state.scene.control()),
            began: None,
            is_down: false,
        });
    }

    /// The share of the way that the ball is down, 0 to 1, while it rolls.
    fn roll(&mut self, ui: &Ui) -> Option<f64> {
        let fall = self.fall.as_mut()?;
        if fall.is_down {
            return Some(1.0);
        }
        let is_of_it = |(of, _): &(Standing, _)| *of == fall.from;
        if !(self.told && self.job.as_ref().is_some_and(is_of_it)) {
            return Some(0.0);
        }
        ui.ctx().request_repaint_after(Duration::from_millis(16));
        let now = ui.input(|input| input.time);
        let share = (now - *fall.began.get_or_insert(now)) / FALL;
        fall.is_down |= share >= 1.0;
        Some(share.min(1.0).powi(2))
    }

    /// What holds the surface, in one line.
    fn words(&self, state: &ViewState) -> String {
        let Some(shown) = &self.shown else {
            let job = self.job.as_ref();
            let why = job.and_then(|(_, job)| job.failed.clone());
            return why
                .unwrap_or_else(|| "The branches come first: saddles are on them.".to_owned());
        };
        let model = &state.model;
        let branches = state.plots.branches.as_ref();
        let complete = branches.is_some_and(|branches| branches.is_complete());
        let mut words = match shown.passes.first() {
            _ if self.fall.is_some() => "The barrier is gone.".to_owned(),
            Some(pass) => {
                let gamma = format!("{:.2e} γL²", pass.barrier() / model.law.surface_energy);
                match (model.units, model.in_kt(pass.barrier())) {
                    (Some(units), Some(kt)) => format!(
                        "The lowest barrier is {} kT, to {} ({gamma}, T = {} K)",
                        significant(kt),
                        pass.to,
                        units.temperature
                    ),
                    _ => format!("The lowest barrier is {gamma}, to {}", pass.to),
                }
            }
            None if complete => "No saddle: no other state is within reach.".to_owned(),
            None => "No saddle is known here: not every branch was followed.".to_owned(),
        };
        for missing in &shown.missing {
            words.push_str(&format!("; missing: {missing}"));
        }
        words
    }

    /// Pictures the place under the pointer, and what was pictured before when it is left.
    fn picture(&mut self, state: &mut ViewState) {
        let place = self.pointed.and_then(|[pass, place]| {
            let pass = self.shown.as_ref()?.passes.get(pass)?;
            pass.path.get(place)
        });
        // What came in the meantime stays.
        let now = state.frame.clone();
        self.pictured
            .take_if(|[shown, _]| now.as_ref().is_none_or(|now| !Arc::ptr_eq(now, shown)));
        let Some(place) = place else {
            if let Some([_, before]) = self.pictured.take() {
                state.frame = Some(before);
            }
            return;
        };
        let before = match &self.pictured {
            Some([_, before]) => before.clone(),
            None => match now {
                Some(now) if !now.relaxing => now,
                _ => return,
            },
        };
        let at = [place.mean_displacement, place.stress];
        let shown = Frame::of_a_branch(before.control, at, place.gap.clone());
        let shown = Arc::new(shown);
        state.frame = Some(shown.clone());
        self.pictured = Some([shown, before]);
    }
}

/// The surface as a ball: at the foot of the paths, or a share of the way `down` the lowest.
fn ball(landscape: &Landscape, law: &Law, down: Option<f64>) -> [Series; 2] {
    let place = landscape.passes.first().and_then(|pass| {
        let Some(share) = down else {
            return pass.path.first().map(|foot| at(foot, pass, law));
        };
        let below = &pass.path[pass.saddle..];
        let (top, end) = (below.first()?.arc, below.last()?.arc);
        let further = below.partition_point(|place| place.arc < top + share * (end - top));
        below.get(further).map(|place| at(place, pass, law))
    });
    Series::here(place)
}

/// The pass and the place of its path that are nearest to the pointer.
fn pointed(drawn: &PlotResponse<()>, landscape: &Landscape, law: &Law) -> Option<[usize; 2]> {
    let passes = landscape.passes.iter().enumerate();
    let places = passes.flat_map(|(i, pass)| {
        let places = pass.path.iter().enumerate();
        places.map(move |(j, place)| ([i, j], at(place, pass, law)))
    });
    diagram::nearest(drawn, NEAR, places)
}
