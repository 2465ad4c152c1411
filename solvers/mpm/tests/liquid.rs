//! Liquid against closed forms: at rest under gravity, between plates, and falling apart.

use crate::common::{Run, TO_MINUS_Y, TO_Y, UPRIGHT, body, cuboid, gravity, plane, scene, set, tank};
use cosplat_core::plugin::SolverScene;
use cosplat_core::scene::{Action, ActionKind, Material, Wall};

fn liquid(bulk_modulus_pa: f64, viscosity_pa_s: f64) -> Material {
    Material::MpmLiquid { density_kg_m3: 1000.0, bulk_modulus_pa, viscosity_pa_s }
}

/// A column of the height 1 m, three cells wide, between slip walls.
fn column(cells: usize, bulk: f64) -> SolverScene {
    let dx = 1.0 / cells as f64;
    let (wide, spacing) = (3.0 * dx, 0.5 * dx);
    let water = body("water", liquid(bulk, 20.0), cuboid([wide, wide, 1.0]), [0.5 * wide, 0.5 * wide, 0.5], spacing);
    let mut scene = scene(vec![water], 0.01);
    scene.statics = tank([wide, wide], Wall::Slip);
    scene
}

/// How far the centre of mass sinks: `p = ρ0 g (H - X)` at the material height X, `J = (1 + 7 p / K)^(-1/7)`.
fn sinks_exactly(bulk: f64) -> f64 {
    let n = 10_000;
    let (mut place, mut mean) = (0.0, 0.0);
    for i in 0..n {
        let depth = 1.0 - (f64::from(i) + 0.5) / f64::from(n);
        let volume = (1.0 + 7.0 * 1000.0 * 9.81 * depth / bulk).powf(-1.0 / 7.0) / f64::from(n);
        mean += (place + 0.5 * volume) / f64::from(n);
        place += volume;
    }
    0.5 - mean
}

/// Pressures of particles by their identities, from a saved state \[Pa\]: blocks, identities and 27 numbers of four particles
/// at a time, of which the 18th is `J^(2/3) - 1`.
fn pressures(bytes: &[u8], count: usize, bulk: f64) -> Vec<f64> {
    let number = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"));
    let blocks = number(0) as usize;
    let quads: usize = (0..blocks).map(|b| number(8 + 20 * b + 16).div_ceil(4) as usize).sum();
    let identities = 8 + 20 * blocks;
    let mut all = vec![f64::NAN; count];
    for slot in 0..4 * quads {
        if let Some(p) = all.get_mut(number(identities + 4 * slot) as usize) {
            let at = identities + 16 * quads + 4 * (slot / 4 * 27 * 4 + 18 * 4 + slot % 4);
            let volume = (1.0 + f64::from(f32::from_bits(number(at)))).powf(1.5);
            *p = bulk / 7.0 * (volume.powi(-7) - 1.0);
        }
    }
    all
}

/// A column at rest.
struct Rest {
    /// How far its centre of mass sank, over what it should.
    sinks: f64,
    /// Kinetic energy over the weight times the height.
    kinetic: f64,
    /// Errors of the pressure over that at the foot: of each particle, and of the mean over each layer of them and each
    /// layer of cells, from below.
    errors: [Vec<f64>; 3],
    /// Pressure at the foot by the line through the lower half of the cells but the lowest, over what it should be.
    foot: f64,
}

/// Square mean.
fn rms(all: &[f64]) -> f64 {
    (all.iter().map(|e| e * e).sum::<f64>() / all.len() as f64).sqrt()
}

fn at_rest(cells: usize) -> Rest {
    // c = √(K/ρ) = 10 m/s: pressure at the foot is a tenth of K, strong enough to tell the exponent 7 from others.
    let bulk = 1e5;
    let mut start = column(cells, bulk);
    // Gravity in 50 equal steps over 5 s, so that the swing (period 0.4 s) stays small; viscosity takes the rest.
    start.actions = (0..50).map(|i| Action { from_s: 0.1 * f64::from(i), ..gravity(-0.1962) }).collect();
    let mut run = Run::<f32>::new(start);
    let (rest, places) = (run.setup.report.bodies[0].position_m[2], run.particles("water"));
    let (mut mean, mut kinetic) = (0.0, 0.0);
    for window in 0..700 {
        let report = run.step().report;
        if window >= 600 {
            mean += report.bodies[0].position_m[2] / 100.0;
        }
        kinetic = report.energy.kinetic_j / (9.81 * report.bodies[0].mass_kg);
    }
    // The weight above a particle is that of the start, and its layer too.
    let weight = 9810.0;
    let found = pressures(&run.bytes(), places.len(), bulk);
    let single: Vec<f64> = found.iter().zip(&places).map(|(p, x)| p / weight - (1.0 - x[2])).collect();
    let layers = |n: usize| {
        let mut sum = vec![(0.0, 0.0); n];
        for (e, x) in single.iter().zip(&places) {
            let (error, count) = &mut sum[(x[2] * n as f64) as usize];
            (*error, *count) = (*error + e, *count + 1.0);
        }
        sum.iter().map(|(e, n)| e / n).collect::<Vec<f64>>()
    };
    let by_cell = layers(cells);
    let line: Vec<[f64; 2]> = (1..cells / 2).map(|k| [(k as f64 + 0.5) / cells as f64, by_cell[k]]).collect();
    let [z, e] = [0, 1].map(|k| line.iter().map(|p| p[k]).sum::<f64>() / line.len() as f64);
    let slope = line.iter().map(|p| (p[0] - z) * (p[1] - e)).sum::<f64>()
        / line.iter().map(|p| (p[0] - z).powi(2)).sum::<f64>();
    let rest = Rest {
        sinks: (rest - mean) / sinks_exactly(bulk),
        kinetic,
        errors: [single.clone(), layers(2 * cells), by_cell],
        foot: 1.0 + e - slope * z,
    };
    println!(
        "{cells} cells, {} substeps: sinks {:.4}, foot {:.4}, lowest {:.4?}, kinetic {:.1e}, square mean error of particles, layers, cells {:.4?}",
        run.substeps,
        rest.sinks,
        rest.foot,
        &rest.errors[2][..3],
        rest.kinetic,
        [0, 1, 2].map(|k| rms(&rest.errors[k])),
    );
    rest
}

#[test]
fn a_column_at_rest_sinks_and_presses_as_its_state_equation_says() {
    let Rest { sinks, kinetic, errors: [_, _, cells], foot } = at_rest(24);
    // An explicit code of the same kind, of first order in the cells, is off by 4.8, 2.3 and 1.1 % at 10, 20 and 40 of them
    // in an elastic column.
    assert!((sinks - 1.0).abs() < 0.03, "{sinks}");
    // The catalogue's gates for hydrostatics: 1e-5 of kinetic energy, 2 % of pressure in the square mean and 1 % at the foot, for
    // the mean over each layer of cells, and for the line that all of them but the lowest give there.
    assert!(kinetic < 1e-5 && rms(&cells) < 0.02 && (foot - 1.0).abs() < 0.01, "{kinetic} {} {foot}", rms(&cells));
    // The kernel of the first nodes above the floor reaches behind it, where nothing presses back: the cell on the floor has
    // 8 % too much at 12, 24 and 48 cells. All others have the gate's 2 % one by one.
    assert!(cells[0] < 0.1 && cells[1..].iter().all(|e| e.abs() < 0.02), "{cells:?}");
}

#[test]
#[ignore = "not met: square mean error 7.0 % by particle, 3.1 % by half a cell (4.8 % at 12 cells, 2.1 % at 48), 8 % too much in the \
            cell on the floor at any resolution: kernels of nodes are cut there, and single particles scatter about their layer"]
fn each_particle_of_a_column_at_rest_has_the_pressure_of_its_depth() {
    let Rest { errors: [single, layers, cells], .. } = at_rest(24);
    assert!(rms(&single) < 0.02 && rms(&layers) < 0.02 && cells[0].abs() < 0.01, "{} {}", rms(&single), rms(&layers));
}

/// Speed in the middle of the start-up flow between no-slip plates H apart under an acceleration g along them:
/// `u = g H²/8ν (1 - 32/π³ Σ (-1)^k exp(-(2k+1)² π² ν t / H²) / (2k+1)³)`.
fn in_the_middle(g: f64, nu: f64, h: f64, t: f64) -> f64 {
    let pi = std::f64::consts::PI;
    let terms = (0..20).map(|k| {
        let n = f64::from(2 * k + 1);
        let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
        sign * (-n * n * pi * pi * nu * t / (h * h)).exp() / (n * n * n)
    });
    g * h * h / (8.0 * nu) * (1.0 - 32.0 / pi.powi(3) * terms.sum::<f64>())
}

/// Speed of the middle at `t`, with substeps of at most `most`, and the substeps taken.
fn between_plates(viscosity: f64, most: f64, t: f64) -> (f64, u64) {
    let (h, length, cells) = (0.1, 0.4, 10);
    let dx = h / f64::from(cells);
    let source = cuboid([length, dx, h]);
    let mud = body("mud", liquid(2.5e4, viscosity), source, [0.0, 0.5 * dx, 0.5 * h], 0.5 * dx);
    let mut start = scene(vec![mud], 0.01);
    set(&mut start, "max_substep_s", most);
    start.statics = vec![
        plane("below", [0.0; 3], UPRIGHT, Wall::NoSlip),
        plane("above", [0.0, 0.0, h], [1.0, 0.0, 0.0, 0.0], Wall::NoSlip),
        plane("front", [0.0; 3], TO_Y, Wall::Slip),
        plane("back", [0.0, dx, 0.0], TO_MINUS_Y, Wall::Slip),
    ];
    let kind = ActionKind::Gravity { acceleration_m_s2: [0.5, 0.0, 0.0] };
    start.actions = vec![Action { kind, bodies: Vec::new(), from_s: 0.0, until_s: None }];
    let mut run = Run::<f32>::new(start);
    let chosen = |p: &[f64; 3]| p[0].abs() < 0.1 && (p[2] - 0.5 * h).abs() < 0.6 * dx;
    let mut before = Vec::new();
    let windows = (t / 0.01).round() as u64;
    for window in 0..windows {
        if window + 1 == windows {
            before = run.particles("mud");
        }
        run.step();
    }
    let after = run.particles("mud");
    let moved: Vec<f64> =
        before.iter().zip(&after).filter(|(p, _)| chosen(p)).map(|(p, q)| (q[0] - p[0]) / 0.01).collect();
    (moved.iter().sum::<f64>() / moved.len() as f64, run.substeps)
}

#[test]
fn flow_between_plates_is_that_of_poiseuille() {
    let (viscosity, h, t) = (10.0, 0.1, 0.2);
    let exact = in_the_middle(0.5, viscosity / 1000.0, h, t - 0.005);
    let (coarse, few) = between_plates(viscosity, 1.0, t);
    let (fine, many) = between_plates(viscosity, 2e-4, t);
    println!("exact {exact}, {coarse} with {few} substeps, {fine} with {many}");
    // Ten cells across: where the wall holds a node, the grid shows (dx/2)² u''/2 less than the flow has, which is
    // (dx/h)² = 1 % of its greatest speed; half as much again for the moving particles.
    assert!((coarse / exact - 1.0).abs() < 0.025, "{coarse} of {exact}");
    // The viscosity knows no substep, and what the transfers lose at the plates hangs on the time: by affine transfers
    // alone the flow would be 6 % slower with four times as many substeps.
    assert!(many > 3 * few && (fine / coarse - 1.0).abs() < 0.015, "{fine} and {coarse}");
}

#[test]
fn a_thousandfold_viscosity_shortens_the_substep_and_stays_bounded() {
    let mut start = column(8, 1e5);
    start.bodies[0].material = liquid(1e5, 2e4);
    start.actions = vec![gravity(-9.81)];
    let mut run = Run::<f32>::new(start);
    let energy = |e: &cosplat_core::plugin::Energy| e.kinetic_j + e.potential_j;
    let first = energy(&run.setup.report.energy);
    for _ in 0..20 {
        let report = run.step().report;
        assert!(report.substep_bound_by.contains("viscosity of `water`"), "{}", report.substep_bound_by);
        assert!(energy(&report.energy) <= first + 1e-3 * first.abs(), "{:?}", report.energy);
    }
}

#[test]
fn a_dam_breaks_without_gaining_energy_and_leaves_no_hole() {
    let water = body("water", liquid(4e4, 0.0), cuboid([0.2, 0.05, 0.2]), [0.1, 0.025, 0.1], 0.0125);
    let mut start = scene(vec![water], 0.01);
    start.statics = tank([0.5, 0.05], Wall::Slip);
    start.actions = vec![gravity(-9.81)];
    let mut run = Run::<f32>::new(start);
    let energy = |e: &cosplat_core::plugin::Energy| e.kinetic_j + e.potential_j;
    let first = energy(&run.setup.report.energy);
    let (mut most, mut last, mut mean) = (f64::NEG_INFINITY, 0.0, 0.0);
    for window in 0..400 {
        let report = run.step().report;
        most = most.max(energy(&report.energy));
        last = report.bodies[0].position_m[2];
        mean += if window >= 280 { last / 120.0 } else { 0.0 };
    }
    // Over the floor of 0.5 m the water stands 0.08 m deep.
    println!("energy {first} J at first, {most} J at most; centre at {last} m, {mean} m in the mean, wanted 0.04 m");
    assert!(most <= first * (1.0 + 1e-3), "{most} of {first}");
    // Compression by its own weight takes 1 %; one spacing of the surface is 15 %.
    assert!((last / 0.04 - 1.0).abs() < 0.15, "{last}");
    // It still swings, by 5 %; the mean over the slowest swing of 0.6 s, twice, is that of its volume.
    assert!((mean / 0.04 - 1.0).abs() < 0.03, "{mean}");
}
