//! The diagram of branches: followed while somebody looks at it, and the state at one of its points.

use super::ViewState;
use crate::follow::diagram::{Diagram, Kind};
use crate::physics::law::Law;
use crate::plot::diagram_panel::diagram_panel;
use crate::plot::panel::Panel;
use crate::scene::Scene;
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
    /// The point (branch, place) whose state map and profile show, until the surface moves.
    pub at: Option<[usize; 2]>,
}

/// A diagram with the law that scales it.
#[derive(Clone, Debug)]
pub struct Shown {
    /// Whose.
    scene: Arc<Scene>,
    /// The branches.
    pub diagram: Arc<Diagram>,
    /// The law.
    pub law: Law,
    /// As it is drawn.
    pub panel: Panel,
}

impl Branches {
    /// The diagram, unless it is that of the scene before an edit.
    pub fn of(&self, scene: &Arc<Scene>) -> Option<&Shown> {
        self.shown
            .as_ref()
            .filter(|shown| Arc::ptr_eq(&shown.scene, scene))
    }

    /// Drops what is computed of a scene that was edited.
    pub fn restart(&mut self) {
        (self.job, self.missing, self.at) = (None, None, None);
    }

    /// Takes in what the job has found of this scene and law.
    pub(super) fn poll(&mut self, scene: &Arc<Scene>, law: Law) {
        let Some(job) = &mut self.job else { return };
        let end = job.poll();
        if let Some(diagram) = job.so_far.take() {
            self.at = None;
            self.shown = Some(Shown {
                scene: scene.clone(),
                panel: diagram_panel(&diagram, &law),
                diagram,
                law,
            });
        }
        if let Some(Err(why)) = end {
            self.missing = Some(why);
        }
    }
}

impl Shown {
    /// A point in words: what it is, and along how many modes it is unstable.
    pub fn words(&self, [branch, point]: [usize; 2]) -> Option<String> {
        let branch = self.diagram.branches.get(branch)?;
        let point = branch.points.get(point)?;
        let [before, after] = point.index;
        let softness = match before.min(after) {
            _ if point.kind == Kind::Fold => "a fold: its own mode has no stiffness".to_owned(),
            _ if point.kind == Kind::Bifurcation => "a bifurcation: other states leave".to_owned(),
            0 => "stable".to_owned(),
            1 => "unstable along one mode: a pass between two valleys".to_owned(),
            many => format!("unstable along {many} modes"),
        };
        Some(format!(
            "Map: {} on \"{}\" at {:.3} ρ, {softness}",
            point.pattern,
            branch.name,
            point.state.mean_displacement / self.law.range
        ))
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
    pub fn show_branch_point(&mut self, which: [usize; 2]) {
        let branches = self
            .branches
            .shown
            .as_ref()
            .map(|shown| &shown.diagram.branches);
        let Some(branch) = branches.and_then(|branches| branches.get(which[0])) else {
            return;
        };
        let Some(point) = branch.points.get(which[1]) else {
            return;
        };
        let state = &point.state;
        self.frame = Some(Arc::new(Frame {
            control: self.run.actual,
            mean_displacement: state.mean_displacement,
            stress: state.stress,
            gap: Arc::new(branch.gap(point)),
            soft_mode: None,
            relaxing: false,
            state: None,
        }));
        self.branches.at = Some(which);
    }
}
