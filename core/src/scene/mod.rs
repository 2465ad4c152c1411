//! The scene: what a user writes, checked and turned into data in SI units.
//!
//! [`read::parse`] takes the text of a scene file and gives a [`Scene`] or every mistake in it as [`Diagnostic`]s;
//! nothing here opens a file. [`presets`] holds published materials by name.

mod diagnostic;
mod material;
mod model;
mod pair;
pub mod presets;
pub mod read;

pub use diagnostic::*;
pub use material::*;
pub use model::*;
pub use pair::*;
