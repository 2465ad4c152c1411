//! Moving-least-squares material point method (MLS-MPM, quadratic kernel, APIC): elastic and elastoplastic solids on a
//! sparse grid, in single or double precision from one source.
//!
//! One substep:
//! 1. each block of particles writes mass and momentum into its own tile of nodes (`transfer`, `particles`);
//! 2. each grid block adds up the tiles that reach it, in a fixed order, and takes outside influences (`grid`, `push`);
//! 3. bodies of this process exchange contact impulses (`contact`), rigid partners their stand-ins' (`proxy`), walls
//!    stop what runs into them (`walls`);
//! 4. each block of particles reads its tile back: velocity, velocity gradient, position, strain, plastic flow.
//!
//! No two blocks ever write to the same memory and every sum has a fixed order, so the bytes of a state do not depend
//! on the number of threads. No allocation and no lock stands inside steps 1 and 4.
//!
//! Strain is stored as `B = b_e - I` (`math`, `law`), which keeps small strains of spinning bodies to single precision;
//! positions are relative to their block, with the rounding of the last sum beside them (`store`). The length of a
//! substep follows from wave speed, particle speed and strain rate (`stable`); a substep that goes too far is undone and
//! repeated with half the length (`sim`). Impulses of walls, gravity and rigid partners are the changes of the grid's
//! momentum, in f64; the momentum that they must explain is summed over the particles (`report`): two separate roads,
//! so that their difference is a check.
//!
//! Not here yet: granular material and liquid, contact with partners that show samples, moving walls, meshes, height
//! fields, two-dimensional slabs, F-bar for ν near 0.5, restitution, the `genesis` contact law. Each is refused by name.
//!
//! Known limit: grid nodes touch a wall or a rigid partner when they lie behind its surface. A body that arrives from
//! afar therefore stops up to one cell early, and the place of contact moves in steps of a cell.

mod contact;
mod grid;
mod kick;
mod law;
mod math;
mod model;
mod params;
mod particles;
mod parts;
mod plugin;
mod proxy;
mod push;
mod reach;
mod read;
mod read_actions;
mod real;
mod report;
mod sample;
mod save;
mod shape;
mod show;
mod sim;
mod sort;
mod stable;
mod store;
mod tally;
mod tile;
mod topology;
mod transfer;
mod walls;

pub use law::YieldNorm;
pub use plugin::Mpm;
pub use real::{Lanes, Real};
