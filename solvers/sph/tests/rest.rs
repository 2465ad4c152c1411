//! A tank at rest: pressure, momentum, and nothing that leaks.

#[cfg(test)]
mod common;

use std::sync::Arc;

use common::{Run, columns, liquid, plane, scene, tank, water};
use cosplat_core::asset::{Asset, TriangleMesh};
use cosplat_core::boundary::norm;
use cosplat_core::scene::{Source, StaticCollider, Wall};

#[test]
fn pressure_in_a_tank_grows_with_depth() {
    let (d, side, height, c) = (0.02, 0.2, 0.3, 24.0);
    let body = liquid(water(c, 1.0), [side, side, height], [0.5 * side, 0.5 * side, 0.5 * height], d);
    let mut run = Run::new(scene(vec![body], tank(side, side, Wall::Slip), 0.01));
    let start = run.setup.report.energy;
    for _ in 0..70 {
        run.step();
    }
    // The mean over ten windows: what is left of the pressure wave of the start oscillates.
    let layers = (height / d) as usize;
    let mut mean = vec![(0.0, 0.0, 0.0); layers];
    let mut last = None;
    for _ in 0..30 {
        last = Some(run.step());
        let (x, _, rho) = columns(&run.bytes());
        for (x, rho) in x.iter().zip(rho) {
            let layer = &mut mean[((x[2] / d) as usize).min(layers - 1)];
            let pressure = 1000.0 * c * c / 7.0 * ((rho / 1000.0_f64).powi(7) - 1.0);
            *layer = (layer.0 + 1.0, layer.1 + x[2], layer.2 + pressure);
        }
    }
    let report = last.expect("windows").report;
    let weight = 1000.0 * 9.81;
    // Base pressure is the weight of the water above, whatever its compression.
    let (mut square, mut of) = (0.0, 0.0);
    for (n, z, p) in mean.iter().map(|&(n, z, p)| (n, z / n, p / n)) {
        let exact = weight * (height - z);
        square += n * (p - exact).powi(2);
        of += n * exact * exact;
    }
    let base = mean[0].2 / mean[0].0 / (weight * (height - mean[0].1 / mean[0].0)) - 1.0;
    let error = (square / of).sqrt();
    println!("pressure: L2 {error:.4}, base {base:.4}; {:?} {:?}", report.energy, report.counters);
    println!("defect {:?} of {}, {} substeps", run.defect, run.gross, run.substeps);
    assert!(error < 0.03, "{error}");
    assert!(base.abs() < 0.02, "{base}");
    // Nobody has left the tank; on the walls a particle stands off by half a spacing, a third where it is pressed.
    let inside = |x: &[f64; 3]| (0..2).all(|k| x[k] > 0.3 * d && x[k] < side - 0.3 * d) && x[2] > 0.3 * d;
    let (x, ..) = columns(&run.bytes());
    assert!(x.iter().all(inside) && x.iter().all(|x| x[2] < height), "{x:?}");
    // Kinetic energy, of that to fall through the whole height.
    let (kinetic, fall) = (report.energy.kinetic_j, 1000.0 * side * side * height * 9.81 * height);
    println!("kinetic {:e} of a fall", kinetic / fall);
    assert!(kinetic < 2e-4 * fall, "{kinetic}");
    assert!(report.energy.potential_j + kinetic + report.energy.dissipated_j < start.potential_j, "energy only falls");
    assert!(
        run.defect[0] < 1e-12 * run.gross.max(1.0) && run.defect[1] < 1e-12 * run.gross.max(1.0),
        "{:?}",
        run.defect
    );
}

#[test]
fn a_valley_of_a_terrain_holds_water() {
    // A bowl of 0.4 m x 0.4 m, z = 2 r², in squares of 2 cm, and 1 cm above its bottom a block of water that fills a part.
    let (d, n) = (0.02, 20_u32);
    let bowl = |x: f64, y: f64| 2.0 * (x * x + y * y);
    let at = |i: u32| f64::from(i) * 0.02 - 0.2;
    let vertices_m = (0..=n).flat_map(|i| (0..=n).map(move |j| [at(i), at(j), bowl(at(i), at(j))])).collect();
    let square = |i: u32, j: u32| {
        let a = i * (n + 1) + j;
        [[a, a + n + 1, a + 1], [a + 1, a + n + 1, a + n + 2]]
    };
    let triangles = (0..n).flat_map(|i| (0..n).flat_map(move |j| square(i, j))).collect();
    let mesh = TriangleMesh { vertices_m, triangles };
    let ground = StaticCollider {
        source: Source::HeightField { file: "bowl.obj".into(), metres_per_unit: 1.0, up: "+z".into() },
        ..plane("bowl", [0.0; 3], common::UPRIGHT, Wall::NoSlip)
    };
    for pressure in ["wcsph", "dfsph"] {
        let body = liquid(water(15.0, 1.0), [0.16, 0.16, 0.06], [0.02, 0.0, 0.06], d);
        let mut start = scene(vec![body], vec![ground.clone()], 0.01);
        start.assets.insert("bowl".into(), Arc::new(Asset::Mesh(mesh.clone())));
        start.params.insert("pressure".into(), pressure.into());
        let mut run = Run::new(start);
        for _ in 0..80 {
            run.step();
        }
        let (x, v, _) = columns(&run.bytes());
        let (count, fastest) = (x.len() as f64, v.iter().map(|&v| norm(v)).fold(0.0, f64::max));
        let lowest = x.iter().map(|x| x[2] - bowl(x[0], x[1])).fold(f64::INFINITY, f64::min);
        let height = x.iter().map(|x| x[2]).sum::<f64>() / count;
        // A paraboloid z = 2 r² filled to z = H holds π H²/4 and has its centre at 2 H/3.
        let expected = (4.0 * count * d * d * d / std::f64::consts::PI).sqrt() * 2.0 / 3.0;
        println!(
            "{pressure}: lowest {lowest}, fastest {fastest}, centre {height} of {expected}, {:?}",
            run.setup.left_out
        );
        // Half a spacing off the ground at rest, less where it is pressed in a hollow; none has gone through.
        assert!(lowest > 0.0, "{lowest}");
        // Fewer than five particles deep: a quarter of a spacing.
        assert!((height - expected).abs() < 0.25 * d && fastest < 0.3, "{height} {expected} {fastest}");
        assert!(run.defect[0] < 1e-12 * run.gross && run.defect[1] < 1e-12 * run.gross, "{:?}", run.defect);
    }
}
