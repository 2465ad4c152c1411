//! Scenes of one solver, and a run of windows with the books checked.
#![allow(dead_code, reason = "each test file uses its own part")]

use cosplat_core::boundary::{ProxyRecord, Wrench, cross, dot, norm, sub};
use cosplat_core::plugin::{BodyState, Inputs, Outputs, Plugin, PluginError, Setup, SolverScene, Steady, Step};
use cosplat_core::scene::{ContactLaw, Material, PairSpec, Pose, Source, StaticCollider, Wall};
use cosplat_core::time::Span;
use cosplat_core::visual::VisualState;
use cosplat_pbd::Pbd;

pub(crate) const UPRIGHT: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

/// Cloth of 0.2 kg/m² with compliances of stretch \[m/N\] and bending \[rad/(N m)\].
pub(crate) fn cloth(stretch_compliance_m_n: f64, bending_compliance_rad_n: f64) -> Material {
    Material::Cloth {
        areal_density_kg_m2: 0.2,
        static_friction: 0.3,
        kinetic_friction: 0.2,
        stretch_compliance_m_n,
        bending_compliance_rad_n,
        stretch_relaxation: 1.0,
        bending_relaxation: 1.0,
    }
}

pub(crate) fn wall(name: &str, source: Source, pose: Pose, wall: Wall) -> StaticCollider {
    StaticCollider { name: name.into(), source, pose, wall, motion: None, color: None }
}

pub(crate) fn floor(surface: Wall) -> StaticCollider {
    let pose = Pose { position_m: [0.0; 3], orientation: UPRIGHT };
    wall("floor", Source::Plane { size_m: None }, pose, surface)
}

pub(crate) fn pair(own: &str, partner: &str, friction: f64) -> PairSpec {
    PairSpec {
        a: own.into(),
        b: partner.into(),
        static_friction: friction,
        kinetic_friction: friction,
        restitution: 0.0,
        softness_m: 0.002,
        contact: ContactLaw::Physical,
        resolver: None,
        enabled: true,
    }
}

/// A ball's record without background.
pub(crate) fn record(position: [f64; 3], linear_velocity: [f64; 3], mass: f64, inertia: f64) -> ProxyRecord {
    ProxyRecord {
        position,
        orientation: UPRIGHT,
        linear_velocity,
        angular_velocity: [0.0; 3],
        mass,
        inertia: [inertia, inertia, inertia, 0.0, 0.0, 0.0],
        share: 1.0,
        background_linear: [0.0; 3],
        background_angular: [0.0; 3],
    }
}

/// A solver with its scene, and the largest closure so far.
pub(crate) struct Run {
    pub(crate) plugin: Pbd,
    pub(crate) scene: SolverScene,
    pub(crate) setup: Setup,
    pub(crate) window: u64,
    pub(crate) momentum: Wrench,
    /// Largest Σ m|v| so far.
    pub(crate) gross: f64,
    /// Largest linear and angular defect of a window, absolute.
    pub(crate) defect: [f64; 2],
}

pub(crate) fn momentum(bodies: &[BodyState]) -> Wrench {
    bodies.iter().fold(Wrench::default(), |sum, b| sum.plus(b.momentum))
}

impl Run {
    pub(crate) fn new(scene: SolverScene) -> Self {
        let mut plugin = Pbd::default();
        let setup = plugin.setup(&scene).expect("the scene is supported");
        let momentum = momentum(&setup.report.bodies);
        let gross = setup.report.bodies.iter().map(|b| b.gross_momentum).sum();
        Self { plugin, scene, setup, window: 0, momentum, gross, defect: [0.0; 2] }
    }

    pub(crate) fn step(&mut self) -> Outputs {
        self.step_with(&Inputs::default()).expect("the step succeeds")
    }

    pub(crate) fn step_with(&mut self, inputs: &Inputs) -> Result<Outputs, PluginError> {
        let clock = &self.scene.clock;
        let span = Span { from: clock.start_of(self.window), to: clock.start_of(self.window + 1) };
        let outputs = self.plugin.advance(&Step::new(clock, self.window, span), inputs, &mut Steady)?;
        self.window += 1;
        let report = &outputs.report;
        let after = momentum(&report.bodies);
        let received = report.interfaces.iter().fold(report.external, |sum, i| sum.plus(i.received));
        let open = after.minus(self.momentum).minus(received);
        self.defect = [self.defect[0].max(norm(open.linear)), self.defect[1].max(norm(open.angular))];
        self.gross = report.bodies.iter().map(|b| b.gross_momentum).sum::<f64>().max(self.gross);
        self.momentum = after;
        Ok(outputs)
    }

    /// Positions of a body's vertices \[m\].
    pub(crate) fn vertices(&self, body: &str) -> Vec<[f64; 3]> {
        match self.plugin.visual(body) {
            Some(VisualState::Particles { position, .. }) => position,
            other => panic!("particles instead of {other:?}"),
        }
    }

    pub(crate) fn bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.plugin.save(&mut bytes);
        bytes
    }
}

/// Triangles of a sheet of `n` by `n` squares, diagonals alternating.
pub(crate) fn squares(n: usize) -> Vec<[usize; 3]> {
    let corners = |i: usize, j: usize| [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| j * (n + 1) + i);
    let halves = |(i, j): (usize, usize)| match corners(i, j) {
        [a, b, c, d] if (i + j) % 2 == 0 => [[a, b, c], [a, c, d]],
        [a, b, c, d] => [[a, b, d], [b, c, d]],
    };
    (0..n).flat_map(|j| (0..n).map(move |i| (i, j))).flat_map(halves).collect()
}

/// Pieces of a leaf between two neighbours that go through a triangle of a cloth.
pub(crate) fn pierced(leaf: &[[f64; 3]], edges: &[[usize; 2]], v: &[[f64; 3]], triangles: &[[usize; 3]]) -> usize {
    let volume = |a: [f64; 3], b: [f64; 3], c: [f64; 3], p: [f64; 3]| dot(cross(sub(b, a), sub(c, a)), sub(p, a));
    let crosses = |[p, q]: [[f64; 3]; 2], [a, b, c]: [[f64; 3]; 3]| {
        let turns = [volume(p, q, a, b), volume(p, q, b, c), volume(p, q, c, a)];
        volume(a, b, c, p) * volume(a, b, c, q) < 0.0
            && (turns.iter().all(|s| *s > 0.0) || turns.iter().all(|s| *s < 0.0))
    };
    let all = edges.iter().map(|e| e.map(|i| leaf[i]));
    all.map(|e| triangles.iter().filter(|t| crosses(e, t.map(|i| v[i]))).count()).sum()
}
