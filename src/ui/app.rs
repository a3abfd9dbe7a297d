//! The application: takes in what the solver says, draws the panels, and acts on what they ask for.

use super::action::{Action, FileTask, ViewOptions};
use super::dialogs::{Dialogs, PathFuture, desktop_chooser};
use super::files::{Files, page};
use super::gap_picture::Maps;
use super::tabs::Tabs;
use super::view_state::{Begin, ViewState};
use super::{commands, layout};
use crate::follow::record::Cause;
use crate::lessons::Progress;
use crate::storage::{self, drawing, picture, scene_file};
use crate::worker::job::{Job, Reporter};
use crate::worker::protocol::Event;
use crate::worker::{self, SolverHandle};
use egui::containers::PanelState;
use egui::{Context, Ui};
use serde::{Deserialize, Serialize};
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
    files: Files,
    /// How the window looked before lecture mode.
    before_lecture: Option<layout::Before>,
}

/// What is kept between two sittings.
#[derive(Default, Serialize, Deserialize)]
#[serde(default)]
struct Sitting {
    lesson: Option<Progress>,
    before_lecture: Option<layout::Before>,
    click: bool,
}

/// Under which name.
const SITTING: &str = "sitting";

impl App {
    /// A window on this state, worked by this solver.
    pub fn new(solver: impl SolverHandle + 'static, state: ViewState) -> Self {
        Self::with_chooser(solver, state, desktop_chooser)
    }

    /// Like [`App::new`], with another way of choosing files.
    pub fn with_chooser(
        solver: impl SolverHandle + 'static,
        state: ViewState,
        chooser: impl FnMut(FileTask) -> PathFuture + 'static,
    ) -> Self {
        Self {
            state,
            solver: Box::new(solver),
            maps: Maps::default(),
            tabs: Tabs::default(),
            dialogs: Dialogs::new(chooser),
            clicks: Clicks::new(desktop_player()),
            announced: f64::NEG_INFINITY,
            files: Files::default(),
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
        self.state.messages.click = click;
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
        self.files.take_in(&mut self.state, &mut self.dialogs);
        self.state.update_foresight(&*self.solver);
        self.state.update_beside(&*self.solver);
        self.tabs.update(&mut self.state, &*self.solver);
        self.maps.update(&ctx, &self.state);
        let mut actions = Vec::new();
        let with = (&self.state, &self.tabs);
        commands::of_keys(&ctx, with, self.dialogs.is_open(), &mut actions);
        let dropped = ctx.input(|input| input.raw.dropped_files.clone());
        let dropped = dropped.into_iter().map(|file| file.path().to_owned());
        actions.extend(dropped.take(1).map(Action::Open));
        self.announce(&ctx);
        self.panels(ui, &mut actions);
        self.tabs.float(&ctx, &self.state, &mut actions);
        self.dialogs
            .show(&ctx, &self.state, &self.tabs, &mut actions);
        self.files.show(&ctx, &mut self.state);
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
            if snaps && event.run == self.state.run.id && self.state.messages.click {
                self.clicks.click(&*self.solver);
            }
            self.state.apply(event);
        }
        if let Some(why) = self.clicks.failed() {
            self.state.messages.click = false;
            self.state.messages.notice = Some(format!("no click at a snap: {why}"));
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
        let (state, maps) = (&self.state, &self.maps);
        if state.view.lecture {
            layout::lecture(ui, state, maps, actions);
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
            Action::LoadPreset(index) => self.load_preset(storage::presets().get(index)),
            Action::Undo => state.undo(),
            Action::Redo => state.redo(),
            Action::AskFile(task) => self.dialogs.ask(task),
            Action::UsePath(path) => {
                let inputs = (&mut self.dialogs, &self.tabs);
                self.files.use_path(ctx, state, inputs, &path);
            }
            Action::SetNotes(notes) => state.notes = notes,
            Action::Open(path) => self.files.open(ctx, state, &path),
            Action::CloseDialog => {
                self.files.drop_job();
                self.dialogs.close();
            }
            Action::ToggleCommands => self.dialogs.toggle_commands(ctx),
            Action::ToggleHelp => self.dialogs.help = !self.dialogs.help,
            Action::SetTheme(theme) => ctx.set_theme(theme),
            Action::SetClick(click) => state.messages.click = click,
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
        self.load_preset(begin.scene.and_then(storage::preset));
        let tab = begin.tab.and_then(|name| self.tabs.index(name));
        self.state.view.tab = tab.unwrap_or(self.state.view.tab);
    }

    fn toggle_lecture(&mut self, ctx: &Context) {
        self.state.view.lecture = !self.state.view.lecture;
        match self.before_lecture.take() {
            Some(before) => before.restore(ctx),
            None => self.before_lecture = Some(layout::Before::enlarge(ctx)),
        }
    }

    fn load_preset(&mut self, preset: Option<&storage::Preset>) {
        let Some(preset) = preset else { return };
        match scene_file::parse(preset.text, preset.name) {
            Ok(scene) => self.state.open_scene(scene),
            Err(failure) => {
                let remedy = "This preset is broken; choose another one.";
                self.state.messages.fail(failure, remedy);
            }
        }
    }
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut Ui, _frame: &mut eframe::Frame) {
        self.frame(ui);
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        let sitting = Sitting {
            lesson: self.state.lesson.clone(),
            before_lecture: self.before_lecture,
            click: self.state.messages.click,
        };
        if let Ok(text) = serde_json::to_string(&sitting) {
            storage.set_string(SITTING, text);
        }
    }
}

/// Makes the sound and returns at its end, on a thread of its own; or says why it cannot.
pub type Player = Arc<dyn Fn() -> Result<(), String> + Send + Sync>;

/// By a program of the desktop.
fn desktop_player() -> Player {
    Arc::new(|| {
        let file = picture::click().map_err(|error| error.to_string())?;
        worker::play(file.path())
    })
}

fn sounded(player: &Player, _: &Reporter<()>) -> Result<(), String> {
    player()
}

/// What clicks.
struct Clicks {
    player: Player,
    sounding: Option<Job<()>>,
}

impl Clicks {
    /// By this player.
    fn new(player: Player) -> Self {
        Self {
            player,
            sounding: None,
        }
    }

    /// Clicks, unless the last click still sounds: a hundred jumps in a second are no hundred
    /// programs.
    fn click(&mut self, solver: &dyn SolverHandle) {
        if self.sounding.as_ref().is_none_or(|job| !job.is_running()) {
            self.sounding = Some(solver.job(self.player.clone(), sounded));
        }
    }

    /// Why there was no click, once.
    fn failed(&mut self) -> Option<String> {
        self.sounding.as_mut()?.poll()?.err()
    }
}
