//! Removing what is no part of an object.

use std::fmt;

use crate::linalg::{rotation_of, wide};
use crate::splats::Splats;

/// A box: everything, or turned by a rotation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Box3 {
    /// Centre, in units of the splats.
    pub centre: [f64; 3],
    /// Half of each edge.
    pub half: [f64; 3],
    /// Quaternion w, x, y, z from the axes of the box to those of the splats.
    pub rotation: [f32; 4],
}

impl Box3 {
    /// A box along the axes.
    pub fn from_corners(lower: [f64; 3], upper: [f64; 3]) -> Box3 {
        let centre = [0, 1, 2].map(|k| f64::midpoint(lower[k], upper[k]));
        let half = [0, 1, 2].map(|k| (upper[k] - lower[k]) / 2.0);
        Box3 { centre, half, rotation: [1.0, 0.0, 0.0, 0.0] }
    }

    /// Whether a point lies inside or on the boundary.
    pub fn contains(&self, point: [f32; 3]) -> bool {
        let local = rotation_of(self.rotation).transpose() * (wide(point) - nalgebra::Vector3::from(self.centre));
        local.iter().zip(self.half).all(|(v, h)| v.abs() <= h)
    }
}

/// What stays. Gaussians with a number that is not finite never stay.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rules {
    /// Smallest opacity, 0 to 1. The default, 1/255, is what a picture of 8 bits can show.
    pub opacity: f64,
    /// Only centres inside this box.
    pub inside: Option<Box3>,
    /// Largest standard deviation, in units of the splats.
    pub largest_sigma: Option<f64>,
}

impl Default for Rules {
    fn default() -> Rules {
        Rules { opacity: 1.0 / 255.0, inside: None, largest_sigma: None }
    }
}

/// How many were removed and why; a Gaussian counts under the first reason that applies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// Gaussians before.
    pub total: usize,
    /// Gaussians after.
    pub kept: usize,
    /// Some number was not finite.
    pub non_finite: usize,
    /// More transparent than asked.
    pub faint: usize,
    /// Outside the box.
    pub outside: usize,
    /// Larger than asked.
    pub large: usize,
    /// Kept, with a quaternion of zero, which is taken as identity.
    pub zero_rotation: usize,
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Report { total, kept, non_finite, faint, outside, large, zero_rotation } = self;
        write!(
            f,
            "{kept} of {total} Gaussians kept; removed: {non_finite} not finite, {faint} faint, {outside} outside, "
        )?;
        write!(f, "{large} large; {zero_rotation} kept without a rotation")
    }
}

/// Indices of the Gaussians that stay, in order, and the count; [`Splats::select`] makes the set.
pub fn clean(splats: &Splats, rules: &Rules) -> (Vec<u32>, Report) {
    let mut report = Report { total: splats.len(), ..Report::default() };
    let mut kept = Vec::new();
    for i in 0..splats.len() {
        let removed = if !is_finite(splats, i) {
            &mut report.non_finite
        } else if splats.opacity(i) < rules.opacity {
            &mut report.faint
        } else if rules.inside.is_some_and(|b| !b.contains(splats.positions[i])) {
            &mut report.outside
        } else if rules.largest_sigma.is_some_and(|limit| splats.scales(i).iter().any(|&s| s > limit)) {
            &mut report.large
        } else {
            report.zero_rotation += usize::from(splats.rotations[i].iter().all(|v| *v == 0.0));
            kept.push(i as u32);
            continue;
        };
        *removed += 1;
    }
    report.kept = kept.len();
    (kept, report)
}

fn is_finite(splats: &Splats, i: usize) -> bool {
    let three = |v: &[f32; 3]| v.iter().all(|c| c.is_finite());
    three(&splats.positions[i])
        && splats.rotations[i].iter().all(|c| c.is_finite())
        && three(&splats.log_scales[i])
        && splats.scales(i).iter().all(|s| s.is_finite())
        && !splats.opacity_logits[i].is_nan()
        && three(&splats.sh_dc[i])
        && splats.rest(i).iter().all(three)
}
