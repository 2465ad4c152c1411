//! Lists of neighbours outlive windows and saved states, and miss nobody.

#[cfg(test)]
mod common;

use common::{Float, Run, columns, liquid, meets, scene, tank, water};
use cosplat_core::boundary::{norm, sub};
use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{Outputs, Plugin};
use cosplat_core::scene::{Source, VelocityField, Wall};

const WINDOW: f64 = 2e-4;
const SIZE: [f64; 3] = [0.06; 3];

/// A block of liquid that flies at a floating box, in windows of one substep.
fn splash() -> (Run, Float) {
    let mut body = liquid(water(20.0, 1.0), [0.2, 0.2, 0.16], [0.1, 0.1, 0.08], 0.02);
    let linear_m_s = [1.0, 0.0, -0.5];
    body.velocity = VelocityField::Twist { linear_m_s, angular_rad_s: [0.0; 3] };
    let mut start = scene(vec![body], tank(0.4, 0.2, Wall::NoSlip), WINDOW);
    start.interfaces.push(meets("box", BoundaryForm::Proxy, Some(Source::Box { size_m: SIZE }), 0.5));
    (Run::new(start), Float::new(0.1, SIZE, [0.24, 0.1, 0.08]))
}

fn step(run: &mut Run, float: &mut Float) -> Outputs {
    let out = run.step_with(&float.inputs(WINDOW));
    float.take(&out, WINDOW);
    out
}

#[test]
fn a_run_restored_between_two_lists_has_the_same_bytes() {
    let (mut run, mut float) = splash();
    let mut made = 0;
    for _ in 0..40 {
        made += step(&mut run, &mut float).report.counters["sorts"];
    }
    println!("lists made {made} times in 40 windows of {} substeps", run.substeps);
    // At 1 m/s a substep is a hundredth of a spacing, the skin √(1.6/100) = 0.13 of them: lists last six substeps, the
    // first, when the pressure waves of the start pass, a little less.
    assert_eq!(run.substeps, 40);
    assert!((4..14).contains(&made), "{made}");
    let (bytes, mut again) = (run.bytes(), splash().0);
    again.plugin.restore(&bytes).expect("its own state");
    again.window = run.window;
    let (mut other, mut same) = (float, 0);
    for _ in 0..20 {
        let kept = step(&mut run, &mut float).report.counters["sorts"] == 0;
        step(&mut again, &mut other);
        assert_eq!(run.hash(), again.hash());
        same += u64::from(kept);
    }
    assert!(same > 10, "{same}");
}

#[test]
fn kept_lists_miss_nobody() {
    // A state whose lists are forgotten before every window is the same motion to rounding: no pair was missed.
    let ((mut run, mut float), (mut fresh, mut other)) = (splash(), splash());
    for _ in 0..40 {
        step(&mut run, &mut float);
        let bytes = fresh.bytes();
        fresh.plugin.restore(&without_lists(&bytes)).expect("a state without lists");
        let made = step(&mut fresh, &mut other).report.counters["sorts"];
        assert_eq!(made, 1);
    }
    let places = |run: &Run| run.particles();
    let off = places(&run).iter().zip(places(&fresh)).map(|(a, b)| norm(sub(*a, b))).fold(0.0, f64::max);
    println!("places differ by {off} m");
    // Rates of densities in another order differ by some 1e-7 of 40/s, so in a substep of 0.2 ms pressures by that of
    // `ρc²` and 0.008: 3e-7 m²/s² over 24 mm for 8 ms are 4e-10 m if all have one sign, and a fiftieth of it as they fall. A
    // missed pair, even one at the rim with a thousandth of a neighbour's force, would move a particle by 1e-9 m.
    assert!(off < 1e-10, "{off}");
}

/// A saved state with the places of its lists left out.
fn without_lists(bytes: &[u8]) -> Vec<u8> {
    let n = columns(bytes).0.len();
    // Identities, places, velocities with their lengths before them, densities, two numbers.
    let lists = 8 + 4 * n + 2 * (8 + 24 * n) + 8 * n + 16;
    // Frictions with samples, of which there are none, two lengths, how many are listed, and the skin.
    let none = [0_u8; 5 * 8];
    [&bytes[..lists], &none].concat()
}
