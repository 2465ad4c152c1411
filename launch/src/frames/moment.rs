//! What a recording is given of a frame.

use cosplat_core::boundary::Vec3;
use cosplat_splat::Splats;
use cosplat_viewer::recording::{Recording, RecordingError};

use super::body::borrowed;

/// Length of an arrow for an impulse \[m/(N s)\].
const ARROW: f64 = 0.2;
/// Radius of a boundary particle in a recording \[m\]; the viewer can show them larger.
const DOT_M: f32 = 0.001;
const DOT_COLOUR: [u8; 4] = [255, 160, 40, 255];
/// Boundary particles of a body that are recorded, about: enough to see where it is felt; they cost as much as the places
/// of Gaussians.
pub(super) const DOTS: usize = 4096;

/// Something that is seen, in the world or in the frame of its entity.
#[derive(Clone, Debug)]
pub(super) enum Item {
    /// Gaussians that nothing but a pose moves.
    Fixed(Splats),
    /// Gaussians now.
    Moving(Splats),
    /// Boundary samples that nothing but a pose moves.
    FixedDots(Vec<[f32; 3]>),
    /// Boundary particles now.
    Dots(Vec<[f32; 3]>),
    /// Where an entity is now.
    Pose(Vec3, [f64; 4]),
    /// An impulse \[N s\] and where it acts.
    Impulse(Vec3, Vec3),
}

impl Item {
    /// Writes it at the current frame; of moving Gaussians at most `most`, evenly chosen.
    pub(super) fn put(&self, recording: &mut Recording, entity: &str, most: usize) -> Result<(), RecordingError> {
        match self {
            Self::Fixed(splats) => recording.static_splats(entity, &borrowed(splats)),
            Self::Moving(splats) if splats.len() > most => {
                recording.splats(entity, &borrowed(&splats.select(&thinned(splats.len(), most))))
            }
            Self::Moving(splats) => recording.splats(entity, &borrowed(splats)),
            Self::FixedDots(points) => recording.static_points(entity, points, &[DOT_COLOUR], &[DOT_M]),
            Self::Dots(points) => recording.points(entity, points, &[DOT_COLOUR], &[DOT_M]),
            Self::Pose(position, orientation) => recording.transform(entity, *position, *orientation),
            Self::Impulse(at, impulse) => recording.arrow(entity, *at, impulse.map(|j| j * ARROW)),
        }
    }
}

/// At most `most` of `count` numbers, evenly chosen.
fn thinned(count: usize, most: usize) -> Vec<u32> {
    (0..count).step_by(count.div_ceil(most.max(1)).max(1)).map(|i| i as u32).collect()
}

/// Boundary particles, thinned.
pub(super) fn dots(positions_m: impl ExactSizeIterator<Item = [f32; 3]>) -> Vec<[f32; 3]> {
    let step = positions_m.len().div_ceil(DOTS).max(1);
    positions_m.step_by(step).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_too_much_is_thinned_evenly() {
        assert_eq!(thinned(10, 20), (0..10).collect::<Vec<u32>>());
        assert_eq!(thinned(10, 4), [0, 3, 6, 9]);
        assert_eq!(thinned(10, 0).len(), 1);
        assert_eq!(dots((0..2 * DOTS).map(|_| [0.0; 3])).len(), DOTS);
    }
}
