//! What two bodies do to each other: contact parameters, links, joints.

use serde::{Deserialize, Serialize};

use super::Vec3;

/// `[[pair]]`: contact parameters of two bodies (or a body and a static collider).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PairSpec {
    /// One body.
    pub a: String,
    /// The other body or static collider.
    pub b: String,
    /// Static friction coefficient.
    pub static_friction: f64,
    /// Kinetic friction coefficient.
    pub kinetic_friction: f64,
    /// Coefficient of restitution, 0..=1.
    pub restitution: f64,
    /// Contact softness \[m\].
    pub softness_m: f64,
    /// Contact law.
    pub contact: ContactLaw,
    /// Solver process that computes the force; `None` lets the plan choose.
    pub resolver: Option<String>,
    /// False leaves the pair out although it could touch.
    pub enabled: bool,
}

/// Contact law of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ContactLaw {
    /// Predictive non-penetration with Coulomb friction.
    Physical,
    /// Influence law of the first seed's simulator.
    Genesis,
}

/// `[[link]]`: a linear spring of two positions, `F_a = -k (x_a - x_b - rest) - c (v_a - v_b)`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Link {
    /// Unique name.
    pub name: String,
    /// One body.
    pub a: String,
    /// The other body; `None` is the world.
    pub b: Option<String>,
    /// Attachment point at the world when `b` is none \[m\].
    pub anchor_m: Vec3,
    /// Stiffness k \[N/m\].
    pub stiffness_n_m: f64,
    /// Damping c \[N s/m\].
    pub damping_n_s_m: f64,
    /// Vector `x_a - x_b` at which the force is zero \[m\].
    pub rest_m: Vec3,
    /// For `serial`: the body that goes first. For `centred`: the body whose solver computes the impulse.
    pub first: Option<String>,
}

/// `[[joint]]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Joint {
    /// Unique name.
    pub name: String,
    /// What it leaves free.
    pub kind: JointKind,
    /// One body.
    pub a: String,
    /// The other body; `None` is the world.
    pub b: Option<String>,
    /// Joint point in the world at t = 0 \[m\].
    pub anchor_m: Vec3,
    /// Axis of a prismatic joint, unit, world frame at t = 0.
    pub axis: Vec3,
    /// Spring along the free direction \[N/m\], or about it \[N m/rad\].
    pub stiffness: f64,
    /// Damper along the free direction \[N s/m\], or about it \[N m s/rad\].
    pub damping: f64,
}

/// Kind of a rigid joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum JointKind {
    /// One translation is free.
    Prismatic,
    /// All rotations are free.
    Ball,
    /// Nothing is free.
    Fixed,
}
