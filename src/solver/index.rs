//! The Morse index: how many eigenvalues of the Hessian are negative, over all modes of the whole
//! cell, sliding ones left out.
//!
//! Over an even pattern on flat ground modes fall into classes of symmetry. Each has an exact block
//! of its longest waves, whose negative pivots are negative eigenvalues of the whole Hessian
//! (Sylvester's law of inertia, and Cauchy's interlacing); a block alone may miss one near zero, as
//! it is too stiff by a hundredth of the longest wave: where an eigenvalue of it is small the class
//! is looked at over all waves of the mesh.

use super::mechanics::{Mechanics, Rates, Slides, preconditioner_stiffness};
use super::method::Lost;
use super::stability::Tracker;
use crate::numerics::eigen::{EigenLimits, EigenPairs, smallest};
use crate::physics::low_block::{Class, LowBlock, Unfolding};
use crate::physics::preconditioner::class_reach;
use crate::physics::system::{Fields, System};
use crate::physics::theory::critical_length;
use rand::SeedableRng;
use rand_pcg::Pcg64;

/// Longest reach of the blocks: beyond it a look over all waves is cheaper than to factorise.
const MOST_REACH: f64 = 16.0;
/// Eigenvalues of a block below this, over [`System::stiffness_unit`], are looked at over all
/// waves: the block is too stiff by 0.013 at the reach of Fig. 2.
const DOUBT: f64 = 0.1;
/// How closely: residual over eigenvalue where the sign is asked, and in units of q1 where the
/// place of the zero is. The error of the eigenvalue is the square of the residual over the
/// distance to the next one, some tenths of q1.
const SIGN: f64 = 0.3;
const CLOSELY: f64 = 1e-3;
const ZERO: f64 = 1e-4;
/// Most iterations over all waves.
const ITERATIONS: usize = 30;

/// Counts the negative eigenvalues over a pattern.
#[derive(Clone, Debug)]
pub struct Index(Modes);

#[derive(Clone, Debug)]
enum Modes {
    /// Even patterns on flat ground, class by class.
    Classes {
        classes: Vec<ClassBlock>,
        /// The whole cell, where the blocks leave out waves.
        cell: Option<Box<Mechanics>>,
        /// Eigenvalues of a block below this (E* per length) are looked at so.
        doubt: f64,
        stiffness: f64,
    },
    /// Any pattern, by all modes of the whole cell.
    Cell {
        cell: Box<Mechanics>,
        tracker: Box<Tracker>,
    },
}

/// The modes of one class.
#[derive(Clone, Debug)]
struct ClassBlock {
    class: Class,
    /// Of the longest waves, and all of them.
    block: LowBlock,
    all: LowBlock,
    /// Where they lie in the whole cell, if that is looked at.
    unfolding: Option<Unfolding>,
    /// How many times the whole cell has them.
    copies: usize,
}

/// Negative eigenvalues of each class, the pattern's own first, and how many times each counts.
#[derive(Clone, Debug)]
pub struct Counts(Vec<(usize, usize)>);

impl Counts {
    /// Over all modes.
    pub fn total(&self) -> usize {
        self.0.iter().map(|(count, copies)| count * copies).sum()
    }

    /// In the class with this place.
    pub fn of(&self, class: usize) -> usize {
        self.0[class].0
    }

    /// How many times the whole cell has the class with this place.
    pub fn copies(&self, class: usize) -> usize {
        self.0[class].1
    }

    /// Places of the classes.
    pub fn classes(&self) -> std::ops::Range<usize> {
        0..self.0.len()
    }
}

/// Which pattern.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Symmetry {
    /// Of a line cell: even.
    Line,
    /// Of a square cell: uniform along y, even along x.
    Ridge,
    /// Of a square cell: even along both axes.
    Even,
    /// The same, with x <-> y.
    Square,
}

impl Symmetry {
    /// The classes of modes, the pattern's own first, and how many times the whole cell has each.
    pub(super) fn classes(self, periods: f64) -> Vec<(Class, usize)> {
        match self {
            Symmetry::Line => vec![(Class::Even, 1), (Class::Sinuous(0), 1)],
            Symmetry::Ridge => {
                // A wave that is shorter along y than any that softens is stable whatever it does
                // along x.
                let modulations = (1..=periods.floor() as usize)
                    .flat_map(|k| [(Class::Varicose(k), 2), (Class::Sinuous(k), 2)]);
                Symmetry::Line
                    .classes(periods)
                    .into_iter()
                    .chain(modulations)
                    .collect()
            }
            Symmetry::Even => vec![
                (Class::Even, 1),
                (Class::OddAlongX, 1),
                (Class::OddAlongY, 1),
                (Class::Odd, 1),
            ],
            // What is odd along y is what is odd along x with x and y exchanged.
            Symmetry::Square => vec![
                (Class::Symmetric, 1),
                (Class::Antisymmetric, 1),
                (Class::OddAlongX, 2),
                (Class::OddSymmetric, 1),
                (Class::OddAntisymmetric, 1),
            ],
        }
    }
}

impl Index {
    /// For patterns of this symmetry of an even `system` on flat ground.
    pub fn of_symmetry(system: &System, symmetry: Symmetry) -> Self {
        let periods = system.grid().length / critical_length(system.law());
        let on_line = system.grid().is_line();
        let reach = class_reach(system, MOST_REACH);
        let cell =
            (!on_line).then(|| Box::new(Mechanics::new(System::whole(system), Slides::Never)));
        let block = |(class, copies): (Class, usize)| {
            let all = LowBlock::new(system, class, f64::INFINITY);
            ClassBlock {
                class,
                block: LowBlock::new(system, class, reach),
                unfolding: cell.as_ref().map(|cell| all.unfolding(&cell.system)),
                all,
                copies,
            }
        };
        // A shorter reach makes a block too stiff by who knows how much.
        let doubt = if reach == MOST_REACH {
            f64::INFINITY
        } else {
            DOUBT * system.stiffness_unit()
        };
        Self(Modes::Classes {
            classes: symmetry.classes(periods).into_iter().map(block).collect(),
            cell,
            doubt,
            stiffness: preconditioner_stiffness(system),
        })
    }

    /// For any pattern of a `system`, whole or even, which slides so on the whole cell; random
    /// directions come from `seed`.
    pub fn of_cell(system: &System, slides: Slides, seed: u64) -> Self {
        let cell = if system.is_even() {
            System::whole(system)
        } else {
            system.clone()
        };
        Self(Modes::Cell {
            cell: Box::new(Mechanics::new(cell, slides)),
            tracker: Box::new(Tracker::new(Pcg64::seed_from_u64(seed))),
        })
    }

    /// The class with this place, if modes are told apart by their symmetry.
    pub fn class(&self, place: usize) -> Option<Class> {
        match &self.0 {
            Modes::Classes { classes, .. } => Some(classes[place].class),
            Modes::Cell { .. } => None,
        }
    }

    /// Transforms of the whole cell spent.
    pub fn transforms(&self) -> usize {
        match &self.0 {
            Modes::Classes { cell, .. } => cell.as_ref().map_or(0, |cell| cell.transforms()),
            Modes::Cell { cell, .. } => cell.transforms(),
        }
    }

    /// Counts over the pattern `z` with these `fields`.
    ///
    /// # Errors
    /// The count was not found within the budget, or somebody asked to stop.
    pub fn count(
        &mut self,
        mechanics: &mut Mechanics,
        z: &[f64],
        fields: &Fields,
    ) -> Result<Counts, Lost> {
        let (classes, cell, doubt, stiffness) = match &mut self.0 {
            Modes::Classes {
                classes,
                cell,
                doubt,
                stiffness,
            } => (classes, cell, *doubt, *stiffness),
            Modes::Cell { cell, tracker } => {
                let found = all_modes(cell, tracker, mechanics, z, fields, SIGN)?;
                return Ok(Counts(vec![(negative(&found), 1)]));
            }
        };
        let rates = mechanics.rates(fields);
        let mut whole = None;
        let mut counts = Vec::with_capacity(classes.len());
        for of in classes {
            of.assemble(&mechanics.system, &rates, z);
            let below = if doubt.is_finite() {
                of.block.negative_below(doubt)
            } else {
                of.block.size()
            };
            let mut count = if below == 0 {
                0
            } else {
                of.block.negative_below(0.0)
            };
            if let Some(cell) = cell.as_mut().filter(|_| count < below) {
                cell.cancel = mechanics.cancel.clone();
                let fields = whole.get_or_insert_with(|| unfolded(mechanics, fields));
                let mut seen = if doubt.is_finite() { below } else { count + 1 };
                count = loop {
                    let goals = [SIGN, ZERO, stiffness];
                    let found = negative(&of.among_all(cell, fields, z, seen, goals));
                    if cell.cancel.requested() {
                        return Err(Lost::Cancelled);
                    }
                    if found < seen {
                        break found;
                    }
                    seen += 1;
                };
            }
            counts.push((count, of.copies));
        }
        Ok(Counts(counts))
    }

    /// The eigenvalue of the class at `place` that has `rank` smaller ones (E* per length), over
    /// all waves of the mesh, and its mode: coefficients of the class, or amplitudes of the whole
    /// cell where there are no classes.
    ///
    /// # Errors
    /// It was not found within the budget, or somebody asked to stop.
    pub fn eigenvalue(
        &mut self,
        mechanics: &mut Mechanics,
        z: &[f64],
        fields: &Fields,
        [place, rank]: [usize; 2],
    ) -> Result<(f64, Vec<f64>), Lost> {
        let mut found = match &mut self.0 {
            Modes::Cell { cell, tracker } => {
                all_modes(cell, tracker, mechanics, z, fields, CLOSELY)?
            }
            Modes::Classes {
                classes,
                cell,
                stiffness,
                ..
            } => {
                let rates = mechanics.rates(fields);
                let of = &mut classes[place];
                of.assemble(&mechanics.system, &rates, z);
                of.block.negative_below(0.0);
                match cell {
                    Some(cell) => {
                        cell.cancel = mechanics.cancel.clone();
                        let fields = unfolded(mechanics, fields);
                        of.among_all(cell, &fields, z, rank + 1, [CLOSELY, ZERO, *stiffness])
                    }
                    None => of.block.lowest(rank + 1),
                }
            }
        };
        if rank >= found.values.len() {
            return Err(Lost::Gone);
        }
        Ok((found.values[rank], found.vectors.swap_remove(rank)))
    }
}

fn negative(found: &EigenPairs) -> usize {
    found.values.iter().filter(|v| **v < 0.0).count()
}

/// The negative modes of the whole `cell` over a pattern of a part of it, and the next.
fn all_modes(
    cell: &mut Mechanics,
    tracker: &mut Tracker,
    mechanics: &mut Mechanics,
    z: &[f64],
    fields: &Fields,
    relative: f64,
) -> Result<EigenPairs, Lost> {
    cell.cancel = mechanics.cancel.clone();
    if !mechanics.system.is_even() {
        cell.refresh(fields);
        return tracker.negative(cell, z, fields, relative);
    }
    let even = mechanics.field(z).clone();
    let displacement = mechanics.system.unfolded(&even);
    let z = cell.amplitudes(&displacement);
    let fields = unfolded(mechanics, fields);
    cell.refresh(&fields);
    tracker.negative(cell, &z, &fields, relative)
}

impl ClassBlock {
    /// The block over the pattern `z` with these derivatives of its stiffness.
    fn assemble(&mut self, system: &System, rates: &Rates, z: &[f64]) {
        self.block
            .assemble_beside(system, &rates.forces, rates.stress, z);
    }

    /// The softest modes over all waves of the mesh, from those of the block as assembled last.
    fn among_all(
        &self,
        cell: &mut Mechanics,
        fields: &Fields,
        z: &[f64],
        count: usize,
        [relative, absolute, stiffness]: [f64; 3],
    ) -> EigenPairs {
        let Self { block, all, .. } = self;
        let unfolding = self.unfolding.as_ref().expect("made with the cell");
        let unit = cell.system.stiffness_unit();
        let limits = EigenLimits {
            pairs: count,
            least: 1,
            most: ITERATIONS,
            relative,
            absolute: absolute * unit,
        };
        let longer = |mode: Vec<f64>| {
            let mut padded = vec![0.0; all.size() - mode.len()];
            padded.extend(mode);
            padded
        };
        let start = block
            .lowest(count)
            .vectors
            .into_iter()
            .map(longer)
            .collect();
        let mut image = vec![0.0; cell.system.dimension()];
        let cancel = cell.cancel.clone();
        smallest(
            |x, out| {
                cell.hessian(fields, &unfolding.unfolded(x), &mut image);
                out.copy_from_slice(&unfolding.folded(&image));
            },
            start,
            all.sliding(z).as_slice(),
            |r, out| out.copy_from_slice(&block.positive_among(all, r, stiffness)),
            limits,
            &cancel,
        )
    }
}

/// The fields of the whole cell. No transform.
fn unfolded(mechanics: &Mechanics, fields: &Fields) -> Fields {
    let of = |field| mechanics.system.unfolded(field);
    Fields {
        gap: of(&fields.gap),
        traction: of(&fields.traction),
        stiffness: of(&fields.stiffness),
    }
}
