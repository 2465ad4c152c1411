//! Substeps a second of a silk of 10 000 vertices that hangs by two opposite corners, as others measure it: a sheet of
//! 1.5 m in substeps of 0.4 ms over a floor, with the published density, factors, friction and iterations.
//!
//! Beside it stand figures measured before, on two cores of such a machine: Genesis 1.4.5 on the CPU with the same sheet
//! 31 substeps/s, Newton 1.8.0 with XPBD on the CPU and a sheet of as many vertices 16 steps/s. They are not measured in
//! this run.

use std::time::Instant;

use cosplat_conformance::parts;
use cosplat_core::plugin::{Inputs, Plugin, Steady};
use cosplat_core::scene::{Pose, Source, StaticCollider, Wall, presets};
use cosplat_pbd::Pbd;

/// Vertices along a side, and the side \[m\].
const ROW: u32 = 100;
const SIDE: f64 = 1.5;
/// Length of a window, of ten substeps \[s\].
const WINDOW: f64 = 4e-3;
/// Windows before, and in, each measurement: the silk falls through its hanging shape and folds.
const WINDOWS: [u64; 2] = [25, 50];

fn main() {
    for own in [false, true] {
        for threads in [1, 2] {
            measure(own, threads);
        }
    }
}

fn measure(own: bool, threads: usize) {
    let Some(silk) = presets::preset("silk").map(|p| p.material) else { return };
    let half = 0.5 * SIDE;
    let mut body = parts::body("silk", silk, Source::Plane { size_m: Some([SIDE; 2]) }, [0.0, 0.0, 1.0]);
    body.spacing_m = Some(SIDE / f64::from(ROW - 1));
    let windows = WINDOWS[0] + 4 * WINDOWS[1];
    let mut scene = parts::solver_scene("pbd", vec![body], windows, WINDOW);
    scene.threads = threads;
    scene.actions = vec![parts::gravity()];
    let pose = Pose { position_m: [0.0; 3], orientation: [0.0, 0.0, 0.0, 1.0] };
    let wall = Wall::Friction { static_friction: 0.05, kinetic_friction: 0.03 };
    let source = Source::Plane { size_m: None };
    scene.statics = vec![StaticCollider { name: "floor".into(), source, pose, wall, motion: None, color: None }];
    scene.params.insert("mode".into(), "genesis".into());
    scene.params.insert("max_substep_s".into(), 4e-4.into());
    scene.params.insert("thickness_m".into(), 0.005.into());
    scene.params.insert("self_collision".into(), own.into());
    scene.params.insert("pins".into(), serde_json::json!({ "silk": [[-half, -half, 1.0], [half, half, 1.0]] }));
    let mut plugin = Pbd::default();
    if let Err(why) = plugin.setup(&scene) {
        return println!("{why}");
    }
    let (mut rates, mut substeps, mut begun) = (Vec::new(), 0, Instant::now());
    for window in 0..windows {
        if window >= WINDOWS[0] && (window - WINDOWS[0]).is_multiple_of(WINDOWS[1]) {
            (substeps, begun) = (0, Instant::now());
        }
        let Ok(out) = plugin.advance(&parts::step(&scene.clock, window), &Inputs::default(), &mut Steady) else {
            return;
        };
        substeps += out.report.substeps;
        if window >= WINDOWS[0] && (window - WINDOWS[0]) % WINDOWS[1] == WINDOWS[1] - 1 {
            rates.push(substeps as f64 / begun.elapsed().as_secs_f64());
        }
    }
    rates.sort_unstable_by(f64::total_cmp);
    let (least, most) = (rates.first().copied().unwrap_or(0.0), rates.last().copied().unwrap_or(0.0));
    println!(
        "{} vertices, {threads} threads, self-collision {}: {least:.0} to {most:.0} substeps/s",
        ROW * ROW,
        if own { "on" } else { "off" }
    );
}
