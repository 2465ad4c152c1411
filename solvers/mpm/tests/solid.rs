//! Elastic and plastic solids against closed forms.

use crate::common::{
    Run, TO_MINUS_X, TO_MINUS_Y, TO_X, TO_Y, body, cuboid, elastic, gravity, moving, plane, scene, set,
};
use cosplat_core::plugin::{Inputs, SolverScene};
use cosplat_core::scene::{Material, Wall};
use cosplat_mpm::Real;

/// A bar along z from z = 0 up, one or more cells wide, between slip walls, its foot held at z = 0.
fn bar(material: Material, length: f64, cells: usize, foot: Wall, window_s: f64) -> SolverScene {
    let dx = length / cells as f64;
    let mut scene = scene(
        vec![body("bar", material, cuboid([dx, dx, length]), [0.5 * dx, 0.5 * dx, 0.5 * length], dx / 2.0)],
        window_s,
    );
    scene.statics = vec![
        plane("foot", [0.0; 3], crate::common::UPRIGHT, foot),
        plane("left", [0.0; 3], TO_X, Wall::Slip),
        plane("right", [dx, 0.0, 0.0], TO_MINUS_X, Wall::Slip),
        plane("front", [0.0; 3], TO_Y, Wall::Slip),
        plane("back", [0.0, dx, 0.0], TO_MINUS_Y, Wall::Slip),
    ];
    scene
}

/// Fixed-free bar of 1 m, c = 31.6 m/s, thrown at 0.1 m/s away from its foot: its centre of mass moves in a triangle
/// wave of period 4 L / c = 0.12649 s. Returns the mean period over `periods` and the amplitude kept.
fn vibrate<R: Real>(cells: usize, periods: usize) -> (f64, f64) {
    let mut scene = bar(elastic(1000.0, 1e6, 0.0), 1.0, cells, Wall::NoSlip, 0.5e-3);
    scene.bodies[0] = moving(scene.bodies[0].clone(), [0.0, 0.0, 0.1], [0.0; 3]);
    let mut run = Run::<R>::new(scene);
    let rest = run.setup.report.bodies[0].position_m[2];
    let (mut crossings, mut before, mut last_peak, mut peak) = (Vec::new(), 0.0, 0.0_f64, 0.0_f64);
    let mut first_peak = 0.0;
    while crossings.len() < periods {
        let z = run.step().report.bodies[0].position_m[2] - rest;
        let t = run.window as f64 * 0.5e-3;
        if before < 0.0 && z >= 0.0 {
            crossings.push(t - 0.5e-3 * z / (z - before));
            if crossings.len() == 1 {
                first_peak = peak;
            }
            (last_peak, peak) = (peak, 0.0);
        }
        peak = peak.max(z);
        before = z;
    }
    println!("{cells} cells: {} substeps, crossings {crossings:?}", run.substeps);
    assert!(run.defect[0] < 1e-6 * run.gross.max(1e-9) * 20.0, "{:?} of {}", run.defect, run.gross);
    (crossings[periods - 1] / periods as f64, last_peak / first_peak)
}

#[test]
fn bar_vibrates_at_the_period_of_its_wave() {
    let exact = 4.0 / 1000.0_f64.sqrt();
    let (period, kept) = vibrate::<f32>(20, 4);
    println!("period {period} of {exact}, amplitude kept {kept}");
    assert!((period / exact - 1.0).abs() < 0.02, "{period}");
    assert!(kept > 0.95, "{kept}");
}

/// Column of M8 (H = 10 m, E = 1e4, ν = 0, ρ = 80) under gravity that is switched on slowly by stages of settling.
fn settle(cells: usize) -> f64 {
    let mut scene = bar(elastic(80.0, 1e4, 0.0), 10.0, cells, Wall::Slip, 0.02);
    // Gravity in 100 equal steps over 40 s (the period is 4 s), so that the swing stays small.
    scene.actions =
        (0..100).map(|i| cosplat_core::scene::Action { from_s: 0.4 * f64::from(i), ..gravity(-0.0981) }).collect();
    let mut run = Run::<f32>::new(scene);
    let start = run.setup.report.bodies[0].position_m[2];
    let mut mean = 0.0;
    for window in 0..2600 {
        let z = run.step().report.bodies[0].position_m[2];
        if window >= 2000 {
            mean += z / 600.0;
        }
    }
    println!(
        "{cells} cells: centre sinks {} m, {} substeps, defect {:?} of {}",
        start - mean,
        run.substeps,
        run.defect,
        run.gross
    );
    start - mean
}

/// Sinking of the centre of mass from the exact deformation `F = (p + √(p² + 4))/2`, `p = -ρ g (H - X)/μ`.
fn sinks_exactly() -> f64 {
    let (h, mu, weight, n) = (10.0, 5e3, 80.0 * 9.81, 10_000);
    let stretch = |x: f64| {
        let p = -weight * (h - x) / mu;
        0.5 * (p + (p * p + 4.0_f64).sqrt())
    };
    let d = h / f64::from(n);
    let (mut place, mut mean) = (0.0, 0.0);
    for i in 0..n {
        let f = stretch((f64::from(i) + 0.5) * d);
        mean += (place + 0.5 * f * d) / f64::from(n);
        place += f * d;
    }
    assert!((place - 7.023_890_6).abs() < 1e-5, "{place} differs from table D05");
    0.5 * h - mean
}

#[test]
fn column_compacts_as_table_d05() {
    let exact = sinks_exactly();
    let found = settle(20);
    println!("{found} m of {exact} m");
    assert!((found / exact - 1.0).abs() < 0.04, "{found} of {exact}");
}

/// Energy of a cube thrown on a floor, over that of the start, at a Courant number.
fn growth(courant: f64) -> Result<f64, String> {
    // The window holds ten of these substeps, so that rounding their number up does not shorten them.
    let wave = elastic(1000.0, 1e6, 0.3).wave_speed_m_s().expect("a solid");
    let cube = body("cube", elastic(1000.0, 1e6, 0.3), cuboid([0.4; 3]), [0.01, 0.013, 0.2], 0.025);
    let mut scene = scene(vec![moving(cube, [0.1, 0.2, -0.5], [1.0, 0.0, 0.0])], 10.0 * courant * 0.05 / wave);
    scene.statics = vec![plane("floor", [0.0; 3], crate::common::UPRIGHT, Wall::NoSlip)];
    set(&mut scene, "courant", 1.05 * courant);
    let mut run = Run::<f32>::new(scene);
    let start = run.setup.report.energy.kinetic_j;
    let mut energy = start;
    for _ in 0..50 {
        let report = run.try_step(&Inputs::default()).map_err(|e| e.to_string())?.report;
        if report.counters["rollbacks"] > 0 {
            return Err(format!("rolled back {} times", report.counters["rollbacks"]));
        }
        energy = report.energy.kinetic_j + report.energy.potential_j;
    }
    Ok(energy / start)
}

#[test]
fn half_a_courant_number_is_stable_and_more_than_one_is_not() {
    let half = growth(0.5);
    println!("0.5: {half:?}");
    assert!(half.is_ok_and(|g| g < 1.001));
    let above = growth(1.2);
    println!("1.2: {above:?}");
    assert!(above.is_err() || above.is_ok_and(|g| g > 10.0));
}

/// Stress and strain of a free cube pulled by a homogeneous velocity field: elastic modulus from the energy.
fn pulled(material: Material, rate: f64, time: f64) -> (f64, f64) {
    let lateral = -0.22 * rate;
    let mut start = scene(vec![body("cube", material, cuboid([0.1; 3]), [0.0; 3], 0.0125)], time);
    start.bodies[0].velocity = cosplat_core::scene::VelocityField::LinearMap {
        linear_m_s: [0.0; 3],
        gradient_1_s: [[lateral, 0.0, 0.0], [0.0, lateral, 0.0], [0.0, 0.0, rate]],
        about_m: [0.0; 3],
    };
    let mut run = Run::<f64>::new(start);
    let energy = run.step().report.energy;
    (energy.potential_j, energy.dissipated_j)
}

#[test]
fn uniaxial_modulus_is_that_of_the_material() {
    // Within 2e-6 s a wave of 276 m/s crosses 0.5 mm of a cube of 100 mm: all but its skin strains as the field says.
    let (rate, time) = (1000.0, 2e-6);
    let strain: f64 = rate * time;
    let (energy, _) = pulled(elastic(30.0, 2e6, 0.22), rate, time);
    let modulus = energy / 1e-3 / (0.5 * strain * strain);
    println!("E = {modulus}");
    // The relieved skin is 3 % of the volume.
    assert!((modulus / 2e6 - 1.0).abs() < 0.04, "{modulus}");
}

#[test]
fn a_heavy_block_yields_where_it_should() {
    // A body of density 3e5 strained fast: inertia holds the field while it flows; dissipation = σ_y ε_p V.
    let plastic = |norm: &str| {
        let material = Material::Elastoplastic {
            density_kg_m3: 3e5,
            youngs_modulus_pa: 2e6,
            poissons_ratio: 0.49,
            yield_stress_pa: 3e4,
        };
        let mut start = scene(vec![body("cube", material, cuboid([0.1; 3]), [0.0; 3], 0.0125)], 1e-3);
        set(&mut start, "yield_norm", norm);
        let rate = 100.0;
        start.bodies[0].velocity = cosplat_core::scene::VelocityField::LinearMap {
            linear_m_s: [0.0; 3],
            gradient_1_s: [[-0.5 * rate, 0.0, 0.0], [0.0, -0.5 * rate, 0.0], [0.0, 0.0, rate]],
            about_m: [0.0; 3],
        };
        let mut run = Run::<f64>::new(start);
        let out = run.step();
        out.report.energy.dissipated_j / 1e-3
    };
    // ε = ln(1 + 0.1)-like: the field is held, so each particle's logarithmic strain is ∫ rate/(1 + ...) ≈ ln(1.1).
    let (physical, genesis) = (plastic("physical"), plastic("genesis"));
    println!("dissipation per volume: physical {physical}, genesis {genesis}");
    let total: f64 = 1.1_f64.ln();
    let shear = 2e6 / (2.0 * 1.49);
    let plateau = |stress: f64| stress * (total - stress / (3.0 * shear));
    println!("expected {} {}", plateau(3e4), plateau(3e4 * 1.5_f64.sqrt()));
    assert!((physical / plateau(3e4) - 1.0).abs() < 0.05, "{physical}");
    assert!((genesis / plateau(3e4 * 1.5_f64.sqrt()) - 1.0).abs() < 0.05, "{genesis}");
}

#[test]
fn spinning_keeps_its_small_strain_in_single_precision() {
    let energy = |double: bool| {
        let material = elastic(30.0, 2e6, 0.22);
        let cube = body("cube", material, cuboid([0.0625; 3]), [0.0; 3], 1.0 / 128.0);
        let start = scene(vec![moving(cube, [0.0; 3], [0.0, 0.0, 10.0])], 1e-2);
        let sum = |energies: Vec<f64>| energies.iter().sum::<f64>() / energies.len() as f64;
        if double {
            let mut run = Run::<f64>::new(start);
            sum((0..10).map(|_| run.step().report.energy.potential_j).collect())
        } else {
            let mut run = Run::<f32>::new(start);
            sum((0..10).map(|_| run.step().report.energy.potential_j).collect())
        }
    };
    let (single, double) = (energy(false), energy(true));
    println!("elastic energy {single:e} J in f32, {double:e} J in f64");
    // Strain 1.5e-6: storing F in f32 would give 2300 % of it after 20 000 substeps (solver references §1.4).
    assert!((single / double - 1.0).abs() < 0.05, "{single:e} {double:e}");
}

#[test]
fn a_supersonic_plush_survives_the_floor() {
    // c = 7.1 m/s, thrown at 10 m/s (M16).
    let plush = body("plush", elastic(50.0, 2500.0, 0.09), cuboid([0.2; 3]), [0.0, 0.0, 0.12], 0.0125);
    let mut start = scene(vec![moving(plush, [0.0, 0.0, -10.0], [0.0; 3])], 1e-3);
    let rough = Wall::Friction { static_friction: 0.5, kinetic_friction: 0.5 };
    start.statics = vec![plane("floor", [0.0; 3], crate::common::UPRIGHT, rough)];
    let mut run = Run::<f32>::new(start);
    let first = run.setup.report.energy.kinetic_j;
    let (mut most, mut counts) = (0.0_f64, [0; 2]);
    for _ in 0..100 {
        let report = run.step().report;
        most = most.max(report.energy.kinetic_j + report.energy.potential_j);
        counts[0] += report.counters["rollbacks"];
        counts[1] += report.counters["stretch-clamps"];
    }
    let last = run.step().report.bodies[0];
    println!("energy {most} of {first}, rollbacks and clamps {counts:?}, {} substeps, {last:?}", run.substeps);
    assert!(most <= 1.001 * first, "{most} of {first}");
    assert!(last.linear_velocity_m_s[2] > 0.0, "it bounces: {last:?}");
    assert!(run.defect[0] < 1e-6 * run.gross, "{:?} of {}", run.defect, run.gross);
    assert_eq!(counts[1], 0);
}
