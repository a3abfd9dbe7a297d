//! The paper, figure by figure: diagrams with gap maps and smaller diagrams inside, what to look
//! for, numbers held against numbers, and what the print got wrong.

use super::{Tab, Title, Update, doing};
use crate::paper::Finding;
use crate::paper::errata::Erratum;
use crate::paper::{Entry, Figure, GALLERY};
use crate::plot::panel::{Content, Panel, letter};
use crate::plot::style::Colours;
use crate::plot::typeset::number;
use crate::storage::picture::{common_scale, gap_image};
use crate::ui::action::Action;
use crate::ui::diagram;
use crate::ui::theme::{self, Palette, set};
use crate::ui::view_state::ViewState;
use crate::ui::widgets::{checkbox, choosable, described, progress};
use crate::ui::words::explain;
use crate::worker::background::{self, Page, PageContent};
use crate::worker::job::Job;
use egui::{
    Color32, ColorImage, Context, Id, Rect, RichText, Role, ScrollArea, TextureHandle,
    TextureOptions, Ui, pos2, vec2,
};
use std::collections::HashMap;

/// The tab. What was computed once stays.
pub struct Paper {
    /// The page that is looked at.
    page: Page,
    /// The pages that are there, but for theory.
    known: HashMap<Page, PageContent>,
    /// The page that is being computed.
    job: Option<(Page, Job<PageContent>)>,
    /// Why the page that is looked at is not there.
    missing: Option<String>,
    /// The page is shown in a window of its own, too.
    large: bool,
    asked: Option<Asked>,
}

/// What was asked of the tab.
enum Asked {
    /// To turn to a page; one that could not be computed is tried again.
    Open(Page),
    /// To open the scene of the figure.
    Scene,
}

/// Every page with a face, in order.
fn all_pages() -> impl Iterator<Item = Page> {
    let figures = GALLERY.iter().map(|entry| Page::Figure(entry.number));
    figures.chain([Page::Errata])
}

/// The gallery's entry of a page, if it is a figure.
fn entry(page: Page) -> Option<&'static Entry> {
    GALLERY
        .iter()
        .find(|entry| Page::Figure(entry.number) == page)
}

impl Default for Paper {
    fn default() -> Self {
        Self {
            page: all_pages().next().unwrap_or(Page::Errata),
            known: HashMap::new(),
            job: None,
            missing: None,
            large: false,
            asked: None,
        }
    }
}

impl Tab for Paper {
    fn title(&self) -> Title {
        let what = "the paper's figures beside their theory, and what the print got wrong";
        Title::tall("Paper", what)
    }

    fn show(&mut self, ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
        self.pages(ui);
        ui.horizontal_wrapped(|ui| {
            self.buttons(ui, state, actions);
            let enlarge = ui.button("Enlarge").on_hover_text("a window of its own");
            self.large |= enlarge.clicked();
        });
        ScrollArea::vertical()
            .auto_shrink([false, false])
            .id_salt("paper")
            .show(ui, |ui| self.content(ui));
    }

    fn update(&mut self, with: Update<'_>) {
        let state = with.state;
        match self.asked.take() {
            Some(Asked::Open(page)) => (self.page, self.missing) = (page, None),
            Some(Asked::Scene) => {
                if let Some(entry) = entry(self.page) {
                    state.open_scene((entry.scene)());
                    state.plots.overlay = true;
                }
            }
            None => {}
        }
        self.take_in(state);
        let seen = with.seen || self.large;
        let theory = (state.plots.overlay && state.plots.theory.is_none()).then_some(Page::Theory);
        let page = (seen && self.missing.is_none()).then_some(self.page);
        let page = page.filter(|page| !self.known.contains_key(page));
        let wanted = theory.or(page);
        // One that nobody looks at any more is dropped.
        if wanted != self.job.as_ref().map(|(page, _)| *page) {
            let begun = |page| (page, with.solver.job(page, background::page));
            self.job = wanted.map(begun);
        }
    }

    /// The page in a window of its own, if it is open.
    fn float(&mut self, ctx: &Context, state: &ViewState, actions: &mut Vec<Action>) {
        if !self.large {
            return;
        }
        let mut open = true;
        let room = ctx.content_rect().size();
        let shown = egui::Window::new("The paper")
            .id(egui::Id::unique("paper, large"))
            .open(&mut open)
            .resizable(true);
        shown
            .default_size([(0.72 * room.x).min(980.0), 0.8 * room.y - 60.0])
            .default_pos([0.14 * room.x, 50.0])
            .show(ctx, |ui| {
                self.pages(ui);
                ui.horizontal_wrapped(|ui| self.buttons(ui, state, actions));
                ScrollArea::vertical()
                    .auto_shrink([false, false])
                    .show(ui, |ui| self.content(ui));
            });
        self.large = open;
    }

    fn commands(&self) -> Vec<String> {
        let name = |page| match entry(page) {
            Some(entry) => format!("Fig. {}: {}", entry.number, entry.title),
            None => "Errata: what the print got wrong".to_owned(),
        };
        all_pages().map(name).collect()
    }

    fn command(&mut self, index: usize) {
        self.asked = all_pages().nth(index).map(Asked::Open);
    }
}

impl Paper {
    /// Takes in what has come of the page that is computed.
    fn take_in(&mut self, state: &mut ViewState) {
        let Some((page, job)) = &mut self.job else {
            return;
        };
        let end = match job.poll() {
            Some(end) => end,
            None if job.is_running() => return,
            None => Err("cancelled".to_owned()),
        };
        let (page, content) = (*page, job.so_far.take());
        self.job = None;
        match (end, content) {
            (Ok(()), Some(PageContent::Theory(theory))) => state.plots.theory = Some(theory),
            (Ok(()), content) => self.known.extend(content.map(|content| (page, content))),
            (Err(_), _) if page == Page::Theory => state.plots.overlay = false,
            (Err(why), _) => self.missing = Some(why),
        }
    }
}

/// How it is drawn.
impl Paper {
    /// A button for each figure, and one for the errata.
    fn pages(&mut self, ui: &mut Ui) {
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing = egui::vec2(2.0, 2.0);
            explain(ui.label(RichText::new("Fig.").weak()), "Fig.");
            for page in all_pages() {
                let (face, name, hover) = match entry(page) {
                    Some(entry) => (
                        entry.number.to_string(),
                        format!("Figure {}", entry.number),
                        format!("Fig. {}: {}", entry.number, entry.title),
                    ),
                    None => (
                        "Errata".to_owned(),
                        "Errata".to_owned(),
                        "what the print got wrong, with evidence in numbers".to_owned(),
                    ),
                };
                let chosen = self.page == page;
                let response = ui.selectable_label(chosen, face).on_hover_text(hover);
                choosable(&response, Role::Button, chosen, &name);
                if response.clicked() {
                    self.asked = Some(Asked::Open(page));
                }
            }
        });
    }

    fn content(&mut self, ui: &mut Ui) {
        if let Some(entry) = entry(self.page) {
            let text = ui.visuals().text_color();
            ui.label(RichText::new(format!("Fig. {}: {}", entry.number, entry.title)).strong());
            ui.label(set(entry.look_for, theme::LEAST, text));
        }
        self.under_way(ui);
        match self.known.get(&self.page) {
            Some(PageContent::Figure(figure)) => {
                diagrams(ui, figure);
                words(ui, figure);
            }
            Some(PageContent::Errata(errata)) => self::errata(ui, errata),
            Some(PageContent::Theory(_)) | None => {}
        }
    }

    fn buttons(&mut self, ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
        ui.spacing_mut().item_spacing.x = 4.0;
        let is_figure = entry(self.page).is_some();
        let scene = ui.add_enabled(is_figure, egui::Button::new("Open this scene"));
        let hover = "play this figure by hand, with theory over it (Ctrl+Z brings the old scene \
            back)";
        if scene.on_hover_text(hover).clicked() {
            self.asked = Some(Asked::Scene);
        }
        let mut overlay = state.plots.overlay;
        let hover = "flat state, and ridge, dimple and bulge of zero range, or JKR for a tip, over \
            the live plot";
        let overlaid = checkbox(ui, &mut overlay, "Overlay theory");
        if overlaid.on_hover_text(hover).changed() {
            actions.push(Action::OverlayTheory(overlay));
        }
    }

    /// How far the page is that is being computed, or why it is not there.
    fn under_way(&mut self, ui: &mut Ui) {
        if let Some((_, job)) = &self.job {
            ui.horizontal(|ui| {
                progress(ui, job);
                doing(ui, job);
            });
        } else if let Some(why) = &self.missing {
            ui.horizontal_wrapped(|ui| {
                let words = format!("Not there: {why}.");
                ui.label(RichText::new(words).color(theme::palette(ui).warn));
                if ui.button("Compute").clicked() {
                    self.asked = Some(Asked::Open(self.page));
                }
            });
        }
    }
}

/// The figure's paragraph and findings.
fn words(ui: &mut Ui, figure: &Figure) {
    let (text, palette) = (ui.visuals().text_color(), theme::palette(ui));
    if !figure.words.is_empty() {
        ui.add_space(4.0);
        ui.label(set(&figure.words, theme::LEAST, text));
    }
    for finding in &figure.findings {
        ui.add_space(3.0);
        self::finding(ui, finding, &palette);
    }
}

fn finding(ui: &mut Ui, finding: &Finding, palette: &Palette) {
    let text = ui.visuals().text_color();
    let (mark, word, colour) = match finding.agrees() {
        Some(true) => ("✔", "agrees", palette.good),
        Some(false) => ("✘", "does not agree", palette.warn),
        None => ("·", "stated", palette.flat),
    };
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 5.0;
        ui.label(RichText::new(mark).color(colour).strong());
        ui.label(set(&finding.quantity, theme::LEAST, text));
    });
    let numbers = format!(
        "{}, expected {} ({}): {word}",
        number(finding.found),
        number(finding.expected),
        finding.source
    );
    ui.indent("numbers", |ui| ui.label(set(&numbers, theme::LEAST, text)));
}

fn errata(ui: &mut Ui, errata: &[Erratum]) {
    let (text, palette) = (ui.visuals().text_color(), theme::palette(ui));
    ui.label(
        RichText::new("Found without either formula: by roots, integrals, measurements, a loop.")
            .weak(),
    );
    for erratum in errata {
        ui.add_space(5.0);
        ui.label(RichText::new(erratum.place).strong());
        ui.label(set(
            &format!("printed: {}", erratum.printed),
            theme::LEAST,
            palette.warn,
        ));
        ui.label(set(
            &format!("right: {}", erratum.right),
            theme::LEAST,
            palette.good,
        ));
        ui.label(set(erratum.because, theme::LEAST, text));
        for evidence in &erratum.evidence {
            let [found, printed, right] =
                [evidence.found, evidence.printed, evidence.right].map(number);
            let words = format!(
                "{}: {found}; print {printed}, right {right}",
                evidence.quantity
            );
            ui.indent("evidence", |ui| ui.label(set(&words, theme::LEAST, text)));
        }
    }
}

/// Least width of two diagrams side by side.
const TWO: f32 = 640.0;

/// Every diagram of a figure, with its legend beneath it.
fn diagrams(ui: &mut Ui, figure: &Figure) {
    let several = figure.panels.len() > 1;
    let columns = if several && ui.available_width() > TWO {
        2
    } else {
        1
    };
    for (row, panels) in figure.panels.chunks(columns).enumerate() {
        ui.columns(columns, |uis| {
            for (column, panel) in panels.iter().enumerate() {
                let index = row * columns + column;
                let heading = panel.heading(index, figure.panels.len());
                let name = format!("Fig. {} diagram {}", figure.number, letter(index));
                self::panel(
                    &mut uis[column],
                    panel,
                    &heading,
                    &name,
                    (figure.number, index),
                );
            }
        });
    }
}

fn panel(ui: &mut Ui, panel: &Panel, heading: &str, name: &str, key: (usize, usize)) {
    if !heading.is_empty() {
        ui.label(set(heading, theme::LEAST, ui.visuals().text_color()));
    }
    let height = (0.66 * ui.available_width())
        .min(0.5 * ui.ctx().content_rect().height())
        .max(150.0);
    let shown = diagram::show(ui, panel, ("paper", key), height, |x, y| {
        Some(format!("x {}\ny {}", number(x), number(y)))
    });
    let curves = panel.series.len();
    let sentence = format!(
        "{name}: {} against {}, {curves} curves",
        panel.y.label, panel.x.label
    );
    described(&shown.response, &sentence);
    maps(ui, panel, *shown.transform.frame(), key);
    diagram::legend(ui, panel);
    for (i, inset) in panel.insets.iter().enumerate() {
        if let Content::Diagram(inner) = &inset.content {
            let heading = format!("inset {}", inner.title);
            self::panel(
                ui,
                inner,
                heading.trim(),
                &format!("{name} inset {}", i + 1),
                (key.0, 100 * (key.1 + 1) + i),
            );
        }
    }
}

/// Textures of gap maps, by figure, diagram and inset.
type Pictures = HashMap<(usize, usize, usize), TextureHandle>;

/// The maps inside the frame of a plot.
fn maps(ui: &Ui, panel: &Panel, frame: Rect, key: (usize, usize)) {
    let colours = common_scale(panel.maps());
    for (i, inset) in panel.insets.iter().enumerate() {
        let Content::Map { letter, gap } = &inset.content else {
            continue;
        };
        let store = Id::unique("paper maps");
        let known = ui.ctx().data_mut(|data| {
            data.get_temp_mut_or_default::<Pictures>(store)
                .get(&(key.0, key.1, i))
                .cloned()
        });
        let texture = known.unwrap_or_else(|| {
            let image = gap_image(gap, colours, Colours::default());
            let size = [image.width() as usize, image.height() as usize];
            let picture = ColorImage::from_rgb(size, image.as_raw());
            let texture = ui.ctx().load_texture(
                format!("map {} {} {i}", key.0, key.1),
                picture,
                TextureOptions::LINEAR,
            );
            ui.ctx().data_mut(|data| {
                data.get_temp_mut_or_default::<Pictures>(store)
                    .insert((key.0, key.1, i), texture.clone())
            });
            texture
        });
        let [x, y, w, h] = inset.place.map(|v| v as f32);
        let room = vec2(w * frame.width(), h * frame.height());
        let corner = pos2(
            frame.left() + x * frame.width(),
            frame.bottom() - y * frame.height() - room.y,
        );
        let size = texture.size_vec2();
        let scale = (room.x / size.x).min(room.y / size.y);
        let rect = Rect::from_min_size(corner, if gap.nrows() == 1 { room } else { size * scale });
        let painter = ui.painter().with_clip_rect(frame);
        painter.image(
            texture.id(),
            rect,
            Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0)),
            Color32::WHITE,
        );
        let visuals = ui.visuals();
        painter.rect_stroke(
            rect,
            0.0,
            egui::Stroke::new(1.0, visuals.text_color()),
            egui::StrokeKind::Outside,
        );
        if letter.is_empty() {
            continue;
        }
        let galley = painter.layout_no_wrap(
            letter.clone(),
            egui::FontId::proportional(theme::LEAST),
            visuals.text_color(),
        );
        painter.rect_filled(
            Rect::from_min_size(rect.min, galley.size() + vec2(4.0, 0.0)),
            0.0,
            visuals.extreme_bg_color,
        );
        painter.galley(rect.min + vec2(2.0, 0.0), galley, visuals.text_color());
    }
}
