//! Point masses and linear springs, integrated exactly over each step.
//!
//! A step has no time-stepping error: the bodies of one solver are advanced by their normal modes, with partners on the
//! path that the coupling scheme gives them (a polynomial of degree 3 at most). What is left against the solution of
//! the whole system is the error of the coupling alone, so this solver measures coupling schemes.
//!
//! Forces are those of vector springs, `F_a = -k (x_a - x_b - rest)`, the same along each axis; `rest` is a vector fixed
//! in the world, so a spring with `rest ≠ 0` exerts a torque on the pair it joins. That torque counts as external.

mod advance;
mod budget;
mod heard;
mod model;
mod modes;
mod plugin;
mod read;
mod stumpff;

use nalgebra::Vector3;

pub use plugin::Oscillator;

/// Three components along the world axes.
type V3 = Vector3<f64>;
