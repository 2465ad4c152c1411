//! Pictures of a scene.
//!
//! [`render`] draws Gaussians on the CPU after the reference recipe (elliptical weighted average, tiles of 16 × 16
//! pixels, front to back in display values) and gives the same bytes whatever the number of threads. [`Picture`] is
//! what comes out, [`png`] stores it, [`Shot`] moves the camera, [`Preview`] makes an animation of many, [`psnr`] compares.
//!
//! With the feature `recording`, `recording` writes a run for the rerun viewer; it is the only module that knows rerun.

mod blend;
mod camera;
mod exp;
mod gaussians;
mod picture;
pub mod png;
mod preview;
mod project;
mod psnr;
#[cfg(feature = "recording")]
pub mod recording;
mod render;
mod sh;
mod shot;
mod tiles;

pub use camera::{Camera, CameraError, View};
pub use gaussians::{Gaussians, LengthError};
pub use picture::Picture;
pub use preview::{Preview, PreviewError, PreviewOptions};
pub use psnr::psnr;
pub use render::{Options, render};
pub use shot::{Shot, Stop, Travel};
