//! Steps of u0 that are too long.

use super::common::{N, fig2, looped, visited};
use tackscope::follow::record::Direction;
use tackscope::physics::pattern::Pattern::{Bulge, Dimple, Flat, Ridge};
use tackscope::solver::Stop;
use tackscope::solver::methods::MethodKind;

#[test]
fn steps_of_a_quarter_range_skip_the_bulge_unless_the_method_locates_where_branches_end() {
    let scene = fig2(N, 0.23);
    let blind = looped(&scene, MethodKind::GfmdTuned);
    assert!(
        !visited(&blind, Direction::Retraction).contains(&Bulge),
        "{:?}",
        visited(&blind, Direction::Retraction)
    );
    for kind in [
        MethodKind::NewtonKrylov,
        MethodKind::Lbfgs,
        MethodKind::ConjugateGradients,
    ] {
        let run = looped(&scene, kind);
        assert_eq!(
            visited(&run, Direction::Approach),
            [Bulge, Ridge, Dimple, Flat],
            "{kind:?}"
        );
        assert_eq!(
            visited(&run, Direction::Retraction),
            [Dimple, Ridge, Bulge, Flat],
            "{kind:?}"
        );
        assert!(
            run.record.states.iter().all(|s| s.stop == Stop::Stable),
            "{kind:?}"
        );
    }
}

#[test]
fn steps_of_a_whole_range_lose_no_pattern_either() {
    let run = looped(&fig2(N, 0.97), MethodKind::NewtonKrylov);
    assert_eq!(
        visited(&run, Direction::Approach),
        [Bulge, Ridge, Dimple, Flat]
    );
    assert_eq!(
        visited(&run, Direction::Retraction),
        [Dimple, Ridge, Bulge, Flat]
    );
}

#[test]
fn what_a_fixed_budget_left_unfinished_is_never_called_converged() {
    let run = looped(&fig2(24, 0.2), MethodKind::Gfmd);
    let unfinished: Vec<_> = run
        .record
        .states
        .iter()
        .filter(|s| !(s.residual <= 1e-6))
        .collect();
    assert!(unfinished.len() > run.record.states.len() / 2);
    assert!(unfinished.iter().all(|s| s.stop == Stop::NotConverged));
}
