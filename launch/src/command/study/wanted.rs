//! Which cases a study is about.

use std::fs;
use std::path::{Path, PathBuf};

use super::StudyArgs;
use crate::exit::{Code, Error, Problem};
use crate::scene_source::{self, Source};
use crate::study::case::{Case, Factor, Level};
use crate::study::catalogue::{self, Entry};
use crate::study::read::{ENDING, case};

/// The cases that are meant, and a name for all of them.
pub(super) fn cases(args: &StudyArgs) -> Result<(String, Vec<Case>), Error> {
    let Some(what) = &args.what else {
        let problem = Problem::new("Nothing says what to study");
        let hint = "name a case, a folder of cases, a scene or a suite, as in `cosplat study stability`";
        return Err(Error::new(Code::Usage, problem.hint(hint)));
    };
    let path = Path::new(what);
    let mut cases = if path.is_dir() {
        quick(in_folder(path)?, path, args.slow)?
    } else if what.ends_with(ENDING) {
        vec![case(path)?]
    } else {
        vec![of_scene(&scene_source::load(what)?, what, &args.vary)?]
    };
    for case in &mut cases {
        for factor in &args.vary {
            case.vary.retain(|known| known.key != factor.key);
            case.vary.push(factor.clone());
        }
    }
    let folder = || fs::canonicalize(path).ok()?.file_name().map(|n| n.to_string_lossy().into_owned());
    let name = match cases.as_slice() {
        [only] => only.name.clone(),
        _ => folder().unwrap_or_else(|| "cases".into()),
    };
    Ok((name, cases))
}

/// The cases of a folder without those that take minutes, where these are not asked for.
fn quick(mut cases: Vec<Case>, folder: &Path, with_slow: bool) -> Result<Vec<Case>, Error> {
    cases.retain(|case| with_slow || !case.slow);
    if cases.is_empty() {
        let problem = Problem::new(format!("All cases of `{}` take minutes", folder.display())).at(folder);
        return Err(Error::new(Code::Usage, problem.hint("add `--slow` to run them")));
    }
    Ok(cases)
}

/// The catalogue of the folder that is studied; an entry says which of its cases were left out.
pub(super) fn catalogue(args: &StudyArgs, cases: &[Case]) -> Result<Vec<Entry>, Error> {
    let folder = args.what.as_deref().map(Path::new).filter(|path| path.is_dir());
    let Some(folder) = folder else { return Ok(Vec::new()) };
    let all = in_folder(folder)?;
    let names: Vec<&str> = all.iter().map(|case| case.name.as_str()).collect();
    let mut entries = catalogue::read(folder, &names)?;
    for entry in &mut entries {
        let is_there = |name: &String| cases.iter().any(|case| case.name == *name);
        let slow: Vec<String> = entry.cases.iter().filter(|name| !is_there(name)).cloned().collect();
        if !slow.is_empty() {
            let sentence = format!("not run, because it takes minutes: {} (`--slow` runs it)", slow.join(", "));
            entry.note =
                [entry.note.clone(), sentence].iter().filter(|s| !s.is_empty()).cloned().collect::<Vec<_>>().join("; ");
        }
    }
    Ok(entries)
}

/// All cases of a folder by name; every mistake in any of them is reported.
pub(super) fn in_folder(folder: &Path) -> Result<Vec<Case>, Error> {
    let cannot = |e: &std::io::Error| Error::io("read", folder, e);
    let entries =
        fs::read_dir(folder).and_then(Iterator::collect::<std::io::Result<Vec<_>>>).map_err(|e| cannot(&e))?;
    let mut files: Vec<PathBuf> = entries.into_iter().map(|entry| entry.path()).collect();
    files.retain(|path| path.to_string_lossy().ends_with(ENDING));
    files.sort_unstable();
    let (mut cases, mut problems) = (Vec::new(), Vec::new());
    for read in files.iter().map(|file| case(file)) {
        match read {
            Ok(case) => cases.push(case),
            Err(error) => problems.extend(error.problems),
        }
    }
    if cases.is_empty() && problems.is_empty() {
        let problem = Problem::new(format!("`{}` holds no case", folder.display())).at(folder);
        problems.push(problem.hint(format!("a case is a file `NAME{ENDING}` beside its scene")));
    }
    if problems.is_empty() { Ok(cases) } else { Err(Error { code: Code::Scene, problems }) }
}

/// The cases with these names; all where none is named.
pub(super) fn chosen(mut cases: Vec<Case>, only: &[String]) -> Result<Vec<Case>, Error> {
    if let Some(unknown) = only.iter().find(|wanted| cases.iter().all(|case| case.name != **wanted)) {
        let names: Vec<&str> = cases.iter().map(|case| case.name.as_str()).collect();
        let problem = Problem::new(format!("There is no case `{unknown}`"));
        return Err(Error::new(Code::Usage, problem.hint(format!("there are {}", names.join(", ")))));
    }
    cases.retain(|case| only.is_empty() || only.contains(&case.name));
    Ok(cases)
}

/// A scene without a reference: its finest run stands in for one.
fn of_scene(source: &Source, wanted: &str, vary: &[Factor]) -> Result<Case, Error> {
    if vary.is_empty() {
        let problem = Problem::new(format!("Nothing says what to vary in `{wanted}`"));
        let hint = "add the values of a key, coarse to fine, as in `--vary clock.window=0.02,0.01,0.005`";
        return Err(Error::new(Code::Usage, problem.hint(hint)));
    }
    let plain = |key: &str| {
        let table: toml::Table = toml::from_str(&source.text).unwrap_or_default();
        table.get(key).and_then(toml::Value::as_str).map(str::to_owned)
    };
    let name = plain("name").unwrap_or_else(|| "scene".into());
    let title = plain("title").unwrap_or_else(|| name.clone());
    Ok(Case::plain(&name, &title, wanted, Vec::new()))
}

/// Reads `KEY=V1,V2`; values are TOML, plain words count as strings.
pub(super) fn factor(text: &str) -> Result<Factor, String> {
    let (key, values) = text.split_once('=').ok_or("expected a key, `=` and values, as in `clock.window=0.02,0.01`")?;
    // Commas inside brackets and quotes belong to a value.
    let (mut parts, mut depth, mut quoted) = (vec![String::new()], 0_i32, false);
    for c in values.chars() {
        depth += i32::from("[{".contains(c)) - i32::from("]}".contains(c));
        quoted ^= c == '"';
        match parts.last_mut() {
            Some(part) if c != ',' || depth > 0 || quoted => part.push(c),
            _ => parts.push(String::new()),
        }
    }
    let values: Vec<Level> = parts.iter().map(|part| Level::of(part)).collect();
    if key.trim().is_empty() || values.iter().any(|value| value.toml.is_empty()) {
        return Err("expected a key, `=` and values with commas between, as in `clock.window=0.02,0.01`".into());
    }
    Ok(Factor { key: key.trim().to_owned(), values })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_split_at_commas_that_are_not_inside_of_one() {
        let shown = |text: &str| factor(text).map(|f| f.values.into_iter().map(|v| v.shown).collect::<Vec<_>>());
        assert_eq!(shown("clock.window=0.02,1e-2").unwrap(), ["0.02", "0.01"]);
        assert_eq!(shown("body.a.position=[0, 1],[2, 3]").unwrap(), ["[0, 1]", "[2, 3]"]);
        assert_eq!(shown("x=\"a,b\",c").unwrap(), ["a,b", "c"]);
        for wrong in ["x", "=1", "x=", "x=1,,2"] {
            assert!(shown(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_scene_needs_something_to_vary() {
        let source = scene_source::load("oscillator").unwrap();
        assert_eq!(of_scene(&source, "oscillator", &[]).unwrap_err().code, Code::Usage);
        let case = of_scene(&source, "oscillator", &[factor("clock.window=0.1").unwrap()]).unwrap();
        assert_eq!((case.name.as_str(), case.quantities.len()), ("oscillator", 0));
    }
}
