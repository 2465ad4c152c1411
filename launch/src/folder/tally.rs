//! Adds up what a run reports, window by window, for its summary and verdicts.

use std::collections::BTreeMap;

use cosplat_core::boundary::{norm, sub};
use cosplat_core::control::{Done, ReadyInfo};
use cosplat_core::ledger::WindowRecord;
use cosplat_core::plan::{BoundaryForm, InterfaceKind, LeftOut, Plan};
use cosplat_core::plugin::{BodyState, count};
use cosplat_core::scene::Scene;
use serde::{Deserialize, Serialize};

use super::foreseen::Foreseen;
use super::summary::{Body, Energy, Interface, Process};
use crate::verdict::{Closure, ClosureGate, Verdict};

/// Sums and extremes over all settled windows.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Tally {
    /// Settled windows.
    pub(crate) windows: u64,
    /// End of the last settled window \[s\].
    pub(crate) simulated_s: f64,
    /// Chain hash after it.
    pub(crate) state_hash: Option<u128>,
    /// In plan order.
    pub(crate) processes: Vec<Process>,
    /// By process, in scene order.
    pub(crate) bodies: Vec<Body>,
    /// In plan order.
    pub(crate) interfaces: Vec<Interface>,
    /// Processes, link interfaces, total.
    pub(crate) energy: Vec<Energy>,
    /// By process.
    pub(crate) counters: BTreeMap<String, BTreeMap<String, u64>>,
    /// What solvers reported at set-up.
    pub(crate) left_out: Vec<LeftOut>,
    /// Number of bodies of each process.
    body_counts: Vec<usize>,
    forms: Vec<BoundaryForm>,
    closures: Vec<Closure>,
    /// Processes of the two sides of each interface.
    sides: Vec<[usize; 2]>,
    carries_impulses: Vec<bool>,
    is_link: Vec<bool>,
    foreseen: Foreseen,
}

impl Tally {
    /// Begins with nothing; `forms` tells for each process with which numbers it computes.
    pub(crate) fn new(plan: &Plan, forms: Vec<BoundaryForm>) -> Self {
        let processes = plan.solvers().iter().map(|p| Process {
            name: p.name.clone(),
            solver: p.plugin.clone(),
            threads: p.threads,
            ..Process::default()
        });
        let bodies = plan
            .participants
            .iter()
            .flat_map(|p| p.bodies.iter().map(|b| Body { name: b.clone(), solver: p.name.clone(), ..Body::default() }));
        let links = plan.interfaces.iter().filter(|i| i.kind == InterfaceKind::Link).map(|i| i.name.as_str());
        let parts = plan.solvers().iter().map(|p| p.name.as_str()).chain(links).chain(["total"]);
        Self {
            windows: 0,
            simulated_s: 0.0,
            state_hash: None,
            processes: processes.collect(),
            bodies: bodies.collect(),
            interfaces: plan.interfaces.iter().map(|i| interface(plan, i)).collect(),
            energy: parts.map(|name| Energy { name: name.into(), ..Energy::default() }).collect(),
            counters: BTreeMap::new(),
            left_out: Vec::new(),
            body_counts: plan.solvers().iter().map(|p| p.bodies.len()).collect(),
            closures: vec![Closure::default(); forms.len()],
            forms,
            sides: plan
                .interfaces
                .iter()
                .map(|i| [usize::from(i.a.participant), usize::from(i.b.participant)])
                .collect(),
            carries_impulses: plan.interfaces.iter().map(cosplat_core::plan::Interface::carries_impulses).collect(),
            is_link: plan.interfaces.iter().map(|i| i.kind == InterfaceKind::Link).collect(),
            foreseen: Foreseen::new(plan),
        }
    }

    /// Takes the states at t = 0, in plan order.
    pub(crate) fn started(&mut self, plan: &Plan, scene: &Scene, ready: &[ReadyInfo]) {
        // Whoever only records owns nothing.
        let ready = &ready[..self.body_counts.len().min(ready.len())];
        for (process, info) in ready.iter().enumerate() {
            for (i, (body, state)) in self.bodies_of(process).iter_mut().zip(&info.report.bodies).enumerate() {
                body.particles = info.particles.get(i).copied().unwrap_or_default();
                body.mass_kg = state.mass_kg;
            }
            self.left_out.extend(info.left_out.iter().cloned());
        }
        self.foreseen.settled(None, |process| ready.get(process).map(|info| &info.report));
        let own = ready.iter().map(|r| [r.report.energy.kinetic_j, r.report.energy.potential_j]);
        let links = plan.interfaces.iter().filter(|i| i.kind == InterfaceKind::Link);
        let stored = links.map(|i| [0.0, i.links.iter().map(|&l| stored_j(plan, scene, ready, l)).sum()]);
        let initial: Vec<[f64; 2]> = own.chain(stored).collect();
        let total = [0, 1].map(|of| initial.iter().map(|part| part[of]).sum());
        for (part, [kinetic_j, potential_j]) in self.energy.iter_mut().zip(initial.into_iter().chain([total])) {
            part.initial_j = Some(kinetic_j + potential_j);
            part.min_potential_j = potential_j;
        }
    }

    /// Takes a settled window.
    pub(crate) fn settled(&mut self, record: &WindowRecord, done: &[Done]) {
        self.windows = record.window + 1;
        self.simulated_s = record.end_s;
        self.state_hash = Some(record.state_hash);
        for (process, done) in done.iter().enumerate().take(self.body_counts.len()) {
            for (body, state) in self.bodies_of(process).iter_mut().zip(&done.report.bodies) {
                body.mass_kg = state.mass_kg;
                body.max_displacement_m = body.max_displacement_m.max(state.max_displacement_m);
            }
        }
        for (process, done) in self.processes.iter_mut().zip(done) {
            process.compute_s += done.times.compute_s;
            process.wait_s += done.times.wait_s;
            process.transfer_s += done.times.transfer_s;
            process.substeps += done.report.substeps;
            process.substep_bound_by.clone_from(&done.report.substep_bound_by);
            // How something ends is told also where it ends well.
            let is_told = |(name, n): &(&String, &u64)| **n > 0 || name.starts_with("final-");
            for (name, n) in done.report.counters.iter().filter(is_told) {
                count(self.counters.entry(process.name.clone()).or_default(), name, *n);
            }
        }
        self.closures(record, done);
        self.interfaces(record);
        for (i, apart) in self.foreseen.settled(Some(record.window), |p| done.get(p).map(|d| &d.report)) {
            if let Some(link) = self.interfaces.get_mut(i) {
                link.foreseen_m = larger(link.foreseen_m, apart);
            }
        }
        self.energies(record);
    }

    /// Bodies of a process.
    fn bodies_of(&mut self, process: usize) -> &mut [Body] {
        let before = self.body_counts[..process].iter().sum::<usize>();
        &mut self.bodies[before..before + self.body_counts[process]]
    }

    fn closures(&mut self, record: &WindowRecord, done: &[Done]) {
        for (i, (closure, solver)) in self.closures.iter_mut().zip(&record.solvers).enumerate() {
            let value = larger(larger(solver.closure, solver.angular_closure), solver.moment_closure);
            let substeps = done.get(i).map_or(1, |d| d.report.substeps);
            closure.add(value, ClosureGate::of(self.forms[i], substeps).window);
        }
    }

    fn interfaces(&mut self, record: &WindowRecord) {
        for (i, (sum, now)) in self.interfaces.iter_mut().zip(&record.interfaces).enumerate() {
            for axis in 0..3 {
                sum.impulse_given[axis] += now.given[axis];
                sum.impulse_received[axis] += now.received[axis];
            }
            sum.gross_impulse += now.gross;
            sum.transfer_defect += now.transfer_defect;
            sum.moment_defect += now.moment_defect;
            sum.work_defect += now.work_defect;
            sum.residual = larger(sum.residual, now.residual);
            let [a, b] = self.sides[i];
            let closure = |s: usize| self.closures.get(s).map_or(0.0, |c| c.worst);
            sum.closure = larger(closure(a), closure(b));
            let relative = if sum.transfer_defect == 0.0 { 0.0 } else { sum.transfer_defect / sum.gross_impulse };
            sum.momentum_defect = larger(relative, sum.closure);
        }
    }

    fn energies(&mut self, record: &WindowRecord) {
        let own = record.solvers.iter();
        let own = own.map(|s| [s.kinetic_j + s.potential_j, s.potential_j, s.dissipated_j, s.supplied_j]);
        let links = record.interfaces.iter().zip(&self.is_link).filter(|(_, is_link)| **is_link);
        let dissipated = record.solvers.iter().map(|s| s.dissipated_j).sum();
        let supplied = record.solvers.iter().map(|s| s.supplied_j).sum();
        let links = links.map(|(i, _)| [i.stored_j, i.stored_j, 0.0, 0.0]);
        let potential = own.clone().chain(links.clone()).map(|part| part[1]).sum();
        let total = [record.total_energy_j, potential, dissipated, supplied];
        for (part, [value, potential_j, dissipated_j, supplied_j]) in
            self.energy.iter_mut().zip(own.chain(links).chain([total]))
        {
            part.supplied_j += supplied_j;
            part.max_supplied_j = part.max_supplied_j.max(part.supplied_j);
            let unsupplied = value - part.supplied_j;
            let balance = unsupplied + dissipated_j;
            if record.window == 0 {
                (part.first_j, part.min_j, part.max_j) = (value, value, value);
                (part.max_unsupplied_j, part.max_balance_j) = (unsupplied, balance);
            }
            part.max_unsupplied_j = part.max_unsupplied_j.max(unsupplied);
            part.max_balance_j = part.max_balance_j.max(balance);
            part.min_potential_j = part.min_potential_j.min(potential_j);
            part.final_j = value;
            part.min_j = part.min_j.min(value);
            part.max_j = part.max_j.max(value);
            part.dissipated_j = dissipated_j;
        }
    }

    /// What decides whether the result is to be trusted; nothing before the first settled window.
    pub(crate) fn verdicts(&self) -> Vec<Verdict> {
        if self.windows == 0 {
            return Vec::new();
        }
        let crossing = self.interfaces.iter().zip(&self.carries_impulses).filter(|(_, crosses)| **crosses);
        let mut verdicts: Vec<Verdict> = crossing
            .map(|(i, _)| Verdict::new("transfer-defect", &format!("{}~{}", i.a, i.b), i.transfer_defect, 0.0))
            .collect();
        for ((process, closure), form) in self.processes.iter().zip(&self.closures).zip(&self.forms) {
            verdicts.extend(closure.verdicts(&process.name, ClosureGate::of(*form, 1).run));
        }
        verdicts
    }
}

/// The larger of two numbers; not a number if one is none, so that it cannot hide.
fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }
}

fn interface(plan: &Plan, from: &cosplat_core::plan::Interface) -> Interface {
    let kind = match from.kind {
        InterfaceKind::Contact => "contact",
        InterfaceKind::Link => "link",
    };
    Interface {
        a: from.a.body.clone(),
        b: from.b.body.clone(),
        kind: kind.into(),
        resolver: from.carries_impulses().then(|| plan.name_of(from.a.participant).to_owned()),
        ..Interface::default()
    }
}

/// Energy of a link between two bodies at t = 0 \[J\]: `½ k |x_a − x_b − rest|²`.
fn stored_j(plan: &Plan, scene: &Scene, ready: &[ReadyInfo], link: usize) -> f64 {
    let Some(link) = scene.links.get(link) else { return 0.0 };
    let place = |name: &str| body_state(plan, ready, name).map(|s| s.position_m);
    let ends = link.b.as_deref().and_then(|b| Some((place(&link.a)?, place(b)?)));
    ends.map_or(0.0, |(a, b)| 0.5 * link.stiffness_n_m * norm(sub(sub(a, b), link.rest_m)).powi(2))
}

fn body_state<'a>(plan: &Plan, ready: &'a [ReadyInfo], body: &str) -> Option<&'a BodyState> {
    plan.participants.iter().zip(ready).find_map(|(participant, info)| {
        let at = participant.bodies.iter().position(|b| b == body)?;
        info.report.bodies.get(at)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::folder::fixtures::{done, plan, record};

    fn tally() -> Tally {
        Tally::new(&plan(3), vec![BoundaryForm::SamplesF64 { normals: false }; 2])
    }

    fn failed(tally: &Tally) -> Vec<String> {
        tally.verdicts().iter().filter(|v| !v.passed).map(|v| format!("{} {}", v.name, v.of)).collect()
    }

    #[test]
    fn a_run_without_defects_passes() {
        let mut tally = tally();
        assert!(tally.verdicts().is_empty());
        (0..3).for_each(|w| tally.settled(&record(w), &[done(w), done(w)]));
        assert_eq!(tally.verdicts().len(), 1 + 2 * 2);
        assert_eq!(failed(&tally), Vec::<String>::new());
        assert_eq!((tally.windows, tally.processes[1].substeps), (3, 9));
    }

    #[test]
    fn the_lowest_potential_of_each_part_is_kept() {
        let mut tally = tally();
        for (window, potential_j) in [3.0, -1.0, 2.0].into_iter().enumerate() {
            let mut now = record(window as u64);
            now.solvers[1].potential_j = potential_j;
            now.solvers[0].potential_j = 1.0 - potential_j;
            tally.settled(&now, &[done(window as u64), done(window as u64)]);
        }
        let lowest: Vec<f64> = tally.energy.iter().map(|part| part.min_potential_j).collect();
        // Not known at t = 0, where nothing was started.
        assert_eq!(lowest, [-2.0, -1.0, 0.0]);
    }

    #[test]
    fn the_smallest_loss_in_transfer_fails() {
        let mut tally = tally();
        let mut lossy = record(0);
        lossy.interfaces[0].transfer_defect = f64::MIN_POSITIVE;
        tally.settled(&lossy, &[done(0), done(0)]);
        tally.settled(&record(1), &[done(1), done(1)]);
        assert_eq!(failed(&tally), ["transfer-defect a~b"]);
    }

    #[test]
    fn a_thrown_away_impulse_and_a_lost_number_fail_the_closure_of_their_solver() {
        for bad in [1e-3, f64::NAN, f64::INFINITY] {
            let mut tally = tally();
            let mut open = record(0);
            open.solvers[1].closure = bad;
            tally.settled(&open, &[done(0), done(0)]);
            tally.settled(&record(1), &[done(1), done(1)]);
            assert_eq!(failed(&tally), ["closure-window right", "closure-run right"], "{bad}");
        }
    }

    #[test]
    fn many_small_leaks_fail_the_run_but_no_window() {
        let mut tally = tally();
        for window in 0..2000 {
            let mut leaky = record(window);
            leaky.solvers[0].angular_closure = 0.9e-12;
            tally.settled(&leaky, &[done(window), done(window)]);
        }
        assert_eq!(failed(&tally), ["closure-run left"]);
    }
}
