//! The exchange with a sheet that vibrates faster than windows follow each other makes no energy.

#[cfg(test)]
mod common;

use common::{Run, ball, meets, scene, sheet, shown};
use cosplat_core::boundary::{BoundaryState, Impulses, SampleStatics, add, dot, scale};
use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{Inputs, PartnerSetup, Plugin};
use cosplat_smoke::Smoke;
use serde_json::json;

/// Length of a window \[s\], and the angle by which springs that hold the samples swing in it.
const WINDOW: f64 = 0.005;
const SWING: f64 = 4.5;
/// Windows.
const COUNT: u32 = 40;

/// A sheet of 0.06 kg/m² in gas at rest, each of its samples on a spring of its own, that begins with 0.3 m/s: its
/// energy at the start and at the end, and the largest energy that the exchange made in a window \[J\].
fn vibrates(at_once: bool) -> ([f64; 2], f64) {
    let params = json!({ "low": [-0.4, -0.4, -0.4], "high": [0.4, 0.4, 0.4], "cell": 0.025 });
    let mut start = scene(ball(1.204, 0.1, [-0.2, 0.0, 0.0], 0.0125), Vec::new(), WINDOW, &params);
    start.interfaces.push(meets(0, "sheet", BoundaryForm::SamplesF64 { normals: false }, None));
    let (area, mass, rate) = (0.015 * 0.015, 0.06 * 0.015 * 0.015, SWING / WINDOW);
    let rest = sheet(20, 0.015, 0.1);
    let statics = SampleStatics { area_m2: vec![area; 400], ..SampleStatics::equal(400, mass) };
    let mut run = Run::with(start, &[PartnerSetup { interface: 0, statics }]);
    let (mut x, mut v) = (vec![[0.0; 3]; 400], vec![[0.3, 0.0, 0.0]; 400]);
    let energy = |x: &[[f64; 3]], v: &[[f64; 3]]| {
        x.iter().zip(v).map(|(x, v)| 0.5 * mass * (rate * rate * dot(*x, *x) + dot(*v, *v))).sum::<f64>()
    };
    let (begin, mut most) = (energy(&x, &v), f64::NEG_INFINITY);
    let (sin, cos) = SWING.sin_cos();
    for _ in 0..COUNT {
        let places: Vec<_> = rest.iter().zip(&x).map(|(r, x)| add(*r, *x)).collect();
        let now = BoundaryState::points(&places, &v);
        let out = run.step_with(&Inputs { partners: vec![shown(0, now, WINDOW)], impulses: Vec::new() });
        let Impulses::Samples(given) = &out.impulses[0].1 else { panic!("samples") };
        let mut work = out.report.interfaces[0].work_j;
        for ((x, v), &j) in x.iter_mut().zip(&mut v).zip(given) {
            // A sudden impulse, or a constant force, which moves the point about which the sample swings.
            let (before, mut about) = ((*x, *v), [0.0; 3]);
            if at_once {
                *v = add(*v, scale(j, 1.0 / mass));
                work += 0.5 * dot(j, add(before.1, *v));
            } else {
                about = scale(j, 1.0 / (WINDOW * mass * rate * rate));
            }
            let off = add(*x, scale(about, -1.0));
            (*x, *v) =
                (add(about, add(scale(off, cos), scale(*v, sin / rate))), add(scale(*v, cos), scale(off, -rate * sin)));
            if !at_once {
                work += dot(scale(j, 1.0 / WINDOW), add(*x, scale(before.0, -1.0)));
            }
        }
        most = most.max(work);
    }
    ([begin, energy(&x, &v)], most)
}

#[test]
fn impulses_taken_at_once_make_no_energy_and_spread_ones_do() {
    let ([begin, sudden], most) = vibrates(true);
    let ([_, spread], made) = vibrates(false);
    println!("{begin} J: at once {sudden} J, at most {most:e} J a window; spread {spread} J, {made:e} J");
    // A sample ends a substep with the gas around it, which is an inelastic impact; to roundings.
    assert!(most < 1e-15 * f64::from(COUNT), "{most:e}");
    assert!(sudden < begin, "{sudden} {begin}");
    // A drag of the velocity at the start of a window, spread over it, multiplies the area of an oscillator's orbit by
    // `1 - sin w / w` where it takes all of the velocity: more than one for swings w from π to 2π.
    assert!(spread > 2.0 * begin && made > 0.0, "{spread} {begin}");
    assert!(Smoke::default().describe().has_feature("sudden-impulses"));
}
