//! Does contact work across processes: a rigid ball of one solver, a soft block of another?

mod support;

use support::{Program, Run};

const SCENE: &str = include_str!("../../launch/scenes/ball-on-block.toml");
/// Of the scene: mass of the ball \[kg\], its first velocity \[m/s\], duration \[s\], gravity \[m/s²\].
const MASS: f64 = 0.5;
const FIRST_SPEED: f64 = -1.0;
const DURATION: f64 = 0.6;
const GRAVITY: f64 = -9.81;

fn run_scene(scene: &str, args: &[&str]) -> Run {
    Program::run(scene, args).finish().expect_code(0)
}

fn run(args: &[&str]) -> Run {
    run_scene(SCENE, args)
}

fn column(run: &Run, name: &str) -> Vec<f64> {
    column_of(run, "probes.csv", name)
}

fn column_of(run: &Run, file: &str, name: &str) -> Vec<f64> {
    let (header, rows) = run.csv(file);
    let at = header.iter().position(|h| h == name).unwrap_or_else(|| panic!("no `{name}` in {header:?}"));
    rows.iter().map(|row| row[at]).collect()
}

#[test]
fn a_ball_bounces_off_a_soft_block_and_its_momentum_is_accounted_for() {
    let run = run(&["--quiet"]);
    let speeds = column(&run, "ball-velocity.z");
    let fastest_fall = speeds.iter().copied().fold(f64::INFINITY, f64::min);
    let rebound = speeds.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    // It falls freely for 0.1 m: √(1² + 2·9.81·0.1) = 1.72 m/s, a cell of 4 cm more or less.
    assert!((-2.0..-1.5).contains(&fastest_fall), "{fastest_fall}");
    assert!(rebound > 0.3 && rebound < -fastest_fall, "thrown back, but not faster than it came: {rebound}");
    let interface = &run.summary["interfaces"][0];
    assert_eq!(interface["transfer_defect"].as_f64(), Some(0.0), "what was sent is what arrived, to the bit");
    // The ball's own account, from its velocity alone: what gravity does not explain came through the interface.
    let explained = MASS * (speeds.last().expect("rows") - FIRST_SPEED) - MASS * GRAVITY * DURATION;
    let received = interface["impulse_received"][2].as_f64().expect("measured");
    assert!((explained / received - 1.0).abs() < 1e-9, "double precision, 600 sums: {explained} of {received}");
}

#[test]
fn threads_change_no_bit_and_the_scheme_does() {
    let serial = run(&["--quiet", "--threads", "1"]).hash();
    assert_eq!(run(&["--quiet", "--threads", "2"]).hash(), serial);
    let parallel = run(&["--quiet", "--set", "clock.contact_scheme=parallel"]);
    assert_eq!(parallel.summary["interfaces"][0]["transfer_defect"].as_f64(), Some(0.0));
    assert_ne!(parallel.hash(), serial);
}

/// Short and without pictures: whether each pair of solvers couples at all, on one thread as on two.
#[test]
fn what_flows_folds_and_bends_meets_bodies_of_another_process() {
    let plain = ["--set", "output.pictures=false", "--set", "output.splats=false", "--set", "output.recording=false"];
    // The raft has fallen onto the water by then, the silk onto the rock, the mud and the jelly onto their blocks.
    for (scene, changes) in [
        ("dam-and-raft", ["--set", "clock.duration=0.35", "--set", "body.water.spacing=0.04"]),
        ("silk-over-rock", ["--set", "clock.duration=0.2", "--set", "body.silk.spacing=0.02"]),
        ("mud-over-block", ["--set", "clock.duration=0.2", "--set", "body.mud.spacing=0.03"]),
        ("block-on-block", ["--set", "clock.duration=0.25", "--set", "body.jelly.spacing=0.02"]),
    ] {
        let run = |threads: &str| {
            let args = [&["--quiet", "--threads", threads], &plain[..], &changes[..]].concat();
            Program::built_in(scene, &args).finish().expect_code(0)
        };
        let one = run("1");
        let interface = &one.summary["interfaces"][0];
        assert_eq!(interface["transfer_defect"].as_f64(), Some(0.0), "{scene}: what was sent is what arrived");
        assert!(interface["gross_impulse"].as_f64().is_some_and(|j| j > 0.01), "{scene}: they touch: {interface}");
        assert_eq!(run("2").hash(), one.hash(), "{scene}: threads");
    }
}

/// A sheet that flies past a soft block in empty space, three of its vertices attached to it.
const TOWED: &str = r#"
format = 1
name = "towed"
title = "A sheet tows a soft block"

[run]
rigidify = false

# The block's outermost particles swing in 7 ms.
[clock]
duration = 0.3
window = 2e-4

[solver.mpm]
plugin = "mpm-f64"

[solver.pbd.params]
max_substep_s = 1e-4
thickness_m = 0.002
bonds = { sheet = [{ to = "block", at = [[0.06, -0.04, 0.0], [0.06, 0.0, 0.0], [0.06, 0.04, 0.0]] }] }

[[body]]
name = "sheet"
solver = "pbd"
material = { kind = "cloth", areal_density = 2.0, stretch_compliance = 1e-4, bending_compliance = 1e4, static_friction = 0.3, kinetic_friction = 0.2 }
plane = [0.1, 0.1]
spacing = 0.01
position = [0.11, 0.0, 0.0]
velocity = [0.5, 0.0, 1.0]

[[body]]
name = "block"
solver = "mpm"
material = { kind = "elastic", density = 300.0, youngs_modulus = 1.0e5, poissons_ratio = 0.3 }
box = [0.1, 0.1, 0.1]
spacing = 0.02
"#;

#[test]
fn cloth_that_is_attached_to_a_soft_body_tows_it_and_their_momentum_stays() {
    let run = run_scene(TOWED, &["--quiet"]);
    let interface = &run.summary["interfaces"][0];
    assert_eq!(interface["transfer_defect"].as_f64(), Some(0.0), "what was sent is what arrived: {interface}");
    // By states alone, as nothing else acts: 2 kg/m² of 0.1 m by 0.1 m at 0.5 m/s and 1 m/s.
    let first = [0.02 * 0.5, 0.0, 0.02];
    let all = |axis: &str| {
        let one = |solver: &str| column_of(&run, "ledger.csv", &format!("{solver}.momentum_{axis}"));
        [one("pbd"), one("mpm")]
    };
    for (axis, first) in ["x", "y", "z"].iter().zip(first) {
        let [sheet, block] = all(axis);
        let drift = sheet.iter().zip(&block).map(|(a, b)| (a + b - first).abs()).fold(0.0, f64::max);
        println!("momentum {axis}: {drift:e}, at the end {:?} and {:?}", sheet.last(), block.last());
        // Double precision on both sides: 1e-16 of 0.02 kg m/s in each of 3000 substeps.
        assert!(drift < 1e-14, "{axis}: {drift}");
    }
    // It hangs on: a pull of the sheet gives the block, of 0.3 kg, most of what they share.
    let [_, block] = all("z");
    assert!(block.last().is_some_and(|p| *p > 0.3 * 0.02), "{:?}", block.last());
    let widest = run.summary["counters"]["pbd"]["largest-gap-of-a-bond-1e-6-m"].as_u64().unwrap_or(0);
    println!("widest gap {widest} µm");
    assert!(widest < 200, "a hundredth of the block's spacing: {widest} µm");
    // Nothing supplies energy; 2 kg/m² of 0.01 m² at √1.25 m/s.
    let most = column_of(&run, "ledger.csv", "total_energy_j").into_iter().fold(0.0, f64::max);
    assert!(most <= 0.5 * 0.02 * 1.25, "{most}");
    assert_eq!(run_scene(TOWED, &["--quiet", "--threads", "2"]).hash(), run.hash(), "threads");
}
