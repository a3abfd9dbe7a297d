//! An atlas for a law or a cell a little different: its ends and nodes found again from those of
//! the old one.

use super::curve::{Branch, End};
use super::trace::{recross, returned};
use super::{Atlas, Meshes, Place};
use crate::numerics::dense::add;
use crate::physics::control::Control;
use crate::physics::system::carried;
use crate::solver::Lost;
use crate::solver::sector::{NODE, Node, Sector, Side};
use std::collections::BTreeSet;

/// Nodes of an adapted branch between its ends, besides those at landings.
const INNER: usize = 1;

impl Atlas {
    /// The same branches for `meshes`, whose law and cell should differ by a few percent at most.
    /// Landings are taken over as they are: the caller compares the order of jumps before and
    /// after.
    ///
    /// # Errors
    /// A branch that was not found again; then a new atlas must be made.
    pub fn adapted(&self, meshes: Meshes) -> Result<Self, Lost> {
        let mut new = Self::new(meshes);
        new.obey(&self.cancel);
        let landings = |i: usize| -> Vec<f64> {
            self.landed()
                .filter(|l| l.2 == i)
                .map(|l| {
                    let control = self.end_state(l.0, l.1).control;
                    self.branches[i].place(self.meshes.control, control)
                })
                .collect()
        };
        for (i, old) in self.branches.iter().enumerate() {
            let from = self.sector_of(old);
            let to = if old.is_ridge {
                &mut new.ridge
            } else {
                &mut new.square
            };
            new.branches
                .push(adapt(old, &landings(i), meshes.control, from, to)?);
        }
        new.landings.clone_from(&self.landings);
        for (place, side, i) in self.landed() {
            if matches!(place, Place::Flat(_)) && new.flat.limits().is_none() {
                return Err(Lost::Gone);
            }
            new.pin(i, new.end_state(place, side).control)?;
        }
        Ok(new)
    }

    /// The known landings on branches: place, its end, and the branch landed on.
    fn landed(&self) -> impl Iterator<Item = (Place, Side, usize)> + '_ {
        self.landings.iter().enumerate().flat_map(|(row, ends)| {
            Side::BOTH.into_iter().filter_map(move |side| {
                let place = match row {
                    0 => Place::Flat(side.opposite()),
                    _ => Place::On(row - 1),
                };
                match ends[side.index()] {
                    Some(Place::On(i)) => Some((place, side, i)),
                    _ => None,
                }
            })
        })
    }
}

/// The branch `old` found again; of its inner nodes those next to the u0 of `landings`, whose
/// energies count, and a few more.
fn adapt(
    old: &Branch,
    landings: &[f64],
    control: Control,
    from: &Sector,
    to: &mut Sector,
) -> Result<Branch, Lost> {
    let last = old.nodes.len() - 1;
    let mut end = |side: Side| {
        let node = moved(old.end(side), from, to);
        match old.ends[side.index()] {
            End::Fold if node.slope.is_finite() => returned(to, control, &node),
            End::Fold => to.refold(&node, side).map(|(end, _)| end),
            End::Breaking => recross(to, &node),
        }
    };
    let (low, high) = (end(Side::Lower)?, end(Side::Upper)?);
    // Symmetry must not break before a fold.
    let holds =
        |node: &Node, side: Side| old.ends[side.index()] == End::Breaking || node.breaking >= 0.0;
    if !holds(&low, Side::Lower) || !holds(&high, Side::Upper) {
        return Err(Lost::Gone);
    }
    let (a, b) = (
        old.nodes[0].state.mean_displacement,
        old.nodes[last].state.mean_displacement,
    );
    let changed = |new: &Node, old: &Node| {
        let mut change = new.state.amplitudes.clone();
        add(
            &mut change,
            -1.0,
            &carried(&old.state.amplitudes, from.system(), to.system()),
        );
        change
    };
    let (change_low, change_high) = (
        changed(&low, &old.nodes[0]),
        changed(&high, &old.nodes[last]),
    );
    let mut nodes = vec![low];
    let (from_u, width) = (
        nodes[0].state.mean_displacement,
        high.state.mean_displacement - nodes[0].state.mean_displacement,
    );
    let stride = (last - 1).div_ceil(INNER).max(1);
    let nearest = |u0: &f64| {
        (1..last).min_by(|&i, &j| {
            (old.nodes[i].state.mean_displacement - u0)
                .abs()
                .total_cmp(&(old.nodes[j].state.mean_displacement - u0).abs())
        })
    };
    let few = (1..last).skip(((last - 1) % stride) / 2).step_by(stride);
    let chosen: BTreeSet<usize> = few.chain(landings.iter().filter_map(nearest)).collect();
    for k in chosen {
        let share = (old.nodes[k].state.mean_displacement - a) / (b - a);
        let mut z = carried(&old.nodes[k].state.amplitudes, from.system(), to.system());
        // What changed at the ends changed a part of that in between.
        add(&mut z, 1.0 - share, &change_low);
        add(&mut z, share, &change_high);
        let (node, _) = to.node(from_u + share * width, z, None, NODE)?;
        nodes.push(node);
    }
    nodes.push(high);
    let stable = nodes[1..nodes.len() - 1]
        .iter()
        .all(|n| n.own > 0.0 && n.breaking > 0.0 && !control.softens([1.0, n.slope]));
    let ordered = nodes
        .windows(2)
        .all(|w| w[0].state.mean_displacement < w[1].state.mean_displacement);
    if !stable || !ordered {
        return Err(Lost::Gone);
    }
    Ok(Branch {
        pattern: old.pattern,
        is_ridge: old.is_ridge,
        nodes,
        ends: old.ends,
    })
}

/// A node as a first guess on another mesh. Displacements hardly scale with the range: what
/// elasticity and surface energy balance has a length of its own, sqrt(gamma L/E*).
fn moved(node: &Node, from: &Sector, to: &Sector) -> Node {
    let mut guess = node.clone();
    guess.state.amplitudes = carried(&node.state.amplitudes, from.system(), to.system());
    guess.tangent = carried(&node.tangent, from.system(), to.system());
    guess
}
