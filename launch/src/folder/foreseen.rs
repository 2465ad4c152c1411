//! How far bodies on links come to be beside where the other side took them to be: what is extrapolated over a window,
//! against what arrives after it. From the states that solvers report, whatever they compute.

use cosplat_core::boundary::{Vec3, add, norm, scale, sub};
use cosplat_core::plan::{Interface, InterfaceKind, Plan};
use cosplat_core::plugin::{BodyState, Report};
use cosplat_core::scene::{MotionRule, Scheme};
use serde::{Deserialize, Serialize};

/// The links of a plan, with the last states of their bodies.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Foreseen(Vec<Link>);

/// A link between two processes.
#[derive(Debug, Serialize, Deserialize)]
struct Link {
    /// Place in the plan.
    interface: usize,
    scheme: Scheme,
    rule: MotionRule,
    window_s: f64,
    /// Process and body of sides `a` and `b`.
    sides: [[usize; 2]; 2],
    /// Place \[m\] and velocity \[m/s\] of their centres of mass at the start of the window.
    before: [Option<[Vec3; 2]>; 2],
}

impl Foreseen {
    /// Those of a plan, before anything has moved.
    pub(super) fn new(plan: &Plan) -> Self {
        let place = |side: &cosplat_core::plan::Side| {
            let process = usize::from(side.participant);
            let bodies = &plan.participants.get(process)?.bodies;
            Some([process, bodies.iter().position(|b| *b == side.body)?])
        };
        let link = |(interface, i): (usize, &Interface)| {
            let sides = [place(&i.a)?, place(&i.b)?];
            let (scheme, rule, window_s) = (i.scheme, i.rule, plan.clock.window_s());
            (i.kind == InterfaceKind::Link).then_some(Link {
                interface,
                scheme,
                rule,
                window_s,
                sides,
                before: [None; 2],
            })
        };
        Self(plan.interfaces.iter().enumerate().filter_map(link).collect())
    }

    /// Takes the states at the end of window `window`, or at t = 0: the place of each link in the plan, and how far a body
    /// of it was beside where it was foreseen \[m\].
    pub(super) fn settled<'a>(
        &mut self,
        window: Option<u64>,
        report: impl Fn(usize) -> Option<&'a Report>,
    ) -> Vec<(usize, f64)> {
        let mut found = Vec::new();
        for link in &mut self.0 {
            let state = |[process, body]: [usize; 2]| report(process)?.bodies.get(body);
            let now = link.sides.map(|side| state(side).map(|s: &BodyState| [s.position_m, s.linear_velocity_m_s]));
            if let Some(window) = window {
                let apart = [0, 1].map(|side| link.apart(window, side, now[side]));
                found.push((link.interface, apart[0].max(apart[1])));
            }
            link.before = now;
        }
        found
    }
}

impl Link {
    /// How far a body is from where its partner took it to be over a window \[m\]; 0 where nothing had to be foreseen.
    fn apart(&self, window: u64, side: usize, now: Option<[Vec3; 2]>) -> f64 {
        let (Some([before, velocity]), Some([now, _])) = (self.before[side], now) else { return 0.0 };
        // The side that goes first sees the start of the window of the other; who goes second sees its end as well.
        let (is_foreseen, part) = match self.scheme {
            Scheme::Serial => (side == 1, 1.0),
            Scheme::Parallel => (true, 1.0),
            Scheme::Alternating => (side == usize::from(window.is_multiple_of(2)), 1.0),
            // Seen in the middle of the window, and held from its start to its end.
            Scheme::Centred => (side == 1, 0.5),
        };
        let moved = match self.rule {
            MotionRule::Hold => [0.0; 3],
            MotionRule::Linear | MotionRule::Hermite => scale(velocity, self.window_s),
        };
        if is_foreseen { part * norm(sub(now, add(before, moved))) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::folder::fixtures::{done, plan};

    fn apart(scheme: Scheme, rule: MotionRule) -> (f64, f64) {
        let mut plan = plan(2);
        (plan.interfaces[0].kind, plan.interfaces[0].scheme, plan.interfaces[0].rule) =
            (InterfaceKind::Link, scheme, rule);
        let mut foreseen = Foreseen::new(&plan);
        let at = |a: u64, b: u64| {
            let mut reports = [done(a).report, done(b).report];
            reports[1].bodies[0].linear_velocity_m_s = [100.0, 0.0, 0.0];
            reports
        };
        let mut settled = |window, reports: [Report; 2]| foreseen.settled(window, |p| reports.get(p));
        assert_eq!(settled(None, at(0, 0)), []);
        // `a` goes 3 m and then 1 m, `b` 2 m and then 5 m in windows of 0.01 s.
        (settled(Some(0), at(3, 2))[0].1, settled(Some(1), at(4, 7))[0].1)
    }

    #[test]
    fn what_is_extrapolated_is_compared_with_what_arrives() {
        assert_eq!(apart(Scheme::Serial, MotionRule::Hold), (2.0, 5.0));
        assert_eq!(apart(Scheme::Parallel, MotionRule::Hold), (3.0, 5.0));
        // In even windows `a` goes first and foresees `b`; in odd ones `b` does, and `a` moves by one metre.
        assert_eq!(apart(Scheme::Alternating, MotionRule::Hold), (2.0, 1.0));
        assert_eq!(apart(Scheme::Centred, MotionRule::Hold), (1.0, 2.5));
        // With its velocity `b` is expected one metre ahead.
        assert_eq!(apart(Scheme::Serial, MotionRule::Linear), (1.0, 4.0));
    }
}
