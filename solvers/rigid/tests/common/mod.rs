//! Scenes of the tests.
#![allow(dead_code, reason = "each test binary uses some of it")]

use cosplat_conformance::parts::{gravity, rigid, solver_scene, step, twist, view};
use cosplat_core::boundary::{Vec3, Wrench, norm};
use cosplat_core::plugin::{Inputs, InterfaceView, Outputs, Plugin, Report, SolverScene, Steady, ViewRole};
use cosplat_core::scene::{Body, Pose, Source, StaticCollider, Wall};
use cosplat_rigid::Rigid;
use nalgebra::{Quaternion, UnitQuaternion};

pub(crate) const G: f64 = 9.81;
pub(crate) const STILL: Vec3 = [0.0; 3];

pub(crate) fn body(name: &str, source: Source, mass_kg: f64, at: Vec3, linear: Vec3, angular: Vec3) -> Body {
    rigid(name, source, mass_kg, at, twist(linear, angular))
}

pub(crate) fn cube(name: &str, edge: f64, mass_kg: f64, at: Vec3) -> Body {
    body(name, Source::Box { size_m: [edge; 3] }, mass_kg, at, STILL, STILL)
}

pub(crate) fn scene(bodies: Vec<Body>, windows: u64, window_s: f64) -> SolverScene {
    solver_scene("rigid", bodies, windows, window_s)
}

/// With gravity and an endless floor z = 0 that has that friction.
pub(crate) fn on_floor(bodies: Vec<Body>, friction: f64, windows: u64, window_s: f64) -> SolverScene {
    let mut scene = scene(bodies, windows, window_s);
    scene.actions = vec![gravity()];
    scene.statics = vec![plane("floor", [0.0, 0.0, 0.0, 1.0], rough(friction))];
    scene
}

pub(crate) fn rough(friction: f64) -> Wall {
    Wall::Friction { static_friction: friction, kinetic_friction: friction }
}

pub(crate) fn plane(name: &str, orientation: [f64; 4], wall: Wall) -> StaticCollider {
    collider(name, Source::Plane { size_m: None }, STILL, orientation, wall)
}

pub(crate) fn collider(name: &str, source: Source, at: Vec3, orientation: [f64; 4], wall: Wall) -> StaticCollider {
    let pose = Pose { position_m: at, orientation };
    StaticCollider { name: name.into(), source, pose, wall, motion: None, color: None }
}

/// `[x, y, z, w]` of a rotation about y that tilts the floor down along +x by `angle` \[rad\].
pub(crate) fn tilt(angle: f64) -> [f64; 4] {
    [0.0, (0.5 * angle).sin(), 0.0, (0.5 * angle).cos()]
}

/// A point `up` above the tilted floor and `along` down it.
pub(crate) fn above(angle: f64, along: f64, up: f64) -> Vec3 {
    let (s, c) = angle.sin_cos();
    [along * c + up * s, 0.0, -along * s + up * c]
}

pub(crate) fn contact(id: u16, own: &str) -> InterfaceView {
    view(id, ViewRole::ContactResponder, own, "mud", Vec::new())
}

pub(crate) fn start(scene: &SolverScene) -> (Rigid, Report) {
    let mut solver = Rigid::default();
    let report = solver.setup(scene).expect("the scene is taken").report;
    (solver, report)
}

pub(crate) fn advance(solver: &mut Rigid, scene: &SolverScene, window: u64, inputs: &Inputs) -> Outputs {
    solver.advance(&step(&scene.clock, window), inputs, &mut Steady).expect("the window is computed")
}

/// Plays all windows and hands each report to `see`.
pub(crate) fn play(scene: &SolverScene, mut see: impl FnMut(u64, &Report)) -> Report {
    let (mut solver, mut last) = start(scene);
    for window in 0..scene.clock.windows {
        last = advance(&mut solver, scene, window, &Inputs::default()).report;
        see(window, &last);
    }
    last
}

pub(crate) fn momentum(report: &Report) -> Wrench {
    report.bodies.iter().fold(Wrench::default(), |sum, b| sum.plus(b.momentum))
}

pub(crate) fn size(w: Wrench) -> [f64; 2] {
    [norm(w.linear), norm(w.angular)]
}

pub(crate) fn turn([x, y, z, w]: [f64; 4]) -> UnitQuaternion<f64> {
    UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z))
}

/// Closure of linear and angular momentum between two reports, without partners, relative to the momenta of the later.
pub(crate) fn closure(before: &Report, after: &Report) -> [f64; 2] {
    let received = after.interfaces.iter().fold(Wrench::default(), |sum, i| sum.plus(i.received));
    let open = size(momentum(after).minus(momentum(before)).minus(after.external).minus(received));
    let linear: f64 = after.bodies.iter().map(|b| b.gross_momentum).sum::<f64>().max(1e-300);
    let angular: f64 = after
        .bodies
        .iter()
        .map(|b| b.gross_momentum * norm(b.position_m) + norm(b.momentum.angular))
        .sum::<f64>()
        .max(1e-300);
    [open[0] / linear, open[1] / angular]
}

/// Work of partners in a window \[J\].
pub(crate) fn worked(report: &Report) -> f64 {
    report.interfaces.iter().map(|i| i.work_j).sum()
}

pub(crate) fn energy(report: &Report) -> f64 {
    report.energy.kinetic_j + report.energy.potential_j
}
