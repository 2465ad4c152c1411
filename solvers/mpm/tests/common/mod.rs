//! Scenes of one solver, and a run of windows with the books checked.
#![allow(dead_code, reason = "each test file uses its own part")]

pub(crate) mod pair;
pub(crate) mod rock;

use cosplat_core::boundary::{Wrench, add, norm, sub};
use cosplat_core::plugin::{Inputs, Outputs, Plugin, PluginError, Setup, SolverScene, StateHasher, Steady, Step};
use cosplat_core::scene::{
    Action, ActionKind, Body, Material, Pose, Source, Space, StaticCollider, VelocityField, Wall,
};
use cosplat_core::time::{Clock, Span};
use cosplat_core::visual::VisualState;
use cosplat_mpm::{Mpm, Real};

pub(crate) const UPRIGHT: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

pub(crate) fn elastic(density_kg_m3: f64, youngs_modulus_pa: f64, poissons_ratio: f64) -> Material {
    Material::Elastic { density_kg_m3, youngs_modulus_pa, poissons_ratio, viscosity_pa_s: 0.0 }
}

pub(crate) fn body(name: &str, material: Material, source: Source, at: [f64; 3], spacing_m: f64) -> Body {
    Body {
        name: name.into(),
        solver: "mpm".into(),
        material,
        source,
        pose: Pose { position_m: at, orientation: UPRIGHT },
        mass_kg: None,
        spacing_m: Some(spacing_m),
        velocity: VelocityField::Twist { linear_m_s: [0.0; 3], angular_rad_s: [0.0; 3] },
        prescribed: None,
        regions: Vec::new(),
        color: None,
    }
}

pub(crate) fn cuboid(size_m: [f64; 3]) -> Source {
    Source::Box { size_m }
}

pub(crate) fn moving(mut body: Body, linear_m_s: [f64; 3], angular_rad_s: [f64; 3]) -> Body {
    body.velocity = VelocityField::Twist { linear_m_s, angular_rad_s };
    body
}

/// A plane through `at`; `turn` turns +z into its normal.
pub(crate) fn plane(name: &str, at: [f64; 3], turn: [f64; 4], wall: Wall) -> StaticCollider {
    StaticCollider {
        name: name.into(),
        source: Source::Plane { size_m: None },
        pose: Pose { position_m: at, orientation: turn },
        wall,
        motion: None,
        color: None,
    }
}

/// A floor, and walls that slip, around a room from the origin that is so wide along x and y \[m\].
pub(crate) fn tank([wide, deep]: [f64; 2], floor: Wall) -> Vec<StaticCollider> {
    vec![
        plane("floor", [0.0; 3], UPRIGHT, floor),
        plane("left", [0.0; 3], TO_X, Wall::Slip),
        plane("right", [wide, 0.0, 0.0], TO_MINUS_X, Wall::Slip),
        plane("front", [0.0; 3], TO_Y, Wall::Slip),
        plane("back", [0.0, deep, 0.0], TO_MINUS_Y, Wall::Slip),
    ]
}

/// Turns +z into ±x and ±y.
pub(crate) const TO_X: [f64; 4] = [0.0, std::f64::consts::FRAC_1_SQRT_2, 0.0, std::f64::consts::FRAC_1_SQRT_2];
pub(crate) const TO_MINUS_X: [f64; 4] = [0.0, -std::f64::consts::FRAC_1_SQRT_2, 0.0, std::f64::consts::FRAC_1_SQRT_2];
pub(crate) const TO_Y: [f64; 4] = [-std::f64::consts::FRAC_1_SQRT_2, 0.0, 0.0, std::f64::consts::FRAC_1_SQRT_2];
pub(crate) const TO_MINUS_Y: [f64; 4] = [std::f64::consts::FRAC_1_SQRT_2, 0.0, 0.0, std::f64::consts::FRAC_1_SQRT_2];

pub(crate) fn gravity(z: f64) -> Action {
    let kind = ActionKind::Gravity { acceleration_m_s2: [0.0, 0.0, z] };
    Action { kind, bodies: Vec::new(), from_s: 0.0, until_s: None }
}

pub(crate) fn scene(bodies: Vec<Body>, window_s: f64) -> SolverScene {
    SolverScene {
        participant: "mpm".into(),
        threads: 1,
        clock: Clock { tick_s: window_s / 2.0, windows: 1_000_000 },
        space: Space::Full,
        bodies,
        statics: Vec::new(),
        links: Vec::new(),
        joints: Vec::new(),
        actions: Vec::new(),
        pairs: Vec::new(),
        probes: Vec::new(),
        interfaces: Vec::new(),
        params: serde_json::Map::new(),
        assets: std::collections::BTreeMap::new(),
    }
}

pub(crate) fn set(scene: &mut SolverScene, key: &str, value: impl Into<serde_json::Value>) {
    scene.params.insert(key.into(), value.into());
}

/// A solver with its scene, and the largest closure so far.
pub(crate) struct Run<R: Real> {
    pub(crate) plugin: Mpm<R>,
    pub(crate) scene: SolverScene,
    pub(crate) setup: Setup,
    pub(crate) window: u64,
    /// Linear and angular momentum of the start of the window.
    pub(crate) momentum: Wrench,
    /// Largest Σ m|v| so far.
    pub(crate) gross: f64,
    /// Largest linear and angular defect over a window, absolute.
    pub(crate) defect: [f64; 2],
    pub(crate) substeps: u64,
}

pub(crate) fn momentum(bodies: &[cosplat_core::plugin::BodyState]) -> Wrench {
    bodies.iter().fold(Wrench::default(), |sum, b| sum.plus(b.momentum))
}

impl<R: Real> Run<R> {
    pub(crate) fn new(scene: SolverScene) -> Self {
        let mut plugin = Mpm::default();
        let setup = plugin.setup(&scene).expect("the scene is supported");
        let momentum = momentum(&setup.report.bodies);
        let gross = setup.report.bodies.iter().map(|b| b.gross_momentum).sum();
        Self { plugin, scene, setup, window: 0, momentum, gross, defect: [0.0; 2], substeps: 0 }
    }

    pub(crate) fn step(&mut self) -> Outputs {
        self.step_with(&Inputs::default())
    }

    pub(crate) fn step_with(&mut self, inputs: &Inputs) -> Outputs {
        self.try_step(inputs).expect("the step succeeds")
    }

    pub(crate) fn try_step(&mut self, inputs: &Inputs) -> Result<Outputs, PluginError> {
        let from = self.scene.clock.start_of(self.window);
        let span = Span { from, to: self.scene.clock.start_of(self.window + 1) };
        let step = Step::new(&self.scene.clock, self.window, span);
        let outputs = self.plugin.advance(&step, inputs, &mut Steady)?;
        self.window += 1;
        let report = &outputs.report;
        self.substeps += report.substeps;
        let after = momentum(&report.bodies);
        let received = report.interfaces.iter().fold(report.external, |sum, i| sum.plus(i.received));
        let defect = after.minus(self.momentum).minus(received);
        self.defect = [self.defect[0].max(norm(defect.linear)), self.defect[1].max(norm(defect.angular))];
        self.gross = report.bodies.iter().map(|b| b.gross_momentum).sum::<f64>().max(self.gross);
        self.momentum = after;
        Ok(outputs)
    }

    /// Positions of a body's particles \[m\].
    pub(crate) fn particles(&self, body: &str) -> Vec<[f64; 3]> {
        match self.plugin.visual(body) {
            Some(VisualState::Particles { position, .. }) => position,
            other => panic!("particles instead of {other:?}"),
        }
    }

    pub(crate) fn hash(&self) -> u128 {
        let mut hasher = StateHasher::default();
        self.plugin.save(&mut hasher);
        hasher.finish()
    }

    pub(crate) fn bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.plugin.save(&mut bytes);
        bytes
    }
}

pub(crate) fn shifted(a: [f64; 3], b: [f64; 3]) -> f64 {
    norm(sub(a, b))
}

pub(crate) fn plus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    add(a, b)
}
