//! What must hold bit by bit or to rounding: momentum with partners, threads, restore, refusals.

#[cfg(test)]
mod common;

use common::{Float, Run, columns, liquid, meets, scene, tank, water};
use cosplat_core::boundary::{BoundaryState, Impulses, SampleStatics, Samples, add, cross, norm};
use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{Inputs, PartnerInput, PartnerSetup, Plugin, PluginError, SolverScene};
use cosplat_core::scene::{Material, MotionRule, Source, Wall};
use cosplat_sph::Sph;

/// A tank with a column that collapses onto a raft.
fn slosh(threads: usize, pressure: &str) -> (SolverScene, Float) {
    let (d, size) = (0.02, [0.1, 0.1, 0.06]);
    let body = liquid(water(25.0, 1.0), [0.24, 0.2, 0.4], [0.12, 0.1, 0.2], d);
    let mut start = scene(vec![body], tank(0.5, 0.2, Wall::NoSlip), 2e-3);
    start.threads = threads;
    start.params.insert("pressure".into(), pressure.into());
    start.interfaces.push(meets("raft", BoundaryForm::Proxy, Some(Source::Box { size_m: size }), 0.5));
    (start, Float::new(0.3, size, [0.32, 0.1, 0.08]))
}

/// State after some windows, and the raft.
fn played(threads: usize, windows: u32, pressure: &str) -> (Run, Float) {
    let (start, mut raft) = slosh(threads, pressure);
    let mut run = Run::new(start);
    for _ in 0..windows {
        let out = run.step_with(&raft.inputs(2e-3));
        raft.take(&out, 2e-3);
    }
    (run, raft)
}

#[test]
fn what_the_liquid_loses_the_raft_receives() {
    exchanges("wcsph");
}

#[test]
fn what_an_incompressible_liquid_loses_the_raft_receives() {
    exchanges("dfsph");
}

fn exchanges(pressure: &str) {
    let (start, mut raft) = slosh(2, pressure);
    let mut run = Run::new(start);
    let (mut mismatch, mut touched) = (0.0_f64, 0.0_f64);
    for _ in 0..80 {
        let out = run.step_with(&raft.inputs(2e-3));
        let Impulses::Rigid(j) = &out.impulses[0].1 else { panic!("a rigid impulse") };
        let got = out.report.interfaces[0].received;
        let about = add(j.angular, cross(raft.record.position, j.linear));
        mismatch = mismatch.max(norm(add(got.linear, j.linear))).max(norm(add(got.angular, about)));
        touched = touched.max(out.report.interfaces[0].gross);
        raft.take(&out, 2e-3);
    }
    println!("raft {:?} {:?}", raft.record.position, raft.record.orientation);
    println!("mismatch {mismatch:e}, defect {:?} of {}, touched {touched}", run.defect, run.gross);
    assert!(touched > 0.01, "the water reached the raft");
    // Roundings of sums of some thousand impulses in double precision.
    assert!(mismatch < 1e-13, "{mismatch}");
    assert!(
        run.defect[0] < 1e-12 * run.gross && run.defect[1] < 1e-12 * run.gross,
        "{:?} of {}",
        run.defect,
        run.gross
    );
}

/// Five strokes a second \[rad/s\].
const STROKES: f64 = 10.0 * std::f64::consts::PI;

/// A tank of samples, `n` spacings wide and `2 n` high, that moves up and down: below and beside the liquid by half a
/// spacing, so that its first particles are one spacing away.
fn vessel(n: i32, d: f64, t: f64) -> Samples {
    let mut samples = Samples::default();
    let lift = 0.002 * (STROKES * t).sin();
    let mut add = |at: [i32; 3], normal: [f64; 3]| {
        let [x, y, z] = at.map(|i| (f64::from(i) + 0.5) * d);
        samples.position.push([x, y, z + lift]);
        samples.velocity.push([0.0, 0.0, 0.002 * STROKES * (STROKES * t).cos()]);
        samples.normal.push(normal);
    };
    for i in -1..=n {
        for j in -1..=n {
            add([i, j, -1], [0.0, 0.0, 1.0]);
        }
    }
    for k in 0..2 * n {
        for i in 0..n {
            add([-1, i, k], [1.0, 0.0, 0.0]);
            add([n, i, k], [-1.0, 0.0, 0.0]);
            add([i, -1, k], [0.0, 1.0, 0.0]);
            add([i, n, k], [0.0, -1.0, 0.0]);
        }
        for (i, j) in [(-1, -1), (-1, n), (n, -1), (n, n)] {
            let to_middle = |i: i32| f64::copysign(std::f64::consts::FRAC_1_SQRT_2, f64::from(n / 2 - i));
            add([i, j, k], [to_middle(i), to_middle(j), 0.0]);
        }
    }
    samples
}

#[test]
fn a_vessel_of_samples_carries_the_water() {
    let (d, n, window) = (0.02, 8, 2e-3);
    let side = f64::from(n) * d;
    let body = liquid(water(25.0, 1.0), [side; 3], [0.5 * side; 3], d);
    let weight = 1000.0 * side * side * side * 9.81;
    let mut start = scene(vec![body], Vec::new(), window);
    start.interfaces.push(meets("vessel", BoundaryForm::SamplesF64 { normals: true }, None, 0.0));
    let count = vessel(n, d, 0.0).position.len();
    let (area_m2, volume_m3) = (vec![d * d; count], vec![d * d * d; count]);
    let statics = SampleStatics { area_m2, volume_m3, ..SampleStatics::equal(count, 0.01) };
    let mut run = Run::with(start, &[PartnerSetup { interface: 0, statics }]);
    let (mut mismatch, mut given, mut time) = (0.0_f64, 0.0, 0.0);
    while run.time() < 0.8 - 0.5 * window {
        let at = vessel(n, d, run.time());
        let now = BoundaryState::Samples(at.clone());
        let partner = PartnerInput { interface: 0, rule: MotionRule::Hold, now, next: None, length_s: window };
        let out = run.step_with(&Inputs { partners: vec![partner], impulses: Vec::new() });
        let Impulses::Samples(each) = &out.impulses[0].1 else { panic!("samples") };
        assert_eq!(each.len(), at.position.len());
        let total = out.impulses[0].1.total();
        mismatch = mismatch.max(norm(add(out.report.interfaces[0].received.linear, total)));
        if run.time() > 0.4 + 0.5 * window {
            (given, time) = (given - total[2], time + window);
        }
    }
    let (x, ..) = columns(&run.bytes());
    let outside = x.iter().filter(|x| x[2] < 0.0 || (0..2).any(|k| x[k] < 0.0 || x[k] > side)).count();
    println!("mean force {} of {weight} in {time} s, {outside} outside, mismatch {mismatch:e}", given / time);
    println!("defect {:?} of {}", run.defect, run.gross);
    // Roundings of sums of some thousand impulses in double precision.
    assert!(mismatch < 1e-13, "{mismatch}");
    assert!(
        run.defect[0] < 1e-12 * run.gross && run.defect[1] < 1e-12 * run.gross,
        "{:?} of {}",
        run.defect,
        run.gross
    );
    assert_eq!(outside, 0, "nothing leaves the vessel");
    // Over two whole strokes its own motion gives nothing; sloshing left over may change the momentum by 2 % of the
    // weight times 0.4 s, a centre of mass that rises by 8 cm/s instead of falling.
    assert!((given / time / weight - 1.0).abs() < 0.02, "{}", given / time);
}

#[test]
fn a_sheet_bears_water_on_both_sides() {
    let (d, n, window) = (0.02, 8, 2e-3);
    let side = f64::from(n) * d;
    // Two blocks, half a spacing off a sheet at z = 0, move against it.
    let points = |up: f64| {
        (0..n * n * 3)
            .map(move |i| [i % n, i / n % n, i / n / n].map(f64::from))
            .map(move |[x, y, z]| [(x + 0.5) * d, (y + 0.5) * d, up * (z + 1.0) * d])
    };
    let mut body = liquid(water(25.0, 1.0), [1.0; 3], [0.0; 3], d);
    body.source = Source::Points { positions_m: points(1.0).chain(points(-1.0)).collect() };
    body.velocity = cosplat_core::scene::VelocityField::LinearMap {
        linear_m_s: [0.0; 3],
        gradient_1_s: [[0.0; 3], [0.0; 3], [0.0, 0.0, -10.0]],
        about_m: [0.0; 3],
    };
    let mut start = scene(vec![body], tank(side, side, Wall::Slip).split_off(1), window);
    start.actions.clear();
    start.interfaces.push(meets("sheet", BoundaryForm::SamplesF64 { normals: true }, None, 0.0));
    let samples = Samples {
        position: (-2..n + 2)
            .flat_map(|i| (-2..n + 2).map(move |j| [i, j]))
            .map(|[i, j]| [i, j].map(|i| (f64::from(i) + 0.5) * d))
            .map(|[x, y]| [x, y, 0.0])
            .collect(),
        ..Samples::default()
    };
    let count = samples.position.len();
    let samples = Samples { velocity: vec![[0.0; 3]; count], normal: vec![[0.0, 0.0, 1.0]; count], ..samples };
    let (area_m2, volume_m3) = (vec![d * d; count], vec![0.1 * d * d * d; count]);
    let statics = SampleStatics { area_m2, volume_m3, ..SampleStatics::equal(count, 0.01) };
    let mut run = Run::with(start, &[PartnerSetup { interface: 0, statics }]);
    let (mut sum, mut gross) = (0.0, 0.0);
    for _ in 0..25 {
        let now = BoundaryState::Samples(samples.clone());
        let partner = PartnerInput { interface: 0, rule: MotionRule::Hold, now, next: None, length_s: window };
        let out = run.step_with(&Inputs { partners: vec![partner], impulses: Vec::new() });
        (sum, gross) = (sum + out.impulses[0].1.total()[2], gross + out.report.interfaces[0].gross);
    }
    let (x, ..) = columns(&run.bytes());
    let above = x.iter().filter(|x| x[2] > 0.0).count();
    println!("{above} of {} above, impulse {sum:e} of {gross}", x.len());
    // By symmetry both sides press alike, but for the order of sums: of rates of densities, of which 24 bits are kept.
    let rounded = f64::from(f32::EPSILON);
    assert!(above * 2 == x.len() && gross > 0.1 && sum.abs() < rounded * gross, "{above} {sum} {gross}");
}

#[test]
fn threads_change_nothing() {
    same_with_threads("wcsph");
    same_with_threads("dfsph");
}

fn same_with_threads(pressure: &str) {
    let (one, raft) = played(1, 30, pressure);
    let particles: u64 = one.setup.particles.iter().sum();
    println!("{particles} particles, {} substeps", one.substeps);
    assert!(particles >= 2000, "enough to share among threads");
    for threads in [2, 3] {
        let (other, same) = played(threads, 30, pressure);
        assert_eq!(other.hash(), one.hash(), "{threads} threads");
        assert_eq!(same.record, raft.record);
    }
}

#[test]
fn restore_is_bitwise() {
    restores("wcsph");
    restores("dfsph");
}

fn restores(pressure: &str) {
    let (mut run, raft) = played(2, 25, pressure);
    let (saved, window) = (run.bytes(), run.window);
    let after = |run: &mut Run| {
        let mut raft = raft;
        for _ in 0..6 {
            let out = run.step_with(&raft.inputs(2e-3));
            raft.take(&out, 2e-3);
        }
        (run.bytes(), raft.record)
    };
    let first = after(&mut run);
    run.plugin.restore(&saved).expect("it fits");
    run.window = window;
    assert!(run.bytes() == saved && after(&mut run) == first, "same solver, restored");
    let mut fresh = Run::new(slosh(1, pressure).0);
    fresh.plugin.restore(&saved).expect("it fits");
    fresh.window = window;
    assert!(after(&mut fresh) == first, "fresh solver, restored");
    assert!(fresh.plugin.restore(&saved[1..]).is_err());
    assert!(Sph::default().restore(&saved).is_err());
}

#[test]
fn what_it_cannot_do_is_refused_by_name() {
    let body = liquid(water(20.0, 1.0), [0.1; 3], [0.0; 3], 0.02);
    let refused = |change: &dyn Fn(&mut SolverScene)| {
        let mut start = scene(vec![body.clone()], Vec::new(), 1e-3);
        change(&mut start);
        Sph::default().setup(&start).expect_err("refused").to_string()
    };
    let tension = |s: &mut SolverScene, value: f64| {
        if let Material::SphLiquid { surface_tension_n_m, .. } = &mut s.bodies[0].material {
            *surface_tension_n_m = value;
        }
    };
    // Bond numbers of a particle of 2 cm: 0.1 and 392. The first would press it by 178 · 40 Pa, where 0.1 ρ c² is 40 kPa.
    assert!(refused(&|s| tension(s, 300.0)).contains("surface tension of 300 N/m"));
    let kept = refused(&|s| {
        tension(s, 1.0);
        *s = common::incompressible(s.clone());
    });
    assert!(kept.contains("surface tension of the incompressible liquid `water`"), "{kept}");
    let mut weak = scene(vec![body.clone()], Vec::new(), 1e-3);
    tension(&mut weak, 0.01);
    let left_out = Sph::default().setup(&weak).expect("a scene it takes").left_out;
    let bond = left_out.iter().find(|l| l.what.contains("surface tension")).and_then(|l| l.indicator);
    assert!(bond.is_some_and(|b| (b - 392.4).abs() < 1e-9), "{left_out:?}");
    assert!(refused(&|s| s.bodies[0].mass_kg = Some(1.0)).contains("a mass beside the density"));
    assert!(refused(&|s| s.bodies[0].spacing_m = Some(-1.0)).contains("spacing"));
    assert!(refused(&|s| s.params.extend([("courant".to_owned(), (-1.0).into())])).contains("`courant`"));
    let wide = SampleStatics { area_m2: vec![0.01; 4], ..SampleStatics::equal(4, 0.01) };
    let mut start = scene(vec![body.clone()], Vec::new(), 1e-3);
    start.interfaces.push(meets("net", BoundaryForm::SamplesF32 { normals: false }, None, 0.0));
    let mut plugin = Sph::default();
    plugin.setup(&start).expect("a scene it takes");
    let why = plugin.connect(&[PartnerSetup { interface: 0, statics: wide }]).unwrap_err().to_string();
    assert!(why.contains("`net` a spacing of at most 0.030 m"), "{why}");
    // A jet faster than its sound.
    let mut fast = scene(vec![body], Vec::new(), 1e-3);
    fast.bodies[0].velocity =
        cosplat_core::scene::VelocityField::Twist { linear_m_s: [30.0, 0.0, 0.0], angular_rad_s: [0.0; 3] };
    let mut plugin = Sph::default();
    plugin.setup(&fast).expect("a scene it takes");
    let step = cosplat_conformance::parts::step(&fast.clock, 0);
    let why = plugin.advance(&step, &Inputs::default(), &mut cosplat_core::plugin::Steady).unwrap_err();
    assert!(matches!(&why, PluginError::Physics(w) if w.contains("faster than sound")), "{why}");
}

#[test]
fn gravity_that_begins_and_ends_supplies_what_the_energy_gains() {
    for pressure in ["wcsph", "dfsph"] {
        // A block in flight: nothing but gravity does work.
        let body = liquid(water(25.0, 1.0), [0.1; 3], [0.0, 0.0, 3.0], 0.02);
        let mut start = scene(vec![body], Vec::new(), 0.01);
        start.params.insert("pressure".into(), pressure.into());
        start.actions[0].from_s = 0.025;
        start.actions[0].until_s = Some(0.08);
        let mut run = Run::new(start);
        let whole = |e: cosplat_core::plugin::Energy| e.kinetic_j + e.potential_j + e.dissipated_j;
        let (before, mut supplied, mut last) = (whole(run.setup.report.energy), 0.0, 0.0);
        for _ in 0..12 {
            let report = run.step().report;
            supplied += report.supplied_j;
            last = whole(report.energy);
        }
        println!("{pressure}: {before} J, supplied {supplied} J, then {last} J");
        // A kilogram that falls 0.055 s gains 0.1456 J. A substep that velocity begins moves g dt²/2 too far: dt/0.055 s.
        let (share, exact) = (2.0 * 0.01 / 0.055, 0.5 * (9.81_f64 * 0.055).powi(2));
        assert!((last - before - supplied).abs() < share * exact, "{}", last - before - supplied);
        assert!((supplied - exact).abs() < share * exact, "{supplied} of {exact}");
    }
}
