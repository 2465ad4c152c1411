//! Colours of surfaces that no camera saw: grain and daylight.

use nalgebra::Vector3;

use super::{Sample, surfels};
use crate::bind::Frame;
use crate::output::OutputFrame;
use crate::splats::Splats;

/// Wavelengths of the grain, in units of the root of a sample's area, and the share of each; single samples have the
/// rest.
const GRAIN: [(f64, f64); 2] = [(12.0, 0.45), (4.0, 0.3)];

/// One lamp at infinity and light from everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Direction towards the lamp in the world, of any length but zero.
    pub towards: [f64; 3],
    /// Share of the light that comes from everywhere, 0 to 1.
    pub ambient: f64,
}

impl Light {
    /// Towards the lamp, of length one; zero where it has no direction.
    pub(super) fn direction(&self) -> Vector3<f64> {
        Vector3::from(self.towards).try_normalize(0.0).unwrap_or_else(Vector3::zeros)
    }

    /// Share of the light that a surface sends back by Lambert's law, from the cosine to the lamp.
    pub(super) fn share(&self, cosine: f64) -> f64 {
        self.ambient + (1.0 - self.ambient) * cosine.max(0.0)
    }
}

impl Default for Light {
    /// High, from the front left; captures are mostly taken in soft light, so half of it is ambient.
    fn default() -> Light {
        Light { towards: [-0.4, -0.5, 0.77], ambient: 0.5 }
    }
}

/// Samples of one colour with grain: linear red, green, blue from 0 to 1, and by what part of it a sample may be lighter
/// or darker. The same samples get the same grain in every run.
pub fn grained(
    positions_m: &[[f64; 3]],
    normals: &[[f64; 3]],
    areas_m2: &[f64],
    linear: [f64; 3],
    grain: f64,
) -> Vec<Sample> {
    let one = |((p, n), a): ((&[f64; 3], &[f64; 3]), &f64)| {
        let factor = (1.0 + grain * noise(*p, a.max(f64::MIN_POSITIVE).sqrt())).max(0.0);
        Sample {
            position: p.map(|v| v as f32),
            normal: n.map(|v| v as f32),
            area: *a as f32,
            colour: linear.map(|c| display_of_linear(c * factor) as f32),
        }
    };
    positions_m.iter().zip(normals).zip(areas_m2).map(one).collect()
}

/// The surface of a body at a pose, lit in the world by Lambert's law and shown in a frame.
pub fn lit(samples: &[Sample], pose: &Frame, light: &Light, frame: &OutputFrame) -> Splats {
    let towards = Vector3::from(light.towards).try_normalize(0.0).unwrap_or_else(Vector3::zeros);
    let shade = |s: &Sample| {
        let normal = Vector3::from(s.normal.map(f64::from)).try_normalize(0.0).unwrap_or_else(Vector3::z);
        let facing = (pose.rotation * normal).dot(&towards).max(0.0);
        let share = light.ambient + (1.0 - light.ambient) * facing;
        Sample { colour: s.colour.map(|c| display_of_linear(linear_of_display(f64::from(c)) * share) as f32), ..*s }
    };
    let shaded: Vec<Sample> = samples.iter().map(shade).collect();
    let mut splats = surfels(&shaded);
    frame.place(&mut splats, pose);
    splats
}

/// Display value of a linear one, IEC 61966-2-1.
pub fn display_of_linear(linear: f64) -> f64 {
    let c = linear.clamp(0.0, 1.0);
    if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 }
}

/// Linear value of a display one, IEC 61966-2-1.
pub fn linear_of_display(display: f64) -> f64 {
    let c = display.clamp(0.0, 1.0);
    if c <= 0.040_45 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

/// −1 to 1, smooth over the wavelengths of [`GRAIN`].
fn noise(p: [f64; 3], width: f64) -> f64 {
    let mut sum = 0.0;
    let mut rest = 1.0;
    for (octave, (wavelength, share)) in GRAIN.into_iter().enumerate() {
        sum += share * lattice(p.map(|v| v / (wavelength * width)), octave as u64);
        rest -= share;
    }
    sum + rest * random(p.map(f64::to_bits), 2)
}

/// Trilinear between random values on the integers.
fn lattice(p: [f64; 3], seed: u64) -> f64 {
    let base = p.map(f64::floor);
    let corner = |n: usize| {
        let (mut weight, mut at) = (1.0, [0_u64; 3]);
        for k in 0..3 {
            let (upper, part) = (n >> k & 1, p[k] - base[k]);
            weight *= if upper == 1 { part } else { 1.0 - part };
            at[k] = (base[k] as i64).cast_unsigned().wrapping_add(upper as u64);
        }
        weight * random(at, seed)
    };
    (0..8).map(corner).sum()
}

/// −1 to 1 from three numbers: the finaliser of `SplitMix64` (Steele, Lea, Flood 2014) over each in turn.
fn random(at: [u64; 3], seed: u64) -> f64 {
    let mut state = seed;
    for v in at {
        state = state.wrapping_add(v).wrapping_add(0x9e37_79b9_7f4a_7c15);
        state = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        state = (state ^ (state >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        state ^= state >> 31;
    }
    (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}
