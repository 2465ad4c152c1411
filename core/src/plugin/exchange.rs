//! What a plugin is given for a step and what it answers.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::boundary::{BoundaryState, Impulses, Vec3, Wrench, add, cross, norm, scale, sub};
use crate::plan::InterfaceId;
use crate::scene::MotionRule;

/// Everything from outside that acts on a step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Inputs {
    /// Partners' boundaries, by interface.
    pub partners: Vec<PartnerInput>,
    /// Impulses on own bodies, by interface.
    pub impulses: Vec<ImpulseInput>,
}

impl Inputs {
    /// Partner at an interface.
    pub fn partner(&self, interface: InterfaceId) -> Option<&PartnerInput> {
        self.partners.iter().find(|p| p.interface == interface)
    }

    /// Impulses at an interface.
    pub fn impulse(&self, interface: InterfaceId) -> Option<&ImpulseInput> {
        self.impulses.iter().find(|i| i.interface == interface)
    }
}

/// A partner's boundary over a step.
#[derive(Clone, Debug, PartialEq)]
pub struct PartnerInput {
    /// Interface.
    pub interface: InterfaceId,
    /// Rule by which it moves.
    pub rule: MotionRule,
    /// Boundary at the start of the step (for the half step of a centred scheme: in the middle of the window).
    pub now: BoundaryState,
    /// Boundary at the end of the step, where it is known already.
    pub next: Option<BoundaryState>,
    /// Length of the step \[s\].
    pub length_s: f64,
}

impl PartnerInput {
    /// Position and velocity of sample `i` (or of the proxy's centre of mass) in a record.
    fn point(state: &BoundaryState, i: usize) -> (Vec3, Vec3) {
        match state {
            BoundaryState::Samples(s) => {
                (s.position.get(i).copied().unwrap_or_default(), s.velocity.get(i).copied().unwrap_or_default())
            }
            BoundaryState::Proxy(p) => (p.position, p.linear_velocity),
        }
    }

    /// Coefficients `c` of the sample's path `x(τ) = Σ c[k] τ^k`, τ in seconds from the start of the step.
    ///
    /// Hold: the newest record. Linear: straight between two records, or `x + v τ` from one. Hermite: the cubic through
    /// positions and velocities of two records, or `x + v τ` from one.
    pub fn path(&self, i: usize) -> [Vec3; 4] {
        let zero = [0.0; 3];
        let (x0, v0) = Self::point(&self.now, i);
        let Some(next) = &self.next else {
            return match self.rule {
                MotionRule::Hold => [x0, zero, zero, zero],
                MotionRule::Linear | MotionRule::Hermite => [x0, v0, zero, zero],
            };
        };
        let (x1, v1) = Self::point(next, i);
        let w = self.length_s;
        match self.rule {
            MotionRule::Hold => [x1, zero, zero, zero],
            MotionRule::Linear => [x0, scale(sub(x1, x0), 1.0 / w), zero, zero],
            MotionRule::Hermite => {
                // p(τ) = x0 + v0 τ + (3Δ/W² − (2 v0 + v1)/W) τ² + (−2Δ/W³ + (v0 + v1)/W²) τ³, Δ = x1 − x0.
                let d = sub(x1, x0);
                let c2 = sub(scale(d, 3.0 / (w * w)), scale(add(scale(v0, 2.0), v1), 1.0 / w));
                let c3 = add(scale(d, -2.0 / (w * w * w)), scale(add(v0, v1), 1.0 / (w * w)));
                [x0, v0, c2, c3]
            }
        }
    }
}

/// Impulses on an own body.
#[derive(Clone, Debug, PartialEq)]
pub struct ImpulseInput {
    /// Interface.
    pub interface: InterfaceId,
    /// The impulses.
    pub impulses: Impulses,
    /// True: spread evenly over the own substeps. False: taken at once at the start of the step.
    pub spread: bool,
}

/// Everything a step answers.
#[derive(Clone, Debug, PartialEq)]
pub struct Outputs {
    /// Boundaries at the end of the step: one per own body that has an interface.
    pub boundaries: Vec<BoundaryOutput>,
    /// Impulses on partners, by interface.
    pub impulses: Vec<(InterfaceId, Impulses)>,
    /// State and budgets at the end of the step.
    pub report: Report,
}

/// Boundary of one body.
#[derive(Clone, Debug, PartialEq)]
pub struct BoundaryOutput {
    /// Body.
    pub body: String,
    /// Its boundary.
    pub state: BoundaryState,
}

/// State and budgets of a solver after a step.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Substeps taken.
    pub substeps: u64,
    /// Term that bound the substep.
    pub substep_bound_by: String,
    /// State of each own body, in scene order.
    pub bodies: Vec<BodyState>,
    /// Impulse from outside the coupled system in this step (gravity, walls, springs to the world), about the world
    /// origin; computed from the forces, not from the momentum it explains.
    pub external: Wrench,
    /// Energy from outside the coupled system in this step \[J\]: work of influences that have no potential energy, of
    /// what moves as told in advance, and the energy of what enters less that of what leaves. What friction on walls
    /// takes is dissipated.
    pub supplied_j: f64,
    /// Energies at the end of the step.
    pub energy: Energy,
    /// Own view of each interface.
    pub interfaces: Vec<InterfaceReport>,
    /// Clamps, quarantines, overflows of this step. What begins with `largest-` or `final-` is no count of events: see
    /// [`count`]; what begins with `work-` says how much was done, and complains about nothing.
    pub counters: BTreeMap<String, u64>,
    /// Answers to probes that no state of a body gives, at the end of the step, by the probe's name: pressure at a point
    /// \[Pa\]. One that has no answer now, as there is no liquid at the point, is missing.
    pub probes: BTreeMap<String, f64>,
}

/// Adds a counter to those of earlier steps: counts are summed, of what begins with `largest-` the largest is kept, of
/// what begins with `final-` the last.
pub fn count(counters: &mut BTreeMap<String, u64>, name: &str, n: u64) {
    let all = counters.entry(name.to_owned()).or_default();
    *all = match name {
        _ if name.starts_with("largest-") => n.max(*all),
        _ if name.starts_with("final-") => n,
        _ => *all + n,
    };
}

/// One body at one moment, from the states of its particles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BodyState {
    /// Mass \[kg\].
    pub mass_kg: f64,
    /// Centre of mass \[m\].
    pub position_m: Vec3,
    /// Unit quaternion `[x, y, z, w]`; identity for bodies without one.
    pub orientation: [f64; 4],
    /// Velocity of the centre of mass \[m/s\].
    pub linear_velocity_m_s: Vec3,
    /// Angular velocity \[rad/s\].
    pub angular_velocity_rad_s: Vec3,
    /// Momentum, angular part about the world origin \[kg m/s, kg m²/s\].
    pub momentum: Wrench,
    /// Σ m|v| \[kg m/s\].
    pub gross_momentum: f64,
    /// Largest distance of a particle from its start \[m\].
    pub max_displacement_m: f64,
}

impl BodyState {
    /// A body of equal points of `mass` \[kg\] each, at `x` \[m\] with velocities `v` \[m/s\], that started at `start` \[m\].
    ///
    /// Points have no orientation of their own, so that the body has none and no angular velocity; what they turn about
    /// each other is in the momentum.
    pub fn of_points(mass: f64, x: &[Vec3], v: &[Vec3], start: &[Vec3]) -> Self {
        let sum = |all: &mut dyn Iterator<Item = Vec3>| all.reduce(add).unwrap_or_default();
        let mean = |all: &[Vec3]| sum(&mut all.iter().copied()).map(|c| c / all.len().max(1) as f64);
        let momentum = || v.iter().map(|&v| scale(v, mass));
        Self {
            mass_kg: mass * x.len() as f64,
            position_m: mean(x),
            orientation: [0.0, 0.0, 0.0, 1.0],
            linear_velocity_m_s: mean(v),
            angular_velocity_rad_s: [0.0; 3],
            momentum: Wrench {
                linear: sum(&mut momentum()),
                angular: sum(&mut x.iter().zip(momentum()).map(|(&x, p)| cross(x, p))),
            },
            gross_momentum: momentum().map(norm).sum(),
            max_displacement_m: x.iter().zip(start).map(|(&x, &s)| norm(sub(x, s))).fold(0.0, f64::max),
        }
    }
}

/// Energies of a solver \[J\].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Energy {
    /// Kinetic.
    pub kinetic_j: f64,
    /// Stored in bodies, springs to the world and gravity.
    pub potential_j: f64,
    /// Lost to friction, damping and plasticity since t = 0.
    pub dissipated_j: f64,
}

/// A solver's view of one interface over a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct InterfaceReport {
    /// Interface.
    pub interface: InterfaceId,
    /// Impulse that its own body received through the interface, about the world origin.
    pub received: Wrench,
    /// Σ|J| of the impulses behind it \[N s\].
    pub gross: f64,
    /// Work done on its own body through the interface \[J\].
    pub work_j: f64,
    /// Largest distance or speed by which the partner's stand-in differed from the partner; 0 where not known.
    pub residual: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_state_of_a_body_is_the_sum_over_its_points() {
        let (start, x) = ([[0.0; 3], [2.0, 0.0, 0.0]], [[0.0, 3.0, 0.0], [2.0, 0.0, 4.0]]);
        let v = [[1.0, 0.0, 0.0], [0.0, 0.0, -3.0]];
        let expected = BodyState {
            mass_kg: 1.0,
            position_m: [1.0, 1.5, 2.0],
            orientation: [0.0, 0.0, 0.0, 1.0],
            linear_velocity_m_s: [0.5, 0.0, -1.5],
            angular_velocity_rad_s: [0.0; 3],
            momentum: Wrench { linear: [0.5, 0.0, -1.5], angular: [0.0, 3.0, -1.5] },
            gross_momentum: 2.0,
            max_displacement_m: 4.0,
        };
        // All numbers are short binary fractions: the sums are exact.
        assert_eq!(BodyState::of_points(0.5, &x, &v, &start), expected);
    }

    #[test]
    fn counts_are_summed_and_the_largest_or_the_last_is_kept() {
        let mut counters = BTreeMap::new();
        for n in [3, 5, 2] {
            count(&mut counters, "clamped", n);
            count(&mut counters, "final-outside", n);
            count(&mut counters, "largest-compression-1e-6", n);
        }
        assert_eq!(counters.into_values().collect::<Vec<_>>(), [10, 2, 5]);
    }

    #[test]
    fn a_lone_point_keeps_its_bits() {
        let (x, v, mass) = ([0.1, -0.2, 0.7], [1.3, -0.0, 0.9], 1.7);
        let state = BodyState::of_points(mass, &[x], &[v], &[x]);
        let bits = |v: Vec3| v.map(f64::to_bits);
        assert_eq!((bits(state.position_m), bits(state.linear_velocity_m_s)), (bits(x), bits(v)));
        assert_eq!(bits(state.momentum.linear), bits(scale(v, mass)));
        assert_eq!(BodyState::of_points(mass, &[], &[], &[]).position_m.map(f64::to_bits), [0; 3]);
    }
}
