//! Contact with a deformable body of another process: its samples are met, and take the impulses.

use crate::common::pair::{Pair, given};
use crate::common::{Run, body, cuboid, elastic, gravity, moving, plane, scene};
use cosplat_core::boundary::norm;
use cosplat_core::plugin::{Outputs, Report, SolverScene};
use cosplat_core::scene::{Body, Material, Source, Wall};
use cosplat_mpm::Real;

const D: f64 = 0.02;

fn one(body: Body, window: f64) -> SolverScene {
    scene(vec![body], window)
}

fn energy(report: &Report) -> f64 {
    report.energy.kinetic_j + report.energy.potential_j
}

/// A block and a ball that fly into each other beside their middles.
fn flying() -> [Body; 2] {
    let a = body("a", elastic(500.0, 1e5, 0.3), cuboid([0.16; 3]), [0.0; 3], D);
    let b = body("b", elastic(500.0, 1e5, 0.2), Source::Sphere { radius_m: 0.09 }, [0.26, 0.05, 0.01], D);
    [moving(a, [1.0, 0.0, 0.0], [0.0; 3]), moving(b, [-1.0, 0.1, 0.0], [0.0, 0.0, 2.0])]
}

fn collide<R: Real>(window: f64, mut each: impl FnMut(&Pair<R>, &[Outputs; 2])) {
    let [a, b] = flying();
    let mut pair = Pair::<R>::new(one(a, window), one(b, window), 0.5);
    for _ in 0..(0.12 / window) as u64 {
        let outputs = pair.step();
        each(&pair, &outputs);
    }
}

#[test]
fn a_collision_keeps_momentum_and_makes_no_energy() {
    let mut together = Run::<f64>::new(scene(flying().into(), 1e-3));
    let first = energy(&together.setup.report);
    let start = together.momentum;
    (0..120).for_each(|_| drop(together.step()));
    let expected = energy(&together.step().report) / first;
    // The plan takes 1.4 spacings of the wave in the block, 1.7 ms, at most.
    for (window, most) in [(1.6e-3, 0.25), (4e-4, 0.1)] {
        let (mut drift, mut highest, mut last, mut gross) = ([0.0_f64; 2], 0.0_f64, 0.0, 0.0);
        let mut closure = 0.0_f64;
        collide::<f64>(window, |pair, outputs| {
            let now = pair.resolver.momentum.plus(pair.responder.momentum).minus(start);
            drift = [drift[0].max(norm(now.linear)), drift[1].max(norm(now.angular))];
            last = (energy(&outputs[0].report) + energy(&outputs[1].report)) / first;
            highest = highest.max(last);
            gross = pair.resolver.gross + pair.responder.gross;
            closure = [pair.resolver.defect, pair.responder.defect].into_iter().flatten().fold(closure, f64::max);
        });
        println!(
            "W {window}: energy {last:.3}, in one process {expected:.3}; drift {drift:?} of {gross}, {closure:.1e}"
        );
        // Sums of some thousand doubles over some hundred substeps.
        assert!(drift[0] < 1e-13 * gross && closure < 1e-13 * gross, "{drift:?} {closure}");
        // Samples move on while they take their impulses, by 0.2 spacings a window and otherwise than foreseen by less:
        // a tenth of that lever, and friction of half the force, would be 2e-4 of the momentum.
        assert!(drift[1] < 1e-4 * gross, "{drift:?}");
        // The aim is 1e-3; in flight the explicit steps let the energy of the turning ball swing by less than 1e-7.
        assert!(highest <= 1.0 + 1e-7, "{highest}");
        // Who meets on the grid meets up to half a cell early, and both lose the waves that a grid cannot carry.
        assert!((last - expected).abs() < most, "{last} {expected}");
    }
    let mut last = 0.0;
    collide::<f32>(1e-3, |pair, _| {
        let gross = pair.resolver.gross + pair.responder.gross;
        let now = pair.resolver.momentum.plus(pair.responder.momentum).minus(start);
        // Roundings of 6e-8 in a hundred substeps, as the square root of their number.
        assert!(norm(now.linear) < 1e-6 * gross, "{now:?}");
        last = pair.resolver.momentum.linear[0];
    });
    assert!(last < 0.0, "the block was thrown back: {last}");
}

/// What a block does that rests on another one: mean force over weight, largest one aside, and the distance of the two
/// surfaces' particles, in spacings, at half time and in the end.
fn rest(spring: [f64; 2], aside: f64, window: f64) -> [f64; 4] {
    let side = 0.16;
    let block = |name: &str, youngs_modulus_pa: f64, x: f64, z: f64| {
        // Swings of some 10 Hz die away in the first half.
        let viscosity_pa_s = 100.0;
        let material =
            Material::Elastic { density_kg_m3: 500.0, youngs_modulus_pa, poissons_ratio: 0.3, viscosity_pa_s };
        let mut start = one(body(name, material, cuboid([side; 3]), [x, x, z * side], D), window);
        start.actions.push(gravity(-9.81));
        start
    };
    let (top, mut under) = (block("top", spring[0], aside, 1.5), block("under", spring[1], 0.0, 0.5));
    under.statics = vec![plane("floor", [0.0; 3], crate::common::UPRIGHT, Wall::Slip)];
    let mut pair = Pair::<f32>::new(top, under, 0.5);
    let weight = 500.0 * side.powi(3) * 9.81 * window;
    let inside = |x: &&[f64; 3]| (x[0] - 0.5 * aside).abs() < 0.05 && (x[1] - 0.5 * aside).abs() < 0.05;
    let windows = (0.8 / window) as u64;
    let (mut sum, mut across, mut gaps) = (0.0, 0.0_f64, [0.0; 2]);
    for n in 1..=windows {
        let [out, _] = pair.step();
        let [x, y, z] = given(&out);
        if 2 * n > windows {
            (sum, across) = (sum - z / weight, across.max(x.hypot(y) / weight));
        }
        if 2 * n == windows || n == windows {
            let top = pair.resolver.particles("top");
            let low = top.iter().filter(inside).map(|x| x[2]).fold(f64::INFINITY, f64::min);
            let high = pair.shown.position.iter().filter(inside).map(|x| x[2]).fold(0.0, f64::max);
            gaps[usize::from(n == windows)] = (low - high) / D;
        }
    }
    [sum / (windows - windows / 2) as f64, across, gaps[0], gaps[1]]
}

#[test]
fn a_block_rests_on_another() {
    for (spring, aside, window) in
        [([1e5, 1e5], 0.0, 1.6e-3), ([1e5, 1e5], 0.5, 4e-4), ([5e4, 2e5], 0.25, 1e-3), ([5e4, 5e6], 0.25, 1e-3)]
    {
        let [force, across, then, now] = rest(spring, aside * D, window);
        println!("{spring:?} {aside} W {window}: weight {force:.4}, aside {across:.3}, distance {then:.4} {now:.4}");
        assert!((force - 1.0).abs() < 0.02, "the published aim is 2 % of the weight: {force}");
        assert!(across < 0.05, "{across}");
        // It sinks no further; what still swings is 4 % of a load that strains a layer by 1 %.
        assert!((now - then).abs() < 0.02, "{then} {now}");
        // One spacing, less the strain and, where rims bulge beside what rests on them, some hundredths.
        assert!(now > 0.9 && now < 1.0, "{now}");
    }
}

/// Case C5: a bar runs end on into another one of impedance `ratio` times its own. What is left of its speed when the wave
/// is back from both ends.
fn reflected(ratio: f64) -> f64 {
    let (d, window, speed) = (0.0125, 5e-4, 0.05);
    let bar = |name: &str, factor: f64, z: f64| {
        let material = elastic(1e3 * factor, 1e6 * factor, 0.0);
        body(name, material, cuboid([0.1, 0.1, 1.0]), [0.0, 0.0, z], d)
    };
    let first = moving(bar("first", 1.0, 0.5), [0.0, 0.0, -speed], [0.0; 3]);
    let mut pair = Pair::<f32>::new(one(first, window), one(bar("second", ratio, -0.5), window), 0.0);
    // Through both at 31.6 m/s and back: 63 ms.
    (0..150).for_each(|_| drop(pair.step()));
    pair.resolver.momentum.linear[2] / (10.0 * speed)
}

#[test]
fn a_wave_is_reflected_as_impedances_say() {
    for ratio in [1.0, 2.0, 10.0] {
        let (found, exact) = (reflected(ratio), (ratio - 1.0) / (ratio + 1.0));
        println!("impedance {ratio}: {found:.4}, exact {exact:.4}");
        // The aim of the catalogue, from 20 cells in the pulse on; here 40.
        assert!((found - exact).abs() < 0.03, "{found} {exact}");
    }
}
