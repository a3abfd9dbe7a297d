//! A loop that stays on the plot, to compare others with: another law, another mesh, another cell.

use super::ViewState;

/// The loop that is kept.
#[derive(Clone, Debug, PartialEq)]
pub struct Kept {
    /// Title of its scene.
    pub title: String,
    /// Its pieces in (u0/rho, stress/sigma_max), each by its own law.
    pub lines: Vec<Vec<[f64; 2]>>,
}

impl ViewState {
    /// Keeps the live loop, or else the walked curve, whatever the scene becomes; or lets go of what is kept.
    pub fn toggle_kept(&mut self) {
        if self.kept.take().is_some() {
            return;
        }
        let live = self.live.iter().flat_map(|live| live.pieces.iter().map(|(_, points)| points));
        let mut lines: Vec<_> = live.cloned().collect();
        if lines.is_empty() {
            lines = self.curve.pieces.iter().map(|piece| piece.points.clone()).collect();
        }
        self.notice = Some(if lines.is_empty() {
            "no loop to keep yet: play one first".to_owned()
        } else {
            self.kept = Some(Kept { title: self.scene.title.clone(), lines });
            "this loop stays on the plot (L lets go of it)".to_owned()
        });
    }
}
