//! The window under test, and the solver it talks to.

use super::hand::{Hand, Window, named_from};
use egui::{Key, Modifiers, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use ndarray::Array2;
use std::any::Any;
use std::cell::RefCell;
use std::ops::{Deref, DerefMut};
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::{Arc, Mutex};
use tackscope::follow::diagram::Diagram;
use tackscope::follow::record::{Cause, Direction, JumpRecord, StateRecord};
use tackscope::physics::pattern::Pattern;
use tackscope::physics::theory::flat_stiffness;
use tackscope::scene::{Model, Part, Points, Scene};
use tackscope::solver::Stop;
use tackscope::storage;
use tackscope::study::chart::Effort;
use tackscope::study::landscape::{Landscape, Standing};
use tackscope::study::plan::{ModelChoice, plan};
use tackscope::study::time_step_map::TimeStepMap;
use tackscope::ui::view_state::ViewState;
use tackscope::ui::{App, theme};
use tackscope::worker::SolverHandle;
use tackscope::worker::background::{ChartSoFar, Page, PageContent};
use tackscope::worker::job::{Computation, Reporter, Wake, Work};
use tackscope::worker::protocol::{Command, Envelope, Event, Frame, Play, Ready, RunId};

/// What the window said, and what it will hear at its next frame.
#[derive(Default)]
struct Wire {
    commands: Vec<Envelope<Command>>,
    events: Vec<Envelope<Event>>,
    begun: Vec<Box<dyn Work>>,
}

/// A solver without a thread: it keeps what it is told and says what the test puts on the wire.
#[derive(Clone, Default)]
struct FakeSolver(Rc<RefCell<Wire>>);

impl SolverHandle for FakeSolver {
    fn send(&self, command: Envelope<Command>) {
        self.0.borrow_mut().commands.push(command);
    }

    fn poll(&self) -> Vec<Envelope<Event>> {
        std::mem::take(&mut self.0.borrow_mut().events)
    }

    fn wake(&self) -> Wake {
        Arc::new(|| {})
    }

    fn begin(&self, work: Box<dyn Work>) {
        self.0.borrow_mut().begun.push(work);
    }
}

/// What a landscape is asked for: a scene, its branches, a state, the landscape before.
pub type Asked = (Arc<Scene>, Arc<Diagram>, Standing, Option<Arc<Landscape>>);

/// A player of sounds that makes none: how often it was called, and what it answers.
pub type Silent = Arc<Mutex<(usize, Result<(), String>)>>;

/// The window under test.
pub struct Bench {
    window: Window,
    solver: FakeSolver,
    pub model: Model,
    pub player: Silent,
}

/// The scene the window opens with.
pub fn fig2() -> Scene {
    storage::resolve("fig2").unwrap()
}

/// The same with so many points along each side.
pub fn coarse(points: usize) -> Scene {
    let mut scene = fig2();
    scene.cell.points = Points::Square(points);
    scene
}

impl Deref for Bench {
    type Target = Window;

    fn deref(&self) -> &Window {
        &self.window
    }
}

impl DerefMut for Bench {
    fn deref_mut(&mut self) -> &mut Window {
        &mut self.window
    }
}

impl Bench {
    /// At rest at the start of Fig. 2.
    pub fn new() -> Self {
        Self::sized(1280.0, 800.0)
    }

    pub fn sized(width: f32, height: f32) -> Self {
        Self::showing(
            ViewState::new(fig2()).expect("fig2 is allowed"),
            (width, height),
        )
    }

    /// Of the usual size, in this state.
    pub fn opened(state: ViewState) -> Self {
        Self::showing(state, (1280.0, 800.0))
    }

    fn showing(state: ViewState, (width, height): (f32, f32)) -> Self {
        let solver = FakeSolver::default();
        let model = state.model.clone();
        // A desktop without a file chooser: every question is answered by nothing.
        let app = App::with_chooser(solver.clone(), state, |_| {
            Box::pin(std::future::ready(None::<PathBuf>))
        });
        let player: Silent = Arc::new(Mutex::new((0, Ok(()))));
        let called = player.clone();
        let app = app.with_player(Arc::new(move || {
            let mut called = called.lock().expect("nobody panics over it");
            called.0 += 1;
            called.1.clone()
        }));
        let window = Harness::builder()
            .with_size(vec2(width, height))
            .with_max_steps(12)
            .with_context_setup(theme::install)
            .build_ui_state(|ui, app: &mut App| app.frame(ui), app);
        let mut bench = Self {
            window,
            solver,
            model,
            player,
        };
        bench.window.run();
        bench
    }

    /// Draws until nothing wants to be drawn any more.
    pub fn settle(&mut self) {
        self.window.run();
    }

    /// The commands since the last call.
    pub fn heard(&self) -> Vec<Command> {
        let heard = self.heard_of().into_iter();
        heard.map(|envelope| envelope.message).collect()
    }

    /// The same with their runs.
    pub fn heard_of(&self) -> Vec<Envelope<Command>> {
        std::mem::take(&mut self.solver.0.borrow_mut().commands)
    }

    /// The jobs of this kind that were begun since the last call, for the test to answer.
    fn begun<I: 'static, T: 'static>(&self) -> Vec<(I, Reporter<T>)> {
        let all = &mut self.solver.0.borrow_mut().begun;
        let is = |work: &mut Box<dyn Work>| (&**work as &dyn Any).is::<Computation<I, T>>();
        let these = all.extract_if(.., is);
        these
            .filter_map(|work| (work as Box<dyn Any>).downcast::<Computation<I, T>>().ok())
            .map(|work| (work.input, work.report))
            .collect()
    }

    /// The time-step map that was asked for.
    pub fn time_steps(&self) -> ((Arc<Scene>, f64), Reporter<TimeStepMap>) {
        self.begun().pop().expect("it was asked for")
    }

    /// The chart that was asked for.
    pub fn chart(&self) -> (Effort, Reporter<ChartSoFar>) {
        let asked = self.begun::<(Arc<Scene>, Effort), _>().pop();
        let ((_, effort), report) = asked.expect("it was asked for");
        (effort, report)
    }

    /// The diagrams of branches that were asked for since the last call.
    pub fn diagrams(&self) -> Vec<(Arc<Scene>, Reporter<Arc<Diagram>>)> {
        self.begun()
    }

    /// The landscapes that were asked for since the last call.
    pub fn landscapes(&self) -> Vec<(Asked, Reporter<Arc<Landscape>>)> {
        self.begun()
    }

    /// Does what was begun and waits, to its end.
    pub fn run_jobs(&mut self) {
        let begun = std::mem::take(&mut self.solver.0.borrow_mut().begun);
        begun.into_iter().for_each(Work::run);
        self.settle();
    }

    /// The pages that were asked for since the last call.
    pub fn pages(&self) -> Vec<(Page, Reporter<PageContent>)> {
        self.begun()
    }

    /// Where the solver was told to go since the last call.
    pub fn targets(&self) -> Vec<f64> {
        let target = |command| match command {
            Command::Play {
                play: Play::ToTarget(control),
                ..
            } => Some(control),
            _ => None,
        };
        self.heard().into_iter().filter_map(target).collect()
    }

    /// The scenes that it was told since the last call.
    pub fn scenes(&self) -> Vec<Scene> {
        let scene = |command| match command {
            Command::SetScene { scene, .. } => Some((*scene).clone()),
            _ => None,
        };
        self.heard().into_iter().filter_map(scene).collect()
    }

    /// The solver says something of the present run.
    pub fn say(&mut self, event: Event) {
        self.say_of(self.view().run.id, event);
    }

    /// The solver says something of this run.
    pub fn say_of(&mut self, run: RunId, message: Event) {
        self.hear([Envelope { run, message }]);
    }

    /// The solver accepts the scene and says which model runs.
    pub fn ready(&mut self) {
        let state = self.view();
        let plan = plan(&state.scene, &self.model, state.asked);
        let choice = ModelChoice {
            plan,
            part: Part::Quarter,
            because: None,
        };
        let ready = Ready {
            model: self.model.clone(),
            height: None,
            choice,
        };
        self.say(Event::Ready(Arc::new(ready)));
    }

    /// The solver comes down, or up, to the flat state at `u0`.
    pub fn down(&mut self, u0: f64) {
        self.reach(u0, Direction::Approach);
    }

    pub fn up(&mut self, u0: f64) {
        self.reach(u0, Direction::Retraction);
    }

    /// The closed form of the flat state.
    fn reach(&mut self, u0: f64, direction: Direction) {
        let law = self.model.law;
        let stress = law.at(u0).traction;
        let state = StateRecord {
            direction,
            control: u0,
            mean_displacement: u0,
            stress,
            stress_over_max: stress / law.traction_max(),
            contact_area: 0.0,
            pattern: Pattern::Flat,
            residual: 0.0,
            stiffness_min: flat_stiffness(&law, self.model.grid.length, u0),
            stiffness_error: 0.0,
            energy: law.at(u0).energy,
            part: Part::Flat,
            stop: Stop::Stable,
            iterations: 0,
            transforms: 0,
            milliseconds: 0.01,
        };
        let gap = Arc::new(Array2::from_elem(self.model.grid.shape(), u0));
        let frame = Frame {
            control: u0,
            mean_displacement: u0,
            stress,
            gap,
            soft_mode: None,
            relaxing: false,
            state: Some(state.clone()),
        };
        let run = self.view().run.id;
        let said = [Event::State(state), Event::Frame(Arc::new(frame))]
            .map(|message| Envelope { run, message });
        self.hear(said);
    }

    fn hear(&mut self, said: impl IntoIterator<Item = Envelope<Event>>) {
        self.solver.0.borrow_mut().events.extend(said);
        self.window.step();
        self.settle();
    }

    pub fn jump(&mut self, u0: f64) {
        self.jump_on(Direction::Approach, u0);
    }

    pub fn jump_on(&mut self, direction: Direction, u0: f64) {
        let jump = JumpRecord {
            direction,
            control: u0,
            mean_displacement: u0,
            mean_displacement_after: u0,
            from: Pattern::Flat,
            to: Pattern::Ridge,
            stress_before: 0.01,
            stress_after: 0.03,
            released_energy: 0.1234,
            release_error: 0.0,
            cause: Cause::FlatLimit,
            landings: Vec::new(),
        };
        self.say(Event::Jump(jump));
    }

    pub fn click(&mut self, label: &str) {
        self.unfold(label);
        self.window.hit(label);
    }

    /// Brings a control into sight as people do: it scrolls, and what is not there is looked for in
    /// the menus and in the fold.
    pub fn unfold(&mut self, label: &str) {
        const FOLDS: [&str; 6] = [
            "Advanced",
            "More tabs",
            "Files",
            "Map options",
            "Menu",
            "Scene",
        ];
        for fold in FOLDS {
            if self.scroll_to(label) {
                return;
            }
            if self.scroll_to(fold) {
                self.window.hit(fold);
                if !self.scroll_to(label) && fold != "Scene" {
                    self.window.hit(fold);
                }
            }
        }
    }

    /// Scrolls to a control that is there, above the status bar; false if there is none.
    fn scroll_to(&mut self, label: &str) -> bool {
        let screen = self.window.ctx.content_rect();
        let sight = screen.with_max_y(screen.max.y - 40.0);
        let Some(node) = self.window.query_all_by_label(label).next() else {
            return false;
        };
        if !sight.contains(node.rect().center()) {
            node.scroll_to_me();
            self.settle();
        }
        true
    }

    /// Everything that is said while the card behind the chip of the status bar is open.
    pub fn status(&mut self) -> String {
        const CHIPS: [&str; 4] = [
            "exact to",
            "no accuracy is promised",
            "no equilibrium",
            "not computed",
        ];
        let chip = |words: &&str| named_from(&self.window, words).is_some();
        let chip = CHIPS.into_iter().find(chip).expect("a chip");
        let open = |bench: &mut Self| {
            let node = named_from(&bench.window, chip);
            node.expect("the chip").click();
            bench.settle();
        };
        open(self);
        let names = self.window.names();
        self.press(Modifiers::NONE, Key::Escape);
        names
    }

    /// A job that was asked for ends with this.
    pub fn answer<T>(&mut self, report: &Reporter<T>, result: T) {
        report.result(result);
        report.end(Ok(()));
        self.settle();
    }

    pub fn ctrl(&mut self, key: Key) {
        self.press(Modifiers::COMMAND, key);
    }

    pub fn press(&mut self, modifiers: Modifiers, key: Key) {
        self.window.key_press_modifiers(modifiers, key);
        self.settle();
    }

    /// Drags from the middle of the control with this label.
    pub fn drag(&mut self, label: &str, by: &[egui::Vec2]) {
        self.unfold(label);
        self.window.get_by_label(label).scroll_to_me();
        self.settle();
        let from = self.window.place_of(label).center();
        self.window.drag_along(from, by);
    }

    /// Types into the field with this label.
    pub fn enter(&mut self, label: &str, text: &str) {
        self.unfold(label);
        self.window.field(label).scroll_to_me();
        self.settle();
        self.window.field(label).click();
        self.window.run();
        self.window.write_over(text);
        self.press(Modifiers::NONE, Key::Enter);
    }

    /// Runs what the palette finds; everything that was said before that.
    pub fn command(&mut self, words: &str) -> String {
        self.press(Modifiers::COMMAND, Key::K);
        self.window.write(words);
        let found = self.window.names();
        self.press(Modifiers::NONE, Key::Enter);
        found
    }

    /// The accessible sentence of the plot.
    pub fn plot_sentence(&self) -> String {
        let names = self.window.names();
        let mut lines = names.lines();
        let sentence = lines.find(|line| line.starts_with("Stress against u0:"));
        sentence.expect("the plot says a sentence").to_owned()
    }

    /// Presses a button of the mouse at a place, or lets it go.
    pub fn button(&mut self, at: egui::Pos2, button: egui::PointerButton, pressed: bool) {
        self.window.event(egui::Event::PointerButton {
            pos: at,
            button,
            pressed,
            modifiers: Modifiers::NONE,
        });
        self.window.step();
    }
}
