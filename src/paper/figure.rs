//! What the paper shows as values: its figures, made of diagrams, its table, and numbers held
//! against numbers from elsewhere.

use super::task::{Stopped, Task};
use crate::plot::panel::{Page, Panel};
use crate::scene::Scene;

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
    pub(super) fn figure(
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
