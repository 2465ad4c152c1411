//! Bodies on a height field: what it carries, what slides down, and what it refuses.

use std::sync::Arc;

use crate::common::{Run, body, cuboid, elastic, gravity, plane, scene, set};
use cosplat_core::asset::{Asset, TriangleMesh};
use cosplat_core::boundary::{dot, norm, sub};
use cosplat_core::plugin::{Plugin, SolverScene};
use cosplat_core::scene::{Source, Wall};
use cosplat_mpm::Mpm;

const DX: f64 = 0.02;

/// A plane that rises along x, as `2 n²` triangles.
fn slope(rise: f64, n: u32) -> TriangleMesh {
    let at = |i: u32| f64::from(i) * 2.0 / f64::from(n) - 1.0;
    let vertices_m = (0..=n).flat_map(|i| (0..=n).map(move |j| [at(i), at(j), rise * at(i)])).collect();
    let square = |i: u32, j: u32| {
        let a = i * (n + 1) + j;
        [[a, a + n + 1, a + 1], [a + 1, a + n + 1, a + n + 2]]
    };
    TriangleMesh { vertices_m, triangles: (0..n).flat_map(|i| (0..n).flat_map(move |j| square(i, j))).collect() }
}

/// A slab on a slope of `degrees` with that friction: the scene, and the uphill direction.
fn on_slope(degrees: f64, friction: f64) -> (SolverScene, [f64; 3]) {
    let angle = degrees.to_radians();
    let normal = [-angle.sin(), 0.0, angle.cos()];
    let mut slab =
        body("slab", elastic(1000.0, 1e6, 0.3), cuboid([0.16, 0.16, 0.08]), normal.map(|n| 0.04 * n), DX / 2.0);
    slab.pose.orientation = [0.0, -(0.5 * angle).sin(), 0.0, (0.5 * angle).cos()];
    let mut start = scene(vec![slab], 1e-3);
    let rough = Wall::Friction { static_friction: friction, kinetic_friction: friction };
    let mut hill = plane("hill", [0.0; 3], crate::common::UPRIGHT, rough);
    hill.source = Source::HeightField { file: "hill.obj".into(), metres_per_unit: 1.0, up: "+z".into() };
    start.statics = vec![hill];
    start.assets.insert("hill".into(), Arc::new(Asset::Mesh(slope(angle.tan(), 9))));
    start.actions.push(gravity(-9.81));
    (start, [angle.cos(), 0.0, angle.sin()])
}

#[test]
fn friction_decides_whether_a_slab_slides_down_a_hill() {
    // tan 20° = 0.364.
    for (friction, holds) in [(0.2, false), (0.34, false), (0.6, true)] {
        let (start, uphill) = on_slope(20.0, friction);
        let mut run = Run::<f32>::new(start);
        let from = run.setup.report.bodies[0].position_m;
        for _ in 0..250 {
            run.step();
        }
        let state = run.step().report.bodies[0];
        let (speed, way) = (dot(state.linear_velocity_m_s, uphill), sub(state.position_m, from));
        let angle = 20.0_f64.to_radians();
        let exact = -9.81 * (angle.sin() - friction * angle.cos()) * 0.251;
        let sunk = dot(way, [-angle.sin(), 0.0, angle.cos()]);
        println!("friction {friction}: {speed} m/s, sliding alone {exact}; off the hill by {sunk} m");
        if holds {
            // The same swing lets go of it for moments: 2 % of the way and of the speed that it would have without friction.
            let free = 9.81 * angle.sin();
            assert!(
                norm(way) < 0.02 * 0.5 * free * 0.251 * 0.251 && speed.abs() < 0.02 * free * 0.251,
                "{speed} {way:?}"
            );
        } else {
            // Just above the threshold the swing that sudden gravity starts lets it stick while it is pressed on and
            // slip while it is not, which costs friction; well above it slides all the time, and what is left is the
            // swing along the hill, g sin / 2πf = 1 cm/s of 38, and across it, 1.4 cm/s times the friction.
            let range = if friction < 0.3 { 0.95..1.05 } else { 0.9..2.0 };
            assert!(range.contains(&(speed / exact)), "{speed} {exact}");
        }
        // Its own weight presses it together by ρ g H²/2E = 0.03 mm; edges between triangles are no steps.
        assert!(sunk.abs() < 5e-4, "{sunk}");
        assert!(run.defect[0] < 1e-6 * run.gross, "{:?} of {}", run.defect, run.gross);
    }
}

#[test]
fn an_open_mesh_is_refused_as_a_solid_and_an_overhang_as_a_hill() {
    let (start, _) = on_slope(20.0, 0.5);
    let refusal =
        |scene: &SolverScene| Mpm::<f32>::default().setup(scene).err().map(|e| e.to_string()).unwrap_or_default();
    let mut solid = start.clone();
    solid.statics[0].source = Source::Mesh { file: "hill.obj".into(), metres_per_unit: 1.0, up: "+z".into() };
    let words = refusal(&solid);
    assert!(words.contains("`hill`") && words.contains("open") && words.contains("height_field"), "{words}");
    let mut fold = start;
    let mut mesh = slope(0.0, 9);
    mesh.vertices_m[44] = [0.9, 0.0, 0.3];
    fold.assets.insert("hill".into(), Arc::new(Asset::Mesh(mesh)));
    let words = refusal(&fold);
    assert!(words.contains("`hill`") && words.contains("overhang"), "{words}");
}

#[test]
fn cubes_stay_on_a_mountain_of_a_scan() {
    let Ok(folder) = std::env::var("COSPLAT_DATA") else { return };
    let Ok(text) = std::fs::read_to_string(format!("{folder}/meshes/mountain.obj")) else { return };
    // 30 m of file become 3 m; its up axis is y.
    let number = |word: &str| word.split('/').next().and_then(|n| n.parse::<f64>().ok()).expect("a number");
    let mut mesh = TriangleMesh::default();
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words.as_slice() {
            ["v", x, y, z, ..] => mesh.vertices_m.push([0.1 * number(x), -0.1 * number(z), 0.1 * number(y)]),
            ["f", a, b, c] => mesh.triangles.push([a, b, c].map(|n| number(n) as u32 - 1)),
            _ => {}
        }
    }
    let hill = cosplat_core::distance::HeightField::new(&mesh).expect("a height field");
    // The highest ground below a cube that may turn.
    let near = (0..400).map(|i| [i / 20, i % 20].map(|k| 0.3 * (f64::from(k) / 19.0 - 0.5)));
    let top = near.map(|[x, y]| hill.height(x, y).expect("inside")).fold(f64::NEG_INFINITY, f64::max);
    let (mut start, _) = on_slope(0.0, 0.8);
    start.bodies[0].source = cuboid([0.16; 3]);
    start.bodies[0].pose.position_m = [0.0, 0.0, top + 0.1];
    start.assets.insert("hill".into(), Arc::new(Asset::Mesh(mesh)));
    set(&mut start, "grid_spacing_m", DX);
    let mut run = Run::<f32>::new(start);
    let mut lowest = f64::INFINITY;
    for _ in 0..20 {
        for _ in 0..10 {
            run.step();
        }
        let above = |x: &[f64; 3]| x[2] - hill.height(x[0], x[1]).expect("inside");
        lowest = run.particles("slab").iter().map(above).fold(lowest, f64::min);
    }
    println!("lowest particle {lowest} m above the mountain");
    // It has landed, half a particle above the ground: surfaces of particles are held to 0.05 cells along the normal.
    assert!(lowest < 0.5 * DX && lowest > 0.0, "{lowest}");
    assert!(run.defect[0] < 1e-6 * run.gross, "{:?} of {}", run.defect, run.gross);
}
