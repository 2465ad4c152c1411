//! What is made of frames, and where.

use std::path::PathBuf;

use cosplat_core::plan::LeftOut;
use cosplat_core::scene::OutputSpec;
use cosplat_viewer::Shot;

use super::rows::Row;
use super::{Drawn, Liquid, LiveTo};
use crate::folder::{PICTURES, SPLATS};

/// What is to be made.
pub(crate) struct Wanted {
    /// The run folder.
    pub(crate) folder: PathBuf,
    /// Name of the scene.
    pub(crate) scene: String,
    /// Identity of this run, for the recording.
    pub(crate) run: String,
    /// Name of the recording of this life of the run.
    pub(crate) recording: String,
    /// Whether the run keeps checkpoints.
    pub(crate) is_kept: bool,
    /// What the scene asks for.
    pub(crate) output: OutputSpec,
    /// Frames per simulated second.
    pub(crate) frames_per_second: f64,
    /// Windows from one frame to the next.
    pub(crate) windows_per_frame: u64,
    /// Where pictures are taken from, in the world.
    pub(crate) shot: Shot,
    /// Where it is shown while the run goes on.
    pub(crate) live: Option<LiveTo>,
    /// Liquids, of which surfaces may be wanted.
    pub(crate) liquids: Vec<Liquid>,
    /// All that is drawn.
    pub(crate) drawn: Vec<Drawn>,
    /// Curves and impulses, as windows are settled.
    pub(crate) rows: std::sync::mpsc::Receiver<Row>,
}

/// What was made.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Frames {
    /// Frames taken.
    pub(crate) taken: u64,
    /// Pictures, below the run folder, in order.
    pub(crate) pictures: Vec<String>,
    /// Splat files, below the run folder, in order.
    pub(crate) splats: Vec<String>,
    /// Surfaces of liquids, below the run folder, in order.
    pub(crate) surfaces: Vec<String>,
    /// Whether there is a film.
    pub(crate) has_film: bool,
    /// Who drew, and why.
    pub(crate) drawn_by: String,
    /// What could not be made, and why.
    pub(crate) left_out: Vec<LeftOut>,
    /// Wall time of moving Gaussians \[s\].
    pub(crate) skin_s: f64,
    /// Wall time of drawing and writing pictures \[s\].
    pub(crate) draw_s: f64,
    /// Wall time of writing splat files and surfaces \[s\].
    pub(crate) write_s: f64,
    /// Wall time of recording \[s\].
    pub(crate) record_s: f64,
}

/// Name of a picture, below the run folder.
pub(crate) fn picture(number: u64) -> String {
    format!("{PICTURES}/frame_{number:04}.png")
}

/// Name of a splat file, below the run folder.
pub(super) fn splats(number: u64, ending: &str) -> String {
    format!("{SPLATS}/frame_{number:04}.{ending}")
}
