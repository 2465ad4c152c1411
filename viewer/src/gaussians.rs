//! What is drawn, borrowed from whoever owns it.

use thiserror::Error;

/// Arrays of different lengths.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{array} has {has} entries and {needs} are needed for {count} Gaussians")]
pub struct LengthError {
    array: &'static str,
    has: usize,
    needs: usize,
    count: usize,
}

impl LengthError {
    pub(crate) fn new(array: &'static str, has: usize, needs: usize, count: usize) -> LengthError {
        LengthError { array, has, needs, count }
    }
}

/// Gaussians as structure of arrays, with the numbers of an INRIA `.ply`.
///
/// Lengths in the unit of the scene; several sets are drawn together as one, sorted among each other.
#[derive(Clone, Copy, Debug)]
pub struct Gaussians<'a> {
    /// Centres.
    pub positions: &'a [[f32; 3]],
    /// Quaternions w, x, y, z; need not be of length one, zero is identity.
    pub rotations: &'a [[f32; 4]],
    /// Natural logarithms of the standard deviations.
    pub log_scales: &'a [[f32; 3]],
    /// Logits of the opacities.
    pub opacity_logits: &'a [f32],
    /// Base band of the colour, R G B.
    pub sh_dc: &'a [[f32; 3]],
    /// Higher bands R G B, (degree + 1)² − 1 of them a Gaussian.
    pub sh_rest: &'a [[f32; 3]],
    /// Highest band, 0 to 3.
    pub sh_degree: u8,
    /// Trained with the antialiasing filter: the opacity of a widened footprint is reduced by
    /// √(det before / det after).
    pub antialiased: bool,
}

impl Gaussians<'_> {
    /// Higher-band coefficients of one Gaussian.
    pub(crate) fn coefficients(&self) -> usize {
        let n = usize::from(self.sh_degree) + 1;
        n * n - 1
    }

    /// Whether the arrays fit together.
    ///
    /// # Errors
    /// The first array of a wrong length.
    pub fn check(&self) -> Result<(), LengthError> {
        let count = self.positions.len();
        let lengths = [
            ("rotations", self.rotations.len(), count),
            ("log_scales", self.log_scales.len(), count),
            ("opacity_logits", self.opacity_logits.len(), count),
            ("sh_dc", self.sh_dc.len(), count),
            ("sh_rest", self.sh_rest.len(), count * self.coefficients()),
            ("sh_degree, at most 3,", usize::from(self.sh_degree), usize::from(self.sh_degree.min(3))),
        ];
        match lengths.into_iter().find(|(_, has, needs)| has != needs) {
            Some((array, has, needs)) => Err(LengthError { array, has, needs, count }),
            None => Ok(()),
        }
    }
}
