//! What a recorder has to remember of its run: how many frames it took, and how everything stood in the first one. Where
//! a capture stood then is what its Gaussians are moved from.

use cosplat_core::plugin::{StateError, StateReader, StateSink};
use cosplat_core::visual::{VisualFrame, VisualState};

const POSE: u64 = 0;
const PARTICLES: u64 = 1;

/// The first frame as bytes.
pub(super) fn encode(frame: &VisualFrame) -> Vec<u8> {
    let mut out = Vec::new();
    out.u64(frame.number);
    out.f64(frame.time_s);
    out.u64(frame.bodies.len() as u64);
    for (name, state) in &frame.bodies {
        out.u64(name.len() as u64);
        out.bytes(name.as_bytes());
        match state {
            VisualState::Pose { position, orientation } => {
                out.u64(POSE);
                out.vec3(*position);
                for n in orientation {
                    out.f64(*n);
                }
            }
            VisualState::Particles { position, gradient } => {
                out.u64(PARTICLES);
                out.vec3s(position);
                out.u64(gradient.len() as u64);
                gradient.as_flattened().iter().for_each(|n| out.bytes(&n.to_le_bytes()));
            }
        }
    }
    out
}

/// Reads what [`encode`] wrote.
///
/// # Errors
/// [`StateError`]; nothing is allocated that the bytes do not fill.
pub(super) fn decode(bytes: &[u8]) -> Result<VisualFrame, StateError> {
    let mut input = StateReader::new(bytes);
    let (number, time_s, count) = (input.u64()?, input.f64()?, input.u64()?);
    let mut bodies = Vec::new();
    for _ in 0..count {
        let name = String::from_utf8_lossy(many(&mut input, 1)?).into_owned();
        let state = match input.u64()? {
            POSE => VisualState::Pose {
                position: input.vec3()?,
                orientation: [input.f64()?, input.f64()?, input.f64()?, input.f64()?],
            },
            PARTICLES => {
                let (positions, _) = many(&mut input, 24)?.as_chunks::<24>();
                let (gradients, _) = many(&mut input, 36)?.as_chunks::<36>();
                VisualState::Particles {
                    position: positions.iter().map(f64s).collect(),
                    gradient: gradients.iter().map(f32s).collect(),
                }
            }
            found => return Err(StateError::Count { what: "form of a body", found, expected: PARTICLES }),
        };
        bodies.push((name, state));
    }
    input.end()?;
    Ok(VisualFrame { number, time_s, bodies })
}

/// The bytes of a list, behind its length.
fn many<'a>(input: &mut StateReader<'a>, width: usize) -> Result<&'a [u8], StateError> {
    let count = usize::try_from(input.u64()?).unwrap_or(usize::MAX);
    input.bytes(count.saturating_mul(width))
}

fn f64s(bytes: &[u8; 24]) -> [f64; 3] {
    let (numbers, _) = bytes.as_chunks::<8>();
    std::array::from_fn(|i| f64::from_le_bytes(numbers[i]))
}

fn f32s(bytes: &[u8; 36]) -> [f32; 9] {
    let (numbers, _) = bytes.as_chunks::<4>();
    std::array::from_fn(|i| f32::from_le_bytes(numbers[i]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_frame_comes_back_to_the_bit_and_what_is_cut_is_refused() {
        let pose = VisualState::Pose { position: [0.1, -0.0, 1e300], orientation: [0.0, 0.6, 0.0, 0.8] };
        let gradient = vec![[1.0, 0.1, -0.2, 0.3, 1.1, 0.0, -0.0, 1e-30, 0.9]; 2];
        let soft = VisualState::Particles { position: vec![[0.1, 0.2, 0.3], [4.0, 5.0, 6.0]], gradient };
        let dots = VisualState::Particles { position: vec![[1.0; 3]], gradient: Vec::new() };
        let bodies = vec![("rock".to_owned(), pose), ("plänt".to_owned(), soft), ("dots".to_owned(), dots)];
        let frame = VisualFrame { number: 0, time_s: 0.0, bodies };
        let bytes = encode(&frame);
        assert_eq!(decode(&bytes), Ok(frame));
        for cut in 0..bytes.len() {
            assert!(decode(&bytes[..cut]).is_err(), "cut at {cut}");
        }
    }
}
