//! The axes of stress against u0: the scene's, or fitted to the data, but never moved by data.

use super::ViewState;
use crate::plot::curve::Curve;
use crate::ui::scene_edit;

impl ViewState {
    /// Fits the plot's axes to the data, or back to the scene.
    pub fn fit_axes(&mut self, to_data: bool) {
        let kept = self.kept.iter().flat_map(|kept| kept.lines.iter().flatten().copied());
        let points: Vec<[f64; 2]> = self.curve.points().chain(self.ghosts.iter().flat_map(Curve::points)).chain(kept).collect();
        let Some(&first) = points.first().filter(|_| to_data) else {
            self.fit = None;
            return;
        };
        let (mut low, mut high) = (first, first);
        for p in points {
            for k in 0..2 {
                low[k] = low[k].min(p[k]);
                high[k] = high[k].max(p[k]);
            }
        }
        for k in 0..2 {
            let margin = 0.06 * (high[k] - low[k]).max(1e-3);
            low[k] -= margin;
            high[k] += margin;
        }
        self.fit = Some((low, high));
    }

    /// Axes of the plot: (lower left, upper right) in u0/rho and stress/sigma_max.
    pub fn axes(&self) -> ([f64; 2], [f64; 2]) {
        if let Some(fit) = self.fit {
            return fit;
        }
        let (low, high) = scene_edit::stress_scale(&self.scene, &self.model);
        let (left, right) = (self.limits.0 / self.rho(), self.limits.1 / self.rho());
        let margin = 0.03 * (right - left);
        ([left - margin, low], [right + margin, high])
    }

    /// True if recorded data lie outside the axes.
    pub fn data_leave_view(&self) -> bool {
        let (low, high) = self.axes();
        let out = |p: [f64; 2]| (0..2).any(|k| p[k] < low[k] || p[k] > high[k]);
        self.curve.pieces.last().and_then(|piece| piece.points.last()).is_some_and(|&p| out(p))
            || self.curve.pieces.iter().any(|piece| piece.points.first().is_some_and(|&p| out(p)))
    }
}
