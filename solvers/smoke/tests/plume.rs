//! Warm smoke rises as similarity says (Turner 1969, "Buoyant plumes and thermals").

#[cfg(test)]
mod common;

use std::f64::consts::PI;

use common::{Run, ball, gravity, meets, rigid, scene, shown};
use cosplat_core::boundary::{BoundaryState, SampleStatics};
use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{Inputs, PartnerSetup};
use cosplat_core::scene::{Body, Source};
use serde_json::json;

/// Edge of a cell and radius of a source \[m\].
const CELL: f64 = 0.02;
const RADIUS: f64 = 0.06;
/// Height of a source \[m\].
const SOURCE: f64 = 0.12;

/// A place that is above that share of all.
fn above(mut places: Vec<f64>, share: f64) -> f64 {
    places.sort_by(f64::total_cmp);
    places[((places.len() - 1) as f64 * share) as usize]
}

/// The power `n` with which `y + below` grows in time: that for which its `1/n`th power grows as much in the first half
/// of the time as in the second. It does not depend on when the time begins.
fn power(seen: &[[f64; 2]], below: f64) -> f64 {
    let (first, last) = (seen[0], seen[seen.len() - 1]);
    let middle = 0.5 * (first[0] + last[0]);
    let after = seen.iter().position(|s| s[0] >= middle).expect("the last one is later");
    let [a, b] = [seen[after - 1], seen[after]];
    let half = a[1] + (middle - a[0]) / (b[0] - a[0]) * (b[1] - a[1]);
    let (mut low, mut high) = (0.1_f64, 3.0_f64);
    for _ in 0..50 {
        let n = 0.5 * (low + high);
        let y = |z: f64| (z + below).powf(1.0 / n);
        if y(last[1]) - y(half) > y(half) - y(first[1]) { low = n } else { high = n }
    }
    0.5 * (low + high)
}

/// Slope of a straight line through points, and where it is zero.
fn line(points: &[[f64; 2]]) -> [f64; 2] {
    let mean = [0, 1].map(|k| points.iter().map(|p| p[k]).sum::<f64>() / points.len() as f64);
    let sum = |k: usize| points.iter().map(|p| (p[0] - mean[0]) * (p[k] - mean[k])).sum::<f64>();
    let slope = sum(1) / sum(0);
    [slope, mean[0] - mean[1] / slope]
}

/// A quarter of a ball, on the side of the planes of symmetry where all coordinates across are positive.
fn quarter() -> Body {
    let spacing = 0.25 * CELL;
    let at = |i: i32| (f64::from(i) + 0.5) * spacing;
    let all = (0..12).flat_map(|i| (0..12).flat_map(move |j| (-12..12).map(move |k| [at(i), at(j), at(k)])));
    let inside = |x: &[f64; 3]| x.iter().map(|x| x * x).sum::<f64>() < RADIUS * RADIUS;
    let mut body = ball(1.204, RADIUS, [0.0, 0.0, SOURCE], spacing);
    body.source = Source::Points { positions_m: all.filter(inside).collect() };
    body
}

#[test]
fn a_thermal_rises_with_the_power_a_half() {
    // Buoyancy F = g' V is kept and so is the viscosity, so that √F/ν, here 105, is a number: a cloud that has
    // forgotten its first radius can only rise as F^(1/4) t^(1/2) and spread in proportion, laminar or not. Without
    // that viscosity a ring of vorticity on so few cells stays laminar and hardly spreads, and the power is 0.8.
    let params = json!({
        "low": [0, 0, 0], "high": [0.64, 0.64, 1.12], "cell": CELL, "open": ["+x", "+y", "+z"], "temperature": 330,
        "kinematic_viscosity": 3e-4
    });
    let mut run = Run::new(scene(quarter(), vec![gravity([0.0, 0.0, -9.81])], 0.05, &params));
    let (mut heights, mut widths) = (Vec::new(), Vec::new());
    loop {
        run.step();
        let x = run.particles();
        let z = x.iter().map(|x| x[2] - SOURCE).sum::<f64>() / x.len() as f64 / RADIUS;
        let b = above(x.iter().map(|x| x[0].hypot(x[1])).collect(), 0.9) / RADIUS;
        if z > 10.0 {
            break;
        }
        if z > 3.0 {
            heights.push([run.time(), z]);
            widths.push([z, b]);
        }
    }
    let [spread, origin] = line(&widths);
    let found = power(&heights, -origin);
    println!("power {found} from {origin} radii, spread {spread}, {} substeps", run.substeps);
    // The published bounds. Thermals spread by 0.2 to 0.3 (Turner 1969), laminar ones a little less (Lecoanet and
    // Jeevanjee 2019).
    assert!((found - 0.5).abs() < 0.1, "{found}");
    assert!((0.15..0.3).contains(&spread) && (-4.0..0.0).contains(&origin), "{spread} {origin}");
}

/// Particles \[1/s\] that leave the source of a starting plume, and seconds for which there are some.
const RATE: f64 = 3000.0;
const LASTS: f64 = 14.0;
/// Length of a window \[s\].
const WINDOW: f64 = 0.02;

/// A source of smoke that never ends: places in a ball in an order by chance, of which each is somewhere else.
fn inflow(cell: f64) -> Body {
    let mut seed = 12345_u64;
    let mut chance = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        2.0 * ((seed >> 33) as f64 / f64::from(1_u32 << 31)) - 1.0
    };
    let count = (RATE * LASTS) as usize + 2000;
    let mut places: Vec<[f64; 3]> = Vec::new();
    while places.len() < count {
        let x = [(); 3].map(|()| chance() * RADIUS);
        if x.iter().map(|x| x * x).sum::<f64>() < RADIUS * RADIUS {
            places.push(x);
        }
    }
    let mut body = ball(1.204, RADIUS, [0.0, 0.0, SOURCE], 0.25 * cell);
    body.source = Source::Points { positions_m: places };
    body.spacing_m = Some((4.19 * RADIUS * RADIUS * RADIUS / count as f64).cbrt());
    body
}

#[test]
#[ignore = "some minutes: turbulence needs room"]
fn a_stirred_starting_plume_rises_with_the_power_three_quarters() {
    // A constant flux of buoyancy B \[m⁴/s³\] and no other number make z ∝ B^(1/4) t^(3/4), if the plume is turbulent.
    // What the cells carry becomes so where something stirs its root: a blade that shakes in the source, three times a
    // second. From 20 radii on, ten diameters, the cap has forgotten it.
    let cell = RADIUS / 1.5;
    let (half, top) = (16.0 * RADIUS, 60.0 * RADIUS);
    let params = json!({
        "low": [-half, -half, 0], "high": [half, half, top], "cell": cell, "open": ["-x", "+x", "-y", "+y", "+z"],
        "temperature": 330, "inflow_rate": RATE, "still": 0.01
    });
    let mut start = scene(inflow(cell), vec![gravity([0.0, 0.0, -9.81])], WINDOW, &params);
    let size = [0.08, 0.03, 0.04];
    start.interfaces.push(meets(0, "blade", BoundaryForm::Proxy, Some(Source::Box { size_m: size })));
    let blade = PartnerSetup { interface: 0, statics: SampleStatics::default() };
    let mut run = Run::with(start, &[blade]);
    let (mut heights, mut widths) = (Vec::new(), Vec::new());
    while heights.last().is_none_or(|last: &[f64; 2]| last[1] < 50.0) && run.time() < LASTS - 2.0 * WINDOW {
        let (x, y) = (6.0 * PI * run.time(), 6.0 * PI * 0.618 * run.time());
        let reach = 0.7 * RADIUS;
        let place = [reach * x.sin(), reach * y.cos(), SOURCE + RADIUS];
        let speed = [6.0 * PI * reach * x.cos(), -6.0 * PI * 0.618 * reach * y.sin(), 0.0];
        let now = BoundaryState::Proxy(rigid(1000.0, size, place, speed));
        run.step_with(&Inputs { partners: vec![shown(0, now, WINDOW)], impulses: Vec::new() });
        let mut smoke = run.particles();
        smoke.truncate((RATE * run.time()) as usize);
        let height = |x: &[f64; 3]| (x[2] - SOURCE) / RADIUS;
        let front = above(smoke.iter().map(height).collect(), 0.99);
        if front > 20.0 {
            let cap = smoke.iter().filter(|x| height(x) > 0.8 * front);
            let width = above(cap.map(|x| x[0].hypot(x[1]) / RADIUS).collect(), 0.9);
            heights.push([run.time(), front]);
            widths.push([front, width]);
        }
    }
    let [spread, origin] = line(&widths);
    let found = power(&heights, -origin);
    let reached = heights[heights.len() - 1];
    println!("power {found} from {origin} radii, spread {spread}, {reached:?}, {} substeps", run.substeps);
    assert!(reached[1] > 45.0, "{reached:?}");
    // The published bounds; caps of starting plumes spread by 0.18 (Turner 1962) to 0.3. One plume is one sample of
    // turbulence: its part from 20 to 45 radii alone grows with the power 0.63.
    assert!((found - 0.75).abs() < 0.1, "{found}");
    assert!((0.15..0.3).contains(&spread), "{spread} from {origin}");
}
