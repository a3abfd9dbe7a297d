//! Dense vectors as slices: inner products and updates, written so that the compiler vectorises them.

/// Independent partial sums: enough to hide the latency of an addition in every vector width.
const LANES: usize = 8;

/// Inner product.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; LANES];
    let (mut xs, mut ys) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    for (x, y) in xs.by_ref().zip(ys.by_ref()) {
        for l in 0..LANES {
            lanes[l] += x[l] * y[l];
        }
    }
    let rest: f64 = xs.remainder().iter().zip(ys.remainder()).map(|(x, y)| x * y).sum();
    lanes.iter().sum::<f64>() + rest
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

/// x *= s.
pub fn scale(x: &mut [f64], s: f64) {
    x.iter_mut().for_each(|x| *x *= s);
}

/// Removes from `x` its components along the orthonormal vectors `basis`.
pub fn project_out(x: &mut [f64], basis: &[Vec<f64>]) {
    for b in basis {
        let c = dot(x, b);
        add(x, -c, b);
    }
}

/// Orthonormalises `vectors` in order (twice-applied Gram-Schmidt), dropping those that add less than `tiny` of their length.
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
