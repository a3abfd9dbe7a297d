//! One shape and one colour for each method, and for the atlas.

use crate::experiment::chart::{Model, Point};
use crate::solver::method::MethodKind;
use plotters::style::RGBColor;
use std::f64::consts::TAU;

/// The colour of a point's method: M. Okabe and K. Ito's set, which the colour-blind can tell apart.
pub(super) fn colour(point: &Point) -> RGBColor {
    match point.method {
        _ if point.model == Model::Atlas => RGBColor(0x33, 0xa2, 0xe0),
        MethodKind::NewtonKrylov => RGBColor(0x00, 0x72, 0xb2),
        MethodKind::Lbfgs => RGBColor(0x00, 0x9e, 0x73),
        MethodKind::ConjugateGradients => RGBColor(0xb8, 0x7a, 0x00),
        MethodKind::Fire => RGBColor(0xd5, 0x5e, 0x00),
        MethodKind::GfmdTuned => RGBColor(0x9a, 0x4a, 0x80),
        MethodKind::Gfmd => RGBColor(0x44, 0x44, 0x44),
    }
}

/// The outline of its marker, of radius 1, y downwards.
pub(super) fn outline(point: &Point) -> Vec<(f64, f64)> {
    let polygon = |corners: usize, turn: f64, radius: f64| {
        let corner = move |i: usize| TAU * (i as f64 / corners as f64 + turn);
        (0..corners).map(|i| (radius * corner(i).sin(), -radius * corner(i).cos())).collect()
    };
    match point.method {
        _ if point.model == Model::Atlas => {
            let (a, b) = (0.45, 1.35);
            let quarter = [(a, -b), (a, -a), (b, -a)];
            (0..4).flat_map(|turn| quarter.map(|p| (0..turn).fold(p, |(x, y), _| (-y, x)))).collect()
        }
        MethodKind::NewtonKrylov => polygon(24, 0.0, 1.0),
        MethodKind::Lbfgs => polygon(4, 0.125, 1.2),
        MethodKind::ConjugateGradients => polygon(3, 0.0, 1.3),
        MethodKind::Fire => polygon(4, 0.0, 1.3),
        MethodKind::GfmdTuned => polygon(3, 0.5, 1.3),
        MethodKind::Gfmd => {
            let star = |i: usize| {
                let (angle, radius) = (TAU * i as f64 / 10.0, if i.is_multiple_of(2) { 1.45 } else { 0.65 });
                (radius * angle.sin(), -radius * angle.cos())
            };
            (0..10).map(star).collect()
        }
    }
}
