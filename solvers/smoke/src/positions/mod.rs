//! The second seed's own smoke: particles without a grid, kept apart by constraints on their density (position-based
//! fluids: Macklin and Müller 2013; as a gas: Macklin, Müller, Chentanez and Kim 2014), in double precision.
//!
//! One substep of length `h`, 1 ms as in the seed:
//! 1. gravity less lift, `g (1 - ρ_air/ρ)`, and what the air around does to the surface, `k (u_air - v)(1 - ρ_i/ρ_0)`;
//! 2. viscosity, a share of the differences to neighbours (`viscosity`, 0.1 in the seed);
//! 3. `density_iterations` times: multipliers of all constraints `ρ_i ≤ ρ_0`, a Jacobi correction by them (`density`),
//!    then contact with solids and samples (`touch`, `sampled`); what begins denser than `ρ_0` may stay so;
//! 4. positions move by `h v`.
//!
//! **Books.** Corrections of positions are impulses `m Δx/h` where the substep began, along the lines between those
//! places, and viscosity acts along the same lines: five times the published share, so that a shear decays as fast
//! where neighbours are on all sides alike (on the lattice at the start half as fast).
//! Linear and angular momentum therefore close to rounding, which the published form does not do.
//!
//! **Contact** is inelastic and does not rub: samples and rigid partners take their part with their own mass, by
//! Gauss–Seidel, at once and at the start of the window. It never pushes out what was inside, so that it makes no
//! energy. Density knows of walls, not of samples.
//!
//! **Limits.** The particles are all there is: no air flows around them, so that a warm cloud entrains nothing, has no
//! added mass and stops rising only by `surface_drag`, a number without a physical source. A density error is left that
//! iterations make smaller, and stiffness depends on them and on the substep. For physics there is the grid; this is
//! for comparison with the seed. Nothing flows in (`inflow_rate` is refused).

mod cloud;
mod density;
mod kernel;
mod near;
mod read;
mod sampled;
mod step;
mod touch;

pub(crate) use cloud::Cloud;
pub(crate) use read::read;
