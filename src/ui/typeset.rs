//! Lines of text with formulas, for egui.

use crate::plot::typeset::{Script, runs};
use egui::text::{LayoutJob, TextFormat};
use egui::{Align, Color32, FontId};

/// The line with Greek letters, sub- and superscripts.
pub fn set(text: &str, size: f32, colour: Color32) -> LayoutJob {
    let mut job = LayoutJob::default();
    append(&mut job, text, size, colour);
    job
}

/// Goes on with another line of another colour.
pub fn append(job: &mut LayoutJob, text: &str, size: f32, colour: Color32) {
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
}
