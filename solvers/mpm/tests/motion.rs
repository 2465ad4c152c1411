//! Free motion: fall, flight, rest, spin.

use crate::common::{Run, body, cuboid, elastic, gravity, moving, scene};
use cosplat_core::scene::{Action, ActionKind, Field, Source};
use cosplat_mpm::Real;

fn cube(velocity: [f64; 3]) -> cosplat_core::scene::Body {
    let at = [1.03, -0.52, 2.01];
    moving(body("cube", elastic(1000.0, 1e5, 0.3), cuboid([0.2; 3]), at, 0.01), velocity, [0.0; 3])
}

/// Free fall for 0.4 s from v0: error of the height against symplectic Euler, which is exact here, and of the velocity.
fn fall<R: Real>() -> [f64; 2] {
    let mut start = scene(vec![cube([3.0, 0.0, 4.0])], 0.01);
    start.actions.push(gravity(-9.81));
    let mut run = Run::<R>::new(start);
    let mut sum = 0.0;
    let mut state = run.setup.report.bodies[0];
    let z0 = state.position_m[2];
    let mut v: f64 = 4.0;
    for _ in 0..40 {
        let out = run.step();
        state = out.report.bodies[0];
        let (n, dt) = (out.report.substeps as f64, 0.01 / out.report.substeps as f64);
        sum += v * 0.01 - 9.81 * dt * dt * n * (n + 1.0) / 2.0;
        v -= 9.81 * 0.01;
    }
    println!("{} substeps", run.substeps);
    [(state.position_m[2] - z0 - sum).abs(), (state.linear_velocity_m_s[2] - v).abs()]
}

#[test]
fn falls_as_symplectic_euler_does() {
    let [height, speed] = fall::<f64>();
    println!("f64: {height:e} m, {speed:e} m/s");
    // Rounding of a few hundred sums of numbers of size 4.
    assert!(height < 1e-12 && speed < 1e-12, "{height} {speed}");
    let [height, speed] = fall::<f32>();
    println!("f32: {height:e} m, {speed:e} m/s");
    // Each substep rounds a velocity of up to 5 m/s once on the grid and once on the particle: 2.4e-7 each, some
    // hundred substeps, all to the same side at worst.
    assert!(speed < 1e-4 && height < 4e-5, "{height} {speed}");
}

#[test]
fn what_pushes_supplies_what_the_energy_gains() {
    let mut start = scene(vec![cube([3.0, 0.0, 4.0])], 0.01);
    let at = |kind, from_s, until_s| Action { kind, bodies: Vec::new(), from_s, until_s };
    let field = Field::Constant { acceleration_m_s2: [0.0, 5.0, 2.0] };
    start.actions = vec![
        at(ActionKind::Impulse { impulse_n_s: [8.0, -4.0, 2.0], at_m: None }, 0.023, None),
        at(ActionKind::AccelerationField { field }, 0.05, Some(0.083)),
        at(ActionKind::Gravity { acceleration_m_s2: [0.0, 0.0, -9.81] }, 0.03, Some(0.1)),
    ];
    let mut run = Run::<f64>::new(start);
    let (before, mut supplied) = (run.setup.report.energy.kinetic_j, 0.0);
    let mut last = 0.0;
    for _ in 0..12 {
        let report = run.step().report;
        supplied += report.supplied_j;
        last = report.energy.kinetic_j + report.energy.potential_j;
    }
    println!("{before} J, supplied {supplied} J, then {last} J");
    // Roundings of sums over eight thousand particles of 100 J in all.
    assert!(supplied > 5.0 && (last - before - supplied).abs() < 1e-10, "{}", last - before - supplied);
}

#[test]
fn rest_stays_rest() {
    let mut run = Run::<f32>::new(scene(vec![cube([0.0; 3])], 0.01));
    for _ in 0..5 {
        let out = run.step();
        assert!(out.report.bodies[0].gross_momentum <= 0.0);
        assert!(out.report.energy.potential_j.abs() <= 0.0);
    }
}

#[test]
fn flight_strains_nothing() {
    let mut run = Run::<f32>::new(scene(vec![cube([3.0, -1.0, 4.0])], 0.01));
    for _ in 0..20 {
        run.step();
    }
    let energy = run.step().report.energy;
    println!(
        "elastic {:e} of kinetic {:e}; defect {:?} of {}",
        energy.potential_j, energy.kinetic_j, run.defect, run.gross
    );
    // Strain of rounding: (1e-6)² of the modulus over ρ v².
    assert!(energy.potential_j < 1e-9 * energy.kinetic_j);
    assert!(run.defect[0] < 1e-6 * run.gross, "{:?}", run.defect);
}

/// Relative drift of linear and angular momentum, and loss of energy, of a spinning ball over one turn.
fn spin<R: Real>() -> [f64; 3] {
    let ball = body("ball", elastic(1000.0, 1e5, 0.3), Source::Sphere { radius_m: 0.1 }, [0.3, 0.1, 0.2], 0.0125);
    let start = scene(vec![moving(ball, [0.5, 0.0, 0.0], [0.0, 0.0, 10.0])], 0.01);
    let mut run = Run::<R>::new(start);
    let (p, e) = (run.momentum, run.setup.report.energy);
    let mut energy = e;
    for _ in 0..63 {
        energy = run.step().report.energy;
    }
    println!("{} substeps", run.substeps);
    let now = run.momentum.minus(p);
    let drift = |d: [f64; 3], of: [f64; 3]| crate::common::shifted(d, [0.0; 3]) / crate::common::shifted(of, [0.0; 3]);
    let loss = 1.0 - (energy.kinetic_j + energy.potential_j) / e.kinetic_j;
    [drift(now.linear, p.linear), drift(now.angular, p.angular), loss]
}

#[test]
fn spin_keeps_angular_momentum() {
    let f64s = spin::<f64>();
    println!("f64 {f64s:?}");
    // Exact transfers: rounding only.
    assert!(f64s[0] < 1e-12 && f64s[1] < 1e-12, "{f64s:?}");
    let f32s = spin::<f32>();
    println!("f32 {f32s:?}");
    assert!(f32s[0] < 1e-5 && f32s[1] < 1e-5, "{f32s:?}");
    // Energy that the transfers of a body twelve cells across lose in one turn.
    assert!(f32s[2] > 0.0 && f32s[2] < 0.02, "{f32s:?}");
}

#[test]
fn one_particle_flies_and_nothing_is_nothing() {
    let mut one =
        body("point", elastic(1000.0, 1e5, 0.3), Source::Points { positions_m: vec![[0.1; 3]] }, [0.0; 3], 0.01);
    one = moving(one, [1.0, 2.0, -3.0], [0.0; 3]);
    let mut start = scene(vec![one], 0.01);
    start.actions.push(gravity(-9.81));
    let mut run = Run::<f32>::new(start);
    for _ in 0..50 {
        run.step();
    }
    let state = run.step().report.bodies[0];
    // 51 windows of 0.01 s.
    assert!((state.linear_velocity_m_s[2] + 3.0 + 9.81 * 0.51).abs() < 1e-4, "{state:?}");
    assert!((state.position_m[0] - 0.1 - 0.51).abs() < 1e-5, "{state:?}");
    let mut none = Run::<f32>::new(scene(Vec::new(), 0.01));
    let out = none.step();
    assert!(out.report.bodies.is_empty() && out.report.substeps == 1, "{:?}", out.report);
}
