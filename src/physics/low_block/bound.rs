//! How soft a class of modes can be at most over *all* waves of the mesh, from the block of its
//! longest waves alone.

use super::{LowBlock, System};
use crate::numerics::vector::dot;

impl LowBlock {
    /// Assembles for [`LowBlock::most_below`]: over the pattern `z`, if it slides, whose sliding
    /// mode is left out. Amplitudes and means are those of gamma'' and of its square. No transform.
    pub fn bound(
        &mut self,
        system: &System,
        z: Option<&[f64]>,
        [once, twice]: [&[f64]; 2],
        [mean, mean_square]: [f64; 2],
    ) {
        let n = self.waves.len();
        self.hessian = self.multiplication(system, once, mean);
        self.joined = self.multiplication(system, twice, mean_square);
        let mut full = vec![0.0; n * n];
        for i in 0..n {
            for (j, entry) in self.hessian[i * (i + 1) / 2..][..=i].iter().enumerate() {
                (full[i * n + j], full[j * n + i]) = (*entry, *entry);
            }
        }
        for (i, row) in full.chunks_exact(n.max(1)).enumerate() {
            let joined = &mut self.joined[i * (i + 1) / 2..][..=i];
            for (entry, other) in joined.iter_mut().zip(full.chunks_exact(n.max(1))) {
                *entry -= dot(row, other);
            }
            self.hessian[i * (i + 3) / 2] += self.elastic[i];
        }
        self.slide = z.and_then(|z| self.sliding(z));
    }

    /// An upper bound of the number of eigenvalues below `shift` (E* per length) of the Hessian
    /// over *all* waves of the class, the sliding mode left out, after [`LowBlock::bound`]; `least`
    /// is the least gamma'' on the mesh (E* per length). Factorises.
    ///
    /// With A the block, C the Hessian among the waves beyond it and B what joins them, it is the
    /// number of negative eigenvalues of A - shift - B (C - shift)^-1 B^T where C > shift (E. V.
    /// Haynsworth, Linear Algebra Appl. 1, 73 (1968)). C is no less than its softest wave and the
    /// least gamma'' together, and B B^T needs no wave beyond the block: with M multiplication by
    /// gamma'' among its waves it is multiplication by the square of gamma'' less M^2.
    pub fn most_below(&mut self, least: f64, shift: f64) -> usize {
        let stiffer = self.beyond + least - shift;
        if !(stiffer > 0.0) {
            return usize::MAX;
        }
        let entries = self.hessian.iter().zip(&self.joined);
        let bounded = entries.map(|(a, bb)| a - bb / stiffer).collect();
        let exact = std::mem::replace(&mut self.hessian, bounded);
        let most = self.negative_below(shift);
        self.hessian = exact;
        most
    }
}
