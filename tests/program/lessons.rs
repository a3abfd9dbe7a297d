//! The lessons can be done, say true numbers, and fail where their condition is made false.

use tackscope::lessons::{
    Act, Condition, Facts, Lesson, Progress, Question, Stage, all, find, parse,
};
use tackscope::numerics::cancel::Cancel;
use tackscope::physics::theory::flat;
use tackscope::scene::Scene;
use tackscope::storage::presets;
use tackscope::worker::rehearsal::rehearse;

fn scene(name: &str) -> Result<Scene, String> {
    let preset = presets::find(name).ok_or_else(|| name.to_owned())?;
    preset.scene().map_err(|failure| failure.to_string())
}

fn performed(lesson: &Lesson) -> Result<Vec<String>, String> {
    rehearse(lesson, &scene, &Cancel::default())
}

#[test]
fn every_lesson_can_be_done_and_fills_in_every_number() {
    assert_eq!(all().len(), 7);
    for lesson in all() {
        let told = performed(lesson).unwrap_or_else(|why| panic!("{why}"));
        assert_eq!(told.len(), lesson.steps.len(), "{}", lesson.name);
        assert!((5..=7).contains(&lesson.minutes));
    }
}

#[test]
fn what_a_lesson_says_is_what_the_theory_says() {
    let told = performed(find("first-snap").unwrap()).unwrap();
    let model = scene("fig2").unwrap().model().unwrap();
    let (lower, upper) = flat::limits(&model.law, model.grid.length).unwrap();
    let limit = format!("{:.3}", upper / model.law.range);
    assert!(
        told[1].contains(&format!("It snapped at {limit} ranges")),
        "{told:?}"
    );
    let told = performed(find("held-by-nothing").unwrap()).unwrap();
    let stiffness = flat::stiffness_min(&model.law, model.grid.length, 2.5);
    assert!(stiffness < 0.0 && lower < 2.5);
    assert!(
        told[1].contains(&format!("{stiffness:.2} E*/L. It is negative")),
        "{told:?}"
    );
}

#[test]
fn a_lesson_whose_condition_is_false_fails_and_says_where() {
    let lesson = find("four-patterns").unwrap();
    for (condition, acts) in [
        // Never met.
        (Some(Condition::Pattern("contact".to_owned())), None),
        (Some(Condition::JumpedBack("flat".to_owned())), None),
        (Some(Condition::MuRhoAbove(1.0)), None),
        (Some(Condition::Stable(false)), None),
        // Not by what is done.
        (None, Some(vec![Act::GoTo(4.0)])),
        // Met before anything is done.
        (Some(Condition::Pattern("flat".to_owned())), None),
    ] {
        let mut mutated = lesson.clone();
        let task = mutated.steps[0].task.as_mut().unwrap();
        if let Some(condition) = condition {
            task.until = vec![condition];
        }
        if let Some(acts) = acts {
            task.act = acts;
        }
        let why = performed(&mutated).expect_err("it cannot be done");
        assert!(
            why.starts_with("four-patterns, step 1: its condition"),
            "{why}"
        );
    }
    let mut mutated = lesson.clone();
    mutated.steps[1].explain = "a number that nobody knows: {temperature}".to_owned();
    let why = performed(&mutated).expect_err("it has no such number");
    assert!(
        why.contains("step 2: no number") && why.contains("{temperature}"),
        "{why}"
    );
}

#[test]
fn a_text_that_is_no_lesson_is_refused_with_its_place() {
    let text =
        "title = \"T\"\nteaches = \"t\"\nminutes = 5\n[[step]]\ntext = \"a\"\nquestoin = 1\n";
    let why = parse("mine", text).expect_err("a typing error");
    assert!(
        why.contains("mine.toml") && why.contains("questoin"),
        "{why}"
    );
    let text = "title = \"T\"\nteaches = \"t\"\nminutes = 5\nstep = []\n";
    assert!(parse("mine", text).is_err());
}

#[test]
fn a_guess_counts_by_how_near_it_is_and_progress_is_kept() {
    let lesson = find("first-snap").unwrap();
    let fig2 = scene("fig2").unwrap();
    let model = fig2.model().unwrap();
    let mut record = tackscope::follow::run::run_loop(
        &fig2,
        Default::default(),
        &Cancel::default(),
        &mut |_| {},
    )
    .unwrap()
    .record;
    record.jumps.truncate(1);
    let facts = Facts {
        scene: &fig2,
        model: &model,
        record: &record,
        loss: None,
    };
    let right = record.jumps[0].mean_displacement / model.law.range;
    for (off, points) in [(1.0, 3), (1.019, 3), (0.96, 2), (1.1, 1), (0.8, 0)] {
        let mut progress = Progress::new(lesson);
        assert!(progress.observe(lesson, &facts), "a text waits for nothing");
        progress.next(lesson);
        assert!(matches!(
            progress.asks(lesson),
            Some(Question::Guess { .. })
        ));
        progress.commit(lesson, &facts);
        assert_eq!(progress.stage, Stage::Asking, "no answer, no step");
        progress.answer = Some((off * right * 100.0).round() / 100.0);
        progress.commit(lesson, &facts);
        assert!(progress.observe(lesson, &facts));
        assert_eq!(progress.score, [points, 3], "{off}");
        let words = progress.explanation(lesson).unwrap();
        assert!(
            words.contains(&format!("({points} of 3 points)")),
            "{words}"
        );
        let text = serde_json::to_string(&progress).unwrap();
        assert_eq!(serde_json::from_str::<Progress>(&text).unwrap(), progress);
        progress.next(lesson);
        progress.back(lesson);
        assert_eq!((progress.step, progress.stage), (1, Stage::Asking));
    }
}
