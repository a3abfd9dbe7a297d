//! Fonts, light and dark visuals, the few colours with a meaning, and lines of text with formulas.

use crate::follow::record::Direction;
use crate::plot::panel::Colour;
use crate::plot::style::{Ground, Rgb};
use crate::plot::typeset::{Script, runs};
use egui::text::{LayoutJob, TextFormat};
use egui::{
    Align, Color32, Context, CornerRadius, FontData, FontDefinitions, FontFamily, FontId, Stroke,
    TextStyle, Theme, Visuals,
};
use std::sync::Arc;

/// Size of words (points). Only sub- and superscripts are smaller than [`LEAST`].
pub const BODY: f32 = 15.0;
/// Of numbers along axes.
pub const TICK: f32 = 14.0;
/// The least.
pub const LEAST: f32 = 13.0;
/// Of headings and the titles of dialogs.
const HEADING: f32 = 17.0;

const DEJAVU: &[u8] = include_bytes!("../../assets/DejaVuSans.ttf");

/// Colours with a meaning outside of diagrams; those of diagrams are [`crate::plot::style`]'s, here
/// too.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Palette {
    /// u0 decreases.
    pub approach: Color32,
    /// u0 increases.
    pub retraction: Color32,
    /// The flat state's closed form.
    pub flat: Color32,
    /// Jumps.
    pub jump: Color32,
    /// The live loop.
    pub live: Color32,
    /// Failures and the zone where the mesh lies.
    pub warn: Color32,
    /// Stable, done.
    pub good: Color32,
    /// Tensile traction.
    pub pull: Color32,
    /// Compressive traction.
    pub push: Color32,
    /// The soft body.
    pub elastomer: Color32,
    /// The rigid indenter.
    pub indenter: Color32,
    /// The present point.
    pub now: Color32,
}

/// A colour of the diagrams as the toolkit has it.
pub fn rgb([red, green, blue]: Rgb) -> Color32 {
    Color32::from_rgb(red, green, blue)
}

/// The one of two colours for this ground.
fn picked(ground: Ground, light: Rgb, dark: Rgb) -> Color32 {
    rgb(match ground {
        Ground::Light => light,
        Ground::Dark => dark,
    })
}

/// The ground of the present theme.
pub fn ground(ui: &egui::Ui) -> Ground {
    if ui.visuals().dark_mode {
        Ground::Dark
    } else {
        Ground::Light
    }
}

/// The colours of the present theme.
pub fn palette(ui: &egui::Ui) -> Palette {
    palette_on(ground(ui))
}

/// The colours over maps, in both themes.
pub fn over_maps() -> Palette {
    palette_on(Ground::Dark)
}

/// The colours on a ground.
pub fn palette_on(ground: Ground) -> Palette {
    let of = |colour: Colour| rgb(colour.on(ground));
    let pick = |light: Rgb, dark: Rgb| picked(ground, light, dark);
    Palette {
        approach: of(Colour::of(Direction::Approach)),
        retraction: of(Colour::of(Direction::Retraction)),
        flat: of(Colour::FLAT),
        jump: of(Colour::JUMP),
        live: of(Colour::LIVE),
        warn: pick([178, 48, 20], [255, 140, 112]),
        good: of(Colour::Green),
        pull: of(Colour::PULL),
        push: of(Colour::PUSH),
        elastomer: pick([138, 178, 212], [70, 112, 148]),
        indenter: pick([150, 145, 136], [108, 104, 98]),
        now: of(Colour::Ink),
    }
}

/// Sets fonts and both themes; once at the start.
pub fn install(ctx: &Context) {
    let mut fonts = FontDefinitions::default();
    fonts.font_data.insert(
        "DejaVu Sans".to_owned(),
        Arc::new(FontData::from_static(DEJAVU)),
    );
    // First, because the default font lacks arrows, letter subscripts and half of the Greek the
    // labels need.
    for family in [FontFamily::Proportional, FontFamily::Monospace] {
        let list = fonts.families.entry(family.clone()).or_default();
        list.insert(
            if family == FontFamily::Proportional {
                0
            } else {
                list.len().min(1)
            },
            "DejaVu Sans".to_owned(),
        );
    }
    ctx.set_fonts(fonts);
    ctx.style_mut_of(Theme::Dark, |style| style.visuals = visuals(Ground::Dark));
    ctx.style_mut_of(Theme::Light, |style| style.visuals = visuals(Ground::Light));
    ctx.all_styles_mut(|style| {
        style.text_styles = [
            (TextStyle::Small, FontId::proportional(LEAST)),
            (TextStyle::Body, FontId::proportional(BODY)),
            (TextStyle::Button, FontId::proportional(BODY)),
            (TextStyle::Heading, FontId::proportional(HEADING)),
            (TextStyle::Monospace, FontId::monospace(TICK)),
        ]
        .into();
        style.spacing.item_spacing = egui::vec2(6.0, 5.0);
        style.spacing.button_padding = egui::vec2(7.0, 3.0);
        style.spacing.interact_size.y = 22.0;
        style.spacing.slider_width = 120.0;
        style.animation_time = 0.0;
        // A drag that misses a slider must not paint the words beside it.
        style.interaction.selectable_labels = false;
    });
}

fn visuals(ground: Ground) -> Visuals {
    let mut v = match ground {
        Ground::Light => Visuals::light(),
        Ground::Dark => Visuals::dark(),
    };
    let pick = |light: Rgb, dark: Rgb| picked(ground, light, dark);
    let stroke = |light: Rgb, dark: Rgb| Stroke::new(1.0, pick(light, dark));
    v.panel_fill = pick([246, 247, 249], [27, 30, 36]);
    v.window_fill = pick([255; 3], [33, 37, 44]);
    v.extreme_bg_color = rgb(ground.colour());
    v.faint_bg_color = pick([236, 239, 243], [34, 38, 45]);
    v.widgets.noninteractive.fg_stroke = stroke([42, 46, 54], [206, 211, 219]);
    v.weak_text_color = Some(pick([84, 90, 100], [160, 166, 176]));
    v.widgets.noninteractive.bg_stroke = stroke([212, 216, 222], [52, 57, 66]);
    v.widgets.inactive.fg_stroke = stroke([38, 42, 50], [220, 224, 230]);
    v.widgets.inactive.weak_bg_fill = pick([226, 230, 236], [48, 53, 62]);
    v.widgets.inactive.bg_fill = pick([206, 212, 220], [62, 68, 79]);
    v.selection.bg_fill = pick([178, 212, 244], [32, 92, 148]);
    v.selection.stroke = stroke([10, 60, 110], [255; 3]);
    let radius = CornerRadius::same(5);
    for w in [
        &mut v.widgets.noninteractive,
        &mut v.widgets.inactive,
        &mut v.widgets.hovered,
        &mut v.widgets.active,
        &mut v.widgets.open,
    ] {
        w.corner_radius = radius;
    }
    v.slider_trailing_fill = true;
    v
}

/// The edge of what can be chosen, whether it is or not: its fill is too pale to be seen alone.
pub fn edge(visuals: &Visuals) -> Stroke {
    Stroke::new(1.0, visuals.weak_text_color())
}

/// Font of tick labels and other small print inside pictures.
pub fn small() -> FontId {
    FontId::proportional(TICK)
}

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
            TextFormat {
                font_id: FontId::proportional(size),
                color: colour,
                valign,
                ..TextFormat::default()
            },
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::style::contrast;

    const GROUNDS: [Ground; 2] = [Ground::Light, Ground::Dark];

    fn of(colour: Color32) -> Rgb {
        assert_eq!(
            colour.a(),
            255,
            "a colour that is seen through has no contrast of its own"
        );
        [colour.r(), colour.g(), colour.b()]
    }

    /// `colour` upon an opaque ground.
    fn upon(colour: Color32, ground: Color32) -> Rgb {
        of(ground.blend(colour))
    }

    #[test]
    fn every_text_stands_out_from_what_it_is_written_on() {
        for ground in GROUNDS {
            let (v, p) = (visuals(ground), palette_on(ground));
            let fills = [
                v.panel_fill,
                v.window_fill,
                v.extreme_bg_color,
                v.faint_bg_color,
            ];
            let texts = [
                ("text", v.text_color()),
                ("strong", v.strong_text_color()),
                ("weak", v.weak_text_color()),
                ("approach", p.approach),
                ("retraction", p.retraction),
                ("jump", p.jump),
                ("live", p.live),
                ("warn", p.warn),
                ("good", p.good),
                ("now", p.now),
            ];
            for fill in fills {
                for (name, text) in texts {
                    let found = contrast(upon(text, fill), of(fill));
                    assert!(found >= 4.5, "{name} on {fill:?}, {ground:?}: {found:.2}");
                }
            }
            // On buttons, fields and what is chosen.
            let chosen = v.panel_fill.blend(v.selection.bg_fill);
            let card = v
                .faint_bg_color
                .blend(v.selection.bg_fill.gamma_multiply(0.55));
            for (what, text, fill) in [
                (
                    "button",
                    v.widgets.inactive.fg_stroke.color,
                    v.widgets.inactive.weak_bg_fill,
                ),
                (
                    "hovered",
                    v.widgets.hovered.fg_stroke.color,
                    v.widgets.hovered.weak_bg_fill,
                ),
                (
                    "pressed",
                    v.widgets.active.fg_stroke.color,
                    v.widgets.active.weak_bg_fill,
                ),
                ("chosen", v.selection.stroke.color, chosen),
                ("chosen card", v.strong_text_color(), card),
            ] {
                let found = contrast(upon(text, fill), of(fill));
                assert!(found >= 4.5, "{what}, {ground:?}: {found:.2}");
            }
        }
    }

    #[test]
    fn every_mark_stands_out_from_what_it_is_drawn_on() {
        for ground in GROUNDS {
            let (v, p) = (visuals(ground), palette_on(ground));
            // Of sliders, pictures and lists; those of diagrams are tested with their style.
            for (name, mark) in [
                ("approach", p.approach),
                ("retraction", p.retraction),
                ("jump", p.jump),
                ("live", p.live),
                ("now", p.now),
                ("flat", p.flat),
                ("warn", p.warn),
                ("pull", p.pull),
                ("push", p.push),
                ("box of a choice", edge(&v).color),
                ("box under the pointer", v.widgets.hovered.bg_stroke.color),
            ] {
                for fill in [
                    v.panel_fill,
                    v.window_fill,
                    v.extreme_bg_color,
                    v.faint_bg_color,
                ] {
                    let found = contrast(upon(mark, fill), of(fill));
                    assert!(found >= 3.0, "{name} on {fill:?}, {ground:?}: {found:.2}");
                }
            }
            let chosen = v.widgets.inactive;
            let found = contrast(of(chosen.fg_stroke.color), of(chosen.bg_fill));
            assert!(found >= 3.0, "tick in a box, {ground:?}: {found:.2}");
        }
    }

    #[test]
    fn no_words_are_smaller_than_thirteen_points() {
        let ctx = Context::default();
        install(&ctx);
        for theme in [Theme::Light, Theme::Dark] {
            let sizes = &ctx.style_of(theme).text_styles;
            assert!(sizes.values().all(|font| font.size >= LEAST), "{sizes:?}");
            assert_eq!(sizes[&TextStyle::Body].size, 15.0);
        }
        assert_eq!(small().size, 14.0);
    }
}
