//! Energy books: what a material has and what it lost together never grow without work.

use crate::common::{Run, UPRIGHT, body, cuboid, elastic, gravity, moving, plane, scene, tank};
use cosplat_core::plugin::SolverScene;
use cosplat_core::scene::{Body, Material, SNOW, Source, Wall};

/// A body on or above a rough floor.
fn on_floor(body: Body, window_s: f64) -> SolverScene {
    let mut start = scene(vec![body], window_s);
    let rough = Wall::Friction { static_friction: 0.7, kinetic_friction: 0.6 };
    start.statics = vec![plane("floor", [0.0; 3], UPRIGHT, rough)];
    start.actions = vec![gravity(-9.81)];
    start
}

/// Largest rise of energy and what was lost above those of the start, over the energy of the start; walls and gravity, which
/// has a potential, do no work. Also the least of what was lost, over the same.
fn rises(name: &str, start: SolverScene, windows: u32) -> [f64; 2] {
    let mut run = Run::<f32>::new(start);
    let energy = run.setup.report.energy;
    let first = energy.kinetic_j + energy.potential_j;
    let (mut rise, mut lost, mut last) = (f64::NEG_INFINITY, 0.0_f64, first);
    for _ in 0..windows {
        let energy = run.step().report.energy;
        last = energy.kinetic_j + energy.potential_j + energy.dissipated_j;
        rise = rise.max(last - first);
        lost = lost.min(energy.dissipated_j);
    }
    println!(
        "{name}: rises by {:.1e}, {:.1e} lost at least, {:.3} at the end",
        rise / first,
        lost / first,
        last / first
    );
    [rise / first, lost / first]
}

fn sand(cohesion_pa: f64) -> Material {
    Material::Granular {
        density_kg_m3: 1600.0,
        youngs_modulus_pa: 4e5,
        poissons_ratio: 0.2,
        friction_angle_deg: 34.0,
        cohesion_pa,
    }
}

/// Published aim of the project: 1e-3 of the energy at the start.
const MOST: f64 = 1e-3;

#[test]
fn sand_gains_nothing_when_it_is_let_go() {
    // On the nodes of the grid and between them, moist and dry.
    let tower = Source::Cylinder { radius_m: 0.05, height_m: 0.16 };
    for (name, cohesion, above) in [("moist", 700.0, 0.0), ("between nodes", 700.0, 0.006), ("dry", 0.0, 0.0)] {
        let tower = body("tower", sand(cohesion), tower.clone(), [0.0, 0.0, 0.08 + above], 0.01);
        let mut start = on_floor(tower, 0.004);
        start.statics[0].pose.position_m[2] = above;
        let [rise, lost] = rises(name, start, 40);
        assert!(rise <= MOST && lost >= 0.0, "{name}: {rise}, {lost}");
    }
}

#[test]
fn solids_that_flow_gain_nothing() {
    let (density_kg_m3, poissons_ratio) = (200.0, 0.3);
    let clay = Material::Elastoplastic { density_kg_m3, youngs_modulus_pa: 1e5, poissons_ratio, yield_stress_pa: 1e3 };
    let foam = Material::Viscoplastic {
        density_kg_m3,
        youngs_modulus_pa: 1e5,
        poissons_ratio,
        yield_stress_pa: 300.0,
        hardening_pa: 0.0,
        consistency_pa_sn: 50.0,
        flow_index: 0.5,
    };
    let [critical_compression, critical_stretch, hardening] = SNOW;
    let snow = Material::Snow {
        density_kg_m3,
        youngs_modulus_pa: 1.4e5,
        poissons_ratio: 0.2,
        critical_compression,
        critical_stretch,
        hardening,
    };
    for (name, material) in [("clay", clay), ("foam", foam), ("snow", snow), ("rubber", elastic(200.0, 1e5, 0.3))] {
        let cube = body("cube", material, cuboid([0.1; 3]), [0.0, 0.0, 0.06], 0.0125);
        let [rise, _] = rises(name, on_floor(moving(cube, [0.5, 0.0, -3.0], [0.0, 2.0, 0.0]), 0.002), 100);
        assert!(rise <= MOST, "{name}: {rise}");
    }
}

#[test]
fn a_liquid_gains_nothing() {
    let material = Material::MpmLiquid { density_kg_m3: 1000.0, bulk_modulus_pa: 4e4, viscosity_pa_s: 0.0 };
    let water = body("water", material, cuboid([0.2, 0.05, 0.2]), [0.1, 0.025, 0.1], 0.0125);
    let mut start = scene(vec![water], 0.01);
    start.statics = tank([0.5, 0.05], Wall::Slip);
    start.actions = vec![gravity(-9.81)];
    let [rise, lost] = rises("water", start, 200);
    assert!(rise <= MOST, "{rise}");
    // What brings its volume back to what the grid shows is taken from the motion: nothing is ever given back.
    // Roundings of the walls' books aside.
    assert!(lost >= -1e-12, "{lost}");
}
