//! The chart's reference on lines and over tips, against second ways to the same loop.

use crate::loops::preset;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::PI;
use tackscope::numerics::threads::Cancel;
use tackscope::physics::theory::flat_limits;
use tackscope::scene::{Points, Range, Scene, Strategy};
use tackscope::solver::sector::{SHARP, Sector, Side};
use tackscope::study::chart::{Effort, News, Point, Reference, measure, run};

/// Ridges of a Morse law of range 1 as sums of cosines, with every derivative written out.
struct Ridges {
    gamma: f64,
    length: f64,
    /// Waves (rows) at the points (columns).
    waves: DMatrix<f64>,
    /// Their wave numbers.
    q: DVector<f64>,
}

/// Force and its derivative with u0, Hessian, energy per area, and the law's third derivative at
/// every point.
struct At {
    force: DVector<f64>,
    force_rate: DVector<f64>,
    hessian: DMatrix<f64>,
    energy: f64,
    third: DVector<f64>,
}

impl Ridges {
    fn new(gamma: f64, length: f64, n: usize) -> Self {
        let number = |k: usize| 2.0 * PI * (k + 1) as f64;
        let waves = DMatrix::from_fn(n / 2 - 1, n, |k, i| (number(k) * i as f64 / n as f64).cos());
        Self {
            gamma,
            length,
            waves,
            q: DVector::from_fn(n / 2 - 1, |k, _| number(k) / length),
        }
    }

    /// gamma (c2 e^{-2g} + c1 e^{-g}) at every point.
    fn law(&self, gap: &DVector<f64>, c2: f64, c1: f64) -> DVector<f64> {
        gap.map(|g| self.gamma * (c2 * (-2.0 * g).exp() + c1 * (-g).exp()))
    }

    /// W diag(d) W^T / n.
    fn between_waves(&self, d: &DVector<f64>) -> DMatrix<f64> {
        let mut scaled = self.waves.clone();
        for (mut column, d) in scaled.column_iter_mut().zip(d.iter()) {
            column *= *d;
        }
        scaled * self.waves.transpose() / d.len() as f64
    }

    fn at(&self, a: &DVector<f64>, u0: f64) -> At {
        let n = self.waves.ncols() as f64;
        let gap = self.waves.tr_mul(a).add_scalar(u0);
        let stiffness = self.law(&gap, 4.0, -2.0);
        let elastic = 0.25 * &self.q;
        let forces = elastic.component_mul(a);
        At {
            energy: 0.5 * forces.dot(a) + self.law(&gap, 1.0, -2.0).mean(),
            force: forces + &self.waves * self.law(&gap, -2.0, 2.0) / n,
            force_rate: &self.waves * &stiffness / n,
            hessian: DMatrix::from_diagonal(&elastic) + self.between_waves(&stiffness),
            third: self.law(&gap, -8.0, 2.0),
        }
    }

    /// The ridge at `u0` next to a guess.
    fn solved(&self, mut a: DVector<f64>, u0: f64) -> DVector<f64> {
        for _ in 0..30 {
            let At { force, hessian, .. } = self.at(&a, u0);
            if force.amax() < 1e-16 {
                break;
            }
            a -= hessian.lu().solve(&force).unwrap();
        }
        assert!(self.at(&a, u0).force.amax() < 1e-14);
        a
    }

    /// The ridge at `to` from that at 2, in short steps.
    fn ridge(&self, to: f64) -> DVector<f64> {
        let mut a = DVector::zeros(self.q.len());
        a[0] = -1.5;
        for _ in 0..1000 {
            let force = self.at(&a, 2.0).force;
            a -= force.zip_map(&self.q, |f, q| f / (0.25 * q + 0.1));
        }
        let steps = ((to - 2.0).abs() / 0.05).ceil();
        for k in 0..=steps as usize {
            a = self.solved(a, 2.0 + (to - 2.0) * k as f64 / steps);
        }
        a
    }

    /// u0 and energy of the fold next to the ridge at `near`: Newton's method for force = 0, a null
    /// vector of the Hessian, and its norm (G. Moore and A. Spence, SIAM J. Numer. Anal. 17, 567
    /// (1980)).
    fn fold(&self, near: f64) -> [f64; 2] {
        let (mut a, mut u0) = (self.ridge(near), near);
        let eigen = self.at(&a, u0).hessian.symmetric_eigen();
        let softest = eigen.eigenvectors.column(eigen.eigenvalues.imin());
        let (mut null, m) = (softest.clone_owned(), a.len());
        for _ in 0..30 {
            let at = self.at(&a, u0);
            let bent = at.third.component_mul(&self.waves.tr_mul(&null));
            let along = &self.waves * &bent / bent.len() as f64;
            let mut system = DMatrix::zeros(2 * m + 1, 2 * m + 1);
            let mut put = |at: (usize, usize), part: &DMatrix<f64>| {
                system.view_mut(at, part.shape()).copy_from(part);
            };
            put((0, 0), &at.hessian);
            put((0, m), &DMatrix::from_columns(&[at.force_rate]));
            put((m, 0), &self.between_waves(&bent));
            put((m, m), &DMatrix::from_columns(&[along]));
            put((m, m + 1), &at.hessian);
            put(
                (2 * m, m + 1),
                &DMatrix::from_rows(&[2.0 * null.transpose()]),
            );
            let mut left = DVector::zeros(2 * m + 1);
            left.rows_mut(0, m).copy_from(&at.force);
            left.rows_mut(m, m).copy_from(&(&at.hessian * &null));
            left[2 * m] = null.norm_squared() - 1.0;
            let step = system.lu().solve(&left).unwrap();
            a -= step.rows(0, m);
            u0 -= step[m];
            null -= step.rows(m + 1, m);
            if step.amax() < 1e-12 {
                return [u0, self.at(&a, u0).energy];
            }
        }
        panic!("no fold near {near}")
    }
}

/// The reference of a quick chart, whose marks are left out.
fn reference(scene: &Scene) -> Reference {
    let cancel = Cancel::default();
    let mut stop = |news: News<'_>| {
        if let News::Begun {
            reference: false, ..
        } = news
        {
            cancel.request();
        }
    };
    let chart = run(scene, Effort::Quick, &cancel, &mut stop).unwrap();
    chart.reference.unwrap()
}

#[test]
fn the_folds_of_a_ridge_are_those_of_dense_matrices() {
    let model = preset("ridge-line").model().unwrap();
    let (law, length) = (model.law, model.grid.length);
    let n = 240;
    let ridges = Ridges::new(law.surface_energy, length, n);
    let mut sector = Sector::ridge(length, n, law);
    for (near, side) in [(0.78, Side::Lower), (3.86, Side::Upper)] {
        let [u0, energy] = ridges.fold(near);
        let [before, here] = [0.05, 0.02].map(|off| {
            let u0 = u0 - side.sign() * off;
            let a = ridges.ridge(u0);
            let mut z = vec![0.0; sector.system().dimension()];
            z[1..=a.len()].copy_from_slice((a / 2.0_f64.sqrt()).as_slice());
            sector.node(u0, z, None, SHARP).unwrap().0
        });
        let (fold, _) = sector.fold(&before, &here, side).unwrap();
        let late = (fold.state.mean_displacement - u0).abs();
        assert!(late < 1e-10 * law.range, "{late:e}");
        let off = (fold.state.energy - energy).abs();
        assert!(off < 1e-10 * law.surface_energy, "{off:e}");
    }
}

#[test]
fn on_a_line_the_error_bar_holds_against_folds_of_dense_matrices() {
    let mut scene = preset("ridge-line");
    scene.cell.points = Points::Line(96);
    let reference = reference(&scene);
    let stated = reference.errors;
    assert!(
        stated.dissipated_energy < 1e-8 && stated.jumps < 1e-8,
        "{stated:?}"
    );
    let model = scene.model().unwrap();
    let ridges = Ridges::new(model.law.surface_energy, model.grid.length, 144);
    let flat_energy = |u0: f64| model.law.at(u0).energy;
    let (low, high) = flat_limits(&model.law, ridges.length).unwrap();
    let (mut loss, mut places) = (0.0, vec![high, low]);
    for (limit, near) in [(low, 0.78), (high, 3.86)] {
        loss += flat_energy(limit) - ridges.at(&ridges.ridge(limit), limit).energy;
        let [u0, energy] = ridges.fold(near);
        loss += energy - flat_energy(u0);
        places.push(u0);
    }
    let off = (reference.dissipated_energy * ridges.gamma / loss - 1.0).abs();
    assert!(
        off <= stated.dissipated_energy,
        "{off:e}, stated {stated:?}"
    );
    let jumps = &reference.finest.record.jumps;
    assert_eq!(jumps.len(), places.len());
    for jump in jumps {
        let late = places.iter().map(|u0| (jump.control - u0).abs());
        let late = late.fold(f64::INFINITY, f64::min);
        assert!(late <= stated.jumps, "{late:e}, stated {stated:?}");
    }
}

/// The walk brackets its jumps by eigenvalues, and promises how well.
#[test]
fn over_a_tip_the_error_bar_holds_against_a_walk_on_a_finer_mesh() {
    let mut scene = preset("hertz");
    scene.cell.points = Points::Square(64);
    scene.drive.step = 0.0005;
    let reference = reference(&scene);
    let (stated, point) = (reference.errors, *reference.point());
    assert!(
        stated.dissipated_energy < 1e-5 && stated.jumps < 1e-5,
        "{stated:?}"
    );
    scene.law.range = Range::Length(reference.finest.law.range);
    let finer = Point {
        model: Strategy::QUARTER,
        points: (point.points * 6 / 5).next_multiple_of(8),
        step: 0.001,
        ..point
    };
    let cancel = Cancel::default();
    let walked = measure(&scene, &finer, f64::INFINITY, &cancel, &mut |_| {}).unwrap();
    let ledger = walked.ledger().unwrap();
    let located = ledger.released_energy_error / walked.dissipated_energy();
    let off = (reference.dissipated_energy / walked.dissipated_energy() - 1.0).abs();
    assert!(
        off <= stated.dissipated_energy + located,
        "{off:e}, stated {stated:?}, located {located:e}"
    );
    let (ours, theirs) = (&reference.finest.record.jumps, &walked.record.jumps);
    assert_eq!((ours.len(), theirs.len()), (2, 2));
    for (jump, other) in ours.iter().zip(theirs) {
        let late = (jump.control - other.control).abs() / walked.law.range;
        assert!(late <= stated.jumps + 1e-5, "{late:e}, stated {stated:?}");
    }
}
