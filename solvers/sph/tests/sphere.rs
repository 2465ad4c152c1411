//! A rigid sphere in a liquid: what lifts it.
//!
//! At rest the lift is the weight of the liquid that is missing, whatever presses the sphere: liquid that was cut away around
//! it too generously leaves a gap, which a liquid without tension does not close. A lattice without what lies nearer than
//! half a spacing to a sphere of three spacings has lost 1.4 to 1.6 times its volume, and lifts it by as much. The solver
//! leaves out as much as the sphere takes.

#[cfg(test)]
mod common;

use common::{Float, Run, liquid, meets, scene, tank, water};
use cosplat_core::boundary::{Impulses, Vec3, norm, scale, sub};
use cosplat_core::plan::BoundaryForm;
use cosplat_core::scene::{Pose, Source, Wall};

const DENSITY: f64 = 1000.0;
const GRAVITY: f64 = 9.81;
/// Spacing of the liquid \[m\].
const D: f64 = 0.005;
/// Angle by which a spiral turns from point to point, `π (3 - √5)`.
const GOLDEN: f64 = 2.399_963_229_728_653;

fn volume(radius: f64) -> f64 {
    4.0 / 3.0 * std::f64::consts::PI * radius.powi(3)
}

/// Places of the particles of a liquid that fills a tank around a sphere: `layers` a spacing apart about the sphere, the first
/// half a spacing from it, and a lattice without as many of its nearest cells as the sphere and the layers hold.
fn around(d: f64, size: Vec3, at: Vec3, radius: f64, layers: usize) -> Vec<Vec3> {
    let cells = |r: f64| volume(r) / d.powi(3);
    let mut all = Vec::new();
    for k in 0..layers {
        let [low, high] = [k, k + 1].map(|k| radius + k as f64 * d);
        let count = (cells(high) - cells(radius)).round() as usize - all.len();
        let r = (0.5 * (low.powi(3) + high.powi(3))).cbrt();
        // Points of a spiral at equal steps of height lie evenly on a sphere.
        all.extend((0..count).map(|i| {
            let z = (2.0 * i as f64 + 1.0) / count as f64 - 1.0;
            let (turn, across) = (GOLDEN * i as f64 + k as f64, r * (1.0 - z * z).sqrt());
            [at[0] + across * turn.cos(), at[1] + across * turn.sin(), at[2] + r * z]
        }));
    }
    let n = size.map(|l| (l / d).round() as usize);
    let cell = |i: usize| [i % n[0], i / n[0] % n[1], i / n[0] / n[1]].map(|i| i as f64 + 0.5);
    let cell = |i: usize| [0, 1, 2].map(|k| cell(i)[k] * size[k] / n[k] as f64);
    let mut lattice: Vec<Vec3> = (0..n.iter().product()).map(cell).collect();
    lattice.sort_by(|a, b| norm(sub(*a, at)).total_cmp(&norm(sub(*b, at))));
    all.extend(lattice.split_off(cells(radius).round() as usize + all.len()));
    all
}

/// A bath of that viscosity with a sphere of that radius and mass in `layers`, or without any in what the solver leaves of a
/// lattice, `off` from a corner of the lattice's cells
/// \[Pa s, m, kg, -, spacings\].
fn bath(
    viscosity: f64,
    [radius, mass]: [f64; 2],
    layers: usize,
    off: f64,
    pressure: &str,
    window: f64,
) -> (Run, Float) {
    // Eight spacings beside it, and five above and below.
    let [side, height] = [8.0, 10.0].map(|room| (2.0 * radius / D + room).round() * D);
    let at = [0.5 * side + off * D, 0.5 * side + 0.7 * off * D, 0.5 * height + 0.4 * off * D];
    let size = [side, side, height];
    let mut body = liquid(water(20.0, viscosity), size, scale(size, 0.5), D);
    if layers > 0 {
        body = liquid(water(20.0, viscosity), size, [0.0; 3], D);
        body.source = Source::Points { positions_m: around(D, size, at, radius, layers) };
    }
    let mut start = scene(vec![body], tank(side, side, Wall::Slip), window);
    start.params.insert("pressure".into(), pressure.into());
    let mut face = meets("ball", BoundaryForm::Proxy, Some(Source::Sphere { radius_m: radius }), 0.0);
    face.partner_pose = (layers == 0).then_some(Pose { position_m: at, orientation: [0.0, 0.0, 0.0, 1.0] });
    start.interfaces.push(face);
    (Run::new(start), Float::new(mass, [2.0 * radius; 3], at))
}

/// A viscosity with which what the start sets in motion comes to rest within a tenth of a second \[Pa s\].
const THICK: f64 = 1.0;

/// Lift of a sphere that is held, over the weight of its volume, in the mean over the second half of 0.3 s.
fn lift(across: f64, layers: usize, off: f64, pressure: &str) -> f64 {
    let (radius, window, windows) = (across * D, 2e-3, 150);
    let (mut run, mut ball) = bath(THICK, [radius, f64::INFINITY], layers, off, pressure, window);
    ball.record.background_linear = [0.0; 3];
    let mut sum = 0.0;
    for w in 0..windows {
        let out = run.step_with(&ball.inputs(window));
        let Impulses::Rigid(j) = &out.impulses[0].1 else { panic!("a rigid impulse") };
        if w >= windows / 2 {
            sum += j.linear[2] / window / f64::from(windows - windows / 2);
        }
    }
    let found = sum / (DENSITY * GRAVITY * volume(radius));
    println!("{pressure}, R = {across} d, {layers} layers, {off} d off: lift {found:.4}");
    found
}

#[test]
fn a_held_sphere_is_lifted_by_the_weight_of_its_volume() {
    for off in [0.0, 0.5] {
        // A fiftieth of a sphere of three spacings is a fiftieth of a spacing around it. What is left of a lattice lies roughly
        // around it: a liquid that keeps its volume undoes what is too full, but closes no gap, so that a twentieth is asked
        // for. One whose density makes the pressure takes layers for a strained lattice; on a lattice its particles still settle.
        for (pressure, layers, gate) in [("dfsph", 3, 0.02), ("dfsph", 0, 0.05), ("wcsph", 0, 0.05)] {
            let found = lift(3.0, layers, off, pressure);
            assert!((found - 1.0).abs() < gate, "{pressure}: {found}");
        }
    }
}
