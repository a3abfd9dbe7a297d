//! Which pattern a surface shows, by the topology of its contact set on the torus.
//!
//! The cell is periodic, so a connected piece of contact may close on itself around the cell. Its
//! closed loops generate a lattice of winding vectors (turns along x, turns along y); the rank of
//! that lattice is 0 for an island, 1 for a line in any direction (a diagonal one too), 2 for a net
//! that surrounds the non-contact. Nothing here depends on where the pattern sits.

use super::law::Law;
use ndarray::{Array2, ArrayView2};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use std::fmt;

/// The patterns of the paper, and what else a surface can be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Pattern {
    /// Uniform gap.
    Flat,
    /// An island of contact: its components wrap around the cell in no direction.
    Bulge,
    /// A line of contact: wraps in exactly one direction.
    Ridge,
    /// An island of non-contact: the contact wraps in both directions.
    Dimple,
    /// On uneven ground: some contact.
    Contact,
    /// Anything else (on uneven ground: no contact; a field with a value that is not finite).
    Other,
}

impl Pattern {
    /// Every one of them.
    pub const ALL: [Self; 6] = [
        Self::Flat,
        Self::Bulge,
        Self::Ridge,
        Self::Dimple,
        Self::Contact,
        Self::Other,
    ];

    /// The word of the tables and labels.
    pub fn word(self) -> &'static str {
        match self {
            Pattern::Flat => "flat",
            Pattern::Bulge => "bulge",
            Pattern::Ridge => "ridge",
            Pattern::Dimple => "dimple",
            Pattern::Contact => "contact",
            Pattern::Other => "other",
        }
    }

    /// What people call it: on uneven ground, which is where it occurs, the other pattern is none.
    pub fn words(self) -> &'static str {
        match self {
            Pattern::Other => "apart",
            named => named.word(),
        }
    }
}

impl fmt::Display for Pattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.word())
    }
}

/// A surface whose gap varies by less than this share of the law's range is flat.
pub const FLATNESS: f64 = 1e-4;

/// The points in contact: those whose gap is below `threshold` (both lengths). Shape of `gap`.
pub fn contact_set(gap: ArrayView2<f64>, threshold: f64) -> Array2<bool> {
    gap.mapv(|g| g < threshold)
}

/// True if on the way from one contact set of the torus to the other its edge moves by a spacing at
/// most: every point that changes has a neighbour that was on the other side before. False where
/// there was no edge.
pub fn moves_by_a_spacing(before: &Array2<bool>, after: &Array2<bool>) -> bool {
    let (ny, nx) = before.dim();
    let beside = |y: usize, x: usize| {
        let (rows, columns) = (
            [y, (y + 1) % ny, (y + ny - 1) % ny],
            [x, (x + 1) % nx, (x + nx - 1) % nx],
        );
        rows.into_iter().any(|row| {
            columns
                .into_iter()
                .any(|column| before[[row, column]] != before[[y, x]])
        })
    };
    let has_edge = before.iter().any(|&inside| inside) && !before.iter().all(|&inside| inside);
    has_edge
        && before
            .indexed_iter()
            .all(|((y, x), inside)| after[[y, x]] == *inside || beside(y, x))
}

/// Share of the cell in contact, 0 to 1: points with a gap (length) below that of the law's largest
/// traction.
pub fn contact_area(gap: ArrayView2<f64>, law: &Law) -> f64 {
    let threshold = law.contact_gap();
    gap.iter().filter(|&&g| g < threshold).count() as f64 / gap.len() as f64
}

/// The pattern of a gap field (length; rows are y; one row is a line cell) above flat or uneven
/// ground.
///
/// On flat ground an uneven surface that lies wholly on one side of the law's contact gap (a faint
/// bulge near the fold where it flattens, a dimple about to close) is cut halfway between its
/// lowest and highest gap instead, so that its shape still decides. Of several pieces of contact
/// the one that wraps in most directions decides.
pub fn classify(gap: ArrayView2<f64>, law: &Law, flat_ground: bool) -> Pattern {
    let Some((low, high)) = extent(&gap) else {
        return Pattern::Other;
    };
    let contact_gap = law.contact_gap();
    if !flat_ground {
        return if low < contact_gap {
            Pattern::Contact
        } else {
            Pattern::Other
        };
    }
    if high - low < FLATNESS * law.range {
        return Pattern::Flat;
    }
    let one_sided = low >= contact_gap || high < contact_gap;
    let threshold = if one_sided {
        0.5 * (low + high)
    } else {
        contact_gap
    };
    if gap.nrows() == 1 {
        // Uniform along y: whatever is in contact wraps around y, and the rest of the row is not in
        // contact.
        return Pattern::Ridge;
    }
    match rank(gap, threshold) {
        0 => Pattern::Bulge,
        1 => Pattern::Ridge,
        _ => Pattern::Dimple,
    }
}

/// Smallest and largest value; `None` for an empty field and where a value is not finite.
fn extent(gap: &ArrayView2<f64>) -> Option<(f64, f64)> {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    let mut finite = true;
    for &g in gap {
        // `min` and `max` would swallow a NaN.
        finite &= g.is_finite();
        low = low.min(g);
        high = high.max(g);
    }
    (finite && low <= high).then_some((low, high))
}

/// Turns around the cell along x and along y.
type Turns = [i64; 2];

/// The largest rank, 0 to 2, of the winding lattices of the components of {gap < threshold}; 0 if
/// nothing is below.
///
/// Components are joined over the four nearest neighbours on the torus. The work is done on runs
/// (contiguous stretches of a row), of which there are few, so that the cost is one pass over the
/// field.
fn rank(gap: ArrayView2<f64>, threshold: f64) -> u8 {
    let (ny, nx) = gap.dim();
    let mut runs: Vec<(usize, usize)> = Vec::new();
    let mut rows = Vec::with_capacity(ny + 1);
    rows.push(0);
    for row in gap.rows() {
        let mut start = None;
        for (i, &g) in row.iter().enumerate() {
            match (start, g < threshold) {
                (None, true) => start = Some(i),
                (Some(s), false) => {
                    runs.push((s, i));
                    start = None;
                }
                _ => {}
            }
        }
        runs.extend(start.map(|s| (s, nx)));
        rows.push(runs.len());
    }
    let mut forest = Forest::new(runs.len());
    for j in 0..ny {
        let (first, end) = (rows[j], rows[j + 1]);
        if end > first && runs[first].0 == 0 && runs[end - 1].1 == nx {
            forest.join(end - 1, first, [1, 0]);
        }
        let (below, turns) = if j + 1 < ny {
            (j + 1, [0, 0])
        } else {
            (0, [0, 1])
        };
        join_rows(
            &mut forest,
            &runs,
            (first, end),
            (rows[below], rows[below + 1]),
            turns,
        );
    }
    // Over roots and former roots alike: a rank once reached stays.
    forest.trees.iter().map(|tree| tree.rank).max().unwrap_or(0)
}

/// Joins the overlapping runs of two neighbouring rows, given as index ranges into `runs`; both are
/// sorted, so one sweep does.
fn join_rows(
    forest: &mut Forest,
    runs: &[(usize, usize)],
    upper: (usize, usize),
    lower: (usize, usize),
    turns: Turns,
) {
    let (mut a, mut b) = (upper.0, lower.0);
    while a < upper.1 && b < lower.1 {
        if runs[a].0.max(runs[b].0) < runs[a].1.min(runs[b].1) {
            forest.join(a, b, turns);
        }
        if runs[a].1 < runs[b].1 {
            a += 1;
        } else {
            b += 1;
        }
    }
}

/// One node of the union-find forest.
#[derive(Clone, Copy)]
struct Tree {
    parent: usize,
    /// Copy of the cell in which this node lies, relative to its parent's, when the component is
    /// unrolled into the plane.
    offset: Turns,
    size: usize,
    /// Rank of the loops found so far, and the latest independent one of them; kept up to date at
    /// the root only.
    rank: u8,
    generator: Turns,
}

/// Union-find whose links remember how often they cross the cell's edge.
struct Forest {
    trees: Vec<Tree>,
}

impl Forest {
    fn new(nodes: usize) -> Self {
        let tree = |parent| Tree {
            parent,
            offset: [0, 0],
            size: 1,
            rank: 0,
            generator: [0, 0],
        };
        Self {
            trees: (0..nodes).map(tree).collect(),
        }
    }

    /// Root of a node and the node's offset from it. Halves the path on the way.
    fn find(&mut self, mut node: usize) -> (usize, Turns) {
        let mut total = [0, 0];
        while self.trees[node].parent != node {
            let parent = self.trees[node].parent;
            let above = self.trees[parent];
            let tree = &mut self.trees[node];
            // A root's own offset is zero, so skipping over it is harmless.
            tree.parent = above.parent;
            tree.offset = add(tree.offset, above.offset);
            total = add(total, tree.offset);
            node = tree.parent;
        }
        (node, total)
    }

    /// Notes that `b` touches `a` when the cell's copy of `b` is `turns` away from that of `a`.
    fn join(&mut self, a: usize, b: usize, turns: Turns) {
        let ((root_a, at_a), (root_b, at_b)) = (self.find(a), self.find(b));
        // Going from root a over the link to root b ends in this copy of the cell.
        let way = sub(add(at_a, turns), at_b);
        if root_a == root_b {
            self.note_loop(root_a, way);
            return;
        }
        let (keep, drop, offset) = if self.trees[root_a].size >= self.trees[root_b].size {
            (root_a, root_b, way)
        } else {
            (root_b, root_a, sub([0, 0], way))
        };
        let dropped = self.trees[drop];
        self.trees[drop] = Tree {
            parent: keep,
            offset,
            ..dropped
        };
        self.trees[keep].size += dropped.size;
        self.note_loop(keep, dropped.generator);
    }

    /// Adds the winding of a closed loop to the lattice of a root; zero adds nothing.
    fn note_loop(&mut self, root: usize, way: Turns) {
        let tree = &mut self.trees[root];
        let independent = match tree.rank {
            0 => way != [0, 0],
            1 => tree.generator[0] * way[1] != tree.generator[1] * way[0],
            _ => false,
        };
        if independent {
            tree.rank += 1;
            tree.generator = way;
        }
    }
}

fn add(a: Turns, b: Turns) -> Turns {
    [a[0] + b[0], a[1] + b[1]]
}

fn sub(a: Turns, b: Turns) -> Turns {
    [a[0] - b[0], a[1] - b[1]]
}

/// What stands alone in a field, and so in the middle of its picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Island {
    /// The contact.
    Contact,
    /// The hole in it.
    Hole,
}

impl Island {
    /// The smaller part of a field, of contact where the gap is below `contact_gap`.
    pub fn of(gap: &Array2<f64>, contact_gap: f64) -> Self {
        if 2 * gap.iter().filter(|&&g| g < contact_gap).count() > gap.len() {
            Self::Hole
        } else {
            Self::Contact
        }
    }

    /// 1 where the island has the largest gap, -1 where it has the smallest.
    pub fn sign(self) -> f64 {
        match self {
            Self::Contact => -1.0,
            Self::Hole => 1.0,
        }
    }
}

/// The roll (rows, columns) that brings the island to the middle of the picture, by the phase of
/// the first harmonic.
pub fn shift_to_middle(gap: &Array2<f64>, island: Island) -> (usize, usize) {
    let (ny, nx) = gap.dim();
    let sign = island.sign();
    let row_means = gap.rows().into_iter().map(|r| r.sum()).collect::<Vec<_>>();
    let column_means = gap
        .columns()
        .into_iter()
        .map(|c| c.sum())
        .collect::<Vec<_>>();
    let scale = gap.iter().map(|g| g.abs()).sum::<f64>();
    let shift = |sums: &[f64], n: usize| {
        let (mut re, mut im) = (0.0, 0.0);
        for (k, s) in sums.iter().enumerate() {
            let phase = TAU * k as f64 / n as f64;
            re += sign * s * phase.cos();
            im += sign * s * phase.sin();
        }
        if n < 2 || re.hypot(im) < 1e-3 * scale {
            return 0;
        }
        let peak = im.atan2(re).rem_euclid(TAU) / TAU * n as f64;
        (n as f64 / 2.0 - peak).round().rem_euclid(n as f64) as usize % n
    };
    (shift(&row_means, ny), shift(&column_means, nx))
}

/// The field moved by `dy` rows and `dx` columns around the cell.
pub fn rolled(gap: &Array2<f64>, dy: usize, dx: usize) -> Array2<f64> {
    let (ny, nx) = gap.dim();
    if (dy, dx) == (0, 0) {
        return gap.clone();
    }
    Array2::from_shape_fn((ny, nx), |(j, i)| {
        gap[((j + ny - dy) % ny, (i + nx - dx) % nx)]
    })
}
