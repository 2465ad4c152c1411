//! A circular drop that is squeezed to an ellipse (Monaghan, "Simulating free surface flows with SPH", 1994, §5.2).

#[cfg(test)]
mod common;

use common::{Run, columns, liquid, plane, scene, water};
use cosplat_core::scene::{Source, VelocityField, Wall};

/// Longer semi-axis at 7.6 ms of a drop of 1 m whose velocities are (-100 x, 100 z) 1/s, by `A' = A² (a⁴ - 1)/(a⁴ + 1)`,
/// `a' = -a A` \[m\].
const LONG: f64 = 1.9445;

/// By how much the particles of a drop are off their lattice at the start at most, in spacings.
///
/// A lattice that is squeezed keeps its rows, which come to stand half a spacing apart one way and two the other. There the
/// kernel's sum, and what its gradient makes of the flow, is not that of a liquid: the rates alone add 13 % to the area by
/// 5.7 ms, by sums over the lattice, with any number of particles. Pressure makes such rows buckle within a millisecond,
/// `d √(ρ/p)`, but needs something to begin with.
const SHAKEN: f64 = 0.1;

/// Semi-axes \[m\] at 7.6 ms and what is left of the energy, with that many particles over the radius.
fn squeezed(over: f64, pressure: &str, shaken: f64) -> ([f64; 2], f64) {
    let d = 1.0 / over;
    let thick = 4.0 * d;
    let mut drop = liquid(water(1400.0, 1e-3), [1.0; 3], [0.0; 3], d);
    let n = over as i32 + 1;
    let all = (-n..n).flat_map(|i| (-n..n).flat_map(move |k| (0..4).map(move |j| [i, j, k])));
    let mut state = 1_u64;
    // A linear congruential generator (Knuth), from -1 to 1.
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / f64::from(1_u32 << 30) - 1.0
    };
    let at = all.map(|i| i.map(|i| (f64::from(i) + 0.5 + shaken * random()) * d));
    drop.source = Source::Points { positions_m: at.filter(|x| x[0].hypot(x[2]) < 1.0).collect() };
    let gradient_1_s = [[-100.0, 0.0, 0.0], [0.0; 3], [0.0, 0.0, 100.0]];
    drop.velocity = VelocityField::LinearMap { linear_m_s: [0.0; 3], gradient_1_s, about_m: [0.0; 3] };
    let walls = vec![
        plane("front", [0.0; 3], common::TO_Y, Wall::Slip),
        plane("back", [0.0, thick, 0.0], common::TO_MINUS_Y, Wall::Slip),
    ];
    let mut start = scene(vec![drop], walls, 7.6e-3 / 8.0);
    start.actions.clear();
    start.params.insert("pressure".into(), pressure.into());
    let mut run = Run::new(start);
    let before = run.setup.report.energy;
    let mut after = before;
    for _ in 0..8 {
        after = run.step().report.energy;
    }
    let (x, ..) = columns(&run.bytes());
    // Of the area of an ellipse 80 % lies within 0.687 of a semi-axis: (2/π)(q √(1 - q²) + asin q) = 0.8.
    let axis = |k: usize| {
        let mut all: Vec<f64> = x.iter().map(|x| x[k].abs()).collect();
        all.sort_by(f64::total_cmp);
        all[all.len() * 4 / 5] / 0.687
    };
    let left = (after.kinetic_j + after.potential_j) / (before.kinetic_j + before.potential_j);
    println!(
        "{pressure} {over}: {} particles, {} substeps, axes {} {}, energy {left}",
        x.len(),
        run.substeps,
        axis(0),
        axis(2)
    );
    println!("dissipated {} of {}", after.dissipated_j, before.kinetic_j);
    ([axis(0), axis(2)], left)
}

#[test]
fn a_drop_is_squeezed_to_the_length_of_the_ellipse() {
    let (axes, left) = squeezed(20.0, "wcsph", 0.0);
    // The catalogue's gate for the axes. What viscosity does not take is not gained.
    assert!((axes[1] / LONG - 1.0).abs() < 0.01, "{axes:?}");
    assert!(left < 1.0, "{left}");
}

#[test]
fn a_drop_off_its_lattice_keeps_its_area_better() {
    for pressure in ["dfsph", "wcsph"] {
        let off = squeezed(20.0, pressure, SHAKEN).0[0] * LONG - 1.0;
        println!("{pressure}: short axis off by {off}");
        // In rows, without anything that makes them buckle, 15 and 18 % are added. The catalogue's hundredth, for 60 particles
        // over the radius, would be 3 % at 20 in proportion to the spacing; twice that.
        assert!(off.abs() < 0.06, "{pressure}: {off}");
    }
}

#[test]
#[ignore = "not met: with 40 particles over the radius the short axis is 0.5 % too long (dfsph 4 %), but 6 % of the energy is lost (dfsph 0.4 %), most to the sound with which the pressure of the start is built"]
fn a_drop_keeps_its_area_and_its_energy() {
    let (axes, left) = squeezed(40.0, "wcsph", SHAKEN);
    // The catalogue's gates.
    assert!((axes[0] * LONG - 1.0).abs() < 0.01 && (left - 1.0).abs() < 0.01, "{axes:?} {left}");
}
