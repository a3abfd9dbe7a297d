//! The colours of a map of the gap, dark where the surfaces touch: the same in the window, in
//! pictures and in films.

use super::style::Rgb;

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
    use crate::plot::style::contrast;

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
