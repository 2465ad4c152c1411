//! Scenes of one solver.
#![allow(dead_code, reason = "each test file uses its own part")]

use cosplat_conformance::parts;
use cosplat_core::plugin::SolverScene;
use cosplat_core::scene::{Body, Pose, Source, StaticCollider, VelocityField, Wall};

pub(crate) fn still() -> VelocityField {
    parts::twist([0.0; 3], [0.0; 3])
}

/// Bodies on a rough floor, with gravity.
pub(crate) fn on_floor(bodies: Vec<Body>, windows: u64, window_s: f64) -> SolverScene {
    let mut scene = parts::solver_scene("shape-matching", bodies, windows, window_s);
    let pose = Pose { position_m: [0.0; 3], orientation: [0.0, 0.0, 0.0, 1.0] };
    scene.statics = vec![StaticCollider {
        name: "floor".into(),
        source: Source::Plane { size_m: None },
        pose,
        wall: Wall::Friction { static_friction: 0.4, kinetic_friction: 0.4 },
        motion: None,
        color: None,
    }];
    scene.actions = vec![parts::gravity()];
    scene
}
