//! Computes the loops of the presets and prints `assets/thumbnails.csv`: their small pictures in the
//! gallery of the window. Arguments choose presets by their names.

use std::error::Error;
use tackscope::follow::record::{Direction, StateRecord};
use tackscope::numerics::threads::Cancel;
use tackscope::scene::Scene;
use tackscope::solver::methods::MethodKind;
use tackscope::storage;
use tackscope::study::plan::{plan, run_planned};

/// Places along a direction: as many as a small picture shows.
const PLACES: usize = 60;

fn main() -> Result<(), Box<dyn Error>> {
    let chosen: Vec<String> = std::env::args().skip(1).collect();
    let all = storage::presets().iter();
    for preset in all.filter(|p| chosen.is_empty() || chosen.iter().any(|name| name == p.name)) {
        let scene = preset.scene()?;
        for row in rows(&scene)? {
            println!("{},{row}", preset.name);
        }
    }
    Ok(())
}

/// Direction and place in shares of what the loop spans.
fn rows(scene: &Scene) -> Result<Vec<String>, Box<dyn Error>> {
    let plan = plan(scene, &scene.model()?, None);
    let (method, cancel) = (MethodKind::default(), Cancel::default());
    let record = run_planned(scene, method, &plan, &cancel, &mut |_| ())?.record;
    let at = |s: &StateRecord| [s.mean_displacement, s.stress];
    let ends: [[f64; 2]; 2] = std::array::from_fn(|k| {
        let values = record.states.iter().map(|s| at(s)[k]);
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| {
            [low.min(x), high.max(x)]
        })
    });
    let mut rows = Vec::new();
    for direction in Direction::BOTH {
        let states = record.states.iter().filter(|s| s.direction == direction);
        let states: Vec<&StateRecord> = states.collect();
        let every = states.len().div_ceil(PLACES).max(1);
        let seen = |(i, s): &(usize, &&StateRecord)| {
            // Both ends of every jump.
            let of = |i: usize| states.get(i).map(|s| s.pattern);
            let edge =
                of(i + 1) != Some(s.pattern) || i.checked_sub(1).and_then(of) != Some(s.pattern);
            i % every == 0 || edge
        };
        for (_, state) in states.iter().enumerate().filter(seen) {
            let [x, y]: [f64; 2] = std::array::from_fn(|k| {
                let [low, high] = ends[k];
                (at(state)[k] - low) / (high - low)
            });
            rows.push(format!("{direction},{x:.3},{y:.3}"));
        }
    }
    Ok(rows)
}
