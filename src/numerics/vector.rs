//! Dense vectors as slices: inner products and updates, written so that the compiler vectorises
//! them.

/// Independent partial sums: enough to hide the latency of an addition in every vector width.
const LANES: usize = 8;

/// Entries of each vector that are worked on together where there are many vectors: a dozen such
/// blocks fit the first cache.
const BLOCK: usize = 256;

/// Inner product.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; LANES];
    accumulate(&mut lanes, a, b);
    let whole = a.len() - a.len() % LANES;
    let rest: f64 = a[whole..].iter().zip(&b[whole..]).map(|(x, y)| x * y).sum();
    lanes.iter().sum::<f64>() + rest
}

/// Adds the products of whole groups of entries to the partial sums.
fn accumulate(lanes: &mut [f64; LANES], a: &[f64], b: &[f64]) {
    for (x, y) in a.chunks_exact(LANES).zip(b.chunks_exact(LANES)) {
        for l in 0..LANES {
            lanes[l] += x[l] * y[l];
        }
    }
}

/// All inner products of the vectors `a` (rows) with the vectors `b` (columns): the same as by
/// [`dot`] to the last bit, in one pass over memory.
pub fn products<A: AsRef<[f64]>, B: AsRef<[f64]>>(a: &[A], b: &[B]) -> Vec<Vec<f64>> {
    let length = a.first().map_or(0, |a| a.as_ref().len());
    let whole = length - length % LANES;
    let mut lanes = vec![vec![[0.0; LANES]; b.len()]; a.len()];
    for start in (0..whole).step_by(BLOCK) {
        let range = start..(start + BLOCK).min(whole);
        for (a, lanes) in a.iter().zip(&mut lanes) {
            for (b, lanes) in b.iter().zip(lanes) {
                accumulate(
                    lanes,
                    &a.as_ref()[range.clone()],
                    &b.as_ref()[range.clone()],
                );
            }
        }
    }
    let rest = |a: &[f64], b: &[f64]| {
        a[whole..]
            .iter()
            .zip(&b[whole..])
            .map(|(x, y)| x * y)
            .sum::<f64>()
    };
    let rows = a.iter().zip(&lanes);
    rows.map(|(a, lanes)| {
        b.iter()
            .zip(lanes)
            .map(|(b, lanes)| lanes.iter().sum::<f64>() + rest(a.as_ref(), b.as_ref()))
            .collect()
    })
    .collect()
}

/// y += sum of `coefficients` x `vectors`, in one pass over memory.
pub fn add_all(y: &mut [f64], coefficients: &[f64], vectors: &[Vec<f64>]) {
    for (block, y) in y.chunks_mut(BLOCK).enumerate() {
        for (c, v) in coefficients.iter().zip(vectors) {
            add(y, *c, &v[block * BLOCK..block * BLOCK + y.len()]);
        }
    }
}

/// Euclidean norm.
pub fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// y += s x.
pub fn add(y: &mut [f64], s: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += s * x;
    }
}

/// Cubic Hermite between two ends a distance `h` apart, at a share `t` of the way (beyond them
/// too): of value and derivative at the first, and value and derivative at the second.
pub fn hermite(ends: [&[f64]; 4], h: f64, t: f64) -> Vec<f64> {
    let (t2, t3) = (t * t, t * t * t);
    let weights = [
        2.0 * t3 - 3.0 * t2 + 1.0,
        (t3 - 2.0 * t2 + t) * h,
        3.0 * t2 - 2.0 * t3,
        (t3 - t2) * h,
    ];
    let mut sum = vec![0.0; ends[0].len()];
    for (weight, end) in weights.into_iter().zip(ends) {
        add(&mut sum, weight, end);
    }
    sum
}

/// x *= s.
pub fn scale(x: &mut [f64], s: f64) {
    x.iter_mut().for_each(|x| *x *= s);
}

/// Removes from `x` its components along the orthonormal vectors `basis`.
pub fn project_out(x: &mut [f64], basis: &[Vec<f64>]) {
    if !basis.is_empty() {
        let along: Vec<f64> = products(basis, &[&*x]).iter().map(|c| -c[0]).collect();
        add_all(x, &along, basis);
    }
}

/// Orthonormalises `vectors` in order (twice-applied Gram-Schmidt), dropping those that add less
/// than `tiny` of their length.
pub fn orthonormalise(vectors: Vec<Vec<f64>>, tiny: f64) -> Vec<Vec<f64>> {
    let mut basis: Vec<Vec<f64>> = Vec::with_capacity(vectors.len());
    for mut v in vectors {
        let before = norm(&v);
        project_out(&mut v, &basis);
        project_out(&mut v, &basis);
        let after = norm(&v);
        if after > tiny * before {
            scale(&mut v, 1.0 / after);
            basis.push(v);
        }
    }
    basis
}

/// Largest absolute value; NaN if any entry is NaN (`fold(f64::max)` would swallow it).
pub fn max_abs(x: &[f64]) -> f64 {
    let mut largest = 0.0_f64;
    for &v in x {
        if v.is_nan() {
            return v;
        }
        largest = largest.max(v.abs());
    }
    largest
}
