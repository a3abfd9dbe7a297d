//! The window with a solver that has no thread: its session is stepped in the frame.

use super::bench::fig2;
use egui::vec2;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use std::any::Any;
use std::cell::RefCell;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};
use tackscope::numerics::cancel::Cancel;
use tackscope::scene::{Points, Scene};
use tackscope::study::live_loop::{Fineness, LiveLoops};
use tackscope::ui::App;
use tackscope::ui::theme;
use tackscope::ui::view_state::ViewState;
use tackscope::worker::SolverHandle;
use tackscope::worker::background::Wanted;
use tackscope::worker::job::{Computation, Wake, Work};
use tackscope::worker::protocol::{Command, Envelope, Event, LiveState, RunId, Stored};
use tackscope::worker::session::Session;

/// Steps of the session in a frame.
const STEPS: usize = 20;

#[derive(Default)]
struct Stepped {
    session: RefCell<Session>,
    said: RefCell<Vec<Envelope<Event>>>,
    /// Whether it foretells loops.
    foretells: bool,
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
        if let Command::SetScene { scene, .. } = &command.message
            && self.foretells
        {
            self.foretell(run, scene);
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
        for _ in 0..STEPS {
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

    /// Only what is found of live loops.
    fn begin(&self, work: Box<dyn Work>) {
        let any = &*work as &dyn Any;
        if any.is::<Computation<Wanted, Arc<Stored>>>()
            || any.is::<Computation<Arc<Scene>, Arc<LiveState>>>()
        {
            work.run();
        }
    }
}

/// The window on a scene, with a session that is stepped in the frame.
pub fn opened(scene: Scene) -> Harness<'static, App> {
    of(Stepped::default(), scene)
}

/// The same beside a live loop.
pub fn foretold(scene: Scene) -> Harness<'static, App> {
    let solver = Stepped {
        foretells: true,
        ..Stepped::default()
    };
    of(solver, scene)
}

fn of(solver: Stepped, scene: Scene) -> Harness<'static, App> {
    let app = App::with_chooser(solver, ViewState::new(scene).expect("allowed"), |_| {
        Box::pin(std::future::ready(None::<PathBuf>))
    });
    let mut window = Harness::builder()
        .with_size(vec2(1280.0, 800.0))
        .with_context_setup(theme::install)
        .build_ui_state(|ui, app: &mut App| app.frame(ui), app);
    window.run();
    window
}

#[test]
fn the_window_plays_a_loop_with_a_session_stepped_in_the_frame() {
    let mut scene = fig2();
    scene.cell.points = Points::Square(32);
    let mut window = opened(scene);
    window.get_by_label("Play loop").click();
    window.step();
    assert!(window.state().state().run.is_busy());
    let mut frames = 0;
    while window.state().state().run.is_busy() && frames < 1000 {
        window.step();
        frames += 1;
    }
    let run = &window.state().state().run;
    let closed = run.closed_loop.as_ref().expect("the loop is closed");
    assert!(
        frames > 3
            && closed
                .summary
                .ledger
                .dissipated_energy()
                .is_some_and(|loss| loss > 0.1),
        "{frames} {closed:?}"
    );
    assert!(
        run.record.jumps.len() >= 6 && window.state().state().frame.is_some(),
        "{:?}",
        run.record.jumps
    );
    assert_eq!(run.actual, window.state().state().limits.1);
}
