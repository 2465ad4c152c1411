//! Runs plugins in one process by the schedule of a plan, without protocol: what is measured is plugin and scheme.

use std::collections::BTreeMap;

use cosplat_conformance::parts;
use cosplat_core::boundary::{BoundaryState, Impulses, Vec3, Wrench, norm};
use cosplat_core::plan::schedule::{self, MessageId, Role, StepPlan};
use cosplat_core::plan::{Content, Plan, build};
use cosplat_core::plugin::{ImpulseInput, Inputs, Outputs, PartnerInput, Plugin, Report, SolverScene, Steady, Step};
use cosplat_core::scene::{Body, ClockSpec, MotionRule, OutputSpec, RunSpec, Scene, Scheme, Space};
use cosplat_oscillator::Oscillator;

/// A scene of oscillators that lasts `duration_s` in windows of `window_s`.
pub(crate) fn scene(duration_s: f64, window_s: f64, scheme: Scheme, rule: MotionRule) -> Scene {
    Scene {
        name: "oscillator".into(),
        title: String::new(),
        clock: ClockSpec {
            duration_s,
            window_s: Some(window_s),
            exact_window: false,
            frames_per_second: None,
            contact_scheme: Scheme::Serial,
            link_scheme: scheme,
            motion_rule: rule,
        },
        space: Space::Full,
        solvers: BTreeMap::new(),
        bodies: Vec::new(),
        statics: Vec::new(),
        pairs: Vec::new(),
        links: Vec::new(),
        joints: Vec::new(),
        actions: Vec::new(),
        probes: Vec::new(),
        output: OutputSpec::default(),
        run: RunSpec { threads: None, join_limit_s: 30.0, silence_limit_s: 10.0, rigidify: true, break_with: None },
        presets: Vec::new(),
    }
}

/// A point mass `name` of solver `solver`.
pub(crate) fn point(solver: &str, name: &str, mass_kg: f64, position_m: Vec3, velocity_m_s: Vec3) -> Body {
    Body { solver: solver.into(), ..parts::point(name, mass_kg, position_m, velocity_m_s) }
}

/// A run in progress.
pub(crate) struct Run {
    pub(crate) plan: Plan,
    scenes: Vec<SolverScene>,
    plugins: Vec<Oscillator>,
    boundaries: BTreeMap<MessageId, BoundaryState>,
    impulses: BTreeMap<MessageId, Impulses>,
    /// Last report of each participant; steps of a window are summed.
    pub(crate) reports: Vec<Report>,
    /// Worst closure so far, linear \[kg m/s\] and angular \[kg m²/s\], over the largest momenta.
    pub(crate) closure: [f64; 2],
    scale: [f64; 2],
    /// Worst change of a solver's energy that work through its interfaces does not explain \[J\].
    pub(crate) work_defect: f64,
}

impl Run {
    /// Plans and sets up; every solver of the scene is an oscillator.
    pub(crate) fn start(scene: &mut Scene) -> Self {
        for body in &scene.bodies {
            scene.solvers.entry(body.solver.clone()).or_insert_with(|| cosplat_core::scene::SolverSpec {
                plugin: Some("oscillator".into()),
                command: None,
                params: serde_json::Map::new(),
            });
        }
        let descriptors = BTreeMap::from([("oscillator".to_owned(), Oscillator::default().describe())]);
        let (plan, scenes) = build(scene, &descriptors, 1).unwrap();
        let mut run = Self {
            plugins: vec![Oscillator::default(); scenes.len()],
            plan,
            scenes,
            boundaries: BTreeMap::new(),
            impulses: BTreeMap::new(),
            reports: Vec::new(),
            closure: [0.0; 2],
            scale: [0.0; 2],
            work_defect: 0.0,
        };
        for who in 0..run.plugins.len() {
            let setup = run.plugins[who].setup(&run.scenes[who]).unwrap();
            run.plugins[who].connect(&[]).unwrap();
            for message in schedule::published_at_start(&run.plan, who as u16) {
                if let Content::Boundary { body, .. } = &run.plan.streams[usize::from(message.stream)].content {
                    let found = setup.boundaries.iter().find(|b| b.body == *body).unwrap();
                    run.boundaries.insert(message, found.state.clone());
                }
            }
            run.reports.push(setup.report);
        }
        run.widen();
        run
    }

    /// Computes one window.
    pub(crate) fn window(&mut self, window: u64) {
        let steps: Vec<Vec<StepPlan>> =
            (0..self.plugins.len()).map(|who| schedule::steps(&self.plan, who as u16, window)).collect();
        let before: Vec<Wrench> = self.reports.iter().map(momentum).collect();
        let energy = |r: &Report| r.energy.kinetic_j + r.energy.potential_j;
        let mut unexplained: Vec<f64> = self.reports.iter().map(|r| -energy(r)).collect();
        let mut explained = vec![Wrench::default(); self.plugins.len()];
        let mut at = vec![0; steps.len()];
        while at.iter().zip(&steps).any(|(&at, steps)| at < steps.len()) {
            let ready = |who: usize| {
                steps[who].get(at[who]).is_some_and(|s| {
                    s.needs
                        .iter()
                        .all(|n| self.boundaries.contains_key(&n.message) || self.impulses.contains_key(&n.message))
                })
            };
            let who = (0..steps.len()).find(|&who| ready(who)).expect("somebody can go on");
            let outputs = self.step(who, window, &steps[who][at[who]]);
            explained[who] = explained[who].plus(outputs.report.external);
            unexplained[who] -= outputs.report.supplied_j;
            for own in &outputs.report.interfaces {
                explained[who] = explained[who].plus(own.received);
                unexplained[who] -= own.work_j;
            }
            self.reports[who] = outputs.report;
            at[who] += 1;
        }
        self.widen();
        for who in 0..self.plugins.len() {
            self.work_defect = self.work_defect.max((unexplained[who] + energy(&self.reports[who])).abs());
            let open = momentum(&self.reports[who]).minus(before[who]).minus(explained[who]);
            for (worst, (open, scale)) in
                self.closure.iter_mut().zip([norm(open.linear), norm(open.angular)].into_iter().zip(self.scale))
            {
                *worst = worst.max(if open == 0.0 { 0.0 } else { open / scale });
            }
        }
    }

    fn step(&mut self, who: usize, window: u64, step: &StepPlan) -> Outputs {
        let at = Step::new(&self.plan.clock, window, step.span);
        let mut inputs = Inputs::default();
        for need in &step.needs {
            let interface = need.interface.unwrap();
            match need.role {
                Role::PartnerNow => inputs.partners.push(PartnerInput {
                    interface,
                    rule: self.plan.interfaces[usize::from(interface)].rule,
                    now: self.boundaries[&need.message].clone(),
                    next: None,
                    length_s: at.length_s,
                }),
                Role::PartnerNext => {
                    let partner = inputs.partners.iter_mut().find(|p| p.interface == interface).unwrap();
                    partner.next = Some(self.boundaries[&need.message].clone());
                }
                role => inputs.impulses.push(ImpulseInput {
                    interface,
                    impulses: self.impulses[&need.message].clone(),
                    spread: role == Role::ImpulseSpread,
                }),
            }
        }
        let outputs = self.plugins[who].advance(&at, &inputs, &mut Steady).unwrap();
        for message in &step.gives {
            match &self.plan.streams[usize::from(message.stream)].content {
                Content::Boundary { body, .. } | Content::MidBoundary { body, .. } => {
                    let found = outputs.boundaries.iter().find(|b| b.body == *body).unwrap();
                    self.boundaries.insert(*message, found.state.clone());
                }
                Content::Impulses { interface, .. } => {
                    let found = outputs.impulses.iter().find(|(id, _)| id == interface).unwrap();
                    self.impulses.insert(*message, found.1.clone());
                }
                Content::Statics { .. } | Content::Visual { .. } => {}
            }
        }
        outputs
    }

    /// Position of a body now \[m\].
    pub(crate) fn position(&self, name: &str) -> Vec3 {
        let mut places = self.plan.participants.iter().zip(&self.reports);
        let (index, report) = places.find_map(|(p, r)| Some((p.bodies.iter().position(|b| b == name)?, r))).unwrap();
        report.bodies[index].position_m
    }

    /// Momentum of everything.
    #[allow(dead_code, reason = "not every test of this folder uses every helper")]
    pub(crate) fn momentum(&self) -> Wrench {
        self.reports.iter().map(momentum).fold(Wrench::default(), Wrench::plus)
    }

    #[allow(dead_code, reason = "not every test of this folder uses every helper")]
    /// Energy of everything \[J\], links between solvers included.
    pub(crate) fn energy(&self, scene: &Scene) -> f64 {
        let inside: f64 = self.reports.iter().map(|r| r.energy.kinetic_j + r.energy.potential_j).sum();
        let crossing = self.plan.interfaces.iter().flat_map(|i| &i.links).map(|&l| {
            let link = &scene.links[l];
            let (a, b) = (self.position(&link.a), self.position(link.b.as_deref().unwrap()));
            let stretch: f64 = (0..3).map(|k| (a[k] - b[k] - link.rest_m[k]).powi(2)).sum();
            0.5 * link.stiffness_n_m * stretch
        });
        inside + crossing.sum::<f64>()
    }

    /// Turns all velocities round, through the saved states: positions, then velocities, each behind its count.
    #[allow(dead_code, reason = "not every test of this folder uses every helper")]
    pub(crate) fn reverse(&mut self) {
        for plugin in &mut self.plugins {
            let mut state = Vec::new();
            plugin.save(&mut state);
            let velocities = state.len() / 2 + 8;
            for number in state[velocities..].chunks_exact_mut(8) {
                number[7] ^= 0x80;
            }
            plugin.restore(&state).unwrap();
        }
    }

    fn widen(&mut self) {
        let bodies = || self.reports.iter().flat_map(|r| &r.bodies);
        let linear: f64 = bodies().map(|b| b.gross_momentum).sum();
        let angular: f64 = bodies().map(|b| b.gross_momentum * norm(b.position_m) + norm(b.momentum.angular)).sum();
        self.scale = [self.scale[0].max(linear), self.scale[1].max(angular)];
    }
}

fn momentum(report: &Report) -> Wrench {
    report.bodies.iter().fold(Wrench::default(), |sum, b| sum.plus(b.momentum))
}
