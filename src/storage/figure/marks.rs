//! Colours, strokes and symbols: what tells the roles apart, also without colour.

use super::sheet::{Place, Sheet, Stroke};
use crate::paper::figure::{Colour, Role, Symbol};
use plotters::style::RGBColor;
use std::f64::consts::TAU;

pub(super) const INK: RGBColor = RGBColor(0x22, 0x22, 0x22);
pub(super) const GRID: RGBColor = RGBColor(0xe8, 0xe8, 0xe8);
pub(super) const ZERO: RGBColor = RGBColor(0xb4, 0xb4, 0xb4);
pub(super) const PAPER: RGBColor = RGBColor(0xff, 0xff, 0xff);

/// The shade on white.
pub(super) fn shade(colour: Colour) -> RGBColor {
    match colour {
        Colour::Ink => INK,
        Colour::Blue => RGBColor(0x1f, 0x5f, 0xb4),
        Colour::Red => RGBColor(0xc8, 0x2a, 0x2a),
        Colour::Green => RGBColor(0x14, 0x84, 0x4c),
        Colour::Orange => RGBColor(0xd0, 0x6a, 0x00),
        Colour::Purple => RGBColor(0x84, 0x46, 0x9c),
        Colour::Teal => RGBColor(0x00, 0x86, 0x90),
        Colour::Grey => RGBColor(0x8c, 0x8c, 0x8c),
        Colour::Gold => RGBColor(0xe8, 0xc8, 0x60),
    }
}

/// Simulated lines are broad, theory is thin and solid, print is dashed, guides are hair lines; `size` is 1 in a diagram of full size.
pub(super) fn stroke(role: Role, colour: Colour, size: f64) -> Stroke {
    let colour = shade(colour);
    match role {
        Role::Simulation => Stroke::solid(lighter(colour), 3.4 * size),
        Role::Theory => Stroke::solid(colour, 1.5 * size),
        Role::Printed => Stroke { colour, width: 1.7 * size, dash: Some([7.0 * size, 4.0 * size]) },
        Role::Guide => Stroke::solid(shade(Colour::Grey), 0.8 * size),
    }
}

/// So that a thin line of the same colour is seen upon it.
fn lighter(colour: RGBColor) -> RGBColor {
    let mix = |c: u8| (f64::from(c) + 0.35 * (255.0 - f64::from(c))).round() as u8;
    RGBColor(mix(colour.0), mix(colour.1), mix(colour.2))
}

/// Draws a symbol of about `radius`.
pub(super) fn symbol(sheet: &mut Sheet, symbol: Symbol, at: Place, colour: Colour, radius: f64) {
    let colour = shade(colour);
    let stroke = Stroke::solid(colour, 0.3 * radius);
    let corners = |count: usize, turn: f64, radius: f64| -> Vec<Place> {
        let corner = |i: usize| {
            let angle = TAU * (i as f64 / count as f64 + turn);
            [at[0] + radius * angle.sin(), at[1] - radius * angle.cos()]
        };
        (0..=count).map(corner).collect()
    };
    match symbol {
        Symbol::Circle => sheet.line(corners(24, 0.0, radius), stroke),
        Symbol::Square => sheet.line(corners(4, 0.125, 1.25 * radius), stroke),
        Symbol::Diamond => sheet.line(corners(4, 0.0, 1.3 * radius), stroke),
        Symbol::Triangle => sheet.line(corners(3, 0.0, 1.3 * radius), stroke),
        Symbol::Dot => sheet.fill(corners(16, 0.0, 0.55 * radius), colour, 1.0),
        Symbol::Cross => {
            for side in [-1.0, 1.0] {
                let (dx, dy) = (0.85 * radius, 0.85 * radius * side);
                sheet.line([[at[0] - dx, at[1] - dy], [at[0] + dx, at[1] + dy]], stroke);
            }
        }
    }
}

/// Draws the head of an arrow that arrives at `tip` from `from`.
pub(super) fn head(sheet: &mut Sheet, from: Place, tip: Place, colour: RGBColor, size: f64) {
    let (dx, dy) = (tip[0] - from[0], tip[1] - from[1]);
    let length = dx.hypot(dy);
    if length < 1e-6 {
        return;
    }
    let long = (9.0 * size).min(length.max(4.0 * size));
    let (ux, uy) = (long * dx / length, long * dy / length);
    let (wx, wy) = (-0.4 * uy, 0.4 * ux);
    sheet.fill([tip, [tip[0] - ux + wx, tip[1] - uy + wy], [tip[0] - ux - wx, tip[1] - uy - wy]], colour, 1.0);
}
