//! The cohesive law that a loop on rough ground shows from far away: mean stress against mean gap
//! (Fig. 14), and its fit by a difference of two exponentials with the uncertainty of its
//! parameters.

use crate::follow::record::{Direction, LoopRecord};
use crate::plot::scale::steps;
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::{DVector, Dyn, Matrix4, OMatrix, OVector, U4, Vector4};

/// Mean stress against mean gap on both ways, at the same gaps.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeasuredLaw {
    /// One row for each mean gap, falling.
    pub rows: Vec<Row>,
}

/// What was measured at one mean gap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Mean gap u_g = u0 - mean(h) (length).
    pub gap: f64,
    /// Mean stress on approach, positive in tension (E*).
    pub approach: f64,
    /// The same on retraction.
    pub retraction: f64,
}

impl Row {
    /// The mean of both ways.
    pub fn mean(&self) -> f64 {
        0.5 * (self.approach + self.retraction)
    }
}

impl MeasuredLaw {
    /// Reads a closed loop on ground of mean height `mean_height`, at `count` equal steps of u0
    /// from its start to its turn.
    pub fn of(record: &LoopRecord, mean_height: f64, count: usize) -> Self {
        let curve = |way: Direction| {
            let states = record.states.iter().filter(|state| state.direction == way);
            let mut points: Vec<_> = states
                .map(|state| [state.mean_displacement, state.stress])
                .collect();
            points.sort_by(|a, b| a[0].total_cmp(&b[0]));
            points
        };
        let (down, up) = (curve(Direction::Approach), curve(Direction::Retraction));
        let (Some(turn), Some(start)) = (down.first(), down.last()) else {
            return Self::default();
        };
        let row = |u0: f64| Row {
            gap: u0 - mean_height,
            approach: between(&down, u0),
            retraction: between(&up, u0),
        };
        Self {
            rows: steps(start[0], turn[0], count).map(row).collect(),
        }
    }

    /// Largest mean tensile stress (E*) and its mean gap (length).
    pub fn strongest(&self) -> (f64, f64) {
        let row = self
            .rows
            .iter()
            .max_by(|a, b| a.mean().total_cmp(&b.mean()));
        row.map_or((f64::NAN, f64::NAN), |row| (row.gap, row.mean()))
    }

    /// Mean gaps between which the law is seen: the smallest, zero at most, and one at which its
    /// tension is less than a hundredth of the largest.
    pub fn reach(&self) -> [f64; 2] {
        let least = 0.01 * self.strongest().1;
        let high = self.rows.iter().find(|row| row.mean().abs() > least);
        let low = self.rows.last().map_or(0.0, |row| row.gap.min(0.0));
        [low, high.map_or(low + 1.0, |row| row.gap)]
    }

    /// Mean gap and mean stress from the largest gap down to where the compression reaches `most`
    /// (E*).
    pub fn window(&self, most: f64) -> Vec<[f64; 2]> {
        self.rows
            .iter()
            .map(|row| [row.gap, row.mean()])
            .take_while(|[_, stress]| *stress > -most)
            .collect()
    }
}

/// The broken line through `points` of rising x.
fn between(points: &[[f64; 2]], x: f64) -> f64 {
    let i = points.partition_point(|p| p[0] < x);
    match (i.checked_sub(1).map(|i| points[i]), points.get(i)) {
        (Some(a), Some(b)) if b[0] > a[0] => a[1] + (b[1] - a[1]) * (x - a[0]) / (b[0] - a[0]),
        (_, Some(b)) => b[1],
        (Some(a), None) => a[1],
        (None, None) => f64::NAN,
    }
}

/// Traction a e^{-g/rho_a} - b e^{-g/rho_r}, positive in tension. The Morse law has rho_a = rho and
/// rho_r = rho/2.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TwoExponentials {
    /// Amplitude a of the adhesion (E*).
    pub adhesion: f64,
    /// Range rho_a of the adhesion (length).
    pub adhesion_range: f64,
    /// Amplitude b of the repulsion (E*).
    pub repulsion: f64,
    /// Range rho_r of the repulsion (length).
    pub repulsion_range: f64,
}

impl TwoExponentials {
    /// Traction at gap `g`.
    pub fn traction(&self, g: f64) -> f64 {
        self.adhesion * (-g / self.adhesion_range).exp()
            - self.repulsion * (-g / self.repulsion_range).exp()
    }

    /// Gap and value of the largest traction: where a/rho_a e^{-g/rho_a} = b/rho_r e^{-g/rho_r}.
    pub fn strongest(&self) -> (f64, f64) {
        let (a, r) = (self.adhesion_range, self.repulsion_range);
        let g = (self.repulsion * a / (self.adhesion * r)).ln() / (1.0 / r - 1.0 / a);
        (g, self.traction(g))
    }

    /// The logarithms of the parameters, which keep them positive.
    fn logarithms(&self) -> Vector4<f64> {
        Vector4::new(
            self.adhesion,
            self.adhesion_range,
            self.repulsion,
            self.repulsion_range,
        )
        .map(f64::ln)
    }

    fn of_logarithms(p: &Vector4<f64>) -> Self {
        let [adhesion, adhesion_range, repulsion, repulsion_range] = p.map(f64::exp).into();
        Self {
            adhesion,
            adhesion_range,
            repulsion,
            repulsion_range,
        }
    }

    /// Derivatives of the traction with the logarithms of the parameters.
    fn gradient(&self, g: f64) -> [f64; 4] {
        let attraction = self.adhesion * (-g / self.adhesion_range).exp();
        let repulsion = self.repulsion * (-g / self.repulsion_range).exp();
        [
            attraction,
            attraction * g / self.adhesion_range,
            -repulsion,
            -repulsion * g / self.repulsion_range,
        ]
    }
}

/// A fitted law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// Its parameters.
    pub law: TwoExponentials,
    /// Their standard deviations, from the curvature of the sum of squares and the scatter about
    /// the fit. Where the data are no random sample they only say how well the form fits.
    pub error: TwoExponentials,
    /// Root mean square deviation (E*).
    pub scatter: f64,
}

/// Least-squares fit to `points` (gap, traction), all of the same weight, by the method of
/// Levenberg and Marquardt.
///
/// # Errors
/// In words: too few points, or none of the ranges tried came near them.
pub fn fit(points: &[[f64; 2]]) -> Result<Fit, String> {
    if points.len() < 8 {
        return Err(format!(
            "{} points are too few for a fit of four parameters",
            points.len()
        ));
    }
    let start =
        scan(points).ok_or("no difference of two exponentials has the signs of these points")?;
    let problem = Deviation { points, law: start };
    let (found, report) = LevenbergMarquardt::new().minimize(problem);
    if !report.termination.was_successful() {
        return Err(format!("the fit did not settle ({:?})", report.termination));
    }
    let jacobian = found.jacobian().ok_or("the fit left the numbers")?;
    let variance = 2.0 * report.objective_function / (points.len() - 4) as f64;
    let normal: Matrix4<f64> = jacobian.tr_mul(&jacobian);
    let covariance = normal
        .try_inverse()
        .ok_or("the points do not tell the two exponentials apart")?
        * variance;
    let [a, b, c, d] = [0, 1, 2, 3].map(|i| covariance[(i, i)].sqrt());
    let law = found.law;
    let error = TwoExponentials {
        adhesion: a * law.adhesion,
        adhesion_range: b * law.adhesion_range,
        repulsion: c * law.repulsion,
        repulsion_range: d * law.repulsion_range,
    };
    Ok(Fit {
        law,
        error,
        scatter: variance.sqrt(),
    })
}

/// The best of many pairs of ranges, each with the amplitudes that suit it best.
fn scan(points: &[[f64; 2]]) -> Option<TwoExponentials> {
    const STEPS: usize = 40;
    let gaps = || points.iter().map(|p| p[0]);
    let span = gaps().fold(f64::NEG_INFINITY, f64::max) - gaps().fold(f64::INFINITY, f64::min);
    let range = |i: usize| span * 100f64.powf(i as f64 / STEPS as f64 - 1.0);
    let pairs = (1..=STEPS).flat_map(|i| (0..i).map(move |j| (range(i), range(j))));
    let tried = pairs.filter_map(|(a, r)| amplitudes(points, a, r));
    tried
        .min_by(|(x, _), (y, _)| x.total_cmp(y))
        .map(|(_, law)| law)
}

/// The sum of squares and the law of the best amplitudes for two ranges; `None` unless both are
/// positive.
fn amplitudes(
    points: &[[f64; 2]],
    adhesion_range: f64,
    repulsion_range: f64,
) -> Option<(f64, TwoExponentials)> {
    let unit = TwoExponentials {
        adhesion: 1.0,
        adhesion_range,
        repulsion: 1.0,
        repulsion_range,
    };
    let [mut aa, mut ar, mut rr, mut ay, mut ry] = [0.0; 5];
    for &[g, y] in points {
        let [a, _, r, _] = unit.gradient(g);
        [aa, ar, rr, ay, ry] = [aa + a * a, ar + a * r, rr + r * r, ay + a * y, ry + r * y];
    }
    let determinant = aa * rr - ar * ar;
    let law = TwoExponentials {
        adhesion: (ay * rr - ry * ar) / determinant,
        repulsion: (ry * aa - ay * ar) / determinant,
        ..unit
    };
    let squares = points
        .iter()
        .map(|&[g, y]| (law.traction(g) - y).powi(2))
        .sum::<f64>();
    (law.adhesion > 0.0 && law.repulsion > 0.0 && squares.is_finite()).then_some((squares, law))
}

/// The deviation of a law from points, as the fit wants it.
struct Deviation<'p> {
    points: &'p [[f64; 2]],
    law: TwoExponentials,
}

impl LeastSquaresProblem<f64, Dyn, U4> for Deviation<'_> {
    type ResidualStorage = nalgebra::VecStorage<f64, Dyn, nalgebra::U1>;
    type JacobianStorage = nalgebra::VecStorage<f64, Dyn, U4>;
    type ParameterStorage = nalgebra::ArrayStorage<f64, 4, 1>;

    fn set_params(&mut self, p: &OVector<f64, U4>) {
        self.law = TwoExponentials::of_logarithms(p);
    }

    fn params(&self) -> OVector<f64, U4> {
        self.law.logarithms()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        let deviations = DVector::from_iterator(
            self.points.len(),
            self.points.iter().map(|&[g, y]| self.law.traction(g) - y),
        );
        deviations
            .iter()
            .all(|d| d.is_finite())
            .then_some(deviations)
    }

    fn jacobian(&self) -> Option<OMatrix<f64, Dyn, U4>> {
        let rows = self.points.iter().flat_map(|&[g, _]| self.law.gradient(g));
        Some(OMatrix::<f64, Dyn, U4>::from_row_iterator(
            self.points.len(),
            rows,
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, SeedableRng};
    use rand_pcg::Pcg64;

    const LAW: TwoExponentials = TwoExponentials {
        adhesion: 0.09,
        adhesion_range: 0.8,
        repulsion: 0.6,
        repulsion_range: 0.2,
    };

    #[test]
    fn the_derivatives_are_those_of_finite_differences() {
        for g in [-0.3, 0.2, 1.0, 4.0] {
            for (i, exact) in LAW.gradient(g).into_iter().enumerate() {
                let moved = |step: f64| {
                    let mut p = LAW.logarithms();
                    p[i] += step;
                    TwoExponentials::of_logarithms(&p).traction(g)
                };
                let difference = (moved(1e-5) - moved(-1e-5)) / 2e-5;
                assert!(
                    (difference - exact).abs() < 1e-8 * (1.0 + exact.abs()),
                    "{g} {i}: {difference} {exact}"
                );
            }
        }
    }

    #[test]
    fn the_largest_traction_is_the_largest() {
        let (g, most) = LAW.strongest();
        assert!((0..500).all(|i| LAW.traction(f64::from(i) * 0.01) <= most));
        assert!((LAW.traction(g) - most).abs() < 1e-15 && most > 0.0);
    }

    /// Points of the law with Gaussian noise of the given standard deviation.
    fn points(noise: f64, seed: u64) -> Vec<[f64; 2]> {
        let mut rng = Pcg64::seed_from_u64(seed);
        let mut gaussian = || (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0;
        (0..=150)
            .map(|i| 0.05 + f64::from(i) * 0.03)
            .map(|g| [g, LAW.traction(g) + noise * gaussian()])
            .collect()
    }

    #[test]
    fn exact_points_give_their_law_back() {
        let found = fit(&points(0.0, 1)).unwrap();
        let off = (found.law.logarithms() - LAW.logarithms()).amax();
        assert!(
            off < 1e-8 && found.scatter < 1e-10,
            "{off:e} {:e}",
            found.scatter
        );
    }

    #[test]
    fn noisy_points_give_it_back_within_the_stated_uncertainties() {
        let (runs, noise) = (200, 1e-3);
        let mut inside = [0; 4];
        let mut scatter = 0.0;
        for seed in 0..runs {
            let Fit {
                law,
                error,
                scatter: s,
            } = fit(&points(noise, seed)).unwrap();
            scatter += s / runs as f64;
            let parts = |l: &TwoExponentials| {
                [l.adhesion, l.adhesion_range, l.repulsion, l.repulsion_range]
            };
            for (i, ((found, right), error)) in parts(&law)
                .into_iter()
                .zip(parts(&LAW))
                .zip(parts(&error))
                .enumerate()
            {
                inside[i] += usize::from((found - right).abs() < error);
            }
        }
        // A normal variable is within one standard deviation 136.5 times of 200, give or take 6.6:
        // four of these.
        assert!(inside.iter().all(|n| (110..=163).contains(n)), "{inside:?}");
        assert!((scatter / noise - 1.0).abs() < 0.02, "{scatter}");
    }

    #[test]
    fn what_cannot_be_fitted_is_refused_in_words() {
        assert!(fit(&points(0.0, 1)[..5]).unwrap_err().contains("too few"));
        let repulsive: Vec<_> = (0..20)
            .map(|i| f64::from(i) * 0.1)
            .map(|g| [g, 1.0 + g])
            .collect();
        assert!(fit(&repulsive).is_err());
    }
}
