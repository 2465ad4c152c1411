//! Pictures of a scene.
//!
//! [`render`] draws Gaussians on the CPU after the reference recipe (elliptical weighted average, tiles of 16 × 16
//! pixels, front to back in display values) and gives the same bytes whatever the number of threads. [`Picture`] is
//! what comes out, [`png`] stores it, [`psnr`] compares.

mod blend;
mod camera;
mod exp;
mod gaussians;
mod picture;
pub mod png;
mod project;
mod psnr;
mod render;
mod sh;
mod tiles;

pub use camera::{Camera, CameraError, View};
pub use gaussians::{Gaussians, LengthError};
pub use picture::Picture;
pub use psnr::psnr;
pub use render::{Options, render};
