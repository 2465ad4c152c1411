//! Small scenes whose pictures are known.

use cosplat_viewer::{Camera, Gaussians, Options, Picture, View, psnr, render};
use proptest::prelude::*;

mod common;

use common::{Set, camera, crowd};

/// The recipe, pixel by pixel and in double precision: every Gaussian at every pixel, no tiles.
fn slow(set: &Set, view: &View, options: &Options) -> Picture {
    let mut order: Vec<usize> = (0..set.positions.len()).collect();
    let t = |i: usize| -> [f64; 3] {
        let from_eye = [0, 1, 2].map(|k| f64::from(set.positions[i][k]) - view.eye[k]);
        view.rows.map(|r| (0..3).map(|k| r[k] * from_eye[k]).sum())
    };
    order.sort_by(|&a, &b| (t(a)[2] as f32).total_cmp(&(t(b)[2] as f32)));
    let mut rgba = vec![[0.0_f32; 4]; view.width * view.height];
    let flat: Vec<_> = order.iter().filter_map(|&i| flatten(set, i, t(i), view, options)).collect();
    for (at, pixel) in rgba.iter_mut().enumerate() {
        let (x, y) = ((at % view.width) as f64 + 0.5, (at / view.width) as f64 + 0.5);
        let (mut sum, mut through) = ([0.0; 3], 1.0);
        for (centre, conic, opacity, colour) in &flat {
            let (dx, dy) = (x - centre[0], y - centre[1]);
            let power = -0.5 * (conic[0] * dx * dx + conic[2] * dy * dy) - conic[1] * dx * dy;
            let alpha = (opacity * (power.min(0.0).exp() - options.kernel_floor)).min(0.99);
            if alpha < 1.0 / 255.0 {
                continue;
            }
            if through * (1.0 - alpha) < 1e-4 {
                break;
            }
            for (s, c) in sum.iter_mut().zip(colour) {
                *s += c * alpha * through;
            }
            through *= 1.0 - alpha;
        }
        let channel = |k: usize| (sum[k] + through * f64::from(options.background[k])) as f32;
        *pixel = [channel(0), channel(1), channel(2), (1.0 - through) as f32];
    }
    Picture { width: view.width, height: view.height, rgba, depth: Vec::new() }
}

type Flat = ([f64; 2], [f64; 3], f64, [f64; 3]);

fn flatten(set: &Set, i: usize, t: [f64; 3], view: &View, options: &Options) -> Option<Flat> {
    use nalgebra::{Matrix2x3, Matrix3, Quaternion, UnitQuaternion, Vector3};
    if t[2] <= options.near {
        return None;
    }
    let [w, x, y, z] = set.rotations[i].map(f64::from);
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)).to_rotation_matrix();
    let m = turn.matrix() * Matrix3::from_diagonal(&Vector3::from(set.log_scales[i].map(|s| f64::from(s).exp())));
    let f = view.focal;
    let held = |v: f64, size: usize| (v / t[2]).clamp(-1.3 * size as f64 / 2.0 / f, 1.3 * size as f64 / 2.0 / f);
    let (u, v) = (held(t[0], view.width), held(t[1], view.height));
    let j = Matrix2x3::new(f / t[2], 0.0, -f * u / t[2], 0.0, f / t[2], -f * v / t[2]);
    let rows = Matrix3::from_fn(|r, c| view.rows[r][c]);
    let c = j * rows * m * m.transpose() * rows.transpose() * j.transpose();
    let (a, b, d) = (c[(0, 0)] + options.dilation, c[(0, 1)], c[(1, 1)] + options.dilation);
    let det = a * d - b * b;
    let centre = [f * t[0] / t[2] + view.width as f64 / 2.0, f * t[1] / t[2] + view.height as f64 / 2.0];
    let colour = set.dc[i].map(|c| (0.5 + 0.282_094_791_773_878_14 * f64::from(c)).max(0.0));
    let opacity = 1.0 / (1.0 + (-f64::from(set.logits[i])).exp());
    Some((centre, [d / det, -b / det, a / det], opacity, colour))
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(24) })]

    /// Tiles, spans, cuts and the fast exponential change nothing that can be seen: only a weight that is within
    /// rounding of a cut-off may fall on the other side, and that is one 255th of a colour.
    #[test]
    fn tiles_draw_what_the_recipe_says(seed in any::<u64>(), floor in prop::bool::ANY, width in 1_usize..70, height in 1_usize..50) {
        let set = crowd(120, seed);
        let view = camera(width, height);
        let options = Options {
            kernel_floor: if floor { (-4.5_f64).exp() } else { 0.0 },
            background: [0.2, 0.4, 0.6],
            ..Options::default()
        };
        let (fast, exact) = (render(&[set.view()], &view, &options), slow(&set, &view, &options));
        let worst = fast.rgba.iter().flatten().zip(exact.rgba.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        prop_assert!(worst < 6e-3, "{worst}");
        prop_assert!(psnr(&fast.rgb(), &exact.rgb()) > 80.0);
    }

    /// Numbers that are none, and anything extreme, draw a picture all the same.
    #[test]
    fn any_numbers_draw(values in prop::collection::vec(prop::num::f32::ANY, 14 * 5)) {
        let mut set = crowd(5, 1);
        for (i, v) in values.chunks(14).enumerate() {
            set.positions[i].copy_from_slice(&v[..3]);
            set.rotations[i].copy_from_slice(&v[3..7]);
            set.log_scales[i].copy_from_slice(&v[7..10]);
            set.logits[i] = v[10];
            set.dc[i].copy_from_slice(&v[11..]);
        }
        let picture = render(&[set.view()], &camera(40, 30), &Options { depth: true, ..Options::default() });
        prop_assert_eq!(picture.to_srgb8().len(), 40 * 30 * 3);
    }
}

#[test]
fn one_gaussian_is_where_and_as_bright_as_it_must_be() {
    let mut set = Set::default();
    // Sigma 0.05 at distance 2: 2.5 pixels.
    set.push([0.2, -0.1, 2.0], [0.05; 3], 0.8, [1.0, 0.5, 0.25]);
    let view = camera(101, 81);
    let picture = render(&[set.view()], &view, &Options { depth: true, ..Options::default() });
    let alpha = |x: usize, y: usize| picture.rgba[y * 101 + x][3];
    // Centre at 50.5 + 100 · 0.2 / 2, 40.5 − 100 · 0.1 / 2: the middle of pixel (60, 35).
    assert!((alpha(60, 35) - 0.8).abs() < 1e-4, "{}", alpha(60, 35));
    // Variance 2.5² (1 + 0.1²) along the line to the middle of the picture, and the dilation.
    let exact = 0.8 * (-0.5 * 9.0 / (6.25_f64 * (1.0 + 0.01) + 0.3)).exp();
    assert!((f64::from(alpha(63, 35)) - exact).abs() < 1e-4, "{} {exact}", alpha(63, 35));
    assert!(alpha(80, 35) == 0.0);
    let [r, g, b, a] = picture.rgba[35 * 101 + 60];
    assert!((r - a).abs() < 1e-6 && (g - 0.5 * a).abs() < 1e-6 && (b - 0.25 * a).abs() < 1e-6);
    assert!((picture.depth[35 * 101 + 60] - 2.0).abs() < 1e-5);
    assert!(picture.depth[0].is_infinite());
}

#[test]
fn order_is_by_depth_then_by_index() {
    let mut set = Set::default();
    set.push([0.0, 0.0, 3.0], [0.5; 3], 0.9, [1.0, 0.0, 0.0]);
    set.push([0.0, 0.0, 2.0], [0.5; 3], 0.9, [0.0, 1.0, 0.0]);
    set.push([0.0, 0.0, 2.0], [0.5; 3], 0.9, [0.0, 0.0, 1.0]);
    let picture = render(&[set.view()], &camera(21, 21), &Options::default());
    let [r, g, b, _] = picture.rgba[10 * 21 + 10];
    assert!((g - 0.9).abs() < 1e-3 && (b - 0.09).abs() < 1e-3 && (r - 0.009).abs() < 1e-3, "{r} {g} {b}");
    // Two sets are sorted among each other, as if they were one.
    let (mut first, mut second) = (Set::default(), Set::default());
    first.push([0.0, 0.0, 3.0], [0.5; 3], 0.9, [1.0, 0.0, 0.0]);
    second.push([0.0, 0.0, 2.0], [0.5; 3], 0.9, [0.0, 1.0, 0.0]);
    second.push([0.0, 0.0, 2.0], [0.5; 3], 0.9, [0.0, 0.0, 1.0]);
    assert_eq!(render(&[first.view(), second.view()], &camera(21, 21), &Options::default()), picture);
}

#[test]
fn every_number_of_threads_gives_the_same_bytes() {
    let set = crowd(5000, 11);
    let view = camera(200, 130);
    let options = Options { depth: true, ..Options::default() };
    let draw = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| render(&[set.view()], &view, &options))
    };
    let bits = |p: &Picture| -> Vec<u32> { p.rgba.iter().flatten().chain(&p.depth).map(|v| v.to_bits()).collect() };
    let one = bits(&draw(1));
    for threads in [2, 3, 8] {
        assert_eq!(bits(&draw(threads)), one, "{threads} threads");
    }
}

/// Scene and camera turned and moved together give the same picture.
#[test]
fn a_rigid_motion_of_everything_is_invisible() {
    use nalgebra::{Quaternion, Rotation3, UnitQuaternion, Vector3};
    let set = crowd(2000, 5);
    let turn = Rotation3::from_euler_angles(0.7, -1.1, 2.0);
    let shift = Vector3::new(3.0, -2.0, 1.0);
    let map = |p: [f64; 3]| -> [f64; 3] { (turn * Vector3::from(p) + shift).into() };
    let mut moved = set.clone();
    for (p, q) in moved.positions.iter_mut().zip(&mut moved.rotations) {
        *p = map(p.map(f64::from)).map(|v| v as f32);
        let old = UnitQuaternion::from_quaternion(Quaternion::new(q[0], q[1], q[2], q[3]).cast::<f64>());
        let new = UnitQuaternion::from_rotation_matrix(&turn) * old;
        *q = [new.w, new.i, new.j, new.k].map(|v| v as f32);
    }
    let camera = Camera {
        eye: [0.0; 3],
        target: [0.0, 0.0, 1.0],
        up: [0.0, -1.0, 0.0],
        fov_y_deg: 60.0,
        width: 160,
        height: 120,
    };
    let up = (turn * Vector3::from(camera.up)).into();
    let there = Camera { eye: map(camera.eye), target: map(camera.target), up, ..camera };
    let draw = |set: &Set, c: Camera| render(&[set.view()], &c.view().unwrap(), &Options::default()).rgb();
    let ratio = psnr(&draw(&set, camera), &draw(&moved, there));
    println!("rigid motion of scene and camera: {ratio:.1} dB");
    assert!(ratio > 60.0, "{ratio}");
}

/// Known pairs of the sRGB curve: its ends, its straight part, and 18 % grey, which is shown as 118 of 255.
#[test]
fn backgrounds_may_be_given_in_linear_light() {
    for (linear, byte) in [(0.0, 0), (1.0, 255), (0.002, 7), (0.18, 118), (-1.0, 0), (7.0, 255)] {
        let options = Options::default().with_linear_background([linear; 3]);
        assert_eq!(render(&[], &camera(2, 2), &options).to_srgb8(), [byte; 12], "{linear}");
    }
}

#[test]
fn cameras_that_see_nothing_are_refused() {
    let good =
        Camera { eye: [0.0; 3], target: [0.0, 0.0, 1.0], up: [0.0, -1.0, 0.0], fov_y_deg: 60.0, width: 16, height: 12 };
    assert!(good.view().is_ok());
    let bad = [
        Camera { width: 0, ..good },
        Camera { height: 1 << 20, ..good },
        Camera { fov_y_deg: 180.0, ..good },
        Camera { fov_y_deg: f64::NAN, ..good },
        Camera { target: [0.0; 3], ..good },
        Camera { up: [0.0, 0.0, 2.0], ..good },
        Camera { eye: [f64::NAN; 3], ..good },
        Camera { up: [0.0; 3], ..good },
    ];
    for camera in bad {
        assert!(camera.view().is_err(), "{camera:?}");
    }
}

#[test]
fn arrays_that_do_not_fit_are_refused() {
    let set = crowd(3, 1);
    assert!(set.view().check().is_ok());
    let short = Gaussians { rotations: &set.rotations[..2], ..set.view() };
    assert!(short.check().unwrap_err().to_string().contains("rotations"));
    assert!(Gaussians { sh_degree: 1, ..set.view() }.check().is_err());
}

#[test]
fn pictures_survive_a_file() {
    let picture = render(&[crowd(200, 2).view()], &camera(33, 21), &Options::default());
    let path = std::env::temp_dir().join(format!("cosplat-viewer-{}.png", std::process::id()));
    cosplat_viewer::png::write(&path, &picture).unwrap();
    let (width, height, back) = cosplat_viewer::png::read(&path).unwrap();
    std::fs::remove_file(&path).unwrap();
    assert_eq!((width, height), (33, 21));
    let bytes: Vec<u8> = back.iter().map(|v| (v * 255.0).round() as u8).collect();
    assert_eq!(bytes, picture.to_srgb8());
}

/// The basis of the picture is that of the files.
#[test]
fn colours_follow_the_bands_of_the_splats() {
    let mut set = Set::default();
    set.push([0.3, 0.2, 1.5], [0.5; 3], 0.9, [0.5; 3]);
    let view = camera(5, 5);
    let d = nalgebra::Vector3::new(0.3_f32, 0.2, 1.5).cast::<f64>().normalize();
    let basis = cosplat_splat::sh::basis(d.into());
    for (j, y) in basis.iter().enumerate() {
        let mut rest = [[0.0; 3]; 15];
        rest[j] = [0.3, -0.2, 0.1];
        let gaussians = Gaussians { sh_rest: &rest, sh_degree: 3, ..set.view() };
        let [r, g, b, a] = render(&[gaussians], &view, &Options::default()).rgba[12];
        for (got, c) in [(r, 0.3), (g, -0.2), (b, 0.1)] {
            assert!((f64::from(got / a) - (0.5 + c * y).max(0.0)).abs() < 1e-5, "{j}");
        }
    }
}
