//! The application: takes in what the solver says, draws the panels, and acts on what they ask for.

use super::action::{Action, FileTask, ViewOptions};
use super::clicks::{self, Clicks, Player};
use super::dialogs::{Dialogs, FileRequest, PathFuture, desktop_chooser};
use super::film::FilmExport;
use super::gap_picture::Maps;
use super::tabs::Tabs;
use super::view_state::{Begin, Extent, Saved, ViewState};
use super::{keys, layout, lecture, loop_plot, widgets};
use crate::follow::record::Cause;
use crate::lessons::Progress;
use crate::physics::topography::Topography;
use crate::plot::loop_panel;
use crate::plot::panel::Page;
use crate::scene::{Model, Scene, edit};
use crate::storage::session::{self, Session};
use crate::storage::{self, Opened, drawing, export, picture, presets, scene_file};
use crate::worker::SolverHandle;
use crate::worker::job::Job;
use crate::worker::protocol::{Command, Envelope, Event};
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
    maps: Maps,
    tabs: Tabs,
    dialogs: Dialogs,
    clicks: Clicks,
    /// When a jump was last announced (seconds).
    announced: f64,
    /// The file that is being read or written.
    file: Option<(PathBuf, FileJob)>,
    /// The film that is being written.
    film: Option<FilmExport>,
    /// How the window looked before lecture mode.
    before_lecture: Option<lecture::Before>,
}

/// What is kept between two sittings.
#[derive(Default, Serialize, Deserialize)]
#[serde(default)]
struct Sitting {
    lesson: Option<Progress>,
    before_lecture: Option<lecture::Before>,
    click: bool,
}

/// Under which name.
const SITTING: &str = "sitting";

/// Work with a file, which may take as long as the file system likes.
type FileJob = Job<Result<Done, storage::Failure>>;

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
            maps: Maps::default(),
            tabs: Tabs::default(),
            dialogs: Dialogs::new(chooser),
            clicks: Clicks::new(clicks::desktop()),
            announced: f64::NEG_INFINITY,
            file: None,
            film: None,
            before_lecture: None,
        }
    }

    /// With another way of clicking at a snap.
    pub fn with_player(self, player: Player) -> Self {
        Self {
            clicks: Clicks::new(player),
            ..self
        }
    }

    /// Takes up what was kept of the last sitting: the lesson goes on, the look is that before a
    /// lecture, and snaps click if they did.
    pub fn resume(&mut self, ctx: &Context, storage: &dyn eframe::Storage) {
        let kept = storage.get_string(SITTING).unwrap_or_default();
        let Sitting {
            lesson,
            before_lecture,
            click,
        } = serde_json::from_str(&kept).unwrap_or_default();
        self.state.view.click = click;
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
        self.take_file();
        self.state.update_foresight(&*self.solver);
        self.state.update_beside(&*self.solver);
        self.tabs.update(&mut self.state, &*self.solver);
        self.maps.update(&ctx, &self.state);
        let mut actions = Vec::new();
        keys::collect(&ctx, &self.state, self.dialogs.is_open(), &mut actions);
        let dropped = ctx.input(|input| input.raw.dropped_files.clone());
        let dropped = dropped.into_iter().map(|file| file.path().to_owned());
        actions.extend(dropped.take(1).map(Action::Open));
        self.announce(&ctx);
        self.panels(ui, &mut actions);
        actions.extend(widgets::take_asked_back(&ctx).map(Action::BringBack));
        self.tabs.float(&ctx, &self.state, &mut actions);
        self.dialogs
            .show(&ctx, &self.state, &self.tabs, &mut actions);
        let state = &mut self.state;
        self.film.take_if(|film| !film.show(&ctx, state));
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
        self.send();
    }

    /// Tells the solver what it has to know: at the end of a frame, or before the first one.
    pub(super) fn send(&mut self) {
        for command in self.state.take_commands() {
            self.solver.send(command);
        }
    }

    fn listen(&mut self) {
        for event in self.solver.poll() {
            let snaps =
                matches!(&event.message, Event::Jump(jump) if jump.cause != Cause::Transition);
            if snaps && event.run == self.state.run.id && self.state.view.click {
                self.clicks.click(&*self.solver);
            }
            self.state.apply(event);
        }
        if let Some(why) = self.clicks.failed() {
            self.state.view.click = false;
            self.state.messages.notice = Some(format!("no click at a snap: {why}"));
        }
    }

    /// Takes in what came of the file that was being read or written, if it is there.
    fn take_file(&mut self) {
        let Some(end) = self.file.as_mut().and_then(|(_, job)| job.poll()) else {
            return;
        };
        let Some((path, mut job)) = self.file.take() else {
            return;
        };
        self.state.messages.notice = None;
        match (job.so_far.take(), end) {
            (Some(Ok(done)), _) => {
                self.dialogs.close();
                if let Some(notice) = self.take_done(done, &path) {
                    self.state.messages.notice = Some(notice);
                }
            }
            (Some(Err(failure)), _) => self.state.messages.fail(failure, OTHER_PATH),
            (None, end) => {
                let (path, why) = (path.display(), end.err().unwrap_or_default());
                let message = format!("{path}: {why}");
                self.state.messages.fail(message, "Please report the file.");
            }
        }
    }

    /// Shows what came of a file; returns what to say, unless it was refused.
    fn take_done(&mut self, done: Done, path: &Path) -> Option<String> {
        let (state, file) = (&mut self.state, path.display());
        state.messages.failure = None;
        let notice = match done {
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
        state.messages.failure.is_none().then_some(notice)
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
        let (state, maps) = (&self.state, &self.maps);
        if state.view.lecture {
            lecture::show(ui, state, maps, actions);
        } else {
            layout::show(ui, state, maps, &mut self.tabs, actions);
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
            Action::Press(push) => state.press(push),
            Action::LetGo => state.let_go(),
            Action::Reset => state.reset(),
            Action::BringBack(key) => state.bring_number_back(key),
            Action::EditScene(scene) => state.edit_scene(*scene),
            Action::SetMethod(method) => state.set_method(method),
            Action::SetStrategy(asked) => state.set_strategy(asked),
            Action::SetFollows(follows) => state.follows = follows,
            Action::LoadPreset(index) => self.load_preset(presets::all().get(index)),
            Action::Undo => state.undo(),
            Action::Redo => state.redo(),
            Action::AskFile(task) => self.dialogs.ask(task),
            Action::UsePath(path) => self.use_path(ctx, &path),
            Action::SetNotes(notes) => state.notes = notes,
            Action::Open(path) => self.begin_to_open(ctx, &path),
            Action::CloseDialog => {
                self.file = None;
                self.dialogs.close();
            }
            Action::ToggleCommands => self.dialogs.toggle_commands(ctx),
            Action::ToggleHelp => self.dialogs.help = !self.dialogs.help,
            Action::SetTheme(theme) => ctx.set_theme(theme),
            Action::FitData => state.fit_axes(),
            Action::FitScene => state.plots.fit = None,
            Action::SetAxes([low, high]) => state.plots.fit = Some((low, high)),
            Action::SetView(view) => state.view = view,
            Action::CommandTab { tab, index } => self.tabs.command(tab, index),
            Action::OpenTab(name) => {
                state.view.tab = self.tabs.index(name).unwrap_or(state.view.tab);
            }
            Action::OverlayTheory(overlay) => state.plots.overlay = overlay,
            Action::SelectState { at, reach, pick } => state.select_near(at, reach, pick),
            Action::SelectOn(direction, control) => state.select_on(direction, control),
            Action::StepState(by) => state.step_state(by),
            Action::GoOn => state.go_on(),
            Action::SelectJump(index) => state.select_jump(index),
            Action::StepJump(by) => state.step_jump(by),
            Action::Keep(from) => state.keep(from),
            Action::OnKept(id, act) => state.act_on_kept(id, act),
            Action::BringKeptBack => state.bring_kept_back(),
            Action::CompareWithBefore => state.compare_with_before(),
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
            Action::RestoreLayout => self.restore_layout(ctx),
            Action::DropNotice => state.messages.notice = None,
            Action::DismissFailure => state.messages.failure = None,
            Action::Quit => ctx.send_viewport_cmd(egui::ViewportCommand::Close),
        }
    }

    fn restore_layout(&mut self, ctx: &Context) {
        ctx.data_mut(egui::util::IdTypeMap::remove_by_type::<PanelState>);
        let state = &mut self.state;
        state.view = ViewOptions {
            lecture: state.view.lecture,
            click: state.view.click,
            ..ViewOptions::default()
        };
        state.plots.fit = None;
        self.tabs.restore();
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

    /// Begins to work with a file.
    fn begin_file(
        &mut self,
        ctx: &Context,
        path: &Path,
        doing: &str,
        work: impl FnOnce(&Path) -> Result<Done, storage::Failure> + Send + 'static,
    ) {
        let (file, ctx) = (path.to_owned(), ctx.clone());
        let job = Job::start(Arc::new(move || ctx.request_repaint()), move |report| {
            report.result(work(&file));
            Ok(())
        });
        self.file = Some((path.to_owned(), job));
        self.state.messages.notice = Some(format!("{doing} {} …", path.display()));
    }

    fn begin_to_open(&mut self, ctx: &Context, path: &Path) {
        let (scene, model) = (self.state.scene.clone(), self.state.model.clone());
        self.begin_file(ctx, path, "opening", move |file| {
            match storage::open(file)? {
                Opened::Scene(scene) => Ok(Done::Scene(scene)),
                Opened::Session(bytes) => {
                    session::of_bytes(file, &bytes).map(|session| Done::Session(Box::new(session)))
                }
                Opened::Heights(map) => ground(&scene, &model, map),
            }
        });
    }

    fn begin_to_save(&mut self, ctx: &Context, path: &Path) {
        let session = self.state.session(Extent::Whole);
        self.begin_file(ctx, path, "writing", move |file| {
            session::save(file, &session, session.window.record()).map(|()| Done::Written)
        });
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
            FileTask::SaveSession => return self.begin_to_save(ctx, path),
            FileTask::ExportFilm(kind) => {
                self.film = FilmExport::begin(ctx, state, path, kind);
                return self.dialogs.close();
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
                let (tab, panels) = self.tabs.panels(state);
                if panels.is_empty() {
                    let message = format!("the tab {tab} has no curves to write");
                    let remedy = "Choose a tab with a diagram, or wait until it is computed.";
                    return self.state.messages.fail(message, remedy);
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
                self.dialogs.close();
                self.state.messages.failure = None;
                self.state.messages.notice = Some(format!("{} written", path.display()));
            }
            Err(failure) => self.state.messages.fail(failure, OTHER_PATH),
        }
    }
}

/// Puts scene and state into a picture, so that it opens again as what it shows.
fn attach(path: &Path, state: &ViewState) -> Result<(), storage::Failure> {
    let session = state.session(Extent::Present);
    let bytes = session::to_bytes(&session, session.window.record()).ok();
    picture::attach(path, &session.scene, bytes.as_deref())
}

/// The picture of the stress curve.
fn page(state: &ViewState) -> Page<'static> {
    let ledger = state.run.record.ledger(state.model.law.surface_energy);
    let error = ledger.stated_error(state.predicted_error());
    loop_panel::page(&state.run.record, &state.model, &state.scene.title, error)
}

/// The scene on the ground of this map.
fn ground(scene: &Scene, model: &Model, map: Topography) -> Result<Done, storage::Failure> {
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

impl eframe::App for App {
    fn ui(&mut self, ui: &mut Ui, _frame: &mut eframe::Frame) {
        self.frame(ui);
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        let sitting = Sitting {
            lesson: self.state.lesson.clone(),
            before_lecture: self.before_lecture,
            click: self.state.view.click,
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
