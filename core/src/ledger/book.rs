//! Writing the ledger: from what participants reported to one record a window.

use serde::{Deserialize, Serialize};

use super::{InterfaceRecord, SolverRecord, WindowRecord};
use crate::boundary::{Vec3, Wrench, add, norm, scale, sub};
use crate::control::{Done, ReadyInfo};
use crate::plan::{Interface, InterfaceId, InterfaceKind, Plan};
use crate::plugin::{BodyState, InterfaceReport, Report, SolverScene};
use crate::scene::{Link, Scheme};

/// Keeps what a record is compared with.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ledger {
    previous: Vec<Wrench>,
    /// Comes from the scene, also where a ledger is reopened.
    #[serde(skip)]
    links: Vec<Vec<Link>>,
    stored: Vec<f64>,
    /// Impulses of the last window, by interface: in the parallel scheme they arrive one window later.
    underway: Vec<Underway>,
    scale: f64,
    angular_scale: f64,
}

/// Impulses on their way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Underway {
    /// Sum \[N s\].
    sum: Vec3,
    /// Sum of magnitudes \[N s\].
    gross: f64,
    /// Their moment about the world origin, as the resolver's books have it \[N m s\].
    moment: Vec3,
}

impl Ledger {
    /// Opens the ledger with the states at t = 0.
    pub fn open(plan: &Plan, scenes: &[SolverScene], ready: &[&ReadyInfo]) -> Self {
        let links = (0..plan.interfaces.len()).map(|i| links_of(scenes, i as InterfaceId)).collect();
        let mut ledger = Self {
            previous: ready.iter().map(|r| momentum(&r.report.bodies)).collect(),
            links,
            stored: Vec::new(),
            underway: vec![Underway::default(); plan.interfaces.len()],
            scale: 0.0,
            angular_scale: 0.0,
        };
        let reports: Vec<&Report> = ready.iter().map(|r| &r.report).collect();
        ledger.widen(&reports);
        ledger.stored = (0..plan.interfaces.len()).map(|i| ledger.stored_energy(plan, i, &reports)).collect();
        ledger
    }

    /// Goes on with a ledger that was stored; `None` where it is of another plan.
    pub(crate) fn reopen(self, plan: &Plan, scenes: &[SolverScene]) -> Option<Self> {
        let interfaces = plan.interfaces.len();
        let fits = self.previous.len() >= plan.solver_count()
            && self.underway.len() == interfaces
            && self.stored.len() == interfaces;
        let links = (0..interfaces).map(|i| links_of(scenes, i as InterfaceId)).collect();
        fits.then_some(Self { links, ..self })
    }

    /// Writes one window. `dones` is in participant order.
    pub fn record(&mut self, plan: &Plan, window: u64, state_hash: u128, dones: &[Done]) -> WindowRecord {
        let dones = &dones[..plan.solver_count().min(dones.len())];
        let reports: Vec<&Report> = dones.iter().map(|d| &d.report).collect();
        self.widen(&reports);
        let mut solvers = (0..dones.len()).map(|i| self.solver(plan, i, &dones[i])).collect::<Vec<_>>();
        let mut interfaces = Vec::with_capacity(plan.interfaces.len());
        for (index, interface) in plan.interfaces.iter().enumerate() {
            let moments = self.moments(plan, interface, index, dones, &reports);
            for (side, unbooked) in [&interface.a, &interface.b].into_iter().zip(moments.unbooked) {
                solvers[usize::from(side.participant)].moment_closure += relative(unbooked, self.angular_scale);
            }
            interfaces.push(self.interface(plan, index, dones, &reports, moments.defect));
        }
        self.previous = reports.iter().map(|r| momentum(&r.bodies)).collect();
        self.stored = interfaces.iter().map(|i| i.stored_j).collect();
        let inside: f64 = solvers.iter().map(|s| s.kinetic_j + s.potential_j).sum();
        WindowRecord {
            window,
            end_s: plan.clock.seconds(plan.clock.start_of(window + 1)),
            state_hash,
            total_energy_j: inside + self.stored.iter().sum::<f64>(),
            solvers,
            interfaces,
        }
    }

    /// Raises the scales against which defects are judged: the run's largest Σ m|v|, and the largest of |L| and
    /// Σ m|v| |x|.
    fn widen(&mut self, reports: &[&Report]) {
        let bodies = || reports.iter().flat_map(|r| &r.bodies);
        let gross: f64 = bodies().map(|b| b.gross_momentum).sum();
        let lever: f64 = bodies().map(|b| b.gross_momentum * norm(b.position_m) + norm(b.momentum.angular)).sum();
        self.scale = self.scale.max(gross);
        self.angular_scale = self.angular_scale.max(lever);
    }

    fn solver(&self, plan: &Plan, index: usize, done: &Done) -> SolverRecord {
        let now = momentum(&done.report.bodies);
        let change = now.minus(self.previous[index]).minus(done.report.external);
        // Linear: impulses as they crossed, not as the solver says it took them. Angular: as the solver says, because
        // the lever arm of an impulse spread over substeps is known only there.
        let mut open = change.linear;
        for &(_, sum, _) in &done.applied {
            open = sub(open, sum);
        }
        for &(_, sum, _) in &done.sent {
            open = add(open, sum);
        }
        let mut angular = change.angular;
        for own in &done.report.interfaces {
            angular = sub(angular, own.received.angular);
            let crossed = plan.interfaces.get(usize::from(own.interface)).is_some_and(Interface::carries_impulses);
            if !crossed {
                open = sub(open, own.received.linear);
            }
        }
        SolverRecord {
            kinetic_j: done.report.energy.kinetic_j,
            potential_j: done.report.energy.potential_j,
            dissipated_j: done.report.energy.dissipated_j,
            supplied_j: done.report.supplied_j,
            momentum: now.linear,
            closure: relative(norm(open), self.scale),
            angular_closure: relative(norm(angular), self.angular_scale),
            moment_closure: 0.0,
        }
    }

    /// Compares the moments in the books of both sides with those that the responder's host computed. In the parallel
    /// scheme the resolver's word is of the window before.
    ///
    /// A wrench on a rigid body has room for every moment: one that the resolver lost and did not send is a mistake in
    /// its books. Impulses on samples act where the samples are, also those that the resolver computed a little beside
    /// them (the friction of a particle of liquid, the drag of a cell of gas): their couple is lost in the crossing.
    fn moments(
        &self,
        plan: &Plan,
        interface: &Interface,
        index: usize,
        dones: &[Done],
        reports: &[&Report],
    ) -> Moments {
        let id = index as InterfaceId;
        let b = usize::from(interface.b.participant);
        let Some(crossed) = dones[b].moments.iter().find(|m| m.interface == id) else { return Moments::default() };
        let gave = if interface.scheme == Scheme::Parallel {
            self.underway[index].moment
        } else {
            seen_by(reports, usize::from(interface.a.participant), id).received.angular
        };
        let got = seen_by(reports, b, id).received.angular;
        // No less than nothing, and what is no number stays none.
        let beyond =
            |difference: Vec3, reach: f64| if norm(difference) <= reach { 0.0 } else { norm(difference) - reach };
        let lag = norm(sub(crossed.given, crossed.applied));
        let elsewhere = beyond(add(crossed.given, gave), crossed.given_reach);
        let unbooked = beyond(sub(crossed.applied, got), crossed.applied_reach);
        if plan.shows_rigid(interface) {
            Moments { defect: lag, unbooked: [elsewhere, unbooked] }
        } else {
            Moments { defect: lag + elsewhere, unbooked: [0.0, unbooked] }
        }
    }

    fn interface(
        &mut self,
        plan: &Plan,
        index: usize,
        dones: &[Done],
        reports: &[&Report],
        moment_defect: f64,
    ) -> InterfaceRecord {
        let id = index as InterfaceId;
        let interface = &plan.interfaces[index];
        let (a, b) = (usize::from(interface.a.participant), usize::from(interface.b.participant));
        let (seen_a, seen_b) = (seen_by(reports, a, id), seen_by(reports, b, id));
        let listed = |list: &[(InterfaceId, Vec3, f64)]| list.iter().find(|(i, ..)| *i == id).map(|&(_, j, g)| (j, g));
        let (given, received, gross) = if interface.carries_impulses() {
            let (sum, gross) = listed(&dones[a].sent).unwrap_or_default();
            let sent = Underway { sum, gross, moment: seen_a.received.angular };
            let late = std::mem::replace(&mut self.underway[index], sent);
            let given = if interface.scheme == Scheme::Parallel { late } else { sent };
            let (applied, _) = listed(&dones[b].applied).unwrap_or_default();
            (given.sum, applied, given.gross)
        } else {
            (scale(seen_a.received.linear, -1.0), seen_b.received.linear, seen_a.gross.max(seen_b.gross))
        };
        let stored_j = self.stored_energy(plan, index, reports);
        InterfaceRecord {
            given,
            received,
            gross,
            transfer_defect: norm(sub(given, received)),
            moment_defect,
            work_defect: seen_a.work_j + seen_b.work_j + stored_j - self.stored.get(index).copied().unwrap_or(stored_j),
            residual: seen_a.residual.max(seen_b.residual),
            stored_j,
        }
    }

    /// Energy of the springs of a link interface, both ends where they really are: `½ k |x_a − x_b − rest|²` \[J\].
    fn stored_energy(&self, plan: &Plan, index: usize, reports: &[&Report]) -> f64 {
        let interface = &plan.interfaces[index];
        if interface.kind != InterfaceKind::Link {
            return 0.0;
        }
        let place = |name: &str| {
            [&interface.a, &interface.b].into_iter().find(|s| s.body == name).and_then(|side| {
                let owner = usize::from(side.participant);
                let at = plan.participants.get(owner)?.bodies.iter().position(|b| b == name)?;
                reports.get(owner)?.bodies.get(at).map(|b| b.position_m)
            })
        };
        let energy = |link: &Link| {
            let (a, b) = (place(&link.a)?, place(link.b.as_deref()?)?);
            let stretch = sub(sub(a, b), link.rest_m);
            Some(0.5 * link.stiffness_n_m * norm(stretch) * norm(stretch))
        };
        self.links[index].iter().filter_map(energy).sum()
    }
}

/// Moments of an interface in a window, compared.
#[derive(Clone, Copy, Debug, Default)]
struct Moments {
    /// Made or lost in the crossing \[N m s\].
    defect: f64,
    /// What crossed and is not in the books of `a`, and of `b`, beyond what the way within the window explains
    /// \[N m s\].
    unbooked: [f64; 2],
}

fn seen_by(reports: &[&Report], participant: usize, id: InterfaceId) -> InterfaceReport {
    reports[participant].interfaces.iter().find(|i| i.interface == id).copied().unwrap_or_default()
}

fn links_of(scenes: &[SolverScene], id: InterfaceId) -> Vec<Link> {
    let views = scenes.iter().flat_map(|s| &s.interfaces);
    views.filter(|v| v.id == id).map(|v| v.links.clone()).next().unwrap_or_default()
}

fn momentum(bodies: &[BodyState]) -> Wrench {
    bodies.iter().fold(Wrench::default(), |sum, b| sum.plus(b.momentum))
}

/// Defect over scale; a defect without any motion to compare it with is infinite.
fn relative(defect: f64, scale: f64) -> f64 {
    if defect == 0.0 { 0.0 } else { defect / scale }
}
