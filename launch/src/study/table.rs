//! Reference tables: CSV with a head; lines that begin with `#` say where the numbers are from.

use std::path::Path;

use crate::hint::{list, near_miss};

/// Which part of a table cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    File,
    Time,
    Value,
}

/// A part that cannot be used: what is wrong, as the end of a sentence, and what to do.
pub(super) type Refusal = (Part, String, Option<String>);

/// Time \[s\] and value of each row, by the names of their columns.
///
/// # Errors
/// The file, or one of the columns.
pub(super) fn read(path: &Path, time: &str, value: &str) -> Result<Vec<(f64, f64)>, Refusal> {
    let cannot = |e: &dyn std::fmt::Display| {
        (Part::File, format!("cannot be read: {e}"), Some("paths are relative to this file".to_owned()))
    };
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(path).map_err(|e| cannot(&e))?;
    let head: Vec<String> = reader.headers().map_err(|e| cannot(&e))?.iter().map(|n| n.trim().to_owned()).collect();
    let column = |part, name: &str| {
        head.iter().position(|n| n == name).ok_or_else(|| {
            let names = || head.iter().map(String::as_str);
            let help = match near_miss(name, names()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("its columns are {}", list(names())),
            };
            (part, format!("is no column of `{}`", path.display()), Some(help))
        })
    };
    let (time, value) = (column(Part::Time, time)?, column(Part::Value, value)?);
    let mut points: Vec<(f64, f64)> = Vec::new();
    for (i, row) in reader.records().enumerate() {
        let row = row.map_err(|e| cannot(&e))?;
        let number = |at: usize| row.get(at).and_then(|cell| cell.trim().parse::<f64>().ok()).filter(|n| n.is_finite());
        match (number(time), number(value)) {
            (Some(t), Some(v)) if points.last().is_none_or(|last| last.0 < t) => points.push((t, v)),
            _ => return Err((Part::File, format!("has no two numbers after the time before in row {}", i + 1), None)),
        }
    }
    if points.is_empty() { Err((Part::File, "has no rows".into(), None)) } else { Ok(points) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_read_by_the_names_of_their_columns() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("x.csv");
        std::fs::write(&path, "# from a paper\nt,u,v\n0,1,2\n0.5,3,4\n").unwrap();
        assert_eq!(read(&path, "t", "v").unwrap(), [(0.0, 2.0), (0.5, 4.0)]);
        assert_eq!(read(&path, "t", "w").unwrap_err().0, Part::Value);
        std::fs::write(&path, "t,u\n0,1\n0,2\n").unwrap();
        assert!(read(&path, "t", "u").unwrap_err().1.contains("row 2"));
        assert_eq!(read(&place.path().join("y.csv"), "t", "u").unwrap_err().0, Part::File);
    }
}
