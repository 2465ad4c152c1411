//! Sheets: a scene with one value a row and another a column, with a picture of each run and what it measures.

mod cell;
mod impact;
mod layout;
mod read;
mod source;

use super::case::{Factor, Level};
pub(crate) use cell::{Cell, csv};
pub(crate) use impact::Impact;
pub(crate) use layout::{Tile, side_by_side};
pub(crate) use source::{ENDING, load};

/// What is laid out.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Sheet {
    /// Short name: of its file, or of the scene.
    pub(crate) name: String,
    /// One line for people.
    pub(crate) title: String,
    /// Scene file or name of a built-in scene, as `cosplat run` takes it.
    pub(crate) scene: String,
    /// Moment of the pictures \[s\]; the last frame where none is given.
    pub(crate) at_s: Option<f64>,
    /// Body whose impact is measured.
    pub(crate) striker: Option<String>,
    /// Rows from above.
    pub(crate) rows: Vec<Line>,
    /// Columns from the left.
    pub(crate) columns: Vec<Line>,
}

/// A row or a column: what its runs have in common.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Line {
    /// Key and value; the first one names the line.
    pub(crate) values: Vec<(String, Level)>,
}

impl Line {
    /// Its name; empty for the only line of an axis on which nothing varies.
    pub(crate) fn name(&self) -> &str {
        self.values.first().map_or("", |(_, level)| level.shown.as_str())
    }
}

/// The lines of an axis: line *i* has the *i*-th value of each key.
///
/// # Errors
/// The first key that has another number of values than the one before, in words.
pub(crate) fn lines(keys: &[Factor]) -> Result<Vec<Line>, String> {
    let Some(first) = keys.first() else { return Ok(vec![Line::default()]) };
    if let Some(other) = keys.iter().find(|key| key.values.len() != first.values.len()) {
        let count = |key: &Factor| format!("`{}` has {}", key.key, key.values.len());
        return Err(format!("{}, but {}: each line takes one value of every key", count(first), count(other)));
    }
    let line = |i: usize| Line { values: keys.iter().map(|key| (key.key.clone(), key.values[i].clone())).collect() };
    Ok((0..first.values.len()).map(line).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(key: &str, values: &[&str]) -> Factor {
        Factor { key: key.into(), values: values.iter().map(|v| Level::of(v)).collect() }
    }

    #[test]
    fn a_line_takes_one_value_of_every_key() {
        let found =
            lines(&[key("body.a.material", &["can", "car"]), key("body.a.mesh.scale", &["1", "0.12"])]).unwrap();
        assert_eq!(found.iter().map(Line::name).collect::<Vec<_>>(), ["can", "car"]);
        assert_eq!(found[1].values[1], ("body.a.mesh.scale".into(), Level::of("0.12")));
        assert_eq!(lines(&[]).unwrap(), [Line::default()]);
        let why = lines(&[key("a", &["1"]), key("b", &["1", "2"])]).unwrap_err();
        assert!(why.contains("`a` has 1, but `b` has 2"), "{why}");
    }
}
