//! Closed forms and fast series: production code and oracles at once.
//!
//! Contact modulus E* = 1 throughout. What is written with a tilde in the paper is made
//! dimensionless by [`units`].

pub mod asymptotes;
pub mod circular;
pub mod discs;
pub mod dissipation;
pub mod flat;
pub mod jkr;
pub mod jkr_periodic;
pub mod ridge;
pub mod units;

/// The point between `below` and `above` where `is_below` turns from true to false, to the last
/// bit.
///
/// `is_below` is never evaluated at the two ends, so that they may lie where it has no meaning.
pub(crate) fn boundary(mut below: f64, mut above: f64, is_below: impl Fn(f64) -> bool) -> f64 {
    loop {
        let middle = 0.5 * (below + above);
        if middle == below || middle == above || middle.is_nan() {
            return middle;
        }
        if is_below(middle) {
            below = middle;
        } else {
            above = middle;
        }
    }
}
