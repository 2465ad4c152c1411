//! The solver passes what every plugin must pass, in each part it can play and in both precisions.

use cosplat_conformance::{Case, assert_conforms, parts};
use cosplat_core::boundary::{BoundaryState, Impulses, ProxyRecord, SampleStatics};
use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{Inputs, PartnerInput, PartnerSetup, Plugin, SolverScene, ViewRole};
use cosplat_core::scene::{ContactLaw, Material, MotionRule, PairSpec, Pose, Source, StaticCollider, Wall};
use cosplat_mpm::{Mpm, Real};

/// Sums of some thousand particles over tens of substeps: the gates of the two precisions.
fn gate<R: Real>() -> f64 {
    if size_of::<R>() == 8 { 1e-12 } else { 1e-6 }
}

fn make<R: Real>() -> Box<dyn Plugin> {
    Box::new(Mpm::<R>::default())
}

/// An elastic box and a plastic ball that meet on a rough floor, with gravity and a push.
fn solids() -> SolverScene {
    let can = Material::Elastoplastic {
        density_kg_m3: 300.0,
        youngs_modulus_pa: 2e5,
        poissons_ratio: 0.22,
        yield_stress_pa: 2e3,
    };
    let soft =
        Material::Elastic { density_kg_m3: 500.0, youngs_modulus_pa: 1e5, poissons_ratio: 0.3, viscosity_pa_s: 0.0 };
    let mut block = parts::body("block", soft, Source::Box { size_m: [0.2, 0.2, 0.1] }, [0.0, 0.0, 0.05]);
    let mut ball = parts::body("ball", can, Source::Sphere { radius_m: 0.06 }, [0.02, 0.01, 0.17]);
    (block.spacing_m, ball.spacing_m) = (Some(0.02), Some(0.02));
    ball.velocity = parts::twist([0.3, 0.0, -2.0], [1.0, 0.0, 0.0]);
    let mut scene = parts::solver_scene("mpm", vec![block, ball], 4, 0.004);
    scene.statics = vec![StaticCollider {
        name: "floor".into(),
        source: Source::Plane { size_m: None },
        pose: Pose { position_m: [0.0; 3], orientation: [0.0, 0.0, 0.0, 1.0] },
        wall: Wall::Friction { static_friction: 0.5, kinetic_friction: 0.4 },
        motion: None,
        color: None,
    }];
    scene.actions = vec![parts::gravity()];
    scene
}

/// Sand, snow and a liquid that fall into each other on a floor.
fn flowing() -> SolverScene {
    let mut scene = solids();
    let sand = Material::Granular {
        density_kg_m3: 1600.0,
        youngs_modulus_pa: 2e5,
        poissons_ratio: 0.2,
        friction_angle_deg: 30.0,
        cohesion_pa: 100.0,
    };
    let snow = Material::Snow {
        density_kg_m3: 400.0,
        youngs_modulus_pa: 1.4e5,
        poissons_ratio: 0.2,
        critical_compression: 2.5e-2,
        critical_stretch: 7.5e-3,
        hardening: 10.0,
    };
    let oil = Material::MpmLiquid { density_kg_m3: 900.0, bulk_modulus_pa: 5e4, viscosity_pa_s: 2.0 };
    let floor = |x: f64| [x, 0.0, 0.06];
    let size = Source::Box { size_m: [0.12, 0.12, 0.12] };
    scene.bodies = vec![
        parts::body("sand", sand, size.clone(), floor(0.0)),
        parts::body("oil", oil, size, floor(0.13)),
        parts::body("snow", snow, Source::Sphere { radius_m: 0.05 }, [0.05, 0.0, 0.18]),
    ];
    for body in &mut scene.bodies {
        body.spacing_m = Some(0.02);
    }
    scene.bodies[2].velocity = parts::twist([0.0, 0.0, -3.0], [0.0; 3]);
    scene
}

fn pair(own: &str, partner: &str) -> PairSpec {
    PairSpec {
        a: own.into(),
        b: partner.into(),
        static_friction: 0.3,
        kinetic_friction: 0.3,
        restitution: 0.0,
        softness_m: 0.002,
        contact: ContactLaw::Physical,
        resolver: None,
        enabled: true,
    }
}

/// Impulses on the samples of the block.
fn responder<R: Real>() -> Case {
    let mut scene = solids();
    scene.interfaces = vec![parts::view(3, ViewRole::ContactResponder, "block", "mud", Vec::new())];
    scene.interfaces[0].pair = Some(pair("block", "mud"));
    let samples = Mpm::<R>::default().setup(&scene).expect("a scene it takes").boundaries[0].statics.len();
    let windows = (0..4).map(|w| {
        let each = (0..samples).map(|i| [1e-4 * f64::from(w), 1e-5 * i as f64, -2e-4]).collect();
        Inputs { partners: Vec::new(), impulses: vec![parts::spread(3, Impulses::Samples(each))] }
    });
    Case { closure_gate: gate::<R>(), ..Case::new("responder", scene).hearing(Vec::new(), windows.collect()) }
}

/// A rigid ball that lands on the block.
fn resolver<R: Real>() -> Case {
    let mut scene = solids();
    scene.interfaces = vec![parts::view(2, ViewRole::ContactResolver, "block", "rock", Vec::new())];
    scene.interfaces[0].pair = Some(pair("block", "rock"));
    scene.interfaces[0].partner_form = BoundaryForm::Proxy;
    scene.interfaces[0].partner_source = Some(Source::Sphere { radius_m: 0.05 });
    let length_s = scene.clock.window_s();
    let windows = (0..4).map(|w| {
        let record = ProxyRecord {
            position: [-0.05, 0.0, 0.14 - 0.004 * f64::from(w)],
            orientation: [0.0, 0.0, 0.0, 1.0],
            linear_velocity: [0.1, 0.0, -1.0],
            angular_velocity: [0.0, 2.0, 0.0],
            mass: 0.5,
            inertia: [5e-4, 5e-4, 5e-4, 0.0, 0.0, 0.0],
            share: 1.0,
            background_linear: [0.0, 0.0, -9.81],
            background_angular: [0.0; 3],
        };
        let now = BoundaryState::Proxy(record);
        let partner = PartnerInput { interface: 2, rule: MotionRule::Linear, now, next: None, length_s };
        Inputs { partners: vec![partner], impulses: Vec::new() }
    });
    let partner = PartnerSetup { interface: 2, statics: SampleStatics::default() };
    Case { closure_gate: gate::<R>(), ..Case::new("resolver", scene).hearing(vec![partner], windows.collect()) }
}

/// A soft layer of another process into which the ball falls.
fn resolver_of_samples<R: Real>() -> Case {
    let mut scene = solids();
    scene.interfaces = vec![parts::view(5, ViewRole::ContactResolver, "ball", "layer", Vec::new())];
    scene.interfaces[0].pair = Some(pair("ball", "layer"));
    scene.interfaces[0].partner_form = BoundaryForm::SamplesF64 { normals: false };
    let length_s = scene.clock.window_s();
    let places = |height: f64| -> Vec<[f64; 3]> {
        (0..81).map(|i| [0.02 * f64::from(i / 9) - 0.06, 0.02 * f64::from(i % 9) - 0.08, height]).collect()
    };
    let windows = (0..4).map(|w| {
        let now = BoundaryState::points(&places(0.1 + 0.002 * f64::from(w)), &vec![[0.1, 0.0, 2.0]; 81]);
        let partner = PartnerInput { interface: 5, rule: MotionRule::Hold, now, next: None, length_s };
        Inputs { partners: vec![partner], impulses: Vec::new() }
    });
    let statics = SampleStatics { volume_m3: vec![8e-6; 81], ..SampleStatics::equal(81, 8e-3) };
    let partner = PartnerSetup { interface: 5, statics };
    let case = Case::new("resolver of samples", scene).hearing(vec![partner], windows.collect());
    Case { closure_gate: gate::<R>(), ..case }
}

fn conforms<R: Real>() {
    let solids = Case { closure_gate: gate::<R>(), ..Case::new("solids", solids()) };
    let flowing = Case { closure_gate: gate::<R>(), ..Case::new("flowing", flowing()) };
    assert_conforms(&make::<R>, &[solids, flowing, responder::<R>(), resolver::<R>(), resolver_of_samples::<R>()]);
}

#[test]
fn single_precision_conforms() {
    conforms::<f32>();
}

#[test]
fn double_precision_conforms() {
    conforms::<f64>();
}
