//! The flat state on flat ground: a closed form that costs nothing, stable up to where Eq. 8 says; and
//! the patterns that come out of it continuously there.

use crate::numerics::dense::dot;
use crate::physics::control::Control;
use crate::physics::law::Law;
use crate::physics::system::System;
use crate::physics::theory::{boundary, flat_limits, flat_stiffness};
use crate::solver::method::{Cost, Equilibrium, Lost, Stiffness, Stop};
use crate::solver::sector::{Node, SHARP, Sector, Side};
use std::f64::consts::PI;

/// The flat branch of a law in a cell under its control.
#[derive(Clone, Copy, Debug)]
pub struct FlatBranch {
    law: Law,
    control: Control,
    /// Side of the half-space's cell in which the longest wave is as stiff as the softest here.
    cell: f64,
    /// Side of the cell whose longest wave is as stiff as what is softest here: the softest wave of
    /// the body, pi E*/L, or the machine, when the body moves as a block.
    length: f64,
    /// True if that is the machine.
    as_a_block: bool,
    /// The gaps between which it is unstable.
    unstable: Option<(f64, f64)>,
}

impl FlatBranch {
    /// The branch in a cell of side `length`, which for a layer is the equivalent one of a
    /// half-space.
    pub fn new(law: Law, length: f64, control: Control) -> Self {
        let block = PI / control.stiffness();
        Self {
            law,
            control,
            cell: length,
            length: length.max(block),
            as_a_block: block > length,
            unstable: flat_limits(&law, length.max(block)),
        }
    }

    /// The smallest eigenvalue at gap `u0` (E* per length).
    pub fn stiffness(&self, u0: f64) -> f64 {
        match self.control {
            Control::Load => self.law.at(u0).stiffness,
            _ => flat_stiffness(&self.law, self.length, u0) / self.length,
        }
    }

    /// The control at the (lower, upper) end of what is stable: upper is met on approach, lower on
    /// retraction. `None` where it is stable everywhere. Under a load what is not in contact is
    /// apart, up to no load at all.
    pub fn limits(&self) -> Option<(f64, f64)> {
        let held = |gap: f64| self.control.balanced(gap, self.law.at(gap).traction)[0];
        let (lower, upper) = self.unstable?;
        Some(match self.control {
            Control::Load => (held(lower), 0.0),
            _ => (held(lower), held(upper)),
        })
    }

    /// The (lower, upper) gaps between which it is unstable (length); `None` where it is stable
    /// everywhere.
    pub fn unstable_gaps(&self) -> Option<(f64, f64)> {
        self.unstable
    }

    /// On which side of what is unstable a gap lies: towards the ground, or off it.
    pub fn side_of(&self, gap: f64) -> Side {
        match self.unstable {
            Some((lower, _)) if gap <= lower => Side::Lower,
            _ => Side::Upper,
        }
    }

    /// The gap of the flat state on a `side` of what is unstable where the control has this
    /// `value`, or the end of that side if it lies nearer.
    pub fn gap_on(&self, side: Side, value: f64) -> f64 {
        let from = match (self.control, side) {
            (Control::Displacement, _) => return value,
            (Control::Load, Side::Upper) => return Control::stop(&self.law, self.cell),
            // The spring is stretched there: the gap is smaller.
            (_, Side::Upper) => value + self.law.range,
            (_, Side::Lower) => self.law.equilibrium_gap(),
        };
        self.at_control(from, value)
            .unwrap_or_else(|(stable, _)| stable)
    }

    /// True if the body gives way as a block, before any wave does.
    pub fn gives_way_as_a_block(&self) -> bool {
        self.as_a_block
    }

    /// The flat state of a `system` where its drive begins, far from the ground.
    pub fn first(&self, system: &System, value: f64) -> Equilibrium {
        let gap = match self.control {
            Control::Displacement => value,
            // The spring is stretched there: the gap is smaller.
            _ => self
                .at_control(value + self.law.range, value)
                .unwrap_or_else(|(_, unstable)| unstable),
        };
        self.state(system, gap)
    }

    /// The gap of the flat state where the control has this `value`, on the way there from a stable
    /// gap `from`; or where stability is lost on that way, as the last stable and the first unstable
    /// double.
    pub fn at_control(&self, from: f64, value: f64) -> Result<f64, (f64, f64)> {
        if self.control == Control::Displacement {
            return self.limit_between(from, value).map_or(Ok(value), Err);
        }
        // The control grows with the gap wherever the flat state is stable.
        let ahead = |gap: f64| {
            let [there, _] = self.control.balanced(gap, self.law.at(gap).traction);
            value - there
        };
        let side = ahead(from).signum();
        let (mut near, mut far, mut width) = (from, from, self.law.range);
        while side * ahead(far) > 0.0 {
            (near, far) = (far, far + side * width);
            width *= 2.0;
            if !far.is_finite() {
                return Err((near, far));
            }
            if let Some((stable, unstable)) = self.limit_between(near, far) {
                if side * ahead(stable) > 0.0 {
                    return Err((stable, unstable));
                }
                far = stable;
            }
        }
        Ok(boundary(near, far, |gap| side * ahead(gap) > 0.0))
    }

    /// The flat state of a `system` of this law and cell at gap `u0`, exact.
    pub fn state(&self, system: &System, u0: f64) -> Equilibrium {
        let value = self.stiffness(u0);
        let stop = if self.is_finite(u0, value) {
            Stop::Stable
        } else {
            Stop::NotConverged
        };
        let mut flat = Equilibrium::unmeasured(system.uniform(u0), 0.0, stop, Cost::default());
        flat.measured(Stiffness { value, error: 0.0 }, Vec::new());
        flat
    }

    /// The same next to gap `u0` where the control has this `value`: the energy of a machine that
    /// yields goes with what u0 is off.
    pub fn state_at(&self, system: &System, u0: f64, value: f64) -> Equilibrium {
        let gap = if self.is_stable(u0) {
            self.at_control(u0, value).unwrap_or(u0)
        } else {
            u0
        };
        let mut flat = self.state(system, gap);
        flat.state.control = value;
        flat
    }

    /// True if the flat state at gap `u0` is stable. At the limit itself it is not: nothing holds the
    /// softest wave there.
    pub fn is_stable(&self, u0: f64) -> bool {
        let value = self.stiffness(u0);
        value > 0.0 && self.is_finite(u0, value)
    }

    /// False so deep in the wall that the law overflows.
    fn is_finite(&self, u0: f64, stiffness: f64) -> bool {
        stiffness.is_finite() && self.law.at(u0).energy.is_finite()
    }

    /// Where stability is lost on the way `from` a stable gap `to` another, as the last stable and
    /// the first unstable double found by bisection; `None` if it is not lost.
    fn limit_between(&self, from: f64, to: f64) -> Option<(f64, f64)> {
        let stable = |u: f64| self.stiffness(u) > 0.0;
        let (lower, upper) = self.unstable?;
        // The unstable gaps are one interval: the gap of the way that lies nearest to its middle
        // tells whether it is met.
        let (mut a, mut b) = (
            from,
            (0.5 * (lower + upper)).clamp(from.min(to), from.max(to)),
        );
        if stable(b) {
            return None;
        }
        while (b - a).abs() > 1e-9 * self.law.range {
            let middle = 0.5 * (a + b);
            if middle == a || middle == b {
                break;
            }
            if stable(middle) {
                a = middle;
            } else {
                b = middle;
            }
        }
        Some((a, b))
    }
}

/// Distance (ranges) before a limit from which a pattern may be seen to fade.
const NEAR: f64 = 0.15;
/// Where a^2, falling as it does, would vanish, in units of the distance to the limit: below 2 for
/// g > 0, and above for g < 0.
const TRICRITICAL: f64 = 2.0;
/// The same where a^2 is as good as proportional to the distance.
const LINEAR: f64 = 1.25;
/// Distance (ranges) from which it is believed: farther off another symmetry may be lost on the way.
const CERTAIN: f64 = 0.02;
/// At this distance (ranges), up to so much more, the fold lies within 2e-5 ranges of the limit, and a
/// jump would free too little to be told from none.
const NEXT: f64 = 5e-4;
const UNRESOLVED: f64 = 2.5;

/// A pattern about to fade away at a limit of the flat state: where that gives way continuously (a
/// supercritical bifurcation) a branch does not turn back, but goes over into it.
///
/// Of the Landau energy r a^2 + g a^4 + h a^6 of an amplitude a, r is proportional to the distance
/// from the limit and h > 0. With g > 0 the pattern goes as the root of that distance; with g < 0 it
/// is still there at the limit, and has a fold beyond.
pub(super) struct Fading {
    /// u0 of the limit, and the distance to it (length).
    limit: f64,
    pub(super) ahead: f64,
    /// True where it is known to.
    pub(super) is_certain: bool,
}

impl Fading {
    /// `None` where the branch of `here` does not seem to fade on this `side`.
    pub(super) fn of(sector: &Sector, here: &Node, side: Side) -> Option<Self> {
        let system = sector.system();
        let (law, length) = (system.law(), system.grid().length);
        let limit = <[f64; 2]>::from(flat_limits(law, length)?)[side.index()];
        let ahead = side.sign() * (limit - here.u0());
        let z = &here.state.amplitudes;
        let fall = -2.0 * side.sign() * dot(z, &here.tangent);
        let vanishes = dot(z, z) / (fall * ahead);
        let is_near = 0.0 < ahead && ahead < NEAR * law.range;
        let is_next = ahead < NEXT * law.range;
        let most = if is_next { UNRESOLVED } else { TRICRITICAL };
        (is_near && 0.0 < vanishes && vanishes < most).then_some(Self {
            limit,
            ahead,
            is_certain: vanishes < LINEAR && ahead < CERTAIN * law.range || is_next,
        })
    }

    /// The end of the branch, whose slope is extrapolated from the last node and one `before`.
    pub(super) fn end(&self, sector: &Sector, before: Option<&Node>, here: &Node) -> Node {
        let bend = before.map_or(0.0, |b| (here.slope - b.slope) / (here.u0() - b.u0()));
        let slope = here.slope + bend * (self.limit - here.u0());
        sector.out_of_flat(self.limit, slope)
    }
}

/// The end on a `side` where a branch fades whose `end` and the node `near` it are those of a slightly
/// different law or cell, if it still does.
///
/// # Errors
/// It does not, as far as the node near it tells.
pub(super) fn refade(to: &mut Sector, end: &Node, near: &Node, side: Side) -> Result<Node, Lost> {
    let (law, length) = (to.system().law(), to.system().grid().length);
    let limits = flat_limits(law, length).ok_or(Lost::Gone)?;
    let u0 = <[f64; 2]>::from(limits)[side.index()] + near.u0() - end.u0();
    let (node, _) = to.node(u0, near.state.amplitudes.clone(), None, SHARP)?;
    let fading = Fading::of(to, &node, side).ok_or(Lost::Gone)?;
    let slope = node.slope + end.slope - near.slope;
    Ok(to.out_of_flat(fading.limit, slope))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::law::{Cosine, DoubleExponential, Mie, Morse, Shape};
    use crate::physics::theory::critical_length;
    use proptest::prelude::*;

    fn any_law() -> impl Strategy<Value = Law> {
        let shape = prop_oneof![
            Just(Shape::Morse(Morse)),
            Just(Shape::Mie(Mie { m: 8.0, n: 2.0 })),
            Just(Shape::Cosine(Cosine { smooth: true })),
            (0.1..0.99_f64).prop_map(|ratio| Shape::DoubleExponential(DoubleExponential { ratio })),
        ];
        (shape, -3.0..3.0_f64).prop_map(|(shape, decade)| Law {
            shape,
            surface_energy: 0.15,
            range: 10f64.powf(decade),
        })
    }

    proptest! {
        /// Against a scan of the whole way in small pieces.
        #[test]
        fn the_limit_on_the_way_is_where_a_scan_first_meets_an_unstable_gap(
            law in any_law(), periods in 1.01..30.0_f64, from in -1.0..12.0_f64, to in -1.0..12.0_f64,
        ) {
            let length = periods * critical_length(&law);
            let branch = FlatBranch::new(law, length, Control::Displacement);
            let base = law.equilibrium_gap();
            let (from, to) = (base + from.abs() * law.range, base + to.abs() * law.range);
            let stable = |u: f64| flat_stiffness(&law, length, u) > 0.0;
            prop_assume!(stable(from));
            let scanned = (0..=20_000).map(|i| from + (to - from) * f64::from(i) / 20_000.0).find(|&u| !stable(u));
            match (branch.limit_between(from, to), scanned) {
                (None, None) => {}
                (Some((last, first)), scanned) => {
                    prop_assert!(stable(last) && !stable(first) && (last - first).abs() <= 1e-9 * law.range);
                    let step = (to - from).abs() / 20_000.0;
                    // An interval thinner than the scan's step may be missed by it, never by the
                    // branch.
                    let met = scanned.map_or(step, |u| (u - first).abs());
                    prop_assert!(met <= step * (1.0 + 1e-9) || scanned.is_none(), "{first} {scanned:?}");
                }
                (None, Some(u)) => prop_assert!(false, "unstable at {u}"),
            }
        }
    }

    proptest! {
        /// Whatever law, spring or load: a state of that control, or the end of what is stable
        /// before it.
        #[test]
        fn the_flat_state_of_any_control_is_found_or_its_end_is(
            law in any_law(), stiffness in -6.0..6.0_f64, from in 0.01..0.99_f64, value in -2.0..9.0_f64, kind in 1..3_usize,
        ) {
            let control = Control::all(10f64.powf(stiffness) / law.range)[kind];
            let branch = FlatBranch::new(law, 3.0 * critical_length(&law), control);
            let (rest, edge) = (law.equilibrium_gap(), law.contact_gap());
            let from = rest + from * (edge - rest) * 0.5;
            prop_assume!(branch.is_stable(from));
            let value = value * control.unit(&law);
            match branch.at_control(from, value) {
                Ok(gap) => {
                    prop_assert!(branch.is_stable(gap), "{gap}");
                    let [there, _] = control.balanced(gap, law.at(gap).traction);
                    prop_assert!((there - value).abs() <= 1e-9 * control.unit(&law).max(value.abs()), "{there} {value}");
                }
                Err((stable, unstable)) => {
                    prop_assert!(branch.is_stable(stable) && !branch.is_stable(unstable), "{stable} {unstable}");
                }
            }
        }
    }

    #[test]
    fn a_way_of_any_length_is_searched_in_no_time() {
        let law = Law {
            shape: Shape::Morse(Morse),
            surface_energy: 0.15,
            range: 0.1,
        };
        let branch = FlatBranch::new(law, 64.0, Control::Displacement);
        for far in [1e7, 1e60, 1e300] {
            let (last, first) = branch
                .limit_between(far, 0.0)
                .expect("the limit lies on the way");
            let (_, upper) = flat_limits(&law, 64.0).expect("unstable");
            assert!(
                (last - upper).abs() <= 1e-9 && (first - upper).abs() <= 1e-9,
                "{last} {first} {upper}"
            );
            assert_eq!(branch.limit_between(far, 0.5 * far), None);
        }
    }
}
