//! Where the picture is taken from.

use nalgebra::Vector3;
use thiserror::Error;

/// Largest width and height of a picture, in pixels.
const LARGEST: usize = 16_384;

/// A camera that cannot take a picture.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum CameraError {
    /// A size of zero or beyond the limit.
    #[error("a picture of {0} x {1} pixels cannot be drawn; each side must be 1 to {LARGEST}")]
    Size(usize, usize),
    /// The field of view leaves no picture plane.
    #[error("the vertical field of view must lie between 0 and 180 degrees")]
    FieldOfView,
    /// Eye, target and up do not span a view.
    #[error("eye and target must be two finite points, and `up` must not lie along the line between them")]
    Direction,
}

/// A pinhole camera in the axes of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Centre of projection, in scene units.
    pub eye: [f64; 3],
    /// A point on the optical axis.
    pub target: [f64; 3],
    /// The direction that points up in the picture; need not be perpendicular to the view.
    pub up: [f64; 3],
    /// Angle between the upper and the lower edge, in degrees.
    pub fov_y_deg: f64,
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
}

/// World to camera (x right, y down, z forward) and camera to pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Centre of projection.
    pub eye: [f64; 3],
    /// Rows right, down, forward: camera point = rows · (point − eye).
    pub rows: [[f64; 3]; 3],
    /// Focal length in pixels, the same for both axes: (height / 2) / tan(fov / 2).
    pub focal: f64,
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
}

impl Camera {
    /// The view of this camera.
    ///
    /// # Errors
    /// Size, field of view or directions make no picture.
    pub fn view(&self) -> Result<View, CameraError> {
        if !(1..=LARGEST).contains(&self.width) || !(1..=LARGEST).contains(&self.height) {
            return Err(CameraError::Size(self.width, self.height));
        }
        if !(self.fov_y_deg > 0.0 && self.fov_y_deg < 180.0) {
            return Err(CameraError::FieldOfView);
        }
        let (eye, target, up) = (Vector3::from(self.eye), Vector3::from(self.target), Vector3::from(self.up));
        let direction = |v: Vector3<f64>| v.try_normalize(0.0).filter(|v| v.iter().all(|c| c.is_finite()));
        let basis = || {
            let forward = direction(target - eye)?;
            let up = direction(up)?;
            let right = Some(forward.cross(&up)).filter(|r| r.norm() > 1e-6).and_then(direction)?;
            Some((right, forward.cross(&right), forward))
        };
        let (right, down, forward) = basis().ok_or(CameraError::Direction)?;
        let focal = self.height as f64 / 2.0 / (self.fov_y_deg.to_radians() / 2.0).tan();
        let rows = [right, down, forward].map(Into::into);
        Ok(View { eye: self.eye, rows, focal, width: self.width, height: self.height })
    }
}

impl View {
    /// A point in camera axes.
    pub(crate) fn in_camera(&self, point: [f32; 3]) -> [f64; 3] {
        let from_eye = [0, 1, 2].map(|k| f64::from(point[k]) - self.eye[k]);
        self.rows.map(|r| r[0] * from_eye[0] + r[1] * from_eye[1] + r[2] * from_eye[2])
    }
}
