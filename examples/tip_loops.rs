//! Computes the loops of the Hertzian tip that are kept in `assets/tips.csv` and prints that file.
//!
//! All 25 take more than an hour on one core. Arguments `MU_RHO POINTS` choose one.

use tackscope::numerics::threads::Cancel;
use tackscope::paper::scenes::{HEAD, KEPT, Order, run};
use tackscope::paper::{Size, Stopped, Task};

fn main() -> Result<(), Stopped> {
    let chosen: Vec<f64> = std::env::args()
        .skip(1)
        .filter_map(|argument| argument.parse().ok())
        .collect();
    let (mus, meshes) = KEPT;
    let all = mus
        .iter()
        .flat_map(|mu| meshes.iter().map(move |n| (*mu, *n)));
    println!("{HEAD}");
    for (mu, n) in all.filter(|(mu, n)| chosen.is_empty() || chosen == [*mu, *n as f64]) {
        let cancel = Cancel::default();
        let tip = run(
            &Order::new(mu, n),
            &mut Task::new(Size::Full, &cancel, &mut |_, _| ()),
        )?;
        println!("{}", tip.row());
    }
    Ok(())
}
