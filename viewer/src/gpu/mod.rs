//! The rasterizer on a graphics processor: the twin of [`crate::render`], in single precision.
//!
//! [`Gpu`] opens a device and draws; [`Renderer`] chooses between it and the processor and says why. All arithmetic of a
//! picture is in the four shaders beside this file, which take the steps of the processor's path one by one: project,
//! sort by depth, bin into tiles of 16 × 16 pixels, blend front to back. Pictures agree up to rounding and to the order of
//! Gaussians whose depths differ by less than it. This folder is the only place that knows wgpu.

mod device;
mod draw;
mod kernels;
mod pack;
mod renderer;
mod sort;

pub use device::{Gpu, GpuError};
pub use renderer::{Choice, Renderer};
