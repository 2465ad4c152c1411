//! Labels: a number a Gaussian that says what it belongs to, kept in the file as a property.

use std::path::Path;

use cosplat_splat::{Extra, Splats};

use crate::exit::{Code, Error, Problem};
use crate::hint::list;

/// A property and one of its values, as `label=3`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Label {
    /// Name of the property.
    pub(crate) name: String,
    /// What it has to be.
    pub(crate) value: f64,
}

/// Reads `NAME=VALUE`.
///
/// # Errors
/// What was expected.
pub(super) fn label(text: &str) -> Result<Label, String> {
    let parts = text.split_once('=').and_then(|(name, value)| Some((name, value.trim().parse().ok()?)));
    match parts.filter(|(name, value): &(&str, f64)| name_of(name).is_ok() && value.is_finite()) {
        Some((name, value)) => Ok(Label { name: name.to_owned(), value }),
        None => Err("expected the name of a property, `=` and a number, as in `label=3`".to_owned()),
    }
}

/// Reads the name of a property: what a header of a `.ply` can hold.
///
/// # Errors
/// What was expected.
pub(super) fn name_of(text: &str) -> Result<String, String> {
    let fits = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let is_name = text.starts_with(|c: char| c.is_ascii_alphabetic()) && text.chars().all(fits);
    // Those that the format gives a meaning.
    let known = ["x", "y", "z", "nx", "ny", "nz", "opacity", "red", "green", "blue", "alpha"];
    let taken = known.contains(&text) || ["f_dc_", "f_rest_", "scale_", "rot_"].iter().any(|p| text.starts_with(p));
    if is_name && !taken && text.len() <= 64 {
        return Ok(text.to_owned());
    }
    Err("expected a name of letters, digits and `_` that the format itself does not use, as in `label`".to_owned())
}

/// Of these Gaussians those that have all labels.
///
/// # Errors
/// The file has no such property.
pub(super) fn having(kept: Vec<u32>, splats: &Splats, labels: &[Label], file: &Path) -> Result<Vec<u32>, Error> {
    let mut properties = Vec::new();
    for label in labels {
        let found = splats.extras.iter().find(|e| e.name == label.name).ok_or_else(|| {
            let has = list(splats.extras.iter().map(|e| e.name.as_str()));
            let problem = Problem::new(format!("`{}` has no property `{}`", file.display(), label.name)).at(file);
            Error::new(Code::Scene, problem.because(format!("beside what every capture has it has {has}")))
        })?;
        properties.push((&found.values, label.value));
    }
    let has = |i: &u32| properties.iter().all(|(values, wanted)| (values[*i as usize] - wanted).abs() <= 0.0);
    Ok(kept.into_iter().filter(has).collect())
}

/// All Gaussians, with a property that is 1 for these and 0 for the others; one of that name before is replaced.
pub(super) fn marked(mut splats: Splats, chosen: &[u32], name: &str) -> Splats {
    let mut values = vec![0.0; splats.len()];
    for &i in chosen {
        values[i as usize] = 1.0;
    }
    splats.extras.retain(|e| e.name != name);
    splats.extras.push(Extra { name: name.to_owned(), kind: "uchar", values });
    splats
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_read_and_what_is_none_is_refused() {
        assert_eq!(label("label=3"), Ok(Label { name: "label".to_owned(), value: 3.0 }));
        assert_eq!(label("w_2=-0.5").map(|l| l.value), Ok(-0.5));
        for wrong in ["label", "=3", "a b=1", "x=1", "rot_0=1", "label=", "label=nan", "é=1"] {
            assert!(label(wrong).is_err(), "{wrong}");
        }
        assert!(name_of(&"a".repeat(65)).is_err());
    }
}
