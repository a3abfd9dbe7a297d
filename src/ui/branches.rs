//! Every branch of the scene, stable and unstable: a click shows the state at that point in map and
//! profile.

use super::action::Action;
use super::diagram;
use super::view_state::{Shown, ViewState};
use super::widgets::{described, progress};
use crate::plot::diagram_panel::{counts, place};
use crate::plot::panel::{Colour, Series, Symbol};
use egui::{RichText, Ui};

/// A click this near to a point means it, in screen points.
const NEAR: f32 = 14.0;

/// The tab.
pub fn show(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let branches = &state.branches;
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        match (&branches.job, &branches.missing, &branches.shown) {
            (Some(job), ..) if job.is_running() => {
                progress(ui, job, Action::StopBranches, actions);
                ui.add(egui::Label::new(RichText::new(&job.doing).small()).truncate());
            }
            (_, Some(why), _) => {
                ui.label(why);
            }
            (_, _, Some(shown)) => {
                let at = branches.at.and_then(|at| shown.words(at));
                let mut words = at.unwrap_or_else(|| counts(&shown.diagram));
                for missing in &shown.diagram.missing {
                    words.push_str(&format!("; missing: {missing}"));
                }
                ui.add(egui::Label::new(RichText::new(words).small()).truncate());
            }
            _ => {}
        }
    });
    let Some(shown) = &branches.shown else {
        ui.label(RichText::new("Every state of equilibrium, stable or not.").weak());
        return;
    };
    let mut panel = shown.panel.clone();
    panel.x.label = "u₀ / ρ".to_owned();
    panel.y.label = "stress / σ_max".to_owned();
    if let Some(now) = &state.run.state {
        let at = vec![[now.mean_displacement / state.rho(), now.stress_over_max]];
        let here = |symbol| Series::symbols("", symbol, Colour::Ink, at.clone());
        panel
            .series
            .extend([here(Symbol::Ring), here(Symbol::Circle).filled()]);
    }
    let seen = branches.at.and_then(|[i, j]| {
        let state = &shown.diagram.branches.get(i)?.points.get(j)?.state;
        Some(place(state.mean_displacement, state.stress, &shown.law))
    });
    let frame = Series::symbols("", Symbol::Frame, Colour::Ink, seen.into_iter().collect());
    panel.series.push(frame);
    let height = ui.available_height().max(80.0);
    let drawn = diagram::show(ui, &panel, "branches", height, |_, _| None);
    let (response, transform) = (drawn.response, drawn.transform);
    let nearest = response.hover_pos().and_then(|pointer| {
        let near = |at: [f64; 2]| {
            let place = transform.position_from_point(&egui_plot::PlotPoint::new(at[0], at[1]));
            place.distance(pointer)
        };
        points(shown)
            .map(|(which, at)| (which, near(at)))
            .filter(|(_, distance)| *distance <= NEAR)
            .min_by(|a, b| a.1.total_cmp(&b.1))
    });
    if let Some((which, _)) = nearest {
        ui.ctx().set_cursor_icon(egui::CursorIcon::PointingHand);
        if response.clicked() {
            actions.push(Action::ShowBranchPoint(which));
        }
    }
    let sentence = format!("Every branch of equilibria: {}", counts(&shown.diagram));
    described(&response, &sentence);
}

/// Every point with its branch and place, and where it is drawn.
fn points(shown: &Shown) -> impl Iterator<Item = ([usize; 2], [f64; 2])> + '_ {
    let law = &shown.law;
    shown
        .diagram
        .branches
        .iter()
        .enumerate()
        .flat_map(move |(i, branch)| {
            branch.points.iter().enumerate().map(move |(j, point)| {
                let (u0, stress) = (point.state.mean_displacement, point.state.stress);
                ([i, j], place(u0, stress, law))
            })
        })
}
