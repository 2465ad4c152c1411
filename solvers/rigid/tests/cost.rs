//! What a window costs; printed, not judged.

mod common;

use common::{advance, cube, on_floor, start};
use cosplat_core::plugin::Inputs;
use cosplat_core::plugin::{Plugin, StateHasher};

#[test]
#[ignore = "a measurement"]
fn a_wall_of_boxes() {
    let boxes = (0..100_u8).map(|i| {
        let (x, z) = (f64::from(i % 10), f64::from(i / 10));
        cube(&format!("b{i}"), 0.1, 1.0, [0.11 * x, 0.0, 0.05 + 0.1 * z])
    });
    let scene = on_floor(boxes.collect(), 0.5, 100, 0.01);
    let (mut solver, _) = start(&scene);
    let clock = std::time::Instant::now();
    (0..100).for_each(|w| drop(advance(&mut solver, &scene, w, &Inputs::default())));
    let step = clock.elapsed().as_secs_f64() / 100.0;
    let clock = std::time::Instant::now();
    let mut hasher = StateHasher::default();
    (0..100).for_each(|_| solver.save(&mut hasher));
    println!("window of 10 ms, 5 substeps: {step:.6} s; hash: {:.6} s", clock.elapsed().as_secs_f64() / 100.0);
}
