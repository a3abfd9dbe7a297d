//! What a panel wants to happen. Panels only push these; `app` acts.

use crate::follow::record::Direction;
use crate::follow::walk::Push;
use crate::plot::style::Colours;
use crate::scene::edit::Follows;
use crate::scene::{Scene, Strategy};
use crate::solver::methods::MethodKind;
use crate::storage::picture::FilmKind;
use crate::worker::protocol::{Speed, Sweep};
use egui::ThemePreference;
use std::path::PathBuf;

/// An intent of the user.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// Walk to this value of what is driven (length; E* of a load).
    SetTarget(f64),
    /// Move the target by this many increments of the drive (negative: down).
    Step(f64),
    /// One increment in the present direction.
    Increment,
    /// Turn round: reverse the sweep, or the direction of the next increment.
    Reverse,
    /// Walk by itself.
    Play(Sweep),
    /// Pause, go on, or start a loop.
    TogglePlay,
    /// Hold (true) or go on.
    Pause(bool),
    /// Drop target and sweep.
    Stop,
    /// Press the surface, and hold it.
    Press(Push),
    /// Let it go.
    LetGo,
    /// Back to rest at the start, everything recorded forgotten.
    Reset,
    /// Bring the number of this key back to what it is in the scene that was opened.
    BringBack(&'static str),
    /// Replace the scene by an edited one.
    EditScene(Box<Scene>),
    /// Choose the method.
    SetMethod(MethodKind),
    /// Let the plan decide on the model, or overrule it.
    SetStrategy(Option<Strategy>),
    /// Choose what follows mu_rho.
    SetFollows(Follows),
    /// Load the preset of this index.
    LoadPreset(usize),
    /// Take the last scene edit back.
    Undo,
    /// Do it again.
    Redo,
    /// Ask for a file.
    AskFile(FileTask),
    /// Do the open dialog's task with this path.
    UsePath(PathBuf),
    /// Write these notes, saved with the session.
    SetNotes(String),
    /// Open the scene, the session or the heights of this file.
    Open(PathBuf),
    /// Close whatever dialog is open.
    CloseDialog,
    /// Show or hide the palette of commands.
    ToggleCommands,
    /// Show or hide the sheet of keys.
    ToggleHelp,
    /// Light, dark, or as the desktop has it.
    SetTheme(ThemePreference),
    /// Click at a snap, or do not.
    SetClick(bool),
    /// Fit the plot's axes to the data.
    FitData,
    /// Fit the plot's axes to the scene.
    FitScene,
    /// Give the plot these axes: lower left and upper right corner.
    SetAxes([[f64; 2]; 2]),
    /// Change how things are drawn.
    SetView(ViewOptions),
    /// Ask a tab for one of its commands.
    CommandTab {
        /// Which tab.
        tab: usize,
        /// Which command.
        index: usize,
    },
    /// Show the tab of this name.
    OpenTab(&'static str),
    /// Lay theory over the live plot, or take it away.
    OverlayTheory(bool),
    /// Look at the walked or foreseen state nearest to a place of the plot.
    SelectState {
        /// u0/rho and stress/sigma_max.
        at: [f64; 2],
        /// How far a click may miss it, along each.
        reach: [f64; 2],
        /// By what gesture.
        pick: Pick,
    },
    /// Look at the newest state of this direction whose control is nearest to a value, or at the
    /// one foreseen there.
    SelectOn(Direction, f64),
    /// Look at the state so many further on along the path, or back.
    StepState(isize),
    /// Take the state that is looked at as the present one.
    GoOn,
    /// Look at the state after the jump of this index.
    SelectJump(usize),
    /// Look at the jump so many further on, or back.
    StepJump(isize),
    /// Keep a loop on the plot.
    Keep(KeepFrom),
    /// Do something with the kept loop of this number.
    OnKept(usize, KeptAct),
    /// Bring the loop back that was deleted last.
    BringKeptBack,
    /// Put the scene before the last edit beside this one.
    CompareWithBefore,
    /// Look at nothing.
    ClearSelection,
    /// The scene as text on the clipboard.
    CopyScene,
    /// The picture of the stress curve on the clipboard.
    CopyPicture,
    /// This text on the clipboard.
    CopyText(String),
    /// A scene as text from the clipboard.
    PasteScene(String),
    /// In the lesson.
    Lesson(LessonAct),
    /// Guess u0 of the next jump (ranges), in a lecture.
    Guess(f64),
    /// Lecture mode, or out of it.
    ToggleLecture,
    /// Panels and view as they were at first.
    RestoreLayout,
    /// The notice has been read, or was long enough.
    DropNotice,
    /// The failure has been read.
    DismissFailure,
    /// End the program.
    Quit,
}

impl Action {
    /// Replaces the scene by this edited one.
    pub fn edit(scene: Scene) -> Self {
        Self::EditScene(Box::new(scene))
    }
}

/// How a state is picked from the plot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pick {
    /// By a click at it.
    Click,
    /// By a drag that begins: the nearest.
    Drag,
    /// By a drag that goes on, along the same curve.
    Along,
}

/// Of what a loop is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeepFrom {
    /// A closed loop that was walked, else the live loop, else what was walked so far.
    Best,
    /// What was walked.
    Walked,
    /// The live loop.
    Live,
}

/// What is done with a kept loop.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum KeptAct {
    /// Give it another name.
    Rename(String),
    /// Take it off the plot, or draw it again.
    Hide,
    /// Open its scene.
    Restore,
    /// Delete it.
    Delete,
    /// Put its scene beside the present one, or take it away.
    Beside,
}

/// In what kept loops are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scales {
    /// The range and the largest traction of each one's own law.
    #[default]
    Own,
    /// The same lengths and stresses for all.
    Absolute,
}

/// What a learner does in the lesson's panel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LessonAct {
    /// Begin the lesson of this index.
    Start(usize),
    /// Choose an answer: u0 in ranges, or the index of a choice.
    Choose(f64),
    /// Give the answer that is chosen.
    Commit,
    /// The next step, whether this one is done or not.
    Next,
    /// The step before.
    Back,
    /// End the lesson.
    Leave,
}

/// What a file is wanted for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileTask {
    /// Open a scene, a session, or measured heights as the scene's ground.
    OpenScene,
    /// The same, asked for heights.
    OpenHeights,
    /// Save the scene.
    SaveScene,
    /// Save the scene with everything that was computed of it.
    SaveSession,
    /// Write the recorded states.
    ExportLoopCsv,
    /// Write the recorded jumps.
    ExportEventsCsv,
    /// Write every curve of the plot.
    ExportCurvesCsv,
    /// Write every curve of the chosen tab.
    ExportTabCsv,
    /// Write the curve of stress against u0 as a picture.
    ExportLoopPng,
    /// The same as an SVG, to be printed at any size.
    ExportLoopSvg,
    /// Write the gap map as a picture.
    ExportGapPng,
    /// Write the stored states of the path as a film.
    ExportFilm(FilmKind),
}

/// A task with what is said of it.
pub struct FileRow {
    /// The task.
    pub task: FileTask,
    /// Title of its dialog.
    pub title: &'static str,
    /// File name that is offered.
    pub file_name: &'static str,
    /// What such a file is.
    pub kind: &'static str,
    /// Its word beside the other tasks of its dialog.
    pub word: &'static str,
    /// Its name among the commands, and its keys.
    pub command: [&'static str; 2],
}

const fn row(
    task: FileTask,
    [title, file_name, kind, word]: [&'static str; 4],
    command: [&'static str; 2],
) -> FileRow {
    FileRow {
        task,
        title,
        file_name,
        kind,
        word,
        command,
    }
}

const DATA: &str = "Export data";
const PICTURE: &str = "Export picture";
const FILM: &str = "Export film";

/// Every task, those that one dialog lets choose between together.
pub static FILE_TASKS: [&[FileRow]; 5] = {
    use FileTask::*;
    const SCENES: &str = "Scene, session, or a picture with its scene";
    [
        &[row(
            OpenScene,
            ["Open scene", "scene.toml", SCENES, ""],
            ["Open a scene", "Ctrl+O"],
        )],
        &[
            row(
                SaveScene,
                ["Save", "scene.toml", "Scene", "scene"],
                ["Save the scene", "Ctrl+S"],
            ),
            row(
                SaveSession,
                [
                    "Save",
                    "session.tackscope",
                    "Session",
                    "session: with all that was computed",
                ],
                ["Save the session", ""],
            ),
        ],
        &[row(
            OpenHeights,
            ["Measured ground", "heights.csv", "Heights", ""],
            ["Open a height file as measured ground", ""],
        )],
        &[
            row(
                ExportLoopCsv,
                [DATA, "loop.csv", "CSV", "states (loop.csv)"],
                ["Export states as CSV", ""],
            ),
            row(
                ExportEventsCsv,
                [DATA, "events.csv", "CSV", "jumps (events.csv)"],
                ["Export jumps as CSV", ""],
            ),
            row(
                ExportCurvesCsv,
                [DATA, "curves.csv", "CSV", "curves of the plot"],
                ["Export the curves of the plot as CSV", ""],
            ),
            row(
                ExportTabCsv,
                [DATA, "tab.csv", "CSV", "of the tab"],
                ["Export the curves of the tab as CSV", ""],
            ),
        ],
        &[
            row(
                ExportLoopPng,
                [PICTURE, "loop.png", "PNG", "stress curve"],
                ["Export the stress curve as PNG", "S"],
            ),
            row(
                ExportLoopSvg,
                [PICTURE, "loop.svg", "SVG", "stress curve, SVG"],
                ["Export the stress curve as SVG", ""],
            ),
            row(
                ExportGapPng,
                [PICTURE, "gap.png", "PNG", "gap map"],
                ["Export the gap map as PNG", ""],
            ),
            row(
                ExportFilm(FilmKind::Gif),
                [FILM, "film.gif", "GIF", "film, GIF"],
                ["Export the path as a film (GIF)", ""],
            ),
            row(
                ExportFilm(FilmKind::Apng),
                [FILM, "film.png", "Animated PNG", "film, PNG"],
                ["Export the path as a film (animated PNG)", ""],
            ),
        ],
    ]
};

impl FileTask {
    /// What is said of it.
    pub fn row(self) -> &'static FileRow {
        let mut all = FILE_TASKS.iter().copied().flatten();
        let row = all.find(|row| row.task == self);
        row.expect("every task has its row")
    }

    /// True if it reads a file, and does not write one.
    pub fn opens(self) -> bool {
        matches!(self, FileTask::OpenScene | FileTask::OpenHeights)
    }

    /// The tasks of its dialog, itself among them; empty where there is nothing to choose.
    pub fn variants(self) -> &'static [FileRow] {
        let of_this = |rows: &&[FileRow]| rows.len() > 1 && rows.iter().any(|row| row.task == self);
        FILE_TASKS.into_iter().find(of_this).unwrap_or_default()
    }
}

/// Along which line the profile is cut.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub enum ProfileLine {
    /// Through the middle of the contact, or of the hole in it, along the axis on which the gap
    /// varies more.
    #[default]
    Auto,
    /// Along x at this share of the height, 0 to 1.
    AlongX(f64),
    /// Along y at this share of the width, 0 to 1.
    AlongY(f64),
}

/// What is shown where the window has no room for all panels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Page {
    /// Map, profile and strip.
    #[default]
    Surface,
    /// The plot and the tabs.
    Curve,
    /// What the scene is made of.
    Scene,
}

impl Page {
    /// Its name on the screen.
    pub fn word(self) -> &'static str {
        match self {
            Page::Surface => "Map",
            Page::Curve => "Curve",
            Page::Scene => "Scene",
        }
    }
}

/// How things are drawn; no part of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewOptions {
    /// Roll the periodic cell so that the pattern stands in its middle.
    pub centred: bool,
    /// Interpolate between mesh points.
    pub smooth: bool,
    /// The colours of maps.
    pub colours: Colours,
    /// Where the profile is cut.
    pub profile: ProfileLine,
    /// Draw the soft mode over the map.
    pub soft_mode: bool,
    /// How wide a push is, as a share of the cell.
    pub push_width: f64,
    /// What is shown below the plot: the tab of this index.
    pub tab: usize,
    /// What is shown where there is no room for all.
    pub page: Page,
    /// How fast sweeps and jumps are shown.
    pub speed: Speed,
    /// In what kept loops are drawn.
    pub scales: Scales,
    /// Lecture mode.
    pub lecture: bool,
}

impl Default for ViewOptions {
    fn default() -> Self {
        Self {
            centred: true,
            smooth: true,
            colours: Colours::default(),
            profile: ProfileLine::Auto,
            soft_mode: false,
            push_width: 0.12,
            tab: 0,
            page: Page::default(),
            speed: Speed::default(),
            scales: Scales::default(),
            lecture: false,
        }
    }
}
