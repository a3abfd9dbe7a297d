//! Floor 6: every figure and table of the paper as a value, computed live beside its theory, with
//! what the print got wrong.
//!
//! Each figure is an [`Entry`] in a file (Figs 2 and 3 share theirs) and one line in [`GALLERY`]; a
//! [`Figure`] is made of diagrams and of numbers held against numbers from elsewhere, a [`Task`] is
//! the order to compute one: how large, when to stop, whom to tell. Nothing is drawn here: `storage`
//! writes a figure as CSV, SVG and PNG, the window shows it as plots. Axes and normalisation are the
//! paper's; the stress is turned into its pressure p = -stress where the paper plots p. May use
//! `plot` and below; no drawing, files, or threads.

pub mod boundary_elements;
pub mod errata;
mod figure_01;
mod figure_04;
mod figure_05;
mod figure_06;
mod figure_07;
mod figure_08;
mod figure_09;
mod figure_10;
mod figure_11;
mod figure_12;
mod figure_13;
mod figure_14;
mod figures_02_03;
pub mod measured_law;
pub mod scenes;

use crate::numerics::threads::{self, Cancel};
use crate::physics::mesh::{TABLE_1, mu_rho_of_zone};
use crate::plot::panel::{Page, Panel};
use crate::scene::Scene;
use std::sync::{Mutex, PoisonError};

/// The figures in the paper's order.
pub const GALLERY: &[Entry] = &[
    figure_01::ENTRY,
    figures_02_03::FIGURE_2,
    figures_02_03::FIGURE_3,
    figure_04::ENTRY,
    figure_05::ENTRY,
    figure_06::ENTRY,
    figure_07::ENTRY,
    figure_08::ENTRY,
    figure_09::ENTRY,
    figure_10::ENTRY,
    figure_11::ENTRY,
    figure_12::ENTRY,
    figure_13::ENTRY,
    figure_14::ENTRY,
];

/// Those of tips under a load in place of a driven displacement.
pub const UNDER_LOAD: &[Entry] = &[figure_12::UNDER_LOAD, figure_13::UNDER_LOAD];

/// Figures that take longest at full size, the longest first; the others take seconds.
const LONG: [usize; 5] = [13, 12, 14, 3, 11];

/// The figures of a gallery with the long ones first: the order in which several are soonest done
/// together.
pub fn longest_first(gallery: &'static [Entry]) -> Vec<&'static Entry> {
    let mut list: Vec<&'static Entry> = gallery.iter().collect();
    list.sort_by_key(|entry| {
        LONG.iter()
            .position(|number| *number == entry.number)
            .unwrap_or(LONG.len())
    });
    list
}

/// The tables.
pub const TABLES: &[TableEntry] = &[MESH_NUMBERS];

/// A place in the gallery.
pub struct Entry {
    /// The figure's number in the paper.
    pub number: usize,
    /// One line.
    pub title: &'static str,
    /// What to look for, in two sentences.
    pub look_for: &'static str,
    /// The scene that a click on it opens.
    pub scene: fn() -> Scene,
    /// Computes it.
    pub compute: fn(&mut Task<'_>) -> Result<Figure, Stopped>,
}

impl Entry {
    /// Its figure: number and title are those of the gallery.
    fn figure(
        &self,
        panels: Vec<Panel>,
        words: impl Into<String>,
        findings: Vec<Finding>,
    ) -> Figure {
        Figure {
            number: self.number,
            title: self.title.to_owned(),
            panels,
            words: words.into(),
            findings,
        }
    }
}

/// One figure of the paper, computed.
#[derive(Clone, Debug, Default)]
pub struct Figure {
    /// Its number in the paper.
    pub number: usize,
    /// One line.
    pub title: String,
    /// Its diagrams, in reading order: one, or (a), (b), ...
    pub panels: Vec<Panel>,
    /// One paragraph for the report: what it shows, how it was computed, what the print got wrong.
    pub words: String,
    /// Numbers held against numbers from elsewhere.
    pub findings: Vec<Finding>,
}

impl Figure {
    /// What its picture shows.
    pub fn page(&self) -> Page<'_> {
        Page::new(
            &format!("Fig. {}: {}", self.number, self.title),
            Vec::new(),
            self.panels.as_slice(),
        )
    }
}

/// A number of this program beside the same number from theory, another method, or the print.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// What is compared, with its unit.
    pub quantity: String,
    /// Found here.
    pub found: f64,
    /// The other.
    pub expected: f64,
    /// Where the other comes from ("Eq. 8", "exact ridge", "printed in Eq. 24").
    pub source: String,
    /// Largest deviation that agreement allows, in the quantity's own unit; `None` for a number
    /// that is stated, not judged.
    pub tolerance: Option<f64>,
}

impl Finding {
    /// A number beside the same from `source`; see the fields.
    pub fn new(
        quantity: impl Into<String>,
        found: f64,
        expected: f64,
        source: impl Into<String>,
        tolerance: Option<f64>,
    ) -> Self {
        Self {
            quantity: quantity.into(),
            found,
            expected,
            source: source.into(),
            tolerance,
        }
    }

    /// Whether the two agree; `None` where nothing was promised.
    pub fn agrees(&self) -> Option<bool> {
        self.tolerance
            .map(|tolerance| (self.found - self.expected).abs() <= tolerance)
    }
}

/// The place of a table.
pub struct TableEntry {
    /// The table's number in the paper.
    pub number: usize,
    /// One line.
    pub title: &'static str,
    /// Computes it.
    pub compute: fn(&mut Task<'_>) -> Result<Table, Stopped>,
}

/// A table as text.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Its number in the paper.
    pub number: usize,
    /// One line.
    pub title: String,
    /// Headings.
    pub columns: Vec<String>,
    /// Rows of as many cells.
    pub rows: Vec<Vec<String>>,
    /// One paragraph for the report.
    pub words: String,
    /// Numbers held against numbers from elsewhere.
    pub findings: Vec<Finding>,
}

/// Table 1: the mesh number that other cohesive-zone models use without naming it.
const MESH_NUMBERS: TableEntry = TableEntry {
    number: 1,
    title: "Mesh number μ_ρ of other cohesive-zone models",
    compute: mesh_numbers,
};

fn mesh_numbers(task: &mut Task<'_>) -> Result<Table, Stopped> {
    task.tell(0.0, "Table 1")?;
    let columns = [
        "model",
        "year",
        "μ_ρ printed",
        "M = l_cz σ_max²/(E*γ)",
        "μ_ρ = 1/(2√M)",
    ];
    let rows = TABLE_1.map(|model| {
        let found = mu_rho_of_zone(model.zone);
        vec![
            model.author.to_owned(),
            model.year.to_string(),
            model.mu_rho.to_string(),
            model.formula.to_owned(),
            format!("{found:.4}"),
        ]
    });
    let findings = TABLE_1.map(|model| {
        Finding::new(
            format!("μ_ρ of {}", model.author),
            mu_rho_of_zone(model.zone),
            model.mu_rho,
            "printed in Table 1",
            // Half a unit of the last digit: three are printed, of Hui's 1.09 two after the point.
            Some(if model.mu_rho > 1.0 { 5e-3 } else { 5e-4 }),
        )
    });
    Ok(Table {
        number: 1,
        title: MESH_NUMBERS.title.to_owned(),
        columns: columns.map(str::to_owned).to_vec(),
        rows: rows.to_vec(),
        words:
            "A model that lets its cohesive zone l_cz = M E*γ/σ_max² be as long as a mesh element \
             has, in the Morse law's measure of Eq. 11, μ_ρ = 1/(2√M). All six printed values \
             follow so from the published values of M, to the digits printed."
                .to_owned(),
        findings: findings.to_vec(),
    })
}

/// How much work a figure may be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Size {
    /// Seconds at most: fewer points and coarser meshes, for the window and the tests.
    Quick,
    /// As in the paper.
    #[default]
    Full,
}

/// Why there is no figure.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Stopped {
    /// Somebody asked to stop.
    #[error("stopped")]
    Cancelled,
    /// A computation that the figure cannot do without has failed.
    #[error("{0}")]
    Failed(String),
}

/// An order to compute a figure.
pub struct Task<'a> {
    /// How large.
    pub size: Size,
    /// Raised to stop.
    pub cancel: &'a Cancel,
    /// What takes the place of the paper's scenes, in a figure that can be of another.
    pub scene: Option<&'a Scene>,
    observe: &'a mut (dyn FnMut(f64, &str) + Send),
    share: [f64; 2],
}

impl<'a> Task<'a> {
    /// An order; `observe` is told the share that is done (0 to 1) and what is being done.
    pub fn new(
        size: Size,
        cancel: &'a Cancel,
        observe: &'a mut (dyn FnMut(f64, &str) + Send),
    ) -> Self {
        Self {
            size,
            cancel,
            scene: None,
            observe,
            share: [0.0, 1.0],
        }
    }

    /// The same of another scene than the paper's.
    pub fn of(self, scene: Option<&'a Scene>) -> Self {
        Self { scene, ..self }
    }

    /// The part of it that goes from share `from` to share `to`.
    pub fn part(&mut self, from: f64, to: f64) -> Task<'_> {
        let [low, high] = self.share;
        let at = |share: f64| low + (high - low) * share;
        Task {
            size: self.size,
            cancel: self.cancel,
            scene: self.scene,
            share: [at(from), at(to)],
            observe: self.observe,
        }
    }

    /// Tells the share that is done and what is being done.
    ///
    /// # Errors
    /// [`Stopped::Cancelled`] if somebody asked to stop, so that a loop can say `task.tell(...)?`.
    pub fn tell(&mut self, done: f64, what: &str) -> Result<(), Stopped> {
        let [low, high] = self.share;
        (self.observe)(low + (high - low) * done.clamp(0.0, 1.0), what);
        if self.cancel.requested() {
            Err(Stopped::Cancelled)
        } else {
            Ok(())
        }
    }

    /// Does `work` on every item, several at a time, the dearest first; `cost`, in any unit, is its
    /// share of the progress. Results stand in the order of the items.
    ///
    /// # Errors
    /// What the first item says that fails: the others are then stopped.
    pub fn each<I: Sync, R: Send>(
        &mut self,
        items: &[I],
        cost: impl Fn(&I) -> f64,
        work: impl Fn(&I, &mut Task<'_>) -> Result<R, Stopped> + Sync,
    ) -> Result<Vec<R>, Stopped> {
        let costs: Vec<f64> = items.iter().map(cost).collect();
        let all: f64 = costs.iter().sum();
        let mut order: Vec<usize> = (0..items.len()).collect();
        order.sort_by(|a, b| costs[*b].total_cmp(&costs[*a]));
        let (size, scene, cancel) = (self.size, self.scene, self.cancel.part());
        let told = Mutex::new((self, vec![0.0; items.len()]));
        let results = threads::side_by_side(order, |index| {
            let mut observe = |done: f64, what: &str| {
                let mut told = told.lock().unwrap_or_else(PoisonError::into_inner);
                let (task, shares) = &mut *told;
                shares[index] = done * costs[index] / all;
                // A request to stop reaches the work by its own token.
                let _ = task.tell(shares.iter().sum(), what);
            };
            let mut part = Task::new(size, &cancel, &mut observe).of(scene);
            let result = work(&items[index], &mut part);
            if result.is_err() {
                cancel.request();
            }
            result
        });
        let (done, mut failed): (Vec<_>, Vec<_>) = results.into_iter().partition(Result::is_ok);
        failed.sort_by_key(|why| matches!(why, Err(Stopped::Cancelled)));
        failed.into_iter().chain(done).collect()
    }

    /// `full` or `quick`, as the order says.
    pub fn choose<T>(&self, quick: T, full: T) -> T {
        match self.size {
            Size::Quick => quick,
            Size::Full => full,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn progress_of_work_side_by_side_never_steps_back(
            costs in prop::collection::vec(0.1_f64..10.0, 1..12)
        ) {
            let (cancel, mut told) = (Cancel::default(), Vec::new());
            let mut observe = |done, _: &str| told.push(done);
            let mut task = Task::new(Size::Quick, &cancel, &mut observe);
            let doubled = task.part(0.2, 0.7).each(&costs, |cost| *cost, |cost, task| {
                for i in 0..=5 {
                    task.tell(f64::from(i) / 5.0, "")?;
                }
                Ok(2.0 * cost)
            });
            prop_assert_eq!(doubled, Ok(costs.iter().map(|cost| 2.0 * cost).collect()));
            prop_assert!(told.is_sorted() && told[0] >= 0.2);
            prop_assert!((told[told.len() - 1] - 0.7).abs() < 1e-12);
        }
    }

    #[test]
    fn a_failure_stops_the_work_beside_it_and_is_what_is_told() {
        let cancel = Cancel::default();
        let result = Task::new(Size::Quick, &cancel, &mut |_, _| ()).each(
            &[1.0, 2.0],
            |cost| *cost,
            |cost, task| {
                if *cost == 2.0 {
                    return Err(Stopped::Failed("no".to_owned()));
                }
                while task.tell(0.5, "").is_ok() {}
                Err::<(), _>(Stopped::Cancelled)
            },
        );
        assert_eq!(result, Err(Stopped::Failed("no".to_owned())));
        assert!(!cancel.requested(), "only the part is stopped");
    }
}
