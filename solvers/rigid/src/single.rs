//! Between the double precision of the state and the single precision of rapier.

use rapier3d::math::{Pose, Rotation, Vector};

use crate::{Turn, V3, plain};

/// Rounds three components.
pub(crate) fn vector(v: V3) -> Vector {
    Vector::new(v.x as f32, v.y as f32, v.z as f32)
}

/// Rounds a rotation.
pub(crate) fn rotation(turn: &Turn) -> Rotation {
    let [x, y, z, w] = plain(turn);
    Rotation::from_xyzw(x as f32, y as f32, z as f32, w as f32).normalize()
}

/// Rounds a place and a rotation.
pub(crate) fn pose(position: V3, turn: &Turn) -> Pose {
    Pose::from_parts(vector(position), rotation(turn))
}

/// Three components as they are.
pub(crate) fn double(v: Vector) -> V3 {
    V3::new(f64::from(v.x), f64::from(v.y), f64::from(v.z))
}

/// A rotation as it is, of unit length in double precision.
pub(crate) fn turned(r: Rotation) -> Turn {
    crate::turn([f64::from(r.x), f64::from(r.y), f64::from(r.z), f64::from(r.w)])
}
