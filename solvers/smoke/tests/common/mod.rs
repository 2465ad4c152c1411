//! Scenes of one cloud, a run of windows with the books checked, and partners on the other side.
#![allow(dead_code, reason = "each test file uses its own part")]

use cosplat_core::boundary::{BoundaryState, Impulses, ProxyRecord, Vec3, Wrench, add, norm, scale};
use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{
    Inputs, InterfaceView, Outputs, PartnerInput, PartnerSetup, Plugin, Setup, SolverScene, StateHasher, Steady, Step,
    ViewRole,
};
use cosplat_core::scene::{
    Action, ActionKind, Body, ContactLaw, Material, MotionRule, PairSpec, Pose, Source, Space, StaticCollider,
    VelocityField, Wall,
};
use cosplat_core::time::{Clock, Span};
use cosplat_core::visual::VisualState;
use cosplat_smoke::Smoke;
use serde_json::{Value, json};

pub(crate) const UPRIGHT: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

/// A ball of smoke of that density \[kg/m³\].
pub(crate) fn ball(density_kg_m3: f64, radius_m: f64, at: Vec3, spacing_m: f64) -> Body {
    Body {
        name: "smoke".into(),
        solver: "smoke".into(),
        material: Material::Smoke { density_kg_m3, viscosity: 0.0 },
        source: Source::Sphere { radius_m },
        pose: Pose { position_m: at, orientation: UPRIGHT },
        mass_kg: None,
        spacing_m: Some(spacing_m),
        velocity: VelocityField::Twist { linear_m_s: [0.0; 3], angular_rad_s: [0.0; 3] },
        prescribed: None,
        regions: Vec::new(),
        color: None,
    }
}

pub(crate) fn wind(velocity_m_s: Vec3) -> Action {
    let kind = ActionKind::Wind { velocity_m_s, air_density_kg_m3: 1.2, drag_coefficient: 1.0 };
    Action { kind, bodies: Vec::new(), from_s: 0.0, until_s: None }
}

pub(crate) fn gravity(acceleration_m_s2: Vec3) -> Action {
    Action { kind: ActionKind::Gravity { acceleration_m_s2 }, bodies: Vec::new(), from_s: 0.0, until_s: None }
}

/// A static collider.
pub(crate) fn wall(name: &str, source: Source, position_m: Vec3) -> StaticCollider {
    let pose = Pose { position_m, orientation: UPRIGHT };
    StaticCollider { name: name.into(), source, pose, wall: Wall::NoSlip, motion: None, color: None }
}

/// A scene with parameters as an object of JSON.
pub(crate) fn scene(body: Body, actions: Vec<Action>, window_s: f64, params: &Value) -> SolverScene {
    SolverScene {
        participant: "smoke".into(),
        threads: 2,
        clock: Clock { tick_s: window_s / 2.0, windows: 1_000_000 },
        space: Space::Full,
        bodies: vec![body],
        statics: Vec::new(),
        links: Vec::new(),
        joints: Vec::new(),
        actions,
        pairs: Vec::new(),
        probes: Vec::new(),
        interfaces: Vec::new(),
        params: params.as_object().cloned().unwrap_or_default(),
        assets: std::collections::BTreeMap::new(),
    }
}

/// A cube of 32 cells of 2.5 cm around a ball in a wind.
pub(crate) fn windy(window_s: f64) -> SolverScene {
    let params = json!({ "low": [-0.4, -0.4, -0.4], "high": [0.4, 0.4, 0.4], "cell": 0.025 });
    let actions = vec![wind([1.0, 0.0, 0.0]), gravity([0.0, 0.0, -9.81])];
    scene(ball(1.0, 0.15, [-0.2, 0.0, 0.0], 0.0125), actions, window_s, &params)
}

/// An interface of the smoke with a partner.
pub(crate) fn meets(id: u16, partner: &str, form: BoundaryForm, source: Option<Source>) -> InterfaceView {
    InterfaceView {
        id,
        role: ViewRole::ContactResolver,
        own: "smoke".into(),
        partner: partner.into(),
        partner_form: form,
        partner_source: source,
        partner_pose: None,
        rule: MotionRule::Hold,
        pair: Some(PairSpec {
            a: "smoke".into(),
            b: partner.into(),
            static_friction: 0.0,
            kinetic_friction: 0.0,
            restitution: 0.0,
            softness_m: 0.002,
            contact: ContactLaw::Physical,
            resolver: None,
            enabled: true,
        }),
        links: Vec::new(),
    }
}

/// What a partner shows at the start of a window.
pub(crate) fn shown(interface: u16, now: BoundaryState, length_s: f64) -> PartnerInput {
    PartnerInput { interface, rule: MotionRule::Hold, now, next: None, length_s }
}

/// Record of a rigid box of that size \[m\] and mass \[kg\].
pub(crate) fn rigid(mass: f64, size: Vec3, position: Vec3, linear_velocity: Vec3) -> ProxyRecord {
    let [x, y, z] = size.map(|s| s * s * mass / 12.0);
    ProxyRecord {
        position,
        orientation: UPRIGHT,
        linear_velocity,
        angular_velocity: [0.0; 3],
        mass,
        inertia: [y + z, x + z, x + y, 0.0, 0.0, 0.0],
        share: 1.0,
        background_linear: [0.0; 3],
        background_angular: [0.0; 3],
    }
}

/// A solver with its scene, and the largest closure so far.
pub(crate) struct Run {
    pub(crate) plugin: Smoke,
    pub(crate) scene: SolverScene,
    pub(crate) setup: Setup,
    pub(crate) window: u64,
    pub(crate) momentum: Wrench,
    /// Largest sum of sizes of momenta, and of the moments that a cell of it can have.
    pub(crate) gross: f64,
    /// Largest linear and angular defect over a window.
    pub(crate) defect: [f64; 2],
    pub(crate) substeps: u64,
    /// Largest of each counter.
    pub(crate) divergence: u64,
    pub(crate) iterations: u64,
}

impl Run {
    pub(crate) fn new(scene: SolverScene) -> Self {
        Self::with(scene, &[])
    }

    pub(crate) fn with(scene: SolverScene, partners: &[PartnerSetup]) -> Self {
        let mut plugin = Smoke::default();
        let setup = plugin.setup(&scene).expect("the scene is supported");
        plugin.connect(partners).expect("the partners are supported");
        let momentum = setup.report.bodies[0].momentum;
        let (gross, defect) = (0.0, [0.0; 2]);
        Self { plugin, scene, setup, window: 0, momentum, gross, defect, substeps: 0, divergence: 0, iterations: 0 }
    }

    pub(crate) fn step(&mut self) -> Outputs {
        self.step_with(&Inputs::default())
    }

    pub(crate) fn step_with(&mut self, inputs: &Inputs) -> Outputs {
        let span =
            Span { from: self.scene.clock.start_of(self.window), to: self.scene.clock.start_of(self.window + 1) };
        let step = Step::new(&self.scene.clock, self.window, span);
        let outputs = self.plugin.advance(&step, inputs, &mut Steady).expect("the step succeeds");
        self.window += 1;
        let report = &outputs.report;
        let counted = |name: &str| report.counters.get(name).copied().unwrap_or_default();
        self.substeps += report.substeps;
        self.divergence = self.divergence.max(counted("largest-divergence-1e-6"));
        self.iterations += counted("pressure-iterations");
        let body = &report.bodies[0];
        let received = report.interfaces.iter().fold(report.external, |sum, i| sum.plus(i.received));
        let open = body.momentum.minus(self.momentum).minus(received);
        self.defect = [self.defect[0].max(norm(open.linear)), self.defect[1].max(norm(open.angular))];
        self.gross = body.gross_momentum.max(self.gross);
        self.momentum = body.momentum;
        outputs
    }

    pub(crate) fn time(&self) -> f64 {
        self.window as f64 * self.scene.clock.tick_s * 2.0
    }

    pub(crate) fn particles(&self) -> Vec<Vec3> {
        match self.plugin.visual("smoke") {
            Some(VisualState::Particles { position, .. }) => position,
            other => panic!("particles instead of {other:?}"),
        }
    }

    pub(crate) fn bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.plugin.save(&mut bytes);
        bytes
    }

    pub(crate) fn hash(&self) -> u128 {
        let mut hasher = StateHasher::default();
        self.plugin.save(&mut hasher);
        hasher.finish()
    }
}

/// Sum of impulses on samples and the size of each.
pub(crate) fn total(impulses: &Impulses) -> Vec3 {
    impulses.total()
}

/// A square sheet of samples across x, `n` on a side, `d` \[m\] apart.
pub(crate) fn sheet(n: usize, d: f64, x: f64) -> Vec<Vec3> {
    let at = |i: usize| (i as f64 - 0.5 * (n as f64 - 1.0)) * d;
    (0..n * n).map(|i| [x, at(i % n), at(i / n)]).collect()
}

/// Points after a time at a velocity.
pub(crate) fn moved(points: &[Vec3], velocity: Vec3, t: f64) -> Vec<Vec3> {
    points.iter().map(|&x| add(x, scale(velocity, t))).collect()
}
