//! Lines of text with formulas, for egui.

use crate::paper::typeset::{Script, runs};
use egui::text::{LayoutJob, TextFormat};
use egui::{Align, Color32, FontId};

/// The line with Greek letters, sub- and superscripts.
pub fn set(text: &str, size: f32, colour: Color32) -> LayoutJob {
    let mut job = LayoutJob::default();
    for run in runs(text) {
        let (size, valign) = match run.script {
            Script::Base => (size, Align::BOTTOM),
            Script::Sub => (0.74 * size, Align::BOTTOM),
            Script::Super => (0.74 * size, Align::TOP),
        };
        job.append(
            &run.text,
            0.0,
            TextFormat { font_id: FontId::proportional(size), color: colour, valign, ..TextFormat::default() },
        );
    }
    job
}

/// The same in one size, for places that take no layout: digits are raised and lowered, the rest stays as it is written.
pub fn plain(text: &str) -> String {
    let raised = |c: char| match c {
        '0' => '⁰',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '4'..='9' => char::from_u32('⁴' as u32 + (c as u32 - '4' as u32)).unwrap_or(c),
        '\u{2212}' => '⁻',
        c => c,
    };
    let lowered = |c: char| char::from_u32('₀' as u32 + (c as u32 - '0' as u32)).unwrap_or(c);
    let one = |run: crate::paper::typeset::Run| match run.script {
        Script::Base => run.text,
        Script::Sub if run.text.chars().all(|c| c.is_ascii_digit()) => run.text.chars().map(lowered).collect(),
        Script::Sub => format!("_{}", run.text),
        Script::Super => run.text.chars().map(raised).collect(),
    };
    runs(text).into_iter().map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_are_raised_and_indices_lowered_where_there_is_one_size_only() {
        assert_eq!(plain("10^{\u{2212}3}"), "10⁻³");
        assert_eq!(plain("5·10^{7}"), "5·10⁷");
        assert_eq!(plain("mu_rho"), "μ_ρ");
        assert_eq!(plain("u0"), "u₀");
    }
}
