//! What a scene becomes beside its particles: setting, names, surfaces.

use cosplat_core::plan::InterfaceId;
use cosplat_core::plugin::ViewRole;

use crate::real::Real;
use crate::sim::Setting;
use crate::walls::Wall;

/// An interface as this solver plays it.
#[derive(Clone, Debug)]
pub(crate) struct Face {
    /// Identity.
    pub(crate) id: InterfaceId,
    /// Own body.
    pub(crate) body: usize,
    /// Part played.
    pub(crate) role: ViewRole,
    /// Rigid partner, where this side resolves.
    pub(crate) partner: Option<usize>,
    /// Partner that shows samples, where this side resolves.
    pub(crate) cloud: Option<usize>,
}

/// A particle at the surface of a body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mark {
    /// Particle.
    pub(crate) id: u32,
    /// Outward normal at the start, world axes.
    pub(crate) normal: [f64; 3],
    /// Area that it stands for \[m²\].
    pub(crate) area: f64,
    /// Volume \[m³\].
    pub(crate) volume: f64,
    /// Mass \[kg\].
    pub(crate) mass: f64,
}

/// What is shown of a body.
#[derive(Clone, Debug, Default)]
pub(crate) struct Shown {
    /// Whether partners see it.
    pub(crate) has_interface: bool,
    /// Whether Gaussians ride on it: pictures then need total deformation gradients.
    pub(crate) is_capture: bool,
    /// Particles at the surface.
    pub(crate) surface: Vec<Mark>,
    /// Volume \[m³\].
    pub(crate) volume: f64,
    /// Mass \[kg\].
    pub(crate) mass: f64,
}

/// A scene read, without what its particles start with: a run has them in its store.
#[derive(Clone, Debug)]
pub(crate) struct Model<R: Real> {
    pub(crate) names: Vec<String>,
    pub(crate) shown: Vec<Shown>,
    pub(crate) faces: Vec<Face>,
    pub(crate) walls: Vec<Wall>,
    pub(crate) setting: Setting<R>,
    pub(crate) particles: Vec<u64>,
    pub(crate) threads: usize,
}

impl<R: Real> Model<R> {
    /// Index of the first particle of each body, and the end.
    pub(crate) fn firsts(&self) -> Vec<u64> {
        let mut sum = 0;
        std::iter::once(0)
            .chain(self.particles.iter().map(|n| {
                sum += n;
                sum
            }))
            .collect()
    }
}
