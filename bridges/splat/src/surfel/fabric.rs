//! Gaussians for cloth: one flat one a vertex, shaped by the triangles around it, so that the sheet is closed however it
//! is stretched or folded.

use nalgebra::{Matrix3, Vector3};

use super::light::{Light, display_of_linear, linear_of_display};
use super::{ACROSS, OPACITY};
use crate::bind::BindError;
use crate::linalg::{perpendicular, quaternion_of};
use crate::output::OutputFrame;
use crate::splats::{Axes, Splats, dc_of_colour, logit_of_opacity};

/// Standard deviation in units of the root mean square of the distance from a vertex to the points of its triangles
/// along the same direction. A third of the area of the triangles is the share of a vertex; a Gaussian of 0.6 times the
/// root of that share, as on other surfaces, is one of 1.2 here: in a diamond of four right triangles of legs h, and in
/// the square of eight, the mean squares are h²/6 and h²/3, and the shares 2h²/3 and 4h²/3.
const ALONG: f64 = 1.2;
/// Least standard deviation along the sheet, in units of the larger one: what is folded to a line keeps a width.
const NARROWEST: f64 = 0.05;

/// What of a cloth does not move.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fabric {
    /// Three vertices each.
    pub triangles: Vec<[u32; 3]>,
    /// Of each vertex: red, green, blue from 0 to 1, display values.
    pub colours: Vec<[f32; 3]>,
}

impl Fabric {
    /// The edges of the triangles, each once, ascending: what ties the surfels to each other (Li et al. 2025,
    /// `WonderPlay`: topological Gaussian surfels).
    pub fn edges(&self) -> Vec<[u32; 2]> {
        let of = |t: &[u32; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
        let mut edges: Vec<[u32; 2]> =
            self.triangles.iter().flat_map(of).map(|[a, b]| [a.min(b), a.max(b)]).filter(|[a, b]| a != b).collect();
        edges.sort_unstable();
        edges.dedup();
        edges
    }
}

/// Sums over the triangles of a vertex.
#[derive(Clone, Copy)]
struct Around {
    /// Twice the area, along the normal.
    normal: Vector3<f64>,
    area: f64,
    /// ∫ x xᵀ dA with x from the vertex.
    moment: Matrix3<f64>,
}

/// One surfel a vertex of any mesh, at these positions \[m\] in the world, in its own colour from every side: what
/// [`fabric`] does for a cloth, without light. With [`Fabric::edges`] these are topological surfels; the vertices are
/// particles of whatever solver moves them, or follow its particles by a [`crate::bind::Binding`].
///
/// # Errors
/// As for [`fabric`].
pub fn topological(positions_m: &[[f64; 3]], mesh: &Fabric, frame: &OutputFrame) -> Result<Splats, BindError> {
    fabric(positions_m, mesh, &Light { ambient: 1.0, ..Light::default() }, frame)
}

/// A cloth with its vertices at these positions \[m\] in the world, seen from both sides and lit by Lambert's law.
///
/// # Errors
/// Not as many positions as colours, or a triangle names a vertex that is not there.
pub fn fabric(
    positions_m: &[[f64; 3]],
    fabric: &Fabric,
    light: &Light,
    frame: &OutputFrame,
) -> Result<Splats, BindError> {
    shaded(positions_m, fabric, &|normal| light.share(normal.dot(&light.direction()).abs()), frame)
}

/// One surfel a vertex; `share` is the part of the light that a place with this normal sends back.
pub(super) fn shaded(
    positions_m: &[[f64; 3]],
    fabric: &Fabric,
    share: &dyn Fn(&Vector3<f64>) -> f64,
    frame: &OutputFrame,
) -> Result<Splats, BindError> {
    let count = positions_m.len();
    if fabric.colours.len() != count {
        return Err(BindError::Length("vertices", fabric.colours.len(), count));
    }
    let around = around(positions_m, &fabric.triangles)?;
    let mut splats = Splats::with_capacity(count, 0);
    splats.axes = Axes::Scene;
    let logit = logit_of_opacity(OPACITY);
    for ((position, own), colour) in positions_m.iter().zip(&around).zip(&fabric.colours) {
        let normal = own.normal.try_normalize(0.0).filter(|n| n.iter().all(|c| c.is_finite()));
        let normal = normal.unwrap_or_else(Vector3::z);
        let (axes, sigmas) = own.shape(&normal);
        let share = share(&normal);
        let lit = colour.map(|c| display_of_linear(linear_of_display(f64::from(c)) * share));
        splats.positions.push(position.map(|v| v as f32));
        splats.rotations.push(quaternion_of(&axes, [1.0, 0.0, 0.0, 0.0]));
        splats.log_scales.push(sigmas.map(|s| s.max(f64::MIN_POSITIVE).ln() as f32));
        splats.opacity_logits.push(logit);
        splats.sh_dc.push(lit.map(dc_of_colour));
    }
    frame.from_world.apply(&mut splats, frame.axes);
    Ok(splats)
}

fn around(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> Result<Vec<Around>, BindError> {
    let none = Around { normal: Vector3::zeros(), area: 0.0, moment: Matrix3::zeros() };
    let mut around = vec![none; positions.len()];
    for (number, triangle) in triangles.iter().enumerate() {
        let mut corners = [Vector3::zeros(); 3];
        for (corner, &i) in corners.iter_mut().zip(triangle) {
            let place = positions.get(i as usize).ok_or(BindError::Index(number, i, positions.len()))?;
            *corner = Vector3::from(*place);
        }
        let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
        let area = normal.norm() / 2.0;
        for k in 0..3 {
            let (a, b) = (corners[(k + 1) % 3] - corners[k], corners[(k + 2) % 3] - corners[k]);
            let own = &mut around[triangle[k] as usize];
            own.normal += normal;
            own.area += area;
            // The mean of x xᵀ over a triangle from its corner, x = s a + t b: ⟨s²⟩ = 1/6 and ⟨st⟩ = 1/12.
            let mixed = a * b.transpose();
            let squares = (a * a.transpose() + b * b.transpose()) / 6.0;
            own.moment += (squares + (mixed + mixed.transpose()) / 12.0) * area;
        }
    }
    Ok(around)
}

impl Around {
    /// Axes as columns, the normal last, and the standard deviation along each.
    fn shape(&self, normal: &Vector3<f64>) -> (Matrix3<f64>, [f64; 3]) {
        let first = perpendicular(normal);
        let second = normal.cross(&first);
        let mean = |u: &Vector3<f64>, v: &Vector3<f64>| u.dot(&(self.moment * v)) / self.area.max(f64::MIN_POSITIVE);
        let (a, b, c) = (mean(&first, &first), mean(&first, &second), mean(&second, &second));
        // Eigenvalues and the axis of the larger one of a symmetric matrix of two rows.
        let (middle, half) = (f64::midpoint(a, c), (a - c) / 2.0);
        let radius = half.hypot(b);
        let (sin, cos) = (0.5 * b.atan2(half)).sin_cos();
        let long = first * cos + second * sin;
        let wide = ALONG * (middle + radius).max(0.0).sqrt();
        let narrow = (ALONG * (middle - radius).max(0.0).sqrt()).max(NARROWEST * wide);
        let axes = Matrix3::from_columns(&[long, normal.cross(&long), *normal]);
        (axes, [wide, narrow, ACROSS * (wide * narrow).sqrt()])
    }
}
