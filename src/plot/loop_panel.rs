//! A loop as a diagram: mean stress against mean displacement, x = u0/rho and y = stress/sigma_max,
//! tension positive.

use super::curve::{Curve, Piece, PieceKind};
use super::panel::{Along, Area, Arrow, Axis, Colour, Label, Page, Panel, Role, Series, Symbol};
use super::scale;
use crate::follow::flat_branch::FlatBranch;
use crate::follow::record::{Direction, JumpRecord, LoopRecord};
use crate::physics::control::Control;
use crate::physics::indenter::Indenter;
use crate::physics::law::Law;
use crate::physics::parameter::Dimension;
use crate::physics::pattern::Pattern;
use crate::scene::Model;
use crate::scene::parameter::Unit;
use crate::study::plan::promise;

/// Points of the flat state's curve and of the edges of the loss: finer than a diagram of 900
/// points across can show.
const POINTS: usize = 600;
/// Curves closer than this share of the largest traction enclose no area worth drawing.
const CLOSE: f64 = 2e-3;
/// Pieces of curve shorter than this share of the axis bear no name, which would not fit.
const NAMED: f64 = 0.07;
/// What is left free at the ends of both axes, in shares of what is shown.
pub(super) const MARGIN: [f64; 2] = [0.02, 0.06];

/// The diagram of what was recorded: the loss of a closed loop, both branches, jumps, names of
/// patterns, and on flat ground the flat state.
pub fn loop_panel(record: &LoopRecord, model: &Model) -> Panel {
    let curve = Curve::of(record, &model.law);
    let ends = |k: usize, more: &[f64], default: [f64; 2]| {
        let values = curve.points().map(|p| p[k]).chain(more.iter().copied());
        let (low, high) = scale::ends(values);
        let [low, high] = if low <= high { [low, high] } else { default };
        let room = MARGIN[k] * if high > low { high - low } else { 1.0 };
        [low - room, high + room]
    };
    let x = ends(0, &[], [0.0, 5.0]);
    let flat = flat_state(model, record.control, x.map(|u| u * model.law.range));
    let peak = if flat.is_empty() { 0.0 } else { 1.0 };
    let y = ends(1, &[0.0, peak], [-0.2, 1.0]);
    let closed = record.ledger(model.law.surface_energy).open.is_none();
    let [x_axis, y_axis] = axes(model, [x, y]);
    Panel {
        x: x_axis,
        y: y_axis,
        areas: if closed { loss(&curve) } else { Vec::new() },
        series: flat.into_iter().chain(branches(&curve)).collect(),
        arrows: jumps(&record.jumps, &model.law),
        labels: names(&curve, x[1] - x[0]),
        ..Panel::default()
    }
}

/// Where a mean displacement (length) and a stress (E*) stand: in ranges, and in units of the
/// largest traction.
pub fn place(u0: f64, stress: f64, law: &Law) -> [f64; 2] {
    [u0 / law.range, stress / law.traction_max()]
}

/// The axes of stress against mean displacement, showing this much of each.
pub(super) fn axes(model: &Model, [x, y]: [[f64; 2]; 2]) -> [Axis; 2] {
    let [length, stress] = [Dimension::Length, Dimension::Stress].map(|of| model.unit(of));
    let (u0, sigma) = ("mean displacement u_0", "mean tensile stress sigma");
    let natural = "mean stress sigma/sigma_max (tension positive)";
    [
        Axis::of(&length, &format!("{u0}/rho"), u0).from_to(x[0], x[1]),
        Axis::of(&stress, natural, sigma).from_to(y[0], y[1]),
    ]
}

/// The picture of what was recorded under the scene's title; `error` is the relative error to be
/// stated of its loss.
pub fn page(record: &LoopRecord, model: &Model, title: &str, error: Option<f64>) -> Page<'static> {
    Page::new(
        title,
        vec![caption(record, model, error)],
        vec![loop_panel(record, model)],
    )
}

/// Approach and retraction by growing u0, each broken at its jumps: a line of what is stable, a
/// dashed one of what is not, and hollow circles of states that are no equilibria.
pub fn branches(curve: &Curve) -> Vec<Series> {
    let mut all = Vec::new();
    for direction in Direction::BOTH {
        let of = |kind| {
            gone(curve, |piece| {
                (piece.direction, piece.kind) == (direction, kind)
            })
        };
        let (name, colour) = (direction.to_string(), Colour::of(direction));
        all.extend([
            Series::gone(direction, of(PieceKind::Stable)),
            Series::line(
                &format!("{name}, unstable"),
                Role::Unstable,
                colour,
                of(PieceKind::Unstable),
            ),
            Series::symbols(
                &format!("{name}, not converged"),
                Symbol::Circle,
                colour,
                finite(of(PieceKind::NotConverged)),
            ),
        ]);
    }
    all.retain(|series| !series.points.is_empty());
    all
}

fn finite(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.retain(|p| p[0].is_finite());
    points
}

/// The points of some pieces by growing u0, with a hole between two of them.
fn gone(curve: &Curve, these: impl Fn(&Piece) -> bool) -> Vec<[f64; 2]> {
    let mut points: Vec<[f64; 2]> = Vec::new();
    let mut direction = Direction::Retraction;
    for piece in curve.pieces.iter().filter(|piece| these(piece)) {
        if !points.is_empty() {
            points.push([f64::NAN; 2]);
        }
        points.extend(&piece.points);
        direction = piece.direction;
    }
    if direction == Direction::Approach {
        points.reverse();
    }
    points
}

/// The flat state's closed form from u0 = `from` to `to` (length), dashed where it is unstable
/// under its control; none on uneven ground.
pub fn flat_state(model: &Model, control: Control, [from, to]: [f64; 2]) -> Vec<Series> {
    let mut pieces: Vec<Series> = Vec::new();
    if model.indenter != Indenter::Flat {
        return pieces;
    }
    let flat = FlatBranch::new(model.law, model.equivalent_length, control);
    for u0 in scale::steps(from, to, POINTS) {
        let point = place(u0, model.law.at(u0).traction, &model.law);
        let stable = flat.is_stable(u0);
        let (name, role) = if stable {
            ("flat state", Role::Guide)
        } else {
            ("flat state, unstable", Role::Unstable)
        };
        match pieces.last_mut() {
            Some(piece) if piece.role == role => piece.points.push(point),
            last => {
                last.into_iter().for_each(|piece| piece.points.push(point));
                pieces.push(Series::line(name, role, Colour::FLAT, vec![point]));
            }
        }
    }
    pieces
}

/// The areas between both ways: what is lost. Under a spring a jump goes along the spring's line.
pub fn loss(curve: &Curve) -> Vec<Area> {
    let [approach, retraction] =
        Direction::BOTH.map(|direction| finite(gone(curve, |piece| piece.direction == direction)));
    let (low, high) = scale::ends(approach.iter().map(|p| p[0]).filter(|u| u.is_finite()));
    let mut areas: Vec<Area> = Vec::new();
    let mut open = false;
    for u in scale::steps(low, high, POINTS) {
        // Next to a jump a curve may have a hole a hair wide: the area goes on.
        let (Some(a), Some(b)) = (value(&approach, u), value(&retraction, u)) else {
            continue;
        };
        let apart = (a - b).abs() > CLOSE;
        if apart && !open {
            let name = if areas.is_empty() { "lost energy" } else { "" };
            areas.push(Area {
                name: name.to_owned(),
                colour: Colour::LOSS,
                spans: Vec::new(),
                along: Along::X,
            });
        }
        open = apart;
        if apart && let Some(area) = areas.last_mut() {
            area.spans.push([u, a.min(b), a.max(b)]);
        }
    }
    areas
}

/// The value of a broken curve at `x`; `None` outside and where it has a hole.
fn value(curve: &[[f64; 2]], x: f64) -> Option<f64> {
    let known = |pair: &[[f64; 2]]| pair[0][0] <= x && x <= pair[1][0] && pair[1][0] > pair[0][0];
    curve.windows(2).find(|pair| known(pair)).map(|pair| {
        let t = (x - pair[0][0]) / (pair[1][0] - pair[0][0]);
        pair[0][1] + t * (pair[1][1] - pair[0][1])
    })
}

/// Jumps as arrows from the state before to the state after: along the line of the machine.
pub fn jumps(jumps: &[JumpRecord], law: &Law) -> Vec<Arrow> {
    let arrow = |jump: &JumpRecord| Arrow {
        name: "jump",
        tail: place(jump.mean_displacement, jump.stress_before, law),
        head: place(jump.mean_displacement_after, jump.stress_after, law),
        colour: Colour::JUMP,
        direction: jump.direction,
    };
    jumps.iter().map(arrow).collect()
}

/// The pattern of every piece that is long enough for its name on an axis of this width: below the
/// approach, above the retraction, and towards the side from which a falling curve bends away. Of
/// the same pattern nearby only the newest.
pub fn names(curve: &Curve, width: f64) -> Vec<Label> {
    let mut named: Vec<Label> = Vec::new();
    for piece in curve
        .pieces
        .iter()
        .rev()
        .filter(|piece| piece.pattern != Pattern::Flat)
    {
        let [Some(first), Some(last)] = [piece.points.first(), piece.points.last()] else {
            continue;
        };
        let middle = 0.5 * (first[0] + last[0]);
        let nearest = piece
            .points
            .iter()
            .min_by(|a, b| (a[0] - middle).abs().total_cmp(&(b[0] - middle).abs()));
        let (text, colour, at) = (
            piece.pattern.word().to_owned(),
            Colour::of(piece.direction),
            *nearest.unwrap_or(first),
        );
        let near = |known: &Label| {
            known.text == text
                && known.colour == colour
                && (known.at[0] - at[0]).abs() < 0.2 * width
        };
        if (first[0] - last[0]).abs() >= NAMED * width && !named.iter().any(near) {
            let side = if piece.direction == Direction::Approach {
                [-1, -1]
            } else {
                [1, 1]
            };
            named.push(Label {
                at,
                text,
                colour,
                side,
            });
        }
    }
    named
}

/// The numbers of a loop in one line; `error` is the relative error to be stated of its loss.
fn caption(record: &LoopRecord, model: &Model, error: Option<f64>) -> String {
    let ledger = record.ledger(model.law.surface_energy);
    let unit = model.unit(Dimension::SurfaceEnergy);
    let energy = |value: f64| energy(value, &unit);
    let loss = match (ledger.dissipated_energy(), &ledger.open) {
        _ if record.states.is_empty() => "No states were computed".to_owned(),
        (Some(loss), _) => format!(
            "Dissipated energy {} per area and loop ({})",
            energy(loss),
            promise(error)
        ),
        (None, Some(open)) => format!("Loop not closed: {}", open.reason),
        (None, None) => "Dissipated energy (not available)".to_owned(),
    };
    if record.jumps.is_empty() {
        return format!("{loss};  no jumps.");
    }
    format!(
        "{loss};  {}, releasing {}.",
        record.tally(),
        energy(record.released_energy_sum())
    )
}

/// An energy (gamma) with four digits, and zero where rounding leaves nothing.
fn energy(value: f64, unit: &Unit) -> String {
    let number = if value.is_finite() {
        unit.number(value, 4).replace('-', "\u{2212}")
    } else {
        "(not available)".to_owned()
    };
    format!("{number} {}", unit.name("γ"))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::follow::record::{Cause, StateRecord};
    use crate::physics::law::{Morse, Shape};
    use crate::plot::panel::Fill;
    use crate::scene::Part;
    use crate::scene::tests::fig2;
    use crate::solver::Stop;

    pub(crate) fn law() -> Law {
        Law {
            shape: Shape::Morse(Morse),
            surface_energy: 0.15,
            range: 1.0,
        }
    }

    fn state(direction: Direction, pattern: Pattern, u0: f64) -> StateRecord {
        let law = law();
        let over_max = match pattern {
            Pattern::Flat => law.at(u0).traction / law.traction_max(),
            Pattern::Bulge => 0.12 + 0.05 * u0,
            Pattern::Ridge => 0.2 + 0.06 * u0,
            _ => 0.55 * u0.powf(0.6),
        };
        StateRecord {
            direction,
            control: u0,
            mean_displacement: u0,
            stress: over_max * law.traction_max(),
            stress_over_max: over_max,
            contact_area: 0.0,
            pattern,
            residual: 0.0,
            stiffness_min: 1.0,
            stiffness_error: 0.0,
            energy: 0.0,
            part: Part::Whole,
            stop: Stop::Stable,
            iterations: 1,
            transforms: 2,
            milliseconds: 0.0,
        }
    }

    #[test]
    fn under_a_load_the_flat_state_is_drawn_stable_in_contact_alone() {
        let model = fig2(64).model().unwrap();
        let law = model.law;
        let ends = |control: Control| -> Vec<f64> {
            let pieces = flat_state(&model, control, [0.0, 6.0 * law.range]);
            let stable = pieces.iter().filter(|piece| piece.role != Role::Unstable);
            stable
                .map(|piece| piece.points[piece.points.len() - 1][0])
                .collect()
        };
        assert_eq!(ends(Control::Displacement).len(), 2);
        let [end] = ends(Control::Load)[..] else {
            panic!("one stable piece")
        };
        assert!((end - law.contact_gap() / law.range).abs() < 0.02, "{end}");
    }

    /// A loop like that of Fig. 2, with invented stresses.
    pub(crate) fn invented_loop() -> LoopRecord {
        use Pattern::{Bulge, Dimple, Flat, Ridge};
        let approach = [
            (Flat, 4.2, 3.1),
            (Bulge, 3.1, 2.6),
            (Ridge, 2.6, 1.7),
            (Dimple, 1.7, 0.8),
            (Flat, 0.8, 0.2),
        ];
        let retraction = [
            (Flat, 0.2, 0.8),
            (Dimple, 0.8, 2.3),
            (Ridge, 2.3, 3.5),
            (Bulge, 3.5, 3.8),
            (Flat, 3.8, 4.2),
        ];
        let mut record = LoopRecord::default();
        for (direction, legs) in [
            (Direction::Approach, approach),
            (Direction::Retraction, retraction),
        ] {
            for (k, (pattern, from, to)) in legs.into_iter().enumerate() {
                if let Some(before) = record.states.last().filter(|_| k > 0).cloned() {
                    let after = state(direction, pattern, from);
                    record.jumps.push(JumpRecord {
                        direction,
                        control: from,
                        mean_displacement: from,
                        mean_displacement_after: from,
                        from: before.pattern,
                        to: pattern,
                        stress_before: before.stress,
                        stress_after: after.stress,
                        released_energy: 0.1,
                        release_error: 1e-5,
                        cause: Cause::Fold,
                        landings: Vec::new(),
                    });
                }
                let first = usize::from(direction == Direction::Retraction && k == 0);
                record.states.extend(
                    (first..=20)
                        .map(|i| state(direction, pattern, from + (to - from) * i as f64 / 20.0)),
                );
            }
        }
        record
    }

    #[test]
    fn only_stable_equilibria_are_a_solid_line() {
        let mut record = invented_loop();
        for (i, state) in record.states.iter_mut().enumerate() {
            state.stop = [Stop::Stable, Stop::NotConverged, Stop::Unstable][i / 20 % 3];
        }
        let count = |stop| record.states.iter().filter(|s| s.stop == stop).count();
        let series = branches(&Curve::of(&record, &law()));
        let points = |these: fn(&&Series) -> bool| -> usize {
            let points = series
                .iter()
                .filter(these)
                .flat_map(|series| &series.points);
            points.filter(|p| p[0].is_finite()).count()
        };
        let hollow = points(|s| s.symbol == Some(Symbol::Circle) && s.fill == Fill::Hollow);
        let solid = points(|s| s.symbol.is_none() && s.role == Role::Simulation);
        let dashed = points(|s| s.symbol.is_none() && s.role == Role::Unstable);
        assert_eq!(
            [solid, hollow, dashed],
            [Stop::Stable, Stop::NotConverged, Stop::Unstable].map(count)
        );
    }

    #[test]
    fn a_loop_is_cut_at_its_jumps_and_its_area_is_the_work() {
        let record = invented_loop();
        let curve = Curve::of(&record, &law());
        let series = branches(&curve);
        let pieces = |series: &Series| series.points.split(|p| p[0].is_nan()).count();
        assert_eq!(series.iter().map(pieces).collect::<Vec<_>>(), [5, 5]);
        let words: Vec<String> = names(&curve, 4.0)
            .into_iter()
            .map(|label| label.text)
            .collect();
        assert_eq!(
            words,
            ["bulge", "ridge", "dimple", "dimple", "ridge", "bulge"]
        );
        let trapezoid = |pair: &[[f64; 3]]| {
            0.5 * (pair[0][2] - pair[0][1] + pair[1][2] - pair[1][1]) * (pair[1][0] - pair[0][0])
        };
        let drawn: f64 = loss(&curve)
            .iter()
            .flat_map(|area| area.spans.windows(2))
            .map(trapezoid)
            .sum();
        // Drawn with straight lines from state to state.
        let pieces = record.states.windows(2).map(|s| {
            0.5 * (s[0].stress_over_max + s[1].stress_over_max)
                * (s[1].mean_displacement - s[0].mean_displacement)
        });
        let work: f64 = pieces.sum();
        // An edge at a jump stands within a point of its raster, and what is nearly closed is left
        // out.
        let heights: f64 = record
            .jumps
            .iter()
            .map(|j| (j.stress_after - j.stress_before).abs() / law().traction_max())
            .sum();
        let bound = 4.0 * (heights / POINTS as f64 + CLOSE);
        assert!(
            (drawn - work).abs() < bound && bound < 0.05 * work,
            "drawn {drawn}, work {work}, bound {bound}"
        );
    }
}
