//! The energy landscape around a state: the paths over its saddles, x = arc length/rho from the
//! state and y = energy/gamma above it; and how the barriers change along the control.

use super::panel::{Axis, Colour, Label, Panel, Role, Series, Symbol};
use super::scale::nice;
use crate::physics::law::Law;
use crate::physics::parameter::Dimension;
use crate::scene::Model;
use crate::study::landscape::{Landscape, Pass, Place};

/// What both diagrams show at least and at most: axes that stay put while the barriers change.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Extent {
    /// The longest path (ranges).
    pub arc: f64,
    /// The deepest neighbour (gamma).
    pub deepest: f64,
    /// The highest barrier (gamma).
    pub highest: f64,
}

impl Extent {
    /// What holds these passes too; it grows to round numbers.
    pub fn with(self, landscape: &Landscape, law: &Law) -> Self {
        let gamma = law.surface_energy;
        let grown = |now: f64, wanted: f64| {
            if wanted > now { nice(wanted) } else { now }
        };
        let mut all = self;
        for pass in &landscape.passes {
            let longest = pass.path.last().map_or(0.0, |end| end.arc / law.range);
            let barriers = pass.barriers.iter().map(|[_, energy]| *energy);
            let highest = barriers.fold(pass.barrier(), f64::max) / gamma;
            all = Self {
                arc: grown(all.arc, longest),
                deepest: grown(all.deepest, pass.released() / gamma),
                highest: grown(all.highest, highest),
            };
        }
        all
    }
}

/// Arc length and energy of a place above the first of its path: ranges, and gamma.
pub fn at(place: &Place, pass: &Pass, law: &Law) -> [f64; 2] {
    let foot = pass.path[0].energy;
    [
        place.arc / law.range,
        (place.energy - foot) / law.surface_energy,
    ]
}

/// The paths over all saddles.
pub fn landscape_panel(landscape: &Landscape, model: &Model, extent: Extent) -> Panel {
    let law = &model.law;
    let (length, energy) = (model.unit(Dimension::Length), model.unit_of_barriers());
    let mut series = Vec::new();
    let mut labels = Vec::new();
    for pass in &landscape.passes {
        let points: Vec<[f64; 2]> = pass.path.iter().map(|place| at(place, pass, law)).collect();
        let colour = Colour::of_pattern(pass.to);
        let name = format!("to {} over \"{}\"", pass.to, pass.branch);
        let end = points[points.len() - 1];
        labels.push(Label {
            at: end,
            text: pass.to.word().to_owned(),
            colour,
            side: [-1, -1],
        });
        let top = vec![points[pass.saddle]];
        series.push(Series::line(&name, Role::Simulation, colour, points));
        series.push(Series::symbols("saddle", Symbol::Triangle, Colour::Ink, top).filled());
    }
    let Extent {
        arc,
        deepest,
        highest,
    } = extent;
    let room = 0.15 * (deepest + highest);
    Panel {
        title: energy.label(
            "path of steepest descent",
            "path of steepest descent: energy",
        ),
        x: Axis::of(&length, "way of the surface/rho", "way of the surface")
            .from_to(-0.05 * arc, 1.05 * arc),
        y: Axis::of(&energy, "energy/gamma", "energy").from_to(-deepest - room, highest + room),
        series,
        labels,
        ..Panel::default()
    }
}

/// The barriers along the control, whose values are told in this `unit` under this `label`.
pub fn barrier_panel(
    landscape: &Landscape,
    model: &Model,
    extent: Extent,
    (label, unit): (&str, f64),
) -> Panel {
    let gamma = model.law.surface_energy;
    let told = model.unit_of_barriers();
    let place = |[control, energy]: &[f64; 2]| [control / unit, energy / gamma];
    let curve = |pass: &Pass| {
        let points = pass.barriers.iter().map(place).collect();
        Series::line("", Role::Simulation, Colour::of_pattern(pass.to), points)
    };
    let now = landscape.passes.iter();
    let now = now.map(|pass| place(&[landscape.control, pass.barrier()]));
    let here = Series::symbols("", Symbol::Circle, Colour::Ink, now.collect()).filled();
    Panel {
        title: told.label("barrier", "barrier"),
        x: Axis::linear(label),
        y: Axis::of(&told, "barrier/gamma", "barrier").from_to(0.0, 1.15 * extent.highest),
        series: landscape.passes.iter().map(curve).chain([here]).collect(),
        ..Panel::default()
    }
}
