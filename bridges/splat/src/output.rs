//! The frame in which Gaussians are shown or written.

use crate::bind::Frame;
use crate::similarity::Similarity;
use crate::splats::{Axes, Splats};
use crate::stage::Staged;

/// From the world to the frame of a picture or a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutputFrame {
    /// From the world.
    pub from_world: Similarity,
    /// Which way the axes point there.
    pub axes: Axes,
}

impl OutputFrame {
    /// The world itself: metres, +z up.
    pub fn world() -> OutputFrame {
        OutputFrame { from_world: Similarity::identity(), axes: Axes::Scene }
    }

    /// The frame of the file that a body came from, if the body stands at `pose` at t = 0: what the run does not move is
    /// where it was in the file, to the last bit.
    pub fn of_file(body: &Staged, pose: &Frame) -> OutputFrame {
        let to_world = Similarity::from(*pose).after(&body.similarity);
        OutputFrame { from_world: to_world.inverse(), axes: body.source.axes }
    }

    /// Brings Gaussians of a body's frame here, the body at `pose`. Nothing changes where both are the identity.
    pub fn place(&self, splats: &mut Splats, pose: &Frame) {
        self.from_world.after(&Similarity::from(*pose)).apply(splats, self.axes);
    }
}
