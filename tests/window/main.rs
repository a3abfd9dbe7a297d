//! The real window, driven through its accessible labels by a solver that is stepped by hand. No
//! display, no graphics, no time.
#![cfg(feature = "gui")]

mod bench;
mod computed;
mod hand;
mod kept;
mod layout;
mod lessons;
mod outside;
mod plot;
mod scene;
mod screens;
mod stored;
mod tabs;
mod why;
mod wrongs;

use bench::{Bench, fig2};
use egui::{Key, Modifiers, pos2, vec2};
use egui_kittest::kittest::Queryable;
use hand::{Hand, place_for};
use tackscope::follow::ledger::{Ledger, Open};
use tackscope::scene::Points;
use tackscope::solver::methods::MethodKind;
use tackscope::storage::{self, scene_file};
use tackscope::ui::view_state::Hint;
use tackscope::worker::protocol::{Command, Envelope, Event, Failure, LoopSummary, Play, Sweep};

#[test]
fn the_window_opens_at_rest_on_fig2_and_says_what_to_do() {
    let bench = Bench::new();
    let heard = bench.heard_of();
    let opened = |message: &Command| {
        matches!(
            message,
            Command::SetScene {
                method: MethodKind::NewtonKrylov,
                ..
            }
        )
    };
    assert!(
        matches!(&heard[..], [Envelope { run: 1, message }] if opened(message)),
        "{heard:?}"
    );
    assert_eq!(bench.view().messages.hint, Some(Hint::Grab));
    assert_eq!(bench.view().target, bench.view().limits.1);
}

#[test]
fn every_control_is_found_by_its_label() {
    let bench = Bench::new();
    for label in [
        "mean displacement u0",
        "ground flat",
        "ground tip",
        "ground waves",
        "ground rough",
        "ground measured",
        "law morse",
        "law mie",
        "law cosine",
        "law double exponential",
        "machine stiff",
        "machine spring",
        "machine weight",
        "Advanced",
        "Preset",
        "What to look for",
        "Lessons",
        "Play approach",
        "Play retract",
        "Play loop",
        "Pause",
        "Stop",
        "Speed",
        "Reset",
        "Undo",
        "Redo",
        "Files",
        "Lecture mode",
        "Switch theme",
        "Help",
        "Menu",
        "Map options",
        "Fit",
        "More tabs",
    ] {
        assert_eq!(bench.query_all_by_label(label).count(), 1, "{label}");
    }
}

#[test]
fn what_is_folded_away_is_found_by_its_label() {
    let mut bench = Bench::new();
    for (fold, labels) in [
        (
            "Files",
            &[
                "Open…",
                "Save…",
                "Export data…",
                "Export picture…",
                "Copy scene",
            ][..],
        ),
        (
            "Map options",
            &["Smooth", "Centre the pattern", "Soft mode"],
        ),
        (
            "Menu",
            &[
                "Restore layout",
                "Theme of the system",
                "All commands…",
                "Quit",
            ],
        ),
        (
            "More tabs",
            &["Speed and accuracy tab", "Equations tab", "Paper tab"],
        ),
        (
            "Advanced",
            &[
                "mesh number mu_rho",
                "mu_rho of Dugdale, 0.798",
                "mu_rho of Hui, 1.09",
                "range",
                "mesh",
                "Line cell (uniform along y)",
            ],
        ),
    ] {
        bench.click(fold);
        for label in labels {
            assert_eq!(bench.query_all_by_label(label).count(), 1, "{label}");
        }
    }
    for label in ["Target", "Mesh number μᵨ", "Length L", "Range ρ"] {
        assert!(
            bench
                .query_by_role_and_label(egui::Role::SpinButton, label)
                .is_some(),
            "{label}"
        );
    }
    let list = bench.query_by_role_and_label(egui::Role::ComboBox, "Points n");
    assert!(list.is_some());
}

#[test]
fn dragging_the_u0_slider_sends_a_target_for_every_new_value_and_none_at_rest() {
    let mut bench = Bench::new();
    bench.heard();
    bench.drag(
        "mean displacement u0",
        &[vec2(0.0, 5.0), vec2(0.0, 20.0), vec2(0.0, 40.0)],
    );
    let targets = bench.targets();
    assert!(targets.len() >= 3, "{targets:?}");
    assert!(
        targets.windows(2).all(|w| w[1] < w[0]),
        "dragging down lowers the body: {targets:?}"
    );
    assert_eq!(bench.view().target, targets[targets.len() - 1]);
    bench.settle();
    assert!(bench.heard().is_empty());
}

#[test]
fn the_thumb_stays_where_the_hand_left_it_while_the_solver_is_on_its_way() {
    let mut bench = Bench::new();
    bench.tap(Key::End);
    bench.down(3.9);
    assert_eq!(bench.view().target, bench.view().limits.0);
    assert_eq!(bench.view().run.actual, 3.9);
    bench.says("3.9000 ρ");
}

#[test]
fn a_typed_target_is_taken_exactly() {
    let mut bench = Bench::new();
    bench.heard();
    bench.enter("Target", "3.123456");
    assert_eq!(bench.targets(), [3.123456]);
}

#[test]
fn play_buttons_start_sweeps_and_pause_and_stop_work_while_they_run() {
    let mut bench = Bench::new();
    for (label, wanted) in [
        ("Play approach", Sweep::Approach),
        ("Play retract", Sweep::Retract),
        ("Play loop", Sweep::Loop),
    ] {
        bench.heard();
        bench.click(label);
        let heard = bench.heard_of();
        let asked = |message: &Command| matches!(message, Command::Play { play: Play::Sweep(sweep), .. } if *sweep == wanted);
        assert!(
            matches!(&heard[..], [Envelope { run: 1, message }] if asked(message)),
            "{heard:?}"
        );
    }
    bench.click("Pause");
    assert!(matches!(
        bench.heard()[..],
        [Command::Pause { paused: true }]
    ));
    bench.click("Go on");
    assert!(matches!(
        bench.heard()[..],
        [Command::Pause { paused: false }]
    ));
    bench.click("Stop");
    assert!(matches!(
        bench.heard()[..],
        [Command::Play {
            play: Play::Rest,
            ..
        }]
    ));
    assert!(!bench.view().run.is_busy());
}

#[test]
fn a_sweep_takes_the_thumb_along() {
    let mut bench = Bench::new();
    bench.click("Play approach");
    bench.down(3.7);
    assert_eq!((bench.view().target, bench.view().run.actual), (3.7, 3.7));
    bench.say(Event::Rest {
        motion: 1,
        control: 3.7,
    });
    assert!(bench.view().run.sweep().is_none() && !bench.view().run.is_busy());
}

#[test]
fn the_rest_that_ends_an_older_motion_does_not_take_the_thumb_from_a_sweep() {
    let mut bench = Bench::new();
    bench.tap(Key::End);
    bench.down(3.9);
    bench.click("Stop");
    bench.click("Play retract");
    // The target was reached in the moment of the stop: two rests are on their way while the sweep
    // already runs.
    let motion = |commands: &[Command]| {
        commands
            .iter()
            .filter_map(|c| {
                if let Command::Play {
                    motion,
                    play: Play::Sweep(_),
                } = c
                {
                    Some(*motion)
                } else {
                    None
                }
            })
            .next_back()
    };
    let sweep = motion(&bench.heard()).expect("a sweep was asked for");
    for motion in [sweep - 2, sweep - 1] {
        bench.say(Event::Rest {
            motion,
            control: 3.9,
        });
    }
    bench.up(3.92);
    assert!(bench.view().run.is_busy() && bench.view().run.sweep() == Some(Sweep::Retract));
    assert_eq!(bench.view().target, 3.92, "the thumb no longer follows");
    bench.say(Event::Rest {
        motion: sweep,
        control: 3.92,
    });
    assert!(!bench.view().run.is_busy() && bench.view().run.sweep().is_none());
}

#[test]
fn another_law_is_a_new_run_and_undo_brings_the_old_one_back() {
    let mut bench = Bench::new();
    bench.heard();
    bench.click("law cosine");
    let scenes = bench.scenes();
    assert_eq!(
        scenes
            .iter()
            .map(|scene| scene.law.shape.word())
            .collect::<Vec<_>>(),
        ["cosine"]
    );
    assert_eq!(bench.view().run.id, 2);
    bench.click("law mie");
    assert_eq!(
        bench.scenes()[0].title,
        format!("Changed: {}", fig2().title)
    );
    bench.ctrl(Key::Z);
    bench.heard();
    bench.ctrl(Key::Z);
    assert_eq!(bench.scenes(), [fig2()]);
    bench.ctrl(Key::Y);
    assert_eq!(bench.view().scene.law.shape.word(), "cosine");
    bench.click("Undo");
    assert_eq!(*bench.view().scene, fig2());
}

#[test]
fn one_drag_of_mu_rho_is_one_undo_and_at_most_one_scene_a_frame() {
    let mut bench = Bench::new();
    bench.heard();
    bench.drag(
        "mesh number mu_rho",
        &[
            vec2(-5.0, 0.0),
            vec2(-12.0, 0.0),
            vec2(-20.0, 0.0),
            vec2(-30.0, 0.0),
        ],
    );
    let scenes = bench.scenes();
    assert!((3..=6).contains(&scenes.len()), "{}", scenes.len());
    assert_ne!(*bench.view().scene, fig2());
    bench.ctrl(Key::Z);
    assert_eq!(*bench.view().scene, fig2());
    assert!(!bench.view().history.can_undo());
}

#[test]
fn a_named_mesh_of_table_1_sets_its_mu_rho_exactly_and_warns_above_one_half() {
    let mut bench = Bench::new();
    bench.click("mu_rho of Dugdale, 0.798");
    assert!((bench.view().model.mu_rho - 0.798).abs() < 1e-12);
    bench.says("Mesh: too coarse");
    bench.click("Refine");
    assert!(bench.view().model.mu_rho <= 0.5);
    bench.says("Mesh: fine enough");
}

#[test]
fn with_the_mesh_following_the_law_stays_and_the_number_of_points_changes() {
    let mut bench = Bench::new();
    let before = bench.view().model.clone();
    bench.click("mesh");
    bench.click("mu_rho of safe, 0.5");
    let after = bench.view().model.clone();
    assert!((after.law.range - before.law.range).abs() < 1e-12);
    assert!(
        after.grid.nx.is_multiple_of(2) && (after.mu_rho - 0.5).abs() < 0.03,
        "{} points, {}",
        after.grid.nx,
        after.mu_rho
    );
}

#[test]
fn a_line_cell_is_one_click_away() {
    let mut bench = Bench::new();
    bench.click("Line cell (uniform along y)");
    assert!(matches!(bench.view().scene.cell.points, Points::Line(_)));
    assert!(bench.view().model.grid.is_line());
}

#[test]
fn keys_step_coarsely_finely_and_to_the_ends() {
    let mut bench = Bench::new();
    let (low, high) = bench.view().limits;
    let step = bench.view().scene.drive.step;
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{a} {b}");
    bench.tap(Key::ArrowLeft);
    near(bench.view().target, high - step);
    bench.press(Modifiers::SHIFT, Key::ArrowLeft);
    near(bench.view().target, high - 1.1 * step);
    bench.tap(Key::PageDown);
    near(bench.view().target, high - 11.1 * step);
    bench.tap(Key::ArrowRight);
    near(bench.view().target, high - 10.1 * step);
    bench.tap(Key::End);
    assert_eq!(bench.view().target, low);
    bench.tap(Key::Home);
    assert_eq!(bench.view().target, high);
}

#[test]
fn space_plays_and_pauses_period_goes_one_increment_and_r_turns_round() {
    let mut bench = Bench::new();
    bench.heard();
    bench.tap(Key::Space);
    assert!(matches!(
        bench.heard()[..],
        [Command::Play {
            play: Play::Sweep(Sweep::Loop),
            ..
        }]
    ));
    bench.tap(Key::Space);
    assert!(matches!(
        bench.heard()[..],
        [Command::Pause { paused: true }]
    ));
    bench.tap(Key::Space);
    assert!(matches!(
        bench.heard()[..],
        [Command::Pause { paused: false }]
    ));
    bench.tap(Key::Escape);
    assert!(matches!(
        bench.heard()[..],
        [Command::Play {
            play: Play::Rest,
            ..
        }]
    ));
    bench.down(3.0);
    bench.say(Event::Rest {
        motion: 2,
        control: 3.0,
    });
    bench.tap(Key::Escape);
    bench.heard();
    bench.tap(Key::Period);
    bench.tap(Key::R);
    bench.tap(Key::Period);
    let targets = bench.targets();
    assert!(
        targets.len() == 2 && targets[0] < 3.0 && targets[1] > targets[0],
        "{targets:?}"
    );
}

#[test]
fn keys_do_not_fire_while_something_is_typed() {
    let mut bench = Bench::new();
    bench.click("Export data…");
    bench.heard();
    bench.tap(Key::Space);
    bench.tap(Key::End);
    bench.tap(Key::R);
    assert!(bench.heard().is_empty());
}

#[test]
fn number_keys_load_presets() {
    let mut bench = Bench::new();
    bench.heard();
    bench.tap(Key::Num2);
    let wanted =
        scene_file::parse(storage::presets()[1].text, "second").expect("a preset is allowed");
    assert_eq!(
        bench
            .scenes()
            .iter()
            .map(|scene| scene.title.clone())
            .collect::<Vec<_>>(),
        [wanted.title]
    );
}

#[test]
fn what_to_look_for_in_a_preset_is_one_click_away_while_it_is_edited_too() {
    let mut bench = Bench::new();
    let words = "Lowering u0, the flat surface jumps to a bulge";
    bench.lacks(words);
    bench.click("What to look for");
    bench.says(words);
    bench.tap(Key::Escape);
    bench.click("law cosine");
    bench.click("What to look for");
    bench.says(words);
    bench.tap(Key::Escape);
    bench.tap(Key::Num3);
    bench.click("What to look for");
    bench.says("Nothing jumps.");
}

#[test]
fn the_first_jump_is_listed_and_the_hint_goes_on() {
    let mut bench = Bench::new();
    bench.down(3.2);
    bench.says("Something will snap.");
    bench.jump(3.102);
    bench.click("Events tab");
    bench.lacks("Something will snap.");
    bench.says("Now pull it off again.");
    for words in ["flat → ridge", "3.102", "0.1234", "flat limit", "1 jump,"] {
        bench.says(words);
    }
}

#[test]
fn the_hint_goes_when_the_surface_was_all_the_way_down_without_a_jump() {
    let mut bench = Bench::new();
    bench.down(0.3);
    assert!(bench.view().messages.hint.is_some());
    bench.down(0.2);
    assert_eq!(bench.view().messages.hint, None);
}

#[test]
fn a_jump_is_announced_and_a_second_one_not_within_two_seconds() {
    let mut bench = Bench::new();
    let said = |bench: &Bench| bench.view().messages.announced.clone();
    let time = |bench: &Bench| bench.ctx.input(|input| input.time);
    assert_eq!(said(&bench), "");
    let begun = time(&bench);
    bench.jump(3.1);
    assert!(said(&bench).contains("3.1"), "{}", said(&bench));
    bench.jump(2.9);
    let mut frames = 0;
    while !said(&bench).contains("2.9") {
        bench.step();
        frames += 1;
        assert!(frames < 100, "it is never announced");
    }
    assert!(time(&bench) - begun >= 2.0);
}

#[test]
fn the_map_and_the_plot_say_one_sentence_each() {
    let mut bench = Bench::new();
    bench.down(3.9);
    bench.says("Gap map: flat, gap from 3.900 to 3.900 rho");
    bench.says("Stress against u0: flat at u0 3.900 rho");
}

#[test]
fn the_status_bar_says_stability_model_and_cost() {
    let mut bench = Bench::new();
    bench.down(3.9);
    let names = bench.status();
    for words in [
        "stable, stiffness_min",
        "flat, closed form",
        "Newton-Krylov",
        "0 iterations",
        "mesh 64 × 64",
    ] {
        assert!(names.contains(words), "{words} in {names}");
    }
}

#[test]
fn stale_events_of_an_older_run_are_dropped() {
    let mut bench = Bench::new();
    bench.click("law cosine");
    let actual = bench.view().run.actual;
    bench.say_of(
        1,
        Event::Failed(Failure {
            message: "old".to_owned(),
            remedy: String::new(),
        }),
    );
    bench.say_of(
        1,
        Event::Rest {
            motion: 0,
            control: 1.0,
        },
    );
    assert_eq!(bench.view().messages.failure, None);
    assert_eq!(bench.view().run.actual, actual);
}

#[test]
fn a_failure_is_said_in_words_with_its_remedy_and_the_last_good_state_stays() {
    let mut bench = Bench::new();
    bench.down(3.9);
    bench.say(Event::Failed(Failure {
        message: "did not converge at u0 = 0.31".to_owned(),
        remedy: "Take a smaller step.".to_owned(),
    }));
    bench.says("did not converge");
    bench.says("Take a smaller step.");
    assert_eq!(bench.view().run.actual, 3.9);
    bench.click("Dismiss");
    assert_eq!(bench.view().messages.failure, None);
}

#[test]
fn a_closed_loop_shades_its_area_and_says_its_number() {
    let mut bench = Bench::new();
    bench.ready();
    bench.click("Play loop");
    bench.say(Event::Cut {
        states: 0,
        jumps: 0,
    });
    for u0 in [4.0, 3.0, 2.0, 1.0] {
        bench.down(u0);
    }
    // A chord over what the approach followed: not the same curve.
    for u0 in [1.5, 4.0] {
        bench.up(u0);
    }
    bench.say(Event::Loop(summary(ledger(0.4321, 0.4322))));
    bench.says("0.4321 γ lost");
    assert!(
        bench
            .view()
            .run
            .closed_loop
            .as_ref()
            .is_some_and(|closed| closed.loss.iter().any(|area| area.spans.len() > 20))
    );
    bench.say(Event::Cut {
        states: 0,
        jumps: 0,
    });
    assert_eq!(
        (
            bench.view().plots.ghosts.len(),
            bench.view().run.closed_loop.is_none()
        ),
        (1, true)
    );
}

fn ledger(released_energy_sum: f64, loop_integral: f64) -> Ledger {
    Ledger {
        released_energy_sum,
        released_energy_error: 0.0,
        loop_integral,
        integral_error: 1e-6,
        open: None,
        viscous: false,
    }
}

fn summary(ledger: Ledger) -> LoopSummary {
    LoopSummary {
        ledger,
        transforms: 9,
        seconds: 0.1,
    }
}

#[test]
fn a_loss_whose_check_fails_is_shown_with_the_doubt_and_an_open_loop_has_none() {
    let mut bench = Bench::new();
    bench.ready();
    for u0 in [4.0, 3.0, 2.0, 1.0] {
        bench.down(u0);
    }
    bench.say(Event::Loop(summary(ledger(0.4321, 0.3))));
    bench.says("0.4321 γ lost");
    bench.says("the loop integral, 0.3000 gamma, is not the sum");
    let open = Open {
        reason: "it ends as bulge and began as flat".to_owned(),
        remedy: "raise drive.start".to_owned(),
    };
    bench.say(Event::Loop(summary(Ledger {
        open: Some(open),
        ..ledger(0.4321, 0.3)
    })));
    bench.says("Loop not closed");
    bench.says("it ends as bulge and began as flat; raise drive.start");
    bench.lacks("0.4321");
}

#[test]
fn the_axes_do_not_move_while_data_arrive_until_fit_is_pressed() {
    let mut bench = Bench::new();
    let axes = bench.view().axes();
    for i in 0..20 {
        bench.down(4.0 - 0.1 * f64::from(i));
    }
    assert_eq!(bench.view().axes(), axes);
    bench.click("Fit");
    assert_ne!(bench.view().axes(), axes);
    bench.click("Scene axes");
    assert_eq!(bench.view().axes(), axes);
}

#[test]
fn without_a_file_chooser_the_path_can_be_typed() {
    let mut bench = Bench::new();
    bench.click("Save…");
    bench.click("Browse…");
    bench.says("Type the path here.");
    bench
        .get_by_role_and_label(egui::Role::TextInput, "Path")
        .focus();
    bench.run();
    let (_folder, path) = place_for("mine.toml");
    let text = path.display().to_string();
    bench.key_press_modifiers(Modifiers::COMMAND, Key::A);
    bench.run();
    bench.event(egui::Event::Text(text));
    bench.run();
    bench.click("Write");
    assert!(path.exists());
    bench.says("mine.toml written");
    bench.open("/nowhere/at/all.toml".as_ref());
    assert!(bench.view().messages.failure.is_some(), "{}", bench.names());
    bench.tap(Key::Escape);
    assert_eq!(*bench.view().scene, fig2());
}

#[test]
fn the_sheet_of_keys_opens_and_closes() {
    let mut bench = Bench::new();
    bench.tap(Key::F1);
    bench.says("Keys and marks");
    bench.tap(Key::Escape);
    bench.lacks("Keys and marks");
}

#[test]
fn a_small_window_keeps_every_panel_inside() {
    let bench = Bench::sized(900.0, 600.0);
    for label in [
        "mean displacement u0",
        "Play loop",
        "Menu",
        "Fit",
        "Map options",
    ] {
        let rect = bench.place_of(label);
        assert!(
            rect.min.x >= 0.0 && rect.max.x <= 900.0 && rect.max.y <= 600.0,
            "{label} at {rect:?}"
        );
    }
    let map = bench.place_of("Gap map: waiting for the solver …");
    assert!(
        map.width() > 150.0
            && egui::Rect::from_min_max(pos2(0.0, 0.0), pos2(900.0, 600.0)).contains_rect(map),
        "{map:?}"
    );
}
