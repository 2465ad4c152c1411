//! Smoke: particles that an incompressible gas carries past walls, rigid bodies and bodies that show samples, in double
//! precision.
//!
//! The gas fills the whole domain (`low`, `high`), a staggered grid of cells (`grid`), or the part of it where
//! something happens (`still`; `follow`). One substep:
//! 1. momentum and the concentration of smoke cross faces of cells (`flux`, `scalar`) and buoyancy acts (Boussinesq),
//!    by Heun's rule;
//! 2. projections take the divergence out of its first guess and of its result (`project`, `multigrid`), with solids as
//!    faces that are heavier by a part of the solid's mass (`solids`): what a solid loses there is what the gas gains;
//! 3. particles go along by Heun's rule (`particles`).
//!
//! **Books.** The momentum flux is a symmetric tensor and pressure a difference, so that linear and angular momentum
//! change only by what is booked: sides of the domain, static solids, buoyancy and confinement as external, partners by
//! their interface. Each impulse on a partner is the gas's own loss at the faces near a sample, times the sample's part
//! of their mass. The moment about the origin that the gas books is that at the faces; a sample takes its impulse where
//! it is, up to a cell away.
//!
//! Samples take the impulses of a window at once, at its start, as their stand-ins do here (`sudden-impulses`): an
//! inelastic impact, which makes no energy whatever holds the partner. The same impulses spread over the window would
//! lag behind what vibrates faster than windows follow each other, and drive it.
//!
//! **Order.** Second order in space and time where the flow is smooth, first order at solids: they fill whole faces, or
//! spread over a cell, and stand still over a window. They do not slip; the boundary layer is a cell thick if it would
//! be thinner.
//!
//! **Viscosity** is that of air (`kinematic_viscosity`), and the material's `viscosity`, a share per step as the seeds
//! have it, taken as a rate: `share d² / 6 ms`, d the spacing of particles. 0.1 at 1 cm is 1.7e-3 m²/s, a hundred times
//! air's.
//!
//! **Sides** are open unless `open` says otherwise: there the pressure is that of the air around. Where a `wind` enters
//! and can leave by the opposite side, the side is an inlet with the wind's velocity, except where a solid stands in it
//! (`plugs`). Closed sides let the gas slide.
//!
//! **Inflow.** With `inflow_rate` the body's shape is a source: it stays full of smoke, and its particles leave in the
//! order of the body's source, those that wait rest in it. `inflow_velocity` drives the gas in it.
//!
//! Every loop over cells has a result that does not depend on its order, and every sum has a fixed one, so that the
//! bytes do not depend on the number of threads.
//!
//! **Turbulence** is what the cells carry; there is no model for what they do not. A thermal whose viscosity they
//! resolve rises with the power 0.49 of time (similarity: a half). A starting plume stays laminar and speeds up, unless
//! something stirs its root: three times a second, it became turbulent and rose with the power 0.71 from 20 to 50 radii
//! of its source (turbulent similarity: three quarters), its cap spreading by 0.27 (Turner 1962: 0.18). Stirred at 2.5
//! and 0.8 times a second the same plume was laminar for 34 and 40 radii.
//!
//! **Method.** `method = "positions"` has no gas, only particles with constraints on their density, as one of the seeds
//! has them, for comparison (`positions`).
//!
//! Not here yet, and refused by name: several clouds in one process, moving static colliders, prescribed motion,
//! impulses from others. Left out: what the density of smoke adds to the inertia (said in the plan above 20 %),
//! hydrostatic lift on solids, heat that conducts. Dissipated energy is not summed.

mod confine;
mod cycle;
mod fill;
mod flux;
mod follow;
mod grid;
mod march;
mod matrix;
mod model;
mod multigrid;
mod params;
mod particles;
mod partner;
mod plugin;
mod plugs;
mod positions;
mod project;
mod proxy;
mod read;
mod report;
mod scalar;
mod sides;
mod solids;
mod step;
mod store;
#[cfg(test)]
mod tests;

pub use plugin::Smoke;
