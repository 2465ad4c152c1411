//! What never changes in a run, and the part of the domain that is computed.

use cosplat_core::boundary::{Vec3, add, scale};
use cosplat_core::distance::Shape;
use cosplat_core::plan::InterfaceId;

use crate::follow::{Part, Whole};
use crate::grid::Grid;
use crate::params::Params;
use crate::sides::Sides;
use crate::solids::Filled;

/// An influence in a range of time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct During {
    /// Acceleration \[m/s²\] or velocity \[m/s\].
    pub(crate) value: Vec3,
    /// First and last moment \[s\].
    pub(crate) from: f64,
    pub(crate) until: f64,
}

/// Sum of the means of influences over `start..end` \[s\].
pub(crate) fn mean(all: &[During], start: f64, end: f64) -> Vec3 {
    all.iter().fold([0.0; 3], |sum, g| {
        let share = ((end.min(g.until) - start.max(g.from)) / (end - start)).clamp(0.0, 1.0);
        add(sum, scale(g.value, share))
    })
}

/// Sum of influences at `t` \[s\].
pub(crate) fn at(all: &[During], t: f64) -> Vec3 {
    all.iter().filter(|w| (w.from..=w.until).contains(&t)).fold([0.0; 3], |sum, w| add(sum, w.value))
}

/// What a partner is.
#[derive(Clone, Debug)]
pub(crate) enum Partner {
    /// Its shape about its centre of mass.
    Rigid(Shape),
    /// It shows samples.
    Samples,
}

/// A partner.
#[derive(Clone, Debug)]
pub(crate) struct Face {
    pub(crate) interface: InterfaceId,
    pub(crate) name: String,
    pub(crate) partner: Partner,
}

/// Everything that never changes, but the part of the domain that is computed.
#[derive(Clone, Debug)]
pub(crate) struct Model {
    /// Name of the smoke.
    pub(crate) name: String,
    /// The part of the domain that is computed.
    pub(crate) part: Part,
    pub(crate) grid: Grid,
    /// By the sum of all winds: whether a side of the domain is an inlet does not change.
    pub(crate) sides: Sides,
    pub(crate) params: Params,
    /// Kinematic viscosity \[m²/s\].
    pub(crate) nu: f64,
    /// Density of the smoke over that of the air around, less one.
    pub(crate) heavier: f64,
    /// Mass \[kg\] and volume \[m³\] of a particle of smoke.
    pub(crate) particle: [f64; 2],
    /// Places at t = 0 \[m\].
    pub(crate) start: Vec<Vec3>,
    /// Static solids, and the mouth of an inflow that drives its gas.
    pub(crate) fixed: Vec<Filled>,
    /// Cells of the source of an inflow.
    pub(crate) source: Vec<usize>,
    pub(crate) whole: Whole,
    pub(crate) partners: Vec<Face>,
    pub(crate) gravity: Vec<During>,
    pub(crate) wind: Vec<During>,
    /// Whether it has an interface, so that its particles are shown.
    pub(crate) coupled: bool,
    pub(crate) threads: usize,
}

impl Model {
    /// Mean gravity over `start..end` \[s\].
    pub(crate) fn gravity(&self, start: f64, end: f64) -> Vec3 {
        mean(&self.gravity, start, end)
    }

    /// Velocity of the air around at `t` \[m/s\].
    pub(crate) fn ambient(&self, t: f64) -> Vec3 {
        at(&self.wind, t)
    }

    /// Particles that an inflow has let go by `t` \[s\]: the first after half the time between two.
    pub(crate) fn born(&self, t: f64) -> usize {
        let all = self.start.len();
        if self.params.rate > 0.0 { ((self.params.rate * t + 0.5) as usize).min(all) } else { all }
    }

    /// Mass of the gas in a cell \[kg\].
    pub(crate) fn cell_mass(&self) -> f64 {
        self.params.air * self.grid.h * self.grid.h * self.grid.h
    }
}
