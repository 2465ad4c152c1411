//! Rigid partners through the stand-in path, with a rigid body of the test on the other side, and impulses on samples.

use crate::common::rock::{Rock, view, with_rock};
use crate::common::{Run, body, cuboid, elastic, gravity, plane, scene};
use cosplat_core::boundary::{BoundaryState, Impulses, add, cross, norm, scale, sub};
use cosplat_core::plugin::{ImpulseInput, Inputs, ViewRole};
use cosplat_core::scene::{Source, Wall};
use cosplat_mpm::Real;

/// Mass on a bar (table D15): relative L2 error of the mass's velocity until 2 L/c, and error of the impulse until 95 %
/// of it (the wave turns round half a cell before the foot, so its return comes early).
fn strike(cells: usize) -> (f64, f64) {
    let dx = 1.0 / cells as f64;
    let window = 1e-3;
    let bar = body("bar", elastic(1000.0, 1e6, 0.0), cuboid([0.1, 0.1, 1.0]), [0.05, 0.05, 0.5], dx / 2.0);
    let mut start = scene(vec![bar], window);
    start.statics = vec![plane("foot", [0.0; 3], crate::common::UPRIGHT, Wall::NoSlip)];
    with_rock(&mut start, "bar", &cuboid([0.3, 0.3, 0.2]), 0.0);
    let mut rock = Rock::new(10.0, 0.2, [0.05, 0.05, 1.1], [0.0, 0.0, -0.5], [0.0; 3]);
    let mut run = Run::<f32>::new(start);
    let (z, t_end) = (1000.0_f64.sqrt() * 10.0, 2.0 / 1000.0_f64.sqrt());
    let (mut square, mut of) = (0.0, 0.0);
    let mut last = 0.0;
    while (run.window + 1) as f64 * window <= t_end {
        let inputs = rock.inputs(window);
        let out = run.step_with(&inputs);
        rock.take(&out, window);
        let exact = 0.5 * (-z / 10.0 * run.window as f64 * window).exp();
        let found = -rock.record.linear_velocity[2];
        square += (found - exact).powi(2);
        of += exact * exact;
        if run.window as f64 * window < 0.95 * t_end {
            last = (0.5 - found) / (0.5 - exact) - 1.0;
        }
    }
    println!("{cells} cells: {} substeps, defect {:?} of {}", run.substeps, run.defect, run.gross);
    ((square / of).sqrt(), last)
}

#[test]
fn mass_strikes_bar_as_table_d15() {
    let (velocity, impulse) = strike(50);
    println!("L2 of velocity {velocity}, impulse {impulse}");
    assert!(velocity < 0.03, "{velocity}");
    assert!(impulse.abs() < 0.01, "{impulse}");
}

/// A ball on a soft block on a floor, off the middle, with friction. Returns the run, the rock and the worst mismatch of
/// what the block received and what the rock was given, linear and angular about the origin.
fn drop<R: Real>(mass: f64, windows: u32) -> (Run<R>, Rock, [f64; 2]) {
    let (window, g) = (1e-3, [0.0, 0.0, -9.81]);
    let block = body("block", elastic(300.0, 1e5, 0.3), cuboid([0.4, 0.4, 0.2]), [0.0, 0.0, 0.1], 0.02);
    let mut start = scene(vec![block], window);
    let rough = Wall::Friction { static_friction: 0.8, kinetic_friction: 0.8 };
    start.statics = vec![plane("floor", [0.0; 3], crate::common::UPRIGHT, rough)];
    start.actions.push(gravity(-9.81));
    with_rock(&mut start, "block", &Source::Sphere { radius_m: 0.1 }, 0.5);
    let mut rock = Rock::new(mass, 0.4 * mass * 0.01, [0.03, 0.02, 0.33], [0.3, 0.0, -1.0], g);
    let mut run = Run::<R>::new(start);
    let mut mismatch = [0.0_f64; 2];
    for _ in 0..windows {
        let out = run.step_with(&rock.inputs(window));
        let Impulses::Rigid(j) = &out.impulses[0].1 else { panic!("a rigid impulse") };
        let got = out.report.interfaces[0].received;
        let about = add(j.angular, cross(rock.record.position, j.linear));
        mismatch[0] = mismatch[0].max(norm(add(got.linear, j.linear)));
        mismatch[1] = mismatch[1].max(norm(add(got.angular, about)));
        rock.take(&out, window);
    }
    (run, rock, mismatch)
}

#[test]
fn a_ball_dropped_on_a_block_keeps_momentum() {
    let (run, rock, mismatch) = drop::<f32>(8.0, 200);
    println!("f32: {} substeps, defect {:?} of {}, mismatch {mismatch:?}", run.substeps, run.defect, run.gross);
    println!("rock {:?} {:?}", rock.record.linear_velocity, rock.record.angular_velocity);
    assert!(run.defect[0] < 1e-6 * run.gross && run.defect[1] < 1e-6 * run.gross, "{:?} of {}", run.defect, run.gross);
    assert!(mismatch[0] < 1e-12 && mismatch[1] < 1e-12, "{mismatch:?}");
    // It met the block, and friction turned it.
    assert!(rock.record.position[2] > 0.15 && rock.record.angular_velocity[1] > 0.1, "{:?}", rock.record);
    let (run, _, mismatch) = drop::<f64>(8.0, 60);
    println!("f64: defect {:?} of {}, mismatch {mismatch:?}", run.defect, run.gross);
    assert!(
        run.defect[0] < 1e-12 * run.gross && run.defect[1] < 1e-12 * run.gross,
        "{:?} of {}",
        run.defect,
        run.gross
    );
}

#[test]
fn light_and_heavy_balls_stay_bounded() {
    // Lagged coupling diverges once the touching mass exceeds the ball's; the block weighs 9.6 kg.
    for mass in [1e-3, 0.1, 100.0] {
        let (run, rock, _) = drop::<f32>(mass, 150);
        println!("{mass} kg: rock {:?} {:?}", rock.record.position, rock.record.linear_velocity);
        assert!(norm(rock.record.linear_velocity) < 4.0, "{mass}: {:?}", rock.record.linear_velocity);
        assert!(run.defect[0] < 1e-6 * run.gross, "{mass}: {:?} of {}", run.defect, run.gross);
    }
}

#[test]
fn impulses_on_samples_arrive() {
    let block = body("block", elastic(300.0, 1e5, 0.3), cuboid([0.2; 3]), [0.5, 0.1, 0.1], 0.02);
    let mut start = scene(vec![block], 2e-3);
    start.interfaces.push(view(ViewRole::ContactResponder, "block", 0.0));
    let mut run = Run::<f32>::new(start);
    let boundary = run.setup.boundaries[0].clone();
    let BoundaryState::Samples(samples) = &boundary.state else { panic!("samples") };
    println!("{} samples, area {}", samples.position.len(), boundary.statics.area_m2.iter().sum::<f64>());
    assert!((boundary.statics.area_m2.iter().sum::<f64>() - 0.24).abs() < 1e-12);
    let wanted: Vec<[f64; 3]> = samples
        .position
        .iter()
        .map(|x| scale(sub(*x, [0.5, 0.1, 0.0]), 1e-3))
        .map(|j| add(j, [1e-9, 0.0, 0.0]))
        .collect();
    for _ in 0..20 {
        let impulses = Impulses::Samples(wanted.clone());
        let total = impulses.total();
        let out = run.step_with(&Inputs {
            partners: Vec::new(),
            impulses: vec![ImpulseInput { interface: 0, impulses, spread: true }],
        });
        let received = out.report.interfaces[0].received.linear;
        assert_eq!(received.map(f64::to_bits), total.map(f64::to_bits), "nothing is lost on the way");
    }
    println!("defect {:?} of {}", run.defect, run.gross);
    assert!(run.defect[0] < 1e-6 * run.gross && run.defect[1] < 1e-6 * run.gross, "{:?} of {}", run.defect, run.gross);
}
