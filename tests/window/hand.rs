//! What is done to a window by hand, and what is read on it, whatever solver is behind it; and the
//! window with a solver that has no thread: its session is stepped in the frame.

use super::bench::coarse;
use egui::{Event as Input, Key, Modifiers, Pos2, Rect, Role, Vec2, vec2};
use egui_kittest::kittest::{NodeT, Queryable};
use egui_kittest::{Harness, LazyRenderer, Node, TestRenderer};
use std::any::Any;
use std::cell::{Cell, RefCell};
use std::path::PathBuf;
use std::sync::Arc;
use std::thread::sleep;
use std::time::{Duration, Instant};
use tackscope::numerics::threads::Cancel;
use tackscope::scene::Scene;
use tackscope::study::live_loop::{Fineness, LiveLoops};
use tackscope::ui::view_state::ViewState;
use tackscope::ui::{App, theme};
use tackscope::worker::SolverHandle;
use tackscope::worker::background::Wanted;
use tackscope::worker::job::{Computation, Wake, Work};
use tackscope::worker::protocol::{Command, Envelope, Event, LiveState, RunId, Stored};
use tackscope::worker::session::Session;
use tempfile::TempDir;

/// The window under test.
pub type Window = Harness<'static, App>;

pub trait Hand {
    /// What is shown.
    fn view(&self) -> &ViewState;

    /// Every name and every value on the screen, a line each.
    fn names(&self) -> String;

    /// Where something stands whose name has these words in it.
    fn place(&self, words: &str) -> Rect;

    /// Where that of this very name stands.
    fn place_of(&self, name: &str) -> Rect;

    /// The whole name of that in whose name these words are.
    fn name(&self, words: &str) -> String;

    /// Clicks what has this name.
    fn hit(&mut self, name: &str);

    fn tap(&mut self, key: Key);

    /// Types into what has the focus.
    fn write(&mut self, text: &str);

    /// Types in place of what is there.
    fn write_over(&mut self, text: &str);

    /// The field for the number of this name.
    fn field<'a>(&'a self, name: &'a str) -> Node<'a>;

    fn click_at(&mut self, at: Pos2);

    /// Presses at a place, goes by these ways from there, and lets go at the last.
    fn drag_along(&mut self, from: Pos2, by: &[Vec2]);

    /// Draws until the surface rests.
    fn rest(&mut self);

    /// Plays by this button, until the surface rests.
    fn play(&mut self, button: &str);

    /// Goes on from what is looked at.
    fn go_on(&mut self);

    /// Takes the last edit back, and draws until the surface is where it was.
    fn undo(&mut self);

    /// Draws until no file is being read or written any more.
    fn wait_for_file(&mut self);

    /// Begins what the palette finds.
    fn begin(&mut self, words: &str);

    /// Does what the palette finds, and draws until the surface rests.
    fn act(&mut self, words: &str) {
        self.begin(words);
        self.rest();
    }

    #[track_caller]
    fn says(&self, words: &str) {
        let names = self.names();
        assert!(names.contains(words), "{words} in {names}");
    }

    #[track_caller]
    fn lacks(&self, words: &str) {
        let names = self.names();
        assert!(!names.contains(words), "{words} in {names}");
    }
}

impl Hand for Window {
    fn view(&self) -> &ViewState {
        self.state().state()
    }

    fn names(&self) -> String {
        let mut all = String::new();
        for node in self.root().children_recursive() {
            let node = node.accesskit_node();
            for words in [node.label(), node.value()].into_iter().flatten() {
                all.push_str(&words);
                all.push('\n');
            }
        }
        all
    }

    fn place(&self, words: &str) -> Rect {
        self.get_by_label_contains(words).rect()
    }

    fn place_of(&self, name: &str) -> Rect {
        self.get_by_label(name).rect()
    }

    fn name(&self, words: &str) -> String {
        let node = self.get_by_label_contains(words);
        node.accesskit_node().label().expect("a name")
    }

    fn hit(&mut self, name: &str) {
        self.get_by_label(name).click();
        self.run();
    }

    fn tap(&mut self, key: Key) {
        self.key_press(key);
        self.run();
    }

    fn write(&mut self, text: &str) {
        self.event(Input::Text(text.to_owned()));
        self.run();
    }

    fn write_over(&mut self, text: &str) {
        self.key_press_modifiers(Modifiers::COMMAND, Key::A);
        self.run();
        self.write(text);
    }

    fn field<'a>(&'a self, name: &'a str) -> Node<'a> {
        self.get_by_role_and_label(Role::SpinButton, name)
    }

    fn click_at(&mut self, at: Pos2) {
        self.drag_along(at, &[]);
    }

    fn drag_along(&mut self, from: Pos2, by: &[Vec2]) {
        self.hover_at(from);
        self.step();
        self.drag_at(from);
        self.step();
        for by in by {
            self.hover_at(from + *by);
            self.step();
        }
        self.drop_at(from + by.last().copied().unwrap_or_default());
        self.run();
    }

    fn rest(&mut self) {
        self.run_steps(4);
        let mut frames = 0;
        while self.view().run.is_busy() {
            self.step();
            frames += 1;
            assert!(frames < 3000, "it never comes to rest");
        }
    }

    fn play(&mut self, button: &str) {
        self.get_by_label(button).click();
        self.step();
        self.rest();
    }

    fn go_on(&mut self) {
        self.key_press(Key::G);
        self.step();
        self.run();
    }

    fn undo(&mut self) {
        self.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        self.run_steps(20);
    }

    fn wait_for_file(&mut self) {
        let begun = Instant::now();
        let busy = |notice: &String| notice.ends_with('…');
        while self.view().messages.notice.as_ref().is_some_and(busy) {
            assert!(begun.elapsed() < Duration::from_secs(60), "it ends");
            sleep(Duration::from_millis(2));
            self.step();
        }
        self.run();
    }

    fn begin(&mut self, words: &str) {
        self.key_press_modifiers(Modifiers::COMMAND, Key::K);
        self.rest();
        self.event(Input::Text(words.to_owned()));
        self.step();
        self.key_press(Key::Enter);
    }
}

/// A folder that goes with the test.
pub fn folder() -> TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

/// A path of this name in such a folder, which is to be held.
pub fn place_for(name: &str) -> (TempDir, PathBuf) {
    let folder = folder();
    let path = folder.path().join(name);
    (folder, path)
}

/// What has a name that begins with these words.
pub fn named_from<'a>(window: &'a Window, words: &'a str) -> Option<Node<'a>> {
    let begins = |node: &Node<'_>| {
        let name = node.accesskit_node().label();
        name.is_some_and(|name| name.starts_with(words))
    };
    window.query_all_by_label_contains(words).find(begins)
}

/// Steps of the session in a frame, on a mesh of up to so many points; on larger ones fewer.
const STEPS: usize = 20;
const POINTS: usize = 64 * 64;

/// What it does beside its session.
#[derive(Clone, Copy, Default, PartialEq)]
enum Beside {
    /// Foreseen states and live loops, where they are asked for.
    #[default]
    Little,
    /// A live loop of every scene as well.
    Loops,
    /// Every job to its end in the moment it is begun as well.
    Jobs,
}

#[derive(Default)]
struct Stepped {
    session: RefCell<Session>,
    said: RefCell<Vec<Envelope<Event>>>,
    /// Points of the mesh.
    points: Cell<usize>,
    beside: Beside,
}

impl Stepped {
    /// The live loop of a scene.
    fn foretell(&self, run: RunId, scene: &Scene) {
        let found =
            LiveLoops::default().next(scene, &scene.model().expect("allowed"), Fineness::Fine);
        let live = LiveState {
            found: found.map_err(|why| why.to_string()),
            fineness: Fineness::Fine,
            milliseconds: 1.0,
        };
        let message = Event::Live(Arc::new(live));
        self.said.borrow_mut().push(Envelope { run, message });
    }
}

impl SolverHandle for Stepped {
    fn send(&self, command: Envelope<Command>) {
        let run = command.run;
        if let Command::SetScene { scene, .. } = &command.message {
            let model = scene.model().expect("allowed");
            self.points.set(model.grid.nx * model.grid.ny);
            if self.beside != Beside::Little {
                self.foretell(run, scene);
            }
        }
        let mut said = self.said.borrow_mut();
        self.session
            .borrow_mut()
            .command(command, &Cancel::default(), &mut |message| {
                said.push(Envelope { run, message });
            });
    }

    fn poll(&self) -> Vec<Envelope<Event>> {
        let mut session = self.session.borrow_mut();
        let mut said = self.said.take();
        let (run, now) = (session.run(), Instant::now());
        for _ in 0..(STEPS * POINTS / self.points.get().max(1)).clamp(1, STEPS) {
            if session.wait(now + Duration::from_secs(3600)).is_none() {
                break;
            }
            session.step(now, &Cancel::default(), &mut |message| {
                said.push(Envelope { run, message });
            });
        }
        said
    }

    fn wake(&self) -> Wake {
        Arc::new(|| {})
    }

    fn begin(&self, work: Box<dyn Work>) {
        let any = &*work as &dyn Any;
        if self.beside == Beside::Jobs
            || any.is::<Computation<Wanted, Arc<Stored>>>()
            || any.is::<Computation<Arc<Scene>, Arc<LiveState>>>()
        {
            work.run();
        }
    }
}

/// The window on a scene, with a session that is stepped in the frame.
pub fn opened(scene: Scene) -> Window {
    of(
        Beside::Little,
        ViewState::new(scene).expect("allowed"),
        LazyRenderer::default(),
    )
}

/// The same beside a live loop.
pub fn foretold(scene: Scene) -> Window {
    of(
        Beside::Loops,
        ViewState::new(scene).expect("allowed"),
        LazyRenderer::default(),
    )
}

/// The same in this state, with every job done at once, drawn by `renderer`.
pub fn computing(state: ViewState, renderer: impl TestRenderer + 'static) -> Window {
    of(Beside::Jobs, state, renderer)
}

fn of(beside: Beside, state: ViewState, renderer: impl TestRenderer + 'static) -> Window {
    let solver = Stepped {
        beside,
        ..Stepped::default()
    };
    let app = App::with_chooser(solver, state, |_| {
        Box::pin(std::future::ready(None::<PathBuf>))
    });
    let mut window = Harness::builder()
        .with_size(vec2(1280.0, 800.0))
        .with_context_setup(theme::install)
        .renderer(renderer)
        .build_ui_state(|ui, app: &mut App| app.frame(ui), app);
    window.run();
    window
}

#[test]
fn the_window_plays_a_loop_with_a_session_stepped_in_the_frame() {
    let mut window = opened(coarse(32));
    window.get_by_label("Play loop").click();
    window.step();
    assert!(window.view().run.is_busy());
    window.rest();
    let run = &window.view().run;
    let closed = run.closed_loop.as_ref().expect("the loop is closed");
    let loss = closed.summary.ledger.dissipated_energy();
    assert!(loss.is_some_and(|loss| loss > 0.1), "{closed:?}");
    assert!(
        run.record.jumps.len() >= 6 && window.view().frame.is_some(),
        "{:?}",
        run.record.jumps
    );
    assert_eq!(run.actual, window.view().limits.1);
}
