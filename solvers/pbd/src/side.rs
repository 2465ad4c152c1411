//! On which side of a cloth each sample of a partner is.
//!
//! A sample that comes near is on the side where it is. From then on its side of that part of the cloth is remembered for
//! as long as it stays near, and a sample that is found on the other side has gone through: contact brings it back. The
//! sides are those of the cloth, which is a surface whatever its partner is like.

use cosplat_core::plugin::{StateError, StateReader, StateSink};

/// A sample near one layer of a cloth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Side {
    /// The nearest triangle.
    pub(crate) triangle: u32,
    /// Whether the sample is, or ought to be, where the triangle's normal points.
    pub(crate) is_above: bool,
    /// Whether it is on the other side.
    pub(crate) is_through: bool,
}

/// Of the nearest layers.
pub(crate) type Sides = [Option<Side>; 3];

/// Writes the sides of all samples.
pub(crate) fn save(sides: &[Sides], sink: &mut dyn StateSink) {
    let known = || (0_u64..).zip(sides).filter(|(_, sides)| sides.iter().any(Option::is_some));
    sink.u64(known().count() as u64);
    for (i, sides) in known() {
        sink.u64(i);
        for side in sides {
            let code = side.map_or(0, |s| 1 + 2 * u64::from(s.is_above) + 4 * u64::from(s.is_through));
            sink.u64(code | side.map_or(0, |s| u64::from(s.triangle)) << 8);
        }
    }
}

/// Reads them back, for so many samples and triangles.
pub(crate) fn restore(reader: &mut StateReader, [samples, triangles]: [usize; 2]) -> Result<Vec<Sides>, StateError> {
    let mut all = vec![Sides::default(); samples];
    let wrong = |what, found, expected: usize| StateError::Count { what, found, expected: expected as u64 };
    for _ in 0..reader.u64()? {
        let i = reader.u64()?;
        let sides = all.get_mut(i as usize).ok_or_else(|| wrong("samples near cloth", i, samples))?;
        for side in sides {
            let code = reader.u64()?;
            if code & 1 == 0 {
                continue;
            }
            let triangle = code >> 8;
            if triangle >= triangles as u64 {
                return Err(wrong("triangles near samples", triangle, triangles));
            }
            let [is_above, is_through] = [code & 2 != 0, code & 4 != 0];
            *side = Some(Side { triangle: triangle as u32, is_above, is_through });
        }
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_come_back_and_strange_ones_are_refused() {
        let mut sides = vec![Sides::default(); 5];
        sides[3][0] = Some(Side { triangle: 7, is_above: true, is_through: false });
        sides[3][2] = Some(Side { triangle: 2, is_above: false, is_through: true });
        let mut bytes = Vec::new();
        save(&sides, &mut bytes);
        assert_eq!(restore(&mut StateReader::new(&bytes), [5, 8]), Ok(sides));
        assert!(restore(&mut StateReader::new(&bytes), [3, 8]).is_err());
        assert!(restore(&mut StateReader::new(&bytes), [5, 7]).is_err());
    }
}
