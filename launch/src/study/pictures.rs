//! How far pictures of runs are apart.

use std::path::{Path, PathBuf};

use cosplat_viewer::png;

use super::evaluate::Finished;
use crate::frames::picture;

/// How far the last picture of a run is from its first; none where it has not two.
pub(crate) fn change(run: &Finished) -> Option<f64> {
    apart(&place(run, 0), &place(run, last(run).filter(|last| *last > 0)?))
}

/// How far the last pictures that two runs share are apart; none where one of them has none.
pub(crate) fn difference(plain: &Finished, other: &Finished) -> Option<f64> {
    let number = last(plain)?.min(last(other)?);
    apart(&place(plain, number), &place(other, number))
}

/// Number of the last frame.
fn last(run: &Finished) -> Option<u64> {
    run.summary()?.frames.as_ref()?.taken.checked_sub(1)
}

fn place(run: &Finished, number: u64) -> PathBuf {
    Path::new(&run.folder).join(picture(number))
}

/// Root of the mean squared difference of two pictures, of colours from 0 to 1.
fn apart(one: &Path, two: &Path) -> Option<f64> {
    let ((w, h, one), (v, g, two)) = (png::read(one).ok()?, png::read(two).ok()?);
    let squares: f64 = one.iter().zip(&two).map(|(a, b)| f64::from(a - b).powi(2)).sum();
    ((w, h) == (v, g) && !one.is_empty()).then(|| (squares / one.len() as f64).sqrt())
}
