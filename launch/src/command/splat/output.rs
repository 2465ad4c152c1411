//! Where results go: never over a file unasked.

use std::fs;
use std::path::Path;

use cosplat_splat::format::{FORMATS, encode, ending_of};
use cosplat_splat::{Axes, Splats};

use super::{put, refused};
use crate::exit::{Code, Error, Problem};

/// What is read and what would be written.
#[derive(Clone, Copy, Debug)]
pub(super) struct Output<'a> {
    pub(super) from: &'a Path,
    pub(super) to: &'a Path,
    pub(super) force: bool,
}

/// Whether the result may be written.
///
/// # Errors
/// It is the file that is read, or it exists and nobody said that it may be replaced.
pub(super) fn free(place: &Output<'_>) -> Result<(), Error> {
    let out = place.to;
    let taken = |why: &str, hint: &str| {
        let problem = Problem::new(format!("`{}` is not written", out.display())).at(out).because(why);
        Err(Error::new(Code::Usage, problem.hint(hint)))
    };
    let real = |path: &Path| fs::canonicalize(path).ok();
    if real(out).is_some() && real(out) == real(place.from) {
        return taken("it is the file that would be read", "give another name for the result");
    }
    if out.exists() && !place.force {
        return taken("it exists", "replace it with `--force`, or give another name");
    }
    Ok(())
}

/// Axes that the format of a name's ending has by convention.
pub(super) fn axes_of(out: &Path) -> Axes {
    let ending = ending_of(out).unwrap_or_default();
    let has = |endings: &[&str]| endings.iter().any(|e| e.eq_ignore_ascii_case(ending));
    FORMATS.iter().find(|f| has(f.endings)).map_or(Axes::Scene, |f| f.axes)
}

/// Writes Gaussians in the format of the name's ending.
///
/// # Errors
/// There is no such format, or no room.
pub(super) fn write(out: &Path, splats: &Splats) -> Result<(), Error> {
    put(out, &encode(splats, ending_of(out)).map_err(|e| refused(out, e))?)
}
