//! The paper's pages as the window knows them: which one is looked at, what is computed, what is under way.

use super::ViewState;
use crate::paper::errata::Erratum;
use crate::paper::overlay::ZeroRange;
use crate::paper::{Entry, Figure, GALLERY};
use crate::ui::action::{Tab, ViewOptions};
use crate::worker::protocol::{Command, Page, PaperNews};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The state of the Paper tab. What was computed once stays.
#[derive(Clone, Debug)]
pub struct PaperState {
    /// The page that is looked at.
    pub page: Page,
    /// The figures by their numbers.
    pub figures: BTreeMap<usize, Arc<Figure>>,
    /// What the print got wrong.
    pub errata: Option<Arc<Vec<Erratum>>>,
    /// Theory for the live plot.
    pub theory: Option<Arc<ZeroRange>>,
    /// What is under way: share and words.
    pub progress: Option<(f64, String)>,
    /// Why the page is not there.
    pub stuck: Option<String>,
    /// Theory is laid over the live plot.
    pub overlay: bool,
    /// The page is shown in a window of its own.
    pub large: bool,
    /// What the worker was asked for last and has not answered.
    asked: Option<Page>,
}

impl Default for PaperState {
    fn default() -> Self {
        Self {
            page: GALLERY.first().map_or(Page::Errata, |entry| Page::Figure(entry.number)),
            figures: BTreeMap::new(),
            errata: None,
            theory: None,
            progress: None,
            stuck: None,
            overlay: false,
            large: false,
            asked: None,
        }
    }
}

impl PaperState {
    /// The gallery's entry of the page, if it is a figure.
    pub fn entry(&self) -> Option<&'static Entry> {
        GALLERY.iter().find(|entry| Page::Figure(entry.number) == self.page)
    }

    fn knows(&self, page: Page) -> bool {
        match page {
            Page::Figure(number) => self.figures.contains_key(&number),
            Page::Errata => self.errata.is_some(),
            Page::Theory => self.theory.is_some(),
        }
    }
}

impl ViewState {
    /// Turns to a page; one that is not known yet is computed, and one under way is dropped.
    pub fn open_page(&mut self, page: Page) {
        self.paper.page = page;
        self.paper.stuck = None;
        self.ask_for_page();
    }

    /// Changes how things are drawn.
    pub fn set_view(&mut self, view: ViewOptions) {
        self.view = view;
        self.ask_for_page();
    }

    /// Shows the page in a window of its own, or only in its tab.
    pub fn enlarge_page(&mut self, large: bool) {
        self.paper.large = large;
        self.ask_for_page();
    }

    /// Gives up what is under way.
    pub fn close_page(&mut self) {
        if self.paper.asked.take().is_some() {
            self.outbox.push(Command::ClosePage);
        }
        self.paper.progress = None;
        self.paper.stuck = Some("cancelled".to_owned());
    }

    /// Lays theory over the live plot, or takes it away.
    pub fn set_overlay(&mut self, overlay: bool) {
        self.paper.overlay = overlay;
        self.ask_for_page();
    }

    /// Asks for what is looked at and not known.
    pub(super) fn ask_for_page(&mut self) {
        let seen = self.view.tab == Tab::Paper || self.paper.large;
        let page = (seen && self.paper.stuck.is_none()).then_some(self.paper.page);
        let theory = self.paper.overlay.then_some(Page::Theory);
        let wanted = theory.into_iter().chain(page).find(|page| !self.paper.knows(*page));
        if wanted == self.paper.asked {
            return;
        }
        self.paper.asked = wanted;
        self.paper.progress = wanted.map(|_| (0.0, "beginning".to_owned()));
        self.outbox.push(match wanted {
            Some(page) => Command::OpenPage { page },
            None => Command::ClosePage,
        });
    }

    /// Takes news of a page in. A page that came although nobody waits any more is kept all the same.
    pub(super) fn take_page(&mut self, page: Page, news: PaperNews) {
        let paper = &mut self.paper;
        match (page, news) {
            (_, PaperNews::Progress { done, what }) => {
                if paper.asked == Some(page) {
                    paper.progress = Some((done, what));
                }
                return;
            }
            (Page::Figure(number), PaperNews::Figure(figure)) => drop(paper.figures.insert(number, figure)),
            (_, PaperNews::Figure(_)) => {}
            (_, PaperNews::Errata(errata)) => paper.errata = Some(errata),
            (_, PaperNews::Theory(theory)) => paper.theory = Some(theory),
            (_, PaperNews::Stuck(why)) => {
                if paper.asked != Some(page) {
                    return;
                }
                match page {
                    Page::Theory => paper.overlay = false,
                    _ => paper.stuck = Some(why),
                }
            }
        }
        if self.paper.asked == Some(page) {
            self.paper.asked = None;
            self.paper.progress = None;
        }
        self.ask_for_page();
    }

    /// Theory in the units of the live plot: name, and (u0/rho, stress/sigma_max).
    pub fn overlay(&self) -> Vec<(&'static str, Vec<[f64; 2]>)> {
        let Some(theory) = self.paper.theory.as_ref().filter(|_| self.paper.overlay) else { return Vec::new() };
        let (rho, top) = (self.rho(), self.model.law.traction_max());
        let scaled = |points: Vec<[f64; 2]>| points.into_iter().map(|[u0, stress]| [u0 / rho, stress / top]).collect();
        theory.lines(&self.model, self.limits.0, self.limits.1).into_iter().map(|line| (line.name, scaled(line.points))).collect()
    }
}
