//! Captured Gaussian splats: from a file to a body that can be simulated, and back to a file any viewer opens.
//!
//! [`format::read_file`] decodes a file into [`Splats`]; [`Similarity`] brings it to metres and to the axes of a scene;
//! [`clean`] removes what is no object, [`components`] says what hangs
//! together; [`fill`] puts simulation proxies inside; [`bind`] ties every Gaussian to
//! particles or to a rigid frame; [`skin`] moves them; [`surfel`] makes Gaussians for bodies that have none. [`stage`] does
//! all of it in one call, and shows the body at any later moment; [`merge`](merge()) makes one file of several bodies; [`liquid_surface`]
//! makes a mesh of a liquid's particles.
//!
//! Nothing here depends on the number of threads or on the order in which a hash map iterates.

pub mod bind;
pub mod clean;
pub mod close;
pub mod components;
pub mod error;
pub mod fill;
pub mod format;
mod grid;
pub mod ground;
mod linalg;
mod liquid;
mod merge;
mod output;
pub mod sequence;
pub mod sh;
mod similarity;
pub mod skin;
mod splats;
pub mod stage;
pub mod surfel;

pub use error::{Fault, SplatError};
pub use liquid::liquid_surface;
pub use merge::{MergeError, merge};
pub use output::OutputFrame;
pub use similarity::{Similarity, SimilarityError};
pub use splats::*;
