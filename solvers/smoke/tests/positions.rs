//! The second seed's own method: particles that are kept apart by constraints on their density.

#[cfg(test)]
mod common;

use common::{Run, UPRIGHT, ball, gravity, meets, rigid, scene, sheet, shown, wall, wind};
use cosplat_conformance::{Case, assert_conforms};
use cosplat_core::boundary::{BoundaryState, Impulses, SampleStatics, add, cross, norm};
use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{Inputs, Outputs, PartnerSetup, Plugin, SolverScene};
use cosplat_core::scene::{Pose, Source, VelocityField};
use cosplat_smoke::Smoke;
use serde_json::json;

/// A heavy gas in a box of that width, filled to that height \[m\], without air.
fn filled(width: f64, height: f64, spacing: f64, iterations: u32) -> SolverScene {
    let params = json!({
        "method": "positions", "low": [0, 0, 0], "high": [width, width, 2.0 * height], "open": ["+z"],
        "air_density": 1e-9, "density_iterations": iterations, "surface_drag": 0
    });
    let mut body = ball(1.0, 0.1, [0.5 * width, 0.5 * width, 0.5 * height], spacing);
    body.source = Source::Box { size_m: [width, width, height] };
    let mut start = scene(body, vec![gravity([0.0, 0.0, -9.81])], 0.02, &params);
    start.threads = 1;
    start
}

/// Root mean square and largest error of the density where it is too large, over that at rest.
fn crowding(out: &Outputs) -> [f64; 2] {
    ["largest-mean-crowding-1e-6", "largest-crowding-1e-6"].map(|name| out.report.counters[name] as f64 * 1e-6)
}

#[test]
fn each_doubling_of_the_iterations_leaves_less_error_of_the_density() {
    // The published box of 0.5 m, filled to 0.3 m.
    let error = |iterations| {
        let mut run = Run::new(filled(0.5, 0.3, 0.05, iterations));
        let last = (0..10).map(|_| crowding(&run.step())).last().expect("ten windows");
        println!("{iterations} iterations: {:.1e} rms, {:.1e} at most", last[0], last[1]);
        last
    };
    let errors = [1, 2, 4, 8, 16].map(error);
    assert!(errors.windows(2).all(|two| two[1][0] < two[0][0]), "{errors:?}");
    // What is published for 8 iterations, a percent, is met by far: the seed's step is 1 ms, in which gravity moves a
    // particle by 1e-5 m, 2e-4 of a spacing.
    assert!(errors[3][0] < 1e-3 && errors[3][1] < 0.01, "{errors:?}");
}

#[test]
fn what_has_come_to_rest_does_not_heat_up() {
    let mut run = Run::new(filled(0.1, 0.15, 0.05, 8));
    let lift = 9.81 * 0.0015 * 0.15;
    let mut energies = Vec::new();
    for _ in 0..500 {
        energies.push(run.step().report.energy.kinetic_j / lift);
    }
    println!("{} substeps; {:.1e}, {:.1e}, {:.1e} of m g h", run.substeps, energies[0], energies[249], energies[499]);
    let [early, late] = [&energies[200..250], &energies[450..]].map(|part| part.iter().fold(0.0_f64, |m, e| m.max(*e)));
    // The published bound, in ten thousand steps.
    assert!(run.substeps >= 10_000 && late < early.max(1e-6), "{early:e} {late:e}");
}

/// A ball of smoke of 0.1 m in a wind, by that method, beside a floor.
fn windy() -> SolverScene {
    let params = json!({ "method": "positions", "density_iterations": 4, "surface_drag": 20 });
    let mut body = ball(1.0, 0.1, [-0.12, 0.0, 0.0], 0.02);
    body.velocity = VelocityField::Twist { linear_m_s: [1.0, 0.0, -0.5], angular_rad_s: [0.0, 3.0, 2.0] };
    let actions = vec![wind([1.0, 0.0, 0.0]), gravity([0.0, 0.0, -9.81])];
    let mut start = scene(body, actions, 0.01, &params);
    start.statics.push(wall("floor", Source::Plane { size_m: None }, [0.0, 0.0, -0.12]));
    start
}

/// Roundings of a hundred thousand impulses.
fn closes(run: &Run) {
    println!("defect {:?} of {} in {} substeps", run.defect, run.gross, run.substeps);
    assert!(run.defect.iter().all(|d| *d < 1e-12 * run.gross), "{:?}", run.defect);
}

#[test]
fn what_a_box_receives_is_what_the_smoke_loses() {
    let (mut start, size) = (windy(), [0.1, 0.2, 0.15]);
    start.interfaces.push(meets(0, "crate", BoundaryForm::Proxy, Some(Source::Box { size_m: size })));
    let mut run = Run::new(start);
    let (mut mismatch, mut pushed) = (0.0_f64, 0.0);
    for w in 0..30 {
        let record = rigid(0.02, size, [0.1, 0.0, 0.001 * f64::from(w)], [0.0, 0.0, 0.1]);
        let shown = vec![shown(0, BoundaryState::Proxy(record), 0.01)];
        let out = run.step_with(&Inputs { partners: shown, impulses: Vec::new() });
        let Impulses::Rigid(j) = &out.impulses[0].1 else { panic!("a rigid impulse") };
        let got = out.report.interfaces[0].received;
        let about = add(j.angular, cross(record.position, j.linear));
        mismatch = mismatch.max(norm(add(got.linear, j.linear))).max(norm(add(got.angular, about)));
        pushed += j.linear[0];
    }
    closes(&run);
    println!("{pushed} N s, {mismatch:e}");
    // Half of the ball, 2 g, is in the way of the box and stopped from 1 m/s; what is between a part and all of it.
    assert!(mismatch < 1e-15 && pushed > 5e-4 && pushed < 4.2e-3, "{pushed} {mismatch:e}");
}

/// A cloud that meets a sheet that stays where it is; and all that the sheet got \[N s\]. It weighs 0.9 kg/m²: a light
/// sample yields to what it is given, and its stand-in lets through what goes at its speed until the window ends.
fn meets_a_sheet(threads: usize) -> (Run, f64) {
    let mut start = windy();
    start.threads = threads;
    start.interfaces.push(meets(0, "sheet", BoundaryForm::SamplesF64 { normals: false }, None));
    let statics = SampleStatics { area_m2: vec![2.25e-4; 400], ..SampleStatics::equal(400, 2e-4) };
    let mut run = Run::with(start, &[PartnerSetup { interface: 0, statics }]);
    let (points, mut pushed) = (sheet(20, 0.015, 0.02), 0.0);
    for _ in 0..30 {
        let now = BoundaryState::points(&points, &[[0.0; 3]; 400]);
        let out = run.step_with(&Inputs { partners: vec![shown(0, now, 0.01)], impulses: Vec::new() });
        let Impulses::Samples(each) = &out.impulses[0].1 else { panic!("samples") };
        let open = add(out.impulses[0].1.total(), out.report.interfaces[0].received.linear);
        // Samples take impulses along the line to the particle, so that moments agree as well.
        let moment = points.iter().zip(each).fold([0.0; 3], |sum, (x, j)| add(sum, cross(*x, *j)));
        let turned = add(moment, out.report.interfaces[0].received.angular);
        assert!(norm(open) < 1e-15 && norm(turned) < 1e-15, "{open:?} {turned:?}");
        pushed += each.iter().map(|j| j[0]).sum::<f64>();
    }
    (run, pushed)
}

#[test]
fn a_sheet_stops_the_smoke_and_takes_its_momentum() {
    let (run, pushed) = meets_a_sheet(1);
    closes(&run);
    let through = run.particles().iter().filter(|x| x[0] > 0.02 && x[1].abs() < 0.12 && x[2].abs() < 0.12).count();
    println!("{pushed} N s, {through} particles behind the sheet");
    // 4.2 g at 1 m/s, and what the wind's drag on its surface adds in 0.3 s.
    assert!(through == 0 && pushed > 3e-3 && pushed < 1e-2, "{pushed} {through}");
    assert_eq!(run.hash(), meets_a_sheet(3).0.hash(), "threads change nothing");
}

#[test]
fn it_conforms_and_refuses_what_belongs_to_the_grid() {
    let mut start = windy();
    start.threads = 1;
    assert_conforms(&|| Box::new(Smoke::default()), &[Case::new("positions", start)]);
    let refused = |key: &str, value: serde_json::Value| {
        let mut start = windy();
        start.params.insert(key.into(), value);
        Smoke::default().setup(&start).expect_err("refused").to_string()
    };
    assert!(refused("cell", json!(0.1)).contains("`cell` beside `method = \"positions\"`"));
    assert!(refused("inflow_rate", json!(5)).contains("`inflow_rate`"));
    assert!(refused("method", json!("sph")).contains("`grid` and `positions`"));
    assert!(refused("density_iterations", json!(0)).contains("`density_iterations`"));
}

#[test]
fn a_cloud_alone_keeps_its_motion() {
    let params = json!({ "method": "positions", "surface_drag": 0 });
    let mut body = ball(1.0, 0.1, [0.3, 0.2, 0.1], 0.02);
    body.pose = Pose { position_m: [0.3, 0.2, 0.1], orientation: UPRIGHT };
    body.velocity = VelocityField::Twist { linear_m_s: [0.5, 0.2, -0.1], angular_rad_s: [0.0; 3] };
    let mut run = Run::new(scene(body, Vec::new(), 0.01, &params));
    let begin = run.setup.report.energy.kinetic_j;
    let end = (0..30).map(|_| run.step().report.energy.kinetic_j).last().expect("thirty windows");
    closes(&run);
    // On a lattice at its density of rest nothing pushes: to roundings of three hundred substeps.
    assert!((end / begin - 1.0).abs() < 1e-12, "{begin} {end}");
}

#[test]
fn what_begins_crowded_is_not_thrown_apart() {
    let params = json!({ "method": "positions", "surface_drag": 0 });
    let mut body = ball(1.0, 0.1, [0.0; 3], 0.03);
    let at = |i: i32| 0.02 * f64::from(i) + 0.003 * f64::from(i * i % 7);
    let all = (0..6).flat_map(|i| (0..6).flat_map(move |j| (0..6).map(move |k| [at(i), at(j + k), at(k)])));
    body.source = Source::Points { positions_m: all.collect() };
    let mut run = Run::new(scene(body, Vec::new(), 0.01, &params));
    let moved = (0..10).map(|_| run.step().report.bodies[0].max_displacement_m).last().expect("ten windows");
    // Roundings of a hundred substeps.
    assert!(moved < 1e-13, "{moved:e}");
}
