//! The graphics processor draws what the processor draws.
//!
//! Where no adapter with Vulkan is found, not even one in software, the tests say that they are skipped.
#![cfg(feature = "gpu")]

use std::sync::OnceLock;

use cosplat_viewer::gpu::{Choice, Gpu, GpuError, Renderer};
use cosplat_viewer::{Gaussians, Layers, NO_OBJECT, Next, Options, psnr, render, render_layers};

mod common;

use common::{Set, camera, crowd};

/// One device for all tests.
fn gpu() -> Option<&'static Gpu> {
    static GPU: OnceLock<Result<Gpu, GpuError>> = OnceLock::new();
    match GPU.get_or_init(Gpu::open) {
        Ok(gpu) => {
            eprintln!("drawn by {}", gpu.about());
            Some(gpu)
        }
        Err(error @ GpuError::NoAdapter(_)) => {
            eprintln!("skipped: {error}");
            None
        }
        Err(error) => panic!("{error}"),
    }
}

/// Both differ by the rounding of single precision in the projection, about 10⁻⁶ of a colour, and where a weight is
/// within that of a cut-off, by at most one 255th at single pixels: no more than a few pixels of ten thousand, which is
/// 48 + 10 · log₁₀(10⁴ / 4) = 82 dB.
const ALIKE_DB: f64 = 80.0;

/// Largest part of pixels in which the two may disagree by more than rounding, for the reason above.
const RARE: f64 = 1e-3;

fn share(differ: impl Iterator<Item = bool>) -> f64 {
    let (mut all, mut bad) = (0.0, 0.0);
    for is_bad in differ {
        all += 1.0;
        bad += f64::from(u8::from(is_bad));
    }
    bad / f64::max(all, 1.0)
}

/// Pictures whose sides are no multiples of tiles, with and without the kernel's floor and the antialiasing filter.
#[test]
fn colours_are_those_of_the_processor() {
    let Some(gpu) = gpu() else { return };
    for (seed, count, width, height) in [(1, 3000, 203, 131), (2, 12_000, 320, 200), (3, 1, 16, 16), (4, 0, 5, 70)] {
        let set = crowd(count, seed);
        for (kernel_floor, antialiased) in [(0.0, false), ((-4.5_f64).exp(), true)] {
            let options = Options { kernel_floor, background: [0.2, 0.4, 0.6], ..Options::default() };
            let sets = [Gaussians { antialiased, ..set.view() }];
            let view = camera(width, height);
            let (here, there) = (render(&sets, &view, &options), gpu.render(&sets, &view, &options).unwrap());
            let ratio = psnr(&there.rgb(), &here.rgb());
            println!("{count} Gaussians at {width} x {height}: {ratio:.1} dB");
            assert!(ratio > ALIKE_DB, "{ratio}");
            let worst = here.rgba.iter().flatten().zip(there.rgba.iter().flatten());
            // One 255th at a cut-off, and as much again through what is behind it.
            let worst = worst.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(worst < 2.0 / 255.0, "{worst}");
        }
    }
}

/// Every coefficient of every band.
#[test]
fn colours_follow_the_bands() {
    let Some(gpu) = gpu() else { return };
    let set = crowd(400, 5);
    let rest: Vec<[f32; 3]> = (0..400 * 15).map(|i| [0.0, 1.0, 2.0].map(|k| (i as f32 * 0.7 + k).sin())).collect();
    for (degree, coefficients) in [(1, 3), (2, 8), (3, 15)] {
        let sets = [Gaussians { sh_rest: &rest[..400 * coefficients], sh_degree: degree, ..set.view() }];
        let (view, options) = (camera(160, 120), Options::default());
        let ratio = psnr(&gpu.render(&sets, &view, &options).unwrap().rgb(), &render(&sets, &view, &options).rgb());
        println!("bands up to {degree}: {ratio:.1} dB");
        assert!(ratio > ALIKE_DB, "{ratio}");
    }
}

/// Ties in depth: a sort that did not keep the order of equal keys would mix red and green.
#[test]
fn equal_depths_keep_their_order() {
    let Some(gpu) = gpu() else { return };
    let mut set = Set::default();
    for i in 0..5000 {
        let colour = if i % 2 == 0 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
        set.push([(i % 70) as f32 * 0.02 - 0.7, (i / 70) as f32 * 0.02 - 0.7, 2.0], [0.05; 3], 0.7, colour);
    }
    let view = camera(160, 160);
    let (here, there) =
        (render(&[set.view()], &view, &Options::default()), gpu.render(&[set.view()], &view, &Options::default()));
    let ratio = psnr(&there.unwrap().rgb(), &here.rgb());
    assert!(ratio > ALIKE_DB, "{ratio}");
}

#[test]
fn by_products_are_those_of_the_processor() {
    let Some(gpu) = gpu() else { return };
    let (first, second) = (crowd(400, 7), crowd(300, 8));
    let moved = |set: &Set| set.positions.iter().map(|&[x, y, z]| [x + 0.02, y - 0.01, z + 0.05]).collect::<Vec<_>>();
    let (first_moved, second_moved) = (moved(&first), moved(&second));
    let view = camera(300, 200);
    let next = Next { positions: vec![&first_moved, &second_moved], view };
    let sets = [first.view(), second.view()];
    let here = render_layers(&sets, &view, &Options::default(), Some(&next)).unwrap();
    let there = gpu.render_layers(&sets, &view, &Options::default(), Some(&next)).unwrap();
    compare(&here, &there);
    assert!(here.object.contains(&0) && here.object.contains(&1) && here.object.contains(&NO_OBJECT));
    // Without a next moment there is no flow, and nothing else changes.
    let still = gpu.render_layers(&sets, &view, &Options::default(), None).unwrap();
    assert!(still.flow.is_empty() && still.object == there.object && still.picture.rgba == there.picture.rgba);
}

fn compare(here: &Layers, there: &Layers) {
    let far = |a: &[f32], b: &[f32], limit: f32| a.iter().zip(b).any(|(a, b)| (a - b).abs() > limit);
    let depths = here.picture.depth.iter().zip(&there.picture.depth);
    let depth = share(depths.map(|(a, b)| a.is_infinite() != b.is_infinite() || far(&[*a], &[*b], 1e-3)));
    let normal = share(here.normal.iter().zip(&there.normal).map(|(a, b)| far(a, b, 1e-2)));
    let object = share(here.object.iter().zip(&there.object).map(|(a, b)| a != b));
    let flows = here.flow.iter().zip(&there.flow);
    let flow = share(flows.map(|(a, b)| a[0].is_nan() != b[0].is_nan() || far(a, b, 1e-2)));
    println!("pixels that differ: depth {depth:.1e}, normal {normal:.1e}, object {object:.1e}, flow {flow:.1e}");
    assert!(depth.max(normal).max(object).max(flow) < RARE);
}

/// The same bytes each time.
#[test]
fn a_device_repeats_itself() {
    let Some(gpu) = gpu() else { return };
    let set = crowd(5000, 11);
    let draw = || gpu.render(&[set.view()], &camera(200, 130), &Options { depth: true, ..Options::default() }).unwrap();
    let first = draw();
    assert!(first == draw() && first == draw());
}

/// Numbers that are none, and anything extreme, draw a picture all the same.
#[test]
fn any_numbers_draw() {
    let Some(gpu) = gpu() else { return };
    let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN, f32::MIN_POSITIVE, 0.0, -1e30, 90.0];
    for shift in 0..odd.len() {
        let mut set = crowd(40, 1);
        let at = |i: usize| odd[(i + shift) % odd.len()];
        for i in 0..20 {
            set.positions[i][i % 3] = at(i);
            set.rotations[i][i % 4] = at(i + 1);
            set.log_scales[i][i % 3] = at(i + 2);
            set.logits[i] = at(i + 3);
            set.dc[i][i % 3] = at(i + 4);
        }
        let picture = gpu.render(&[set.view()], &camera(40, 30), &Options::default()).unwrap();
        assert_eq!(picture.to_srgb8().len(), 40 * 30 * 3);
    }
}

#[test]
fn who_draws_is_said() {
    let mut cpu = Renderer::new(Choice::Cpu).unwrap();
    assert_eq!(cpu.name(), "cpu");
    let set = crowd(50, 3);
    let view = camera(30, 20);
    let picture = render(&[set.view()], &view, &Options::default());
    assert_eq!(cpu.render(&[set.view()], &view, &Options::default()).unwrap(), picture);
    // With any machine there is an answer, and it has a reason.
    let mut auto = Renderer::new(Choice::Auto).unwrap();
    println!("auto: {} because of {}", auto.name(), auto.why());
    assert!(!auto.why().is_empty());
    assert!(auto.render(&[set.view()], &view, &Options::default()).is_ok());
    let Some(gpu) = gpu() else { return };
    let wrong = Next { positions: vec![&[]], view };
    let error = gpu.render_layers(&[set.view()], &view, &Options::default(), Some(&wrong)).unwrap_err();
    assert!(error.to_string().contains("next positions"), "{error}");
}
