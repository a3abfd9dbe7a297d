//! Dialogs: a file by the desktop's chooser or by its typed path, the sheet of keys, the palette of
//! commands. Nothing here waits.

use super::action::{Action, FileTask};
use super::commands::{self, Palette};
use super::tabs::Tabs;
use super::view_state::ViewState;
use super::widgets::{Asks, radio};
use crate::storage::files::{self, Effect};
use egui::{Align2, Context, RichText, Ui, Window};
use std::path::{Path, PathBuf};
use std::pin::Pin;
use std::task::{Poll, Waker};
use std::time::Duration;

/// What a file chooser promises: a path, or nothing.
pub type PathFuture = Pin<Box<dyn Future<Output = Option<PathBuf>>>>;

/// How often an open desktop chooser is asked for its answer.
const ASK_AGAIN: Duration = Duration::from_millis(100);

/// The dialogs.
pub struct Dialogs {
    chooser: Box<dyn FnMut(FileTask) -> PathFuture>,
    file: Option<FileDialog>,
    /// True while the sheet of keys is shown.
    pub help: bool,
    commands: Option<Palette>,
}

struct FileDialog {
    task: FileTask,
    path: String,
    note: Option<String>,
    /// What was entered, where it replaces a file or makes a folder, until that is wanted in so
    /// many words.
    question: Option<Question>,
    pending: Option<PathFuture>,
    fresh: bool,
}

struct Question {
    entered: String,
    words: String,
    /// The word on the button that says yes.
    yes: &'static str,
}

impl Question {
    /// What to ask before writing to `path`, which was entered in this way; nothing for a new file
    /// in a folder that is there.
    fn before(path: &Path, entered: &str) -> Option<Self> {
        let (words, yes) = match files::effect(path) {
            Effect::Adds => return None,
            Effect::Replaces => (
                format!("{} is there already.", path.display()),
                "Replace it",
            ),
            Effect::MakesFolder(folder) => (
                format!("The folder {} is not there.", folder.display()),
                "Make the folder",
            ),
        };
        Some(Self {
            entered: entered.to_owned(),
            words,
            yes,
        })
    }
}

impl Dialogs {
    /// Dialogs that ask `chooser` for files.
    pub fn new(chooser: impl FnMut(FileTask) -> PathFuture + 'static) -> Self {
        Self {
            chooser: Box::new(chooser),
            file: None,
            help: false,
            commands: None,
        }
    }

    /// True while one is open.
    pub fn is_open(&self) -> bool {
        self.file.is_some() || self.help || self.commands.is_some()
    }

    /// Opens the dialog of a task, and the desktop's chooser beside it where there is nothing to
    /// decide first.
    pub fn ask(&mut self, task: FileTask) {
        let pending = task.variants().is_empty().then(|| (self.chooser)(task));
        self.file = Some(FileDialog {
            task,
            path: task.row().file_name.to_owned(),
            note: None,
            question: None,
            pending,
            fresh: true,
        });
    }

    /// Opens the palette of commands in place of whatever is open, or closes it.
    pub fn toggle_commands(&mut self, ctx: &Context) {
        let open = self.commands.is_none();
        self.close();
        self.commands = open.then(|| Palette::new(ctx));
    }

    /// What the open file dialog is for.
    pub fn task(&self) -> Option<FileTask> {
        self.file.as_ref().map(|file| file.task)
    }

    /// Closes everything.
    pub fn close(&mut self) {
        self.file = None;
        self.help = false;
        self.commands = None;
    }

    /// Draws what is open and asks the desktop's chooser for its answer.
    pub fn show(
        &mut self,
        ctx: &Context,
        state: &ViewState,
        tabs: &Tabs,
        actions: &mut Vec<Action>,
    ) {
        if self.help {
            help(ctx, actions);
        }
        if let Some(commands) = &mut self.commands {
            commands.show(ctx, state, tabs, actions);
        }
        let Self {
            chooser,
            file: Some(file),
            ..
        } = self
        else {
            return;
        };
        file.poll(ctx, actions);
        let open = centred(ctx, file.task.row().title, |ui| {
            if let Some(task) = file.body(ui, &state.notes, actions) {
                file.note = None;
                file.pending = Some(chooser(task));
            }
        });
        if !open {
            actions.push(Action::CloseDialog);
        }
    }
}

impl FileDialog {
    fn poll(&mut self, ctx: &Context, actions: &mut Vec<Action>) {
        let Some(pending) = &mut self.pending else {
            return;
        };
        match pending
            .as_mut()
            .poll(&mut std::task::Context::from_waker(Waker::noop()))
        {
            Poll::Pending => ctx.request_repaint_after(ASK_AGAIN),
            Poll::Ready(Some(path)) => {
                self.pending = None;
                actions.push(Action::UsePath(path));
            }
            Poll::Ready(None) => {
                self.pending = None;
                // A desktop without a portal answers like a cancel, after a moment.
                let note =
                    "No file was chosen, or this desktop has no file chooser. Type the path here.";
                self.note = Some(note.to_owned());
            }
        }
    }

    /// The contents; returns the task if the desktop's chooser shall be opened.
    fn body(&mut self, ui: &mut Ui, notes: &str, actions: &mut Vec<Action>) -> Option<FileTask> {
        ui.set_width(430.0);
        if !self.task.variants().is_empty() {
            ui.horizontal_wrapped(|ui| {
                for row in self.task.variants() {
                    if radio(ui, &self.task, &row.task, row.word).clicked() {
                        self.task = row.task;
                        self.path = row.file_name.to_owned();
                    }
                }
            });
        }
        let label = ui.label("Path");
        let field = ui
            .add(egui::TextEdit::singleline(&mut self.path).desired_width(f32::INFINITY))
            .labelled_by(label.id);
        if std::mem::take(&mut self.fresh) {
            field.request_focus();
        }
        if self.task == FileTask::SaveSession {
            let (label, mut notes) = (ui.label("Notes"), notes.to_owned());
            let field = egui::TextEdit::multiline(&mut notes)
                .desired_rows(3)
                .desired_width(f32::INFINITY);
            if ui.add(field).labelled_by(label.id).changed() {
                actions.push(Action::SetNotes(notes));
            }
        }
        let entered = field.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter));
        self.question
            .take_if(|question| question.entered != self.path);
        if let Some(question) = &self.question {
            ui.label(RichText::new(&question.words).strong());
        } else if let Some(note) = &self.note {
            ui.label(RichText::new(note).weak());
        } else if self.pending.is_some() {
            ui.label(
                RichText::new(
                    "The desktop's file chooser is open; a path typed here does as well.",
                )
                .weak(),
            );
        }
        let mut browse = None;
        ui.horizontal(|ui| {
            let word = match &self.question {
                Some(question) => question.yes,
                None if self.task.opens() => "Open",
                None => "Write",
            };
            if (ui
                .add_enabled(!self.path.trim().is_empty(), egui::Button::new(word))
                .clicked()
                || entered)
                && !self.path.trim().is_empty()
            {
                actions.extend(self.enter());
            }
            if ui
                .add_enabled(self.pending.is_none(), egui::Button::new("Browse…"))
                .clicked()
            {
                browse = Some(self.task);
            }
            ui.button("Cancel").asks(actions, Action::CloseDialog);
        });
        browse
    }

    /// The path that was typed, once what it does to other files is wanted.
    fn enter(&mut self) -> Option<Action> {
        let path = match files::typed(Path::new(self.path.trim())) {
            Ok(path) => path,
            Err(failure) => {
                self.note = Some(failure.to_string());
                return None;
            }
        };
        let asked = self.question.take().is_some();
        if !self.task.opens() && !asked {
            self.question = Question::before(&path, &self.path);
        }
        self.question.is_none().then_some(Action::UsePath(path))
    }
}

/// How the names of scenes and of height files end.
const SCENES: &[&str] = &["toml", "tackscope", "png"];
const HEIGHTS: &[&str] = &[
    "csv", "txt", "dat", "xyz", "npy", "npz", "sur", "sdf", "x3p", "nc",
];

/// The desktop's own file chooser (rfd), which runs elsewhere while the window goes on drawing.
pub fn desktop_chooser(task: FileTask) -> PathFuture {
    let row = task.row();
    let dialog = rfd::AsyncFileDialog::new().set_title(row.title);
    let dialog = match task {
        FileTask::OpenScene => dialog.add_filter(row.kind, SCENES),
        FileTask::OpenHeights => dialog.add_filter(row.kind, HEIGHTS),
        _ => {
            let ending = row.file_name.rsplit('.').next();
            dialog.add_filter(row.kind, ending.as_slice())
        }
    };
    Box::pin(async move {
        let file = if task.opens() {
            dialog.pick_file().await
        } else {
            dialog.set_file_name(row.file_name).save_file().await
        };
        file.map(|file| file.path().to_path_buf())
    })
}

/// A window in the middle; true while it stays open.
fn centred(ctx: &Context, title: &str, body: impl FnOnce(&mut Ui)) -> bool {
    let mut open = true;
    Window::new(title)
        .collapsible(false)
        .resizable(false)
        .open(&mut open)
        .anchor(Align2::CENTER_CENTER, [0.0, 0.0])
        .show(ctx, body);
    open
}

fn help(ctx: &Context, actions: &mut Vec<Action>) {
    let open = centred(ctx, "Keys and marks", |ui| {
        egui::Grid::new("keys")
            .num_columns(2)
            .spacing([18.0, 4.0])
            .show(ui, |ui| {
                for (key, what) in commands::SHEET {
                    ui.label(RichText::new(key).strong());
                    ui.label(what);
                    ui.end_row();
                }
            });
        ui.separator();
        ui.label(
            "u₀ is the mean displacement: down is closer. ◀ approach, ▶ retraction, \
                arrows are jumps.",
        );
        ui.label(
            "Stress counts positive where the surfaces pull at each other. Dark on the \
                map is contact.",
        );
    });
    if !open {
        actions.push(Action::ToggleHelp);
    }
}
