//! Slopes of sand: on which it stays, how it slides, and the one that a steeper heap comes to.

use crate::common::{Run, TO_MINUS_Y, TO_X, TO_Y, UPRIGHT, body, cuboid, plane, scene, set};
use cosplat_core::plugin::SolverScene;
use cosplat_core::scene::{Action, ActionKind, Material, Source, Wall};

const DX: f64 = 0.01;
/// Time at which gravity leans \[s\].
const LEANS: f64 = 0.2;

fn sand(friction_angle_deg: f64) -> Material {
    Material::Granular {
        density_kg_m3: 1600.0,
        youngs_modulus_pa: 3e5,
        poissons_ratio: 0.2,
        friction_angle_deg,
        cohesion_pa: 0.0,
    }
}

/// A sheet of sand one cell thick on a floor that holds it, under gravity that leans by so many degrees towards +x.
fn sheet(source: Source, at: [f64; 3], angle: f64, lean_deg: f64) -> SolverScene {
    let mut start = scene(vec![body("sand", sand(angle), source, at, 0.5 * DX)], 0.01);
    set(&mut start, "friction_cone", "shear");
    start.statics = vec![
        plane("floor", [0.0; 3], UPRIGHT, Wall::NoSlip),
        plane("front", [0.0; 3], TO_Y, Wall::Slip),
        plane("back", [0.0, DX, 0.0], TO_MINUS_Y, Wall::Slip),
    ];
    let (sin, cos) = lean_deg.to_radians().sin_cos();
    let pull = |x: f64, z: f64, from_s: f64| {
        let kind = ActionKind::Gravity { acceleration_m_s2: [9.81 * x, 0.0, 9.81 * z] };
        Action { kind, bodies: Vec::new(), from_s, until_s: None }
    };
    // It is loaded in steps before it is leant, so that it does not bounce off its floor.
    start.actions = (0..10).map(|i| pull(0.0, -0.1 * cos, 0.01 * f64::from(i))).collect();
    start.actions.push(pull(sin, 0.0, LEANS));
    start
}

/// Mean way along a slope, from the window `from` on, of what lay 0.35 m to 0.45 m above the lower end of a layer 0.6 m long
/// and 0.05 m deep, above half its depth, at each hundredth of a second.
fn slides(lean_deg: f64, from: usize, windows: usize) -> Vec<f64> {
    let mut run = Run::<f32>::new(sheet(cuboid([0.6, DX, 0.05]), [0.0, 0.5 * DX, 0.025], 30.0, lean_deg));
    let chosen: Vec<usize> = {
        let all = run.particles("sand");
        (0..all.len()).filter(|&i| (all[i][0] + 0.1).abs() < 0.05 && all[i][2] > 0.025).collect()
    };
    let mean = |run: &Run<f32>| {
        let all = run.particles("sand");
        chosen.iter().map(|&i| all[i][0]).sum::<f64>() / chosen.len() as f64
    };
    let mut way = Vec::new();
    for window in 0..windows {
        run.step();
        if window >= from {
            way.push(mean(&run));
        }
    }
    way
}

#[test]
fn a_layer_stays_below_the_friction_angle() {
    // In the first second it follows its lower end, which is open and slumps, by 2.1 mm.
    let way = slides(25.0, 140, 240);
    let creep = way[way.len() - 1] - way[0];
    println!("{creep} m in 1 s");
    // Published aim: 1 mm in 2 s, a tenth of a cell. On 20° it crept by 4.7 mm/s when nodes behind the floor were free.
    assert!(creep.abs() < 0.5e-3, "{creep}");
}

#[test]
fn a_layer_slides_above_the_friction_angle() {
    let way = slides(40.0, 25, 36);
    let found = (way[10] - 2.0 * way[5] + way[0]) / 0.05_f64.powi(2);
    // g (sin θ - tan φ cos θ): in an infinite slope shear over pressure is tan θ at every depth.
    let wanted = 9.81 * (40.0_f64.to_radians().sin() - 30.0_f64.to_radians().tan() * 40.0_f64.to_radians().cos());
    println!("{found} m/s², {wanted} wanted");
    assert!((found / wanted - 1.0).abs() < 0.05, "{found} of {wanted}");
}

/// Slope in degrees to which the half of a heap as steep as 40° comes; a wall that slips stands in its middle.
fn heap(angle: f64) -> f64 {
    let (height, spacing) = (0.16, 0.5 * DX);
    let slope = 40.0_f64.to_radians().tan();
    let mut positions_m = Vec::new();
    for k in 0..(height / spacing) as usize {
        let z = (k as f64 + 0.5) * spacing;
        for i in 0..((height - z) / slope / spacing) as usize {
            for j in 0..2 {
                positions_m.push([(i as f64 + 0.5) * spacing, (f64::from(j) + 0.5) * spacing, z]);
            }
        }
    }
    let mut start = sheet(Source::Points { positions_m }, [0.0; 3], angle, 0.0);
    start.statics.push(plane("middle", [0.0; 3], TO_X, Wall::Slip));
    let mut run = Run::<f32>::new(start);
    for _ in 0..120 {
        run.step();
    }
    // Surface over each cell between a fifth and four fifths of the height, and the line of least squares through it.
    let places = run.particles("sand");
    let top = |cell: usize| {
        let here = places.iter().filter(|p| (p[0] / DX) as usize == cell);
        here.map(|p| p[2]).fold(0.0, f64::max)
    };
    let peak = top(0);
    let surface: Vec<[f64; 2]> = (0..60)
        .map(|cell| [(cell as f64 + 0.5) * DX, top(cell)])
        .filter(|[_, z]| (0.2 * peak..0.8 * peak).contains(z))
        .collect();
    let n = surface.len() as f64;
    let mean = [0, 1].map(|k| surface.iter().map(|p| p[k]).sum::<f64>() / n);
    let sum = |k: usize| surface.iter().map(|p| (p[0] - mean[0]) * (p[k] - mean[k])).sum::<f64>();
    let found = (-sum(1) / sum(0)).atan().to_degrees();
    println!("{angle}°: {found}° over {n} cells, {peak} m high");
    found
}

#[test]
fn a_steep_heap_comes_to_its_angle_of_repose() {
    // Up to 4° below the friction angle: it comes to rest from a slide.
    let found = heap(30.0);
    assert!((26.0..30.0).contains(&found), "{found}");
    // A control: what is rougher than the heap is steep stays.
    let found = heap(63.0);
    assert!((38.0..42.0).contains(&found), "{found}");
}
