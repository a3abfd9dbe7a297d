//! One branch followed to its end with long tangent steps; the end located directly.

use crate::follow::record::LOCATED;
use crate::numerics::vector::{add, hermite, norm};
use crate::physics::system::Fields;
use crate::physics::theory::flat;
use crate::solver::Lost;
use crate::solver::branch::distance;
use crate::solver::sector::{NODE, Node, Sector, Side};

/// How a branch of stable states ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum End {
    /// It turns back.
    Fold,
    /// It goes on, unstable, where a mode of another symmetry has gone soft.
    Breaking,
}

/// First step (ranges), and the longest: shorter than any branch of the paper's, so that none is
/// jumped over.
const FIRST: f64 = 0.1;
const LONGEST: f64 = 0.7;
/// A branch is lost when the step falls below this (ranges).
const SHORTEST: f64 = 2e-4;
/// Error of the prediction, root mean square in ranges, that the step length aims at in a cell of 3
/// L_c; in longer ones, where amplitudes are larger and edges creep over the mesh, more is allowed.
const AIM: f64 = 0.03;
/// Distance (ranges) from which a fold is gone for directly.
const NEAR_FOLD: f64 = 0.15;
/// At a fold, breaking eigenvalues below this share of q1 are computed over all waves of the mesh.
const SOFT: f64 = 0.1;
/// Most Newton steps towards it.
const CROSSINGS: usize = 24;
/// Most nodes of one branch, one way.
const NODES: usize = 60;
/// Largest deviation from the prediction in units of the predicted change: beyond it another branch
/// was found.
const STRAY: f64 = 0.6;

/// Follows the branch of `first`, whose `breaking` is known over all waves, towards growing u0 if
/// `up`. Nodes in order, without `first`; the last is the end. A node `behind` the first one, if
/// there is one, tells where the branch comes from.
///
/// # Errors
/// The branch was lost before an end was found.
pub fn trace(
    sector: &mut Sector,
    first: &Node,
    behind: Option<&Node>,
    side: Side,
) -> Result<(Vec<Node>, End), Lost> {
    let range = sector.system().law().range;
    let sign = side.sign();
    let periods = sector.system().grid().length / flat::critical_length(sector.system().law());
    let aim = AIM * (periods / 3.0).clamp(1.0, 3.0);
    let mut nodes: Vec<Node> = Vec::new();
    let mut step = FIRST * range;
    // A fold beyond which symmetry is already broken: the end lies before it.
    let mut wall = f64::INFINITY;
    while nodes.len() < NODES {
        let (before, here) = match nodes.len() {
            0 => (behind, first.clone()),
            1 => (Some(first), nodes[0].clone()),
            n => (Some(&nodes[n - 2]), nodes[n - 1].clone()),
        };
        let fold = before.map_or(f64::INFINITY, |b| zero_of_square(b, &here));
        if let Some(before) = before
            && fold < NEAR_FOLD * range
            && wall.is_infinite()
        {
            if let Ok((mut end, fields)) = sector.fold(before, &here, side) {
                if end.breaking < SOFT * sector.system().grid().q1() {
                    sector.sharpen(&mut end, &fields);
                }
                let ahead = sign * (end.state.mean_displacement - here.state.mean_displacement);
                if ahead > -1e-9 * range && ahead < 4.0 * NEAR_FOLD * range {
                    if end.breaking >= 0.0 {
                        end.own = 0.0;
                        nodes.push(end);
                        return Ok((nodes, End::Fold));
                    }
                    if ahead < 20.0 * LOCATED * range {
                        nodes.push(end);
                        return Ok((nodes, End::Breaking));
                    }
                    wall = ahead;
                }
            }
            step = step.min(0.5 * wall.min(fold));
        }
        let breaking = before.map_or(f64::INFINITY, |b| zero(b, &here));
        // Past the expected zero, so that it is enclosed; in this symmetry the branch simply goes
        // on there.
        let h = step
            .min(0.6 * fold)
            .min(0.5 * wall)
            .min(1.5 * breaking + 0.02 * range);
        if !(h > SHORTEST * range) {
            return Err(Lost::Gone);
        }
        let u0 = here.state.mean_displacement + sign * h;
        let guess = predict(before, &here, u0);
        let predicted = distance(&guess, &here.state.amplitudes);
        let node = sector.node(u0, guess.clone(), Some(&here), NODE);
        let strayed = |n: &Node| {
            distance(&guess, &n.state.amplitudes) > STRAY * predicted + 1e-3 * range
                || !audit(&here, n, range, sector)
        };
        let (node, fields) = match node {
            Ok((node, fields)) if !strayed(&node) && node.own > 0.0 => (node, fields),
            Err(Lost::Cancelled) => return Err(Lost::Cancelled),
            _ => {
                step = 0.35 * h;
                continue;
            }
        };
        let error = distance(&guess, &node.state.amplitudes) / range;
        step = (h * (aim / error).powf(0.3).clamp(0.4, 2.5)).min(LONGEST * range);
        if wall.is_finite() {
            wall -= h;
        }
        let broken = node.breaking < 0.0;
        nodes.push(node);
        if broken {
            let end = cross(sector, first, &mut nodes, &fields)?;
            nodes.push(end);
            return Ok((nodes, End::Breaking));
        }
    }
    Err(Lost::Gone)
}

/// Hermite extrapolation from two nodes, or along the tangent of one.
fn predict(before: Option<&Node>, here: &Node, u0: f64) -> Vec<f64> {
    let Some(before) = before else {
        let mut z = here.state.amplitudes.clone();
        add(&mut z, u0 - here.state.mean_displacement, &here.tangent);
        return z;
    };
    between(before, here, u0)
}

/// Cubic Hermite between two regular nodes, at any u0.
pub fn between(a: &Node, b: &Node, u0: f64) -> Vec<f64> {
    let h = b.state.mean_displacement - a.state.mean_displacement;
    let t = (u0 - a.state.mean_displacement) / h;
    let (y, z) = (&a.state.amplitudes, &b.state.amplitudes);
    hermite([y, &a.tangent, z, &b.tangent], h, t)
}

/// Distance beyond `here` at which `own`, whose square falls linearly before a fold, would vanish.
fn zero_of_square(before: &Node, here: &Node) -> f64 {
    let fall = (before.own.powi(2) - here.own.powi(2))
        / (here.state.mean_displacement - before.state.mean_displacement).abs();
    if fall > 0.0 {
        here.own.powi(2) / fall
    } else {
        f64::INFINITY
    }
}

/// Distance beyond `here` at which `breaking`, which falls linearly, would vanish.
fn zero(before: &Node, here: &Node) -> f64 {
    let fall = (before.breaking - here.breaking)
        / (here.state.mean_displacement - before.state.mean_displacement).abs();
    if fall > 0.0 {
        (here.breaking / fall).max(0.0)
    } else {
        f64::INFINITY
    }
}

/// Along a branch dV = stress du0, by the trapezoid with its end correction: a step across a jump
/// pays with energy.
fn audit(from: &Node, to: &Node, range: f64, sector: &Sector) -> bool {
    let h = to.state.mean_displacement - from.state.mean_displacement;
    let work =
        0.5 * h * (from.state.stress + to.state.stress) - h * h / 12.0 * (to.slope - from.slope);
    let missing = (to.state.energy - from.state.energy - work).abs();
    let law = sector.system().law();
    missing
        <= 0.05 * ((to.state.stress - from.state.stress) * h).abs()
            + 1e-4 * law.surface_energy * (h / range).abs()
        && norm(&to.state.amplitudes) > 1e-3 * range
}

/// The node where the breaking eigenvalue vanishes over all waves of the mesh; `nodes` (after
/// `first`, the last one unstable and with these `fields`) lose those beyond it.
///
/// The nodes know the eigenvalue from the longest waves only, which is too high by nearly the same
/// amount everywhere: the last one's value over all waves corrects them.
fn cross(
    sector: &mut Sector,
    first: &Node,
    nodes: &mut Vec<Node>,
    fields: &Fields,
) -> Result<Node, Lost> {
    let range = sector.system().law().range;
    let mut b = nodes.pop().expect("the unstable node");
    let of_block = b.breaking;
    sector.sharpen(&mut b, fields);
    let offset = b.breaking - of_block;
    let mut a = loop {
        // The first one is known over all waves, and stable.
        let Some(last) = nodes.last() else {
            break first.clone();
        };
        let mut last = last.clone();
        last.breaking += offset;
        if last.breaking.abs() < 0.5 * offset.abs() {
            // Too near to call by the correction.
            last = sector.sharp_node(
                last.state.mean_displacement,
                last.state.amplitudes.clone(),
                Some(&last),
            )?;
        }
        if last.breaking > 0.0 {
            break last;
        }
        // Stable to the longest waves, but not to all.
        b = last;
        nodes.pop().ok_or(Lost::Gone)?;
    };
    for round in 0..CROSSINGS {
        let rate =
            (a.breaking - b.breaking) / (a.state.mean_displacement - b.state.mean_displacement);
        let secant = a.state.mean_displacement - a.breaking / rate;
        let enclosed =
            (secant - a.state.mean_displacement) * (secant - b.state.mean_displacement) < 0.0;
        // Where the eigenvalue falls off steeply towards one end, secants creep.
        let u0 = if enclosed && round % 4 != 3 {
            secant
        } else {
            0.5 * (a.state.mean_displacement + b.state.mean_displacement)
        };
        let node = sector.sharp_node(u0, between(&a, &b, u0), Some(&a))?;
        // The two ends may be known less well than their distance to this node, but not than their
        // own.
        let correction = -node.breaking / rate;
        if correction.abs() < LOCATED * range {
            return Ok(moved(node, correction, rate));
        }
        if node.breaking > 0.0 {
            a = node;
        } else {
            b = node;
        }
    }
    Err(Lost::Gone)
}

/// The symmetry-breaking end next to `near`, one of a slightly different law or cell.
///
/// # Errors
/// It was not found.
pub fn recross(sector: &mut Sector, near: &Node) -> Result<Node, Lost> {
    let range = sector.system().law().range;
    let (mut u0, mut z, mut rate) = (
        near.state.mean_displacement,
        near.state.amplitudes.clone(),
        near.bend,
    );
    let mut last: Option<(f64, f64)> = None;
    for _ in 0..CROSSINGS {
        let node = sector.sharp_node(u0, z, None)?;
        if let Some((u, value)) = last {
            rate = (node.breaking - value) / (node.state.mean_displacement - u);
        }
        let correction = -node.breaking / rate;
        if node.own <= 0.0 || !(correction.abs() < LONGEST * range) {
            break;
        }
        if correction.abs() < LOCATED * range {
            return Ok(moved(node, correction, rate));
        }
        last = Some((node.state.mean_displacement, node.breaking));
        z = node.state.amplitudes.clone();
        add(&mut z, correction, &node.tangent);
        u0 += correction;
    }
    Err(Lost::Gone)
}

/// A node moved along its branch by so little that its tangent serves; `rate` is d breaking/du0.
fn moved(mut node: Node, du: f64, rate: f64) -> Node {
    node.state.drive_by(du);
    node.state.energy += du * node.state.stress;
    node.state.stress += du * node.slope;
    add(&mut node.state.amplitudes, du, &node.tangent);
    node.bend = rate;
    node
}
