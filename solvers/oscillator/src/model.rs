//! What a scene is to this solver: masses, springs, couplings and outside influences. Nothing here changes in a run.

use cosplat_core::plan::InterfaceId;
use cosplat_core::plugin::{Influence, ViewRole};
use cosplat_core::time::Clock;
use nalgebra::DMatrix;

use crate::V3;
use crate::modes::Modes;

/// A scene, read.
#[derive(Clone, Debug)]
pub(crate) struct Model {
    pub(crate) clock: Clock,
    pub(crate) bodies: Vec<PointMass>,
    pub(crate) springs: Vec<Spring>,
    pub(crate) couplings: Vec<Coupling>,
    pub(crate) influences: Vec<Influence>,
    pub(crate) modes: Modes,
}

/// A body: one point.
#[derive(Clone, Debug)]
pub(crate) struct PointMass {
    pub(crate) name: String,
    /// \[kg\].
    pub(crate) mass: f64,
    /// At t = 0 \[m\].
    pub(crate) position: V3,
    /// At t = 0 \[m/s\].
    pub(crate) velocity: V3,
    /// Whether a partner sees it.
    pub(crate) coupled: bool,
}

/// A spring with both ends here: `F_a = -k (x_a - x_b - rest)`; for the world `x_b = 0` and `rest` holds the anchor.
#[derive(Clone, Debug)]
pub(crate) struct Spring {
    pub(crate) a: usize,
    pub(crate) b: Option<usize>,
    /// k \[N/m\].
    pub(crate) stiffness: f64,
    /// \[m\].
    pub(crate) rest: V3,
}

/// An interface with another solver.
#[derive(Clone, Debug)]
pub(crate) struct Coupling {
    pub(crate) id: InterfaceId,
    pub(crate) role: ViewRole,
    pub(crate) own: usize,
    pub(crate) partner: String,
    /// Whether the partner is a rigid body, joined at its centre of mass.
    pub(crate) partner_is_rigid: bool,
    /// Σ k of its links \[N/m\].
    pub(crate) stiffness: f64,
    /// Σ k rest \[N\], rest being `x_own - x_partner` without force.
    pub(crate) preload: V3,
}

impl Coupling {
    /// Whether this side computes the springs, with the partner on a given path.
    pub(crate) fn computes(&self) -> bool {
        matches!(self.role, ViewRole::LinkSide | ViewRole::LinkResolver)
    }
}

impl Model {
    /// Stiffness matrix \[N/m\] of everything that pulls when a body moves and its partners do not.
    pub(crate) fn stiffness(bodies: usize, springs: &[Spring], couplings: &[Coupling]) -> DMatrix<f64> {
        let mut k = DMatrix::zeros(bodies, bodies);
        for spring in springs {
            k[(spring.a, spring.a)] += spring.stiffness;
            if let Some(b) = spring.b {
                k[(b, b)] += spring.stiffness;
                k[(spring.a, b)] -= spring.stiffness;
                k[(b, spring.a)] -= spring.stiffness;
            }
        }
        for coupling in couplings.iter().filter(|c| c.computes()) {
            k[(coupling.own, coupling.own)] += coupling.stiffness;
        }
        k
    }

    /// Energy stored in springs and gravity at time `t` \[J\].
    pub(crate) fn potential(&self, position: &[V3], t: f64) -> f64 {
        let springs: f64 = self
            .springs
            .iter()
            .map(|s| {
                let stretch = position[s.a] - s.b.map_or_else(V3::zeros, |b| position[b]) - s.rest;
                0.5 * s.stiffness * stretch.norm_squared()
            })
            .sum();
        let weight =
            |i: &Influence| -> f64 { i.bodies.iter().map(|&b| -i.force(self.bodies[b].mass).dot(&position[b])).sum() };
        let gravity = self.influences.iter().filter(|i| i.acts_at(t) && i.has_potential());
        springs + gravity.map(weight).sum::<f64>()
    }
}
