//! Proxies inside captured surfaces, and surfels.

mod common;

use std::f64::consts::PI;

use common::{Random, data, some_splats};
use cosplat_splat::fill::{FillError, Filling, Settings, fill};
use cosplat_splat::surfel::{Sample, surfels};
use cosplat_splat::{Axes, Similarity, Splats, format::read_file};

/// Points of a sphere, evenly, by the golden angle.
fn sphere(count: usize, radius: f64) -> Vec<Sample> {
    let area = (4.0 * PI * radius * radius / count as f64) as f32;
    let point = |i: usize| {
        let z = 1.0 - (2.0 * i as f64 + 1.0) / count as f64;
        let (r, angle) = ((1.0 - z * z).sqrt(), i as f64 * PI * (3.0 - 5.0_f64.sqrt()));
        let n = [r * angle.cos(), r * angle.sin(), z];
        Sample { position: n.map(|v| (v * radius) as f32), normal: n.map(|v| v as f32), area, colour: [0.5; 3] }
    };
    (0..count).map(point).collect()
}

/// Points of a torus around z, about evenly.
fn torus(rows: usize, big: f64, small: f64) -> Vec<Sample> {
    let mut out = Vec::new();
    for i in 0..rows {
        let v = 2.0 * PI * i as f64 / rows as f64;
        let ring = big + small * v.cos();
        let count = (rows as f64 * ring / small).round() as usize;
        for j in 0..count {
            let u = 2.0 * PI * (j as f64 + 0.5 * (i % 2) as f64) / count as f64;
            let n = [u.cos() * v.cos(), u.sin() * v.cos(), v.sin()];
            let p = [u.cos() * ring, u.sin() * ring, small * v.sin()];
            out.push(Sample {
                position: p.map(|c| c as f32),
                normal: n.map(|c| c as f32),
                area: 1e-3,
                colour: [0.5; 3],
            });
        }
    }
    out
}

fn filled(samples: &[Sample], spacing: f64) -> Filling {
    fill(&surfels(samples), &Settings { sigmas: 0.0, ..Settings::new(spacing) }).expect("there is a surface")
}

#[test]
fn spheres_hold_their_volume() {
    // Root mean square over places on the lattice; a perfect inside test reaches 8e-3, 3e-3 and 6e-4.
    for (per_radius, gate) in [(5.0, 16e-3), (10.0, 6e-3), (20.0, 1.2e-3)] {
        let h = 1.0 / per_radius;
        let mut r = Random::new(17);
        let mut squares = 0.0;
        let mut sum = 0.0;
        for _ in 0..6 {
            let shift = [0; 3].map(|_| r.single(0.0, h));
            let mut samples = sphere(20_000, 1.0);
            for s in &mut samples {
                s.position = [0, 1, 2].map(|k| s.position[k] + shift[k]);
            }
            let found = filled(&samples, h);
            let error = found.inside_volume() / (4.0 / 3.0 * PI) - 1.0;
            squares += error * error / 6.0;
            sum += error / 6.0;
            let length = |p: &[f32; 3]| (0..3).map(|k| f64::from(p[k] - shift[k]).powi(2)).sum::<f64>().sqrt();
            assert!(found.proxies.iter().all(|p| length(p) < 1.0 - 0.4 * h));
        }
        println!("sphere R/h = {per_radius}: volume error mean {sum:.1e}, root mean square {:.1e}", squares.sqrt());
        assert!(squares.sqrt() < gate, "{}", squares.sqrt());
    }
}

#[test]
fn a_torus_keeps_its_hole() {
    let found = filled(&torus(120, 1.0, 0.4), 0.05);
    let error = found.inside_volume() / (2.0 * PI * PI * 0.16) - 1.0;
    println!("torus r/h = 8: volume error {error:.2e}, {} proxies, {} two-sided", found.proxies.len(), found.two_sided);
    assert!(error.abs() < 0.02, "{error}");
    for p in &found.proxies {
        let [x, y, z] = p.map(f64::from);
        assert!((x.hypot(y) - 1.0).hypot(z) < 0.4, "{p:?}");
    }
}

#[test]
fn small_holes_are_closed_and_sheets_and_bowls_are_not_filled() {
    let pierced: Vec<Sample> = sphere(20_000, 1.0).into_iter().filter(|s| s.position[2] < 0.985).collect();
    let found = filled(&pierced, 0.1);
    assert!((found.inside_volume() / (4.0 / 3.0 * PI) - 1.0).abs() < 0.05, "{}", found.inside_volume());
    let bowl: Vec<Sample> = sphere(20_000, 1.0).into_iter().filter(|s| s.position[2] < 0.0).collect();
    let mut r = Random::new(1);
    let sheet: Vec<Sample> = (0..20_000)
        .map(|_| Sample {
            position: [r.single(-1.0, 1.0), r.single(-1.0, 1.0), 0.0],
            normal: [0.0, 0.0, 1.0],
            area: 2e-4,
            colour: [0.5; 3],
        })
        .collect();
    for (name, open) in [("bowl", bowl), ("sheet", sheet)] {
        let found = filled(&open, 0.05);
        println!("{name}: {} proxies, {} inside", found.proxies.len(), found.interior.len());
        assert!(found.proxies.is_empty(), "{name} {}", found.proxies.len());
    }
}

#[test]
fn what_cannot_be_filled_is_refused() {
    let splats = some_splats(100, 0, 1);
    for spacing in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(fill(&splats, &Settings::new(spacing)).unwrap_err(), FillError::Spacing);
    }
    assert!(matches!(fill(&splats, &Settings::new(1e-6)), Err(FillError::TooFine(..))));
    assert!(matches!(fill(&Splats::default(), &Settings::new(0.1)), Err(FillError::NoSurface(0))));
    let mut broken = splats.clone();
    broken.positions[3][0] = f32::NAN;
    broken.log_scales[4][0] = f32::INFINITY;
    assert!(fill(&broken, &Settings::new(0.1)).is_ok());
}

#[test]
fn a_captured_plant_is_filled() {
    let Some(folder) = data() else { return };
    let mut plant = read_file(&folder.join("splats/plant.v4.spz")).unwrap().splats;
    Similarity::upright([0.0, 1.0, 0.0], 0.45).unwrap().apply(&mut plant, Axes::Scene);
    let start = std::time::Instant::now();
    let found = fill(&plant, &Settings { on_ground: true, ..Settings::new(0.006) }).unwrap();
    println!(
        "plant, h = 6 mm: {} proxies, {:.3} litres inside, {} surface points, {} two-sided, pitch {:.4}, {:.0} ms",
        found.proxies.len(),
        found.inside_volume() * 1e3,
        found.surface_points,
        found.two_sided,
        found.pitch,
        start.elapsed().as_secs_f64() * 1e3
    );
    // The pot is about 15 cm wide and high and full of soil: some two litres.
    assert!((1e-3..4e-3).contains(&found.inside_volume()), "{}", found.inside_volume());
    assert!(found.proxies.len() > 1000, "{}", found.proxies.len());
}

/// A cup that stands on its open end.
#[test]
fn an_underside_that_no_camera_saw_is_closed() {
    let dome: Vec<Sample> = sphere(20_000, 1.0).into_iter().filter(|s| s.position[2] > 0.0).collect();
    let open = filled(&dome, 0.05);
    assert!(open.proxies.is_empty());
    let settings = Settings { sigmas: 0.0, on_ground: true, ..Settings::new(0.05) };
    let closed = fill(&surfels(&dome), &settings).unwrap();
    let error = closed.inside_volume() / (2.0 / 3.0 * PI) - 1.0;
    println!("dome on the ground R/h = 20: volume error {error:.2e}, {} two-sided", closed.two_sided);
    assert!(error.abs() < 0.05, "{error}");
    assert!(closed.proxies.iter().all(|p| p[2] > 0.0));
}

#[test]
fn surfels_are_flat_and_face_their_normal() {
    let splats = surfels(&sphere(50, 2.0));
    for (i, sample) in sphere(50, 2.0).iter().enumerate() {
        let s = splats.scales(i);
        assert!((s[0] - 0.6 * f64::from(sample.area).sqrt()).abs() < 1e-5 && s[0] > 9.0 * s[2]);
        let [w, x, y, z] = splats.rotations[i];
        let q = nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, x, y, z));
        let n = q * nalgebra::Vector3::z();
        assert!((n - nalgebra::Vector3::from(sample.normal)).amax() < 1e-6);
    }
    let zero = surfels(&[Sample { position: [0.0; 3], normal: [0.0; 3], area: 0.0, colour: [1.0; 3] }]);
    assert!(zero.scales(0).iter().all(|s| s.is_finite()) && zero.rotations[0][0].to_bits() == 1.0_f32.to_bits());
}
