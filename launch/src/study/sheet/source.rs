//! Where a sheet comes from: a file, or one of the sheets inside this program.

use std::path::Path;

use cosplat_core::scene::Diagnostic;

use super::Sheet;
use super::read::parse;
use crate::exit::{Code, Error, Problem};
use crate::render::{Paint, problem_of};

/// How the name of a sheet file ends.
pub(crate) const ENDING: &str = ".sheet.toml";

/// Sheets inside this program, by the name of their scene.
const BUILT_IN: [(&str, &str); 1] = [("impacts", include_str!("../../../sheets/impacts.sheet.toml"))];

/// The sheet of a built-in scene, or of a file; none where a scene has none.
///
/// # Errors
/// The file cannot be read, or every mistake in it.
pub(crate) fn load(wanted: &str) -> Result<Option<Sheet>, Error> {
    if let Some((name, text)) = BUILT_IN.iter().find(|(name, _)| *name == wanted) {
        return read(Path::new(name), text).map(Some);
    }
    let path = Path::new(wanted);
    if !wanted.ends_with(ENDING) {
        return Ok(None);
    }
    let text = std::fs::read_to_string(path).map_err(|e| {
        let problem = Problem::new(format!("Cannot read the sheet `{wanted}`")).at(path).because(e);
        Error::new(Code::Scene, problem.hint(format!("give a file `NAME{ENDING}`, or a scene with `--rows`")))
    })?;
    read(path, &text).map(Some)
}

fn read(path: &Path, text: &str) -> Result<Sheet, Error> {
    parse(path, text).map_err(|found| {
        let shown = path.display().to_string();
        let problem = |d: &Diagnostic| problem_of(Paint::stderr(), &shown, text, d);
        Error { code: Code::Scene, problems: found.iter().map(problem).collect() }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sheets_of_the_program_are_sheets_of_their_scenes() {
        for (name, _) in BUILT_IN {
            let sheet = load(name).unwrap().unwrap();
            assert_eq!((sheet.name.as_str(), sheet.scene.as_str()), (name, name));
        }
        assert_eq!(load("oscillator").unwrap(), None);
        assert_eq!(load("no.sheet.toml").unwrap_err().code, Code::Scene);
    }
}
