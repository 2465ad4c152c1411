//! Pictures of captured scenes against those of an independent renderer (splat-transform 2.7.1).
//!
//! `COSPLAT_DATA` names the data folder; without it the tests say that they are skipped.

use std::path::PathBuf;
use std::time::Instant;

use cosplat_splat::Splats;
use cosplat_splat::format::read_file;
use cosplat_viewer::{Camera, Gaussians, Options, png, psnr, render};

/// What the other renderer subtracts from the kernel: e^−4.5, its value at three standard deviations.
const FLOOR: f64 = 0.011_108_996_538_242_306;

fn data() -> Option<PathBuf> {
    let folder = std::env::var_os("COSPLAT_DATA").map(PathBuf::from);
    if folder.is_none() {
        eprintln!("skipped: COSPLAT_DATA does not name a data folder");
    }
    folder
}

fn gaussians(s: &Splats) -> Gaussians<'_> {
    Gaussians {
        positions: &s.positions,
        rotations: &s.rotations,
        log_scales: &s.log_scales,
        opacity_logits: &s.opacity_logits,
        sh_dc: &s.sh_dc,
        sh_rest: &s.sh_rest,
        sh_degree: s.sh_degree,
        antialiased: s.antialiased,
    }
}

/// Scene, picture of the other renderer, and its camera in the axes of the file.
fn cases() -> [(&'static str, &'static str, Camera); 3] {
    let camera = |eye, target, up, fov_y_deg, width, height| Camera { eye, target, up, fov_y_deg, width, height };
    let up = [0.0, -1.0, 0.0];
    [
        ("plant.splat", "plant.png", camera([0.0, 0.0, -1.6], [0.0; 3], [0.0, 1.0, 0.0], 45.0, 480, 640)),
        ("playbot_31k.ply", "playbot_31k.png", camera([-1.2, -1.2, -1.6], [0.0, -0.4, 0.0], up, 50.0, 400, 300)),
        (
            "statue_narcissus.sog",
            "statue_narcissus.png",
            camera([-1.6, -0.6, -4.2], [0.0, -0.2, 0.0], up, 50.0, 320, 400),
        ),
    ]
}

#[test]
fn pictures_are_those_of_another_renderer() {
    let Some(folder) = data() else { return };
    for (file, picture, camera) in cases() {
        let splats = read_file(&folder.join("splats").join(file)).unwrap().splats;
        let (width, height, reference) = png::read(&folder.join("reference_renders").join(picture)).unwrap();
        assert_eq!((width, height), (camera.width, camera.height));
        let draw = |kernel_floor| {
            let options = Options { kernel_floor, ..Options::default() };
            psnr(&render(&[gaussians(&splats)], &camera.view().unwrap(), &options).rgb(), &reference)
        };
        let (with, without) = (draw(FLOOR), draw(0.0));
        println!("{file}: {with:.2} dB with the other renderer's kernel, {without:.2} dB without");
        assert!(with >= 55.0, "{file}: {with:.2} dB");
        assert!(without >= 42.0, "{file}: {without:.2} dB");
    }
}

/// A scene and its quantised copies differ by what the coding loses.
#[test]
fn formats_of_one_scene_look_alike() {
    let Some(folder) = data() else { return };
    let (_, _, camera) = cases()[1];
    let view = camera.view().unwrap();
    let draw = |file: &str| {
        let splats = read_file(&folder.join("splats").join(file)).unwrap().splats.to_axes(cosplat_splat::Axes::Rdf);
        render(&[gaussians(&splats)], &view, &Options::default()).rgb()
    };
    let ply = draw("playbot_31k.ply");
    for file in ["playbot_31k.v3.spz", "playbot_31k.v4.spz"] {
        let ratio = psnr(&draw(file), &ply);
        println!("{file} against .ply: {ratio:.2} dB");
        assert!(ratio > 30.0, "{file}: {ratio:.2} dB");
    }
}

/// Time for the plant at 960 × 540; printed, not judged, because machines differ.
#[test]
fn time_of_a_picture() {
    let Some(folder) = data() else { return };
    let splats = read_file(&folder.join("splats/plant.v4.spz")).unwrap().splats;
    let camera = Camera {
        eye: [0.0, 0.0, 1.1],
        target: [0.0; 3],
        up: [0.0, 1.0, 0.0],
        fov_y_deg: 50.0,
        width: 960,
        height: 540,
    };
    let view = camera.view().unwrap();
    let times = (0..10).map(|_| {
        let start = Instant::now();
        std::hint::black_box(render(&[gaussians(&splats)], &view, &Options::default()));
        start.elapsed().as_secs_f64() * 1e3
    });
    let mut times: Vec<f64> = times.collect();
    times.sort_by(f64::total_cmp);
    println!("{} Gaussians at 960 x 540: best {:.1} ms, median {:.1} ms of 10", splats.len(), times[0], times[5]);
}
