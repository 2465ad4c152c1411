//! Planes of a picture.

/// A picture in display values.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// Row by row from the top: red, green, blue with the background blended in, and the opacity 1 − T. Values above 1
    /// are kept.
    pub rgba: Vec<[f32; 4]>,
    /// Expected depth Σ w z / Σ w in scene units, infinite where nothing is seen; empty if it was not asked for.
    pub depth: Vec<f32>,
}

impl Picture {
    /// Red, green, blue as bytes: round(255 · value), cut to 0 to 255. The values are display values already, so no
    /// curve is applied.
    pub fn to_srgb8(&self) -> Vec<u8> {
        let byte = |v: f32| (v.clamp(0.0, 1.0) * 255.0).round() as u8;
        self.rgba.iter().flat_map(|&[r, g, b, _]| [byte(r), byte(g), byte(b)]).collect()
    }

    /// Red, green, blue cut to 0 to 1.
    pub fn rgb(&self) -> Vec<f32> {
        self.rgba.iter().flat_map(|&[r, g, b, _]| [r, g, b].map(|v| v.clamp(0.0, 1.0))).collect()
    }
}
