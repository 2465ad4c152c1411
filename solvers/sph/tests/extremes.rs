//! Scenes at the edge: each ends in a right answer, in a worse one that is reported, or in a refusal with its reason.

#[cfg(test)]
mod common;

use common::{Float, Run, columns, liquid, meets, plane, scene, tank, water};
use cosplat_core::boundary::norm;
use cosplat_core::plan::{BoundaryForm, LeftOut};
use cosplat_core::plugin::{Inputs, Plugin, PluginError, SolverScene, Steady};
use cosplat_core::scene::{Body, Pose, Source, VelocityField, Wall};
use cosplat_sph::Sph;

const BOTH: [&str; 2] = ["wcsph", "dfsph"];

fn with(pressure: &str, mut scene: SolverScene) -> SolverScene {
    scene.params.insert("pressure".into(), pressure.into());
    scene
}

fn flying(mut body: Body, linear_m_s: [f64; 3]) -> Body {
    body.velocity = VelocityField::Twist { linear_m_s, angular_rad_s: [0.0; 3] };
    body
}

fn mechanical(run: &mut Run) -> f64 {
    let e = run.step().report.energy;
    e.kinetic_j + e.potential_j
}

#[test]
fn nothing_at_all_advances() {
    for pressure in BOTH {
        let mut run = Run::new(with(pressure, scene(Vec::new(), tank(1.0, 1.0, Wall::Slip), 1e-3)));
        assert!(run.setup.stable_dt.is_none() && run.step().report.bodies.is_empty());
    }
}

#[test]
fn one_particle_falls_and_stays_above_the_floor() {
    let d = 0.02;
    for pressure in BOTH {
        let body = liquid(water(10.0, 1e-3), [d; 3], [0.1, 0.1, 0.05], d);
        let mut run = Run::new(with(pressure, scene(vec![body], tank(0.2, 0.2, Wall::Slip), 5e-3)));
        assert_eq!(run.setup.particles, [1]);
        for _ in 0..200 {
            run.step();
        }
        let (x, v, _) = columns(&run.bytes());
        println!("{pressure}: {:?} {:?}", x[0], v[0]);
        // It bounces, as nothing takes its energy, above the floor and no higher than it started.
        assert!((0.2 * d..0.051).contains(&x[0][2]) && norm(v[0]) < 1.0, "{:?} {:?}", x[0], v[0]);
    }
}

#[test]
fn without_gravity_nothing_moves() {
    for pressure in BOTH {
        let body = liquid(water(10.0, 1.0), [0.1; 3], [0.05; 3], 0.02);
        let mut start = with(pressure, scene(vec![body], tank(0.2, 0.1, Wall::NoSlip), 5e-3));
        start.actions.clear();
        let mut run = Run::new(start);
        for _ in 0..20 {
            run.step();
        }
        let (_, v, _) = columns(&run.bytes());
        assert!(v.iter().all(|&v| norm(v) < 1e-9), "{pressure}");
    }
}

#[test]
fn a_thousand_times_the_viscosity_creeps_and_gains_nothing() {
    for pressure in BOTH {
        let body = liquid(water(10.0, 1000.0), [0.16; 3], [0.08; 3], 0.02);
        let mut run = Run::new(with(pressure, scene(vec![body], tank(0.4, 0.16, Wall::NoSlip), 0.01)));
        let first = run.setup.report.energy.potential_j;
        for _ in 0..20 {
            let now = mechanical(&mut run);
            assert!(now <= first * 1.001, "{now} of {first}");
        }
        let (_, v, _) = columns(&run.bytes());
        let fastest = v.iter().map(|&v| norm(v)).fold(0.0, f64::max);
        println!("{pressure}: {} substeps, fastest {fastest}", run.substeps);
        // A column of height H creeps with about ρ g H²/μ = 0.25 m/s; free fall would have reached 2 m/s.
        assert!(fastest < 0.25, "{fastest}");
    }
}

#[test]
fn an_impact_at_100_m_per_s_is_refused_by_name_or_borne() {
    let hit = |sound: f64, pressure: &str| {
        let body = flying(liquid(water(sound, 1e-3), [0.1; 3], [0.2, 0.2, 0.08], 0.02), [0.0, 0.0, -100.0]);
        with(pressure, scene(vec![body], vec![plane("floor", [0.0; 3], common::UPRIGHT, Wall::Slip)], 5e-4))
    };
    // Liquid slower than the impact: the equation of state has nothing to say.
    let mut plugin = Sph::default();
    let slow = hit(20.0, "wcsph");
    plugin.setup(&slow).expect("a scene it takes");
    let step = cosplat_conformance::parts::step(&slow.clock, 0);
    let why = plugin.advance(&step, &Inputs::default(), &mut Steady).unwrap_err();
    assert!(matches!(&why, PluginError::Physics(w) if w.contains("faster than sound")), "{why}");
    for (sound, pressure) in [(1000.0, "wcsph"), (20.0, "dfsph")] {
        let mut run = Run::new(hit(sound, pressure));
        let first = run.setup.report.energy.kinetic_j;
        let mut most = 0.0_f64;
        for _ in 0..8 {
            most = most.max(mechanical(&mut run) / first);
        }
        let (x, ..) = columns(&run.bytes());
        let lowest = x.iter().map(|x| x[2]).fold(f64::INFINITY, f64::min);
        println!("{pressure}: energy at most {most}, lowest {lowest}, {} substeps", run.substeps);
        println!("defect {:?} of {}", run.defect, run.gross);
        // At a tenth of the speed of sound the first layer is pressed into the wall's, which holds it.
        assert!(most < 1.001 && lowest > -0.02, "{most} {lowest}");
        assert!(run.defect[0] < 1e-12 * run.gross && run.defect[1] < 1e-12 * run.gross, "{:?}", run.defect);
    }
}

#[test]
fn what_leaves_the_domain_is_counted() {
    for pressure in BOTH {
        let d = 0.02;
        let mut body = flying(liquid(water(80.0, 1e-3), [0.1; 3], [0.0; 3], d), [50.0, 0.0, 0.0]);
        body.name = "shot".into();
        let rest = liquid(water(80.0, 1e-3), [0.1; 3], [0.0, 0.0, -0.2], d);
        let floor = plane("floor", [0.0, 0.0, -0.25], common::UPRIGHT, Wall::Slip);
        let mut run = Run::new(with(pressure, scene(vec![rest, body], vec![floor], 0.02)));
        let mut strayed = 0;
        for _ in 0..10 {
            strayed = run.step().report.counters["strayed-particles"];
        }
        // Ten metres away, with a start of half a metre in size.
        println!("{pressure}: {strayed} strayed, {} substeps", run.substeps);
        assert_eq!(strayed, 125);
    }
}

/// A box of that share of the water's density in the middle of a tank, under water or laid on it.
fn partner(pressure: &str, share: f64, height: f64) -> (f64, f64, Run) {
    let (d, side, size, window) = (0.02, 0.2, [0.08; 3], 2e-3);
    let body = liquid(water(20.0, 1.0), [side; 3], [0.5 * side; 3], d);
    let mut start = with(pressure, scene(vec![body], tank(side, side, Wall::Slip), window));
    let mut face = meets("box", BoundaryForm::Proxy, Some(Source::Box { size_m: size }), 0.0);
    face.partner_pose = Some(Pose { position_m: [0.5 * side, 0.5 * side, height], orientation: [0.0, 0.0, 0.0, 1.0] });
    start.interfaces.push(face);
    let mut float = Float::new(share * 1000.0 * size[0].powi(3), size, [0.5 * side, 0.5 * side, height]);
    let mut run = Run::new(start);
    let (mut fastest, mut splash) = (0.0_f64, 0.0_f64);
    for _ in 0..40 {
        let out = run.step_with(&float.inputs(window));
        float.take(&out, window);
        fastest = fastest.max(norm(float.record.linear_velocity));
        let (_, v, _) = columns(&run.bytes());
        splash = v.iter().map(|&v| norm(v)).fold(splash, f64::max);
    }
    println!("{pressure}, {share} at {height}: box {fastest} m/s, water {splash} m/s, {:?}", float.record.position);
    assert!(run.defect[0] < 1e-12 * run.gross && run.defect[1] < 1e-12 * run.gross, "{:?}", run.defect);
    (fastest, splash, run)
}

#[test]
fn ratios_of_mass_of_ten_thousand_stay_bounded() {
    for pressure in BOTH {
        // Laid on the water: free fall over 80 ms is 0.8 m/s. The surface, which trembles while its pressure builds up, throws
        // what weighs a hundredth of a particle: its 50 mg fly, and the water does not notice.
        let (fastest, splash, _) = partner(pressure, 1e-4, 0.24);
        assert!(fastest < 3.0 && splash < 0.5, "{fastest} {splash}");
        let (fastest, splash, _) = partner(pressure, 1e4, 0.24);
        assert!(fastest < 0.8 + 1e-3 && splash < 4.0, "{fastest} {splash}");
    }
}

#[test]
fn a_start_inside_a_solid_is_put_right_and_said() {
    for pressure in BOTH {
        let body = liquid(water(20.0, 1.0), [0.2, 0.2, 0.1], [0.1, 0.1, 0.05], 0.02);
        let mut walls = tank(0.2, 0.2, Wall::Slip);
        walls[0].pose.position_m[2] = 0.04;
        let mut run = Run::new(with(pressure, scene(vec![body], walls, 5e-3)));
        let said =
            run.setup.left_out.iter().any(|l| l.what.starts_with("200 of 500 particles") && l.why.contains("inside"));
        assert!(said, "{:?}", run.setup.left_out);
        let first = run.setup.report.energy.potential_j;
        for _ in 0..20 {
            let now = mechanical(&mut run);
            // Three layers, weakly compressible, gain 1.04e-3: the catalogue's 1e-3 is missed by a little.
            assert!(now <= first * 1.002, "{pressure}: {now} of {first}");
        }
    }
}

#[test]
fn a_start_around_a_soft_body_leaves_out_what_it_takes_and_says_so() {
    let (d, size) = (0.02, [0.08; 3]);
    let body = liquid(water(20.0, 1.0), [0.2; 3], [0.1; 3], d);
    let mut start = with("wcsph", scene(vec![body], tank(0.2, 0.2, Wall::Slip), 2e-4));
    let form = BoundaryForm::SamplesF64 { normals: true };
    let mut face = meets("jelly", form, Some(Source::Box { size_m: size }), 0.0);
    face.partner_pose = Some(Pose { position_m: [0.1; 3], orientation: common::UPRIGHT });
    start.interfaces.push(face);
    let mut plugin = Sph::default();
    let setup = plugin.setup(&start).expect("the scene is supported");
    let said = |l: &LeftOut| l.what == "64 of 1000 particles of `water`" && l.why == "they lay inside `jelly`";
    assert!(setup.left_out.iter().any(said), "{:?}", setup.left_out);
}

#[test]
fn a_start_around_a_rigid_body_leaves_out_what_it_takes_and_says_so() {
    for (pressure, height) in [("wcsph", 0.1), ("dfsph", 0.1), ("wcsph", 0.107), ("dfsph", 0.107)] {
        let (fastest, splash, run) = partner(pressure, 0.5, height);
        // Four cells along each side, in whole layers wherever it is between them.
        let said = |l: &LeftOut| l.what == "64 of 1000 particles of `water`" && l.why == "they lay inside `box`";
        assert!(run.setup.left_out.iter().any(said), "{:?}", run.setup.left_out);
        // Half as heavy as what it displaces, and that mass with it by half a sphere's share at least: it rises with at most
        // g (1 - s)/(s + 1/2) over 80 ms.
        assert!(fastest < 0.5 * 9.81 * 0.08, "{fastest}");
        assert!(splash < 1.0, "{splash}");
    }
}
