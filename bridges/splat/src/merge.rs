//! Several bodies in one set.

use thiserror::Error;

use crate::splats::{Axes, Extra, Splats};

/// Sets that cannot be one.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum MergeError {
    /// Axes that point different ways.
    #[error("set {0} has axes {1:?} and the first has {2:?}; bring all to one frame first")]
    Axes(usize, Axes, Axes),
    /// Arrays of different lengths.
    #[error("the arrays of set {0} have different lengths")]
    Inconsistent(usize),
}

/// All Gaussians, set after set, bit by bit. The highest degree of the sets is that of the result; missing bands are
/// zero. Extra properties and the antialiasing flag are those of the first set; others have zero in its properties.
///
/// # Errors
/// The sets are not in one frame, or one contradicts itself.
pub fn merge(sets: &[&Splats]) -> Result<Splats, MergeError> {
    let Some(first) = sets.first() else { return Ok(Splats::default()) };
    for (i, set) in sets.iter().enumerate() {
        if set.axes != first.axes {
            return Err(MergeError::Axes(i, set.axes, first.axes));
        }
        if !set.is_consistent() {
            return Err(MergeError::Inconsistent(i));
        }
    }
    let degree = sets.iter().map(|s| s.sh_degree).max().unwrap_or(0);
    let count = sets.iter().map(|s| s.len()).sum();
    let mut out = Splats { axes: first.axes, antialiased: first.antialiased, ..Splats::with_capacity(count, degree) };
    let bands = out.coefficients();
    for set in sets {
        out.positions.extend(&set.positions);
        out.rotations.extend(&set.rotations);
        out.log_scales.extend(&set.log_scales);
        out.opacity_logits.extend(&set.opacity_logits);
        out.sh_dc.extend(&set.sh_dc);
        if set.sh_degree == degree {
            out.sh_rest.extend(&set.sh_rest);
            continue;
        }
        for i in 0..set.len() {
            out.sh_rest.extend(set.rest(i));
            out.sh_rest.resize(out.sh_rest.len() + bands - set.coefficients(), [0.0; 3]);
        }
    }
    let padded = |extra: &Extra| {
        let mut values = extra.values.clone();
        values.resize(count, 0.0);
        Extra { values, ..extra.clone() }
    };
    out.extras = first.extras.iter().map(padded).collect();
    Ok(out)
}
