//! One code of colour, stroke and symbol for each meaning: the same in the window, in files, and in
//! the report.
//!
//! Colour never speaks alone: approach and retraction differ in the marks along their lines, stable
//! and unstable in dashes, methods in symbols. Contrasts are those of WCAG 2: at least 3 for every
//! mark on its ground, 1.5 for the shaded loss, which has an outline too. The colours of a map of the
//! gap are dark where the surfaces touch.

use super::panel::{Colour, Dash, Role, Symbol};
use crate::follow::record::Direction;
use std::f64::consts::TAU;

/// Red, green and blue.
pub type Rgb = [u8; 3];

/// What a diagram stands on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ground {
    /// Paper, and the light window.
    Light,
    /// The dark window.
    Dark,
}

impl Ground {
    /// Its own colour.
    pub fn colour(self) -> Rgb {
        match self {
            Ground::Light => [255, 255, 255],
            Ground::Dark => [18, 20, 25],
        }
    }

    /// How much of its colour a filled area shows: less on dark ground, where light colours stand
    /// out more.
    pub fn opacity(self) -> f64 {
        match self {
            Ground::Light => 0.4,
            Ground::Dark => 0.25,
        }
    }
}

impl Colour {
    /// Jumps.
    pub const JUMP: Self = Self::Magenta;
    /// The energy that is lost.
    pub const LOSS: Self = Self::Gold;
    /// The flat state.
    pub const FLAT: Self = Self::Grey;
    /// Tensile traction: the surfaces pull at each other.
    pub const PULL: Self = Self::Orange;
    /// Compressive traction: they push each other away.
    pub const PUSH: Self = Self::Purple;
    /// What the machine allows.
    pub const MACHINE: Self = Self::Ink;
    /// The live loop.
    pub const LIVE: Self = Self::Teal;

    /// The colour of what is recorded in a direction of the drive.
    pub fn of(direction: Direction) -> Self {
        match direction {
            Direction::Approach => Self::Blue,
            Direction::Retraction => Self::Orange,
        }
    }

    /// Its shade on a ground.
    pub fn on(self, ground: Ground) -> Rgb {
        let [light, dark]: [u32; 2] = match self {
            Colour::Ink => [0x22_2222, 0xe6_e6e6],
            Colour::Blue => [0x1f_5fb4, 0x6a_b0ff],
            Colour::Red => [0xc8_2a2a, 0xff_8278],
            Colour::Green => [0x10_7a44, 0x52_d094],
            Colour::Orange => [0xac_4e00, 0xff_a64d],
            Colour::Purple => [0x84_469c, 0xd0_98ea],
            Colour::Teal => [0x00_767f, 0x4c_d0d8],
            Colour::Magenta => [0xb0_1c68, 0xf4_78b0],
            Colour::Gold => [0x96_6e00, 0xe8_c860],
            Colour::Grey => [0x6c_7076, 0x96_9ca6],
        };
        let [_, rgb @ ..] = match ground {
            Ground::Light => light,
            Ground::Dark => dark,
        }
        .to_be_bytes();
        rgb
    }
}

/// How a line is drawn, in units of a diagram of full size (screen points in the window).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    /// Colour.
    pub colour: Rgb,
    /// Width.
    pub width: f64,
    /// Lengths of dash and space; `None` is solid.
    pub dash: Option<[f64; 2]>,
}

/// The line of a series.
pub fn stroke(role: Role, colour: Colour, ground: Ground) -> Stroke {
    let (plain, ink) = (colour.on(ground), Colour::Ink.on(ground));
    let (colour, width, dash) = match role {
        Role::Simulation => (plain, 2.8, None),
        Role::Unstable => (plain, 1.4, Some([5.0, 4.0])),
        // Towards the ink, so that a thin line is seen upon a broad one of its colour.
        Role::Theory => (mixed(plain, ink, 0.35), 1.4, None),
        Role::Printed => (mixed(plain, ink, 0.35), 1.7, Some([8.0, 4.0])),
        Role::Forecast => (plain, 1.2, None),
        Role::Guide => (Colour::Grey.on(ground), 0.9, None),
        Role::Kept(dash) => (
            plain,
            2.0,
            match dash {
                Dash::Solid => None,
                Dash::Long => Some([11.0, 5.0]),
                Dash::Dotted => Some([2.0, 4.0]),
            },
        ),
    };
    Stroke {
        colour,
        width,
        dash,
    }
}

/// `share` of `b` in `a`.
fn mixed(a: Rgb, b: Rgb, share: f64) -> Rgb {
    std::array::from_fn(|k| {
        (f64::from(a[k]) + share * (f64::from(b[k]) - f64::from(a[k]))).round() as u8
    })
}

/// The symbol along a line that was gone in a direction.
pub fn pointing(direction: Direction) -> Symbol {
    match direction {
        Direction::Approach => Symbol::Left,
        Direction::Retraction => Symbol::Right,
    }
}

/// Contrast ratio of two colours (WCAG 2.2, 1 to 21).
#[cfg(test)]
pub(crate) fn contrast(a: Rgb, b: Rgb) -> f64 {
    let linear = |c: u8| {
        let c = f64::from(c) / 255.0;
        if c <= 0.04045 {
            c / 12.92
        } else {
            ((c + 0.055) / 1.055).powf(2.4)
        }
    };
    let luminance = |c: Rgb| 0.2126 * linear(c[0]) + 0.7152 * linear(c[1]) + 0.0722 * linear(c[2]);
    let (a, b) = (luminance(a) + 0.05, luminance(b) + 0.05);
    a.max(b) / a.min(b)
}

/// Where such symbols stand on a line: the first point of every slot of a raster of `every` along
/// x, which does not wander while the line grows. None at its two ends.
pub fn marked(points: &[[f64; 2]], every: f64) -> impl Iterator<Item = [f64; 2]> + '_ {
    let slot = move |p: &[f64; 2]| (p[0] / every).floor();
    points
        .windows(2)
        .map(move |pair| (slot(&pair[0]) != slot(&pair[1]), pair[1]))
        .filter(|(new, _)| *new)
        .map(|(_, p)| p)
}

/// Slots of that raster across a diagram.
pub const MARKS: f64 = 18.0;

impl Symbol {
    /// Its strokes, each a line of corners around the origin, y upwards, for a symbol of radius 1.
    /// One stroke is an outline, closed, that may be filled.
    pub fn strokes(self) -> Vec<Vec<[f64; 2]>> {
        let polygon = |corners: usize, turn: f64, radius: f64| {
            let corner = |i: usize| {
                let angle = TAU * (i as f64 / corners as f64 + turn);
                [radius * angle.sin(), radius * angle.cos()]
            };
            vec![(0..=corners).map(corner).collect::<Vec<_>>()]
        };
        let two = |a: [f64; 2], b: [f64; 2]| vec![vec![[-a[0], -a[1]], a], vec![[-b[0], -b[1]], b]];
        match self {
            Symbol::Circle => polygon(24, 0.0, 1.0),
            Symbol::Square => polygon(4, 0.125, 1.25),
            Symbol::Diamond => polygon(4, 0.0, 1.3),
            Symbol::Triangle => polygon(3, 0.0, 1.3),
            Symbol::Down => polygon(3, 0.5, 1.3),
            Symbol::Left => polygon(3, 0.75, 1.3),
            Symbol::Right => polygon(3, 0.25, 1.3),
            Symbol::Dot => polygon(16, 0.0, 0.55),
            Symbol::Ring => polygon(32, 0.0, 2.0),
            Symbol::Frame => polygon(4, 0.125, 2.6),
            Symbol::Cross => two([0.85, 0.85], [0.85, -0.85]),
            Symbol::Plus => two([1.2, 0.0], [0.0, 1.2]),
        }
    }
}

/// A scale of colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Colours {
    /// Viridis: equal steps of the gap look equally large.
    #[default]
    Uniform,
    /// As in print: red, orange, yellow, blue, black. Its steps do not look equally large, and edges
    /// appear where there are none.
    Paper,
}

/// Black in contact to red far away, at equal shares.
const PAPER: [Rgb; 5] = [
    [0, 0, 0],
    [35, 70, 190],
    [250, 225, 70],
    [245, 140, 30],
    [190, 25, 25],
];

impl Colours {
    /// All of them with their words.
    pub const ALL: [(Self, &str); 2] = [
        (Self::Uniform, "viridis"),
        (Self::Paper, "as in the paper (not uniform)"),
    ];

    /// The colour of a share, 0 in contact to 1; beyond it is that of the end.
    pub fn at(self, share: f64) -> Rgb {
        let share = share.clamp(0.0, 1.0);
        match self {
            Self::Uniform => colorous::VIRIDIS.eval_continuous(share).as_array(),
            Self::Paper => {
                let last = PAPER.len() - 1;
                let place = share * last as f64;
                let from = (place as usize).min(last - 1);
                let part = place - from as f64;
                let [a, b] = [PAPER[from], PAPER[from + 1]];
                [0, 1, 2].map(|k| {
                    let (a, b) = (f64::from(a[k]), f64::from(b[k]));
                    (a + part * (b - a)).round() as u8
                })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COLOURS: [Colour; 10] = [
        Colour::Ink,
        Colour::Blue,
        Colour::Red,
        Colour::Green,
        Colour::Orange,
        Colour::Purple,
        Colour::Teal,
        Colour::Magenta,
        Colour::Gold,
        Colour::Grey,
    ];

    #[test]
    fn every_mark_stands_out_from_its_ground_and_the_loss_is_seen() {
        assert!((contrast([0; 3], [255; 3]) - 21.0).abs() < 1e-9);
        for ground in [Ground::Light, Ground::Dark] {
            let paper = ground.colour();
            for colour in COLOURS {
                for role in Role::ORDER {
                    let found = contrast(stroke(role, colour, ground).colour, paper);
                    assert!(found >= 3.0, "{colour:?} {role:?} on {ground:?}: {found}");
                }
            }
            let loss = mixed(paper, Colour::LOSS.on(ground), ground.opacity());
            assert!(
                contrast(loss, paper) >= 1.5,
                "{ground:?}: {}",
                contrast(loss, paper)
            );
            // What is drawn over the loss.
            for colour in [
                Colour::of(Direction::Approach),
                Colour::of(Direction::Retraction),
                Colour::JUMP,
            ] {
                assert!(
                    contrast(colour.on(ground), loss) >= 2.0,
                    "{colour:?} on the loss, {ground:?}"
                );
            }
        }
    }

    #[test]
    fn roles_and_symbols_differ_without_colour() {
        let look = |role| {
            let stroke = stroke(role, Colour::Blue, Ground::Light);
            (stroke.width, stroke.dash)
        };
        for (i, a) in Role::ORDER.iter().enumerate() {
            assert!(
                Role::ORDER[..i].iter().all(|b| look(*a) != look(*b)),
                "{a:?}"
            );
        }
    }

    #[test]
    fn marks_keep_their_places_while_a_line_grows() {
        let line: Vec<[f64; 2]> = (0..100).map(|i| [5.0 - 0.03 * f64::from(i), 0.0]).collect();
        let all: Vec<_> = marked(&line, 0.5).collect();
        let half: Vec<_> = marked(&line[..60], 0.5).collect();
        assert!(all.len() == 6 && half == all[..half.len()]);
    }

    #[test]
    fn contact_is_the_darkest_of_every_scale_and_white_lines_are_seen_on_it() {
        for (colours, word) in Colours::ALL {
            let on_white = |share: f64| contrast(colours.at(share), [255; 3]);
            let darkest = (1..=100).all(|k| on_white(f64::from(k) / 100.0) < on_white(0.0));
            assert!(darkest && on_white(0.0) > 10.0, "{word}");
        }
    }

    #[test]
    fn no_colour_jumps_along_a_scale_and_its_ends_go_on() {
        for (colours, word) in Colours::ALL {
            for k in 0..400 {
                let [a, b] = [k, k + 1].map(|k| colours.at(f64::from(k) / 400.0));
                let far = (0..3).any(|c| a[c].abs_diff(b[c]) > 4);
                assert!(!far, "{word}: {a:?} {b:?}");
            }
            assert_eq!(
                [colours.at(-1.0), colours.at(2.0)],
                [0.0, 1.0].map(|s| colours.at(s))
            );
        }
    }
}
