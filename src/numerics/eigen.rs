//! Smallest eigenvalues of a symmetric operator: the pairs by block LOBPCG, and a lower bound from one
//! random vector, with a stated chance of error.
//!
//! **The bound.** The Lanczos vectors of a symmetric operator B are q_j = p_j(B) q_0 with polynomials
//! p_j that the three-term recurrence gives: beta_j p_{j+1}(t) = (t - alpha_j) p_j(t) - beta_{j-1}
//! p_{j-1}(t). Let v be a unit eigenvector with eigenvalue t and c = v.q_0. Then v.q_j = c p_j(t), and
//! as unit vectors have no product above 1, |c| <= 1/|p_j(t)|. Below all Ritz values the |p_j(t)| grow
//! without bound as j grows and as t falls, so that an eigenvalue far below the Ritz values needs a
//! start that all but misses its vector. A start drawn evenly from the sphere in d dimensions has
//! |c| < e with a chance below e sqrt(2 d/pi). This turns a chance of error into a bound, from what
//! was computed alone: no spectrum is assumed, and eigenvalues may be as degenerate as they like.
//!
//! (The bound before the fact is that of J. Kuczynski and H. Wozniakowski, SIAM J. Matrix Anal.
//! Appl. 13, 1094 (1992).) Lanczos vectors lose their orthogonality to rounding; the argument asks
//! for none. It does ask that c be well above rounding.

use super::dense::{
    add, add_all, dot, norm, orthonormalise, products, project_out, scale, symmetric_eigen,
};
use super::threads::Cancel;
use std::f64::consts::PI;

/// Approximate eigenpairs, smallest first.
#[derive(Clone, Debug, Default)]
pub struct EigenPairs {
    /// Rayleigh quotients; each is an upper bound of the eigenvalue of the same rank.
    pub values: Vec<f64>,
    /// Orthonormal vectors.
    pub vectors: Vec<Vec<f64>>,
    /// |A x - value x| of the first pair: some eigenvalue lies within it of the first value.
    pub residual: f64,
}

/// Budget of one call of [`smallest`].
#[derive(Clone, Copy, Debug)]
pub struct EigenLimits {
    /// Pairs wanted; only their residuals are iterated on. Further start vectors only widen the
    /// first subspace.
    pub pairs: usize,
    /// Iterations that are always done (unless the residual vanishes).
    pub least: usize,
    /// Iterations that are done while the first residual is above `relative` x |value|, or above
    /// `absolute`.
    pub most: usize,
    /// Goal for residual over |value|.
    pub relative: f64,
    /// A residual below this is good enough in any case.
    pub absolute: f64,
}

/// Block LOBPCG from the vectors `start`, orthogonal to the orthonormal vectors `removed`.
///
/// A. V. Knyazev, SIAM J. Sci. Comput. 23, 517 (2001), with an orthonormalised basis (robust
/// against nearly dependent vectors). `precondition` is an approximate inverse, symmetric positive
/// definite.
pub fn smallest(
    mut apply: impl FnMut(&[f64], &mut [f64]),
    start: Vec<Vec<f64>>,
    removed: &[Vec<f64>],
    precondition: impl Fn(&[f64], &mut [f64]),
    limits: EigenLimits,
    cancel: &Cancel,
) -> EigenPairs {
    let mut image = |v: &Vec<f64>| {
        let mut out = vec![0.0; v.len()];
        apply(v, &mut out);
        out
    };
    let start = start
        .into_iter()
        .map(|mut v| {
            project_out(&mut v, removed);
            v
        })
        .collect();
    let basis = orthonormalise(start, 1e-10);
    let images: Vec<_> = basis.iter().map(&mut image).collect();
    let (mut values, rotation) = rayleigh_ritz(&basis, &images);
    let pairs = limits.pairs.min(basis.len());
    let mut x = combine(&basis, &rotation, pairs);
    let mut ax = combine(&images, &rotation, pairs);
    // The subspace of the last iteration, from which the conjugate directions come, and how the
    // vectors were made of it.
    let mut last: Option<(Subspace, Vec<Vec<f64>>)> = None;
    let mut residual = f64::INFINITY;
    for iteration in 0..=limits.most {
        let error = |i: usize| {
            let mut r = ax[i].clone();
            add(&mut r, -values[i], &x[i]);
            // Images may point along removed directions; what counts is their part beside them.
            project_out(&mut r, removed);
            r
        };
        let first = (!x.is_empty()).then(|| error(0));
        residual = first.as_ref().map_or(residual, |r| norm(r));
        let good = residual
            <= (limits.relative * values.first().map_or(0.0, |v| v.abs())).max(limits.absolute);
        if cancel.requested() || iteration == limits.most || (good && iteration >= limits.least) {
            break;
        }
        let errors = first.into_iter().chain((1..x.len()).map(error));
        let steps: Vec<_> = errors
            .map(|r| {
                let mut step = vec![0.0; r.len()];
                precondition(&r, &mut step);
                project_out(&mut step, removed);
                step
            })
            .collect();
        let width = x.len();
        let conjugate = last
            .take()
            .map(|(space, rotation)| space.conjugate(&rotation, width))
            .unwrap_or_default();
        let mut space = Subspace {
            basis: x,
            images: ax,
        };
        for v in steps {
            space.add(v, None, &mut image);
        }
        for (v, av) in conjugate {
            space.add(v, Some(av), &mut image);
        }
        let rotation;
        (values, rotation) = rayleigh_ritz(&space.basis, &space.images);
        x = combine(&space.basis, &rotation, width);
        ax = combine(&space.images, &rotation, width);
        last = Some((space, rotation));
    }
    values.truncate(x.len());
    EigenPairs {
        values,
        vectors: x,
        residual,
    }
}

/// An orthonormal basis with its images under the operator.
struct Subspace {
    basis: Vec<Vec<f64>>,
    images: Vec<Vec<f64>>,
}

impl Subspace {
    /// What the first `width` Ritz vectors owe to the part outside the first `width` vectors, with
    /// its image.
    fn conjugate(&self, rotation: &[Vec<f64>], width: usize) -> Vec<(Vec<f64>, Vec<f64>)> {
        if self.basis.len() == width {
            return Vec::new();
        }
        let outside = |vectors: &[Vec<f64>]| {
            let rotation: Vec<_> = rotation.iter().map(|c| c[width..].to_vec()).collect();
            combine(&vectors[width..], &rotation, width)
        };
        outside(&self.basis)
            .into_iter()
            .zip(outside(&self.images))
            .collect()
    }

    /// Adds the part of `v` that is new, unless it is nearly nothing. A known image is carried
    /// along, which saves a product.
    fn add(
        &mut self,
        mut v: Vec<f64>,
        known: Option<Vec<f64>>,
        image: &mut impl FnMut(&Vec<f64>) -> Vec<f64>,
    ) {
        let before = norm(&v);
        let mut carried = known;
        for _twice in 0..2 {
            let along: Vec<f64> = products(&self.basis, std::slice::from_ref(&v))
                .iter()
                .map(|c| -c[0])
                .collect();
            add_all(&mut v, &along, &self.basis);
            if let Some(av) = &mut carried {
                add_all(av, &along, &self.images);
            }
        }
        let after = norm(&v);
        // A carried image loses digits to cancellation: it is dropped earlier than a fresh vector.
        let tiny = if carried.is_some() { 1e-5 } else { 1e-10 };
        if !(after > tiny * before) {
            return;
        }
        scale(&mut v, 1.0 / after);
        let av = match carried {
            Some(mut av) => {
                scale(&mut av, 1.0 / after);
                av
            }
            None => image(&v),
        };
        self.basis.push(v);
        self.images.push(av);
    }
}

/// Eigen-decomposition of the operator in the span of an orthonormal basis: values ascending, and
/// one coefficient column each.
fn rayleigh_ritz(basis: &[Vec<f64>], images: &[Vec<f64>]) -> (Vec<f64>, Vec<Vec<f64>>) {
    let a = products(basis, images);
    let symmetric = |i: usize, j: usize| 0.5 * (a[i][j] + a[j][i]);
    symmetric_eigen(
        (0..a.len())
            .map(|i| (0..a.len()).map(|j| symmetric(i, j)).collect())
            .collect(),
    )
}

fn combine(vectors: &[Vec<f64>], rotation: &[Vec<f64>], count: usize) -> Vec<Vec<f64>> {
    rotation
        .iter()
        .take(count)
        .map(|coefficients| {
            let mut sum = vec![0.0; vectors.first().map_or(0, Vec::len)];
            add_all(&mut sum, coefficients, vectors);
            sum
        })
        .collect()
}

/// What a run proved.
#[derive(Clone, Debug)]
pub struct Bound {
    /// No eigenvalue lies below, but for the chance that was asked for.
    pub lower: f64,
    /// The smallest Ritz value: an upper bound of the smallest eigenvalue.
    pub upper: f64,
    /// Products with the operator spent.
    pub products: usize,
    /// Components of the smallest Ritz vector along the Lanczos vectors.
    ritz: Vec<f64>,
}

/// Runs from `start`, drawn evenly from all directions, until it is known on which side of `level`
/// the smallest eigenvalue lies, if that is asked, or for `most` products. `chance` is the chance
/// that an eigenvalue lies below the bound all the same; far above 1e-13, where rounding begins to
/// matter.
pub fn lowest(
    mut apply: impl FnMut(&[f64], &mut [f64]),
    start: &[f64],
    chance: f64,
    most: usize,
    level: Option<f64>,
    cancel: &Cancel,
) -> Bound {
    let wanted = (chance * (PI / (2.0 * start.len() as f64)).sqrt()).recip();
    let mut chain = Chain::new(start);
    let mut bound = Bound {
        lower: f64::NEG_INFINITY,
        upper: f64::INFINITY,
        products: 0,
        ritz: Vec::new(),
    };
    let (mut ended, mut above) = (false, false);
    while bound.products < most && !cancel.requested() {
        ended = !chain.step(&mut apply);
        bound.products += 1;
        let below = level.is_some_and(|level| chain.below(level) > 0);
        above = !below && level.is_some_and(|level| chain.growth(level) >= wanted);
        if ended || below || above {
            break;
        }
    }
    if bound.products > 0 {
        bound.upper = chain.smallest_ritz();
        bound.lower = if ended {
            bound.upper
        } else {
            chain.lower(bound.upper, wanted)
        };
    }
    // The bisection stops short of the largest lower bound.
    if let Some(level) = level.filter(|_| above) {
        bound.lower = bound.lower.max(level);
    }
    bound.ritz = chain.ritz(bound.upper);
    bound
}

impl Bound {
    /// The vector of the smallest Ritz value, of norm 1, by going the same way from `start` once
    /// more.
    pub fn vector(&self, mut apply: impl FnMut(&[f64], &mut [f64]), start: &[f64]) -> Vec<f64> {
        let mut chain = Chain::new(start);
        let mut sum = vec![0.0; start.len()];
        for &share in &self.ritz {
            add(&mut sum, share, &chain.vector);
            chain.step(&mut apply);
        }
        let length = norm(&sum);
        scale(&mut sum, length.recip());
        sum
    }
}

/// The recurrence: the newest two vectors and all coefficients.
struct Chain {
    vector: Vec<f64>,
    before: Vec<f64>,
    image: Vec<f64>,
    alpha: Vec<f64>,
    beta: Vec<f64>,
}

impl Chain {
    fn new(start: &[f64]) -> Self {
        let mut vector = start.to_vec();
        scale(&mut vector, norm(start).recip());
        Self {
            before: vec![0.0; start.len()],
            image: vec![0.0; start.len()],
            vector,
            alpha: Vec::new(),
            beta: Vec::new(),
        }
    }

    /// One product; false if the vectors span an invariant space.
    fn step(&mut self, apply: &mut impl FnMut(&[f64], &mut [f64])) -> bool {
        apply(&self.vector, &mut self.image);
        let alpha = dot(&self.vector, &self.image);
        let (coupling, next) = (self.beta.last().copied().unwrap_or(0.0), &mut self.before);
        for ((next, image), vector) in next.iter_mut().zip(&self.image).zip(&self.vector) {
            *next = image - alpha * vector - coupling * *next;
        }
        let beta = norm(next);
        self.alpha.push(alpha);
        self.beta.push(beta);
        scale(next, beta.recip());
        std::mem::swap(&mut self.before, &mut self.vector);
        beta > 1e-13
            * self
                .alpha
                .iter()
                .fold(0.0, |most: f64, a| most.max(a.abs()))
    }

    /// Number of eigenvalues of the tridiagonal matrix below `t` (Sturm).
    fn below(&self, t: f64) -> usize {
        let (mut count, mut pivot) = (0, 1.0);
        for (i, a) in self.alpha.iter().enumerate() {
            let coupling = if i == 0 {
                0.0
            } else {
                self.beta[i - 1] * self.beta[i - 1]
            };
            pivot = a - t - coupling / pivot;
            if pivot == 0.0 {
                pivot = f64::MIN_POSITIVE;
            }
            count += usize::from(pivot < 0.0);
        }
        count
    }

    /// By bisection from Gershgorin's bounds.
    fn smallest_ritz(&self) -> f64 {
        let reach = |i: usize| self.beta[i] + if i == 0 { 0.0 } else { self.beta[i - 1] };
        let discs = self.alpha.iter().enumerate();
        let mut low = discs.fold(f64::INFINITY, |low: f64, (i, a)| low.min(a - reach(i)));
        let mut high = self
            .alpha
            .iter()
            .fold(f64::INFINITY, |high: f64, a| high.min(*a));
        // To rounding of the discs' reach.
        for _ in 0..54 {
            let middle = 0.5 * (low + high);
            if self.below(middle) > 0 {
                high = middle;
            } else {
                low = middle;
            }
        }
        high
    }

    /// The largest |p_j(t)|, `t` below all Ritz values.
    fn growth(&self, t: f64) -> f64 {
        let (mut before, mut now, mut largest) = (0.0, 1.0, 1.0_f64);
        for (i, (a, b)) in self.alpha.iter().zip(&self.beta).enumerate() {
            let coupling = if i == 0 { 0.0 } else { self.beta[i - 1] };
            (before, now) = (now, ((t - a) * now - coupling * before) / b);
            largest = largest.max(now.abs());
        }
        largest
    }

    /// The largest t below `ritz` at which some |p_j| reaches `wanted`: it grows as t falls.
    fn lower(&self, ritz: f64, wanted: f64) -> f64 {
        let width = self
            .beta
            .iter()
            .fold(f64::MIN_POSITIVE, |most: f64, b| most.max(*b));
        let mut step = 1e-6 * width;
        while self.growth(ritz - step) < wanted {
            step *= 2.0;
        }
        let (mut low, mut high) = (ritz - step, ritz);
        // To a thousandth of the distance that there is at most.
        for _ in 0..10 {
            let middle = 0.5 * (low + high);
            if self.growth(middle) < wanted {
                high = middle;
            } else {
                low = middle;
            }
        }
        low
    }

    /// Components of the vector of the smallest Ritz value along the Lanczos vectors, by inverse
    /// iteration from just below it, where the matrix is positive definite.
    fn ritz(&self, smallest: f64) -> Vec<f64> {
        let n = self.alpha.len();
        let shift = smallest
            - 1e-9
                * self
                    .alpha
                    .iter()
                    .fold(smallest.abs(), |most: f64, a| most.max(a.abs()));
        let mut pivots = Vec::with_capacity(n);
        for (i, a) in self.alpha.iter().enumerate() {
            let coupling = if i == 0 {
                0.0
            } else {
                self.beta[i - 1] * self.beta[i - 1] / pivots[i - 1]
            };
            pivots.push(a - shift - coupling);
        }
        let mut x = vec![1.0; n];
        for _ in 0..3 {
            for i in 1..n {
                x[i] -= self.beta[i - 1] / pivots[i - 1] * x[i - 1];
            }
            for i in (0..n).rev() {
                let known = if i + 1 < n {
                    self.beta[i] * x[i + 1]
                } else {
                    0.0
                };
                x[i] = (x[i] - known) / pivots[i];
            }
            let length = norm(&x);
            scale(&mut x, length.recip());
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_pcg::Pcg64;

    fn random(n: usize, seed: u64) -> Vec<f64> {
        let mut rng = Pcg64::seed_from_u64(seed);
        (0..n).map(|_| StandardNormal.sample(&mut rng)).collect()
    }

    /// diag(values) in a basis turned by a Householder reflection.
    fn turned(values: &[f64], seed: u64) -> impl Fn(&[f64], &mut [f64]) {
        let mut axis = random(values.len(), !seed);
        let length = norm(&axis);
        scale(&mut axis, length.recip());
        let values = values.to_vec();
        move |v, out| {
            let reflect = |x: &mut [f64]| {
                let along = dot(&axis, x);
                add(x, -2.0 * along, &axis);
            };
            out.copy_from_slice(v);
            reflect(out);
            out.iter_mut()
                .zip(&values)
                .for_each(|(o, value)| *o *= value);
            reflect(out);
        }
    }

    proptest! {
        #[test]
        fn no_eigenvalue_lies_outside_the_bounds(
            mut values in proptest::collection::vec(-1.0..10.0f64, 2..120), copies in 1usize..4, seed: u64, most in 1usize..60,
        ) {
            values.sort_by(f64::total_cmp);
            let smallest = values[0];
            values.extend(vec![smallest; copies - 1]);
            let apply = turned(&values, seed);
            let bound = lowest(&apply, &random(values.len(), seed), 1e-10, most, None, &Cancel::default());
            let rounding = 1e-12;
            prop_assert!(bound.lower <= smallest + rounding && bound.upper >= smallest - rounding, "{smallest} {bound:?}");
        }

        #[test]
        fn the_ritz_vector_has_the_ritz_value(values in proptest::collection::vec(0.1..10.0f64, 10..80), seed: u64) {
            let (apply, start) = (turned(&values, seed), random(values.len(), seed));
            let bound = lowest(&apply, &start, 1e-10, 8, None, &Cancel::default());
            let v = bound.vector(&apply, &start);
            let mut image = vec![0.0; v.len()];
            apply(&v, &mut image);
            prop_assert!((dot(&v, &image) - bound.upper).abs() < 1e-6 * bound.upper, "{} {}", dot(&v, &image), bound.upper);
        }
    }

    #[test]
    fn a_chance_of_a_tenth_is_missed_in_less_than_a_tenth_of_the_runs_and_not_by_far() {
        let values: Vec<f64> = (0..200)
            .map(|i| 1.0 + 0.02 * f64::from(i))
            .chain([0.7])
            .collect();
        let missed = |products: usize| {
            let run = |seed| {
                lowest(
                    turned(&values, 3),
                    &random(201, seed),
                    0.1,
                    products,
                    None,
                    &Cancel::default(),
                )
            };
            (0..2000).filter(|&seed| run(seed).lower > 0.7).count()
        };
        // The bound asks for |v.q_j| <= 1 alone; the vector is spread over several q_j, so that
        // fewer are missed than allowed.
        let counts = [4, 6, 8, 10].map(missed);
        assert!(counts.iter().all(|&missed| missed < 200), "{counts:?}");
        assert!(counts.iter().any(|&missed| missed > 2), "{counts:?}");
    }

    #[test]
    fn a_start_without_the_softest_vector_is_what_the_chance_is_about() {
        // Forbidden to any honest caller: the run cannot know that 0 is an eigenvalue, until its
        // rounding tells.
        let values: Vec<f64> = (0..50)
            .map(|i| {
                if i == 0 {
                    0.0
                } else {
                    1.0 + 0.02 * f64::from(i)
                }
            })
            .collect();
        let apply = turned(&values, 1);
        let mut softest = vec![0.0; 50];
        let mut axis = random(50, !1);
        let length = norm(&axis);
        scale(&mut axis, length.recip());
        softest[0] = 1.0;
        let along = axis[0];
        add(&mut softest, -2.0 * along, &axis);
        let mut start = random(50, 9);
        project_out(&mut start, &[softest]);
        let bound = lowest(&apply, &start, 1e-10, 40, Some(0.5), &Cancel::default());
        assert!(bound.lower >= 0.5, "{bound:?}");
    }
}
