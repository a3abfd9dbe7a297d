//! What a legend lists: every name with the look it stands for, once.

use super::panel::{Colour, Panel, Role, Symbol};
use crate::follow::record::Direction;

/// How an entry looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Look {
    /// A line, perhaps with marks along it.
    Line(Role, Colour, Option<Direction>),
    /// A symbol, filled or hollow.
    Symbol(Symbol, Colour, bool),
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
                .map_or(line, |symbol| Look::Symbol(symbol, s.colour, s.filled)),
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
