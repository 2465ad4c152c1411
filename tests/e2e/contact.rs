//! Does contact work across processes: a rigid ball of one solver, a soft block of another?

mod support;

use support::{Program, Run};

const SCENE: &str = include_str!("../../launch/scenes/ball-on-block.toml");
/// Of the scene: mass of the ball \[kg\], its first velocity \[m/s\], duration \[s\], gravity \[m/s²\].
const MASS: f64 = 0.5;
const FIRST_SPEED: f64 = -1.0;
const DURATION: f64 = 0.6;
const GRAVITY: f64 = -9.81;

fn run(args: &[&str]) -> Run {
    Program::run(SCENE, args).finish().expect_code(0)
}

fn column(run: &Run, name: &str) -> Vec<f64> {
    let (header, rows) = run.csv("probes.csv");
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
