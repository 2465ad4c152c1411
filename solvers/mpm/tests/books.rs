//! What must hold bit by bit or to rounding: contact momentum, restore, threads, sensitivity.

use crate::common::rock::view;
use crate::common::{Run, body, cuboid, elastic, gravity, moving, plane, scene, set};
use cosplat_core::boundary::{BoundaryState, Impulses};
use cosplat_core::plugin::{ImpulseInput, Inputs, Plugin, SolverScene, ViewRole};
use cosplat_core::scene::{Material, Source, Wall};
use cosplat_mpm::{Mpm, Real};

/// Two blocks that fly into each other off-centre; returns the run after contact.
fn collide<R: Real>(windows: u32) -> Run<R> {
    let a = body("a", elastic(500.0, 1e5, 0.3), cuboid([0.16; 3]), [0.0; 3], 0.02);
    let b = body("b", elastic(800.0, 2e5, 0.2), Source::Sphere { radius_m: 0.09 }, [0.23, 0.05, 0.01], 0.02);
    let start = scene(vec![moving(a, [1.0, 0.0, 0.0], [0.0; 3]), moving(b, [-1.0, 0.1, 0.0], [0.0, 0.0, 2.0])], 1e-3);
    let mut run = Run::<R>::new(start);
    for _ in 0..windows {
        run.step();
    }
    run
}

#[test]
fn contact_of_two_bodies_keeps_momentum() {
    let mut double = collide::<f64>(150);
    println!("f64: {:?} of {} in {} substeps", double.defect, double.gross, double.substeps);
    assert!(double.defect[0] < 1e-12 * double.gross && double.defect[1] < 1e-12 * double.gross, "{:?}", double.defect);
    let states = double.step().report.bodies;
    println!("velocities {:?} {:?}", states[0].linear_velocity_m_s, states[1].linear_velocity_m_s);
    // They touched and bounced: the relative velocity along x turned round.
    assert!(states[0].linear_velocity_m_s[0] < states[1].linear_velocity_m_s[0]);
    let single = collide::<f32>(150);
    println!("f32: {:?} of {} in {} substeps", single.defect, single.gross, single.substeps);
    assert!(single.defect[0] < 1e-6 * single.gross, "{:?}", single.defect);
}

/// A scene with everything in it: walls, gravity, plasticity, two bodies, sorting.
fn everything() -> SolverScene {
    let can = Material::Elastoplastic {
        density_kg_m3: 300.0,
        youngs_modulus_pa: 2e5,
        poissons_ratio: 0.22,
        yield_stress_pa: 2e3,
    };
    let a = body("a", elastic(500.0, 1e5, 0.3), cuboid([0.3, 0.3, 0.2]), [0.0, 0.0, 0.11], 0.01);
    let b = body("b", can, Source::Cylinder { radius_m: 0.08, height_m: 0.15 }, [0.02, 0.01, 0.3], 0.01);
    let mut scene = scene(vec![a, moving(b, [0.3, 0.0, -2.0], [0.0, 1.0, 0.0])], 1e-3);
    let friction = Wall::Friction { static_friction: 0.4, kinetic_friction: 0.3 };
    scene.statics = vec![plane("floor", [0.0; 3], crate::common::UPRIGHT, friction)];
    scene.actions.push(gravity(-9.81));
    scene
}

fn hash_after(mut scene: SolverScene, threads: usize, windows: u32) -> u128 {
    scene.threads = threads;
    let mut run = Run::<f32>::new(scene);
    for _ in 0..windows {
        run.step();
    }
    run.hash()
}

#[test]
fn threads_change_nothing_and_one_ulp_does() {
    let mut run = Run::<f32>::new(everything());
    let mut last = None;
    for _ in 0..40 {
        last = Some(run.step());
    }
    let report = last.expect("windows").report;
    println!("{} particles, {} substeps, {:?}", run.setup.particles.iter().sum::<u64>(), run.substeps, report.counters);
    println!("defect {:?} of {}; {:?}", run.defect, run.gross, report.energy);
    assert!(report.energy.dissipated_j > 0.0);
    assert!(run.setup.particles.iter().sum::<u64>() > 8000, "enough to share among threads");
    assert!(run.defect[0] < 1e-6 * run.gross && run.defect[1] < 1e-6 * run.gross, "{:?} of {}", run.defect, run.gross);
    let one = run.hash();
    for threads in [2, 3] {
        assert_eq!(one, hash_after(everything(), threads, 40), "{threads} threads");
    }
    let mut other = everything();
    other.actions = vec![gravity(f64::from_bits((-9.81_f64).to_bits() + (1 << 29)))];
    assert_ne!(one, hash_after(other, 1, 40));
}

/// Term that binds the substep of a small cube in free flight.
fn binds(velocity: [f64; 3], spin: [f64; 3], change: impl FnOnce(&mut SolverScene)) -> String {
    let mut start = scene(
        vec![moving(body("cube", elastic(1000.0, 1e5, 0.3), cuboid([0.1; 3]), [0.0; 3], 0.0125), velocity, spin)],
        1e-2,
    );
    change(&mut start);
    let mut run = Run::<f32>::new(start);
    run.step().report.substep_bound_by
}

#[test]
fn the_term_that_binds_the_substep_is_named() {
    let plain = |_: &mut SolverScene| {};
    assert_eq!(binds([0.0; 3], [0.0; 3], plain), "elastic wave in `cube` (Courant number 0.5)");
    // 50 m/s against a wave of 11.6 m/s, weighted by 0.3 and 0.5.
    assert_eq!(binds([50.0, 0.0, 0.0], [0.0; 3], plain), "particle speed of `cube` (0.3 cells a substep)");
    // One cell that spins: |C| = √2 ω = 1414 / s, and 0.25 / |C| = 0.18 ms, while its corners move at 11 m/s.
    let small = |s: &mut SolverScene| s.bodies[0].source = cuboid([0.025; 3]);
    assert_eq!(binds([0.0; 3], [0.0, 0.0, 1000.0], small), "strain rate of `cube`");
    assert_eq!(binds([0.0; 3], [0.0; 3], |s| set(s, "max_substep_s", 1e-4)), "maximum given by the user");
    assert_eq!(binds([0.0; 3], [0.0; 3], |s| s.clock.tick_s = 5e-5), "coupling window");
}

#[test]
fn restore_is_bitwise() {
    let mut run = Run::<f32>::new(everything());
    for _ in 0..25 {
        run.step();
    }
    let (saved, window) = (run.bytes(), run.window);
    let after = |run: &mut Run<f32>| {
        let out = (0..10).map(|_| run.step()).last().expect("a window");
        (run.bytes(), out)
    };
    let first = after(&mut run);
    run.plugin.restore(&saved).expect("it fits");
    run.window = window;
    assert!(run.bytes() == saved);
    assert!(after(&mut run) == first, "same solver, restored");
    let mut fresh = Run::<f32>::new(everything());
    fresh.plugin.restore(&saved).expect("it fits");
    fresh.window = window;
    assert!(after(&mut fresh) == first, "fresh solver, restored");
    assert!(fresh.plugin.restore(&saved[..saved.len() - 1]).is_err());
    assert!(Mpm::<f32>::default().restore(&saved).is_err());
}

/// A body floats and all its samples are pushed up, away from it on the one side and towards it on the other. Largest change of
/// a sample's velocity over that of one with the mass it shows; the least and largest of these masses over a particle's.
fn resists(size: [f64; 3]) -> [f64; 3] {
    let spacing = 0.02;
    let mut start = scene(vec![body("body", elastic(500.0, 1.0, 0.3), cuboid(size), [0.003; 3], spacing)], 2e-4);
    start.interfaces.push(view(ViewRole::ContactResponder, "body", 0.0));
    let mut run = Run::<f64>::new(start);
    let masses = run.setup.boundaries[0].statics.mass_kg.clone();
    let own = 500.0 * spacing * spacing * spacing;
    let wanted: Vec<_> = masses.iter().map(|_| [0.0, 0.0, 1e-6]).collect();
    let impulses = vec![ImpulseInput { interface: 0, impulses: Impulses::Samples(wanted), spread: false }];
    let step = run.step_with(&Inputs { partners: Vec::new(), impulses });
    let BoundaryState::Samples(after) = &step.boundaries[0].state else { panic!("samples") };
    let given = after.velocity.iter().zip(&masses).map(|(v, m)| v[2] * m / 1e-6).fold(0.0, f64::max);
    let fold = |f: fn(f64, f64) -> f64, first: f64| masses.iter().map(|m| m / own).fold(first, f);
    [given, fold(f64::min, f64::INFINITY), fold(f64::max, 0.0)]
}

#[test]
fn samples_show_the_mass_that_they_resist_with() {
    // One particle thick: each particle is a sample, and resists with what it is.
    let [given, least, most] = resists([0.24, 0.24, 0.02]);
    println!("leaf: {given}, {least} to {most}");
    assert!((given - 1.0).abs() < 1e-6 && (least - 1.0).abs() < 1e-6 && (most - 1.0).abs() < 1e-6);
    // Thick: the layers behind, within the 1.5 cells of a kernel, resist as well; least at corners, where most are samples.
    let [given, least, most] = resists([0.24; 3]);
    println!("block: {given}, {least} to {most}");
    assert!((given - 1.0).abs() < 1e-6 && least >= 1.0 && (1.5..2.5).contains(&most));
}

/// A block floats and single particles of its surface are pushed, all the same way or to and fro. Returns the work that
/// was booked, the energy that the body gained by the end of the window, and `Σ J²/2m`, all in J.
fn pushed(sign: impl Fn(usize) -> f64) -> [f64; 3] {
    let spacing = 0.02;
    let mut start = scene(vec![body("block", elastic(500.0, 1e4, 0.3), cuboid([0.24; 3]), [0.0; 3], spacing)], 2e-4);
    start.interfaces.push(view(ViewRole::ContactResponder, "block", 0.0));
    let mut run = Run::<f64>::new(start);
    let BoundaryState::Samples(samples) = run.setup.boundaries[0].state.clone() else { panic!("samples") };
    let size = 1e-4;
    let wanted: Vec<_> = (0..samples.position.len()).map(|i| [0.0, 0.0, size * sign(i)]).collect();
    let alone = wanted.iter().map(|j| 0.5 * j[2] * j[2] / (500.0 * spacing * spacing * spacing)).sum();
    let impulses = vec![ImpulseInput { interface: 0, impulses: Impulses::Samples(wanted), spread: false }];
    let report = run.step_with(&Inputs { partners: Vec::new(), impulses }).report;
    assert_eq!(run.substeps, 1, "the transfer takes some of what moves within a cell in every substep");
    let energy = report.energy;
    [report.interfaces[0].work_j, energy.kinetic_j + energy.potential_j, alone]
}

#[test]
fn the_work_of_impulses_is_what_the_body_feels() {
    for (name, step) in [("all", 1), ("every fifth", 5), ("to and fro", 0)] {
        let sign = |i: usize| match step {
            0 => 1.0 - 2.0 * (i % 2) as f64,
            n => f64::from(u8::from(i.is_multiple_of(n))),
        };
        let [work, gained, alone] = pushed(sign);
        println!("{name}: work {work:e} J, gained {gained:e} J, by particles alone {alone:e} J");
        // What the grid has gained is the work, exactly; the way back to the particles keeps all but what is neither a
        // velocity nor a gradient around them: 1.4, 3.8 and 2.2 % of it here.
        assert!(gained <= work * (1.0 + 1e-9) && gained > 0.95 * work && work < 0.7 * alone, "{name}");
    }
}
