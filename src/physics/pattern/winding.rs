//! Connected components on a torus, with the windings of their closed loops.

use ndarray::ArrayView2;

/// Turns around the cell along x and along y.
type Turns = [i64; 2];

/// The largest rank, 0 to 2, of the winding lattices of the components of {gap < threshold}; 0 if
/// nothing is below.
///
/// Components are joined over the four nearest neighbours on the torus. The work is done on runs
/// (contiguous stretches of a row), of which there are few, so that the cost is one pass over the
/// field.
pub(super) fn rank(gap: ArrayView2<f64>, threshold: f64) -> u8 {
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
