//! Motion of a rigid body, in double precision.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::state::{StateError, StateReader, StateSink};
use crate::boundary::Wrench;

type V3 = Vector3<f64>;

/// Motion of a rigid body: 13 numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moving {
    /// Centre of mass \[m\].
    pub position: V3,
    /// From the frame in which its inertia is known to the world.
    pub turn: UnitQuaternion<f64>,
    /// Of the centre of mass \[m/s\].
    pub velocity: V3,
    /// Angular momentum about the centre of mass, world axes \[kg m²/s\].
    pub spin: V3,
}

impl Moving {
    /// Momentum, angular part about the world origin.
    pub fn momentum(&self, mass: f64) -> Wrench {
        let linear = self.velocity * mass;
        Wrench { linear: linear.into(), angular: (self.position.cross(&linear) + self.spin).into() }
    }

    /// Whether every number is one.
    pub fn is_finite(&self) -> bool {
        let turn = self.turn.coords;
        [self.position, self.velocity, self.spin].iter().flat_map(V3::iter).chain(turn.iter()).all(|v| v.is_finite())
    }

    /// Saves several, with their number.
    pub fn save(all: &[Self], sink: &mut dyn StateSink) {
        sink.u64(all.len() as u64);
        for moving in all {
            sink.vec3(moving.position.into());
            moving.turn.coords.iter().for_each(|&c| sink.f64(c));
            sink.vec3(moving.velocity.into());
            sink.vec3(moving.spin.into());
        }
    }

    /// Reads so many back, bit by bit.
    ///
    /// # Errors
    /// There is another number of them, or the bytes end.
    pub fn restore(expected: usize, reader: &mut StateReader<'_>) -> Result<Vec<Self>, StateError> {
        let (found, expected) = (reader.u64()?, expected as u64);
        if found != expected {
            return Err(StateError::Count { what: "rigid bodies", found, expected });
        }
        (0..expected)
            .map(|_| {
                let position = reader.vec3()?.into();
                let [x, y, z, w] = [reader.f64()?, reader.f64()?, reader.f64()?, reader.f64()?];
                // As it was saved: normalising again could change the last bit.
                let turn = UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z));
                Ok(Self { position, turn, velocity: reader.vec3()?.into(), spin: reader.vec3()?.into() })
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comes_back_bit_by_bit_and_in_the_right_number() {
        let moving = Moving {
            position: V3::new(1.0, 2.0, 3.0),
            // Not quite of length 1, as after many steps.
            turn: UnitQuaternion::new_unchecked(Quaternion::new(0.1, 0.7, -0.7, 0.099_999)),
            velocity: V3::new(-0.0, 1e-300, 5.0),
            spin: V3::new(0.5, 0.25, -1.0),
        };
        let mut bytes: Vec<u8> = Vec::new();
        Moving::save(&[moving, moving], &mut bytes);
        let mut reader = StateReader::new(&bytes);
        assert_eq!(Moving::restore(2, &mut reader).unwrap(), [moving, moving]);
        reader.end().unwrap();
        assert!(matches!(Moving::restore(3, &mut StateReader::new(&bytes)), Err(StateError::Count { .. })));
        assert!(Moving::restore(2, &mut StateReader::new(&bytes[..100])).is_err());
        assert!(moving.is_finite() && !Moving { velocity: V3::repeat(f64::NAN), ..moving }.is_finite());
        // p = m v and L = x × p + spin.
        let expected = Wrench { linear: [0.0, 2e-300, 10.0], angular: [20.5, -9.75, -1.0] };
        assert_eq!(moving.momentum(2.0), expected);
    }
}
