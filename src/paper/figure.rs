//! A figure as a value: what it shows, not how it is drawn. The same value becomes CSV, SVG, PNG and a plot in the window.

use ndarray::Array2;

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
    /// Largest deviation that agreement allows, in the quantity's own unit; `None` for a number that is stated, not judged.
    pub tolerance: Option<f64>,
}

impl Finding {
    /// A number beside the same from `source`; see the fields.
    pub fn new(quantity: &str, found: f64, expected: f64, source: &str, tolerance: Option<f64>) -> Self {
        Self { quantity: quantity.to_owned(), found, expected, source: source.to_owned(), tolerance }
    }

    /// Whether the two agree; `None` where nothing was promised.
    pub fn agrees(&self) -> Option<bool> {
        self.tolerance.map(|tolerance| (self.found - self.expected).abs() <= tolerance)
    }
}

/// One diagram.
#[derive(Clone, Debug, Default)]
pub struct Panel {
    /// Its heading, such as "(a) mu_rho = 0.5"; may be empty.
    pub title: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// Filled areas, drawn first.
    pub areas: Vec<Area>,
    /// Curves and symbols, in the order of the legend.
    pub series: Vec<Series>,
    /// Arrows from tail to head: jumps.
    pub arrows: Vec<Arrow>,
    /// Words at places.
    pub labels: Vec<Label>,
    /// Smaller pictures inside the diagram.
    pub insets: Vec<Inset>,
}

/// An axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Axis {
    /// Quantity and unit.
    pub label: String,
    /// Logarithmic (values at or below zero are not shown).
    pub logarithmic: bool,
    /// What is shown; `None` is what the data need.
    pub range: Option<[f64; 2]>,
}

impl Axis {
    /// A linear axis that shows what the data need.
    pub fn linear(label: &str) -> Self {
        Self { label: label.to_owned(), ..Self::default() }
    }

    /// A logarithmic axis that shows what the data need.
    pub fn logarithmic(label: &str) -> Self {
        Self { label: label.to_owned(), logarithmic: true, range: None }
    }

    /// The same, showing `low` to `high`.
    pub fn from_to(self, low: f64, high: f64) -> Self {
        Self { range: Some([low, high]), ..self }
    }
}

/// Where a series comes from; each is drawn in its own way, also without colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Role {
    /// Solved equilibria: symbols, or a line where they are dense.
    #[default]
    Simulation,
    /// Exact or corrected theory: a solid line.
    Theory,
    /// As the paper prints it, where that differs from the theory: a dashed line.
    Printed,
    /// A help for the eye: thin and grey.
    Guide,
}

/// A curve or a set of symbols.
#[derive(Clone, Debug, Default)]
pub struct Series {
    /// Its name in the legend; empty is not listed.
    pub name: String,
    /// Where it comes from.
    pub role: Role,
    /// Symbols at the points; `None` is a line through them.
    pub symbol: Option<Symbol>,
    /// Colour.
    pub colour: Colour,
    /// (x, y); a line is broken where one is not finite.
    pub points: Vec<[f64; 2]>,
}

impl Series {
    /// A line through `points`.
    pub fn line(name: &str, role: Role, colour: Colour, points: Vec<[f64; 2]>) -> Self {
        Self { name: name.to_owned(), role, symbol: None, colour, points }
    }
}

/// A symbol.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Symbol {
    /// Hollow circle.
    Circle,
    /// Hollow square.
    Square,
    /// Hollow diamond.
    Diamond,
    /// Hollow triangle.
    Triangle,
    /// Two strokes.
    Cross,
    /// Filled dot, for dense data.
    Dot,
}

/// A colour of the palette; each drawer has its own shade for light and dark ground.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Colour {
    /// Black on white, white on black.
    #[default]
    Ink,
    /// Approach.
    Blue,
    /// Retraction.
    Red,
    /// Third.
    Green,
    /// Fourth.
    Orange,
    /// Fifth.
    Purple,
    /// Sixth.
    Teal,
    /// Help for the eye.
    Grey,
    /// Dissipated energy.
    Gold,
}

/// The area between two curves over the same x.
#[derive(Clone, Debug, Default)]
pub struct Area {
    /// Its name in the legend; empty is not listed.
    pub name: String,
    /// Colour.
    pub colour: Colour,
    /// (x, lower y, upper y).
    pub spans: Vec<[f64; 3]>,
}

/// An arrow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrow {
    /// Where it starts.
    pub tail: [f64; 2],
    /// Where it points.
    pub head: [f64; 2],
    /// Colour.
    pub colour: Colour,
    /// Dashed (retraction) or solid.
    pub dashed: bool,
}

/// A word at a place.
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    /// Where its middle stands.
    pub at: [f64; 2],
    /// The word.
    pub text: String,
}

/// A picture inside a diagram.
#[derive(Clone, Debug)]
pub struct Inset {
    /// Left, bottom, width and height as shares of the diagram, from its lower left corner.
    pub place: [f64; 4],
    /// What it shows.
    pub content: Content,
}

/// What an inset shows.
#[derive(Clone, Debug)]
pub enum Content {
    /// The gap over the cell, with the letter that the paper gives it.
    Map {
        /// "a", "b", ...
        letter: String,
        /// Gap (length), shape (ny, nx).
        gap: Array2<f64>,
    },
    /// Another diagram.
    Diagram(Box<Panel>),
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
