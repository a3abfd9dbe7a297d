//! Closed forms, laws, grounds and mechanics: what is known without solving for a loop.

mod griffith;
mod hertz;
mod laws;
mod layer;
#[path = "../shared/loops.rs"]
mod loops;
mod mechanics;
mod numerics;
mod patterns;
mod theory;
mod topography;

/// Holds `found` to `expected` but for a share of it.
#[track_caller]
fn close(found: f64, expected: f64, share: f64) {
    let off = (found / expected - 1.0).abs();
    assert!(
        off < share,
        "{found:e} for {expected:e}: off by {off:.1e} of it"
    );
}

/// Holds `found` to `expected` but for so much.
#[track_caller]
fn near(found: f64, expected: f64, within: f64) {
    let off = (found - expected).abs();
    assert!(off < within, "{found:e} for {expected:e}: off by {off:.1e}");
}
