//! Nonlinear conjugate gradients (Polak-Ribiere+) with a secant search that knows the curvature of
//! the last direction.

use super::{Landscape, Lost};
use crate::numerics::vector::{add, dot};

/// Share of its slope that a direction may keep: most trials then need no second one.
const SLOPE: f64 = 0.3;

pub(super) fn relax(land: &mut Landscape<'_>) -> Result<(), Lost> {
    let mut d: Vec<f64> = land.gradient.iter().map(|g| -g).collect();
    // Of order one in these variables.
    let mut curvature = 1.0;
    loop {
        if let Some(end) = land.ended() {
            return end;
        }
        let before = land.gradient.clone();
        if dot(&before, &d) >= 0.0 {
            d = before.iter().map(|g| -g).collect();
        }
        let t = -dot(&before, &d) / (curvature * dot(&d, &d));
        curvature = land.search(&d, t, SLOPE)?;
        let g = &land.gradient;
        let beta = ((dot(g, g) - dot(g, &before)) / dot(&before, &before)).max(0.0);
        d.iter_mut().for_each(|d| *d *= beta);
        add(&mut d, -1.0, g);
    }
}
