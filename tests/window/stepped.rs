//! The window with a solver that has no thread: its session is stepped in the frame.

use super::bench::coarse;
use super::hand::{Hand, Window};
use egui::vec2;
use egui_kittest::kittest::Queryable;
use egui_kittest::{Harness, LazyRenderer, TestRenderer};
use std::any::Any;
use std::cell::{Cell, RefCell};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};
use tackscope::numerics::cancel::Cancel;
use tackscope::scene::Scene;
use tackscope::study::live_loop::{Fineness, LiveLoops};
use tackscope::ui::App;
use tackscope::ui::theme;
use tackscope::ui::view_state::ViewState;
use tackscope::worker::SolverHandle;
use tackscope::worker::background::Wanted;
use tackscope::worker::job::{Computation, Wake, Work};
use tackscope::worker::protocol::{Command, Envelope, Event, LiveState, RunId, Stored};
use tackscope::worker::session::Session;

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
