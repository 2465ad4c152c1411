//! The solver passes what every plugin must pass, in each part it can play.

mod common;

use common::{cloth, floor, pair, record};
use cosplat_conformance::{Case, assert_conforms, parts};
use cosplat_core::boundary::{BoundaryState, Impulses, SampleStatics, Samples};
use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{Inputs, PartnerInput, PartnerSetup, Plugin, SolverScene, ViewRole};
use cosplat_core::scene::{MotionRule, Source, Wall};
use cosplat_pbd::Pbd;

fn make() -> Box<dyn Plugin> {
    Box::new(Pbd::default())
}

/// A pinned flag and a cloth that lands on a rough floor, with gravity, wind and damping.
fn cloths() -> SolverScene {
    let mut flag =
        parts::body("flag", cloth(1e-6, 1e-3), Source::Plane { size_m: Some([0.3, 0.2]) }, [0.0, 0.0, 0.204]);
    let mut rug = parts::body("rug", cloth(1e-5, 1e-2), Source::Plane { size_m: Some([0.4, 0.4]) }, [0.0, 0.0, 0.002]);
    (flag.spacing_m, rug.spacing_m) = (Some(0.02), Some(0.02));
    rug.velocity = parts::twist([0.3, 0.0, -1.0], [0.0, 0.0, 0.5]);
    let mut scene = parts::solver_scene("pbd", vec![flag, rug], 4, 0.002);
    scene.statics = vec![floor(Wall::Friction { static_friction: 0.5, kinetic_friction: 0.4 })];
    let wind = cosplat_core::scene::ActionKind::Wind {
        velocity_m_s: [2.0, 1.0, 3.0],
        air_density_kg_m3: 1.2,
        drag_coefficient: 1.1,
    };
    scene.actions = vec![parts::gravity(), parts::action(wind, 0.001, Some(0.0055))];
    scene.params.insert("damping_1_s".into(), 0.5.into());
    scene.params.insert("pins".into(), serde_json::json!({ "flag": [[-0.15, 0.1, 0.204], [0.15, 0.1, 0.204]] }));
    scene
}

/// Impulses on the vertices of both.
fn responder() -> Case {
    let mut scene = cloths();
    scene.interfaces = ["flag", "rug"]
        .iter()
        .zip(3..)
        .map(|(own, id)| {
            let mut view = parts::view(id, ViewRole::ContactResponder, own, "mud", Vec::new());
            view.pair = Some(pair(own, "mud", 0.3));
            view
        })
        .collect();
    let setup = Pbd::default().setup(&scene).expect("a scene it takes");
    let counts: Vec<usize> = setup.boundaries.iter().map(|b| b.statics.len()).collect();
    let windows = (0..4).map(|w| {
        let each = |n: usize| (0..n).map(|i| [1e-5 * f64::from(w), 1e-7 * i as f64, -2e-5]).collect();
        let impulses = counts.iter().zip(3..).map(|(&n, id)| {
            let mut input = parts::spread(id, Impulses::Samples(each(n)));
            input.spread = id == 3;
            input
        });
        Inputs { partners: Vec::new(), impulses: impulses.collect() }
    });
    Case::new("responder", scene).hearing(Vec::new(), windows.collect())
}

/// A rigid ball between the two that both meet, and a hill of samples under the rug.
fn resolver() -> Case {
    let mut scene = cloths();
    scene.statics.clear();
    let mut flag = parts::view(1, ViewRole::ContactResolver, "flag", "ball", Vec::new());
    let mut rug = parts::view(2, ViewRole::ContactResolver, "rug", "ball", Vec::new());
    for view in [&mut flag, &mut rug] {
        view.partner_form = BoundaryForm::Proxy;
        view.partner_source = Some(Source::Sphere { radius_m: 0.1015 });
        view.pair = Some(pair("flag", "ball", 0.3));
    }
    let mut hill = parts::view(7, ViewRole::ContactResolver, "rug", "hill", Vec::new());
    hill.partner_form = BoundaryForm::SamplesF32 { normals: true };
    hill.pair = Some(pair("rug", "hill", 0.6));
    scene.interfaces = vec![flag, rug, hill];
    let length_s = scene.clock.window_s();
    let places: Vec<[f64; 3]> =
        (0..400).map(|i| [0.02 * f64::from(i % 20) - 0.2, 0.02 * f64::from(i / 20) - 0.2, -0.012]).collect();
    let windows = (0..4).map(|w| {
        let mut ball = record([0.05, 0.0, 0.103], [0.1, 0.0, if w % 2 == 0 { 0.5 } else { -3.0 }], 0.4, 1.6e-3);
        ball.angular_velocity = [0.0, 3.0, 0.0];
        let input = |interface, now| PartnerInput { interface, rule: MotionRule::Linear, now, next: None, length_s };
        let samples = Samples {
            position: places.clone(),
            velocity: vec![[0.0, 0.0, 0.5]; 400],
            normal: vec![[0.0, 0.0, 1.0]; 400],
        };
        let proxies = [1, 2].map(|id| input(id, BoundaryState::Proxy(ball)));
        let partners = proxies.into_iter().chain([input(7, BoundaryState::Samples(samples))]).collect();
        Inputs { partners, impulses: Vec::new() }
    });
    let partner = |interface, statics| PartnerSetup { interface, statics };
    let statics =
        SampleStatics { area_m2: vec![4e-4; 400], volume_m3: vec![8e-6; 400], ..SampleStatics::equal(400, 4e-3) };
    let partners =
        vec![partner(1, SampleStatics::default()), partner(2, SampleStatics::default()), partner(7, statics)];
    Case::new("resolver", scene).hearing(partners, windows.collect())
}

#[test]
fn it_conforms() {
    assert_conforms(&make, &[Case::new("cloths", cloths()), responder(), resolver()]);
}

#[test]
fn the_partners_of_the_cases_are_really_met() {
    let case = resolver();
    let mut plugin = Pbd::default();
    plugin.setup(&case.scene).expect("a scene it takes");
    plugin.connect(&case.partners).expect("partners it takes");
    let mut met = [false; 3];
    for (window, inputs) in (0..).zip(&case.windows) {
        let step = parts::step(&case.scene.clock, window);
        let out = plugin.advance(&step, inputs, &mut cosplat_core::plugin::Steady).expect("a step");
        for (met, (_, given)) in met.iter_mut().zip(&out.impulses) {
            *met |= given.gross() > 0.0;
        }
    }
    assert_eq!(met, [true; 3]);
}
