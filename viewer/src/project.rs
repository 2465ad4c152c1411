//! From a Gaussian in space to an ellipse in the picture.

use rayon::prelude::*;

use crate::beside::{Beside, Origin};
use crate::camera::View;
use crate::gaussians::Gaussians;
use crate::layers::Next;
use crate::render::Options;
use crate::sh::colour;

/// Smallest opacity that is drawn.
pub(crate) const CUT: f64 = 1.0 / 255.0;
/// Gaussians a task.
const CHUNK: usize = 2048;

/// An ellipse in the picture; pixel i covers i to i + 1.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Ellipse {
    /// Centre, in pixels.
    pub(crate) x: f32,
    pub(crate) y: f32,
    /// Inverse covariance (a b; b c), per pixel².
    pub(crate) a: f32,
    pub(crate) b: f32,
    pub(crate) c: f32,
    pub(crate) opacity: f32,
    /// Squared Mahalanobis distance at which the opacity has fallen to [`CUT`].
    pub(crate) reach: f32,
    /// Distance along the optical axis.
    pub(crate) depth: f32,
    pub(crate) colour: [f32; 3],
    /// First pixel and pixel after the last that it can touch, in x and in y.
    pub(crate) columns: [u16; 2],
    pub(crate) rows: [u16; 2],
}

/// Every visible ellipse, in the order of the Gaussians, and what is gathered beside their colours.
pub(crate) fn project<B: Beside>(
    sets: &[Gaussians<'_>],
    view: &View,
    options: &Options,
    next: Option<&Next<'_>>,
) -> (Vec<Ellipse>, Vec<B::Feature>) {
    let (mut all, mut features) = (Vec::new(), Vec::new());
    for (object, set) in sets.iter().enumerate() {
        let next = next.map(|next| (next.positions[object], &next.view));
        let starts: Vec<usize> = (0..set.positions.len()).step_by(CHUNK).collect();
        let in_chunk = |&start: &usize| {
            let end = set.positions.len().min(start + CHUNK);
            let one = |index| {
                let ellipse = ellipse(set, index, view, options)?;
                let origin = Origin { object: object as u32, set, index, view, next, near: options.near };
                Some((ellipse, B::feature(&origin)))
            };
            (start..end).filter_map(one).collect::<(Vec<_>, Vec<_>)>()
        };
        let chunks: Vec<(Vec<Ellipse>, Vec<B::Feature>)> = starts.par_iter().map(in_chunk).collect();
        all.reserve(chunks.iter().map(|(ellipses, _)| ellipses.len()).sum());
        for (ellipses, beside) in &chunks {
            all.extend_from_slice(ellipses);
            features.extend_from_slice(beside);
        }
    }
    (all, features)
}

/// Where a point in camera axes is in the picture, in pixels.
pub(crate) fn in_picture(view: &View, [x, y, z]: [f64; 3]) -> [f64; 2] {
    [view.focal * x / z + view.width as f64 / 2.0, view.focal * y / z + view.height as f64 / 2.0]
}

/// Rotation matrix of a quaternion w, x, y, z of any length.
pub(crate) fn rotation(q: [f32; 4]) -> [[f64; 3]; 3] {
    let [w, x, y, z] = q.map(f64::from);
    let norm = w * w + x * x + y * y + z * z;
    if norm <= 0.0 || !norm.is_finite() {
        return [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    }
    let s = 2.0 / norm;
    [
        [1.0 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)],
        [s * (x * y + w * z), 1.0 - s * (x * x + z * z), s * (y * z - w * x)],
        [s * (x * z - w * y), s * (y * z + w * x), 1.0 - s * (x * x + y * y)],
    ]
}

/// The ellipse of one Gaussian, if any pixel can see it.
///
/// C = J W Σ Wᵀ Jᵀ + dilation · 1, J the Jacobian of the projection at the centre, held within 1.3 times the picture
/// (Zwicker et al. 2001; Kerbl et al. 2023).
fn ellipse(set: &Gaussians<'_>, i: usize, view: &View, options: &Options) -> Option<Ellipse> {
    let [tx, ty, tz] = view.in_camera(set.positions[i]);
    if !(tz > options.near && tx.is_finite() && ty.is_finite() && tz.is_finite()) {
        return None;
    }
    let mut opacity = 1.0 / (1.0 + (-f64::from(set.opacity_logits[i])).exp());
    let (width, height, focal) = (view.width as f64, view.height as f64, view.focal);
    let held = |t: f64, size: f64| (t / tz).clamp(-1.3 * size / (2.0 * focal), 1.3 * size / (2.0 * focal));
    let (along, up) = (focal / tz, [held(tx, width), held(ty, height)]);
    // Rows of J W.
    let row = |axis: usize| [0, 1, 2].map(|k| along * (view.rows[axis][k] - up[axis] * view.rows[2][k]));
    let (jx, jy) = (row(0), row(1));
    let turn = rotation(set.rotations[i]);
    let scale = set.log_scales[i].map(|s| f64::from(s).exp());
    // J W R S.
    let column = |j: [f64; 3], k: usize| (j[0] * turn[0][k] + j[1] * turn[1][k] + j[2] * turn[2][k]) * scale[k];
    let (u, v) = ([0, 1, 2].map(|k| column(jx, k)), [0, 1, 2].map(|k| column(jy, k)));
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let (plain_xx, xy, plain_yy) = (dot(u, u), dot(u, v), dot(v, v));
    let (xx, yy) = (plain_xx + options.dilation, plain_yy + options.dilation);
    let det = xx * yy - xy * xy;
    if set.antialiased {
        opacity *= ((plain_xx * plain_yy - xy * xy).max(0.0) / det).sqrt();
    }
    // The kernel exp(−½ q) − floor times the opacity is above the cut while q < reach.
    let reach = -2.0 * (options.kernel_floor + CUT / opacity).ln();
    if !(det > 0.0 && det.is_finite() && reach > 0.0) {
        return None;
    }
    let [x, y] = in_picture(view, [tx, ty, tz]);
    let columns = pixels(x, (reach * xx).sqrt(), width)?;
    let rows = pixels(y, (reach * yy).sqrt(), height)?;
    let from_camera = [0, 1, 2].map(|k| f64::from(set.positions[i][k]) - view.eye[k]);
    let k = set.coefficients();
    Some(Ellipse {
        x: x as f32,
        y: y as f32,
        a: (yy / det) as f32,
        b: (-xy / det) as f32,
        c: (xx / det) as f32,
        opacity: opacity as f32,
        reach: reach as f32,
        depth: tz as f32,
        colour: colour(set.sh_dc[i], &set.sh_rest[i * k..(i + 1) * k], from_camera),
        columns,
        rows,
    })
}

/// Pixels whose centres lie within `half` of `centre`.
fn pixels(centre: f64, half: f64, size: f64) -> Option<[u16; 2]> {
    let first = (centre - half - 0.5).ceil().clamp(0.0, size);
    let end = ((centre + half - 0.5).floor() + 1.0).clamp(0.0, size);
    (first < end).then_some([first as u16, end as u16])
}
