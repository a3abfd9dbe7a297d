//! FIRE: damped dynamics that turns its velocity into the force and stops when it goes uphill.

use super::{Landscape, Lost};
use crate::numerics::vector::{add, dot, norm, scale};

/// Steering at the start of a run downhill, and its decay per step.
const STEERING: f64 = 0.1;
const STEERING_DECAY: f64 = 0.99;
/// Growth of the time step on the way down, cut when uphill, and steps after which it may grow.
const GROWTH: f64 = 1.1;
const CUT: f64 = 0.5;
const PATIENCE: usize = 5;
/// First and largest time step over the limit 2/sqrt(stiffest eigenvalue).
const FIRST: f64 = 0.4;
const LARGEST: f64 = 0.8;

pub(super) fn relax(land: &mut Landscape<'_>) -> Result<(), Lost> {
    let limit = |land: &Landscape<'_>| 2.0 / land.stiffest().sqrt();
    let mut velocity = vec![0.0; land.gradient.len()];
    let (mut dt, mut steering, mut downhill) = (FIRST * limit(land), STEERING, 0);
    loop {
        if let Some(end) = land.ended() {
            return end;
        }
        if dot(&velocity, &land.gradient) <= 0.0 {
            downhill += 1;
            if downhill > PATIENCE {
                dt *= GROWTH;
                steering *= STEERING_DECAY;
            }
        } else {
            // Half a step back: the bottom was passed on the way.
            land.go(&velocity, -0.5 * dt);
            velocity.fill(0.0);
            (dt, steering, downhill) = (CUT * dt, STEERING, 0);
        }
        dt = dt.min(LARGEST * limit(land));
        add(&mut velocity, -dt, &land.gradient);
        let force = norm(&land.gradient);
        if force > 0.0 {
            let speed = norm(&velocity);
            scale(&mut velocity, 1.0 - steering);
            add(&mut velocity, -steering * speed / force, &land.gradient);
        }
        land.go(&velocity, dt);
    }
}
