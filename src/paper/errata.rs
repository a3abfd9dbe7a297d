//! What the print of the paper got wrong: where, what it says, what is right, and numbers that
//! decide between the two.
//!
//! The numbers are computed on the spot and from neither formula: by finding a root, by
//! integrating, by measuring a law or a mesh, by running a loop.

mod evidence;

use super::task::{Stopped, Task};

/// An error of the print.
#[derive(Clone, Debug, PartialEq)]
pub struct Erratum {
    /// Where it stands ("Eq. 24").
    pub place: &'static str,
    /// What is printed.
    pub printed: &'static str,
    /// What is right.
    pub right: &'static str,
    /// Why, in a sentence.
    pub because: &'static str,
    /// Numbers that decide; none where the error is one of notation only.
    pub evidence: Vec<Evidence>,
}

/// A number found here, beside the same number by the printed and by the right formula.
#[derive(Clone, Debug, PartialEq)]
pub struct Evidence {
    /// What it is, and how it was found.
    pub quantity: &'static str,
    /// Found here.
    pub found: f64,
    /// By the print.
    pub printed: f64,
    /// By what is right.
    pub right: f64,
    /// How near to `right` the found number must be to support it: what the way of finding leaves
    /// open.
    pub tolerance: f64,
}

impl Evidence {
    /// A number found here, the same by the print and by what is right, and how near the found one
    /// must be; see the fields.
    pub(super) fn new(
        quantity: &'static str,
        found: f64,
        [printed, right]: [f64; 2],
        tolerance: f64,
    ) -> Self {
        Self {
            quantity,
            found,
            printed,
            right,
            tolerance,
        }
    }
}

/// What is said while the loop behind one of them is run.
const LOOP: &str = "errata: a loop of a line cell";

/// All of them, in the paper's order.
///
/// # Errors
/// [`Stopped`] if somebody asked to stop, or a computation behind the evidence has failed.
pub fn errata(task: &mut Task<'_>) -> Result<Vec<Erratum>, Stopped> {
    task.tell(0.0, "errata: meshes and laws")?;
    let mut list = vec![
        evidence::equation_9(),
        evidence::equation_22(),
        evidence::equation_24(),
        evidence::equation_25(),
        evidence::equation_27(),
    ];
    task.tell(0.2, "errata: circular patterns")?;
    list.extend([
        evidence::equation_28(),
        evidence::equation_29(),
        evidence::after_equation_29(),
    ]);
    task.tell(0.6, LOOP)?;
    list.extend([
        evidence::equation_30c(),
        evidence::text_at_equation_30(task)?,
        evidence::equation_31(),
        evidence::equation_33(),
    ]);
    list.extend([evidence::section_4(), notation()]);
    Ok(list)
}

/// Slips of the appendix that change no result.
fn notation() -> Erratum {
    Erratum {
        place: "Appendix: A1, A3, A8, A10, A11",
        printed: "σ_0 and u_0 without 1/abar and 1/alpha; q_n = n/(2 pi L); factors of two; alpha \
            for 1 - alpha",
        right: "A1 with 1/abar, A8 with 1/alpha; q_n = 2 pi n/L; the amplitudes of Eqs 4 and A5; \
            alpha is the share out of contact",
        because: "The mean of the printed profile is abar σ_0 and not σ_0, and its wave numbers \
            are not those of a cell of side L.",
        evidence: vec![evidence::wave_number()],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::cancel::Cancel;
    use crate::paper::Size;

    #[test]
    fn all_evidence_supports_what_is_right_and_contradicts_the_print() {
        let list = errata(&mut Task::new(
            Size::Quick,
            &Cancel::default(),
            &mut |_, _| {},
        ))
        .expect("errata");
        assert_eq!(list.len(), 14);
        assert!(list.iter().all(|erratum| !erratum.evidence.is_empty()));
        let all = list.iter().flat_map(|erratum| {
            erratum
                .evidence
                .iter()
                .map(move |evidence| (erratum.place, evidence))
        });
        // Near what is right, and far from the print: by five tolerances or more.
        let decides = |e: &Evidence| {
            (e.found - e.right).abs() <= e.tolerance
                && (e.found - e.printed).abs() >= 5.0 * e.tolerance
        };
        let idle: Vec<_> = all.filter(|(_, evidence)| !decides(evidence)).collect();
        assert!(idle.is_empty(), "{idle:#?}");
    }
}
