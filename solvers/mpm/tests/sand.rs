//! Sand: columns that collapse, heaps that stand, energy.

use crate::common::rock::{Rock, with_rock};
use crate::common::{Run, TO_MINUS_Y, TO_X, TO_Y, UPRIGHT, body, cuboid, gravity, plane, scene, set, tank};
use cosplat_core::scene::{Material, Source, Wall};

fn sand(friction_angle_deg: f64, cohesion_pa: f64) -> Material {
    Material::Granular {
        density_kg_m3: 1600.0,
        youngs_modulus_pa: 3e5,
        poissons_ratio: 0.2,
        friction_angle_deg,
        cohesion_pa,
    }
}

/// A column 0.1 m wide and `aspect` times as high, at a slip wall, let go at t = 0 on a rough floor.
struct Collapse {
    /// Place of the foremost particle, less the width, over the width.
    runout: f64,
    /// Energy at the start and the most later \[J\].
    energy: [f64; 2],
    /// Places at the end.
    places: Vec<[f64; 3]>,
}

fn collapse(aspect: f64, cells: u32, material: Material) -> Collapse {
    let (width, dx) = (0.1, 0.1 / f64::from(cells));
    let height = aspect * width;
    let column = body("sand", material, cuboid([width, dx, height]), [0.5 * width, 0.5 * dx, 0.5 * height], 0.5 * dx);
    let mut start = scene(vec![column], 0.01);
    set(&mut start, "friction_cone", "shear");
    start.statics = vec![
        plane("floor", [0.0; 3], UPRIGHT, Wall::Friction { static_friction: 0.6, kinetic_friction: 0.6 }),
        plane("left", [0.0; 3], TO_X, Wall::Slip),
        plane("front", [0.0; 3], TO_Y, Wall::Slip),
        plane("back", [0.0, dx, 0.0], TO_MINUS_Y, Wall::Slip),
    ];
    start.actions = vec![gravity(-9.81)];
    let mut run = Run::<f32>::new(start);
    let total = |e: &cosplat_core::plugin::Energy| e.kinetic_j + e.potential_j;
    let mut energy = [total(&run.setup.report.energy), f64::NEG_INFINITY];
    // It is over after 3.3 √(H/g); half as long again.
    let windows = (5.0 * (height / 9.81).sqrt() / 0.01).ceil() as u64;
    for _ in 0..windows {
        energy[1] = energy[1].max(total(&run.step().report.energy));
    }
    let places = run.particles("sand");
    let front = places.iter().map(|p| p[0]).fold(0.0, f64::max);
    let runout = (front - width) / width;
    println!("aspect {aspect}: run-out {runout:.3}, {} particles, {} substeps", places.len(), run.substeps);
    Collapse { runout, energy, places }
}

/// Exponent of the run-out by the aspect ratio: slope of the line through the logarithms.
fn exponent(all: &[(f64, f64)]) -> f64 {
    let logs = || all.iter().map(|(aspect, runout)| (aspect.ln(), runout.ln()));
    let n = all.len() as f64;
    let (x, y) = logs().fold((0.0, 0.0), |sum, (x, y)| (sum.0 + x / n, sum.1 + y / n));
    logs().map(|p| (p.0 - x) * (p.1 - y)).sum::<f64>() / logs().map(|p| (p.0 - x).powi(2)).sum::<f64>()
}

/// Run-out of columns that many cells wide, by their aspect ratios; none gains energy.
fn runouts(all: &[(f64, u32)]) -> Vec<(f64, f64)> {
    let one = |&(aspect, cells): &(f64, u32)| {
        let run = collapse(aspect, cells, sand(30.0, 0.0));
        assert!(run.energy[1] <= run.energy[0] * (1.0 + 1e-3), "{:?}", run.energy);
        (aspect, run.runout)
    };
    all.iter().map(one).collect()
}

#[test]
fn columns_run_out_as_in_the_experiments() {
    // Lube et al. 2005: 1.2 a up to a = 2.3, then 1.9 a^(2/3); Lajeunesse et al. 2005: 1.8 a up to 3, then 2.3 a^(2/3), each
    // about 10 %; between 0.85 of the one and 1.1 of the other. Half as high as wide it takes twice as many cells: 10 of
    // them high the foot is as fine as at a = 1.
    let found = runouts(&[(0.5, 20), (1.0, 10), (2.0, 10), (4.0, 10)]);
    for ((aspect, runout), [least, most]) in found.iter().zip([[0.51, 1.0], [1.02, 2.0], [2.4, 3.6], [4.79, 5.80]]) {
        assert!((least..=most).contains(runout), "{runout} at {aspect}");
    }
    // Linear below a = 2.3, with the catalogue's tolerance: 1.16. With 20 cells over each height it is 0.99.
    let low = exponent(&found[..3]);
    println!("exponent {low:.3} of low columns");
    assert!((low - 1.0).abs() < 0.25, "{low}");
}

#[test]
fn tall_columns_run_out_with_two_thirds_of_their_aspect_ratio() {
    // Six cells wide; with ten run-outs are longer by 11 to 14 %, with an exponent of 0.75 in place of 0.78.
    let found = runouts(&[(4.0, 6), (5.6, 6), (8.0, 6)]);
    let tall = exponent(&found);
    println!("exponent {tall:.3} of tall columns");
    // The catalogue's tolerance.
    assert!((tall - 2.0 / 3.0).abs() < 0.25, "{tall}");
    // Between 0.85 of the shorter and 1.1 of the longer of the two laws, as for lower columns.
    let last = found[2].1;
    assert!((0.85 * 7.6..=1.1 * 9.2).contains(&last), "{last} at 8");
}

#[test]
#[ignore = "not met: exponent 1.38 with 10 cells across each column and 1.26 with 20, of 1 ± 0.25: the tip of the foot, a few cells \
            thin, is missing, and of a low column it is a larger part (run-out at a = 0.5: 0.40, 0.54, 0.68 with 10, 20, 40 cells)"]
fn low_columns_on_one_grid_run_out_with_their_aspect_ratio() {
    let low = exponent(&runouts(&[(0.5, 10), (1.0, 10), (2.0, 10)]));
    assert!((low - 1.0).abs() < 0.25, "{low}");
}

#[test]
fn cohesion_keeps_a_column_standing() {
    // A vertical cut of c = 1 kPa stands up to 4 c tan(45° + φ/2) / ρ g = 0.44 m; this one has 0.2 m.
    let wet = collapse(2.0, 10, sand(30.0, 1000.0));
    assert!(wet.runout < 0.1, "{}", wet.runout);
    let top = wet.places.iter().map(|p| p[2]).fold(0.0, f64::max);
    assert!(top > 0.19, "{top}");
}

#[test]
fn sand_thrown_up_comes_down_with_its_volume() {
    // A block is thrown apart by a velocity field that opens it, falls back into a box, and fills about what it filled before.
    let dx = 0.02;
    let mut block = body("sand", sand(30.0, 0.0), cuboid([0.2, dx, 0.1]), [0.1, 0.5 * dx, 0.05], 0.5 * dx);
    block.velocity = cosplat_core::scene::VelocityField::LinearMap {
        linear_m_s: [0.0, 0.0, 1.5],
        gradient_1_s: [[0.0; 3], [0.0; 3], [0.0, 0.0, 15.0]],
        about_m: [0.1, 0.5 * dx, 0.05],
    };
    let mut start = scene(vec![block], 0.01);
    start.statics = tank([0.2, dx], Wall::Slip);
    start.actions = vec![gravity(-9.81)];
    let mut run = Run::<f32>::new(start);
    let total = |e: &cosplat_core::plugin::Energy| e.kinetic_j + e.potential_j;
    let first = total(&run.setup.report.energy);
    let (mut highest, mut last) = (0.0_f64, 0.0);
    for _ in 0..150 {
        let report = run.step().report;
        last = report.bodies[0].position_m[2];
        highest = highest.max(last);
        assert!(total(&report.energy) <= first * (1.0 + 1e-3), "{} of {first}", total(&report.energy));
    }
    println!("centre at 0.05 m, {highest} m at most, {last} m at the end");
    // Layers that came apart further than the kernel reaches close again with up to e^0.4 of their volume.
    assert!(highest > 0.1 && (0.95..1.49).contains(&(last / 0.05)), "{last}");
}

/// A bed of sand 0.2 m wide and 0.1 m deep between slip walls, three cells thick, on which that rock falls; returns the
/// places of the particles and the height of the rock's middle after 1 s.
fn pressed(shape: &Source, mass: f64, half_height: f64) -> (Vec<[f64; 3]>, f64) {
    let (dx, window) = (0.01, 5e-3);
    let wide = 3.0 * dx;
    let bed = body("sand", sand(30.0, 0.0), cuboid([0.2, wide, 0.1]), [0.1, 0.5 * wide, 0.05], 0.5 * dx);
    let mut start = scene(vec![bed], window);
    start.statics = tank([0.2, wide], Wall::Slip);
    start.actions = vec![gravity(-9.81)];
    with_rock(&mut start, "sand", shape, 0.5);
    let mut rock = Rock::new(mass, 1e6, [0.1, 0.5 * wide, 0.101 + half_height], [0.0, 0.0, -1.0], [0.0, 0.0, -9.81]);
    let mut run = Run::<f32>::new(start);
    for _ in 0..200 {
        let out = run.step_with(&rock.inputs(window));
        rock.take(&out, window);
    }
    (run.particles("sand"), rock.record.position[2])
}

#[test]
fn sand_keeps_its_volume_under_a_piston() {
    // 4 kg on 0.2 m by 0.03 m: confined, the bed shortens by its pressure and half its own weight over the modulus.
    let (mass, modulus) = (4.0, 3e5 * 0.8 / (1.2 * 0.6));
    let (_, z) = pressed(&cuboid([0.2, 0.03, 0.04]), mass, 0.02);
    let pressure = mass * 9.81 / 0.006 + 0.5 * 1600.0 * 9.81 * 0.1;
    let (depth, wanted) = (z - 0.02, 0.1 * (-pressure / modulus).exp());
    println!("bed {depth} m, {wanted} m wanted");
    // The blow loosened it: grains that came apart bear load again when the grid shows their room to a tenth.
    assert!((depth / wanted - 1.0).abs() < 0.03, "{depth} instead of {wanted}");
}

#[test]
fn sand_keeps_its_volume_under_a_rock() {
    let (places, z) = pressed(&Source::Sphere { radius_m: 0.04 }, 1.0, 0.04);
    let mean = places.iter().map(|p| p[2]).sum::<f64>() / places.len() as f64;
    // Without loss: half the depth, less a third of its own weight over the modulus, and the segment of the rock's circle
    // that is below the surface raised from half its depth to the top.
    let (deep, top) = (0.14 - z, 0.1);
    let area = 2.0 / 3.0 * 2.0 * (2.0 * 0.04 * deep - deep * deep).sqrt() * deep;
    let wanted = 0.05 - 1600.0 * 9.81 * top * top / (3.0 * 3.33e5) + area * 0.5 * deep / (0.2 * top);
    println!("middle of the sand at {mean} m, {wanted} m wanted; the rock {deep} m deep");
    // Flow may leave sand denser by a tenth before the grid tells (`law::Room`); the ring of it below the rock is.
    assert!((mean / wanted - 1.0).abs() < 0.025, "{mean} instead of {wanted}");
}
