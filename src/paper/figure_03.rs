//! Fig. 3: the same surfaces in a cell four times as long, where the bulge is missing.

use super::figure::{Figure, Finding};
use super::task::{Size, Stopped, Task};
use super::{Entry, flat_loop, scenes};
use crate::follow::record::Direction;
use crate::physics::pattern::Pattern;
use crate::scene::{Points, Scene};

pub(super) const ENTRY: Entry = Entry {
    number: 3,
    title: "A cell four times as long: no bulge, and more hysteresis",
    look_for: "The bulge is gone: the flat surface jumps straight to the ridge, from further away. The areas are wider than in Fig. 2, \
               and 3.5 times as much energy is lost per area.",
    scene: scenes::figure_3,
    compute,
};

/// The scene on the mesh of `size`: the quick one has longer steps and still mu_rho below 0.45.
fn scene(size: Size) -> Scene {
    let mut scene = scenes::figure_3();
    if size == Size::Quick {
        scene.cell.points = Points::Square(192);
        scene.drive.step = 0.2;
    }
    scene
}

fn compute(task: &mut Task<'_>) -> Result<Figure, Stopped> {
    let (small, _) = flat_loop::run(
        &scenes::figure_2(),
        &mut task.part(0.0, 0.05),
        "the loop of Fig. 2",
    )?;
    let (run, model) = flat_loop::run(
        &scene(task.size),
        &mut task.part(0.05, 1.0),
        "the loop of Fig. 3",
    )?;
    let mut findings = flat_loop::findings(&run, &model);
    let ratio = run.record.released_energy_sum() / small.record.released_energy_sum();
    findings.push(Finding {
        quantity: "dissipated energy over that of Fig. 2".to_owned(),
        found: ratio,
        expected: 4.0,
        source: "\"a factor close to 4\", text at Fig. 3".to_owned(),
        tolerance: None,
    });
    let bulges = run
        .record
        .jumps
        .iter()
        .filter(|jump| jump.to == Pattern::Bulge)
        .count();
    findings.push(Finding {
        quantity: "jumps to a bulge".to_owned(),
        found: bulges as f64,
        expected: 0.0,
        source: "text at Fig. 3".to_owned(),
        tolerance: Some(0.0),
    });
    let words = format!(
        "As Fig. 2 with L/ρ = 1024: approach shows {}, retraction {}. The loss per area is {:.4} γ, {ratio:.2} times that of Fig. 2 \
         (the paper: close to 4).",
        flat_loop::chain(&run.record, Direction::Approach),
        flat_loop::chain(&run.record, Direction::Retraction),
        run.record.released_energy_sum(),
    );
    let panels = vec![flat_loop::panel(&run, &model.law)];
    Ok(Figure {
        number: 3,
        title: ENTRY.title.to_owned(),
        panels,
        words,
        findings,
    })
}
