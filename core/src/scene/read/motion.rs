//! Pose, initial velocity and motions told in advance.

use super::fields::Fields;
use super::limits::Limits;
use super::node::Value;
use super::value::At;
use crate::scene::model::{Motion, Pose, VelocityField};

const POSITION: Limits = Limits::any("m");
const SPEED: Limits = Limits::any("m/s");
const TURN: Limits = Limits::any("rad/s");

const NO_TURN: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

/// `position`, and `orientation` or `rotation`.
pub(super) fn pose(fields: &Fields<'_>) -> Pose {
    fields.exclude("orientation", "rotation");
    let orientation = fields
        .opt("orientation", |at| quaternion(&at))
        .or_else(|| fields.opt("rotation", |at| at.table(rotation)).flatten())
        .unwrap_or(NO_TURN);
    Pose { position_m: fields.vec3_or_zero("position", POSITION), orientation }
}

/// A quaternion `[x, y, z, w]`, scaled to length one.
fn quaternion(at: &At<'_>) -> [f64; 4] {
    let quaternion: [f64; 4] = at.numbers(Limits::any(""));
    let length = quaternion.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length < 1e-12 && matches!(&at.node.value, Value::List(items) if items.len() == 4) {
        let help = "no turn at all is [0, 0, 0, 1], in the order x, y, z, w";
        at.error(format!("`{}` is no rotation: its length is zero", at.key()), Some(help.to_owned()));
    } else if (length - 1.0).abs() > 0.01 && length >= 1e-12 {
        let help = "the order is x, y, z, w; it was scaled to length 1";
        at.warning(format!("`{}` has the length {length:.3} instead of 1", at.key()), Some(help.to_owned()));
    }
    quaternion.map(|x| x / length)
}

/// `{ axis, degrees }` or `{ axis, radians }`.
fn rotation(fields: &Fields<'_>) -> [f64; 4] {
    let axis = fields.must("axis", |at| at.direction()).unwrap_or([0.0, 0.0, 1.0]);
    let half_angle = match fields.one_key(&["degrees", "radians"]) {
        Some(("degrees", at)) => at.num(Limits::any("degrees")).to_radians() / 2.0,
        Some((_, at)) => at.num(Limits::any("rad")) / 2.0,
        None => 0.0,
    };
    let [x, y, z] = axis.map(|component| component * half_angle.sin());
    [x, y, z, half_angle.cos()]
}

/// `velocity` and `angular_velocity`, or `velocity_field`.
pub(super) fn initial_velocity(fields: &Fields<'_>) -> VelocityField {
    fields.exclude("velocity_field", "velocity");
    fields.exclude("velocity_field", "angular_velocity");
    let twist = VelocityField::Twist {
        linear_m_s: fields.vec3_or_zero("velocity", SPEED),
        angular_rad_s: fields.vec3_or_zero("angular_velocity", TURN),
    };
    fields.opt("velocity_field", |at| at.table(velocity_field).flatten()).flatten().unwrap_or(twist)
}

fn velocity_field(fields: &Fields<'_>) -> Option<VelocityField> {
    match fields.one_key(&["linear_map", "rotation"])? {
        ("linear_map", at) => at.table(|fields| VelocityField::LinearMap {
            linear_m_s: fields.vec3_or_zero("velocity", SPEED),
            gradient_1_s: fields.must("gradient", |at| at.rows(Limits::any("1/s"))).unwrap_or_default(),
            about_m: fields.vec3_or_zero("about", POSITION),
        }),
        (_, at) => at.table(|fields| VelocityField::Rotation {
            angular_rad_s: fields.vec3("angular_velocity", TURN),
            about_m: fields.vec3_or_zero("about", POSITION),
        }),
    }
}

/// A motion told in advance: a twist, or `{ oscillation = { amplitude, frequency } }`.
pub(super) fn motion(at: &At<'_>) -> Option<Motion> {
    at.table(|fields| {
        fields.exclude("oscillation", "velocity");
        fields.exclude("oscillation", "angular_velocity");
        let twist = Motion::Twist {
            linear_m_s: fields.vec3_or_zero("velocity", SPEED),
            angular_rad_s: fields.vec3_or_zero("angular_velocity", TURN),
        };
        let oscillation = |fields: &Fields<'_>| Motion::Oscillation {
            amplitude_m: fields.vec3("amplitude", POSITION),
            frequency_hz: fields.num("frequency", Limits::positive("Hz")),
        };
        fields.opt("oscillation", |at| at.table(oscillation)).flatten().unwrap_or(twist)
    })
}

/// Linear RGB, each from 0 to 1.
pub(super) fn color(fields: &Fields<'_>) -> Option<[f64; 3]> {
    fields.opt("color", |at| at.numbers(Limits::between(0.0, 1.0, "")))
}
