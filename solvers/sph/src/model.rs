//! What never changes in a run.

use cosplat_core::boundary::Vec3;
use cosplat_core::distance::{Placed, Shape, SignedDistance};
use cosplat_core::plan::InterfaceId;

use crate::frame::Frame;
use crate::gates::{Drain, Inflow};
use crate::kernel::Kernel;
use crate::params::Params;
use crate::shell::Piece;
use crate::state::Equation;

/// A body.
#[derive(Clone, Debug)]
pub(crate) struct Liquid {
    /// Name.
    pub(crate) name: String,
    /// Density at rest \[kg/m³\].
    pub(crate) rho: f64,
    /// Stiffness, `ρ0 c²/7` of both equations of state \[Pa\].
    pub(crate) stiffness: f64,
    /// How pressure follows from the density.
    pub(crate) equation: Equation,
    /// Speed of sound at rest \[m/s\].
    pub(crate) sound: f64,
    /// Dynamic viscosity of which forces are taken before a substep, at least the artificial one, and after it (`thick`), one
    /// of both being 0 \[Pa s\].
    pub(crate) viscosity: f64,
    pub(crate) thickness: f64,
    /// Factor of the pull between its particles (`cohesion`) \[N\], and its surface tension \[N/m\].
    pub(crate) cohesion: f64,
    pub(crate) tension: f64,
    /// Identities of its particles.
    pub(crate) ids: std::ops::Range<usize>,
    /// Whether it has an interface, so that its boundary is shown.
    pub(crate) coupled: bool,
}

/// Something that a liquid cannot enter.
#[derive(Clone, Debug)]
pub(crate) enum Solid {
    /// A plane; its particles are made where the liquid is.
    Plane(Frame, Shape),
    /// A static solid: its particles in the world.
    Fixed(Vec<Piece>),
    /// A rigid partner of that name: its particles about its centre of mass.
    Rigid(String, Vec<Piece>),
    /// A partner of that name that shows samples.
    Sampled(String),
}

/// A body and a solid that touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Face {
    /// Own body.
    pub(crate) body: usize,
    /// Solid.
    pub(crate) solid: usize,
    /// Interface, for partners.
    pub(crate) interface: Option<InterfaceId>,
    /// Whether the liquid slides along it freely.
    pub(crate) slips: bool,
}

/// Gravity in a range of time.
#[derive(Clone, Debug)]
pub(crate) struct Gravity {
    /// \[m/s²\].
    pub(crate) acceleration: Vec3,
    /// Whether it acts on each body.
    pub(crate) acts: Vec<bool>,
    /// First and last moment \[s\].
    pub(crate) from: f64,
    pub(crate) until: f64,
    /// Whether it acts at all times, so that its potential energy is in the books.
    pub(crate) always: bool,
}

impl Gravity {
    /// Share of `start..end` \[s\] in which it acts.
    pub(crate) fn share(&self, start: f64, end: f64) -> f64 {
        ((end.min(self.until) - start.max(self.from)) / (end - start)).clamp(0.0, 1.0)
    }
}

/// Everything that never changes.
#[derive(Clone, Debug)]
pub(crate) struct Model {
    /// Bodies, in scene order.
    pub(crate) liquids: Vec<Liquid>,
    /// Body, mass \[kg\] and place at t = 0 \[m\] of each particle, by identity.
    pub(crate) body: Vec<u32>,
    pub(crate) mass: Vec<f64>,
    pub(crate) start: Vec<Vec3>,
    /// Solids.
    pub(crate) solids: Vec<Solid>,
    /// Where static solids are, with their number among the solids.
    pub(crate) statics: Vec<(usize, Placed)>,
    /// Pairs that touch.
    pub(crate) faces: Vec<Face>,
    /// Interfaces, in the scene's order.
    pub(crate) interfaces: Vec<InterfaceId>,
    /// Gravity.
    pub(crate) gravity: Vec<Gravity>,
    /// Gravity times the height of all that is there at the start, `g H` \[m²/s²\].
    pub(crate) head: f64,
    /// Where liquid enters and leaves.
    pub(crate) inflows: Vec<Inflow>,
    pub(crate) drains: Vec<Drain>,
    /// Kernel.
    pub(crate) kernel: Kernel,
    /// Distance of particles at rest \[m\].
    pub(crate) spacing: f64,
    /// Parameters.
    pub(crate) params: Params,
    /// Threads.
    pub(crate) threads: usize,
}

impl Model {
    /// Whether viscosity is implicit.
    pub(crate) fn is_thick(&self) -> bool {
        self.liquids.iter().any(|l| l.thickness > 0.0)
    }

    /// Whether a place \[m\] lies inside a static solid before number `solid` among the solids.
    pub(crate) fn taken(&self, x: Vec3, solid: usize) -> bool {
        let mut before = self.statics.iter().take_while(|s| s.0 < solid);
        before.any(|(_, placed)| placed.distance(x).0 < -1e-6 * self.spacing)
    }
}
