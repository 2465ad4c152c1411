//! Gaussians of bodies that were never captured: their light, their grain, their shape.

mod common;

use common::covariance;
use cosplat_splat::bind::Frame;
use cosplat_splat::surfel::{Light, dots, grained, linear_of_display, lit};
use cosplat_splat::{OutputFrame, SH_C0, Splats};
use nalgebra::{Matrix3, Vector3};

#[test]
fn light_falls_from_where_it_comes_and_stays_there() {
    let light = Light { towards: [0.0, 0.0, 2.0], ambient: 0.25 };
    let up = grained(&[[0.0; 3]], &[[0.0, 0.0, 1.0]], &[1e-4], [0.5; 3], 0.0);
    let colour = |s: &Splats| {
        let display = 0.5 + SH_C0 * f64::from(s.sh_dc[0][0]);
        linear_of_display(display)
    };
    let world = OutputFrame::world();
    // Single precision of a colour.
    assert!((colour(&lit(&up, &Frame::identity(), &light, &world)) - 0.5).abs() < 1e-6);
    let over = Frame::of_pose([0.0; 3], [1.0, 0.0, 0.0, 0.0]).unwrap();
    assert!((colour(&lit(&up, &over, &light, &world)) - 0.5 * 0.25).abs() < 1e-6);
    // Grain stays within its share and has no preferred side.
    let many: Vec<[f64; 3]> = (0..4000)
        .map(|i| [0.01 * f64::from(i % 20), 0.01 * f64::from(i / 20 % 20), 0.01 * f64::from(i / 400)])
        .collect();
    let n = many.len();
    let stone = grained(&many, &vec![[0.0, 0.0, 1.0]; n], &vec![1e-4; n], [0.3; 3], 0.3);
    let linear: Vec<f64> = stone.iter().map(|s| linear_of_display(f64::from(s.colour[0]))).collect();
    let mean = linear.iter().sum::<f64>() / n as f64;
    assert!(linear.iter().all(|c| (c / 0.3 - 1.0).abs() <= 0.3 + 1e-6) && (mean / 0.3 - 1.0).abs() < 0.1, "{mean}");
    assert!(linear.iter().any(|c| (c / 0.3 - 1.0).abs() > 0.1));
}

#[test]
fn dots_follow_their_gradients() {
    let stretch = [2.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 1.0_f32];
    let world = OutputFrame::world();
    let found = dots(&[[1.0, 2.0, 3.0]; 2], &[stretch, [f32::NAN; 9]], 0.1, [0.5; 3], &world).unwrap();
    let sigma = covariance(&found, 0);
    let expected = Matrix3::from_diagonal(&Vector3::new(0.1 * 0.1, 0.025 * 0.025, 0.05 * 0.05));
    assert!((sigma - expected).amax() < 1e-6 * 0.01);
    assert!((covariance(&found, 1) - Matrix3::identity() * 0.0025).amax() < 1e-8);
    assert!(dots(&[[0.0; 3]], &[stretch; 2], 0.1, [0.5; 3], &world).is_err());
}
