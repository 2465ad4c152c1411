//! Bodies whose particles were prepared: captures and filled meshes.

use std::sync::Arc;

use crate::common::rock::mesh_source;
use crate::common::{Run, UPRIGHT, body, elastic, gravity, moving, scene};
use cosplat_core::asset::{Asset, ParticleCloud};
use cosplat_core::boundary::{norm, sub};
use cosplat_core::plugin::{Plugin, SolverScene};
use cosplat_core::scene::{Fill, Source, VelocityField};
use cosplat_core::visual::{VisualForm, VisualState};
use cosplat_mpm::Mpm;

fn splat() -> Source {
    Source::Splat {
        file: "plant.ply".into(),
        metres_per_unit: 1.0,
        up: "+z".into(),
        min_opacity: 0.1,
        keep_box: None,
        fill: Fill::Winding,
    }
}

/// A lattice of 12³ particles in an order that no lattice has, every third one half as large.
fn cloud() -> ParticleCloud {
    let (n, spacing_m) = (12, 0.01);
    let count = n * n * n;
    // 5 shares no factor with 12³.
    let shuffled = (0..count).map(|i| i * 5 % count);
    let place = |i: usize| [i / (n * n), i / n % n, i % n].map(|k| (k as f64 + 0.5) * spacing_m);
    ParticleCloud {
        spacing_m,
        position_m: shuffled.map(place).collect(),
        volume_m3: (0..count).map(|i| if i % 3 == 0 { 0.5e-6 } else { 1e-6 }).collect(),
    }
}

/// A body made of that cloud, moved and turned by 90° about z.
fn captured(source: Source, cloud: ParticleCloud) -> SolverScene {
    let mut plant = body("plant", elastic(400.0, 1e5, 0.3), source, [0.5, -0.2, 1.0], 0.05);
    plant.pose.orientation = [0.0, 0.0, std::f64::consts::FRAC_1_SQRT_2, std::f64::consts::FRAC_1_SQRT_2];
    let mut start = scene(vec![plant], 5e-3);
    start.assets.insert("plant".into(), Arc::new(Asset::Particles(cloud)));
    start
}

fn shown(plugin: &impl Plugin) -> (Vec<[f64; 3]>, Vec<[f32; 9]>) {
    match plugin.visual("plant") {
        Some(VisualState::Particles { position, gradient }) => (position, gradient),
        other => panic!("particles instead of {other:?}"),
    }
}

#[test]
fn particles_keep_their_order_their_volumes_and_their_gradients() {
    let cloud = cloud();
    let mut start = captured(splat(), cloud.clone());
    start.bodies[0] = moving(start.bodies[0].clone(), [1.0, 0.0, 0.0], [0.0, 0.0, 20.0]);
    let mut run = Run::<f32>::new(start);
    let mass: f64 = cloud.volume_m3.iter().sum::<f64>() * 400.0;
    assert!((run.setup.report.bodies[0].mass_kg / mass - 1.0).abs() < 1e-6, "single precision of each mass");
    assert_eq!(run.setup.particles, [1728]);
    let (position, gradient) = shown(&run.plugin);
    for (x, [px, py, pz]) in position.iter().zip(&cloud.position_m) {
        // Roundings of places of 1 m; the store keeps 48 bits of a cell.
        assert!(norm(sub(*x, [0.5 - py, -0.2 + px, 1.0 + pz])) < 1e-12, "{x:?}");
    }
    let identity = [1.0_f32, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0].map(f32::to_bits);
    assert!(gradient.iter().all(|f| f.map(f32::to_bits) == identity));
    // A quarter turn at 20 rad/s.
    let windows = (std::f64::consts::FRAC_PI_2 / 20.0 / 5e-3).round();
    for _ in 0..windows as u32 {
        run.step();
    }
    let turn = 20.0 * windows * 5e-3;
    let (_, gradient) = shown(&run.plugin);
    let exact = [turn.cos(), -turn.sin(), 0.0, turn.sin(), turn.cos(), 0.0, 0.0, 0.0, 1.0];
    let mut mean = [0.0; 9];
    for f in &gradient {
        mean.iter_mut().zip(f).for_each(|(m, f)| *m += f64::from(*f) / gradient.len() as f64);
    }
    println!("mean gradient {mean:?} after a turn of {turn}");
    // Spinning stretches it by up to ρ ω² R² / E = 6e-3 and so slows it down by as much again.
    assert!(mean.iter().zip(exact).all(|(m, e)| (m - e).abs() < 1.2e-2), "{mean:?}");
}

#[test]
fn mass_is_spread_over_the_volume_where_it_is_given() {
    let mut start = captured(splat(), cloud());
    start.bodies[0].mass_kg = Some(3.0);
    start.actions.push(gravity(-9.81));
    let mut run = Run::<f64>::new(start);
    let state = run.step().report.bodies[0];
    assert!(
        (state.mass_kg - 3.0).abs() < 1e-12 && (state.linear_velocity_m_s[2] + 9.81 * 5e-3).abs() < 1e-12,
        "{state:?}"
    );
}

#[test]
fn a_filled_mesh_is_particles_without_gradients() {
    let run = Run::<f32>::new(captured(mesh_source(), cloud()));
    let (position, gradient) = shown(&run.plugin);
    assert_eq!((position.len(), gradient.len()), (1728, 0));
    assert_eq!(run.plugin.describe().visual, Some(VisualForm::Particles { gradients: true }));
    assert_eq!(run.plugin.visual("pot"), None);
}

#[test]
fn what_cannot_be_particles_is_refused_by_name() {
    let refusal = |change: &dyn Fn(&mut SolverScene)| {
        let mut start = captured(splat(), cloud());
        change(&mut start);
        Mpm::<f32>::default().setup(&start).expect_err("nothing to simulate").to_string()
    };
    let with = |start: &mut SolverScene, cloud: ParticleCloud| {
        start.assets.insert("plant".into(), Arc::new(Asset::Particles(cloud)));
    };
    let missing = refusal(&|s| s.assets.clear());
    assert!(missing.contains("not filled with particles before the run (body `plant`)"), "{missing}");
    let empty = refusal(&|s| with(s, ParticleCloud { position_m: Vec::new(), volume_m3: Vec::new(), ..cloud() }));
    assert!(empty.contains("`plant`: it has no particle"), "{empty}");
    let short = refusal(&|s| with(s, ParticleCloud { volume_m3: vec![1e-6], ..cloud() }));
    assert!(short.contains("1728 points have 1 volumes"), "{short}");
    let flat = refusal(&|s| with(s, ParticleCloud { spacing_m: 0.0, ..cloud() }));
    assert!(flat.contains("its spacing is 0 m"), "{flat}");
    let hollow = refusal(&|s| with(s, ParticleCloud { volume_m3: vec![0.0; 1728], ..cloud() }));
    assert!(hollow.contains("positive mass and volume (body `plant`)"), "{hollow}");
}

#[test]
fn a_linear_field_moves_every_particle_linearly() {
    // The patch test: a velocity field that is linear in place strains all alike, so no force acts inside and each
    // particle that no wave from the surface has reached moves by x + G x t.
    let uniform = ParticleCloud { volume_m3: vec![1e-6; 1728], ..cloud() };
    let mut start = captured(splat(), uniform);
    let gradient = [[30.0, 20.0, 0.0], [-10.0, 40.0, 5.0], [0.0, 25.0, -20.0]];
    let (about, time) = ([0.44, -0.14, 1.06], 4e-4);
    start.clock.tick_s = 0.5 * time;
    start.bodies[0].pose.orientation = UPRIGHT;
    start.bodies[0].velocity =
        VelocityField::LinearMap { linear_m_s: [0.0; 3], gradient_1_s: gradient, about_m: about };
    let mut run = Run::<f64>::new(start);
    let (before, _) = shown(&run.plugin);
    run.step();
    let (after, _) = shown(&run.plugin);
    let (mut count, mut worst) = (0, 0.0_f64);
    for (a, b) in before.iter().zip(&after) {
        let r = sub(*a, about);
        let wanted = gradient.map(|row| time * (row[0] * r[0] + row[1] * r[1] + row[2] * r[2]));
        let depth = (0..3).map(|k| (a[k] - [0.5, -0.2, 1.0][k]).min([0.62, -0.08, 1.12][k] - a[k])).fold(1.0, f64::min);
        // The wave of 18 m/s goes 7 mm, and the kernel reaches 30 mm further.
        if depth > 0.038 {
            count += 1;
            worst = worst.max(norm(sub(sub(*b, *a), wanted)));
        }
    }
    println!("{count} particles, worst {worst} m");
    // A lattice strained by e = 1.6 % is no longer symmetric about the nodes: a stress of E e meets weights that differ by
    // e from one side of a cell to the other, so it accelerates by E e²/(ρ dx) = 3 m/s² at most, over 0.4 ms.
    assert!(count > 30 && worst < 3e-7, "{count} {worst}");
}
