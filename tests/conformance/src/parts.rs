//! Parts of scenes, for tests of plugins.

use cosplat_core::boundary::{BoundaryState, Impulses, Samples, Vec3};
use cosplat_core::plan::{BoundaryForm, InterfaceId};
use cosplat_core::plugin::{ImpulseInput, InterfaceView, PartnerInput, SolverScene, Step, ViewRole};
use cosplat_core::scene::{Action, ActionKind, Body, Link, Material, MotionRule, Pose, Source, Space, VelocityField};
use cosplat_core::time::{Clock, Span};

/// A solver's part of a scene over `windows` windows of `window_s` \[s\], with those bodies and nothing else.
pub fn solver_scene(participant: &str, bodies: Vec<Body>, windows: u64, window_s: f64) -> SolverScene {
    SolverScene {
        participant: participant.to_owned(),
        threads: 1,
        clock: Clock::new(windows as f64 * window_s, windows),
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

/// A body of one material and shape at a place \[m\], at rest, its frame along the world's axes.
pub fn body(name: &str, material: Material, source: Source, position_m: Vec3) -> Body {
    Body {
        name: name.to_owned(),
        solver: String::new(),
        material,
        source,
        pose: Pose { position_m, orientation: [0.0, 0.0, 0.0, 1.0] },
        mass_kg: None,
        spacing_m: None,
        velocity: twist([0.0; 3], [0.0; 3]),
        prescribed: None,
        regions: Vec::new(),
        color: None,
    }
}

/// A point mass.
pub fn point(name: &str, mass_kg: f64, position_m: Vec3, velocity_m_s: Vec3) -> Body {
    let source = Source::Points { positions_m: vec![[0.0; 3]] };
    Body {
        mass_kg: Some(mass_kg),
        velocity: twist(velocity_m_s, [0.0; 3]),
        ..body(name, Material::PointMass, source, position_m)
    }
}

/// A rigid body of that mass and motion.
pub fn rigid(name: &str, source: Source, mass_kg: f64, position_m: Vec3, velocity: VelocityField) -> Body {
    let material = Material::Rigid { density_kg_m3: 1000.0, friction: 0.5 };
    Body { mass_kg: Some(mass_kg), velocity, ..body(name, material, source, position_m) }
}

/// Rigid motion about the centre of mass \[m/s, rad/s\].
pub fn twist(linear_m_s: Vec3, angular_rad_s: Vec3) -> VelocityField {
    VelocityField::Twist { linear_m_s, angular_rad_s }
}

/// An undamped spring from `a` to `b`, or to the world at `anchor_m`.
pub fn spring(a: &str, b: Option<&str>, stiffness_n_m: f64, anchor_m: Vec3, rest_m: Vec3) -> Link {
    Link {
        name: format!("{a}-{}", b.unwrap_or("world")),
        a: a.to_owned(),
        b: b.map(str::to_owned),
        anchor_m,
        stiffness_n_m,
        damping_n_s_m: 0.0,
        rest_m,
        first: None,
    }
}

/// An outside influence on all bodies.
pub fn action(kind: ActionKind, from_s: f64, until_s: Option<f64>) -> Action {
    Action { kind, bodies: Vec::new(), from_s, until_s }
}

/// Gravity of 9.81 m/s² along -z on all bodies, always.
pub fn gravity() -> Action {
    action(ActionKind::Gravity { acceleration_m_s2: [0.0, 0.0, -9.81] }, 0.0, None)
}

/// An interface seen from `own`, with a partner that shows double-precision samples and moves straight.
pub fn view(id: InterfaceId, role: ViewRole, own: &str, partner: &str, links: Vec<Link>) -> InterfaceView {
    InterfaceView {
        id,
        role,
        own: own.to_owned(),
        partner: partner.to_owned(),
        partner_form: BoundaryForm::SamplesF64 { normals: false },
        partner_source: None,
        partner_pose: None,
        rule: MotionRule::Linear,
        pair: None,
        links,
    }
}

/// A partner of one sample over a step of `length_s` \[s\].
pub fn partner(interface: InterfaceId, position_m: Vec3, velocity_m_s: Vec3, length_s: f64) -> PartnerInput {
    let now = Samples { position: vec![position_m], velocity: vec![velocity_m_s], normal: Vec::new() };
    PartnerInput { interface, rule: MotionRule::Linear, now: BoundaryState::Samples(now), next: None, length_s }
}

/// Impulses of a partner, spread over the step.
pub fn spread(interface: InterfaceId, impulses: Impulses) -> ImpulseInput {
    ImpulseInput { interface, impulses, spread: true }
}

/// The step over all of a window.
pub fn step(clock: &Clock, window: u64) -> Step {
    Step::new(clock, window, Span { from: clock.start_of(window), to: clock.start_of(window + 1) })
}
