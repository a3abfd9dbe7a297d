//! The application: takes in what the solver says, draws the panels, and acts on what they ask for.

use super::action::{Action, FileTask, ViewOptions};
use super::dialogs::{Dialogs, FileRequest, PathFuture, desktop_chooser};
use super::gap_map::MapCache;
use super::tabs::Tabs;
use super::view_state::{Begin, ViewState};
use super::{keys, layout, lecture, loop_plot};
use crate::lessons::Progress;
use crate::physics::topography::Topography;
use crate::plot::loop_panel;
use crate::plot::panel::Page;
use crate::scene::{Model, Scene, edit};
use crate::storage::{self, Opened, drawing, export, picture, presets, scene_file};
use crate::worker::SolverHandle;
use crate::worker::job::Job;
use crate::worker::protocol::{Command, Envelope};
use egui::containers::PanelState;
use egui::{Context, Ui};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Seconds between two announcements of a jump to a screen reader.
const ANNOUNCE_EVERY: f64 = 2.0;

/// The window's application.
pub struct App {
    state: ViewState,
    solver: Box<dyn SolverHandle>,
    map: MapCache,
    tabs: Tabs,
    dialogs: Dialogs,
    /// When a jump was last announced (seconds).
    announced: f64,
    /// The file that is being opened.
    opening: Option<(PathBuf, Opening)>,
    /// How the window looked before lecture mode.
    before_lecture: Option<lecture::Before>,
}

/// What is kept between two sittings.
#[derive(Default, Serialize, Deserialize)]
#[serde(default)]
struct Sitting {
    lesson: Option<Progress>,
    before_lecture: Option<lecture::Before>,
}

/// Under which name.
const SITTING: &str = "sitting";

/// The reading of a file, which may take as long as the file system likes.
type Opening = Job<Result<Found, storage::Failure>>;

/// What a file makes of the scene.
enum Found {
    /// Another one.
    Scene(Scene),
    /// The present one on measured ground, and what to know of it.
    Ground(Scene, String),
}

/// What to do where a file was refused.
const OTHER_PATH: &str = "Choose another path, or mend the file.";

impl App {
    /// A window on this state, worked by this solver.
    pub fn new(solver: impl SolverHandle + 'static, state: ViewState) -> Self {
        Self::with_chooser(solver, state, desktop_chooser)
    }

    /// Like [`App::new`], with another way of choosing files.
    pub fn with_chooser(
        solver: impl SolverHandle + 'static,
        state: ViewState,
        chooser: impl FnMut(FileRequest) -> PathFuture + 'static,
    ) -> Self {
        Self {
            state,
            solver: Box::new(solver),
            map: MapCache::default(),
            tabs: Tabs::default(),
            dialogs: Dialogs::new(chooser),
            announced: f64::NEG_INFINITY,
            opening: None,
            before_lecture: None,
        }
    }

    /// Takes up what was kept of the last sitting: the lesson goes on, and the look is that before
    /// a lecture.
    pub fn resume(&mut self, ctx: &Context, storage: &dyn eframe::Storage) {
        let kept = storage.get_string(SITTING).unwrap_or_default();
        let Sitting {
            lesson,
            before_lecture,
        } = serde_json::from_str(&kept).unwrap_or_default();
        if let Some(before) = before_lecture {
            before.restore(ctx);
        }
        if let Some(progress) = lesson {
            let begin = self.state.resume_lesson(progress);
            self.begin_step(begin);
        }
    }

    /// What is shown.
    pub fn state(&self) -> &ViewState {
        &self.state
    }

    /// One frame.
    pub fn frame(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        self.listen();
        self.state.observe_lesson();
        self.open();
        self.tabs.update(&mut self.state, &*self.solver);
        self.map.update(&ctx, &self.state);
        let mut actions = Vec::new();
        keys::collect(&ctx, &self.state, self.dialogs.is_open(), &mut actions);
        let dropped = ctx.input(|input| input.raw.dropped_files.clone());
        let dropped = dropped.into_iter().map(|file| file.path().to_owned());
        actions.extend(dropped.take(1).map(Action::Open));
        self.announce(&ctx);
        self.panels(ui, &mut actions);
        self.tabs.float(&ctx, &self.state, &mut actions);
        self.dialogs
            .show(&ctx, &self.state, &self.tabs, &mut actions);
        // The panels above were drawn before this; draw them once more with what follows.
        if !actions.is_empty() {
            ctx.request_repaint();
        }
        for action in actions {
            self.act(&ctx, action);
        }
        if !ctx.input(|input| input.pointer.any_down()) {
            self.state.history.end_gesture();
        }
        for command in self.state.take_commands() {
            self.solver.send(command);
        }
    }

    fn listen(&mut self) {
        for event in self.solver.poll() {
            self.state.apply(event);
        }
    }

    /// Takes in the file that was being opened, if it is there.
    fn open(&mut self) {
        let Some(end) = self.opening.as_mut().and_then(|(_, job)| job.poll()) else {
            return;
        };
        let Some((path, mut job)) = self.opening.take() else {
            return;
        };
        let messages = &mut self.state.messages;
        match (job.so_far.take(), end) {
            (Some(Ok(found)), _) => {
                self.dialogs.close();
                let mut notice = format!("{} opened", path.display());
                match found {
                    Found::Scene(scene) => self.state.open_scene(scene),
                    Found::Ground(scene, words) => {
                        notice = words;
                        self.state.edit_scene(scene);
                    }
                }
                let messages = &mut self.state.messages;
                if messages.failure.is_none() {
                    messages.notice = Some(notice);
                }
            }
            (Some(Err(failure)), _) => {
                messages.notice = None;
                messages.fail(failure, OTHER_PATH);
            }
            (None, end) => {
                let (path, why) = (path.display(), end.err().unwrap_or_default());
                let message = format!("{path} could not be read: {why}");
                messages.fail(message, "Please report the file.");
            }
        }
    }

    fn announce(&mut self, ctx: &Context) {
        let now = ctx.input(|input| input.time);
        let words = self
            .state
            .run
            .record
            .jumps
            .last()
            .map(|jump| self.state.say_jump(jump))
            .unwrap_or_default();
        let told = &mut self.state.messages.announced;
        if words != *told && now - self.announced >= ANNOUNCE_EVERY {
            (*told, self.announced) = (words, now);
        }
    }

    fn panels(&mut self, ui: &mut Ui, actions: &mut Vec<Action>) {
        let (state, map) = (&self.state, &self.map);
        if state.view.lecture {
            lecture::show(ui, state, map, actions);
        } else {
            layout::show(ui, state, map, &mut self.tabs, actions);
        }
    }

    fn act(&mut self, ctx: &Context, action: Action) {
        let state = &mut self.state;
        match action {
            Action::SetTarget(u0) => state.set_target(u0),
            Action::Step(increments) => state.step(increments),
            Action::Increment => state.increment(),
            Action::Reverse => state.reverse(),
            Action::Play(sweep) => state.play(sweep),
            Action::TogglePlay => state.toggle_play(),
            Action::Pause(paused) => state.run.paused = paused,
            Action::Stop => state.stop(),
            Action::Reset => state.reset(),
            Action::EditScene(scene) => state.edit_scene(*scene),
            Action::SetMethod(method) => state.set_method(method),
            Action::SetStrategy(asked) => state.set_strategy(asked),
            Action::SetFollows(follows) => state.follows = follows,
            Action::LoadPreset(index) => self.load_preset(presets::all().get(index)),
            Action::Undo => state.undo(),
            Action::Redo => state.redo(),
            Action::AskFile(task) => self.dialogs.ask(task),
            Action::UsePath(path) => self.use_path(ctx, &path),
            Action::Open(path) => self.begin_to_open(ctx, &path),
            Action::CloseDialog => {
                self.opening = None;
                self.dialogs.close();
            }
            Action::ToggleCommands => self.dialogs.toggle_commands(ctx),
            Action::ToggleHelp => self.dialogs.help = !self.dialogs.help,
            Action::ToggleTheme => {
                let dark = ctx.theme() == egui::Theme::Dark;
                ctx.set_theme(if dark {
                    egui::Theme::Light
                } else {
                    egui::Theme::Dark
                });
            }
            Action::SystemTheme => ctx.set_theme(egui::ThemePreference::System),
            Action::FitData => state.fit_axes(),
            Action::FitScene => state.plots.fit = None,
            Action::SetView(view) => state.view = view,
            Action::CommandTab { tab, index } => self.tabs.command(tab, index),
            Action::OpenTab(name) => {
                state.view.tab = self.tabs.index(name).unwrap_or(state.view.tab);
            }
            Action::OverlayTheory(overlay) => state.plots.overlay = overlay,
            Action::SelectState { at, reach } => state.select_near(at, reach),
            Action::SelectOn(direction, control) => state.select_on(direction, control),
            Action::StepState(by) => state.step_state(by),
            Action::GoOn => state.go_on(),
            Action::SelectJump(index) => state.select_jump(index),
            Action::StepJump(by) => state.step_jump(by),
            Action::ToggleKept => state.toggle_kept(),
            Action::ClearSelection => state.select_nothing(),
            Action::CopyScene => {
                ctx.copy_text(scene_file::to_text(&state.scene));
                state.messages.notice =
                    Some("scene copied as text: paste it here, or into a mail".to_owned());
            }
            Action::CopyPicture => self.copy_picture(ctx),
            Action::CopyText(text) => {
                ctx.copy_text(text);
                state.messages.notice = Some("copied as text".to_owned());
            }
            Action::PasteScene(text) => match scene_file::received("clipboard", text.as_bytes()) {
                Ok(scene) => state.open_scene(scene),
                Err(failure) => state
                    .messages
                    .fail(failure, "Copy a whole scene file, from format = 1 on."),
            },
            Action::Lesson(act) => {
                let begin = state.act_in_lesson(act);
                self.begin_step(begin);
            }
            Action::Guess(u0) => state.plots.guess(u0),
            Action::ToggleLecture => self.toggle_lecture(ctx),
            Action::RestoreLayout => {
                ctx.data_mut(egui::util::IdTypeMap::remove_by_type::<PanelState>);
                state.view = ViewOptions {
                    lecture: state.view.lecture,
                    ..ViewOptions::default()
                };
                state.plots.fit = None;
                self.tabs.restore();
            }
            Action::DropNotice => state.messages.notice = None,
            Action::DismissFailure => state.messages.failure = None,
            Action::Quit => ctx.send_viewport_cmd(egui::ViewportCommand::Close),
        }
    }

    fn copy_picture(&mut self, ctx: &Context) {
        let drawn = drawing::page_image(&page(&self.state));
        let messages = &mut self.state.messages;
        match drawn {
            Ok(image) => {
                let size = [image.width() as usize, image.height() as usize];
                ctx.copy_image(egui::ColorImage::from_rgb(size, &image));
                messages.notice = Some("picture of the stress curve copied".to_owned());
            }
            Err(why) => messages.fail(why, "Export it as PNG instead."),
        }
    }

    /// Opens what a step of a lesson begins with.
    fn begin_step(&mut self, begin: Begin) {
        self.load_preset(begin.scene.and_then(presets::find));
        let tab = begin.tab.and_then(|name| self.tabs.index(name));
        self.state.view.tab = tab.unwrap_or(self.state.view.tab);
    }

    fn toggle_lecture(&mut self, ctx: &Context) {
        self.state.view.lecture = !self.state.view.lecture;
        match self.before_lecture.take() {
            Some(before) => before.restore(ctx),
            None => self.before_lecture = Some(lecture::Before::enlarge(ctx)),
        }
    }

    fn load_preset(&mut self, preset: Option<&presets::Preset>) {
        let Some(preset) = preset else { return };
        match scene_file::parse(preset.text, preset.name) {
            Ok(scene) => self.state.open_scene(scene),
            Err(failure) => {
                let remedy = "This preset is broken; choose another one.";
                self.state.messages.fail(failure, remedy);
            }
        }
    }

    fn begin_to_open(&mut self, ctx: &Context, path: &Path) {
        let (file, ctx) = (path.to_owned(), ctx.clone());
        let (scene, model) = (self.state.scene.clone(), self.state.model.clone());
        let opening = Job::start(Arc::new(move || ctx.request_repaint()), move |report| {
            report.result(storage::open(&file).and_then(|opened| match opened {
                Opened::Scene(scene) => Ok(Found::Scene(scene)),
                Opened::Heights(map) => ground(&scene, &model, map),
            }));
            Ok(())
        });
        self.opening = Some((path.to_owned(), opening));
        self.state.messages.notice = Some(format!("opening {} …", path.display()));
    }

    /// Does what the open dialog was opened for. It stays open if that fails, so that the path can
    /// be mended.
    fn use_path(&mut self, ctx: &Context, path: &Path) {
        let Some(task) = self.dialogs.task() else {
            return;
        };
        let state = &self.state;
        let done = match task {
            FileTask::OpenScene | FileTask::OpenHeights => return self.begin_to_open(ctx, path),
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
            FileTask::ExportLoopPng => drawing::write_page_png(path, &page(state))
                .and_then(|()| picture::attach_scene(path, &state.scene)),
            FileTask::ExportGapPng => match state.pictured() {
                Some(frame) => picture::write_gap_png(path, &frame.gap)
                    .and_then(|()| picture::attach_scene(path, &state.scene)),
                None => return,
            },
        };
        match done {
            Ok(()) => {
                self.dialogs.close();
                self.state.messages.failure = None;
                self.state.messages.notice = Some(format!("{} written", path.display()));
            }
            Err(failure) => self.state.messages.fail(failure, OTHER_PATH),
        }
    }
}

/// The picture of the stress curve.
fn page(state: &ViewState) -> Page<'static> {
    let ledger = state.run.record.ledger(state.model.law.surface_energy);
    let error = ledger.stated_error(state.predicted_error());
    loop_panel::page(&state.run.record, &state.model, &state.scene.title, error)
}

/// The scene on the ground of this map.
fn ground(scene: &Scene, model: &Model, map: Topography) -> Result<Found, storage::Failure> {
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
    Ok(Found::Ground(scene, words))
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut Ui, _frame: &mut eframe::Frame) {
        self.frame(ui);
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        let sitting = Sitting {
            lesson: self.state.lesson.clone(),
            before_lecture: self.before_lecture,
        };
        if let Ok(text) = serde_json::to_string(&sitting) {
            storage.set_string(SITTING, text);
        }
    }

    fn on_exit(&mut self, _gl: Option<&eframe::glow::Context>) {
        self.solver.send(Envelope {
            run: self.state.run.id,
            message: Command::Quit,
        });
    }
}
