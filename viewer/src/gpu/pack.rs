//! Gaussians and views as the shaders read them.

use rayon::prelude::*;

use crate::camera::View;
use crate::gaussians::Gaussians;
use crate::layers::Next;
use crate::render::Options;

/// Numbers of one Gaussian.
const EACH: usize = 20;
/// The logit of what is not drawn.
const UNSEEN: f32 = -80.0;
/// Logarithms of scales beyond this are held: single precision could not hold their squares.
const LARGEST: f32 = 40.0;

/// Five times four numbers a Gaussian: from the eye and logit; rotation of length one; logarithms of scales; base band;
/// from the next eye. Differences from eyes are made in double precision, so that nothing is lost far from the origin.
pub(super) fn shapes(set: &Gaussians<'_>, view: &View, next: Option<(&[[f32; 3]], &View)>) -> Vec<f32> {
    let mut all = vec![0.0_f32; EACH * set.positions.len()];
    all.par_chunks_mut(EACH).enumerate().for_each(|(i, shape)| {
        let from = |p: [f32; 3], eye: [f64; 3]| [0, 1, 2].map(|k| (f64::from(p[k]) - eye[k]) as f32);
        let from_eye = from(set.positions[i], view.eye);
        let scales = set.log_scales[i];
        let is_seen = from_eye.iter().chain(&scales).all(|v| v.is_finite()) && !set.opacity_logits[i].is_nan();
        if !is_seen {
            shape[3] = UNSEEN;
            return;
        }
        shape[..3].copy_from_slice(&from_eye);
        shape[3] = set.opacity_logits[i].clamp(UNSEEN, -UNSEEN);
        shape[4..8].copy_from_slice(&unit(set.rotations[i]));
        shape[8..11].copy_from_slice(&scales.map(|s| s.clamp(-LARGEST, LARGEST)));
        shape[12..15].copy_from_slice(&set.sh_dc[i].map(|c| if c.is_finite() { c } else { 0.0 }));
        if let Some((positions, next_view)) = next {
            shape[16..19].copy_from_slice(&from(positions[i], next_view.eye));
        }
    });
    all
}

/// A quaternion of length one; no rotation for one of length zero or none.
fn unit(q: [f32; 4]) -> [f32; 4] {
    let norm = q.iter().map(|&v| f64::from(v).powi(2)).sum::<f64>().sqrt();
    if norm > 0.0 && norm.is_finite() { q.map(|v| (f64::from(v) / norm) as f32) } else { [1.0, 0.0, 0.0, 0.0] }
}

/// The numbers of one set: `struct Group` of `project.wgsl`.
pub(super) fn group(
    set: &Gaussians<'_>,
    [first, object]: [u32; 2],
    view: &View,
    options: &Options,
    next: Option<&Next<'_>>,
    has_features: bool,
) -> Vec<u32> {
    let next_view = next.map_or(view, |next| &next.view);
    let rows = |view: &View| view.rows.into_iter().flat_map(|[x, y, z]| [x, y, z, 0.0]).collect::<Vec<f64>>();
    let lens = |view: &View| [view.width as f64, view.height as f64, view.focal, options.near];
    let numbers = rows(view).into_iter().chain(rows(next_view)).chain(lens(view)).chain(lens(next_view));
    let numbers = numbers.chain([options.dilation, options.kernel_floor, 0.0, 0.0]);
    let mut words: Vec<u32> = numbers.map(|v| (v as f32).to_bits()).collect();
    let sizes = [first, set.positions.len() as u32, set.coefficients() as u32, object];
    words.extend(sizes);
    words.extend([set.antialiased, has_features, next.is_some(), false].map(u32::from));
    words
}
