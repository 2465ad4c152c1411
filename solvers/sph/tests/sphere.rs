//! A rigid sphere in a liquid: what lifts it, and how it settles.
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
use cosplat_core::scene::{Material, Pose, Source, Wall};

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

/// Tank, diameter of the sphere, how high its lowest point starts \[m\], its density, and that and the viscosity of the oil
/// \[kg/m³, Pa s\]; its largest speed as measured \[m/s\]: experiment E1 of ten Cate, Nieuwstad, Derksen and Van den Akker
/// ("Particle imaging velocimetry experiments and lattice-Boltzmann simulations on a single sphere settling under gravity",
/// 2002).
const TANK: Vec3 = [0.1, 0.1, 0.16];
const DIAMETER: f64 = 0.015;
const START: f64 = 0.12;
const HEAVY: f64 = 1120.0;
const OIL: [f64; 2] = [970.0, 0.373];
const FASTEST: f64 = 0.035_986;

/// Largest speed of a sphere with that many particles across, a multiple of three so that the tank is full, that settles for
/// 0.6 s \[m/s\].
fn settle(across: f64) -> f64 {
    let (d, radius, window) = (DIAMETER / across, 0.5 * DIAMETER, 2e-3);
    let at = [0.5 * TANK[0], 0.5 * TANK[1], START + radius];
    let mut oil = liquid(water(20.0, OIL[1]), TANK, [0.0; 3], d);
    if let Material::SphLiquid { density_kg_m3, .. } = &mut oil.material {
        *density_kg_m3 = OIL[0];
    }
    oil.source = Source::Points { positions_m: around(d, TANK, at, radius, 3) };
    let mut start = scene(vec![oil], tank(TANK[0], TANK[1], Wall::NoSlip), window);
    start.params.insert("pressure".into(), "dfsph".into());
    start.params.insert("artificial_viscosity".into(), 0.0.into());
    start.interfaces.push(meets("ball", BoundaryForm::Proxy, Some(Source::Sphere { radius_m: radius }), 0.5));
    let mass = HEAVY * volume(radius);
    // Of the box in `Float` that has the sphere's moment of inertia.
    let mut ball = Float::new(mass, [DIAMETER * 0.6_f64.sqrt(); 3], at);
    let free = ball.record;
    (ball.record.mass, ball.record.background_linear) = (f64::INFINITY, [0.0; 3]);
    let (mut run, mut most, mut lift) = (Run::new(start), 0.0_f64, 0.0);
    // It is held until the oil has come to rest around it.
    for w in 0..50 {
        let out = run.step_with(&ball.inputs(window));
        let Impulses::Rigid(j) = &out.impulses[0].1 else { panic!("a rigid impulse") };
        lift += if w < 25 { 0.0 } else { j.linear[2] / window / 25.0 };
    }
    println!("{across} across: lift {}", lift / (OIL[0] * GRAVITY * volume(radius)));
    ball.record = free;
    for _ in 0..300 {
        let out = run.step_with(&ball.inputs(window));
        ball.take(&out, window);
        most = most.max(-ball.record.linear_velocity[2]);
        if run.window % 10 == 0 {
            println!(
                "{:.3} s: {:.5} m/s at {:.4} m",
                run.time(),
                ball.record.linear_velocity[2],
                ball.record.position[2]
            );
        }
    }
    most
}

#[test]
#[ignore = "not met: with six particles across the lattice, which buckles under the pressure, stirs the oil at up to 0.06 m/s, faster than the sphere settles, and carries it up again after 0.2 s, with any accuracy of the pressures; in thicker oil it is lifted to 0.3 %"]
fn a_sphere_settles_as_measured() {
    let found = settle(6.0);
    // The catalogue's gate.
    assert!((found / FASTEST - 1.0).abs() < 0.05, "{found} m/s");
}
