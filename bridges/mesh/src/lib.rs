//! Triangle meshes: from a file to a body that can be simulated and drawn.
//!
//! [`Prepared::from_file`] reads a file of any format in [`format`](mod@format), welds its vertices and brings it to metres and +z up; the result is the
//! [`TriangleMesh`](cosplat_core::asset::TriangleMesh) that a solver is given. [`surface_samples`] covers it with
//! oriented points, [`poisson_disks`] with points at a least distance, [`SignedDistance`] says what is inside, [`fill`] puts particles there; [`encode`] writes a mesh.
//!
//! Nothing here depends on the number of threads or on the order in which a hash map iterates.

mod cells;
mod disks;
mod distance;
mod error;
mod filling;
pub mod format;
mod prepare;
mod random;
mod sample;
mod thin;
mod triangulate;
mod weld;
mod write;

pub use disks::{Amount, poisson_disks};
pub use distance::SignedDistance;
pub use error::{Fault, MeshError};
pub use filling::fill;
pub use prepare::{Prepared, Recipe, Report};
pub use sample::{SurfaceSamples, surface_samples};
pub use write::encode;
