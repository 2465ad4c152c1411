//! Warm smoke rises as similarity says (Turner, "Buoyant plumes and thermals", 1969).

#[cfg(test)]
mod common;

use common::{Run, ball, gravity, scene};
use serde_json::json;

/// Height of the front above the source \[m\] over time \[s\]: nineteen of twenty moving particles are below.
fn heights(mut run: Run, source: f64, windows: u32, born: impl Fn(f64) -> usize) -> Vec<[f64; 2]> {
    let mut found = Vec::new();
    for _ in 0..windows {
        run.step();
        let count = born(run.time());
        let mut z: Vec<f64> = run.particles().iter().take(count).map(|x| x[2] - source).collect();
        if z.is_empty() {
            continue;
        }
        z.sort_by(f64::total_cmp);
        found.push([run.time(), z[z.len() * 19 / 20]]);
    }
    println!("{} substeps, {} iterations", run.substeps, run.iterations);
    found
}

/// Slope of height over time, both as logarithms, between two heights, by least squares.
fn slope(heights: &[[f64; 2]], from: f64, to: f64) -> f64 {
    let seen = heights.iter().filter(|[_, z]| (from..to).contains(z));
    let points: Vec<_> = seen.map(|[t, z]| [t.ln(), z.ln()]).collect();
    let mean = [0, 1].map(|k| points.iter().map(|p| p[k]).sum::<f64>() / points.len() as f64);
    let sum = |k: usize| points.iter().map(|p| (p[0] - mean[0]) * (p[k] - mean[k])).sum::<f64>();
    println!(
        "{} points from {:?} to {:?}",
        points.len(),
        points[0].map(f64::exp),
        points[points.len() - 1].map(f64::exp)
    );
    sum(1) / sum(0)
}

#[test]
fn a_starting_plume_rises_with_the_power_three_quarters() {
    let params = json!({
        "low": [-0.6, -0.6, 0.0], "high": [0.6, 0.6, 2.4], "cell": 0.0375, "open": ["-x", "+x", "-y", "+y", "+z"],
        "temperature": 320.0, "inflow_rate": 400.0
    });
    let source = 0.2;
    let start = scene(ball(1.204, 0.11, [0.0, 0.0, source], 0.0125), vec![gravity([0.0, 0.0, -9.81])], 0.05, &params);
    let run = Run::new(start);
    let heights = heights(run, source, 60, |t| (400.0 * t) as usize);
    for h in heights.iter().step_by(4) {
        println!("{:.2} s {:.3} m", h[0], h[1]);
    }
    let found = slope(&heights, 0.5, 1.8);
    println!("power {found}");
    assert!((found - 0.75).abs() < 0.1, "{found}");
}

#[test]
fn a_puff_rises_with_the_power_a_half() {
    let params = json!({
        "low": [-0.6, -0.6, 0.0], "high": [0.6, 0.6, 2.4], "cell": 0.0375, "open": ["-x", "+x", "-y", "+y", "+z"],
        "temperature": 340.0
    });
    let source = 0.2;
    let start = scene(ball(1.204, 0.12, [0.0, 0.0, source], 0.02), vec![gravity([0.0, 0.0, -9.81])], 0.05, &params);
    let run = Run::new(start);
    let heights = heights(run, source, 80, |_| 900);
    for h in heights.iter().step_by(4) {
        println!("{:.2} s {:.3} m", h[0], h[1]);
    }
    let found = slope(&heights, 0.5, 1.8);
    println!("power {found}");
}
