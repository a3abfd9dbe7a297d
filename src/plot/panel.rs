//! A diagram as a value: what it shows, not how it is drawn. The same value becomes CSV, SVG, PNG
//! and a plot in the window; its legend lists every name with the look it stands for, once.

use crate::follow::record::Direction;
use crate::scene::parameter::Unit;
use ndarray::Array2;
use std::borrow::Cow;

/// Diagrams under one title: what a picture file holds.
#[derive(Clone, Debug)]
pub struct Page<'a> {
    /// One line.
    pub title: String,
    /// Lines beneath it.
    pub caption: Vec<String>,
    /// The diagrams, in reading order: one, or (a), (b), ...
    pub panels: Cow<'a, [Panel]>,
}

/// Letters of a title, at most: somebody else may have written it.
const TITLE_MAX: usize = 120;

impl<'a> Page<'a> {
    /// Diagrams under a title and the lines of a caption.
    pub fn new(title: &str, caption: Vec<String>, panels: impl Into<Cow<'a, [Panel]>>) -> Self {
        Self {
            title: title.chars().take(TITLE_MAX).collect(),
            caption,
            panels: panels.into(),
        }
    }
}

/// a, b, c, ...
pub fn letter(index: usize) -> char {
    char::from(b'a' + index.min(25) as u8)
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

impl Panel {
    /// Its heading as the one at `index` of `count` on a page: with its letter where there are
    /// several and it has none of its own.
    pub fn heading(&self, index: usize, count: usize) -> String {
        let title = self.title.trim();
        if count < 2 || title.starts_with('(') {
            return title.to_owned();
        }
        format!("({}) {title}", letter(index)).trim_end().to_owned()
    }

    /// The gaps of its maps, which have one scale of colours, so that they can be compared.
    pub fn maps(&self) -> impl Iterator<Item = &Array2<f64>> {
        self.insets.iter().filter_map(|inset| match &inset.content {
            Content::Map { gap, .. } => Some(gap),
            Content::Diagram(_) => None,
        })
    }
}

/// How values are spread along an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Spread {
    /// Evenly.
    #[default]
    Linear,
    /// By their logarithms (base 10); values at or below zero are not shown.
    Logarithmic,
    /// Evenly below 0.1, on either side of zero by their logarithms beyond: an inverse hyperbolic
    /// sine.
    Signed,
}

/// Below this magnitude a signed axis is linear.
const LINEAR: f64 = 0.1;

impl Spread {
    /// A value as it is shown; not finite where it has no place.
    pub fn shown(self, value: f64) -> f64 {
        match self {
            Spread::Linear => value,
            Spread::Logarithmic => value.log10(),
            Spread::Signed => (value / LINEAR).asinh(),
        }
    }

    /// The value that is shown so.
    pub fn value(self, shown: f64) -> f64 {
        match self {
            Spread::Linear => shown,
            Spread::Logarithmic => 10f64.powf(shown),
            Spread::Signed => LINEAR * shown.sinh(),
        }
    }
}

/// An axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Quantity and unit.
    pub label: String,
    /// How many of that unit a value of 1 is told as.
    pub unit: f64,
    /// How its values are spread.
    pub spread: Spread,
    /// What is shown; `None` is what the data need.
    pub range: Option<[f64; 2]>,
}

impl Default for Axis {
    fn default() -> Self {
        Self {
            label: String::new(),
            unit: 1.0,
            spread: Spread::Linear,
            range: None,
        }
    }
}

impl Axis {
    /// A linear axis that shows what the data need.
    pub fn linear(label: &str) -> Self {
        Self {
            label: label.to_owned(),
            ..Self::default()
        }
    }

    /// The same of values in natural units, under the label `natural`, told as the `quantity` in
    /// another unit where there is one.
    pub fn of(unit: &Unit, natural: &str, quantity: &str) -> Self {
        Self {
            unit: unit.scale,
            ..Self::linear(&unit.label(natural, quantity))
        }
    }

    /// A logarithmic axis that shows what the data need.
    pub fn logarithmic(label: &str) -> Self {
        Self {
            spread: Spread::Logarithmic,
            ..Self::linear(label)
        }
    }

    /// One that is linear about zero and logarithmic on both sides of it.
    pub fn signed(label: &str) -> Self {
        Self {
            spread: Spread::Signed,
            ..Self::linear(label)
        }
    }

    /// The same, showing `low` to `high`.
    pub fn from_to(self, low: f64, high: f64) -> Self {
        Self {
            range: Some([low, high]),
            ..self
        }
    }
}

/// Where a series comes from; each is drawn in its own way, also without colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Role {
    /// Solved equilibria: symbols, or a line where they are dense.
    #[default]
    Simulation,
    /// States that exist and are not stable: a dashed line.
    Unstable,
    /// Exact or corrected theory: a thin solid line.
    Theory,
    /// Computed beforehand: a thin solid line beneath what is solved.
    Forecast,
    /// As the paper prints it, where that differs from the theory: a dashed line.
    Printed,
    /// A help for the eye: thin and grey.
    Guide,
    /// Another loop, kept to compare with.
    Kept(Dash),
}

/// How the lines of several loops that are compared differ without colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Dash {
    /// Not at all.
    Solid,
    /// Long dashes.
    Long,
    /// Dots.
    Dotted,
}

/// How much of a symbol is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Fill {
    /// Its outline.
    #[default]
    Hollow,
    /// All of it.
    Filled,
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
    /// How much of the symbols is drawn.
    pub fill: Fill,
    /// Colour.
    pub colour: Colour,
    /// Marks along a line that point the way it was gone.
    pub direction: Option<Direction>,
    /// (x, y); a line is broken where one is not finite.
    pub points: Vec<[f64; 2]>,
}

impl Role {
    /// In the order in which lines are drawn: what is thin lies on what is broad, helps and
    /// forecasts beneath everything.
    pub const ORDER: [Self; 9] = [
        Self::Guide,
        Self::Forecast,
        Self::Kept(Dash::Solid),
        Self::Kept(Dash::Long),
        Self::Kept(Dash::Dotted),
        Self::Simulation,
        Self::Unstable,
        Self::Theory,
        Self::Printed,
    ];
}

impl Series {
    /// A line through `points`.
    pub fn line(name: &str, role: Role, colour: Colour, points: Vec<[f64; 2]>) -> Self {
        Self {
            name: name.to_owned(),
            role,
            colour,
            points,
            ..Self::default()
        }
    }

    /// The line of a function at these places.
    pub fn curve(
        name: &str,
        role: Role,
        colour: Colour,
        places: impl Iterator<Item = f64>,
        value: impl Fn(f64) -> f64,
    ) -> Self {
        Self::line(name, role, colour, places.map(|x| [x, value(x)]).collect())
    }

    /// A line gone in this direction, as it was computed.
    pub fn gone(direction: Direction, points: Vec<[f64; 2]>) -> Self {
        Self {
            name: direction.to_string(),
            colour: Colour::of(direction),
            direction: Some(direction),
            points,
            ..Self::default()
        }
    }

    /// Symbols at `points`.
    pub fn symbols(name: &str, symbol: Symbol, colour: Colour, points: Vec<[f64; 2]>) -> Self {
        Self {
            name: name.to_owned(),
            symbol: Some(symbol),
            colour,
            points,
            ..Self::default()
        }
    }

    /// The present point, or none: a dot in a ring.
    pub fn here(at: Option<[f64; 2]>) -> [Self; 2] {
        let symbol = |symbol| Self::symbols("", symbol, Colour::Ink, at.into_iter().collect());
        [symbol(Symbol::Ring), symbol(Symbol::Circle).filled()]
    }

    /// A point that is looked at, or none: a frame around it.
    pub fn framed(at: Option<[f64; 2]>, colour: Colour) -> Self {
        Self::symbols("", Symbol::Frame, colour, at.into_iter().collect())
    }

    /// The same with filled symbols.
    pub fn filled(self) -> Self {
        Self {
            fill: Fill::Filled,
            ..self
        }
    }
}

/// A symbol.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Symbol {
    /// Circle.
    Circle,
    /// Square.
    Square,
    /// Diamond.
    Diamond,
    /// Triangle that points up.
    Triangle,
    /// Triangle that points down.
    Down,
    /// Triangle that points to the left.
    Left,
    /// Triangle that points to the right.
    Right,
    /// Two strokes, oblique.
    Cross,
    /// Two strokes, upright.
    Plus,
    /// Filled dot, for dense data.
    Dot,
    /// Large circle, around another symbol.
    Ring,
    /// Large square, around another symbol.
    Frame,
}

/// A colour of the palette, with a shade for light and one for dark ground ([`Colour::on`]).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Colour {
    /// Black on white, white on black.
    #[default]
    Ink,
    /// First.
    Blue,
    /// Second.
    Red,
    /// Third.
    Green,
    /// Fourth.
    Orange,
    /// Fifth.
    Purple,
    /// Sixth.
    Teal,
    /// Seventh.
    Magenta,
    /// Eighth.
    Gold,
    /// Help for the eye.
    Grey,
}

/// Along which axis the edges of an area run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Along {
    /// Spans are (x, lower y, upper y).
    #[default]
    X,
    /// Spans are (y, left x, right x).
    Y,
}

/// The area between two curves over the same x, or the same y.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Area {
    /// Its name in the legend; empty is not listed.
    pub name: String,
    /// Colour.
    pub colour: Colour,
    /// (x, lower y, upper y), or as `along` says.
    pub spans: Vec<[f64; 3]>,
    /// Which axis its edges run along.
    pub along: Along,
}

impl Area {
    /// The place of the edge `k`, 1 or 2, of a span.
    pub fn edge(&self, span: &[f64; 3], k: usize) -> [f64; 2] {
        match self.along {
            Along::X => [span[0], span[k]],
            Along::Y => [span[k], span[0]],
        }
    }
}

/// An arrow.
#[derive(Clone, Debug, PartialEq)]
pub struct Arrow {
    /// Its name in the legend; empty is not listed.
    pub name: &'static str,
    /// Where it starts.
    pub tail: [f64; 2],
    /// Where it points.
    pub head: [f64; 2],
    /// Colour.
    pub colour: Colour,
    /// Direction of the drive in which it happens.
    pub direction: Direction,
}

/// A word at a place.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Label {
    /// The place.
    pub at: [f64; 2],
    /// The word.
    pub text: String,
    /// Colour.
    pub colour: Colour,
    /// Where the word stands: -1 to the left, 0 centred, 1 to the right of the place; and below,
    /// on, above it.
    pub side: [i8; 2],
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

/// How an entry looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Look {
    /// A line, perhaps with marks along it.
    Line(Role, Colour, Option<Direction>),
    /// A symbol.
    Symbol(Symbol, Colour, Fill),
    /// A filled area.
    Area(Colour),
    /// An arrow.
    Arrow(Colour),
}

/// The entries of a diagram: its series, arrows and areas that have names.
pub fn entries(panel: &Panel) -> Vec<(String, Look)> {
    let series = panel.series.iter().map(|s| {
        let line = Look::Line(s.role, s.colour, s.direction);
        (
            s.name.as_str(),
            s.symbol
                .map_or(line, |symbol| Look::Symbol(symbol, s.colour, s.fill)),
        )
    });
    let arrows = panel
        .arrows
        .iter()
        .map(|arrow| (arrow.name, Look::Arrow(arrow.colour)));
    let areas = panel
        .areas
        .iter()
        .map(|area| (area.name.as_str(), Look::Area(area.colour)));
    let mut entries: Vec<(String, Look)> = Vec::new();
    for (name, look) in series.chain(arrows).chain(areas) {
        if !name.is_empty()
            && !entries
                .iter()
                .any(|known| known.0 == name && known.1 == look)
        {
            entries.push((name.to_owned(), look));
        }
    }
    entries
}
