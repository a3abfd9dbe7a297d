//! The diagram of branches: followed while somebody looks at it, and the state at one of its points.

use super::ViewState;
use crate::follow::diagram::{Diagram, Kind};
use crate::physics::law::Law;
use crate::plot::diagram_panel::diagram_panel;
use crate::plot::panel::Panel;
use crate::ui::action::Tab;
use crate::worker::SolverHandle;
use crate::worker::job::Job;
use crate::worker::protocol::Frame;
use std::sync::Arc;

/// The diagram of the scene as the window knows it.
#[derive(Debug, Default)]
pub struct Branches {
    /// The newest one; of an edited scene until its own is there.
    pub shown: Option<Shown>,
    /// The one that is being computed.
    pub job: Option<Job<Arc<Diagram>>>,
    /// Why there is none.
    pub missing: Option<String>,
}

/// A diagram with the law that scales it.
#[derive(Clone, Debug)]
pub struct Shown {
    /// The branches.
    pub diagram: Arc<Diagram>,
    /// The law.
    pub law: Law,
    /// As it is drawn.
    pub panel: Panel,
}

impl Branches {
    /// The diagram, unless it is that of the scene before an edit.
    pub fn of_scene(&self) -> Option<&Shown> {
        let known = self.job.as_ref().is_some_and(|job| !job.is_running());
        self.shown.as_ref().filter(|_| known)
    }

    /// Drops what is computed of a scene that was edited.
    pub fn restart(&mut self) {
        (self.job, self.missing) = (None, None);
    }

    /// Takes in what the job has found.
    pub(super) fn poll(&mut self, law: Law) {
        let Some(job) = &mut self.job else { return };
        let end = job.poll();
        if let Some(diagram) = job.so_far.take() {
            let panel = diagram_panel(&diagram, &law);
            self.shown = Some(Shown {
                diagram,
                law,
                panel,
            });
        }
        if let Some(Err(why)) = end {
            self.missing = Some(why);
        }
    }
}

impl ViewState {
    /// Begins to follow the branches of the scene if somebody looks at them, and they are neither
    /// there nor under way.
    pub fn follow_branches(&mut self, solver: &dyn SolverHandle) {
        let branches = &mut self.branches;
        if self.view.tab == Tab::Branches && branches.job.is_none() && branches.missing.is_none() {
            branches.job = Some(solver.diagram(self.scene.clone()));
        }
    }

    /// Stops following; what was found stays.
    pub fn stop_branches(&mut self) {
        self.branches.job.iter_mut().for_each(Job::stop);
    }

    /// Shows the state at a point of a branch in map and profile, until the surface moves.
    pub fn show_branch_point(&mut self, [branch, point]: [usize; 2]) {
        let Some(shown) = &self.branches.shown else {
            return;
        };
        let branches = &shown.diagram.branches;
        let Some(branch) = branches.get(branch) else {
            return;
        };
        let Some(point) = branch.points.get(point) else {
            return;
        };
        let state = &point.state;
        self.frame = Some(Arc::new(Frame {
            mean_displacement: state.mean_displacement,
            stress: state.stress,
            gap: Arc::new(branch.gap(point)),
            soft_mode: None,
            relaxing: false,
            state: None,
        }));
        let [before, after] = point.index;
        let softness = match before.min(after) {
            _ if point.kind == Kind::Fold => "a fold: its own mode has no stiffness".to_owned(),
            _ if point.kind == Kind::Bifurcation => "a bifurcation: other states leave".to_owned(),
            0 => "stable".to_owned(),
            1 => "unstable along one mode: a pass between two valleys".to_owned(),
            many => format!("unstable along {many} modes"),
        };
        self.messages.notice = Some(format!(
            "shown: {} on the branch \"{}\" at {:.3} ρ, {softness}",
            point.pattern,
            branch.name,
            state.mean_displacement / shown.law.range
        ));
    }
}
