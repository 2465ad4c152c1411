//! By-products of a picture as files that other programs read.
//!
//! | ending | what it holds |
//! |---|---|
//! | `.npy` | the numbers as they are, for `numpy.load`: rows, columns and components; `float32`, objects `uint32` |
//! | `.png` | 16 bits: opacity · 65535; depth in thousandths of a unit; (normal + 1) / 2 · 65535; object + 1; flow below |
//! | `.flo` | flow alone: 202021.25, width, height, then right and down of each pixel (Baker et al. 2011) |
//!
//! In a `.png` zero says that nothing is seen, and a depth beyond 65.535 units is 65535. Flow in a `.png` is that of KITTI
//! (Menze and Geiger 2015): 64 · pixels + 32768, right and down in red and green, and blue 1 where there is a flow. Where
//! there is none, a `.flo` has 10¹⁰ and a `.npy` NaN.

use std::path::Path;

use thiserror::Error;

use crate::layers::{Layers, NO_OBJECT};
use crate::png;

/// Depths of a `.png` in a unit of the scene.
const DEPTHS_PER_UNIT: f32 = 1000.0;
/// What a `.flo` has where there is no flow: it is unknown above 10⁹.
const UNKNOWN: f32 = 1e10;
/// What every `.flo` begins with, "PIEH" in bytes.
const FLO: f32 = 202_021.25;

/// A by-product.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Plane {
    /// How much of the background is hidden, 0 to 1.
    Alpha,
    /// Expected depth, in scene units.
    Depth,
    /// Normal, in the axes of the scene.
    Normal,
    /// Place of the set that is seen.
    Object,
    /// Motion until the next moment \[pixels\].
    Flow,
}

/// How numbers are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// `NumPy`.
    Npy,
    /// PNG of 16 bits.
    Png,
    /// Optical flow as in the Middlebury benchmark.
    Flo,
}

/// A by-product that cannot be stored like this.
#[derive(Debug, Error)]
pub enum StoreError {
    /// No form has this ending.
    #[error("a by-product is stored as `.npy` or `.png`, and a flow also as `.flo`")]
    Ending,
    /// There is no next moment.
    #[error("there is no next moment to which a flow would lead")]
    NoFlow,
    /// It could not be packed.
    #[error("the picture cannot be packed: {0}")]
    Png(String),
}

impl Form {
    /// The form of a file name, if there is one for what is stored.
    ///
    /// # Errors
    /// There is none.
    pub fn of(path: &Path, plane: Plane) -> Result<Form, StoreError> {
        let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
        match (ending.as_str(), plane) {
            ("npy", _) => Ok(Form::Npy),
            ("png", _) => Ok(Form::Png),
            ("flo", Plane::Flow) => Ok(Form::Flo),
            _ => Err(StoreError::Ending),
        }
    }
}

impl Layers {
    /// A by-product as the bytes of a file.
    ///
    /// # Errors
    /// It is a flow and there is none, or it is none and a `.flo` is asked for.
    pub fn encode(&self, plane: Plane, form: Form) -> Result<Vec<u8>, StoreError> {
        if plane == Plane::Flow && self.flow.is_empty() {
            return Err(StoreError::NoFlow);
        }
        match form {
            Form::Npy => Ok(self.npy(plane)),
            Form::Flo if plane == Plane::Flow => Ok(self.flo()),
            Form::Flo => Err(StoreError::Ending),
            Form::Png => {
                let (values, colour) = self.words(plane);
                let size = [self.picture.width as u32, self.picture.height as u32];
                png::encode_words(size, colour, &values).map_err(|e| StoreError::Png(e.to_string()))
            }
        }
    }

    fn npy(&self, plane: Plane) -> Vec<u8> {
        let size = [self.picture.height, self.picture.width];
        let floats = |components: usize, values: &mut dyn Iterator<Item = f32>| {
            npy("<f4", size, components, values.map(f32::to_le_bytes))
        };
        match plane {
            Plane::Alpha => floats(1, &mut self.picture.rgba.iter().map(|p| p[3])),
            Plane::Depth => floats(1, &mut self.picture.depth.iter().copied()),
            Plane::Normal => floats(3, &mut self.normal.iter().flatten().copied()),
            Plane::Flow => floats(2, &mut self.flow.iter().flatten().copied()),
            Plane::Object => npy("<u4", size, 1, self.object.iter().map(|o| o.to_le_bytes())),
        }
    }

    fn flo(&self) -> Vec<u8> {
        let [width, height] = [self.picture.width, self.picture.height].map(|side| (side as u32).to_le_bytes());
        let mut bytes: Vec<u8> = [FLO.to_le_bytes(), width, height].concat();
        let known = |v: &f32| if v.is_nan() { UNKNOWN } else { *v };
        bytes.extend(self.flow.iter().flatten().flat_map(|v| known(v).to_le_bytes()));
        bytes
    }

    /// Numbers of 16 bits, and whether they are three a pixel.
    fn words(&self, plane: Plane) -> (Vec<u16>, bool) {
        // Conversions to integers saturate.
        let word = |v: f32| v.round() as u16;
        let full = f32::from(u16::MAX);
        match plane {
            Plane::Alpha => (self.picture.rgba.iter().map(|p| word(p[3] * full)).collect(), false),
            Plane::Depth => {
                let depth = |&d: &f32| if d.is_finite() { word(d * DEPTHS_PER_UNIT).max(1) } else { 0 };
                (self.picture.depth.iter().map(depth).collect(), false)
            }
            Plane::Object => {
                let object = |&o: &u32| if o == NO_OBJECT { 0 } else { u16::try_from(o + 1).unwrap_or(u16::MAX) };
                (self.object.iter().map(object).collect(), false)
            }
            Plane::Normal => {
                let is_none = |n: &[f32; 3]| n.iter().all(|&v| v == 0.0);
                let normal =
                    |n: &[f32; 3]| if is_none(n) { [0; 3] } else { n.map(|v| word(f32::midpoint(v, 1.0) * full)) };
                (self.normal.iter().flat_map(normal).collect(), true)
            }
            Plane::Flow => {
                let flow = |&[u, v]: &[f32; 2]| {
                    let code = |v: f32| word(64.0 * v + 32_768.0);
                    if u.is_nan() { [0; 3] } else { [code(u), code(v), 1] }
                };
                (self.flow.iter().flat_map(flow).collect(), true)
            }
        }
    }
}

/// The format 1.0 of `NumPy`: magic, version, length of the header, header padded to a multiple of 64 bytes, numbers.
fn npy(kind: &str, [rows, columns]: [usize; 2], components: usize, values: impl Iterator<Item = [u8; 4]>) -> Vec<u8> {
    let last = if components == 1 { String::new() } else { format!(" {components}") };
    let header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({rows}, {columns},{last}), }}");
    let length = (10 + header.len() + 1).next_multiple_of(64) - 10;
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((length as u16).to_le_bytes());
    bytes.extend(format!("{header:<0$}\n", length - 1).into_bytes());
    bytes.extend(values.flatten());
    bytes
}
