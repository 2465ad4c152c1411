//! On which side of a partner's samples each point of a cloth is.
//!
//! A point that comes near is on the side where it is. From then on its side is remembered, and turns only as the point
//! goes round: a direction that turns by more than 120° between two looks has gone through.

use cosplat_core::boundary::Vec3;
use cosplat_core::plugin::{StateError, StateReader, StateSink};

/// Cosine beyond which a turn between two looks is no way round.
pub(crate) const THROUGH: f64 = -0.5;

/// A point of a cloth near a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Side {
    /// The nearest sample.
    pub(crate) sample: u32,
    /// Unit vector to the side on which the point is, or ought to be.
    pub(crate) out: Vec3,
    /// Distance of the surfaces \[m\].
    pub(crate) gap: f64,
    /// Whether the middle of the cloth is behind the middle of the sample.
    pub(crate) beyond: bool,
}

/// Writes the sides of all points.
pub(crate) fn save(sides: &[Option<Side>], sink: &mut dyn StateSink) {
    let known = || (0_u64..).zip(sides).filter_map(|(i, side)| Some((i, (*side)?)));
    sink.u64(known().count() as u64);
    for (i, side) in known() {
        sink.u64(i);
        sink.u64(side.sample.into());
        sink.u64(side.beyond.into());
        sink.vec3(side.out);
    }
}

/// Reads them back, for so many points and samples.
pub(crate) fn restore(
    reader: &mut StateReader,
    [points, samples]: [usize; 2],
) -> Result<Vec<Option<Side>>, StateError> {
    let mut sides = vec![None; points];
    for _ in 0..reader.u64()? {
        let (i, sample, beyond) = (reader.u64()?, reader.u64()?, reader.u64()? != 0);
        let out = reader.vec3()?;
        let wrong = |what, found, expected: usize| StateError::Count { what, found, expected: expected as u64 };
        let side = sides.get_mut(i as usize).ok_or_else(|| wrong("points near samples", i, points))?;
        if sample >= samples as u64 {
            return Err(wrong("samples that points are near", sample, samples));
        }
        *side = Some(Side { sample: sample as u32, out, gap: 0.0, beyond });
    }
    Ok(sides)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_come_back_and_strange_ones_are_refused() {
        let mut sides = vec![None; 5];
        sides[3] = Some(Side { sample: 7, out: [0.0, 0.6, -0.8], gap: 0.0, beyond: true });
        let mut bytes = Vec::new();
        save(&sides, &mut bytes);
        assert_eq!(restore(&mut StateReader::new(&bytes), [5, 8]), Ok(sides));
        assert!(restore(&mut StateReader::new(&bytes), [3, 8]).is_err());
        assert!(restore(&mut StateReader::new(&bytes), [5, 7]).is_err());
    }
}
