//! Things: bodies, static colliders, where their shapes come from and how they start.

use serde::{Deserialize, Serialize};

use super::region::Region;
use crate::scene::Material;

/// Three components along the world axes.
pub type Vec3 = [f64; 3];

/// One physical thing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Body {
    /// Unique name.
    pub name: String,
    /// Solver process that owns it: a key of `Scene::solvers` or the name of a plugin.
    pub solver: String,
    /// What it is made of, but for its regions.
    pub material: Material,
    /// Parts of another material; where they overlap, the last holds.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub regions: Vec<Region>,
    /// Where its shape comes from.
    pub source: Source,
    /// Pose of the source's frame in the world.
    pub pose: Pose,
    /// Total mass \[kg\]; `None` means density times volume.
    pub mass_kg: Option<f64>,
    /// Particle or sample spacing \[m\]; `None` lets the solver choose.
    pub spacing_m: Option<f64>,
    /// Motion at t = 0.
    pub velocity: VelocityField,
    /// Motion told in advance; such a body has infinite mass for its partners.
    pub prescribed: Option<Motion>,
    /// Plain colour for bodies without splats, linear RGB in 0..=1.
    pub color: Option<[f64; 3]>,
}

/// How the inside of a capture, which is a shell, is filled with particles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Fill {
    /// Where the winding number of the oriented surface says inside; what was filled is never drawn.
    #[default]
    Winding,
    /// As `PhysGaussian` does (Xie et al. 2024): every Gaussian is a particle, more are put where a density field and rays
    /// say so, and these are drawn with the attributes of the Gaussian nearest to them. For comparison.
    Physgaussian,
    /// Not at all: particles lie on the shell alone.
    None,
}

/// Shape of a body or static collider, in its own frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Source {
    /// A Gaussian splat file.
    Splat {
        /// Path relative to the scene file.
        file: String,
        /// Length of one file unit \[m\].
        metres_per_unit: f64,
        /// The file's up axis, as one of `+x -x +y -y +z -z`, or [`Source::UP_OF_FORMAT`].
        up: String,
        /// Gaussians below this opacity are dropped.
        min_opacity: f64,
        /// Keep only what lies in this box of the file's frame: lower and upper corner.
        keep_box: Option<[Vec3; 2]>,
        /// How its inside is filled.
        #[serde(default)]
        fill: Fill,
    },
    /// A triangle mesh file.
    Mesh {
        /// Path relative to the scene file.
        file: String,
        /// Length of one file unit \[m\].
        metres_per_unit: f64,
        /// The file's up axis, as for splats.
        up: String,
    },
    /// Terrain of a static collider: a triangle mesh file through which every line along local +z passes at most once.
    HeightField {
        /// Path relative to the scene file.
        file: String,
        /// Length of one file unit \[m\].
        metres_per_unit: f64,
        /// The file's up axis, which becomes local +z.
        up: String,
    },
    /// Axis-aligned box of full edge lengths \[m\], centred.
    Box {
        /// Full edge lengths \[m\].
        size_m: Vec3,
    },
    /// Sphere, centred.
    Sphere {
        /// Radius \[m\].
        radius_m: f64,
    },
    /// Cylinder along local z, centred.
    Cylinder {
        /// Radius \[m\].
        radius_m: f64,
        /// Full height \[m\].
        height_m: f64,
    },
    /// Plane through the origin of the frame with normal local +z; without size it is infinite.
    Plane {
        /// Full extents along local x and y \[m\].
        size_m: Option<[f64; 2]>,
    },
    /// Listed points \[m\].
    Points {
        /// Positions in the body's frame \[m\].
        positions_m: Vec<Vec3>,
    },
    /// A regular cloud of points in a box, for tests and benchmarks of the exchange.
    Cloud {
        /// Number of points.
        count: usize,
        /// Full edge lengths of the box they fill \[m\].
        size_m: Vec3,
    },
}

impl Source {
    /// What stands for the up axis where a scene states none: that of the format's convention. Whoever reads the file
    /// says which one it took.
    pub const UP_OF_FORMAT: &'static str = "format";
}

/// Position and orientation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Position \[m\].
    pub position_m: Vec3,
    /// Unit quaternion `[x, y, z, w]`.
    pub orientation: [f64; 4],
}

/// Initial velocities of a body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum VelocityField {
    /// Rigid motion about the body's centre of mass.
    Twist {
        /// Velocity of the centre of mass \[m/s\].
        linear_m_s: Vec3,
        /// Angular velocity, world axes \[rad/s\].
        angular_rad_s: Vec3,
    },
    /// `v = v0 + G (x - x0)`.
    LinearMap {
        /// Velocity at `about_m` \[m/s\].
        linear_m_s: Vec3,
        /// Velocity gradient G \[1/s\], rows.
        gradient_1_s: [Vec3; 3],
        /// Point x0 \[m\].
        about_m: Vec3,
    },
    /// `v = ω × (x - x0)`.
    Rotation {
        /// Angular velocity \[rad/s\].
        angular_rad_s: Vec3,
        /// Point on the axis \[m\].
        about_m: Vec3,
    },
}

/// A motion told in advance: a straight line at constant twist, or a harmonic oscillation about the start.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Motion {
    /// Constant twist about the body's origin.
    Twist {
        /// \[m/s\].
        linear_m_s: Vec3,
        /// \[rad/s\].
        angular_rad_s: Vec3,
    },
    /// `x = x0 + a sin(2π f t)`.
    Oscillation {
        /// Amplitude vector a \[m\].
        amplitude_m: Vec3,
        /// Frequency f \[Hz\].
        frequency_hz: f64,
    },
}

/// A collider that takes no impulses.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StaticCollider {
    /// Unique name.
    pub name: String,
    /// Shape.
    pub source: Source,
    /// Pose at t = 0.
    pub pose: Pose,
    /// What its surface does to what touches it.
    pub wall: Wall,
    /// Motion of a moving wall.
    pub motion: Option<Motion>,
    /// Plain colour, linear RGB in 0..=1.
    pub color: Option<[f64; 3]>,
}

/// Boundary condition of a wall.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Wall {
    /// Free along the wall, nothing through it; may separate.
    Slip,
    /// Sticks.
    NoSlip,
    /// Coulomb friction.
    Friction {
        /// Static friction coefficient.
        static_friction: f64,
        /// Kinetic friction coefficient.
        kinetic_friction: f64,
    },
}
