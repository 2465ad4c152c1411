//! A light sheet below a liquid: what a lagged exchange makes of energy.

#[cfg(test)]
mod common;

use common::{Run, liquid, meets, scene, tank, water};
use cosplat_core::boundary::{BoundaryState, Impulses, SampleStatics, Samples};
use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{Inputs, PartnerInput, PartnerSetup};
use cosplat_core::scene::{MotionRule, Wall};

/// Spacing \[m\], particles across and upwards.
const D: f64 = 0.02;
const ACROSS: usize = 8;
const UP: usize = 10;
/// Sound \[m/s\] and viscosity \[Pa s\] of the published mud, with the viscosity of the scenes that pour it.
const SOUND: f64 = 20.5;
const VISCOSITY: f64 = 10.0;
/// Spring below each square metre of the sheet \[N/m³\]: the liquid at rest presses it down by half a spacing.
const SPRING: f64 = 1000.0 * 9.81 * D * UP as f64 / (0.5 * D);

/// Largest `E + dissipated - supplied` over what there was at the start, where a sheet of `areal` \[kg/m²\], whose samples move
/// up and down on springs, bears a liquid for half a second of windows of `window` \[s\].
fn most(areal: f64, window: f64) -> f64 {
    let side = ACROSS as f64 * D;
    let body =
        liquid(water(SOUND, VISCOSITY), [side, side, UP as f64 * D], [0.5 * side, 0.5 * side, 0.5 * UP as f64 * D], D);
    let mut walls = tank(side, side, Wall::Slip);
    walls.remove(0);
    let mut start = scene(vec![body], walls, window);
    start.interfaces.push(meets("sheet", BoundaryForm::SamplesF64 { normals: true }, None, 0.3));
    let count = ACROSS * ACROSS;
    let mass = areal * D * D;
    let statics = SampleStatics {
        area_m2: vec![D * D; count],
        volume_m3: vec![1e-3 * D * D; count],
        ..SampleStatics::equal(count, mass)
    };
    let mut run = Run::with(start, &[PartnerSetup { interface: 0, statics }]);
    let (mut lift, mut v) = (vec![0.0; count], vec![0.0; count]);
    let energy = |lift: &[f64], v: &[f64]| {
        let spring = SPRING * D * D;
        lift.iter().zip(v).map(|(z, v)| 0.5 * mass * v * v + 0.5 * spring * z * z + mass * 9.81 * z).sum::<f64>()
    };
    let first = run.setup.report.energy;
    let before = first.kinetic_j + first.potential_j;
    let mut most = 0.0_f64;
    while run.time() < 0.5 {
        let place = |i: usize| [(i / ACROSS) as f64 + 0.5, (i % ACROSS) as f64 + 0.5].map(|k| k * D);
        let shown = Samples {
            position: (0..count).map(|i| [place(i)[0], place(i)[1], lift[i] - 0.5 * D]).collect(),
            velocity: v.iter().map(|&v| [0.0, 0.0, v]).collect(),
            normal: vec![[0.0, 0.0, 1.0]; count],
        };
        let now = BoundaryState::Samples(shown);
        let partner = PartnerInput { interface: 0, rule: MotionRule::Hold, now, next: None, length_s: window };
        let out = run.step_with(&Inputs { partners: vec![partner], impulses: Vec::new() });
        let Impulses::Samples(each) = &out.impulses[0].1 else { panic!("samples") };
        for ((z, v), j) in lift.iter_mut().zip(&mut v).zip(each) {
            *v += (j[2] - (SPRING * D * D * *z + mass * 9.81) * window) / mass;
            *z += *v * window;
        }
        let energy = out.report.energy.kinetic_j + out.report.energy.potential_j + energy(&lift, &v);
        most = most.max((energy + out.report.energy.dissipated_j - out.report.supplied_j) / before);
    }
    println!("{areal} kg/m², windows of {window:.3e} s: at most {most} of the start");
    most
}

#[test]
fn a_light_sheet_gives_back_no_more_than_it_took() {
    // A sheet as light as a leaf, 4 mm of a plant of 700 kg/m³, and a cloth, with 1 and 2 times the root of the plan's bound,
    // of which that takes three quarters and at 2.9 of which a leapfrog ends.
    for (areal, share) in [(2.8, 1.0), (1.0, 1.0), (2.8, 2.0), (1.0, 2.0)] {
        let window = share * (areal * D / (1000.0 * SOUND * SOUND)).sqrt();
        let most = most(areal, window);
        assert!(most < 1.0 + 1e-3, "{most}");
    }
}
