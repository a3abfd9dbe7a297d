//! Fig. 4: where the flat surface gives way, against the size of the cell.

use super::figure::{Axis, Colour, Figure, Panel, Role, Series};
use super::task::{Stopped, Task};
use super::{Entry, scenes};
use crate::experiment::scene::Points;
use crate::physics::law::{Law, Morse, Shape};
use crate::physics::theory::flat;

pub(super) const ENTRY: Entry = Entry {
    number: 4,
    title: "Where the flat surface gives way",
    look_for: "Below L = L_c the flat surface never gives way. Above it, approach and retraction give way at different separations, and \
               the distance between them grows with the logarithm of the cell.",
    scene: || scenes::flat("Fig. 4: a cell of 1.2 critical lengths", 100.6, Points::Square(32), 2.6, 0.6, 0.02),
    compute,
};

fn compute(task: &mut Task<'_>) -> Result<Figure, Stopped> {
    task.tell(0.0, "Eq. 8")?;
    let law = Law { shape: Shape::Morse(Morse), surface_energy: scenes::SURFACE_ENERGY, range: 1.0 };
    let critical = flat::critical_length(&law);
    let ratios: Vec<f64> = (0..=400).map(|i| 10f64.powf(3.0 * i as f64 / 400.0)).collect();
    let line = |name: &str, colour, pick: fn((f64, f64)) -> f64| Series {
        name: name.to_owned(),
        role: Role::Theory,
        colour,
        points: ratios.iter().filter_map(|&r| flat::limits(&law, r * critical).map(|limits| [r, pick(limits)])).collect(),
        symbol: None,
    };
    let panel = Panel {
        x: Axis::logarithmic("L/L_c"),
        y: Axis::linear("u_c/rho"),
        series: vec![line("approach, Eq. 8", Colour::Ink, |l| l.1), line("retraction, Eq. 8", Colour::Red, |l| l.0)],
        ..Panel::default()
    };
    Ok(Figure { number: 4, title: ENTRY.title.to_owned(), panels: vec![panel], ..Figure::default() })
}
