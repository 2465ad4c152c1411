//! A tank at rest: pressure, momentum, and nothing that leaks.

#[cfg(test)]
mod common;

use common::{Run, columns, liquid, scene, tank, water};
use cosplat_core::scene::Wall;

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
