//! The film of the path, written beside the window: how far it is, and a button that gives it up.

use super::gap_picture::{self, GapPicture};
use super::view_state::ViewState;
use super::widgets::progress;
use crate::physics::indenter::Indenter;
use crate::plot::scale;
use crate::storage::Failure;
use crate::storage::film::{FilmKind, Shot, write_film};
use crate::worker::job::Job;
use crate::worker::protocol::Stored;
use egui::{Align2, Context, Window};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Most pictures of a film; of more an even choice is shown.
const MOST: usize = 300;

/// A film that is being written.
pub struct FilmExport {
    path: PathBuf,
    job: Job<Result<(), Failure>>,
}

impl FilmExport {
    /// Begins to write the stored states of the path; `None` where there are none.
    pub fn begin(ctx: &Context, state: &ViewState, path: &Path, kind: FilmKind) -> Option<Self> {
        let all: Vec<Arc<Stored>> = state.run.store.all().cloned().collect();
        let every = all.len().div_ceil(MOST).max(1);
        let shown: Vec<Arc<Stored>> = all.into_iter().step_by(every).collect();
        if shown.is_empty() {
            return None;
        }
        let look = (
            scale::gap_scale(&state.scene, &state.model),
            state.view.colours,
        );
        let centred = state.view.centred && state.model.indenter == Indenter::Flat;
        let (contact, (low, high)) = (state.model.law.contact_gap(), state.limits);
        let (file, ctx) = (path.to_owned(), ctx.clone());
        let job = Job::start(Arc::new(move || ctx.request_repaint()), move |report| {
            let count = shown.len();
            let mut island = None;
            let shots = shown.iter().map(|stored| {
                let frame = stored.frame();
                let this = gap_picture::island(&frame, contact, island);
                island = Some(this);
                let gap = if centred {
                    GapPicture::centred(&frame.gap, contact, this).gap
                } else {
                    (*frame.gap).clone()
                };
                let place = (stored.record.control - low) / (high - low);
                Shot { gap, place }
            });
            let mut goes_on = |share: f64| {
                if report.is_due() {
                    report.progress(share, "film");
                }
                !report.cancel.requested()
            };
            report.result(write_film(&file, kind, (shots, count), look, &mut goes_on));
            Ok(())
        });
        let path = path.to_owned();
        Some(Self { path, job })
    }

    /// Shows how far it is; false once it has ended, of which `state` then tells.
    pub fn show(&mut self, ctx: &Context, state: &mut ViewState) -> bool {
        let end = self.job.poll();
        let path = self.path.display();
        let gave_up = !self.job.is_running() && end.is_none();
        match (self.job.so_far.take(), end) {
            _ if gave_up => state.messages.notice = Some("the film was given up".to_owned()),
            (Some(Ok(())), _) => state.messages.notice = Some(format!("{path} written")),
            (Some(Err(failure)), _) => {
                state.messages.fail(failure, "Choose another path.");
            }
            (None, Some(Err(why))) => {
                let words = format!("{path} could not be written: {why}");
                state.messages.fail(words, "Please report it.");
            }
            (None, _) => {
                Window::new("Film")
                    .title_bar(false)
                    .resizable(false)
                    .anchor(Align2::CENTER_TOP, [0.0, 60.0])
                    .show(ctx, |ui| {
                        ui.horizontal(|ui| {
                            ui.label("Writing the film");
                            progress(ui, &self.job);
                        });
                    });
                return true;
            }
        }
        false
    }
}
