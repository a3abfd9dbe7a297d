//! What is ahead of a surface that has not snapped yet: where the next jump is to be expected, from
//! the smallest eigenvalue along the branch so far; in words, also where nothing can snap.
//!
//! Near a fold the eigenvalue falls like the square root of the distance, so that its square is
//! linear in the control; near a symmetry breaking the eigenvalue itself is linear. Which of them
//! lies ahead is not known, so both are drawn on to zero, with the curvature of the last three
//! states where there are as many, and the bracket spans them all. It is wide far away and closes
//! as the jump comes nearer.

use crate::follow::flat_branch::FlatBranch;
use crate::follow::record::{Direction, LoopRecord, StateRecord};
use crate::physics::body::Body;
use crate::physics::control::Control;
use crate::physics::indenter::Indenter;
use crate::physics::parameter::Dimension;
use crate::physics::pattern::Pattern;
use crate::physics::theory::critical_length;
use crate::scene::{Model, Scene};

/// The bracket reaches this much nearer and farther than the extrapolations do, whose third
/// differences are not known.
const NEARER: f64 = 0.75;
const FARTHER: f64 = 1.25;
/// States closer together than this, in units of the control, say nothing new about the slope; nor
/// is an end located better.
const SPACING: f64 = 2e-4;
/// How far, in units of the control, the located end of a branch may lie behind the zero of the
/// eigenvalue.
const BEHIND: f64 = 5e-4;
/// No extrapolation farther than this, in units of the control.
const FARTHEST: f64 = 0.5;
/// A state off the line through the two before by more than this share of the eigenvalue follows
/// another mode.
const KINK: f64 = 0.5;

/// A bracket of the control at which the present branch is expected to give way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Forecast {
    /// The end that is met first (in the control's unit).
    pub nearest: f64,
    /// The other end; the same where the limit is known exactly.
    pub farthest: f64,
}

/// The next jump in the direction of motion. `None` where the eigenvalue grows, is unknown, or will
/// not vanish nearby.
///
/// The flat state's limit is known exactly ([`FlatBranch`]).
pub fn forecast(record: &LoopRecord, model: &Model) -> Option<Forecast> {
    let now = record.states.last()?;
    let way = if now.direction == Direction::Approach {
        -1.0
    } else {
        1.0
    };
    if now.pattern == Pattern::Flat && model.indenter == Indenter::Flat {
        let flat = FlatBranch::new(model.law, model.equivalent_length, record.control);
        let (lower, upper) = flat.limits()?;
        let limit = if now.direction == Direction::Approach {
            upper
        } else {
            lower
        };
        return (way * (limit - now.control) >= 0.0).then_some(Forecast {
            nearest: limit,
            farthest: limit,
        });
    }
    let unit = record.control.unit(&model.law);
    let samples = samples(record, way, SPACING * unit);
    let (near, far) = distances(&samples)?;
    if near > FARTHEST * unit {
        return None;
    }
    let at = |distance: f64| now.control + way * distance;
    Some(Forecast {
        nearest: at(NEARER * near),
        farthest: at(FARTHER * far + BEHIND * unit),
    })
}

/// Up to three states of the present branch, newest first, as (distance gone in the direction of
/// motion, eigenvalue).
fn samples(record: &LoopRecord, way: f64, spacing: f64) -> Vec<[f64; 2]> {
    let landed = record
        .jumps
        .last()
        .map(|jump| (jump.direction, jump.control));
    let mut found: Vec<[f64; 2]> = Vec::new();
    let mut newest = None;
    for StateRecord {
        direction,
        control,
        stiffness_min,
        ..
    } in record.states.iter().rev()
    {
        let gone = way * control;
        if *newest.get_or_insert(*direction) != *direction || !stiffness_min.is_finite() {
            break;
        }
        if found.last().is_none_or(|newer| newer[0] - gone >= spacing) {
            found.push([gone, *stiffness_min]);
        }
        if found.len() == 3 || landed == Some((*direction, *control)) {
            break;
        }
    }
    found
}

/// The nearest and the farthest extrapolated distance to the eigenvalue's zero.
fn distances(samples: &[[f64; 2]]) -> Option<(f64, f64)> {
    let &[[x, y], [x1, y1], ref rest @ ..] = samples else {
        return None;
    };
    if !(y > 0.0 && y < y1) {
        return None;
    }
    // Of the eigenvalue and of its square, the zero of the line through the last two states.
    let mut zeros = vec![
        y * (x - x1) / (y1 - y),
        y * y * (x - x1) / (y1 * y1 - y * y),
    ];
    if let [[x0, y0], ..] = *rest {
        let line = y1 + (y1 - y0) / (x1 - x0) * (x - x1);
        if (y - line).abs() > KINK * y1 {
            return None;
        }
        let farthest = 3.0 * zeros[0];
        let at = [x0 - x, x1 - x];
        let curved = [
            parabola_zero(at, [y0, y1, y]),
            parabola_zero(at, [y0 * y0, y1 * y1, y * y]),
        ];
        zeros.extend(curved.into_iter().flatten().filter(|zero| *zero < farthest));
    }
    Some(
        zeros
            .into_iter()
            .fold((f64::INFINITY, 0.0), |(near, far), zero| {
                (near.min(zero), far.max(zero))
            }),
    )
}

/// The first zero beyond 0 of the parabola through (x0, y0), (x1, y1) and (0, y2), or its lowest
/// point if it turns just above zero.
fn parabola_zero([x0, x1]: [f64; 2], [y0, y1, y2]: [f64; 3]) -> Option<f64> {
    let (early, late) = ((y1 - y0) / (x1 - x0), (y2 - y1) / -x1);
    let a = (late - early) / -x0;
    let b = late - a * x1;
    let discriminant = b * b - 4.0 * a * y2;
    if discriminant < 0.0 {
        return (a > 0.0 && b < 0.0).then(|| -b / (2.0 * a));
    }
    let q = -0.5 * (b + discriminant.sqrt().copysign(b));
    [q / a, y2 / q]
        .into_iter()
        .filter(|zero| *zero > 0.0)
        .min_by(f64::total_cmp)
}

/// What is driven at this value: "u₀ = 3.102 ρ".
pub(super) fn told(control: Control, value: f64, model: &Model, digits: usize) -> String {
    let (natural, word, of) = match control {
        Control::Load => (model.law.traction_max(), "σₘₐₓ", Dimension::Stress),
        _ => (model.law.range, "ρ", Dimension::Length),
    };
    let value = model.unit(of).say(value / natural, digits, word);
    format!("{} = {}", control.symbol(), value.replace('-', "−"))
}

/// Why nothing can snap in a scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Calm {
    /// What to change.
    pub remedy: &'static str,
    /// The reason with its numbers.
    pub reason: String,
}

/// Why nothing can snap in this scene; `None` where something can, or nobody knows.
pub fn calm(scene: &Scene, model: &Model) -> Option<Calm> {
    let branch = FlatBranch::new(model.law, model.equivalent_length, scene.control());
    if model.indenter != Indenter::Flat || branch.limits().is_some() {
        return None;
    }
    let rho = model.law.range;
    let across = model.unit_across();
    let (remedy, what) = if model.body == Body::HalfSpace {
        ("Make the cell longer.", "The cell has")
    } else {
        (
            "Make the layer thicker.",
            "The softest wave of the layer is that of a cell of",
        )
    };
    Some(Calm {
        remedy,
        reason: format!(
            "{what} {}, and below L_c = {} every wave is stiffer than the law is soft.",
            across.say(model.equivalent_length / rho, 1, "ranges"),
            across.say(critical_length(&model.law) / rho, 1, "ranges")
        ),
    })
}

/// What can happen next, in words; nothing of a record without a state.
pub fn ahead(scene: &Scene, model: &Model, record: &LoopRecord) -> String {
    if let Some(calm) = calm(scene, model) {
        return format!("Here nothing snaps. {} {}", calm.remedy, calm.reason);
    }
    let control = scene.control();
    let Some(now) = record.states.last() else {
        return String::new();
    };
    let way = match now.direction {
        Direction::Approach => "down",
        Direction::Retraction => "up",
    };
    let Some(ahead) = forecast(record, model) else {
        return match model.indenter {
            Indenter::Flat => format!("No jump is near on the way {way}."),
            _ => "Where it snaps shows when it comes near: there its stiffness falls to zero."
                .to_owned(),
        };
    };
    let (low, high) = scene.window_of_control(model);
    let (near, far) = (
        ahead.nearest.min(ahead.farthest),
        ahead.nearest.max(ahead.farthest),
    );
    if high < near || far < low {
        return format!(
            "It would snap at {}, beyond the end of the drive.",
            told(control, ahead.nearest, model, 3)
        );
    }
    if near == far {
        return format!(
            "It snaps at {} on the way {way}: there the flat surface gives way.",
            told(control, near, model, 4)
        );
    }
    format!(
        "The next jump on the way {way} is between {} and {}.",
        told(control, near, model, 3),
        told(control, far, model, 3)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Distances for the eigenvalue `f` at the distances `at` before the jump.
    fn of(at: &[f64], f: impl Fn(f64) -> f64) -> Option<(f64, f64)> {
        let samples: Vec<[f64; 2]> = at.iter().map(|d| [-d, f(*d)]).collect();
        distances(&samples)
    }

    #[test]
    fn the_zeros_of_a_pure_fold_and_of_a_pure_symmetry_breaking_are_among_the_extrapolations() {
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{a} {b}");
        let (nearest, farthest) = of(&[0.10, 0.12, 0.14], |d| 3.0 * d.sqrt()).unwrap();
        near(nearest, 0.10);
        assert!(farthest > 0.11 && farthest < 0.23, "{farthest}");
        let (nearest, farthest) = of(&[0.10, 0.12, 0.14], |d| 3.0 * d).unwrap();
        assert!(nearest > 0.04 && nearest < 0.06, "{nearest}");
        near(farthest, 0.10);
    }

    #[test]
    fn a_parabola_meets_zero_where_it_does() {
        let f = |x: f64| (x - 2.0) * (x - 5.0);
        let zero = parabola_zero([-2.0, -1.0], [f(-2.0), f(-1.0), f(0.0)]).unwrap();
        assert!((zero - 2.0).abs() < 1e-12, "{zero}");
        let above = |x: f64| (x - 2.0).powi(2) + 0.1;
        let lowest = parabola_zero([-2.0, -1.0], [above(-2.0), above(-1.0), above(0.0)]).unwrap();
        assert!((lowest - 2.0).abs() < 1e-12, "{lowest}");
    }

    #[test]
    fn nothing_is_foreseen_while_the_eigenvalue_grows_is_unknown_or_changes_its_mode() {
        assert_eq!(of(&[0.10, 0.12, 0.14], |d| 1.0 - d), None);
        assert_eq!(of(&[0.10], |d| d), None);
        assert_eq!(of(&[0.10, 0.12], |_| f64::NAN), None);
        assert_eq!(
            of(&[0.10, 0.12, 0.14], |d| if d < 0.11 {
                0.2
            } else {
                2.0 - d
            }),
            None
        );
    }
}
