//! What is computed in the background: the time-step map, the chart, the pages of the paper; and
//! what follows from them.

use super::ViewState;
use crate::paper::overlay::ZeroRange;
use crate::paper::{Entry, GALLERY};
use crate::scene::Range;
use crate::scene::part::Strategy;
use crate::study::chart::Effort;
use crate::ui::action::{Measurement, Tab};
use crate::worker::SolverHandle;
use crate::worker::job::Job;
use crate::worker::protocol::{Page, PageContent};
use std::collections::HashMap;

/// Processor seconds of a full chart.
const FULL: f64 = 120.0;

/// The paper's pages as the window knows them. What was computed once stays.
#[derive(Debug)]
pub struct PaperState {
    /// The page that is looked at.
    pub page: Page,
    /// The pages that are there.
    pub known: HashMap<Page, PageContent>,
    /// The page that is being computed.
    pub job: Option<(Page, Job<PageContent>)>,
    /// Why the page is not there.
    pub missing: Option<String>,
    /// Theory is laid over the live plot.
    pub overlay: bool,
    /// The page is shown in a window of its own.
    pub large: bool,
}

impl Default for PaperState {
    fn default() -> Self {
        Self {
            page: GALLERY
                .first()
                .map_or(Page::Errata, |entry| Page::Figure(entry.number)),
            known: HashMap::new(),
            job: None,
            missing: None,
            overlay: false,
            large: false,
        }
    }
}

impl PaperState {
    /// The gallery's entry of the page, if it is a figure.
    pub fn entry(&self) -> Option<&'static Entry> {
        GALLERY
            .iter()
            .find(|entry| Page::Figure(entry.number) == self.page)
    }

    /// Theory for the live plot, if it is there and wanted.
    pub(super) fn theory(&self) -> Option<&ZeroRange> {
        match self.known.get(&Page::Theory) {
            Some(PageContent::Theory(theory)) if self.overlay => Some(theory),
            _ => None,
        }
    }

    /// Turns to a page; one that could not be computed is tried again.
    pub fn open(&mut self, page: Page) {
        self.page = page;
        self.missing = None;
    }

    /// Gives up the page that is being computed.
    pub fn cancel(&mut self) {
        if let Some((page, _)) = self.job.take() {
            self.give_up(page, "cancelled".to_owned());
        }
    }

    fn give_up(&mut self, page: Page, why: String) {
        match page {
            Page::Theory => self.overlay = false,
            _ => self.missing = Some(why),
        }
    }

    /// Takes in what has come of the page that is being computed.
    fn poll(&mut self) {
        let Some((page, job)) = &mut self.job else {
            return;
        };
        let Some(end) = job.poll() else { return };
        let (page, content) = (*page, job.so_far.take());
        self.job = None;
        match end {
            Ok(()) => self.known.extend(content.map(|content| (page, content))),
            Err(why) => self.give_up(page, why),
        }
    }
}

impl ViewState {
    /// Takes in what the jobs have found since the last call.
    pub fn poll_jobs(&mut self) {
        let time_steps = self.run.time_steps.as_mut().and_then(Job::poll);
        let chart = self.chart.as_mut().and_then(Job::poll);
        for why in [time_steps, chart]
            .into_iter()
            .flatten()
            .filter_map(Result::err)
        {
            let message = format!("The measurement ended early: {why}.");
            self.messages.fail(message, "What was measured stands.");
        }
        self.paper.poll();
        self.branches.poll(&self.scene, self.model.law);
    }

    /// Begins to compute the page that is looked at, or the theory, if it is not there; drops a
    /// page that nobody looks at any more.
    pub fn begin_page(&mut self, solver: &dyn SolverHandle) {
        let paper = &self.paper;
        let seen = self.view.tab == Tab::Paper || paper.large;
        let page = (seen && paper.missing.is_none()).then_some(paper.page);
        let theory = paper.overlay.then_some(Page::Theory);
        let wanted = theory
            .into_iter()
            .chain(page)
            .find(|page| !paper.known.contains_key(page));
        if wanted != paper.job.as_ref().map(|(page, _)| *page) {
            self.paper.job = wanted.map(|page| (page, solver.page(page)));
        }
    }

    /// Begins a measurement; one under way is stopped.
    pub fn measure(&mut self, what: Measurement, solver: &dyn SolverHandle) {
        self.stop_measuring();
        let scene = self.scene.clone();
        match what {
            Measurement::TimeSteps => {
                self.run.time_steps = Some(solver.time_steps(scene, self.limits.0));
            }
            Measurement::QuickChart => self.chart = Some(solver.chart(scene, Effort::Quick)),
            Measurement::FullChart => {
                self.chart = Some(solver.chart(scene, Effort::Full { seconds: FULL }));
            }
        }
    }

    /// Stops the measurement under way; what was measured stays.
    pub fn stop_measuring(&mut self) {
        self.run.time_steps.iter_mut().for_each(Job::stop);
        self.chart.iter_mut().for_each(Job::stop);
    }

    /// Makes the settings of a row of the chart the scene's: method, mesh, step. The chart stays:
    /// it is of the same loop.
    pub fn use_chart_row(&mut self, index: usize) {
        let mut chart = self.chart.take();
        let row = chart
            .as_ref()
            .and_then(|job| job.so_far.as_ref()?.rows.get(index));
        if let Some(point) = row.map(|row| row.point) {
            chart.iter_mut().for_each(Job::stop);
            let mut scene = (*self.scene).clone();
            scene.law.range = Range::Length(self.model.law.range);
            scene.cell.points = scene.cell.points.resized(point.points);
            scene.drive.step = point.step;
            self.edit_scene(scene);
            self.set_method(point.method);
            self.set_strategy(Some(point.model).filter(|strategy| *strategy != Strategy::Atlas));
            self.messages.notice = Some(match point.model {
                Strategy::Walk(_) => format!("the scene now runs as {point}"),
                Strategy::Atlas => {
                    format!(
                        "the scene now runs as {point}; the walk solves what is shown, the atlas \
                         says what is ahead"
                    )
                }
            });
        }
        self.chart = chart;
    }
}
