//! The solver passes what every plugin must pass, in each part it can play.

#[cfg(test)]
mod common;

use std::sync::Arc;

use common::{Float, liquid, meets, scene, tank, water};
use cosplat_conformance::{Case, assert_conforms};
use cosplat_core::asset::{Asset, ParticleCloud, TriangleMesh};
use cosplat_core::boundary::{BoundaryState, SampleStatics};
use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{Inputs, PartnerInput, PartnerSetup, SolverScene};
use cosplat_core::scene::{Body, Material, MotionRule, Pose, Source, Wall};
use cosplat_sph::Sph;

fn basin() -> SolverScene {
    let mud = Material::SphLiquid {
        density_kg_m3: 1400.0,
        stiffness_pa: 6e4,
        viscosity_pa_s: 10.0,
        surface_tension_n_m: 0.0,
    };
    let pool = liquid(water(15.0, 1e-3), [0.2, 0.2, 0.08], [0.1, 0.1, 0.04], 0.02);
    let drop = Body {
        name: "drop".into(),
        source: Source::Sphere { radius_m: 0.05 },
        pose: Pose { position_m: [0.1, 0.1, 0.15], orientation: common::UPRIGHT },
        ..liquid(mud, [1.0; 3], [0.0; 3], 0.02)
    };
    let mut basin = scene(vec![pool, drop], tank(0.2, 0.2, Wall::NoSlip), 4e-3);
    basin.threads = 1;
    basin
}

fn rigid() -> Case {
    let mut scene = basin();
    let size = [0.06, 0.06, 0.04];
    scene.interfaces.push(meets("raft", BoundaryForm::Proxy, Some(Source::Box { size_m: size }), 0.5));
    let windows = (0..4).map(|w| Float::new(0.1, size, [0.1, 0.09, 0.098 - 0.002 * f64::from(w)]).inputs(4e-3));
    let partner = PartnerSetup { interface: 0, statics: SampleStatics::default() };
    Case { name: "rigid partner".into(), ..Case::new("", scene).hearing(vec![partner], windows.collect()) }
}

/// The same with a liquid that keeps its volume.
fn kept() -> Case {
    let case = rigid();
    Case { name: "incompressible".into(), scene: common::incompressible(case.scene.clone()), ..case }
}

/// The same raft as twelve triangles, and the drop as prepared particles.
fn prepared() -> Case {
    let case = rigid();
    let mut scene = case.scene.clone();
    let half = [0.03, 0.03, 0.02];
    let corner = |i: usize| [0, 1, 2].map(|k| if i >> k & 1 == 1 { half[k] } else { -half[k] });
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mesh = TriangleMesh {
        vertices_m: (0..8).map(corner).collect(),
        triangles: quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
    };
    let position_m: Vec<_> = (0..27).map(|i| [i % 3, i / 3 % 3, i / 9].map(|i| 0.02 * f64::from(i - 1))).collect();
    let cloud = ParticleCloud { spacing_m: 0.02, volume_m3: vec![8e-6; 27], position_m };
    let file = |file: &str| Source::Mesh { file: file.into(), metres_per_unit: 1.0, up: "+z".into() };
    scene.assets.insert("raft".into(), Arc::new(Asset::Mesh(mesh)));
    scene.assets.insert("drop".into(), Arc::new(Asset::Particles(cloud)));
    scene.interfaces[0].partner_source = Some(file("raft.obj"));
    scene.bodies[1].source = file("drop.obj");
    Case { name: "prepared geometry".into(), scene, ..case }
}

fn sampled() -> Case {
    let mut scene = basin();
    scene.interfaces.push(meets("jelly", BoundaryForm::SamplesF64 { normals: false }, None, 0.5));
    let at = |w: f64| {
        let grid =
            (0..25).map(move |i| [0.06 + 0.02 * f64::from(i % 5), 0.06 + 0.02 * f64::from(i / 5), 0.1 - 0.001 * w]);
        BoundaryState::points(&grid.collect::<Vec<_>>(), &[[0.0, 0.1, -0.25]; 25])
    };
    let windows = (0..4).map(|w| {
        let (now, rule) = (at(f64::from(w)), MotionRule::Linear);
        let partner = PartnerInput { interface: 0, rule, now, next: None, length_s: 4e-3 };
        Inputs { partners: vec![partner], impulses: Vec::new() }
    });
    let statics =
        SampleStatics { area_m2: vec![4e-4; 25], volume_m3: vec![8e-6; 25], ..SampleStatics::equal(25, 0.01) };
    Case::new("sampled partner", scene).hearing(vec![PartnerSetup { interface: 0, statics }], windows.collect())
}

#[test]
fn the_solver_conforms() {
    assert_conforms(
        &|| Box::new(Sph::default()),
        &[Case::new("liquids", basin()), rigid(), kept(), prepared(), sampled()],
    );
}
