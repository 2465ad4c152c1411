//! Rigid bodies that something else holds as well: other resolvers, a floor.

use crate::common::rock::{Rock, with_rock};
use crate::common::{Run, body, cuboid, elastic, moving, plane, scene};
use cosplat_core::boundary::{Impulses, Wrench, add, scale};
use cosplat_core::plugin::Outputs;
use cosplat_core::scene::{Material, Wall};

fn viscous(mut material: Material, viscosity: f64) -> Material {
    if let Material::Elastic { viscosity_pa_s, .. } = &mut material {
        *viscosity_pa_s = viscosity;
    }
    material
}

fn rigid(outputs: &Outputs) -> Wrench {
    let Impulses::Rigid(wrench) = outputs.impulses[0].1 else { panic!("a rigid impulse") };
    wrench
}

/// A plate of 2 kg set down on as many soft blocks as there are solvers: mean way down in the second second, the mean
/// expected \[m\], and the largest speed in the first and in the last half second.
///
/// Without viscosity nothing in blocks or plate damps the swing (angular frequency ω); what decays is the coupling's. With `n` substeps in a
/// window `h`, the plate here moves by its velocity at the end of a window and its stand-ins by those of their substeps:
/// the plate is `(n-1)/2n` of a window ahead, which takes `ω² h (n-1)/4n` of the swing a second. One solver with both
/// blocks shows 0.41/s of 0.45/s at two substeps in 2 ms, 1.21/s of 1.36/s at four in 4 ms, and none at one in 1 ms. With
/// a solver for each block it is 0.61, 1.61 and 0.15/s: a stand-in feels the moment of one block, and not that of the
/// other, which would hold it level. With 1000 times the moment of inertia, two and three solvers decay as one does.
fn set_down(solvers: usize, viscosity: f64, spacing: f64) -> (f64, f64, [f64; 2]) {
    let (window, gravity, mass) = (2e-3, [0.0, 0.0, -9.81], 2.0);
    let (edge, stiffness) = (0.1, 2e4);
    let mut runs: Vec<Run<f32>> = (0..solvers)
        .map(|i| {
            let turn = std::f64::consts::TAU * i as f64 / solvers as f64;
            let at = [0.15 * turn.cos(), 0.15 * turn.sin(), 0.05];
            let material = viscous(elastic(300.0, stiffness, 0.0), viscosity);
            let mut start = scene(vec![body("block", material, cuboid([edge; 3]), at, spacing)], window);
            start.statics = vec![plane("floor", [0.0; 3], crate::common::UPRIGHT, Wall::NoSlip)];
            with_rock(&mut start, "block", &cuboid([0.5, 0.5, 0.05]), 0.3);
            Run::new(start)
        })
        .collect();
    let mut plate = Rock::new(mass, 0.04, [0.0, 0.0, 0.125], [0.0; 3], gravity);
    plate.record.share = 1.0 / solvers as f64;
    let (mut mean, mut speeds) = (0.0, [0.0_f64; 2]);
    for n in 0..1000 {
        let outputs: Vec<Outputs> = runs.iter_mut().map(|run| run.step_with(&plate.inputs(window))).collect();
        let total = outputs.iter().map(rigid).fold(Wrench::default(), Wrench::plus);
        let mut one = outputs[0].clone();
        one.impulses[0].1 = Impulses::Rigid(total);
        plate.take(&one, window);
        let speed = plate.record.linear_velocity[2].abs();
        if n < 250 {
            speeds[0] = speeds[0].max(speed);
        } else if n >= 750 {
            speeds[1] = speeds[1].max(speed);
        }
        if n >= 500 {
            mean += (0.125 - plate.record.position[2]) / 500.0;
        }
    }
    // Neo-Hookean with ν = 0: force E A (1/F - F) / 2 with the stretch F.
    let f = mass * 9.81 / (solvers as f64 * stiffness * edge * edge);
    let expected = edge * (1.0 - ((f * f + 1.0).sqrt() - f));
    (mean, expected, speeds)
}

#[test]
fn a_plate_on_two_and_on_three_solvers_swings_about_its_rest() {
    for solvers in [2, 3] {
        let (mean, expected, speeds) = set_down(solvers, 0.0, 0.01);
        println!("{solvers} solvers: {mean} m of {expected}, speeds {speeds:?}");
        // A window of two substeps between the stand-ins' motion and the plate's: an overlap of some 1.5 % of a cell of
        // 20 mm stays.
        assert!((mean - expected).abs() < 0.015 * 0.02, "{mean} of {expected}");
        // A swing that is still dying away.
        assert!(speeds[1] < 0.5 * speeds[0], "{speeds:?}");
    }
}

#[test]
fn a_plate_on_two_and_on_three_solvers_comes_to_rest_where_its_blocks_damp_it() {
    // Uniaxial strain rate: 4/3 η of it acts against it, beside the stiffness E. The swing ω² = n E A / L m then decays
    // with the rate 2/3 η ω² / E.
    let (viscosity, stiffness) = (60.0, 2e4);
    for solvers in [2, 3] {
        let (mean, expected, speeds) = set_down(solvers, viscosity, 0.02);
        let rate = 2.0 / 3.0 * viscosity / stiffness * (solvers as f64 * stiffness * 0.01 / 0.1 / 2.0);
        println!("{solvers} solvers: {mean} m of {expected}, speeds {speeds:?}, decay {rate}/s");
        // As above, of cells twice as large.
        assert!((mean - expected).abs() < 0.015 * 0.04, "{mean} of {expected}");
        // From the last quarter of a swing before 0.1 s to 1.5 s, and a factor of two for the phase of both.
        assert!(speeds[1] < 2.0 * (-1.4 * rate).exp() * speeds[0], "{speeds:?}");
    }
}

/// Velocity \[m/s\] of a bar of 1 m and 10 kg after it hit the floor at 0.5 m/s, or a plate of 100 kg that lies on it.
fn rebound(on_plate: bool) -> f64 {
    let bar = body("bar", elastic(1000.0, 1e6, 0.0), cuboid([0.1, 0.1, 1.0]), [0.0, 0.0, 0.53], 0.01);
    // 20 substeps: 0.5 dx / c = 0.32 ms each.
    let window = 20.0 * 0.5 * 0.02 / 1000.0_f64.sqrt();
    let mut start = scene(vec![moving(bar, [0.0, 0.0, -0.5], [0.0; 3])], window);
    if on_plate {
        with_rock(&mut start, "bar", &cuboid([0.4, 0.4, 0.1]), 0.0);
    } else {
        start.statics = vec![plane("floor", [0.0; 3], crate::common::UPRIGHT, Wall::Slip)];
    }
    let mut plate = Rock::new(100.0, 1.5, [0.0, 0.0, -0.05], [0.0; 3], [0.0; 3]);
    let mut run = Run::<f32>::new(start);
    let mut velocity = 0.0;
    while (run.window as f64) * window < 0.2 {
        let outputs = if on_plate { run.step_with(&plate.inputs(window)) } else { run.step() };
        velocity = outputs.report.bodies[0].linear_velocity_m_s[2];
        if on_plate {
            // The floor keeps the plate where it is: what it did in this window is foreseen for the next.
            let floor = scale(rigid(&outputs).linear, -1.0 / (100.0 * window));
            plate.record.background_linear = add([0.0; 3], floor);
        }
    }
    velocity
}

#[test]
fn a_plate_on_the_floor_is_as_hard_as_the_floor() {
    let (wall, plate) = (rebound(false), rebound(true));
    println!("rebound from the floor {wall} m/s, from the plate {plate} m/s");
    // The gate of the contact scheme at a mass ratio of 0.1 and 20 substeps a window.
    assert!((plate / wall - 1.0).abs() < 0.1, "{plate} {wall}");
    // The bar comes back with nearly all of its speed: its wave returns as a step.
    assert!(wall > 0.45, "{wall}");
}
