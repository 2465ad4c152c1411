//! Recordings for the rerun viewer: an `.rrd` file, or the same sent to a viewer that is open. Nothing is bound or
//! spawned here.
//!
//! What stays as it is logged once: higher bands of Gaussians, and everything below an entity that only a
//! [`Recording::transform`] moves. Sizes, directions and colours of Gaussians are logged again when they differ visibly.
//! Curves are gathered and written as columns. [`Recording::flush`] hands all of it to the system, so that a run that is
//! killed leaves a file that can be read up to its last flush.
//!
//! The content is the same for the same run, and so is its order; the bytes are not, because rerun gives every row and
//! chunk an identity made of the clock and a random number.

pub mod diagram;
mod gaussians;
mod layout;

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Display;
use std::net::SocketAddr;
use std::path::Path;
use std::time::Duration;

use rerun::external::re_sdk_types::components::ViewCoordinates;
use rerun::log::ChunkBatcherConfig;
use rerun::{
    Arrows3D, AsComponents, Color, Points3D, Quaternion, RecordingStream, RecordingStreamBuilder, Scalars, SeriesLines,
    TimeColumn, Transform3D,
};
use thiserror::Error;

use gaussians::Written;
pub use layout::{Curves, Layout};

use crate::gaussians::{Gaussians, LengthError};

/// Timeline of simulated seconds.
pub const TIME: &str = "simulated_time";
/// Timeline of coupling windows.
pub const WINDOW: &str = "window";
/// Entity above everything that has a place.
pub const WORLD: &str = "world";

/// A file that cannot answer for this long is given up.
const PATIENCE: Duration = Duration::from_mins(1);
/// A viewer that takes nothing for this long is given up.
const PATIENCE_LIVE: Duration = Duration::from_secs(5);

/// A recording that cannot be written.
#[derive(Debug, Error)]
pub enum RecordingError {
    /// The file cannot be made.
    #[error("{0}: the recording cannot be created: {1}; check the path and its permissions")]
    Create(String, String),
    /// Nobody can be reached under that address.
    #[error("{0}: no viewer can be reached: {1}")]
    Connect(String, String),
    /// Something cannot be written.
    #[error("{0}: the recording cannot be written: {1}; check that there is room")]
    Write(String, String),
    /// Arrays of Gaussians that do not fit together.
    #[error("{0}: {1}")]
    Gaussians(String, LengthError),
    /// Arrays of points that do not fit together.
    #[error("{entity}: {count} points need 1 or {count} {array}, and {has} were given")]
    Points {
        /// Entity.
        entity: String,
        /// Points given.
        count: usize,
        /// What does not fit them.
        array: &'static str,
        /// How many there are.
        has: usize,
    },
}

/// A point of a curve: window, moment \[s\], value.
type Point = (i64, f64, f64);

/// Writes a recording. Entities are paths such as `world/jelly`; times are simulated.
pub struct Recording {
    stream: RecordingStream,
    /// Name of the file or address, for errors.
    name: String,
    /// How long a flush may take.
    patience: Duration,
    /// Gaussians as they are written by now, by entity.
    splats: BTreeMap<String, Written>,
    /// Curves that have a name.
    named: BTreeSet<String>,
    /// Points of curves that are not written yet.
    pending: BTreeMap<String, Vec<Point>>,
}

impl std::fmt::Debug for Recording {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Recording").field("name", &self.name).finish_non_exhaustive()
    }
}

impl Recording {
    /// Creates the file, with the layout in which the viewer opens it.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn create(path: &Path, layout: &Layout<'_>) -> Result<Recording, RecordingError> {
        let name = path.display().to_string();
        let made = builder(layout).save(path).map_err(|e| RecordingError::Create(name.clone(), e.to_string()));
        Recording::begin(made?, name, PATIENCE, layout)
    }

    /// Sends to a viewer, or to what passes on to viewers, that listens at an address. Whoever calls this waits for it
    /// whenever it takes nothing.
    ///
    /// # Errors
    /// It cannot be reached, or takes nothing.
    pub fn connect(address: SocketAddr, layout: &Layout<'_>) -> Result<Recording, RecordingError> {
        let url = url(address);
        let made = builder(layout).connect_grpc_opts(url.clone());
        let made = made.map_err(|e| RecordingError::Connect(url.clone(), e.to_string()));
        Recording::begin(made?, url, PATIENCE_LIVE, layout)
    }

    fn begin(
        stream: RecordingStream,
        name: String,
        patience: Duration,
        layout: &Layout<'_>,
    ) -> Result<Recording, RecordingError> {
        stream.set_log_time_enabled(false);
        stream.set_log_tick_enabled(false);
        let (splats, named, pending) = (BTreeMap::new(), BTreeSet::new(), BTreeMap::new());
        let recording = Recording { stream, name, patience, splats, named, pending };
        recording.written(recording.stream.send_recording_name(layout.scene))?;
        recording.written(layout.send(&recording.stream))?;
        let axes = ViewCoordinates::from_up_and_handedness(layout.up_axis(), rerun::coordinates::Handedness::Right);
        recording.fixed(WORLD, &rerun::archetypes::ViewCoordinates::new(axes))?;
        recording.flush_stream()?;
        Ok(recording)
    }

    /// What is logged from now on belongs to this window and moment \[s\].
    pub fn frame(&mut self, window: u64, time_s: f64) {
        self.stream.set_time_sequence(WINDOW, count(window));
        self.stream.set_duration_secs(TIME, time_s);
    }

    /// Gaussians that never change on their own; a [`Recording::transform`] of the same entity may move them.
    ///
    /// # Errors
    /// Arrays that do not fit together, or the file cannot be written.
    pub fn static_splats(&mut self, entity: &str, gaussians: &Gaussians<'_>) -> Result<(), RecordingError> {
        check(entity, gaussians)?;
        self.fixed(entity, &gaussians::whole(gaussians))?;
        self.fixed(entity, &gaussians::bands(gaussians))
    }

    /// Gaussians at the current frame: 12 bytes each for their places before compression; 12 more where one in a hundred
    /// differs by 5 % in size from what is written, 16 where one in a hundred differs by a degree in direction, and 4
    /// where a colour differs. Higher bands are those of the first call, and logged once.
    ///
    /// # Errors
    /// Arrays that do not fit together, or the file cannot be written.
    pub fn splats(&mut self, entity: &str, gaussians: &Gaussians<'_>) -> Result<(), RecordingError> {
        check(entity, gaussians)?;
        if let Some(written) = self.splats.get_mut(entity) {
            let news = written.news(gaussians);
            return self.now(entity, &news);
        }
        self.splats.insert(entity.to_owned(), Written::new(gaussians));
        self.fixed(entity, &gaussians::bands(gaussians))?;
        self.now(entity, &gaussians::whole(gaussians))
    }

    /// Points at the current frame; `colours` (red, green, blue, opacity) and `radii_m` hold one value for all or one
    /// each.
    ///
    /// # Errors
    /// Arrays that do not fit together, or the file cannot be written.
    pub fn points(
        &mut self,
        entity: &str,
        positions_m: &[[f32; 3]],
        colours: &[[u8; 4]],
        radii_m: &[f32],
    ) -> Result<(), RecordingError> {
        self.now(entity, &points(entity, positions_m, colours, radii_m)?)
    }

    /// Points that never change on their own; a [`Recording::transform`] of the same entity may move them.
    ///
    /// # Errors
    /// Arrays that do not fit together, or the file cannot be written.
    pub fn static_points(
        &mut self,
        entity: &str,
        positions_m: &[[f32; 3]],
        colours: &[[u8; 4]],
        radii_m: &[f32],
    ) -> Result<(), RecordingError> {
        self.fixed(entity, &points(entity, positions_m, colours, radii_m)?)
    }

    /// An arrow at the current frame: an impulse, a force or a velocity, in lengths of the scene. The arrow stays until
    /// the entity gets another; a vector of zero shows none.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn arrow(&mut self, entity: &str, origin_m: [f64; 3], vector: [f64; 3]) -> Result<(), RecordingError> {
        self.now(entity, &Arrows3D::from_vectors([single(vector)]).with_origins([single(origin_m)]))
    }

    /// Pose of an entity and of everything below it at the current frame; `orientation` is a unit quaternion
    /// `[x, y, z, w]`.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn transform(
        &mut self,
        entity: &str,
        position_m: [f64; 3],
        orientation: [f64; 4],
    ) -> Result<(), RecordingError> {
        let turn = Quaternion::from_xyzw(orientation.map(|c| c as f32));
        self.now(entity, &Transform3D::from_translation_rotation(single(position_m), turn))
    }

    /// A point of a curve; [`Curves::path`] tells in which plot it is shown. The current frame does not matter.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn series(&mut self, path: &str, window: u64, time_s: f64, value: f64) -> Result<(), RecordingError> {
        if self.named.insert(path.to_owned()) {
            let name = path.rsplit('/').next().unwrap_or(path);
            self.fixed(path, &SeriesLines::new().with_names([name]))?;
        }
        self.pending.entry(path.to_owned()).or_default().push((count(window), time_s, value));
        Ok(())
    }

    /// Hands everything to the system.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn flush(&mut self) -> Result<(), RecordingError> {
        for (path, points) in std::mem::take(&mut self.pending) {
            let windows = TimeColumn::new_sequence(WINDOW, points.iter().map(|p| p.0));
            let moments = TimeColumn::new_duration_secs(TIME, points.iter().map(|p| p.1));
            let values = Scalars::new(points.iter().map(|p| p.2)).columns_of_unit_batches();
            let columns = self.written(values)?;
            self.written(self.stream.send_columns(path, [windows, moments], columns))?;
        }
        self.flush_stream()
    }

    /// Writes what is left, and the index at the end of the file.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn finish(mut self) -> Result<(), RecordingError> {
        self.flush()?;
        // The index is written when the file is closed, which this waits for.
        self.stream.disconnect();
        Ok(())
    }

    fn flush_stream(&self) -> Result<(), RecordingError> {
        self.written(self.stream.flush_with_timeout(self.patience))
    }

    fn fixed(&self, entity: &str, what: &impl AsComponents) -> Result<(), RecordingError> {
        self.written(self.stream.log_static(entity, what))
    }

    fn now(&self, entity: &str, what: &impl AsComponents) -> Result<(), RecordingError> {
        self.written(self.stream.log(entity, what))
    }

    fn written<T, E: Display>(&self, result: Result<T, E>) -> Result<T, RecordingError> {
        result.map_err(|error| RecordingError::Write(self.name.clone(), error.to_string()))
    }
}

impl Drop for Recording {
    fn drop(&mut self) {
        // Nobody is left to tell: whoever wants to know calls `finish`.
        let _ = self.flush();
    }
}

/// The address under which a viewer listens, as the viewer itself takes it.
pub fn url(address: SocketAddr) -> String {
    format!("rerun+http://{address}/proxy")
}

/// Chunks are cut where this module flushes, never by the wall clock.
fn builder(layout: &Layout<'_>) -> RecordingStreamBuilder {
    let builder = RecordingStreamBuilder::new(layout.application()).enabled(true);
    builder.recording_id(layout.run).batcher_config(ChunkBatcherConfig::NEVER)
}

fn points(
    entity: &str,
    positions_m: &[[f32; 3]],
    colours: &[[u8; 4]],
    radii_m: &[f32],
) -> Result<Points3D, RecordingError> {
    let count = positions_m.len();
    for (array, has) in [("colours", colours.len()), ("radii", radii_m.len())] {
        if has != 1 && has != count {
            return Err(RecordingError::Points { entity: entity.to_owned(), count, array, has });
        }
    }
    let colours = colours.iter().map(|&[r, g, b, a]| Color::from_unmultiplied_rgba(r, g, b, a));
    Ok(Points3D::new(positions_m.iter().copied()).with_colors(colours).with_radii(radii_m.iter().copied()))
}

fn check(entity: &str, gaussians: &Gaussians<'_>) -> Result<(), RecordingError> {
    gaussians.check().map_err(|error| RecordingError::Gaussians(entity.to_owned(), error))
}

/// A window as a sequence number.
fn count(window: u64) -> i64 {
    i64::try_from(window).unwrap_or(i64::MAX)
}

fn single(v: [f64; 3]) -> [f32; 3] {
    v.map(|c| c as f32)
}
