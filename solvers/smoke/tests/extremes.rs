//! Extreme settings: correct, degraded and reported, or refused by name.

#[cfg(test)]
mod common;

use common::{Run, ball, gravity, meets, rigid, scene, shown, wall, wind};
use cosplat_core::boundary::{BoundaryState, Vec3, norm};
use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{Inputs, Outputs, Plugin, PluginError, SolverScene, Steady, Step};
use cosplat_core::scene::{Action, Source};
use cosplat_core::time::Span;
use cosplat_smoke::Smoke;
use serde_json::{Value, json};

/// A ball of warm smoke of 0.2 m in a cube of 16 cells of 5 cm, with parameters beside.
fn cube(actions: Vec<Action>, more: &[(&str, Value)]) -> SolverScene {
    let params = json!({ "low": [-0.4, -0.4, -0.4], "high": [0.4, 0.4, 0.4], "cell": 0.05, "temperature": 330 });
    let mut start = scene(ball(1.204, 0.1, [0.0; 3], 0.025), actions, 0.02, &params);
    for (key, value) in more {
        start.params.insert((*key).into(), value.clone());
    }
    start
}

/// The same by density constraints.
fn cloud(actions: Vec<Action>, more: &[(&str, Value)]) -> SolverScene {
    let mut start = scene(ball(1.0, 0.1, [0.0; 3], 0.025), actions, 0.02, &json!({ "method": "positions" }));
    for (key, value) in more {
        start.params.insert((*key).into(), value.clone());
    }
    start
}

fn down() -> Action {
    gravity([0.0, 0.0, -9.81])
}

/// Roundings over the largest momentum: solids may be a thousand times heavier than the gas on each of some thousand
/// faces.
const ROUNDING: f64 = 1e-11;

/// So many windows: the last answer, with books that close to rounding and numbers that are some.
fn plays(run: &mut Run, windows: u32) -> Outputs {
    let last = (0..windows).map(|_| run.step()).last().expect("a window");
    assert!(run.defect.iter().all(|d| *d <= ROUNDING * run.gross), "{:?} of {}", run.defect, run.gross);
    assert!(run.particles().iter().flatten().all(|x| x.is_finite()));
    last
}

fn speed(out: &Outputs) -> f64 {
    norm(out.report.bodies[0].linear_velocity_m_s)
}

#[test]
fn a_wind_that_can_neither_enter_nor_leave_does_not_blow() {
    let mut run = Run::new(cube(vec![wind([1.0, 0.0, 0.0])], &[("open", json!([]))]));
    let out = plays(&mut run, 3);
    // What the projection leaves: 1e-4 of the largest speed in each of 16 cells.
    assert!(speed(&out) < 2e-3, "{}", speed(&out));
}

#[test]
fn without_viscosity_and_without_gravity() {
    let none = ("kinematic_viscosity", json!(0));
    let mut inviscid = Run::new(cube(vec![down()], std::slice::from_ref(&none)));
    let out = plays(&mut inviscid, 10);
    assert!(out.report.bodies[0].linear_velocity_m_s[2] > 0.05);
    for start in [cube(Vec::new(), &[none]), cloud(Vec::new(), &[])] {
        let mut still = Run::new(start);
        let out = plays(&mut still, 5);
        // Nothing pushes warm air where nothing is heavy, but roundings of a density of one, over a spacing, in each of
        // a hundred substeps.
        let moved = out.report.bodies[0].max_displacement_m;
        assert!(moved < 1e-14, "{moved:e}");
    }
}

#[test]
fn an_obstacle_that_fills_the_domain_stops_everything() {
    let mut full = cube(vec![wind([1.0, 0.0, 0.0]), down()], &[]);
    full.statics.push(wall("rock", Source::Box { size_m: [2.0; 3] }, [0.0; 3]));
    let out = plays(&mut Run::new(full), 3);
    // A wall lets a thousandth through.
    assert!(speed(&out) < 2e-3, "{}", speed(&out));
    let mut full = cloud(vec![wind([1.0, 0.0, 0.0]), down()], &[]);
    full.statics.push(wall("rock", Source::Box { size_m: [2.0; 3] }, [0.0; 3]));
    let mut run = Run::new(full);
    let (all, out) = (run.setup.particles[0], plays(&mut run, 3));
    assert_eq!(out.report.counters["largest-particles-inside-solids"], all, "said in the report");
    // A rigid partner in place of the rock takes all that the gas had, and is told so.
    let mut full = cube(vec![down()], &[]);
    full.interfaces.push(meets(0, "rock", BoundaryForm::Proxy, Some(Source::Box { size_m: [2.0; 3] })));
    let mut run = Run::new(full);
    let record = rigid(1e4, [2.0; 3], [0.0; 3], [0.0, 0.1, 0.0]);
    for _ in 0..3 {
        let partners = vec![shown(0, BoundaryState::Proxy(record), 0.02)];
        let out = run.step_with(&Inputs { partners, impulses: Vec::new() });
        assert!((speed(&out) - 0.1).abs() < 2e-3, "{}", speed(&out));
    }
    assert!(run.defect.iter().all(|d| *d <= ROUNDING * run.gross), "{:?} of {}", run.defect, run.gross);
}

/// What a first window says.
fn first(start: &SolverScene) -> Result<Outputs, PluginError> {
    let mut plugin = Smoke::default();
    plugin.setup(start)?;
    let span = Span { from: start.clock.start_of(0), to: start.clock.start_of(1) };
    plugin.advance(&Step::new(&start.clock, 0, span), &Inputs::default(), &mut Steady)
}

#[test]
fn an_inlet_that_is_too_fast_is_refused_by_name() {
    let jet = |v: f64| {
        let more = [("inflow_rate", json!(100)), ("inflow_velocity", json!([0.0, 0.0, v]))];
        first(&cube(vec![down()], &more)).map(|out| out.report.substeps)
    };
    let why = jet(200.0).expect_err("twice what air bears").to_string();
    assert!(why.contains("above 100 m/s it is not incompressible"), "{why}");
    let substeps = jet(50.0).expect("half of it");
    assert!(substeps > 20, "a Courant number of 0.7 and cells of 5 cm: {substeps}");
    let mut fast = cloud(Vec::new(), &[]);
    fast.bodies[0].velocity =
        cosplat_core::scene::VelocityField::Twist { linear_m_s: [200.0, 0.0, 0.0], angular_rad_s: [0.0; 3] };
    let why = first(&fast).expect_err("lost").to_string();
    assert!(why.contains("particles move at 2.000e2 m/s"), "{why}");
}

#[test]
fn a_domain_a_body_and_a_partner_as_thin_as_a_cell() {
    // A domain grows to whole blocks of 8 cells, as its parameter says.
    let thin = [("low", json!([-0.4, -0.025, -0.4])), ("high", json!([0.4, 0.025, 0.4]))];
    let mut run = Run::new(cube(vec![down()], &thin));
    let out = plays(&mut run, 3);
    assert_eq!(out.report.counters["largest-cells-computed"], 16 * 8 * 16);
    for mut start in [cube(vec![down()], &[]), cloud(vec![down()], &[])] {
        start.bodies[0].source = Source::Box { size_m: [0.01; 3] };
        let mut run = Run::new(start);
        assert_eq!(run.setup.particles[0], 1);
        plays(&mut run, 3);
    }
    let mut start = cube(vec![wind([1.0, 0.0, 0.0])], &[]);
    let size = [0.4, 0.4, 0.01];
    start.interfaces.push(meets(0, "card", BoundaryForm::Proxy, Some(Source::Box { size_m: size })));
    let mut run = Run::new(start);
    let record = rigid(0.1, size, [0.2, 0.0, 0.012], [0.0; 3]);
    let partners = vec![shown(0, BoundaryState::Proxy(record), 0.02)];
    let out = run.step_with(&Inputs { partners, impulses: Vec::new() });
    // It lies between the middles of faces; the gas does not see it, and the report says so.
    assert_eq!(out.report.counters["largest-rigid-partners-outside-or-thinner-than-a-cell"], 1);
}

#[test]
fn particles_that_leave_go_on_and_are_counted() {
    let velocity: Vec3 = [5.0, 0.0, 0.0];
    let mut run = Run::new(cube(vec![wind(velocity)], &[]));
    let all = run.setup.particles[0];
    let out = plays(&mut run, 10);
    assert_eq!(out.report.counters["largest-particles-outside"], all, "a metre in 0.2 s");
    assert!((speed(&out) - 5.0).abs() < 0.05, "{}", speed(&out));
    // Through a closed side nothing leaves.
    let mut run = Run::new(cube(vec![wind(velocity)], &[("open", json!(["-x", "-y", "+y"]))]));
    let out = plays(&mut run, 10);
    let beyond = run.particles().iter().filter(|x| x[0] > 0.4).count();
    assert_eq!((beyond, out.report.counters["largest-particles-outside"] < all), (0, true));
}
