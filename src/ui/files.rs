//! Files read and written beside the window: what the dialog of files was opened for, what is dropped
//! on the window, and the film of the path, with how far it is and a button that gives it up.

use super::action::FileTask;
use super::dialogs::Dialogs;
use super::gap_picture;
use super::loop_plot;
use super::tabs::Tabs;
use super::view_state::{Extent, Saved, ViewState};
use super::widgets::progress;
use crate::physics::pattern::rolled;
use crate::physics::topography::Topography;
use crate::plot::loop_panel;
use crate::plot::panel::Page;
use crate::plot::scale;
use crate::scene::{Model, Scene, edit};
use crate::storage::picture::{FilmKind, Shot, write_film};
use crate::storage::session::{self, Session};
use crate::storage::{self, Failure, Opened, drawing, export, picture, scene_file};
use crate::worker::job::Job;
use crate::worker::protocol::Stored;
use egui::{Align2, Context, Window};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Work with a file, which may take as long as the file system likes.
type FileJob = Job<Result<Done, Failure>>;

/// What came of it.
enum Done {
    /// Another scene.
    Scene(Scene),
    /// A scene with what was computed of it.
    Session(Box<Session<Saved>>),
    /// The present scene on measured ground, and what to know of it.
    Ground(Scene, String),
    /// The file is written.
    Written,
}

/// What to do where a file was refused.
const OTHER_PATH: &str = "Choose another path, or mend the file.";

impl Done {
    /// Shows it, and says so unless it was refused.
    fn show(self, state: &mut ViewState, path: &Path) {
        let file = path.display();
        state.messages.failure = None;
        let notice = match self {
            Done::Scene(scene) => {
                state.open_scene(scene);
                format!("{file} opened")
            }
            Done::Session(session) => {
                let states = session.window.states();
                if let Err(why) = state.reopen(*session) {
                    state.messages.fail(format!("{file}: {why}"), OTHER_PATH);
                }
                let notes = state.notes.lines().next().unwrap_or_default();
                format!("{file} opened, with {states} states. {notes}")
            }
            Done::Ground(scene, words) => {
                state.edit_scene(scene);
                words
            }
            Done::Written => format!("{file} written"),
        };
        if state.messages.failure.is_none() {
            state.messages.notice = Some(notice);
        }
    }
}

/// What is read and written.
#[derive(Default)]
pub struct Files {
    /// The file that is being read or written.
    job: Option<(PathBuf, FileJob)>,
    /// The film that is being written.
    film: Option<FilmExport>,
}

impl Files {
    /// Takes in what came of the file that was being read or written, if it is there.
    pub fn take_in(&mut self, state: &mut ViewState, dialogs: &mut Dialogs) {
        let Some(end) = self.job.as_mut().and_then(|(_, job)| job.poll()) else {
            return;
        };
        let Some((path, mut job)) = self.job.take() else {
            return;
        };
        state.messages.notice = None;
        match (job.so_far.take(), end) {
            (Some(Ok(done)), _) => {
                dialogs.close();
                done.show(state, &path);
            }
            (Some(Err(failure)), _) => state.messages.fail(failure, OTHER_PATH),
            (None, end) => {
                let (path, why) = (path.display(), end.err().unwrap_or_default());
                let message = format!("{path}: {why}");
                state.messages.fail(message, "Please report the file.");
            }
        }
    }

    /// Shows how far a film is that is being written.
    pub fn show(&mut self, ctx: &Context, state: &mut ViewState) {
        self.film.take_if(|film| !film.show(ctx, state));
    }

    /// Gives the file up, but no film.
    pub fn drop_job(&mut self) {
        self.job = None;
    }

    /// Begins to work with a file.
    fn begin(
        &mut self,
        ctx: &Context,
        state: &mut ViewState,
        (path, doing): (&Path, &str),
        work: impl FnOnce(&Path) -> Result<Done, Failure> + Send + 'static,
    ) {
        let (file, ctx) = (path.to_owned(), ctx.clone());
        let job = Job::start(Arc::new(move || ctx.request_repaint()), move |report| {
            report.result(work(&file));
            Ok(())
        });
        self.job = Some((path.to_owned(), job));
        state.messages.notice = Some(format!("{doing} {} …", path.display()));
    }

    /// Begins to open the scene, the session or the heights of this file.
    pub fn open(&mut self, ctx: &Context, state: &mut ViewState, path: &Path) {
        let (scene, model) = (state.scene.clone(), state.model.clone());
        self.begin(
            ctx,
            state,
            (path, "opening"),
            move |file| match storage::open(file)? {
                Opened::Scene(scene) => Ok(Done::Scene(scene)),
                Opened::Session(bytes) => {
                    session::of_bytes(file, &bytes).map(|session| Done::Session(Box::new(session)))
                }
                Opened::Heights(map) => ground(&scene, &model, map),
            },
        );
    }

    fn save(&mut self, ctx: &Context, state: &mut ViewState, path: &Path) {
        let session = state.session(Extent::Whole);
        self.begin(ctx, state, (path, "writing"), move |file| {
            session::save(file, &session, session.window.record()).map(|()| Done::Written)
        });
    }

    /// Does what the open dialog was opened for. It stays open if that fails, so that the path can
    /// be mended.
    pub fn use_path(
        &mut self,
        ctx: &Context,
        state: &mut ViewState,
        (dialogs, tabs): (&mut Dialogs, &Tabs),
        path: &Path,
    ) {
        let Some(task) = dialogs.task() else {
            return;
        };
        let done = match task {
            FileTask::OpenScene | FileTask::OpenHeights => return self.open(ctx, state, path),
            FileTask::SaveSession => return self.save(ctx, state, path),
            FileTask::ExportFilm(kind) => {
                self.film = FilmExport::begin(ctx, state, path, kind);
                return dialogs.close();
            }
            FileTask::SaveScene => scene_file::save(path, &state.scene),
            FileTask::ExportLoopCsv => {
                export::write_loop_csv(path, &state.scene, &state.run.record.states)
            }
            FileTask::ExportEventsCsv => {
                export::write_events_csv(path, &state.scene, &state.run.record.jumps)
            }
            FileTask::ExportCurvesCsv => {
                let panel = loop_plot::panel(state);
                export::write_panels_csv(path, &state.scene.title, &[panel])
            }
            FileTask::ExportTabCsv => {
                let (tab, panels) = tabs.panels(state);
                if panels.is_empty() {
                    let message = format!("the tab {tab} has no curves to write");
                    let remedy = "Choose a tab with a diagram, or wait until it is computed.";
                    return state.messages.fail(message, remedy);
                }
                let title = format!("{}: {tab}", state.scene.title);
                export::write_panels_csv(path, &title, &panels)
            }
            FileTask::ExportLoopPng => {
                drawing::write_page_png(path, &page(state)).and_then(|()| attach(path, state))
            }
            FileTask::ExportLoopSvg => drawing::write_page_svg(path, &page(state)),
            FileTask::ExportGapPng => match state.pictured() {
                Some(frame) => picture::write_gap_png(path, &frame.gap, state.view.colours)
                    .and_then(|()| attach(path, state)),
                None => return,
            },
        };
        match done {
            Ok(()) => {
                dialogs.close();
                Done::Written.show(state, path);
            }
            Err(failure) => state.messages.fail(failure, OTHER_PATH),
        }
    }
}

/// The picture of the stress curve.
pub fn page(state: &ViewState) -> Page<'static> {
    let ledger = state.run.record.ledger(state.model.law.surface_energy);
    let error = ledger.stated_error(state.predicted_error());
    loop_panel::page(&state.run.record, &state.model, &state.scene.title, error)
}

/// Puts scene and state into a picture, so that it opens again as what it shows.
fn attach(path: &Path, state: &ViewState) -> Result<(), Failure> {
    let session = state.session(Extent::Present);
    let bytes = session::to_bytes(&session, session.window.record()).ok();
    picture::attach(path, &session.scene, bytes.as_deref())
}

/// The scene on the ground of this map.
fn ground(scene: &Scene, model: &Model, map: Topography) -> Result<Done, Failure> {
    let file = map.file.display().to_string();
    let (told, [ny, nx]) = (
        map.size.is_some(),
        [map.heights.nrows(), map.heights.ncols()],
    );
    let scene = edit::with_heights(scene, model, map);
    scene
        .model()
        .map_err(|error| scene_file::refused(&file, error))?;
    let side = if told {
        "its side is that of the file"
    } else {
        "the file does not say how large it is: it fills the cell; see Measured side"
    };
    let words = format!("measured ground, {nx} x {ny} points ({file}): {side}");
    Ok(Done::Ground(scene, words))
}

/// Most pictures of a film; of more an even choice is shown.
const MOST: usize = 300;

/// A film that is being written.
struct FilmExport {
    path: PathBuf,
    job: Job<Result<(), Failure>>,
}

impl FilmExport {
    /// Begins to write the stored states of the path; `None` where there are none.
    fn begin(ctx: &Context, state: &ViewState, path: &Path, kind: FilmKind) -> Option<Self> {
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
        let (view, model, (low, high)) = (state.view, state.model.clone(), state.limits);
        let contact = model.law.contact_gap();
        let (file, ctx) = (path.to_owned(), ctx.clone());
        let job = Job::start(Arc::new(move || ctx.request_repaint()), move |report| {
            let count = shown.len();
            let mut island = None;
            let shots = shown.iter().map(|stored| {
                let frame = stored.frame();
                let this = gap_picture::island(&frame, contact, island);
                island = Some(this);
                let (dy, dx) = gap_picture::roll(&view, &model, &frame.gap, this);
                let gap = rolled(&frame.gap, dy, dx);
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
    fn show(&mut self, ctx: &Context, state: &mut ViewState) -> bool {
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
