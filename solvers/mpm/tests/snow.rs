//! Snow: a ball that breaks, one that packs, energy.

use crate::common::{Run, UPRIGHT, body, gravity, moving, plane, scene};
use cosplat_core::scene::{Material, Source, Wall};

fn snow(hardening: f64) -> Material {
    Material::Snow {
        density_kg_m3: 400.0,
        youngs_modulus_pa: 1.4e5,
        poissons_ratio: 0.2,
        critical_compression: 2.5e-2,
        critical_stretch: 7.5e-3,
        hardening,
    }
}

/// A ball of 0.1 m radius dropped at that speed: height of what lies on the floor, and its width.
fn dropped(speed: f64, hardening: f64) -> [f64; 2] {
    let ball = body("ball", snow(hardening), Source::Sphere { radius_m: 0.1 }, [0.0, 0.0, 0.105], 0.0125);
    let mut start = scene(vec![moving(ball, [0.0, 0.0, -speed], [0.0; 3])], 0.01);
    let floor = Wall::Friction { static_friction: 0.5, kinetic_friction: 0.5 };
    start.statics = vec![plane("floor", [0.0; 3], UPRIGHT, floor)];
    start.actions = vec![gravity(-9.81)];
    let mut run = Run::<f32>::new(start);
    let total = |e: &cosplat_core::plugin::Energy| e.kinetic_j + e.potential_j;
    let first = total(&run.setup.report.energy);
    let mut dissipated = 0.0;
    for _ in 0..40 {
        let report = run.step().report;
        assert!(total(&report.energy) <= first * (1.0 + 1e-3), "{} of {first}", total(&report.energy));
        assert!(report.energy.dissipated_j >= dissipated - 1e-3 * first, "{}", report.energy.dissipated_j);
        dissipated = report.energy.dissipated_j;
    }
    let places = run.particles("ball");
    let most = |k: usize| places.iter().map(|p| p[k]).fold(f64::NEG_INFINITY, f64::max);
    println!("{speed} m/s, ξ = {hardening}: {} high, {} wide, lost {dissipated} of {first} J", most(2), most(0));
    [most(2), most(0)]
}

#[test]
fn a_faster_ball_is_flatter_and_hardening_holds_it_up() {
    let (slow, fast, soft) = (dropped(1.0, 10.0), dropped(5.0, 10.0), dropped(5.0, 0.0));
    assert!(fast[0] < slow[0] && fast[0] > soft[0], "{slow:?} {fast:?} {soft:?}");
}
