//! The paper, figure by figure: diagrams, what to look for, numbers held against numbers, and what
//! the print got wrong.

use super::action::Action;
use super::figure_plot;
use super::theme::{self, Palette, set};
use super::view_state::ViewState;
use crate::paper::errata::Erratum;
use crate::paper::figure::Finding;
use crate::paper::{Figure, GALLERY};
use crate::plot::typeset::number;
use crate::worker::protocol::{Page, PageContent};
use egui::{Context, ProgressBar, RichText, Role, ScrollArea, Ui, WidgetInfo};

/// The tab.
pub fn show(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    pages(ui, state, actions);
    buttons(ui, state, actions, false);
    ScrollArea::vertical()
        .auto_shrink([false, false])
        .id_salt("paper")
        .show(ui, |ui| page(ui, state, actions));
}

/// The page in a window of its own, if it is open.
pub fn window(ctx: &Context, state: &ViewState, actions: &mut Vec<Action>) {
    if !state.paper.large {
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
            pages(ui, state, actions);
            buttons(ui, state, actions, true);
            ScrollArea::vertical()
                .auto_shrink([false, false])
                .show(ui, |ui| page(ui, state, actions));
        });
    if !open {
        actions.push(Action::EnlargePage(false));
    }
}

/// A button for each figure, and one for the errata.
fn pages(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = egui::vec2(2.0, 2.0);
        let figures = GALLERY.iter().map(|entry| {
            let (number, title) = (entry.number, entry.title);
            (
                Page::Figure(number),
                number.to_string(),
                format!("Figure {number}"),
                format!("Fig. {number}: {title}"),
            )
        });
        let errata = (
            Page::Errata,
            "Errata".to_owned(),
            "Errata".to_owned(),
            "what the print got wrong, with evidence in numbers".to_owned(),
        );
        ui.label(RichText::new("Fig.").weak());
        for (page, face, name, hover) in figures.chain([errata]) {
            let chosen = state.paper.page == page;
            let response = ui.selectable_label(chosen, face).on_hover_text(hover);
            response.widget_info(|| WidgetInfo::selected(Role::Button, true, chosen, &name));
            if response.clicked() {
                actions.push(Action::OpenPage(page));
            }
        }
    });
}

fn page(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let paper = &state.paper;
    if let Some(entry) = paper.entry() {
        let text = ui.visuals().text_color();
        ui.label(RichText::new(format!("Fig. {}: {}", entry.number, entry.title)).strong());
        ui.label(set(entry.look_for, 12.5, text));
    }
    progress(ui, state, actions);
    match paper.known.get(&paper.page) {
        Some(PageContent::Figure(figure)) => {
            figure_plot::figure(ui, figure);
            words(ui, figure);
        }
        Some(PageContent::Errata(errata)) => self::errata(ui, errata),
        Some(PageContent::Theory(_)) | None => {}
    }
}

fn buttons(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>, large: bool) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let scene = ui.add_enabled(
            state.paper.entry().is_some(),
            egui::Button::new(
                "Open this \
            scene",
            ),
        );
        if scene
            .on_hover_text(
                "play this figure by hand, with theory over it (Ctrl+Z brings the \
            old scene back)",
            )
            .clicked()
        {
            actions.push(Action::OpenPageScene);
        }
        let mut overlay = state.paper.overlay;
        let hover = "flat state, and ridge, dimple and bulge of zero range, or JKR for a tip, over \
            the live plot";
        if ui
            .checkbox(&mut overlay, "Overlay theory")
            .on_hover_text(hover)
            .changed()
        {
            actions.push(Action::OverlayTheory(overlay));
        }
        if !large
            && ui
                .button("Enlarge")
                .on_hover_text("a window of its own")
                .clicked()
        {
            actions.push(Action::EnlargePage(true));
        }
    });
}

fn progress(ui: &mut Ui, state: &ViewState, actions: &mut Vec<Action>) {
    let paper = &state.paper;
    if let Some((_, job)) = &paper.job {
        ui.horizontal(|ui| {
            if ui.button("Cancel").clicked() {
                actions.push(Action::ClosePage);
            }
            ui.add(
                ProgressBar::new(job.fraction as f32)
                    .desired_width(80.0)
                    .desired_height(14.0),
            );
            ui.add(egui::Label::new(RichText::new(&job.doing).small()).truncate());
        });
    } else if let Some(why) = &paper.missing {
        ui.horizontal_wrapped(|ui| {
            ui.label(
                RichText::new(format!("Not there: {why}."))
                    .color(theme::palette(theme::ground(ui)).warn),
            );
            if ui.button("Compute").clicked() {
                actions.push(Action::OpenPage(paper.page));
            }
        });
    }
}

/// The figure's paragraph and findings.
fn words(ui: &mut Ui, figure: &Figure) {
    let (text, palette) = (ui.visuals().text_color(), theme::palette(theme::ground(ui)));
    if !figure.words.is_empty() {
        ui.add_space(4.0);
        ui.label(set(&figure.words, 12.5, text));
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
        ui.label(set(&finding.quantity, 12.0, text));
    });
    let numbers = format!(
        "{}, expected {} ({}): {word}",
        number(finding.found),
        number(finding.expected),
        finding.source
    );
    ui.indent("numbers", |ui| ui.label(set(&numbers, 12.0, text)));
}

fn errata(ui: &mut Ui, errata: &[Erratum]) {
    let (text, palette) = (ui.visuals().text_color(), theme::palette(theme::ground(ui)));
    ui.label(
        RichText::new("Found without either formula: by roots, integrals, measurements, a loop.")
            .weak(),
    );
    for erratum in errata {
        ui.add_space(5.0);
        ui.label(RichText::new(erratum.place).strong());
        ui.label(set(
            &format!("printed: {}", erratum.printed),
            12.0,
            palette.warn,
        ));
        ui.label(set(
            &format!("right: {}", erratum.right),
            12.0,
            palette.good,
        ));
        ui.label(set(erratum.because, 12.0, text));
        for evidence in &erratum.evidence {
            let [found, printed, right] =
                [evidence.found, evidence.printed, evidence.right].map(number);
            let words = format!(
                "{}: {found}; print {printed}, right {right}",
                evidence.quantity
            );
            ui.indent("evidence", |ui| ui.label(set(&words, 12.0, text)));
        }
    }
}
