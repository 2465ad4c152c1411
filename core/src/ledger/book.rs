//! Writing the ledger: from what participants reported to one record a window.

use serde::{Deserialize, Serialize};

use super::{InterfaceRecord, SolverRecord, WindowRecord};
use crate::boundary::{Vec3, Wrench, add, norm, scale, sub};
use crate::control::{Done, ReadyInfo};
use crate::plan::{Interface, InterfaceId, InterfaceKind, Plan};
use crate::plugin::{BodyState, Report, SolverScene};
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
    underway: Vec<(Vec3, f64)>,
    scale: f64,
    angular_scale: f64,
}

impl Ledger {
    /// Opens the ledger with the states at t = 0.
    pub fn open(plan: &Plan, scenes: &[SolverScene], ready: &[&ReadyInfo]) -> Self {
        let links = (0..plan.interfaces.len()).map(|i| links_of(scenes, i as InterfaceId)).collect();
        let mut ledger = Self {
            previous: ready.iter().map(|r| momentum(&r.report.bodies)).collect(),
            links,
            stored: Vec::new(),
            underway: vec![Default::default(); plan.interfaces.len()],
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
        let solvers = (0..dones.len()).map(|i| self.solver(plan, i, &dones[i])).collect::<Vec<_>>();
        let interfaces: Vec<InterfaceRecord> =
            (0..plan.interfaces.len()).map(|i| self.interface(plan, i, dones, &reports)).collect();
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
            momentum: now.linear,
            closure: relative(norm(open), self.scale),
            angular_closure: relative(norm(angular), self.angular_scale),
        }
    }

    fn interface(&mut self, plan: &Plan, index: usize, dones: &[Done], reports: &[&Report]) -> InterfaceRecord {
        let id = index as InterfaceId;
        let interface = &plan.interfaces[index];
        let (a, b) = (usize::from(interface.a.participant), usize::from(interface.b.participant));
        let own =
            |side: usize| reports[side].interfaces.iter().find(|i| i.interface == id).copied().unwrap_or_default();
        let (seen_a, seen_b) = (own(a), own(b));
        let listed = |list: &[(InterfaceId, Vec3, f64)]| list.iter().find(|(i, ..)| *i == id).map(|&(_, j, g)| (j, g));
        let (given, received, gross) = if interface.carries_impulses() {
            let sent = listed(&dones[a].sent).unwrap_or_default();
            let late = std::mem::replace(&mut self.underway[index], sent);
            let (given, gross) = if interface.scheme == Scheme::Parallel { late } else { sent };
            let (applied, _) = listed(&dones[b].applied).unwrap_or_default();
            (given, applied, gross)
        } else {
            (scale(seen_a.received.linear, -1.0), seen_b.received.linear, seen_a.gross.max(seen_b.gross))
        };
        let stored_j = self.stored_energy(plan, index, reports);
        InterfaceRecord {
            given,
            received,
            gross,
            transfer_defect: norm(sub(given, received)),
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
