//! Pictures of a scene.
//!
//! [`render`] draws Gaussians on the CPU after the reference recipe (elliptical weighted average, tiles of 16 × 16
//! pixels, front to back in display values) and gives the same bytes whatever the number of threads. [`Picture`] is
//! what comes out, [`png`] stores it, [`Shot`] moves the camera, [`Preview`] makes an animation of many, [`psnr`] compares.
//! [`render_layers`] also gives depth, normal, object and flow of each pixel, which [`Layers::encode`] makes files of.
//!
//! With the feature `gpu`, `gpu` draws the same on a graphics processor; it is the only module that knows wgpu.
//! With the feature `recording`, `recording` writes a run for the rerun viewer; it is the only module that knows rerun.

mod beside;
mod blend;
mod camera;
mod exp;
mod gaussians;
#[cfg(feature = "gpu")]
pub mod gpu;
mod layers;
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
mod store;
mod tiles;
mod weights;

pub use camera::{Camera, CameraError, View};
pub use gaussians::{Gaussians, LengthError};
pub use layers::{Layers, NO_OBJECT, Next};
pub use picture::Picture;
pub use preview::{Preview, PreviewError, PreviewOptions};
pub use psnr::psnr;
pub use render::{Options, render, render_layers};
pub use shot::{Shot, Stop, Travel};
pub use store::{Form, Plane, StoreError};
pub use weights::{Seen, weights};
