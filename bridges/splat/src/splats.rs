//! A set of Gaussians as structure of arrays, with the numbers as the interchange format stores them.

/// Base-band constant of the spherical harmonics, Y₀ = ½ √(1/π).
pub const SH_C0: f64 = 0.282_094_791_773_878_14;

/// Opacities are kept this far from 0 and 1 where a logit has to be made from them.
const OPACITY_EDGE: f64 = 1e-6;

/// Which way the axes of the numbers point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Axes {
    /// x right, y down, z forward: COLMAP, INRIA `.ply`, `.splat`; up is −y.
    #[default]
    Rdf,
    /// x right, y up, z back: `.spz`, glTF; up is +y.
    Rub,
    /// The axes of a scene, after [`crate::Similarity::apply`]: nothing is assumed about them.
    Scene,
}

impl Axes {
    /// The up axis by convention, as scenes name it; nothing where there is none.
    pub fn up(self) -> Option<&'static str> {
        match self {
            Axes::Rdf => Some("-y"),
            Axes::Rub => Some("+y"),
            Axes::Scene => None,
        }
    }
}

/// A property of a file that this crate does not use, kept under its name.
#[derive(Clone, Debug, PartialEq)]
pub struct Extra {
    /// Name in the file.
    pub name: String,
    /// Type in the file, by its PLY name (`uchar`, `float`, …).
    pub kind: &'static str,
    /// One value a Gaussian; every PLY number is exact in `f64`.
    pub values: Vec<f64>,
}

/// Gaussians, one index for one Gaussian in every array.
///
/// Numbers are those of the INRIA `.ply`: log scales, opacity logits, unnormalised quaternions. A Gaussian that nobody
/// touches keeps the bits it was decoded with.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Splats {
    /// Centres, in units of the file.
    pub positions: Vec<[f32; 3]>,
    /// Quaternions w, x, y, z as stored: not normalised, possibly zero (taken as identity).
    pub rotations: Vec<[f32; 4]>,
    /// Natural logarithms of the three standard deviations, in units of the file.
    pub log_scales: Vec<[f32; 3]>,
    /// Opacity α as its logit: α = 1 / (1 + e^−logit).
    pub opacity_logits: Vec<f32>,
    /// Base band of the colour, R G B: colour = ½ + Y₀ dc.
    pub sh_dc: Vec<[f32; 3]>,
    /// Higher bands, R G B: coefficient j (from 0) of Gaussian i at `i * coefficients + j`.
    pub sh_rest: Vec<[f32; 3]>,
    /// Highest band, 0 to 3.
    pub sh_degree: u8,
    /// Properties that are only carried along.
    pub extras: Vec<Extra>,
    /// Which way the axes point.
    pub axes: Axes,
    /// Trained with the antialiasing filter: the opacity of a widened footprint is reduced when drawn.
    pub antialiased: bool,
}

impl Splats {
    /// Number of Gaussians.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether there is no Gaussian.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// Coefficients above the base band of one Gaussian and channel: (degree + 1)² − 1.
    pub fn coefficients(&self) -> usize {
        coefficients(self.sh_degree)
    }

    /// Higher-band coefficients of one Gaussian.
    pub fn rest(&self, index: usize) -> &[[f32; 3]] {
        let k = self.coefficients();
        &self.sh_rest[index * k..(index + 1) * k]
    }

    /// Opacity of one Gaussian, 0 to 1.
    pub fn opacity(&self, index: usize) -> f64 {
        opacity_of_logit(self.opacity_logits[index])
    }

    /// Standard deviations of one Gaussian, in units of the file.
    pub fn scales(&self, index: usize) -> [f64; 3] {
        self.log_scales[index].map(|s| f64::from(s).exp())
    }

    /// Whether every array has the length it must have.
    pub fn is_consistent(&self) -> bool {
        let n = self.len();
        self.rotations.len() == n
            && self.log_scales.len() == n
            && self.opacity_logits.len() == n
            && self.sh_dc.len() == n
            && self.sh_rest.len() == n * self.coefficients()
            && self.sh_degree <= 3
            && self.extras.iter().all(|e| e.values.len() == n)
    }

    /// Room for that many Gaussians more.
    pub(crate) fn with_capacity(count: usize, sh_degree: u8) -> Splats {
        Splats {
            positions: Vec::with_capacity(count),
            rotations: Vec::with_capacity(count),
            log_scales: Vec::with_capacity(count),
            opacity_logits: Vec::with_capacity(count),
            sh_dc: Vec::with_capacity(count),
            sh_rest: Vec::with_capacity(count * coefficients(sh_degree)),
            sh_degree,
            ..Splats::default()
        }
    }

    /// The Gaussians of these indices, in that order, bit by bit.
    #[must_use]
    pub fn select(&self, indices: &[u32]) -> Splats {
        let at = |i: &u32| *i as usize;
        let extra = |e: &Extra| Extra { values: indices.iter().map(|i| e.values[at(i)]).collect(), ..e.clone() };
        Splats {
            positions: indices.iter().map(|i| self.positions[at(i)]).collect(),
            rotations: indices.iter().map(|i| self.rotations[at(i)]).collect(),
            log_scales: indices.iter().map(|i| self.log_scales[at(i)]).collect(),
            opacity_logits: indices.iter().map(|i| self.opacity_logits[at(i)]).collect(),
            sh_dc: indices.iter().map(|i| self.sh_dc[at(i)]).collect(),
            sh_rest: indices.iter().flat_map(|i| self.rest(at(i)).iter().copied()).collect(),
            extras: self.extras.iter().map(extra).collect(),
            ..*self
        }
    }

    /// The same Gaussians with their axes the other way: half a turn about x, which takes [`Axes::Rdf`] to
    /// [`Axes::Rub`] and back. Only signs change, so twice is the same bits. [`Axes::Scene`] stays as it is.
    #[must_use]
    pub fn to_axes(mut self, axes: Axes) -> Splats {
        if self.axes == axes || self.axes == Axes::Scene || axes == Axes::Scene {
            return self;
        }
        for p in &mut self.positions {
            *p = [p[0], -p[1], -p[2]];
        }
        for q in &mut self.rotations {
            *q = [q[0], q[1], -q[2], -q[3]];
        }
        let k = self.coefficients();
        for rest in self.sh_rest.chunks_mut(k.max(1)) {
            for (c, odd) in rest.iter_mut().zip(ODD_IN_YZ) {
                if odd {
                    *c = c.map(|v| -v);
                }
            }
        }
        self.axes = axes;
        self
    }
}

/// Higher-band coefficients whose basis changes its sign with (x, y, z) → (x, −y, −z).
const ODD_IN_YZ: [bool; 15] =
    [true, true, false, true, false, false, true, false, true, false, true, false, false, true, false];

/// Coefficients above the base band: (degree + 1)² − 1.
pub fn coefficients(degree: u8) -> usize {
    let n = usize::from(degree) + 1;
    n * n - 1
}

/// α = 1 / (1 + e^−logit).
pub fn opacity_of_logit(logit: f32) -> f64 {
    1.0 / (1.0 + (-f64::from(logit)).exp())
}

/// ln(α / (1 − α)), α kept 10⁻⁶ away from 0 and 1.
pub fn logit_of_opacity(opacity: f64) -> f32 {
    let alpha = opacity.clamp(OPACITY_EDGE, 1.0 - OPACITY_EDGE);
    (alpha / (1.0 - alpha)).ln() as f32
}

/// Base-band coefficient of a colour 0 to 1: (colour − ½) / Y₀.
pub fn dc_of_colour(colour: f64) -> f32 {
    ((colour - 0.5) / SH_C0) as f32
}
