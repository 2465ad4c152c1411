//! Scenes of one solver, a run of windows with the books checked, and a rigid body on the other side.
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
use cosplat_sph::Sph;
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

pub(crate) const UPRIGHT: [f64; 4] = [0.0, 0.0, 0.0, 1.0];
const HALF: f64 = std::f64::consts::FRAC_1_SQRT_2;
/// Turn +z into ±x and ±y.
pub(crate) const TO_X: [f64; 4] = [0.0, HALF, 0.0, HALF];
pub(crate) const TO_MINUS_X: [f64; 4] = [0.0, -HALF, 0.0, HALF];
pub(crate) const TO_Y: [f64; 4] = [-HALF, 0.0, 0.0, HALF];
pub(crate) const TO_MINUS_Y: [f64; 4] = [HALF, 0.0, 0.0, HALF];
/// Turns +z down.
pub(crate) const DOWN: [f64; 4] = [1.0, 0.0, 0.0, 0.0];

/// Water of that sound speed and viscosity.
pub(crate) fn water(sound_m_s: f64, viscosity_pa_s: f64) -> Material {
    Material::SphLiquid {
        density_kg_m3: 1000.0,
        stiffness_pa: 1000.0 * sound_m_s * sound_m_s / 7.0,
        viscosity_pa_s,
        surface_tension_n_m: 0.0,
    }
}

pub(crate) fn liquid(material: Material, size_m: Vec3, centre: Vec3, spacing_m: f64) -> Body {
    Body {
        name: "water".into(),
        solver: "sph".into(),
        material,
        source: Source::Box { size_m },
        pose: Pose { position_m: centre, orientation: UPRIGHT },
        mass_kg: None,
        spacing_m: Some(spacing_m),
        velocity: VelocityField::Twist { linear_m_s: [0.0; 3], angular_rad_s: [0.0; 3] },
        prescribed: None,
        regions: Vec::new(),
        color: None,
    }
}

pub(crate) fn plane(name: &str, at: Vec3, turn: [f64; 4], wall: Wall) -> StaticCollider {
    StaticCollider {
        name: name.into(),
        source: Source::Plane { size_m: None },
        pose: Pose { position_m: at, orientation: turn },
        wall,
        motion: None,
        color: None,
    }
}

/// A floor at z = 0 and four walls about `0..x` and `0..y`.
pub(crate) fn tank(x: f64, y: f64, wall: Wall) -> Vec<StaticCollider> {
    vec![
        plane("floor", [0.0; 3], UPRIGHT, wall),
        plane("left", [0.0; 3], TO_X, wall),
        plane("right", [x, 0.0, 0.0], TO_MINUS_X, wall),
        plane("front", [0.0; 3], TO_Y, wall),
        plane("back", [0.0, y, 0.0], TO_MINUS_Y, wall),
    ]
}

pub(crate) fn gravity(acceleration_m_s2: Vec3) -> Action {
    Action { kind: ActionKind::Gravity { acceleration_m_s2 }, bodies: Vec::new(), from_s: 0.0, until_s: None }
}

pub(crate) fn scene(bodies: Vec<Body>, statics: Vec<StaticCollider>, window_s: f64) -> SolverScene {
    SolverScene {
        participant: "sph".into(),
        threads: 2,
        clock: Clock { tick_s: window_s / 2.0, windows: 1_000_000 },
        space: Space::Full,
        bodies,
        statics,
        links: Vec::new(),
        joints: Vec::new(),
        actions: vec![gravity([0.0, 0.0, -9.81])],
        pairs: Vec::new(),
        probes: Vec::new(),
        interfaces: Vec::new(),
        params: std::iter::once(("pressure".to_owned(), "wcsph".into())).collect(),
        assets: std::collections::BTreeMap::new(),
    }
}

/// The same, kept incompressible.
pub(crate) fn incompressible(mut scene: SolverScene) -> SolverScene {
    scene.params.insert("pressure".into(), "dfsph".into());
    scene
}

/// An interface of the water with a partner.
pub(crate) fn meets(partner: &str, form: BoundaryForm, source: Option<Source>, friction: f64) -> InterfaceView {
    InterfaceView {
        id: 0,
        role: ViewRole::ContactResolver,
        own: "water".into(),
        partner: partner.into(),
        partner_form: form,
        partner_source: source,
        partner_pose: None,
        rule: MotionRule::Hold,
        pair: Some(PairSpec {
            a: "water".into(),
            b: partner.into(),
            static_friction: friction,
            kinetic_friction: friction,
            restitution: 0.0,
            softness_m: 0.002,
            contact: ContactLaw::Physical,
            resolver: None,
            enabled: true,
        }),
        links: Vec::new(),
    }
}

/// A solver with its scene, and the largest closure so far.
pub(crate) struct Run {
    pub(crate) plugin: Sph,
    pub(crate) scene: SolverScene,
    pub(crate) setup: Setup,
    pub(crate) window: u64,
    pub(crate) momentum: Wrench,
    pub(crate) gross: f64,
    /// Largest linear and angular defect over a window.
    pub(crate) defect: [f64; 2],
    pub(crate) substeps: u64,
}

impl Run {
    pub(crate) fn new(scene: SolverScene) -> Self {
        Self::with(scene, &[])
    }

    pub(crate) fn with(scene: SolverScene, partners: &[PartnerSetup]) -> Self {
        let mut plugin = Sph::default();
        let setup = plugin.setup(&scene).expect("the scene is supported");
        plugin.connect(partners).expect("the partners are supported");
        let momentum = sum(&setup.report.bodies);
        Self { plugin, scene, setup, window: 0, momentum, gross: 0.0, defect: [0.0; 2], substeps: 0 }
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
        self.substeps += report.substeps;
        let after = sum(&report.bodies);
        let received = report.interfaces.iter().fold(report.external, |sum, i| sum.plus(i.received));
        let open = after.minus(self.momentum).minus(received);
        self.defect = [self.defect[0].max(norm(open.linear)), self.defect[1].max(norm(open.angular))];
        self.gross = report.bodies.iter().map(|b| b.gross_momentum).sum::<f64>().max(self.gross);
        self.momentum = after;
        outputs
    }

    pub(crate) fn time(&self) -> f64 {
        self.window as f64 * self.scene.clock.tick_s * 2.0
    }

    pub(crate) fn particles(&self) -> Vec<Vec3> {
        match self.plugin.visual("water") {
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

pub(crate) fn sum(bodies: &[cosplat_core::plugin::BodyState]) -> Wrench {
    bodies.iter().fold(Wrench::default(), |sum, b| sum.plus(b.momentum))
}

/// A free rigid box.
#[derive(Clone, Copy)]
pub(crate) struct Float {
    pub(crate) record: ProxyRecord,
    inertia: Vec3,
}

impl Float {
    pub(crate) fn new(mass: f64, size: Vec3, position: Vec3) -> Self {
        let [x, y, z] = size.map(|s| s * s * mass / 12.0);
        let inertia = [y + z, x + z, x + y];
        let record = ProxyRecord {
            position,
            orientation: UPRIGHT,
            linear_velocity: [0.0; 3],
            angular_velocity: [0.0; 3],
            mass,
            inertia: [inertia[0], inertia[1], inertia[2], 0.0, 0.0, 0.0],
            share: 1.0,
            background_linear: [0.0, 0.0, -9.81],
            background_angular: [0.0; 3],
        };
        Self { record, inertia }
    }

    pub(crate) fn inputs(&self, length_s: f64) -> Inputs {
        let now = BoundaryState::Proxy(self.record);
        let partner = PartnerInput { interface: 0, rule: MotionRule::Hold, now, next: None, length_s };
        Inputs { partners: vec![partner], impulses: Vec::new() }
    }

    /// Takes the impulse of a window of that length, then moves; without the gyroscopic moment, which is of second order
    /// in the small spins here.
    pub(crate) fn take(&mut self, outputs: &Outputs, length_s: f64) {
        let Impulses::Rigid(j) = &outputs.impulses[0].1 else { panic!("a rigid impulse") };
        let r = &mut self.record;
        let gained = add(scale(j.linear, 1.0 / r.mass), scale(r.background_linear, length_s));
        // The impulse came during the window: half of what it adds moves the body.
        let before = r.linear_velocity;
        r.linear_velocity = add(before, gained);
        r.position = add(r.position, scale(add(before, r.linear_velocity), 0.5 * length_s));
        let inverse = |q: &UnitQuaternion<f64>| {
            let m = q.to_rotation_matrix();
            let inertia = m.matrix() * Matrix3::from_diagonal(&Vector3::from(self.inertia)) * m.matrix().transpose();
            (inertia, inertia.try_inverse().expect("positive"))
        };
        let [x, y, z, w] = r.orientation;
        let q = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        let turned = inverse(&q).1 * Vector3::from(j.angular);
        r.angular_velocity = add(r.angular_velocity, turned.into());
        let q = UnitQuaternion::from_scaled_axis(Vector3::from(scale(r.angular_velocity, length_s))) * q;
        r.orientation = [q.i, q.j, q.k, q.w];
        let i = inverse(&q).0;
        r.inertia = [i[(0, 0)], i[(1, 1)], i[(2, 2)], i[(0, 1)], i[(0, 2)], i[(1, 2)]];
    }
}

/// Positions, velocities and densities in a saved state, in the order of the state: it begins with the number of
/// particles and four bytes for the identity of each.
pub(crate) fn columns(bytes: &[u8]) -> (Vec<Vec3>, Vec<Vec3>, Vec<f64>) {
    let number = |at: usize| f64::from_le_bytes(bytes[at..at + 8].try_into().expect("eight bytes"));
    let n = u64::from_le_bytes(bytes[..8].try_into().expect("eight bytes")) as usize;
    let vector = |at: usize| [0, 1, 2].map(|k| number(at + 8 * k));
    let (x, v) = (8 + 4 * n + 8, 8 + 4 * n + 8 + 24 * n + 8);
    let rho = v + 24 * n;
    let vectors = |from: usize| (0..n).map(|i| vector(from + 24 * i)).collect();
    (vectors(x), vectors(v), (0..n).map(|i| number(rho + 8 * i)).collect())
}

/// The same state with other velocities.
pub(crate) fn with_velocities(bytes: &[u8], velocity: impl Fn(Vec3) -> Vec3) -> Vec<u8> {
    let (x, ..) = columns(bytes);
    let n = x.len();
    let from = 8 + 4 * n + 8 + 24 * n + 8;
    let new: Vec<u8> = x.iter().flat_map(|&x| velocity(x)).flat_map(f64::to_le_bytes).collect();
    let mut changed = bytes.to_vec();
    changed[from..from + 24 * n].copy_from_slice(&new);
    changed
}
