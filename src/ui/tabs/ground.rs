//! The ground before anything runs: its map, how its heights are distributed, its power spectrum,
//! and its root mean squares.

use super::{Tab, Title, Update, small, under_way};
use crate::plot::diagram_panel::{distribution_panel, map_panel, numbers, spectrum_panel};
use crate::plot::panel::Panel;
use crate::scene::Scene;
use crate::study::ground::GroundReport;
use crate::ui::action::Action;
use crate::ui::gap_picture;
use crate::ui::view_state::ViewState;
use crate::ui::widgets::described;
use crate::worker::job::{Job, Reporter};
use egui::{RichText, TextureHandle, TextureOptions, Ui, Vec2, vec2};
use std::sync::Arc;

/// Share of the width and of the height that the map may take.
const MAP: f32 = 0.45;

/// The tab.
#[derive(Default)]
pub struct GroundTab {
    /// The look, and at which scene.
    job: Option<(Arc<Scene>, Job<GroundReport>)>,
    /// What was seen, and its map once it was drawn.
    shown: Option<(GroundReport, Option<TextureHandle>)>,
}

impl Tab for GroundTab {
    fn title(&self) -> Title {
        let what = "the ground: map, heights, spectrum, and what was done to a height file";
        Title::tall("Ground", what)
    }

    fn show(&mut self, ui: &mut Ui, _: &ViewState, _: &mut Vec<Action>) {
        // No empty row where there is nothing to tell.
        let telling = |(_, job): &&(_, Job<_>)| job.is_running() || job.failed.is_some();
        if let Some((_, job)) = self.job.as_ref().filter(telling) {
            ui.horizontal_wrapped(|ui| under_way(ui, job));
        }
        let Some((report, texture)) = &mut self.shown else {
            return;
        };
        let told = numbers("On the mesh", &report.cell, report.unit);
        ui.label(RichText::new(&told).strong());
        for words in &report.words {
            ui.small(words);
        }
        let size = ui.available_size();
        let side = MAP * size.x.min(size.y);
        ui.horizontal_top(|ui| {
            if report.grid.is_line() {
                let x = format!("x ({})", report.length());
                panel(ui, map_panel(report), &x, vec2(side, side));
            } else {
                let texture = texture.get_or_insert_with(|| {
                    let image = gap_picture::heights(&report.height);
                    ui.ctx()
                        .load_texture("ground", image, TextureOptions::NEAREST)
                });
                let image = egui::Image::new((texture.id(), vec2(side, side)));
                described(&ui.add(image), &format!("Map of the ground. {told}"));
            }
            let beside = vec2(size.x - side - 12.0, side);
            let height = format!("height ({})", report.length());
            panel(ui, distribution_panel(report), &height, beside);
        });
        let rest = vec2(size.x, ui.available_height() - 4.0);
        let wave = format!("wave number q (1/{})", report.length());
        panel(ui, spectrum_panel(report), &wave, rest);
    }

    fn panels(&self, _: &ViewState) -> Vec<Panel> {
        let shown = self.shown.as_ref();
        shown.map_or(Vec::new(), |(report, _)| {
            vec![distribution_panel(report), spectrum_panel(report)]
        })
    }

    fn update(
        &mut self,
        Update {
            state,
            solver,
            seen,
        }: Update<'_>,
    ) {
        if let Some((_, job)) = &mut self.job {
            job.poll();
            self.shown.take_if(|_| job.failed.is_some());
            if let Some(report) = job.so_far.take() {
                self.shown = Some((report, None));
            }
        }
        let stale = self.job.as_ref();
        let stale = stale.is_none_or(|(of, _)| !Arc::ptr_eq(of, &state.scene));
        if seen && stale {
            self.job = Some((
                state.scene.clone(),
                solver.job(state.scene.clone(), compute),
            ));
        }
    }
}

fn compute(scene: &Arc<Scene>, report: &Reporter<GroundReport>) -> Result<(), String> {
    let model = scene.model().map_err(|error| error.to_string())?;
    let found = GroundReport::of(&model.indenter, &model.grid, Some(&model.law));
    let found =
        found.ok_or("Flat ground: choose another one on the left, or drop a height file.")?;
    report.result(found.in_units(scene.units));
    Ok(())
}

/// A small diagram under its title, which says what its y is; `x` in so few words.
fn panel(ui: &mut Ui, mut panel: Panel, x: &str, size: Vec2) {
    x.clone_into(&mut panel.x.label);
    panel.y.label.clear();
    described(
        &small(ui, &panel, &panel.title, size).response,
        &panel.title,
    );
}
