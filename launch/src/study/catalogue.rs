//! Which of the published cases a folder of cases covers: `catalogue.toml` beside them.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::exit::{Code, Error, Problem};

/// Name of the file.
pub(crate) const FILE: &str = "catalogue.toml";

/// A published case.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Entry {
    /// Short name, as in the literature list: `C1`.
    pub(crate) id: String,
    /// What it asks.
    pub(crate) title: String,
    /// Cases of the folder that answer.
    #[serde(default)]
    pub(crate) cases: Vec<String>,
    /// What answers, or is missing, beside them; needed where there is no case.
    #[serde(default)]
    pub(crate) note: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Catalogue {
    entry: Vec<Entry>,
}

/// Reads the catalogue of a folder; empty where it has none.
///
/// # Errors
/// It cannot be read, or an entry has neither a case of the folder nor a note.
pub(crate) fn read(folder: &Path, cases: &[&str]) -> Result<Vec<Entry>, Error> {
    let file = folder.join(FILE);
    if !file.is_file() {
        return Ok(Vec::new());
    }
    let refused = |why: String| {
        let problem = Problem::new(format!("The catalogue `{}` cannot be used", file.display())).at(&file).because(why);
        Error::new(Code::Scene, problem.hint("an `[[entry]]` has `id`, `title` and `cases` or a `note`"))
    };
    let text = std::fs::read_to_string(&file).map_err(|e| refused(e.to_string()))?;
    let catalogue: Catalogue = toml::from_str(&text).map_err(|e| refused(e.to_string()))?;
    for entry in &catalogue.entry {
        if let Some(unknown) = entry.cases.iter().find(|case| !cases.contains(&case.as_str())) {
            return Err(refused(format!("`{}` names the case `{unknown}`, which is not there", entry.id)));
        }
        if entry.cases.is_empty() && entry.note.is_empty() {
            return Err(refused(format!("`{}` has neither a case nor a note that says why", entry.id)));
        }
    }
    Ok(catalogue.entry)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_entry_has_a_case_or_says_why_not() {
        let place = tempfile::tempdir().unwrap();
        assert_eq!(read(place.path(), &[]).unwrap(), []);
        let with = |text: &str| {
            std::fs::write(place.path().join(FILE), text).unwrap();
            read(place.path(), &["swing"])
        };
        let head = "[[entry]]\nid = \"C1\"\ntitle = \"t\"\n";
        assert_eq!(with(&format!("{head}cases = [\"swing\"]\n")).unwrap().len(), 1);
        for wrong in [head.to_owned(), format!("{head}cases = [\"swim\"]\n"), format!("{head}nte = \"x\"\n")] {
            assert_eq!(with(&wrong).unwrap_err().code, Code::Scene, "{wrong}");
        }
    }
}
