//! Deliberate faults in what a solver is given, for negative controls: each must turn a gate red that is green without.

use crate::boundary::{BoundaryState, Impulses, Vec3, Wrench, add, scale};
use crate::scene::Break;

/// Factor of impulses that are too strong.
const STRONG: f64 = 1.25;

/// Impulses as the solver gets them.
pub(super) fn of_impulses(fault: Option<Break>, impulses: Impulses) -> Impulses {
    match (fault, impulses) {
        (Some(Break::DropReaction), impulses) => impulses.zeroed(),
        (Some(Break::StrongReaction), Impulses::Samples(each)) => {
            Impulses::Samples(each.into_iter().map(|j| scale(j, STRONG)).collect())
        }
        (Some(Break::StrongReaction), Impulses::Rigid(Wrench { linear, angular })) => {
            Impulses::Rigid(Wrench { linear: scale(linear, STRONG), angular: scale(angular, STRONG) })
        }
        (Some(Break::DropMoment), Impulses::Rigid(wrench)) => Impulses::Rigid(Wrench { angular: [0.0; 3], ..wrench }),
        (_, impulses) => impulses,
    }
}

/// A partner as the solver sees it. Where it was a step ago is `x - v dt` to first order, which is all that a lag of a
/// step is about: no message has to be kept for it.
pub(super) fn of_boundary(fault: Option<Break>, mut state: BoundaryState, length_s: f64) -> BoundaryState {
    if fault != Some(Break::StaleBoundary) {
        return state;
    }
    let back = |x: Vec3, v: Vec3| add(x, scale(v, -length_s));
    match &mut state {
        BoundaryState::Samples(samples) => {
            for (x, v) in samples.position.iter_mut().zip(&samples.velocity) {
                *x = back(*x, *v);
            }
        }
        BoundaryState::Proxy(record) => record.position = back(record.position, record.linear_velocity),
    }
    state
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_a_fault_nothing_is_touched() {
        let impulses = Impulses::Rigid(Wrench { linear: [1.0, 2.0, 3.0], angular: [4.0, 5.0, 6.0] });
        assert_eq!(of_impulses(None, impulses.clone()), impulses);
        let state = BoundaryState::points(&[[1.0, 0.0, 0.0]], &[[2.0, 0.0, 0.0]]);
        assert_eq!(of_boundary(Some(Break::DropReaction), state.clone(), 0.5), state);
    }

    #[test]
    fn each_fault_falsifies_what_it_says() {
        let wrench = Impulses::Rigid(Wrench { linear: [4.0, 0.0, 0.0], angular: [0.0, 8.0, 0.0] });
        let strong = of_impulses(Some(Break::StrongReaction), wrench.clone());
        assert_eq!(strong, Impulses::Rigid(Wrench { linear: [5.0, 0.0, 0.0], angular: [0.0, 10.0, 0.0] }));
        let turned = of_impulses(Some(Break::DropMoment), wrench.clone());
        assert_eq!(turned, Impulses::Rigid(Wrench { linear: [4.0, 0.0, 0.0], angular: [0.0; 3] }));
        assert_eq!(of_impulses(Some(Break::DropReaction), wrench.clone()), wrench.zeroed());
        let state = BoundaryState::points(&[[1.0, 0.0, 0.0]], &[[2.0, 0.0, 0.0]]);
        let stale = of_boundary(Some(Break::StaleBoundary), state, 0.5);
        assert_eq!(stale, BoundaryState::points(&[[0.0; 3]], &[[2.0, 0.0, 0.0]]));
    }
}
