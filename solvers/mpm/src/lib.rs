//! Moving-least-squares material point method (MLS-MPM, quadratic kernel, APIC): elastic and elastoplastic solids, sand,
//! snow and liquid on a sparse grid, in single or double precision from one source.
//!
//! One substep:
//! 1. each block of particles writes mass and momentum into its own tile of nodes (`transfer`, `particles`);
//! 2. each grid block adds up the tiles that reach it, in a fixed order, and takes outside influences (`grid`, `push`);
//! 3. bodies of this process exchange contact impulses (`contact`); walls, the stand-ins of rigid partners (`proxy`) and
//!    of samples of deformable ones (`swarm`) stop the surfaces of single particles (`touch` and `patch` find the places,
//!    `settle` the impulses);
//! 4. each block of particles reads its tile back: velocity, velocity gradient, position, strain, plastic flow.
//!
//! No two blocks ever write to the same memory and every sum has a fixed order, so the bytes of a state do not depend
//! on the number of threads. No allocation and no lock stands inside steps 1 and 4.
//!
//! Strain is stored as `B = b_e - I` (`math`, `law`), which keeps small strains of spinning bodies to single precision;
//! positions are relative to their block, with the rounding of the last sum beside them (`store`). The length of a
//! substep follows from wave speed, particle speed and strain rate (`stable`); a substep that goes too far is undone and
//! repeated with half the length (`sim`). Single particles that run away all the same lose their stress, counted
//! (`quarantine`). Impulses of walls, gravity and rigid partners are the changes of the grid's
//! momentum, in f64; the momentum that they must explain is summed over the particles (`report`): two separate roads,
//! so that their difference is a check.
//!
//! Memory in single (double) precision: 116 (224) B a particle, twice, for the copy that a segment can go back to, and 24 B of
//! its start; 8.2 (16.2) KiB a block of 4³ cells with particles, for its tile, 16 (32) B a particle where each cell holds eight;
//! 19 (35) B a node, and 4 B where anything can be touched. What flows has tiles and nodes twice, a capture 36 (72) B more, twice.
//!
//! Not here yet: moving walls, two-dimensional slabs, restitution, the `genesis` contact law. Each is refused by name.
//!
//! Shapes are formulas, closed meshes or, of static colliders, height fields (`cosplat_core::distance`). A body is a
//! lattice in a shape or a cloud that was prepared (`sample`); one that comes from a capture carries total deformation
//! gradients for the Gaussians that ride on it.
//!
//! A body may have regions of another material (`read_regions`): parts with blocks of particles of their own, so that a
//! block has one law, and with shared nodes, so that they stick.
//!
//! Solids near incompressibility average their volume ratio over cells (`fbar`), so that they do not lock.
//!
//! What flows, sand and liquid, meets walls at nodes and compares its volume with the grid's density (`shores`, `law::Room`).
//!
//! Known limits: bodies of this process still meet at nodes, up to half a cell early; the place where a particle of a
//! plastic body ends takes its elastic stretch only; the grid's density knows walls, but neither partners nor other bodies;
//! a liquid at rest has 8 % too much pressure in the cells on its floor, and single particles are off by 7 % of that at the
//! foot in the square mean.

mod contact;
mod fbar;
mod gauge;
mod grid;
mod hear;
mod kick;
mod law;
mod math;
mod mobility;
mod model;
mod nodes;
mod params;
mod particles;
mod parts;
mod patch;
mod plugin;
mod proxy;
mod quarantine;
mod read;
mod read_bodies;
mod read_partners;
mod read_regions;
mod real;
mod report;
mod sample;
mod save;
mod settle;
mod shores;
mod show;
mod sim;
mod sort;
mod stable;
mod store;
mod swarm;
mod tally;
mod tile;
mod topology;
mod touch;
mod transfer;
mod walls;

pub use law::YieldNorm;
pub use plugin::Mpm;
pub use real::{Lanes, Real};
