//! Small scenes.

use cosplat_viewer::{Camera, Gaussians, View};

/// An owned set, without higher bands.
#[derive(Clone, Default)]
pub(crate) struct Set {
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) rotations: Vec<[f32; 4]>,
    pub(crate) log_scales: Vec<[f32; 3]>,
    pub(crate) logits: Vec<f32>,
    pub(crate) dc: Vec<[f32; 3]>,
}

impl Set {
    pub(crate) fn push(&mut self, position: [f32; 3], sigma: [f32; 3], opacity: f32, colour: [f32; 3]) {
        self.positions.push(position);
        self.rotations.push([1.0, 0.0, 0.0, 0.0]);
        self.log_scales.push(sigma.map(f32::ln));
        self.logits.push((opacity / (1.0 - opacity)).ln());
        self.dc.push(colour.map(|c| (c - 0.5) / 0.282_094_8));
    }

    pub(crate) fn view(&self) -> Gaussians<'_> {
        Gaussians {
            positions: &self.positions,
            rotations: &self.rotations,
            log_scales: &self.log_scales,
            opacity_logits: &self.logits,
            sh_dc: &self.dc,
            sh_rest: &[],
            sh_degree: 0,
            antialiased: false,
        }
    }
}

/// From the origin along +z, y down, focal length 100 pixels at a height of 100.
pub(crate) fn camera(width: usize, height: usize) -> View {
    let fov_y_deg = 2.0 * (height as f64 / 200.0).atan().to_degrees();
    let up = [0.0, -1.0, 0.0];
    Camera { eye: [0.0; 3], target: [0.0, 0.0, 1.0], up, fov_y_deg, width, height }.view().expect("the camera sees")
}

/// Many Gaussians in front of the camera.
pub(crate) fn crowd(count: u64, seed: u64) -> Set {
    let mut state = seed | 1;
    let mut random = move |lower: f32, upper: f32| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        lower + (upper - lower) * ((state >> 40) as f32 / (1 << 24) as f32)
    };
    let mut set = Set::default();
    for _ in 0..count {
        let p = [random(-1.5, 1.5), random(-1.0, 1.0), random(-0.5, 3.0)];
        let s = [0; 3].map(|_| random(-6.0, -2.0).exp());
        set.push(p, s, random(0.01, 0.99), [0; 3].map(|_| random(0.0, 1.0)));
        let last = set.rotations.len() - 1;
        set.rotations[last] = [0; 4].map(|_| random(-1.0, 1.0));
    }
    set
}
