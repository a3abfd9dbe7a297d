//! The solver thread as the window meets it: latest target, kept path, quick cancel, stale runs,
//! films of jumps.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};
use tackscope::follow::record::StateRecord;
use tackscope::follow::run::{Outcome, run_loop};
use tackscope::follow::walk::WalkOptions;
use tackscope::numerics::threads::Cancel;
use tackscope::physics::indenter::{Hertz, Indenter};
use tackscope::physics::pattern::Pattern;
use tackscope::scene::{Part, Points, Range, Scene, Strategy, Turn};
use tackscope::solver::methods::MethodKind;
use tackscope::storage;
use tackscope::study::chart::Effort;
use tackscope::study::live_loop::Fineness;
use tackscope::worker::background::{self, Page, PageContent};
use tackscope::worker::job::Job;
use tackscope::worker::protocol::{Command, Envelope, Event, Failure, Frame, Play, Speed, Sweep};
use tackscope::worker::session::Session;
use tackscope::worker::{SolverHandle, Worker};

fn fig2(points: usize) -> Scene {
    let mut scene = storage::resolve("fig2").unwrap();
    scene.cell.points = Points::Square(points);
    scene
}

fn of(run: u64, message: Command) -> Envelope<Command> {
    Envelope { run, message }
}

fn set_scene(run: u64, scene: Scene) -> Envelope<Command> {
    wished(run, scene, None)
}

fn wished(run: u64, scene: Scene, asked: Option<Strategy>) -> Envelope<Command> {
    of(
        run,
        Command::SetScene {
            scene: Arc::new(scene),
            method: MethodKind::NewtonKrylov,
            asked,
            from: None,
        },
    )
}

fn target(run: u64, motion: u64, control: f64) -> Envelope<Command> {
    of(
        run,
        Command::Play {
            motion,
            play: Play::ToTarget(control),
        },
    )
}

fn sweep(run: u64, motion: u64, sweep: Sweep) -> Envelope<Command> {
    of(
        run,
        Command::Play {
            motion,
            play: Play::Sweep(sweep),
        },
    )
}

/// Steps a session by hand, at no pace, until it rests; returns everything it handed out.
fn drain(session: &mut Session, commands: Vec<Envelope<Command>>) -> Vec<Event> {
    let mut out = Vec::new();
    for command in commands {
        session.command(command, &Cancel::default(), &mut |o| out.push(o));
    }
    let now = Instant::now();
    while session.wait(now + Duration::from_secs(3600)).is_some() {
        session.step(now, &Cancel::default(), &mut |o| out.push(o));
    }
    out
}

/// What these events of one kind hold.
macro_rules! picked {
    ($events:expr, $event:pat => $what:expr) => {
        $events.iter().filter_map(|event| match event {
            $event => Some($what),
            _ => None,
        })
    };
}

fn frames(out: &[Event]) -> impl Iterator<Item = &Frame> {
    picked!(out, Event::Frame(frame) => &**frame)
}

#[test]
fn a_target_far_away_is_reached_in_steps_no_longer_than_the_scenes() {
    let mut session = Session::default();
    let out = drain(
        &mut session,
        vec![set_scene(1, fig2(32)), target(1, 1, 2.0)],
    );
    let path: Vec<f64> = picked!(out, Event::State(state) => state.mean_displacement).collect();
    assert_eq!(*path.last().unwrap(), 2.0);
    assert!(
        path.windows(2)
            .all(|w| w[0] - w[1] <= 0.02 + 1e-9 && w[1] <= w[0]),
        "{path:?}"
    );
}

#[test]
fn slow_motion_takes_four_times_as_long_and_full_speed_does_not_wait() {
    let mut session = Session::default();
    drain(&mut session, vec![set_scene(1, fig2(32))]);
    session.command(
        sweep(1, 1, Sweep::Approach),
        &Cancel::default(),
        &mut |_| (),
    );
    let mut pause = |speed| {
        session.command(
            of(1, Command::SetSpeed { speed }),
            &Cancel::default(),
            &mut |_| (),
        );
        let now = Instant::now();
        session.step(now, &Cancel::default(), &mut |_| ());
        session.wait(now).expect("it is under way")
    };
    let normal = pause(Speed::Normal);
    assert!(normal > Duration::ZERO);
    assert_eq!(
        [pause(Speed::Slow), pause(Speed::Full)],
        [4 * normal, Duration::ZERO]
    );
}

#[test]
fn a_jump_is_seen_as_a_film_and_told_once() {
    let mut session = Session::default();
    let out = drain(
        &mut session,
        vec![set_scene(1, fig2(64)), target(1, 1, 3.05)],
    );
    let film = frames(&out)
        .filter(|frame| frame.relaxing && frame.state.is_none())
        .count();
    let jumps: Vec<_> = picked!(out, Event::Jump(jump) => (jump.from, jump.to)).collect();
    assert_eq!(jumps, [(Pattern::Flat, Pattern::Bulge)]);
    assert!(film >= 5, "{film} pictures");
}

#[test]
fn a_closed_loop_reports_a_ledger_that_agrees() {
    let mut session = Session::default();
    let out = drain(
        &mut session,
        vec![set_scene(1, fig2(64)), sweep(1, 1, Sweep::Loop)],
    );
    let summary = picked!(out, Event::Loop(summary) => summary.clone()).next();
    let summary = summary.expect("a loop was closed");
    let ledger = &summary.ledger;
    assert!(
        ledger.dissipated_energy().unwrap() > 0.1
            && ledger.mismatch().unwrap() < 1e-4
            && ledger.warning().is_none(),
        "{ledger:?}"
    );
}

#[test]
fn a_loop_made_by_hand_is_told_once_also_when_the_hand_goes_on() {
    let mut session = Session::default();
    let out = drain(
        &mut session,
        vec![set_scene(1, fig2(32)), target(1, 1, 0.4)],
    );
    let losses = |out: &[Event]| -> Vec<f64> {
        let loss = |e: &Event| match e {
            Event::Loop(summary) => summary.ledger.dissipated_energy(),
            _ => None,
        };
        out.iter().filter_map(loss).collect()
    };
    assert!(losses(&out).is_empty());
    let back = drain(&mut session, vec![target(1, 2, 4.1)]);
    let released = out.iter().chain(&back).filter_map(|e| match e {
        Event::Jump(jump) => Some(jump.released_energy),
        _ => None,
    });
    assert_eq!(losses(&back), [released.sum::<f64>()]);
    let on = drain(&mut session, vec![target(1, 3, 3.5), target(1, 4, 4.15)]);
    assert!(losses(&on).is_empty());
}

#[test]
fn commands_of_an_older_run_are_dropped() {
    let mut session = Session::default();
    let out = drain(
        &mut session,
        vec![
            set_scene(1, fig2(32)),
            set_scene(2, fig2(32)),
            target(1, 1, 1.0),
        ],
    );
    let moved = out
        .iter()
        .any(|e| matches!(e, Event::State(state) if state.mean_displacement < 4.2));
    assert!(!moved);
}

#[test]
fn a_scene_that_cannot_run_is_refused_in_words() {
    let mut scene = fig2(64);
    scene.law.surface_energy = f64::NAN;
    let out = drain(&mut Session::default(), vec![set_scene(1, scene)]);
    let [Event::Failed(Failure { message, remedy })] = &out[..] else {
        panic!("one refusal expected")
    };
    assert!(
        message.contains("law.surface_energy")
            && message.contains("NaN")
            && remedy.contains("above 0"),
        "{message} {remedy}"
    );
}

/// Waits until the worker has shown `event`, at most a minute: other tests may load the machine.
fn await_event(worker: &Worker, mut wanted: impl FnMut(u64, &Event) -> bool) {
    let begin = Instant::now();
    while begin.elapsed() < Duration::from_secs(60) {
        if worker
            .next_event(Duration::from_millis(50))
            .is_some_and(|e| wanted(e.run, &e.message))
        {
            return;
        }
    }
    panic!("the event did not come");
}

#[test]
fn stop_is_answered_in_the_middle_of_a_large_increment_and_the_thread_goes_on() {
    let wakes = Arc::new(AtomicUsize::new(0));
    let counter = wakes.clone();
    let worker = Worker::spawn(move || {
        counter.fetch_add(1, Ordering::Relaxed);
    });
    worker.send(set_scene(1, fig2(256)));
    await_event(&worker, |_, e| matches!(e, Event::Rest { .. }));
    worker.send(target(1, 1, 0.5));
    // In the thick of the first jump.
    await_event(
        &worker,
        |_, e| matches!(e, Event::State(state) if state.mean_displacement < 3.12),
    );
    std::thread::sleep(Duration::from_millis(30));
    let begin = Instant::now();
    worker.send(of(
        1,
        Command::Play {
            motion: 2,
            play: Play::Rest,
        },
    ));
    await_event(&worker, |_, e| matches!(e, Event::Rest { .. }));
    let answered = begin.elapsed();
    println!("stop answered after {answered:?}");
    // 50 ms are promised; a loaded test machine may itself sleep longer than that.
    assert!(answered < Duration::from_millis(500), "{answered:?}");
    worker.send(target(1, 3, 4.2));
    await_event(&worker, |_, e| matches!(e, Event::Rest { motion: 3, .. }));
    assert!(wakes.load(Ordering::Relaxed) > 5);
}

#[test]
fn the_latest_of_many_targets_is_where_it_rests() {
    let worker = Worker::spawn(|| {});
    worker.send(set_scene(7, fig2(32)));
    await_event(&worker, |_, e| matches!(e, Event::Rest { .. }));
    for i in 0..100 {
        worker.send(target(7, i + 1, 4.2 - 0.005 * i as f64));
    }
    worker.send(target(7, 101, 4.0));
    await_event(
        &worker,
        |_, e| matches!(e, Event::Rest { control, .. } if *control == 4.0),
    );
}

#[test]
fn every_rest_names_the_motion_it_ends_and_an_older_motion_is_dropped() {
    let mut session = Session::default();
    let to = |motion, mean_displacement| target(1, motion, mean_displacement);
    let rests = |out: &[Event]| -> Vec<u64> {
        picked!(out, Event::Rest { motion, .. } => *motion).collect()
    };
    assert_eq!(
        rests(&drain(
            &mut session,
            vec![set_scene(1, fig2(32)), to(1, 4.1)]
        )),
        [0, 1]
    );
    // A stop while it rests, and a sweep within milliseconds: the rest of the stop is not the end
    // of the sweep.
    let sweep = sweep(1, 3, Sweep::Retract);
    assert_eq!(
        rests(&drain(
            &mut session,
            vec![
                of(
                    1,
                    Command::Play {
                        motion: 2,
                        play: Play::Rest
                    }
                ),
                sweep
            ]
        )),
        [2, 3]
    );
    let out = drain(
        &mut session,
        vec![
            to(5, 4.1),
            of(
                1,
                Command::Play {
                    motion: 4,
                    play: Play::Rest,
                },
            ),
            to(4, 4.0),
        ],
    );
    assert!(matches!(out.last(), Some(Event::Rest { motion: 5, control }) if *control == 4.1));
}

#[test]
fn a_picture_at_rest_carries_the_soft_mode_and_a_moving_one_does_not() {
    let mut session = Session::default();
    let out = drain(
        &mut session,
        vec![set_scene(1, fig2(32)), target(1, 1, 3.05)],
    );
    let (mut resting, mut moving) = (0, 0);
    for frame in frames(&out) {
        assert!(!(frame.relaxing && frame.soft_mode.is_some()));
        moving += usize::from(frame.relaxing);
        if let Some(mode) = &frame.soft_mode {
            let square = mode.iter().map(|v| v * v).sum::<f64>() / mode.len() as f64;
            assert!((square - 1.0).abs() < 1e-6, "{square}");
            resting += 1;
        }
    }
    assert!(resting > 10 && moving > 3, "{resting} {moving}");
}

/// The worker as the window sees it.
fn beside(worker: &Worker) -> &dyn SolverHandle {
    worker
}

/// Waits until a job has ended, at most a minute, calling `look` now and then.
fn await_end<T>(job: &mut Job<T>, mut look: impl FnMut(&Job<T>)) -> Result<(), String> {
    let begin = Instant::now();
    while begin.elapsed() < Duration::from_secs(60) {
        if let Some(end) = job.poll() {
            return end;
        }
        look(job);
        std::thread::sleep(Duration::from_millis(5));
    }
    panic!("the job did not end");
}

#[test]
fn time_steps_are_measured_beside_the_walk_and_the_newest_measurement_takes_the_place_of_the_others()
 {
    let worker = Worker::spawn(|| {});
    let scene = Arc::new(fig2(16));
    let mut job = beside(&worker).job((scene.clone(), 0.2), background::time_steps);
    job = {
        drop(job);
        beside(&worker).job((scene.clone(), 0.2), background::time_steps)
    };
    worker.send(set_scene(2, fig2(16)));
    job.stop();
    assert!(!job.is_running());
    job = beside(&worker).job((scene, 0.2), background::time_steps);
    let mut partial = 0;
    assert_eq!(
        await_end(&mut job, |job| partial += usize::from(
            job.so_far
                .as_ref()
                .is_some_and(|map| map.stable.len() < 100)
        )),
        Ok(())
    );
    let cells = job.so_far.as_ref().map_or(0, |map| map.stable.len());
    assert!(cells > 100 && partial > 0, "{cells} {partial}");
}

#[test]
fn the_live_loop_of_the_newest_scene_comes_coarse_first_and_fine_when_the_scenes_stop_changing() {
    let worker = Worker::spawn(|| {});
    let last = 30;
    let began = Instant::now();
    for run in 1..=last {
        let mut scene = fig2(32);
        scene.law.range = Range::Length(1.0 + 0.002 * run as f64);
        worker.send(set_scene(run, scene));
    }
    assert!(
        began.elapsed() < Duration::from_millis(100),
        "asking must not wait"
    );
    let mut told = Vec::new();
    await_event(&worker, |run, e| {
        if let Event::Live(live) = e {
            assert!(live.found.is_ok(), "{live:?}");
            told.push((run, live.fineness));
        }
        matches!(e, Event::Live(live) if live.fineness == Fineness::Fine)
    });
    assert_eq!(told.last(), Some(&(last, Fineness::Fine)));
    assert!(
        told.contains(&(last, Fineness::Coarse)) && told.len() < 10,
        "{told:?}"
    );
    assert!(told.windows(2).all(|w| w[0].0 <= w[1].0), "{told:?}");
}

#[test]
fn a_chart_is_told_as_it_grows_and_stops_when_asked() {
    let worker = Worker::spawn(|| {});
    let mut job = beside(&worker).job((Arc::new(fig2(32)), Effort::Quick), background::chart);
    let begin = Instant::now();
    while job
        .so_far
        .as_ref()
        .is_none_or(|chart| chart.rows.is_empty())
    {
        assert!(job.poll().is_none() && begin.elapsed() < Duration::from_secs(60));
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(
        job.fraction > 0.0 && job.fraction < 1.0 && !job.doing.is_empty(),
        "{} {}",
        job.fraction,
        job.doing
    );
    let begin = Instant::now();
    job.stop();
    // The errors of the reference come last.
    while job
        .so_far
        .as_ref()
        .is_none_or(|chart| chart.floor.is_none())
    {
        assert!(
            job.poll().is_none() && begin.elapsed() < Duration::from_secs(2),
            "{:?}",
            begin.elapsed()
        );
        std::thread::sleep(Duration::from_millis(5));
    }
    println!("stopped after {:?}", begin.elapsed());
}

#[test]
fn pages_of_the_paper_are_computed_beside_the_walk_and_one_that_is_dropped_says_no_more() {
    let worker = Worker::spawn(|| {});
    let mut dropped = beside(&worker).job(Page::Figure(2), background::page);
    dropped.stop();
    worker.send(set_scene(1, fig2(16)));
    let mut theory = beside(&worker).job(Page::Theory, background::page);
    assert_eq!(await_end(&mut theory, |_| {}), Ok(()));
    assert!(matches!(theory.so_far, Some(PageContent::Theory(_))));
    assert!(
        dropped.poll().is_none() && dropped.so_far.is_none(),
        "Fig. 2 was dropped without a word"
    );
    let mut figure = beside(&worker).job(Page::Figure(4), background::page);
    assert_eq!(await_end(&mut figure, |_| {}), Ok(()));
    assert!(matches!(&figure.so_far, Some(PageContent::Figure(figure)) if figure.number == 4));
    let end = await_end(
        &mut beside(&worker).job(Page::Figure(777), background::page),
        |_| {},
    );
    assert!(
        matches!(&end, Err(why) if why.contains("no Fig. 777")),
        "{end:?}"
    );
}

fn ready(out: &[Event]) -> &tackscope::worker::protocol::Ready {
    picked!(out, Event::Ready(ready) => &**ready)
        .next()
        .expect("ready")
}

#[test]
fn a_scene_runs_on_the_part_of_the_cell_the_plan_says_unless_somebody_overrules_it() {
    let tip = || Scene {
        indenter: Indenter::Hertz(Hertz { radius: 256.0 }),
        ..fig2(64)
    };
    let cases = [
        (
            wished(1, fig2(64), None),
            Part::Quarter,
            "ridge on half a line",
        ),
        (
            wished(1, fig2(64), Some(Strategy::WHOLE)),
            Part::Whole,
            "asked for",
        ),
        (
            wished(1, fig2(64), Some(Strategy::QUARTER)),
            Part::Quarter,
            "asked for",
        ),
        (
            wished(1, fig2(62), Some(Strategy::QUARTER)),
            Part::Whole,
            "asked for",
        ),
        (wished(1, fig2(16), None), Part::Whole, "jumps of its own"),
        (
            wished(1, tip(), None),
            Part::Quarter,
            "a single crest keeps its mirror symmetry",
        ),
    ];
    for (command, reduction, words) in cases {
        let out = drain(&mut Session::default(), vec![command]);
        let choice = &ready(&out).choice;
        assert_eq!(choice.part, reduction, "{choice:?}");
        assert!(choice.plan.words().contains(words), "{choice:?}");
        // Pictures are always of the whole cell.
        let shape = ready(&out).model.grid.shape();
        assert!(frames(&out).all(|frame| frame.gap.dim() == shape));
        assert!(ready(&out).height.as_ref().is_none_or(|h| h.dim() == shape));
    }
    let out = drain(
        &mut Session::default(),
        vec![of(
            1,
            Command::SetScene {
                scene: Arc::new(fig2(64)),
                method: MethodKind::Gfmd,
                asked: None,
                from: None,
            },
        )],
    );
    let choice = &ready(&out).choice;
    assert!(
        choice.part == Part::Whole
            && choice
                .because
                .as_ref()
                .unwrap()
                .contains("as it was published"),
        "{choice:?}"
    );
}

#[test]
fn the_quarter_and_the_whole_cell_walk_the_same_loop() {
    let walked = |asked| {
        let mut session = Session::default();
        let began = Instant::now();
        let out = drain(
            &mut session,
            vec![wished(1, fig2(64), asked), sweep(1, 1, Sweep::Loop)],
        );
        println!("{asked:?}: {:?}", began.elapsed());
        let jumps: Vec<_> =
            picked!(out, Event::Jump(jump) => (jump.direction, jump.from, jump.to)).collect();
        let energy = out.iter().find_map(|e| {
            if let Event::Loop(summary) = e {
                summary.ledger.dissipated_energy()
            } else {
                None
            }
        });
        (jumps, energy.expect("a loop was closed"))
    };
    let (quarter, whole) = (walked(None), walked(Some(Strategy::WHOLE)));
    assert_eq!(quarter.0, whole.0);
    assert!(
        (quarter.1 / whole.1 - 1.0).abs() < 2e-3,
        "{quarter:?} {whole:?}"
    );
}

/// A scene of which a quarter of the cell is not enough.
fn coarse() -> Scene {
    let mut scene = fig2(32);
    let range = 0.35;
    scene.law.range = Range::Length(range);
    (scene.drive.start, scene.drive.turn, scene.drive.step) =
        (8.0 * range, Turn::At(0.3 * range), 0.05 * range);
    scene
}

/// What is heard of its loop on the quarter; walked once for all tests.
fn on_the_quarter() -> &'static [Event] {
    static EVENTS: OnceLock<Vec<Event>> = OnceLock::new();
    EVENTS.get_or_init(|| looped(Strategy::QUARTER))
}

fn looped(asked: Strategy) -> Vec<Event> {
    let commands = vec![wished(1, coarse(), Some(asked)), sweep(1, 1, Sweep::Loop)];
    drain(&mut Session::default(), commands)
}

#[test]
fn a_quarter_that_is_not_enough_becomes_the_whole_cell_on_the_way_and_says_so_once() {
    let mut changes = Vec::new();
    let mut ledgers = Vec::new();
    for out in [on_the_quarter(), &looped(Strategy::WHOLE)] {
        let mut path = Vec::new();
        for event in out {
            match event {
                Event::Remodelled(choice) => {
                    assert_eq!(choice.part, Part::Whole);
                    let models: Vec<_> = path.iter().map(|s: &StateRecord| s.part).collect();
                    assert!(models.iter().all(|m| *m != Part::Whole), "{models:?}");
                    changes.push(choice.because.clone().unwrap());
                }
                Event::State(state) => path.push(state.clone()),
                Event::Failed(Failure { message, .. }) => panic!("{message}"),
                Event::Loop(summary) => ledgers.push(summary.ledger.clone()),
                _ => {}
            }
        }
        // The path already gone is kept: no step is longer than the scene's, before and after the
        // change.
        let long = path.windows(2).find(|w| {
            (w[0].mean_displacement - w[1].mean_displacement).abs() > coarse().drive.step + 1e-9
        });
        assert!(long.is_none(), "{long:?}");
        assert!(path.iter().any(|s| s.part == Part::Whole));
    }
    assert!(
        changes.len() == 1 && changes[0].contains("not mirror-symmetric"),
        "{changes:?}"
    );
    // The mesh traps the dimple beyond the start: neither loop closes, and both know.
    assert!(
        ledgers.len() == 2 && ledgers[0].open.is_some() && ledgers[0].open == ledgers[1].open,
        "{ledgers:?}"
    );
}

#[test]
fn a_run_goes_over_to_the_whole_cell_exactly_as_the_window_does() {
    let (scene, out) = (coarse(), on_the_quarter());
    let began = out
        .iter()
        .rposition(|e| matches!(e, Event::Cut { .. }))
        .expect("a loop");
    let state = |s: &StateRecord| (s.direction, s.mean_displacement, s.stress, s.energy, s.part);
    let shown: Vec<_> = picked!(out[began..], Event::State(s) => state(s)).collect();
    let cancel = Cancel::default();
    let run = run_loop(
        &scene,
        WalkOptions {
            part: Part::Quarter,
            ..MethodKind::NewtonKrylov.into()
        },
        &cancel,
        &mut |_| {},
    )
    .expect("a scene");
    assert_eq!(run.outcome, Outcome::Completed);
    assert!(
        run.deviation
            .as_ref()
            .is_some_and(|why| why.contains("on the whole cell")),
        "{:?}",
        run.deviation
    );
    assert_eq!(
        run.record.states.iter().map(state).collect::<Vec<_>>(),
        shown
    );
    let told = picked!(out, Event::Loop(summary) => &summary.ledger).next();
    assert_eq!(run.ledger(scene.law.surface_energy).as_ref(), told);
}

#[test]
fn no_loop_begins_with_an_unstable_state_and_an_open_one_says_so() {
    let mut scene = fig2(32);
    scene.drive.start = 2.5;
    let sweep = || sweep(1, 1, Sweep::Loop);
    let out = drain(
        &mut Session::default(),
        vec![set_scene(1, scene.clone()), sweep()],
    );
    let failed = picked!(out, Event::Failed(Failure { message, .. }) => message.clone()).next();
    assert!(
        failed
            .as_ref()
            .is_some_and(|words| words.contains("unstable")),
        "{failed:?}"
    );
    assert!(!out.iter().any(|e| matches!(e, Event::Loop(_))));
    (scene.drive.start, scene.drive.turn) = (3.5, Turn::At(1.8));
    let out = drain(&mut Session::default(), vec![set_scene(1, scene), sweep()]);
    let ledger = picked!(out, Event::Loop(summary) => summary.ledger.clone()).next();
    let ledger = ledger.expect("the drive is completed");
    assert!(
        ledger.open.is_some() && ledger.dissipated_energy().is_none(),
        "{ledger:?}"
    );
}

/// Not a timed test: it prints what a hand that drags the range would see.
#[test]
fn a_hand_that_drags_the_range_gets_loops_all_the_way_and_the_fine_one_at_the_end() {
    let worker = Worker::spawn(|| {});
    let steps = 150;
    let began = Instant::now();
    let mut told: Vec<(u64, Fineness, f64)> = Vec::new();
    let mut listen = |until: Instant| {
        while let Some(event) = worker.next_event(until.saturating_duration_since(Instant::now())) {
            if let Envelope {
                run,
                message: Event::Live(live),
            } = event
            {
                assert!(live.found.is_ok(), "{live:?}");
                told.push((run, live.fineness, began.elapsed().as_secs_f64()));
            }
        }
    };
    for run in 1..=steps {
        let mut scene = fig2(64);
        scene.law.range = Range::Length(0.8 + 0.4 * run as f64 / steps as f64);
        worker.send(set_scene(run, scene));
        listen(began + Duration::from_millis(16 * run));
    }
    let dragged = began.elapsed().as_secs_f64();
    listen(Instant::now() + Duration::from_secs(3));
    let on_the_way: Vec<f64> = told.iter().map(|t| t.2).filter(|t| *t <= dragged).collect();
    let longest = on_the_way
        .windows(2)
        .map(|w| w[1] - w[0])
        .fold(0.0, f64::max);
    println!(
        "{} loops in {dragged:.2} s, longest wait {:.0} ms, first after {:.0} ms",
        on_the_way.len(),
        1e3 * longest,
        1e3 * told[0].2
    );
    assert_eq!(
        told.last().map(|t| (t.0, t.1)),
        Some((steps, Fineness::Fine))
    );
}

#[test]
fn the_threads_end_within_two_seconds_whatever_they_are_at() {
    let heavy = || {
        let mut scene = storage::resolve("hertz").unwrap();
        scene.cell.points = Points::Square(512);
        scene
    };
    let scenes = [fig2(192), heavy(), storage::resolve("rough").unwrap()];
    for scene in scenes {
        for pages in [
            Page::Figure(4),
            Page::Figure(14),
            Page::Errata,
            Page::Theory,
        ] {
            let worker = Worker::spawn(|| {});
            worker.send(set_scene(1, scene.clone()));
            worker.send(sweep(1, 1, Sweep::Loop));
            let jobs = (
                beside(&worker).job(
                    (Arc::new(scene.clone()), Effort::Full { seconds: 60.0 }),
                    background::chart,
                ),
                beside(&worker).job(pages, background::page),
            );
            std::thread::sleep(Duration::from_millis(150));
            let began = Instant::now();
            drop((jobs, worker));
            assert!(
                began.elapsed() < Duration::from_secs(2),
                "{pages:?}: {:?}",
                began.elapsed()
            );
        }
    }
}

/// The states of these events.
fn states(out: &[Event]) -> Vec<StateRecord> {
    picked!(out, Event::State(state) => state.clone()).collect()
}

#[test]
fn going_on_from_a_stored_state_leads_to_the_states_it_led_to() {
    for (scene, asked, far) in [
        (fig2(48), None, 1.0),
        (fig2(48), Some(Strategy::WHOLE), 2.5),
    ] {
        let mut session = Session::default();
        let commands = vec![wished(1, scene, asked), target(1, 1, far)];
        let out = drain(&mut session, commands);
        let path = states(&out);
        let stored: Vec<_> = picked!(out, Event::Stored(stored) => stored.clone()).collect();
        assert_eq!(stored.len(), path.len());
        let mut motion = 1;
        // On the flat branch, on patterns, and right after each jump.
        for index in (5..path.len() - 10).step_by(23) {
            let from = stored[index].clone();
            assert_eq!(from.before[0], index);
            motion += 2;
            let go_on = of(1, Command::GoOn { motion, from });
            let out = drain(&mut session, vec![go_on]);
            let cut = picked!(out, Event::Cut { states, .. } => *states).next();
            // Later ones were walked anew, to the same states within the tolerance.
            assert!(cut == Some(index) || cut == Some(0), "{cut:?} {index}");
            let again = drain(
                &mut session,
                vec![target(1, motion + 1, path[index + 8].control)],
            );
            let again = states(&again);
            // Brackets of a jump are a matter of where the walk came from.
            let last = again.last().expect("it went on");
            let wanted = &path[index + 8];
            assert_eq!(
                (last.control, last.pattern),
                (wanted.control, wanted.pattern),
                "{index}"
            );
            let off = (last.stress_over_max - wanted.stress_over_max).abs();
            assert!(off < 1e-5, "{off} at {index}");
        }
    }
}
