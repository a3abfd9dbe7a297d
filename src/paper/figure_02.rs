//! Fig. 2: the loop of a cell of 256 ranges, with four patterns on the way.

use super::figure::Figure;
use super::task::{Stopped, Task};
use super::{Entry, flat_loop, scenes};
use crate::follow::record::Direction;

pub(super) const ENTRY: Entry = Entry {
    number: 2,
    title: "Four patterns: flat, bulge, ridge, dimple, flat",
    look_for: "On the way down the surface jumps to a bulge, a ridge, a dimple, and flat contact; on the way up each pattern lives on \
               beyond the place where it was born. The four shaded areas between the two curves are energy that no slowness can save.",
    scene: scenes::figure_2,
    compute,
};

fn compute(task: &mut Task<'_>) -> Result<Figure, Stopped> {
    let scene = scenes::figure_2();
    let (run, model) = flat_loop::run(&scene, task, "the loop of Fig. 2")?;
    let findings = flat_loop::findings(&run, &model);
    let words = format!(
        "Mean pressure over the largest traction against mean displacement for L/ρ = 256 and γ/(E*ρ) = 0.15: approach shows {}, \
         retraction {}. All {} jumps are located on the eigenvalue that vanishes; their releases add up to {:.4} γ, and so does the \
         area between the curves. The maps are the surfaces just after each jump of the approach.",
        flat_loop::chain(&run.record, Direction::Approach),
        flat_loop::chain(&run.record, Direction::Retraction),
        run.record.jumps.len(),
        run.record.released_energy_sum(),
    );
    let panels = vec![flat_loop::panel(&run, &model.law)];
    Ok(Figure {
        number: 2,
        title: ENTRY.title.to_owned(),
        panels,
        words,
        findings,
    })
}
