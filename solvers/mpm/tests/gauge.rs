//! Probes that the solver answers itself.

use cosplat_core::scene::{Probe, ProbeQuantity, VelocityField};

use crate::common::{Run, body, cuboid, elastic, scene};

#[test]
fn a_stretched_block_tells_its_strain_and_how_far_it_reaches() {
    // So soft that it goes on as it was pushed: its stress, 2 mPa, slows its ends by 4e-5 of their speed.
    let mut block = body("block", elastic(1000.0, 1e-2, 0.0), cuboid([0.1; 3]), [0.0; 3], 0.02);
    let gradient_1_s = [[2.0, 0.0, 0.0], [0.0; 3], [0.0; 3]];
    block.velocity = VelocityField::LinearMap { linear_m_s: [0.0; 3], gradient_1_s, about_m: [0.0; 3] };
    let probe = |name: &str, quantity, along| Probe {
        name: name.into(),
        quantity,
        body: Some("block".into()),
        at_m: None,
        along,
    };
    let mut start = scene(vec![block], 0.01);
    start.probes = vec![
        probe("strain", ProbeQuantity::Strain, None),
        probe("right", ProbeQuantity::Reach, Some([1.0, 0.0, 0.0])),
        probe("down", ProbeQuantity::Reach, Some([0.0, 0.0, -1.0])),
    ];
    let mut run = Run::<f32>::new(start);
    assert_eq!(run.setup.report.probes["strain"].to_bits(), 0);
    let mut last = run.step();
    for _ in 1..10 {
        last = run.step();
    }
    let farthest = |axis: usize, sign: f64| {
        run.particles("block").iter().map(|x| sign * x[axis]).fold(f64::NEG_INFINITY, f64::max)
    };
    for (name, place) in [("right", farthest(0, 1.0)), ("down", farthest(2, -1.0))] {
        assert_eq!(last.report.probes[name].to_bits(), place.to_bits(), "{name}");
    }
    // After 0.1 s the block is 1.2 times as long; its faces are known to a part of a grid cell, of 0.04 m.
    let (strain, right) = (last.report.probes["strain"], last.report.probes["right"]);
    assert!((right - 1.2 * 0.04).abs() < 4e-4, "{right}");
    // No block is longer than its most stretched part makes it.
    assert!(strain >= (right / 0.04).ln() && strain < 0.2, "{strain}");
}
