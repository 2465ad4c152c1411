//! Payload layouts.

use std::ops::Range;

use xxhash_rust::xxh3::xxh3_64;

use super::arrays::{Reader, Writer, aligned};
use super::visual;
use crate::boundary::{BoundaryState, Impulses, ProxyRecord, SampleStatics, Samples, Vec3, Wrench, add};
use crate::plan::{BoundaryForm, Content};
use crate::visual::VisualForm;

/// Bytes that do not hold what their stream carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PayloadError {
    /// The length does not follow from the count.
    #[error("{found} bytes instead of {expected}")]
    Length {
        /// Expected.
        expected: usize,
        /// Found.
        found: usize,
    },
    /// A rigid body is one element.
    #[error("{found} elements where there is one")]
    Count {
        /// Found.
        found: usize,
    },
    /// NaN or infinity where a finite number belongs.
    #[error("number {index} of `{array}` is not finite")]
    NotFinite {
        /// Array.
        array: &'static str,
        /// Place in it, components counted apart.
        index: usize,
    },
}

/// Layout in words; its hash is in every header, so that a changed type is refused at the first frame.
pub fn schema_text(content: &Content) -> &'static str {
    match content {
        Content::Statics { .. } => "statics/1 id:u64 area:f64 volume:f64 mass:f64",
        Content::Boundary { form, .. } | Content::MidBoundary { form, .. } => match form {
            BoundaryForm::SamplesF32 { normals: false } => "samples/1 origin:f64x4 position:f32x3 velocity:f32x3",
            BoundaryForm::SamplesF32 { normals: true } => {
                "samples/1 origin:f64x4 position:f32x3 velocity:f32x3 normal:f32x3"
            }
            BoundaryForm::SamplesF64 { normals: false } => "samples/1 position:f64x3 velocity:f64x3",
            BoundaryForm::SamplesF64 { normals: true } => "samples/1 position:f64x3 velocity:f64x3 normal:f64x3",
            BoundaryForm::Proxy => {
                "proxy/1 position:f64x3 orientation:f64x4 velocity:f64x3 angular_velocity:f64x3 mass:f64 inertia:f64x6 \
                 share:f64 background:f64x3 angular_background:f64x3"
            }
        },
        Content::Impulses { form: BoundaryForm::Proxy, .. } => "wrench/1 impulse:f64x3 angular_impulse:f64x3",
        Content::Impulses { .. } => "impulses/1 impulse:f64x3",
        Content::Visual { form, .. } => visual::schema_text(*form),
    }
}

/// Hash of [`schema_text`].
pub fn schema_hash(content: &Content) -> u64 {
    xxh3_64(schema_text(content).as_bytes())
}

const PROXY_NUMBERS: usize = 27;
/// Places of the numbers of a proxy record that are finite for every body.
const PROXY_ARRAYS: [(&str, Range<usize>); 7] = [
    ("position", 0..3),
    ("orientation", 3..7),
    ("velocity", 7..10),
    ("angular velocity", 10..13),
    ("share", 20..21),
    ("background", 21..24),
    ("angular background", 24..27),
];
/// Places of its mass and inertia.
const INERTIAL: Range<usize> = 13..20;
const WRENCH_NUMBERS: usize = 6;
const ORIGIN_BYTES: usize = 32;

/// Bytes of a payload with `count` elements; [`usize::MAX`], which no payload has, where there is no such number.
pub fn payload_bytes(content: &Content, count: usize) -> usize {
    let arrays = |number: usize, width: usize| aligned(count.saturating_mul(width)).saturating_mul(number);
    let vectors = |number: usize, width: usize| arrays(number, 3 * width);
    match content {
        Content::Statics { .. } => arrays(4, 8),
        Content::Boundary { form, .. } | Content::MidBoundary { form, .. } => match form {
            BoundaryForm::SamplesF32 { normals } => vectors(2 + usize::from(*normals), 4).saturating_add(ORIGIN_BYTES),
            BoundaryForm::SamplesF64 { normals } => vectors(2 + usize::from(*normals), 8),
            BoundaryForm::Proxy => aligned(PROXY_NUMBERS * 8),
        },
        Content::Impulses { form: BoundaryForm::Proxy, .. } => aligned(WRENCH_NUMBERS * 8),
        Content::Impulses { .. } => vectors(1, 8),
        Content::Visual { form, .. } => visual::payload_bytes(*form, count),
    }
}

/// Payload of a boundary, in chunks behind room for their headers, and its count.
pub fn encode_boundary(form: BoundaryForm, state: &BoundaryState) -> (u32, Vec<Vec<u8>>) {
    match state {
        BoundaryState::Proxy(p) => {
            let mut numbers = Vec::with_capacity(PROXY_NUMBERS);
            numbers.extend(p.position);
            numbers.extend(p.orientation);
            numbers.extend(p.linear_velocity);
            numbers.extend(p.angular_velocity);
            numbers.push(p.mass);
            numbers.extend(p.inertia);
            numbers.push(p.share);
            numbers.extend(p.background_linear);
            numbers.extend(p.background_angular);
            let mut out = Writer::new(numbers.len() * 8 + 16);
            out.raw(bytemuck::cast_slice(&numbers));
            (1, out.finish())
        }
        BoundaryState::Samples(s) => {
            let n = s.position.len();
            let single = matches!(form, BoundaryForm::SamplesF32 { .. });
            let normals = has_normals(form);
            let mut out = Writer::new(n * if single { 36 } else { 72 } + 128);
            if single {
                let origin = s.position.first().copied().unwrap_or_default();
                out.raw(bytemuck::bytes_of(&[origin[0], origin[1], origin[2], 0.0]));
                out.narrow(&s.position, origin);
                out.narrow(&s.velocity, [0.0; 3]);
                if normals {
                    out.narrow(&s.normal, [0.0; 3]);
                }
            } else {
                out.raw(bytemuck::cast_slice(&s.position));
                out.raw(bytemuck::cast_slice(&s.velocity));
                if normals {
                    out.raw(bytemuck::cast_slice(&s.normal));
                }
            }
            (n as u32, out.finish())
        }
    }
}

fn has_normals(form: BoundaryForm) -> bool {
    matches!(form, BoundaryForm::SamplesF32 { normals: true } | BoundaryForm::SamplesF64 { normals: true })
}

/// Boundary of `count` elements.
///
/// # Errors
/// [`PayloadError`].
pub fn decode_boundary(form: BoundaryForm, count: usize, chunks: &[&[u8]]) -> Result<BoundaryState, PayloadError> {
    let content = Content::Boundary { body: String::new(), form };
    check_length(&content, count, chunks)?;
    let mut input = Reader::new(chunks);
    if form == BoundaryForm::Proxy {
        return decode_proxy(&input.list::<f64>(PROXY_NUMBERS)).map(BoundaryState::Proxy);
    }
    let samples = if matches!(form, BoundaryForm::SamplesF32 { .. }) {
        let origin = input.list::<f64>(4);
        let origin = [origin[0], origin[1], origin[2]];
        Samples {
            position: input.widened(count, origin),
            velocity: input.widened(count, [0.0; 3]),
            normal: if has_normals(form) { input.widened(count, [0.0; 3]) } else { Vec::new() },
        }
    } else {
        Samples {
            position: input.list(count),
            velocity: input.list(count),
            normal: if has_normals(form) { input.list(count) } else { Vec::new() },
        }
    };
    check_samples(&samples)?;
    Ok(BoundaryState::Samples(samples))
}

/// Position of one element in the chunks of an encoded boundary, without decoding the others; `None` where they end
/// before it.
pub fn place(form: BoundaryForm, chunks: &[&[u8]], element: usize) -> Option<Vec3> {
    let origin = if matches!(form, BoundaryForm::SamplesF32 { .. }) { ORIGIN_BYTES } else { 0 };
    if origin == 0 {
        return numbers::<[f64; 3]>(chunks, element.checked_mul(size_of::<[f64; 3]>())?);
    }
    let offset: [f32; 3] = numbers(chunks, origin.checked_add(element.checked_mul(size_of::<[f32; 3]>())?)?)?;
    Some(add(offset.map(f64::from), numbers(chunks, 0)?))
}

/// Numbers that begin `at` bytes behind the start, across the borders of chunks.
fn numbers<T: bytemuck::Pod>(chunks: &[&[u8]], mut at: usize) -> Option<T> {
    let mut value = T::zeroed();
    let mut left = bytemuck::bytes_of_mut(&mut value);
    for chunk in chunks {
        let Some(rest) = chunk.get(at..) else {
            at -= chunk.len();
            continue;
        };
        let (now, later) = left.split_at_mut(rest.len().min(left.len()));
        now.copy_from_slice(&rest[..now.len()]);
        (left, at) = (later, 0);
        if left.is_empty() {
            return Some(value);
        }
    }
    None
}

/// Whether all numbers of a set of samples are finite: asked by the sender, who is to blame, and by the reader.
///
/// # Errors
/// [`PayloadError::NotFinite`].
pub fn check_samples(samples: &Samples) -> Result<(), PayloadError> {
    finite("position", samples.position.as_flattened())?;
    finite("velocity", samples.velocity.as_flattened())?;
    finite("normal", samples.normal.as_flattened())
}

/// Whether all impulses are finite.
///
/// # Errors
/// [`PayloadError::NotFinite`].
pub fn check_impulses(impulses: &Impulses) -> Result<(), PayloadError> {
    match impulses {
        Impulses::Samples(each) => finite("impulse", each.as_flattened()),
        Impulses::Rigid(w) => finite("impulse", [w.linear, w.angular].as_flattened()),
    }
}

fn decode_proxy(n: &[f64]) -> Result<ProxyRecord, PayloadError> {
    let three = |at: usize| [n[at], n[at + 1], n[at + 2]];
    let record = ProxyRecord {
        position: three(0),
        orientation: [n[3], n[4], n[5], n[6]],
        linear_velocity: three(7),
        angular_velocity: three(10),
        mass: n[13],
        inertia: [n[14], n[15], n[16], n[17], n[18], n[19]],
        share: n[20],
        background_linear: three(21),
        background_angular: three(24),
    };
    for (array, places) in PROXY_ARRAYS {
        finite(array, &n[places])?;
    }
    // A scripted body has infinite mass and inertia.
    match n[INERTIAL].iter().position(|m| m.is_nan() || *m == f64::NEG_INFINITY) {
        Some(index) => Err(PayloadError::NotFinite { array: "mass and inertia", index }),
        None => Ok(record),
    }
}

/// Payload of a body's statics, as of a boundary.
pub fn encode_statics(statics: &SampleStatics) -> (u32, Vec<Vec<u8>>) {
    let mut out = Writer::new(statics.len() * 32 + 64);
    out.raw(bytemuck::cast_slice(&statics.id));
    out.raw(bytemuck::cast_slice(&statics.area_m2));
    out.raw(bytemuck::cast_slice(&statics.volume_m3));
    out.raw(bytemuck::cast_slice(&statics.mass_kg));
    (statics.len() as u32, out.finish())
}

/// Statics of `count` samples.
///
/// # Errors
/// [`PayloadError`].
pub fn decode_statics(count: usize, chunks: &[&[u8]]) -> Result<SampleStatics, PayloadError> {
    check_length(&Content::Statics { body: String::new() }, count, chunks)?;
    let mut input = Reader::new(chunks);
    let statics = SampleStatics {
        id: input.list(count),
        area_m2: input.list(count),
        volume_m3: input.list(count),
        mass_kg: input.list(count),
    };
    finite("area", &statics.area_m2)?;
    finite("volume", &statics.volume_m3)?;
    finite("mass", &statics.mass_kg)?;
    Ok(statics)
}

/// Payload of impulses, as of a boundary.
pub fn encode_impulses(impulses: &Impulses) -> (u32, Vec<Vec<u8>>) {
    match impulses {
        Impulses::Samples(each) => {
            let mut out = Writer::new(each.len() * 24 + 16);
            out.raw(bytemuck::cast_slice(each));
            (each.len() as u32, out.finish())
        }
        Impulses::Rigid(w) => {
            let mut out = Writer::new(WRENCH_NUMBERS * 8);
            out.raw(bytemuck::bytes_of(&[w.linear, w.angular]));
            (1, out.finish())
        }
    }
}

/// Impulses on a boundary of form `form` with `count` elements.
///
/// # Errors
/// [`PayloadError`].
pub fn decode_impulses(form: BoundaryForm, count: usize, chunks: &[&[u8]]) -> Result<Impulses, PayloadError> {
    check_length(&Content::Impulses { interface: 0, form }, count, chunks)?;
    let mut input = Reader::new(chunks);
    if form == BoundaryForm::Proxy {
        let n = input.list::<f64>(WRENCH_NUMBERS);
        let wrench = Impulses::Rigid(Wrench { linear: [n[0], n[1], n[2]], angular: [n[3], n[4], n[5]] });
        return check_impulses(&wrench).map(|()| wrench);
    }
    let each = Impulses::Samples(input.list(count));
    check_impulses(&each).map(|()| each)
}

/// Whether `chunks` can hold `count` elements; after this nothing is allocated that they do not fill.
pub(super) fn check_length(content: &Content, count: usize, chunks: &[&[u8]]) -> Result<(), PayloadError> {
    use Content::{Boundary, Impulses, MidBoundary, Visual};
    if count != 1
        && let Boundary { form: BoundaryForm::Proxy, .. }
        | MidBoundary { form: BoundaryForm::Proxy, .. }
        | Impulses { form: BoundaryForm::Proxy, .. }
        | Visual { form: VisualForm::Pose, .. } = content
    {
        return Err(PayloadError::Count { found: count });
    }
    let (expected, found) = (payload_bytes(content, count), chunks.iter().map(|chunk| chunk.len()).sum());
    if found == expected { Ok(()) } else { Err(PayloadError::Length { expected, found }) }
}

pub(super) fn finite(array: &'static str, values: &[f64]) -> Result<(), PayloadError> {
    if all_finite(values) {
        return Ok(());
    }
    match values.iter().position(|v| !v.is_finite()) {
        Some(index) => Err(PayloadError::NotFinite { array, index }),
        None => Ok(()),
    }
}

/// Zero times a number is zero for a finite one and NaN for any other. Several sums, so that none waits for another.
fn all_finite(values: &[f64]) -> bool {
    let (blocks, rest) = values.as_chunks::<8>();
    let mut sums = [0.0; 8];
    for block in blocks {
        for (sum, value) in sums.iter_mut().zip(block) {
            *sum += value * 0.0;
        }
    }
    sums.iter().all(|s| *s == 0.0) && rest.iter().all(|v| v.is_finite())
}
