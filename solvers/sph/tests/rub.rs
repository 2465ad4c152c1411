//! Friction with samples that tremble within a window, or are so light that the friction of one would throw them.

#[cfg(test)]
mod common;

use common::{Run, liquid, meets, scene, water};
use cosplat_core::boundary::{BoundaryState, Impulses, SampleStatics, Samples};
use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{Inputs, PartnerInput, PartnerSetup, Plugin};
use cosplat_core::scene::MotionRule;

/// Spacing \[m\], particles across and upwards.
const D: f64 = 0.02;
const ACROSS: usize = 8;
const UP: usize = 4;
const SAMPLES: usize = ACROSS * ACROSS;

/// A block of mud at rest on a sheet, whose samples move sideways on springs.
struct Sheet {
    run: Run,
    window: f64,
    mass: f64,
    frequency: f64,
    /// Ways \[m\] and velocities \[m/s\].
    way: Vec<f64>,
    v: Vec<f64>,
}

impl Sheet {
    /// Below a liquid of that speed of sound \[m/s\], a sheet of `areal` \[kg/m²\] with springs of that angular frequency \[rad/s\], which moves with 0.1 m/s.
    fn new(sound: f64, areal: f64, frequency: f64, window: f64) -> Self {
        let size = [ACROSS, ACROSS, UP].map(|n| n as f64 * D);
        let body = liquid(water(sound, 10.0), size, size.map(|s| 0.5 * s), D);
        let mut start = scene(vec![body], Vec::new(), window);
        start.actions.clear();
        start.interfaces.push(meets("sheet", BoundaryForm::SamplesF64 { normals: true }, None, 0.3));
        let mass = areal * D * D;
        let statics = SampleStatics {
            area_m2: vec![D * D; SAMPLES],
            volume_m3: vec![1e-3 * D * D; SAMPLES],
            ..SampleStatics::equal(SAMPLES, mass)
        };
        let run = Run::with(start, &[PartnerSetup { interface: 0, statics }]);
        Self { run, window, mass, frequency, way: vec![0.0; SAMPLES], v: vec![0.1; SAMPLES] }
    }

    /// One window; kinetic and potential energy and what was dissipated \[J\] after it.
    fn step(&mut self) -> [f64; 2] {
        let across = |n: usize| (n as f64 + 0.5) * D;
        let shown = Samples {
            position: (0..SAMPLES).map(|i| [across(i / ACROSS) + self.way[i], across(i % ACROSS), -0.5 * D]).collect(),
            velocity: self.v.iter().map(|&v| [v, 0.0, 0.0]).collect(),
            normal: vec![[0.0, 0.0, 1.0]; SAMPLES],
        };
        let now = BoundaryState::Samples(shown);
        let partner = PartnerInput { interface: 0, rule: MotionRule::Hold, now, next: None, length_s: self.window };
        let out = self.run.step_with(&Inputs { partners: vec![partner], impulses: Vec::new() });
        let Impulses::Samples(each) = &out.impulses[0].1 else { panic!("samples") };
        let (stiff, angle) = (self.mass * self.frequency * self.frequency, self.frequency * self.window);
        for ((x, v), j) in self.way.iter_mut().zip(&mut self.v).zip(each) {
            // A steady force and a spring, or a steady force alone, exactly.
            let force = j[0] / self.window;
            if stiff > 0.0 {
                let from = *x - force / stiff;
                let to = from * angle.cos() + *v / self.frequency * angle.sin();
                *v = *v * angle.cos() - from * self.frequency * angle.sin();
                *x = to + force / stiff;
            } else {
                *x += (*v + 0.5 * j[0] / self.mass) * self.window;
                *v += j[0] / self.mass;
            }
        }
        let own: f64 = self.way.iter().zip(&self.v).map(|(x, v)| 0.5 * self.mass * v * v + 0.5 * stiff * x * x).sum();
        let energy = out.report.energy;
        [own + energy.kinetic_j + energy.potential_j, energy.dissipated_j]
    }

    /// Energy at the start \[J\].
    fn first(&self) -> f64 {
        0.5 * self.mass * 0.01 * SAMPLES as f64
    }
}

#[test]
fn what_a_trembling_sheet_loses_is_booked_once() {
    for angle in [0.2, 1.0, 2.0] {
        let window = 1e-4;
        let mut sheet = Sheet::new(20.5, 2.8, angle / window, window);
        let (first, mut last) = (sheet.first(), [0.0; 2]);
        for _ in 0..1000 {
            last = sheet.step();
        }
        let [left, lost] = last.map(|e| e / first);
        println!("{angle} a window: {left} left, {lost} lost");
        assert!(left < 0.1, "it comes to rest: {left}");
        // By the velocities shown at the start of windows 2.2 times as much would be booked at two radians a window.
        assert!((left + lost - 1.0).abs() < 2e-3, "{left} {lost}");
    }
}

#[test]
fn a_sheet_too_light_for_its_window_is_stopped_and_not_thrown() {
    // Friction alone would throw it about forty times as fast the other way. The liquid is so soft that its pressures do not.
    let mut sheet = Sheet::new(0.5, 0.02, 0.0, 5e-4);
    let first = sheet.first();
    for n in 0..40 {
        let [left, lost] = sheet.step();
        let fastest = sheet.v.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        if n % 10 == 0 {
            println!("{n}: {left} J of {first}, {lost} lost, fastest {fastest} m/s");
        }
        assert!(left <= first && fastest <= 0.1, "{n}: {left} J of {first}, {fastest} m/s");
    }
}

#[test]
fn a_restored_run_settles_the_same_friction() {
    let mut sheet = Sheet::new(20.5, 2.8, 1e4, 1e-4);
    for _ in 0..20 {
        sheet.step();
    }
    let (saved, window, way, v) = (sheet.run.bytes(), sheet.run.window, sheet.way.clone(), sheet.v.clone());
    let played = |sheet: &mut Sheet| (0..5).map(|_| sheet.step()).last();
    let first = (played(&mut sheet), sheet.run.bytes());
    let mut fresh = Sheet::new(20.5, 2.8, 1e4, 1e-4);
    fresh.run.plugin.restore(&saved).expect("it fits");
    (fresh.run.window, fresh.way, fresh.v) = (window, way, v);
    let again = (played(&mut fresh), fresh.run.bytes());
    assert!(first == again);
    assert!(fresh.run.plugin.restore(&saved[..saved.len() - 8]).is_err());
}
