//! Moments of the impulses that a solver was given, as its host computes them from what the body showed: a solver's own
//! word about them can then be judged.

use super::Joined;
use crate::boundary::{Impulses, Vec3, Wrench, add, cross, norm, sub};
use crate::control::Moment;
use crate::plan::schedule::MessageId;
use crate::plan::{BoundaryForm, Content, InterfaceId, Plan, StreamId};
use crate::wire::place;

/// The straight way between two edges of a window may be shorter than the way itself, on which the lever arm moves.
const DETOUR: f64 = 2.0;

/// Impulses of a window that were handed to the solver, where they are not zero.
#[derive(Debug)]
pub(super) struct Handed {
    interface: InterfaceId,
    /// Window in which the resolver computed them.
    made_in: u64,
    what: What,
}

#[derive(Debug)]
enum What {
    Samples(Vec<(u32, Vec3)>),
    /// About the centre of mass at the start of this window.
    Rigid(Wrench),
}

impl Handed {
    pub(super) fn new(interface: InterfaceId, made_in: u64, impulses: &Impulses) -> Self {
        let what = match impulses {
            Impulses::Samples(each) => {
                let acts = |(_, j): &(usize, &Vec3)| j.iter().any(|c| *c != 0.0);
                What::Samples(each.iter().enumerate().filter(acts).map(|(i, &j)| (i as u32, j)).collect())
            }
            Impulses::Rigid(wrench) => What::Rigid(*wrench),
        };
        Self { interface, made_in, what }
    }

    /// Their moment, once the body has shown where it is at the end of `window`; `None` where it no longer shows it.
    pub(super) fn moment(&self, joined: &Joined, window: u64) -> Option<Moment> {
        let interface = self.interface;
        let shown = joined.plan.interfaces.get(usize::from(interface))?.from_b;
        let at = |index| MessageId { stream: shown, index };
        match &self.what {
            What::Samples(each) if each.is_empty() => Some(Moment { interface, ..Moment::default() }),
            What::Samples(each) => {
                let form = form_of(&joined.plan, shown)?;
                let edges = [self.made_in, window, window + 1].map(|i| joined.outbox.chunks(at(i)));
                let [Some(then), Some(now), Some(end)] = &edges else { return None };
                let of = |chunks: &[&[u8]], sample: u32| place(form, chunks, sample as usize);
                of_samples(interface, each, |i| Some([of(then, i)?, of(now, i)?, of(end, i)?]))
            }
            What::Rigid(wrench) => {
                let (now, end) = (joined.outbox.centre(at(window))?, joined.outbox.centre(at(window + 1))?);
                let moment = add(cross(now, wrench.linear), wrench.angular);
                let reach = DETOUR * norm(wrench.linear) * norm(sub(end, now));
                // Moving the moment from one centre to the next leaves the one about the origin alone.
                Some(Moment { interface, given: moment, given_reach: 0.0, applied: moment, applied_reach: reach })
            }
        }
    }
}

/// `places`: where a sample was when the resolver saw it, at the start of this window, and at its end.
fn of_samples(
    interface: InterfaceId,
    each: &[(u32, Vec3)],
    places: impl Fn(u32) -> Option<[Vec3; 3]>,
) -> Option<Moment> {
    let mut sum = Moment { interface, ..Moment::default() };
    for &(i, j) in each {
        let [then, now, end] = places(i)?;
        sum.given = add(sum.given, cross(then, j));
        sum.applied = add(sum.applied, cross(now, j));
        let (before, within) = (norm(sub(now, then)), norm(sub(end, now)));
        sum.given_reach += DETOUR * norm(j) * (before + within);
        sum.applied_reach += DETOUR * norm(j) * within;
    }
    Some(sum)
}

fn form_of(plan: &Plan, stream: StreamId) -> Option<BoundaryForm> {
    match plan.streams.get(usize::from(stream))?.content {
        Content::Boundary { form, .. } => Some(form),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_moment_is_taken_where_the_samples_were_shown_and_its_reach_is_their_way() {
        let places = [[1.0, 0.0, 0.0], [1.5, 0.0, 0.0], [1.75, 0.0, 0.0]];
        let moment = of_samples(4, &[(1, [0.0, 2.0, 0.0])], |i| (i == 1).then_some(places)).unwrap();
        assert_eq!((moment.interface, moment.given, moment.applied), (4, [0.0, 0.0, 2.0], [0.0, 0.0, 3.0]));
        assert_eq!(of_samples(4, &[(2, [0.0, 2.0, 0.0])], |i| (i == 1).then_some(places)), None);
        assert_eq!((moment.given_reach, moment.applied_reach), (2.0 * 2.0 * 0.75, 2.0 * 2.0 * 0.25));
    }

    #[test]
    fn samples_that_nothing_touched_are_not_kept() {
        let handed = Handed::new(0, 3, &Impulses::Samples(vec![[0.0; 3], [0.0, -1.0, 0.0], [-0.0; 3]]));
        assert!(matches!(handed.what, What::Samples(each) if each == [(1, [0.0, -1.0, 0.0])]));
    }
}
