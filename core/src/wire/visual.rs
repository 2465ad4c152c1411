//! Payloads of visual states: positions in single precision about an origin, which is more than a picture shows.

use super::arrays::{Reader, Writer, aligned};
use super::payload::{PayloadError, check_length, finite};
use crate::plan::Content;
use crate::visual::{VisualForm, VisualState};

const POSE_NUMBERS: usize = 7;
const ORIGIN_BYTES: usize = 32;

/// Layout in words.
pub(super) fn schema_text(form: VisualForm) -> &'static str {
    match form {
        VisualForm::Pose => "pose/1 position:f64x3 orientation:f64x4",
        VisualForm::Particles { gradients: false } => "particles/1 origin:f64x4 position:f32x3",
        VisualForm::Particles { gradients: true } => "particles/1 origin:f64x4 position:f32x3 gradient:f32x9",
    }
}

/// Bytes of a payload with `count` elements.
pub(super) fn payload_bytes(form: VisualForm, count: usize) -> usize {
    let array = |numbers: usize| aligned(count.saturating_mul(4 * numbers));
    match form {
        VisualForm::Pose => aligned(POSE_NUMBERS * 8),
        VisualForm::Particles { gradients } => {
            ORIGIN_BYTES.saturating_add(array(3)).saturating_add(if gradients { array(9) } else { 0 })
        }
    }
}

/// Payload of a visual state, in chunks behind room for their headers, and its count.
pub fn encode_visual(state: &VisualState) -> (u32, Vec<Vec<u8>>) {
    match state {
        VisualState::Pose { position, orientation } => {
            let mut out = Writer::new(POSE_NUMBERS * 8 + 16);
            let mut numbers = [0.0; POSE_NUMBERS];
            numbers[..3].copy_from_slice(position);
            numbers[3..].copy_from_slice(orientation);
            out.raw(bytemuck::cast_slice(&numbers));
            (1, out.finish())
        }
        VisualState::Particles { position, gradient } => {
            let n = position.len();
            let mut out = Writer::new(n * if gradient.is_empty() { 12 } else { 48 } + 96);
            let origin = position.first().copied().unwrap_or_default();
            out.raw(bytemuck::bytes_of(&[origin[0], origin[1], origin[2], 0.0]));
            out.narrow(position, origin);
            if !gradient.is_empty() {
                out.raw(bytemuck::cast_slice(gradient));
            }
            (n as u32, out.finish())
        }
    }
}

/// Visual state of `count` elements.
///
/// # Errors
/// [`PayloadError`].
pub fn decode_visual(form: VisualForm, count: usize, chunks: &[&[u8]]) -> Result<VisualState, PayloadError> {
    check_length(&Content::Visual { body: String::new(), form }, count, chunks)?;
    let mut input = Reader::new(chunks);
    let state = match form {
        VisualForm::Pose => {
            let n = input.list::<f64>(POSE_NUMBERS);
            VisualState::Pose { position: [n[0], n[1], n[2]], orientation: [n[3], n[4], n[5], n[6]] }
        }
        VisualForm::Particles { gradients } => {
            let origin = input.list::<f64>(4);
            let position = input.widened(count, [origin[0], origin[1], origin[2]]);
            VisualState::Particles { position, gradient: if gradients { input.list(count) } else { Vec::new() } }
        }
    };
    check_visual(&state).map(|()| state)
}

/// Whether all numbers of a visual state are finite.
///
/// # Errors
/// [`PayloadError::NotFinite`].
pub fn check_visual(state: &VisualState) -> Result<(), PayloadError> {
    match state {
        VisualState::Pose { position, orientation } => {
            finite("position", position)?;
            finite("orientation", orientation)
        }
        VisualState::Particles { position, gradient } => {
            finite("position", position.as_flattened())?;
            let wild = gradient.as_flattened().iter().position(|g| !g.is_finite());
            wild.map_or(Ok(()), |index| Err(PayloadError::NotFinite { array: "gradient", index }))
        }
    }
}
