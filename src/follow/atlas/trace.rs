//! One branch followed to its ends with long tangent steps, which are located directly; and the same
//! branch for a law or a cell a little different, found again from its ends and nodes.

use super::read_off::{Branch, End, Support, between, node_between};
use crate::follow::flat_branch::{Fading, refade};
use crate::follow::record::{LOCATED, has_turned};
use crate::numerics::dense::{add, norm};
use crate::physics::control::Control;
use crate::physics::system::{Fields, carried};
use crate::physics::theory::{boundary, critical_length};
use crate::solver::method::{Lost, distance};
use crate::solver::sector::{NODE, Node, SHARP, Sector, Side};
use std::collections::BTreeSet;

/// First step (ranges), and the longest: shorter than any branch of the paper's, so that none is
/// jumped over.
const FIRST: f64 = 0.1;
const LONGEST: f64 = 0.7;
/// A branch is lost when the step falls below this (ranges).
const SHORTEST: f64 = 2e-5;
/// Error of the prediction, root mean square in ranges, that the step length aims at in a cell of 3
/// L_c; in longer ones, where amplitudes are larger and edges creep over the mesh, more is allowed.
const AIM: f64 = 0.03;
/// Distance (ranges) from which a fold is gone for directly.
const NEAR_FOLD: f64 = 0.15;
/// At a fold, breaking eigenvalues below this share of q1 are computed over all waves of the mesh.
const SOFT: f64 = 0.1;
/// Distance, as a share of [`LOCATED`], within which a fold of u0 and where a machine turns back are
/// one.
const ONE: f64 = 0.1;
/// Share of q1 to which the eigenvalue that vanishes at a fold is known there.
const FOLDED: f64 = 1e-3;
/// A curve fits where it has the stress of a node between its supports to this share of sigma_max;
/// and most nodes that are added for it.
const FIT: f64 = 1e-6;
const GRADES: usize = 8;
/// Share of the eigenvalue behind a breaking of symmetry that is little before it.
const CLOSE: f64 = 0.1;
/// Most Newton steps towards it.
const CROSSINGS: usize = 24;
/// Farthest extrapolation from two nodes, in units of their distance: more than steps grow.
const FARTHEST: f64 = 3.0;
/// How much of the predicted change the force of a node may leave undecided along its softest mode:
/// more reads as straying from the branch.
const DECIDED: f64 = 0.02;
/// Most nodes of one branch, one way.
const NODES: usize = 60;
/// A step that leaves less than this share of the pattern led to the flat state; a fold that does is
/// none, but where the pattern fades, and one at which more of the stiffness is left is none either.
const LEFT: f64 = 0.25;
/// Largest deviation from the prediction in units of the predicted change: beyond it another branch
/// was found.
const STRAY: f64 = 0.6;

/// The whole branch of `first`, whose `breaking` is known over all waves: its nodes by growing u0,
/// and how it ends below and above under `control`.
///
/// # Errors
/// The branch was lost before an end was found.
pub fn both_ways(
    sector: &mut Sector,
    control: Control,
    first: Node,
) -> Result<(Vec<Node>, [End; 2]), Lost> {
    let regular = |nodes: &[Node]| nodes.first().filter(|n| !n.is_vertical()).cloned();
    let mut go = |behind: Option<Node>, side| trace(sector, control, &first, behind.as_ref(), side);
    let ((mut nodes, below), (after, above)) = match go(None, Side::Lower) {
        Ok(down) => {
            let up = go(regular(&down.0), Side::Upper)?;
            (down, up)
        }
        // Right above a fold only the way up is open, and tells where the fold is.
        Err(_) => {
            let up = go(None, Side::Upper)?;
            (go(regular(&up.0), Side::Lower)?, up)
        }
    };
    nodes.reverse();
    nodes.push(first);
    nodes.extend(after);
    Ok((nodes, [below, above]))
}

/// Follows the branch of `first`, whose `breaking` is known over all waves, to its end on a `side`
/// under `control`. Nodes in order, without `first`; the last is the end. A node `behind` the first
/// one, if there is one, tells where the branch comes from.
///
/// # Errors
/// The branch was lost before an end was found.
fn trace(
    sector: &mut Sector,
    control: Control,
    first: &Node,
    behind: Option<&Node>,
    side: Side,
) -> Result<(Vec<Node>, End), Lost> {
    let range = sector.system().law().range;
    let sign = side.sign();
    let periods = sector.system().grid().length / critical_length(sector.system().law());
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
        let breaking = before.map_or(f64::INFINITY, |b| zero(b, &here, |node| node.breaking));
        let flat = Fading::of(sector, &here, side);
        // Softness against other symmetries fades with the pattern, unless it is lost before.
        if let Some(flat) = &flat
            && flat.is_certain
            && breaking > 0.75 * flat.ahead
        {
            let end = flat.end(sector, before, &here);
            if control.softens([1.0, end.slope]) {
                return returns(sector, control, (first, nodes), (&here, &end));
            }
            nodes.push(end);
            return Ok((nodes, End::Flat));
        }
        let fold = match (before, &flat) {
            (Some(before), None) => zero(before, &here, |node| node.own.powi(2)),
            _ => f64::INFINITY,
        };
        if let Some(before) = before
            && fold < NEAR_FOLD * range
            && wall.is_infinite()
        {
            match at_fold(sector, control, (first, &nodes), (before, &here), side) {
                Some(Ok(found)) => return Ok(found),
                Some(Err(ahead)) => wall = ahead,
                None => {}
            }
            step = step.min(0.5 * wall.min(fold));
        }
        // Past the expected zero, so that it is enclosed; in this symmetry the branch simply goes
        // on there.
        let h = step
            .min(0.6 * fold)
            .min(flat.as_ref().map_or(f64::INFINITY, |flat| 0.5 * flat.ahead))
            .min(0.5 * wall)
            .min(1.5 * breaking + 0.02 * range);
        if !(h > SHORTEST * range) {
            return Err(Lost::Gone);
        }
        let u0 = here.u0() + sign * h;
        let guess = predict(before, &here, u0);
        let predicted = distance(&guess, &here.state.amplitudes);
        let node = decided(sector, &here, u0, &guess);
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
        if control.softens([1.0, node.slope]) {
            return returns(sector, control, (first, nodes), (&here, &node));
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

/// The nodes of a branch `so_far` (after the first one) with its end at the fold ahead of two nodes, or
/// where under `control` it turns back before that; or how far ahead a fold lies beyond which symmetry
/// is broken. `None` where no fold is found.
fn at_fold(
    sector: &mut Sector,
    control: Control,
    (first, nodes): (&Node, &[Node]),
    (before, here): (&Node, &Node),
    side: Side,
) -> Option<Result<(Vec<Node>, End), f64>> {
    let (range, q1) = (sector.system().law().range, sector.system().grid().q1());
    let (mut end, fields) = sector.fold(before, here, side).ok()?;
    let ahead = side.sign() * (end.u0() - here.u0());
    let turns_back = end.own < LEFT * here.own.max(FOLDED * q1)
        && norm(&end.state.amplitudes) > LEFT * norm(&here.state.amplitudes);
    let is_near = ahead > -1e-9 * range && ahead < 4.0 * NEAR_FOLD * range;
    if !turns_back || !is_near {
        return None;
    }
    if end.breaking < SOFT * q1 {
        sector.sharpen(&mut end, &fields);
    }
    // Under a stiff spring the two are one; what is driven is off by as much as u0.
    let apart = (turning_point(control, here, &end) - end.u0()).abs();
    let turns_before = control.frees_mean() && apart > ONE * LOCATED * range;
    if end.breaking < 0.0 {
        if ahead >= 20.0 * LOCATED * range {
            return Some(Err(ahead));
        }
        return Some(Ok(([nodes, &[end]].concat(), End::Breaking)));
    }
    if turns_before {
        let so_far = (first, nodes.to_vec());
        let found = returns(sector, control, so_far, (here, &end));
        return Some(found.map_err(|_| ahead));
    }
    end.own = 0.0;
    Some(Ok(([nodes, &[end]].concat(), End::Fold)))
}

/// The node at `u0` after `here`, next to the guess, with its fields.
fn decided(
    sector: &mut Sector,
    here: &Node,
    u0: f64,
    guess: &[f64],
) -> Result<(Node, Fields), Lost> {
    let undecided = DECIDED * distance(guess, &here.state.amplitudes);
    let strongest = sector.system().law().traction_max();
    let tolerance = |node: &Node| (undecided * node.own / strongest).clamp(SHARP, NODE);
    let (node, fields) = sector.node(u0, guess.to_vec(), Some(here), tolerance(here))?;
    if tolerance(&node) >= 0.5 * tolerance(here) {
        return Ok((node, fields));
    }
    // Softer than was expected.
    let z = node.state.amplitudes.clone();
    sector.node(u0, z, Some(&node), tolerance(&node))
}

/// Hermite extrapolation from two nodes, or along the tangent of one.
fn predict(before: Option<&Node>, here: &Node, u0: f64) -> Vec<f64> {
    let far = |before: &&Node| (u0 - here.u0()).abs() > FARTHEST * (here.u0() - before.u0()).abs();
    let Some(before) = before.filter(|before| !far(before)) else {
        let mut z = here.state.amplitudes.clone();
        add(&mut z, u0 - here.u0(), &here.tangent);
        return z;
    };
    between(before, here, u0)
}

/// Distance beyond `here` at which a `value` that falls linearly would vanish: `breaking` does, and
/// before a fold the square of `own`.
fn zero(before: &Node, here: &Node, value: fn(&Node) -> f64) -> f64 {
    let fall = (value(before) - value(here)) / (here.u0() - before.u0()).abs();
    if fall > 0.0 {
        (value(here) / fall).max(0.0)
    } else {
        f64::INFINITY
    }
}

/// Along a branch dV = stress du0, by the trapezoid with its end correction: a step across a jump
/// pays with energy.
fn audit(from: &Node, to: &Node, range: f64, sector: &Sector) -> bool {
    let h = to.u0() - from.u0();
    let work =
        0.5 * h * (from.state.stress + to.state.stress) - h * h / 12.0 * (to.slope - from.slope);
    let missing = (to.state.energy - from.state.energy - work).abs();
    let law = sector.system().law();
    missing
        <= 0.05 * ((to.state.stress - from.state.stress) * h).abs()
            + 1e-4 * law.surface_energy * (h / range).abs()
        && norm(&to.state.amplitudes) > LEFT * norm(&from.state.amplitudes)
}

/// The nodes of a branch `so_far` (after the first one) with its end: where under `control` it
/// turns back between two nodes, or where its symmetry breaks before that.
fn returns(
    sector: &mut Sector,
    control: Control,
    so_far: (&Node, Vec<Node>),
    between: (&Node, &Node),
) -> Result<(Vec<Node>, End), Lost> {
    let (first, mut nodes) = so_far;
    let (end, fields) = turn(sector, control, between.0, between.1)?;
    if end.breaking < 0.0 {
        nodes.push(end);
        let end = cross(sector, first, &mut nodes, &fields)?;
        nodes.push(end);
        return Ok((nodes, End::Breaking));
    }
    nodes.extend(graded(sector, between, &end)?);
    nodes.push(end);
    Ok((nodes, End::Fold))
}

/// Nodes from one before an `end` to it, closer and closer until the curve between them fits: a
/// fold of u0 lies beyond, towards which the stress falls off like a square root. States are found
/// from the curve to a node `beyond` the end, which may be that fold.
fn graded(
    sector: &mut Sector,
    (before, beyond): (&Node, &Node),
    end: &Node,
) -> Result<Vec<Node>, Lost> {
    let largest = sector.system().law().traction_max();
    let mut nodes = Vec::new();
    let mut last = before.clone();
    for _ in 0..GRADES {
        let [a, b] = [&last, end].map(Support::of);
        let middle = 0.5 * (a.u0 + b.u0);
        let (node, _) = node_between(sector, (&last, beyond), middle, Some(&last), NODE)?;
        let off = node.state.stress - a.to(b, middle).stress;
        nodes.push(node.clone());
        if off.abs() < FIT * largest {
            break;
        }
        last = node;
    }
    Ok(nodes)
}

/// u0 where the control turns back between a node that it does not soften and one that it does,
/// which may be a fold of u0, by the curve between them: S = -k, as [`Control::softens`] has it.
fn turning_point(control: Control, stable: &Node, beyond: &Node) -> f64 {
    let (from, to) = (Support::of(stable), Support::of(beyond));
    boundary(from.u0, to.u0, |u0| {
        !control.softens([1.0, from.to(to, u0).slope])
    })
}

/// The node there.
fn turn(
    sector: &mut Sector,
    control: Control,
    stable: &Node,
    beyond: &Node,
) -> Result<(Node, Fields), Lost> {
    let law = *sector.system().law();
    let (mut a, mut b) = (stable.clone(), beyond.clone());
    let mut last = f64::INFINITY;
    for _ in 0..CROSSINGS {
        let u0 = turning_point(control, &a, &b);
        let (mut node, fields) = node_between(sector, (&a, &b), u0, None, SHARP)?;
        if has_turned(control, &law, node.slope, u0 - last) {
            sector.sharpen(&mut node, &fields);
            node.bend = (node.slope - a.slope) / (u0 - a.u0());
            return Ok((node, fields));
        }
        last = u0;
        if control.softens([1.0, node.slope]) {
            b = node;
        } else {
            a = node;
        }
    }
    Err(Lost::Gone)
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
        if last.breaking.abs() < (0.5 * offset.abs()).max(CLOSE * b.breaking.abs()) {
            // Too near to call by the correction, or from a state that is not sharp.
            last = sector.sharp_node(last.u0(), last.state.amplitudes.clone(), Some(&last))?;
        }
        if last.breaking > 0.0 {
            break last;
        }
        // Stable to the longest waves, but not to all.
        b = last;
        nodes.pop().ok_or(Lost::Gone)?;
    };
    // (breaking, u0) of the enclosing nodes, and of all since.
    let known = |node: &Node| (node.breaking, node.u0());
    let mut met = vec![known(&b), known(&a)];
    for round in 0..CROSSINGS {
        let zero = vanishing(&met);
        let [low, high] = [&a, &b].map(Node::u0);
        let enclosed = (zero - low) * (zero - high) < 0.0;
        // Where the eigenvalue falls off steeply towards one end, interpolation may creep.
        let u0 = if enclosed && round % 4 != 3 {
            zero
        } else {
            0.5 * (low + high)
        };
        let node = sector.sharp_node(u0, between(&a, &b, u0), Some(&a))?;
        met.push(known(&node));
        // The two ends may be known less well than their distance to this node, but not than their
        // own.
        let correction = vanishing(&met) - u0;
        if correction.abs() < LOCATED * range {
            let (value, place) = met[met.len() - 2];
            let rate = (node.breaking - value) / (u0 - place);
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

/// Where a value vanishes that is known, as (value, place), at two points or more: by the parabola
/// of the place over the value through the last three (E. H. Neville's scheme).
fn vanishing(met: &[(f64, f64)]) -> f64 {
    let last = &met[met.len().saturating_sub(3)..];
    let mut places: Vec<f64> = last.iter().map(|(_, place)| *place).collect();
    for width in 1..last.len() {
        for i in 0..last.len() - width {
            let (a, b) = (last[i].0, last[i + width].0);
            places[i] = (b * places[i] - a * places[i + 1]) / (b - a);
        }
    }
    places[0]
}

/// The end where a machine turns back next to `near`, one of a slightly different law or cell.
///
/// # Errors
/// It was not found.
fn returned(sector: &mut Sector, control: Control, near: &Node) -> Result<Node, Lost> {
    let softened = |node: &Node| node.slope + control.stiffness();
    let law = *sector.system().law();
    let found = |node: &Node, off| has_turned(control, &law, node.slope, off);
    let (mut node, _, rate) = zero_along(sector, near, softened, found)?;
    node.bend = rate;
    Ok(node)
}

/// The symmetry-breaking end next to `near`, one of a slightly different law or cell.
///
/// # Errors
/// It was not found.
fn recross(sector: &mut Sector, near: &Node) -> Result<Node, Lost> {
    let within = LOCATED * sector.system().law().range;
    let found = |_: &Node, off: f64| off.abs() < within;
    let (node, correction, rate) = zero_along(sector, near, |node| node.breaking, found)?;
    Ok(moved(node, correction, rate))
}

/// The node next to `near` at which a `value` that falls at its rate `near.bend` vanishes; how far
/// off that still is, when it is `near_enough`, and the rate there.
fn zero_along(
    sector: &mut Sector,
    near: &Node,
    value: impl Fn(&Node) -> f64,
    near_enough: impl Fn(&Node, f64) -> bool,
) -> Result<(Node, f64, f64), Lost> {
    let range = sector.system().law().range;
    let (mut u0, mut z) = (near.u0(), near.state.amplitudes.clone());
    let mut met: Vec<(f64, f64)> = Vec::new();
    for _ in 0..CROSSINGS {
        let node = sector.sharp_node(u0, z, None)?;
        let (here, found) = (node.u0(), value(&node));
        let before = met.last().copied();
        met.push((found, here));
        let (correction, rate) = match before {
            Some((before, u)) => (vanishing(&met) - here, (found - before) / (here - u)),
            None => (-found / near.bend, near.bend),
        };
        if node.own <= 0.0 || !(correction.abs() < LONGEST * range) {
            break;
        }
        if near_enough(&node, correction) {
            return Ok((node, correction, rate));
        }
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

/// The branch `old` found again; of its inner nodes the first, and those next to the u0 of
/// `landings`, whose energies count.
pub fn adapt(
    old: &Branch,
    landings: &[f64],
    control: Control,
    from: &Sector,
    to: &mut Sector,
) -> Result<Branch, Lost> {
    let last = old.nodes.len() - 1;
    let mut end = |side: Side| {
        let node = carried_over(old.end(side), from, to);
        match old.ends[side.index()] {
            End::Fold if node.slope.is_finite() => returned(to, control, &node),
            End::Fold => to.refold(&node, side).map(|(end, _)| end),
            End::Breaking => recross(to, &node),
            End::Flat => {
                let near = carried_over(old.beside(side), from, to);
                refade(to, &node, &near, side)
            }
        }
    };
    let (low, high) = (end(Side::Lower)?, end(Side::Upper)?);
    // Symmetry must not break before a fold.
    let holds =
        |node: &Node, side: Side| old.ends[side.index()] == End::Breaking || node.breaking >= 0.0;
    if !holds(&low, Side::Lower) || !holds(&high, Side::Upper) {
        return Err(Lost::Gone);
    }
    let (a, b) = old.extent();
    let [change_low, change_high] =
        [(&low, Side::Lower), (&high, Side::Upper)].map(|(new, side)| {
            let mut change = new.state.amplitudes.clone();
            let before = &old.end(side).state.amplitudes;
            add(
                &mut change,
                -1.0,
                &carried(before, from.system(), to.system()),
            );
            change
        });
    let mut nodes = vec![low];
    let (from_u, width) = (nodes[0].u0(), high.u0() - nodes[0].u0());
    let nearest = |u0: &f64| {
        let off = |i: usize| (old.nodes[i].u0() - u0).abs();
        (1..last).min_by(|&i, &j| off(i).total_cmp(&off(j)))
    };
    let fades = old.ends.map(|end| end == End::Flat);
    let first = (1..last).take(1);
    let beside = (1..last).rev().take(usize::from(fades[1]));
    let chosen: BTreeSet<usize> = first
        .chain(beside)
        .chain(landings.iter().filter_map(nearest))
        .collect();
    let tolerance = if fades.contains(&true) { SHARP } else { NODE };
    for k in chosen {
        let share = (old.nodes[k].u0() - a) / (b - a);
        let mut z = carried(&old.nodes[k].state.amplitudes, from.system(), to.system());
        // What changed at the ends changed a part of that in between.
        add(&mut z, 1.0 - share, &change_low);
        add(&mut z, share, &change_high);
        let (node, _) = to.node(from_u + share * width, z, None, tolerance)?;
        nodes.push(node);
    }
    nodes.push(high);
    let stable = nodes[1..nodes.len() - 1]
        .iter()
        .all(|n| n.own > 0.0 && n.breaking > 0.0 && !control.softens([1.0, n.slope]));
    let ordered = nodes.windows(2).all(|w| w[0].u0() < w[1].u0());
    if !stable || !ordered {
        return Err(Lost::Gone);
    }
    Ok(Branch {
        pattern: old.pattern,
        nodes,
        ends: old.ends,
    })
}

/// A node as a first guess on another mesh. Displacements hardly scale with the range: what
/// elasticity and surface energy balance has a length of its own, sqrt(gamma L/E*).
fn carried_over(node: &Node, from: &Sector, to: &Sector) -> Node {
    let mut guess = node.clone();
    guess.state.amplitudes = carried(&node.state.amplitudes, from.system(), to.system());
    guess.tangent = carried(&node.tangent, from.system(), to.system());
    guess
}
