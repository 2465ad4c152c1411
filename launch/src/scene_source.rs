//! Where a scene comes from: a file, or one of the scenes inside this program.

use std::fs;
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};

use cosplat_core::scene::read::parse_with;
use cosplat_core::scene::{Diagnostic, Scene, Severity};

use crate::exit::{Code, Error, Problem};
use crate::hint::{list, near_miss};
use crate::render::{Paint, problem_of};

/// Scene of `cosplat` without arguments.
pub(crate) const DEFAULT: &str = "plant-and-rock";

/// Scenes inside this program, by name.
const BUILT_IN: &[(&str, &str)] = &[
    ("ball-on-block", include_str!("../scenes/ball-on-block.toml")),
    ("ball-on-cloth", include_str!("../scenes/ball-on-cloth.toml")),
    ("block-on-block", include_str!("../scenes/block-on-block.toml")),
    ("cloth-catches-mud", include_str!("../scenes/cloth-catches-mud.toml")),
    ("cloth-over", include_str!("../scenes/cloth-over.toml")),
    ("cloth-over-plant", include_str!("../scenes/cloth-over-plant.toml")),
    ("dam-and-raft", include_str!("../scenes/dam-and-raft.toml")),
    ("dam-break", include_str!("../scenes/dam-break.toml")),
    ("flag-in-wind", include_str!("../scenes/flag-in-wind.toml")),
    ("foam", include_str!("../scenes/foam.toml")),
    ("fountain", include_str!("../scenes/fountain.toml")),
    ("impacts", include_str!("../scenes/impacts.toml")),
    ("mud-over", include_str!("../scenes/mud-over.toml")),
    ("mud-over-block", include_str!("../scenes/mud-over-block.toml")),
    ("mud-over-plant", include_str!("../scenes/mud-over-plant.toml")),
    ("mudslide", include_str!("../scenes/mudslide.toml")),
    ("oscillator", include_str!("../scenes/oscillator.toml")),
    ("plant-and-rock", include_str!("../scenes/plant-and-rock.toml")),
    ("sand-castle", include_str!("../scenes/sand-castle.toml")),
    ("silk-over-rock", include_str!("../scenes/silk-over-rock.toml")),
    ("smoke-past-plant", include_str!("../scenes/smoke-past-plant.toml")),
    ("snow-ball", include_str!("../scenes/snow-ball.toml")),
    ("stage-1", include_str!("../scenes/stage-1.toml")),
    ("stage-2", include_str!("../scenes/stage-2.toml")),
    ("stage-3", include_str!("../scenes/stage-3.toml")),
    ("stage-4", include_str!("../scenes/stage-4.toml")),
    ("two-tops", include_str!("../scenes/two-tops.toml")),
];

/// Largest scene file that is read; a scene is text written by hand.
const LARGEST_BYTES: u64 = 16 << 20;

/// The text of a scene and where it is from.
#[derive(Clone, Debug)]
pub(crate) struct Source {
    /// File, or `built-in NAME`, for messages.
    pub(crate) shown: String,
    /// File, where it is one.
    pub(crate) file: Option<PathBuf>,
    /// Text as given.
    pub(crate) text: String,
}

/// Finds a scene by name or path.
///
/// # Errors
/// There is no such scene, or its file cannot be read.
pub(crate) fn load(wanted: &str) -> Result<Source, Error> {
    if let Some((name, text)) = BUILT_IN.iter().find(|(name, _)| *name == wanted) {
        return Ok(Source { shown: format!("built-in {name}"), file: None, text: (*text).to_owned() });
    }
    let path = Path::new(wanted);
    let text = read(path).map_err(|e| refuse(wanted, path, &e))?;
    Ok(Source { shown: wanted.to_owned(), file: Some(path.to_owned()), text })
}

/// Names of the scenes inside this program.
pub(crate) fn built_in_names() -> impl Iterator<Item = &'static str> {
    BUILT_IN.iter().map(|(name, _)| *name)
}

/// Whether a word on the command line is a scene rather than a command.
pub(crate) fn looks_like_scene(word: &str) -> bool {
    built_in_names().any(|n| n == word) || Path::new(word).extension().is_some_and(|e| e == "toml")
}

fn read(path: &Path) -> io::Result<String> {
    let about = fs::metadata(path)?;
    if !about.is_file() {
        return Err(io::Error::other("it is not a file"));
    }
    if about.len() > LARGEST_BYTES {
        let mib = LARGEST_BYTES >> 20;
        return Err(io::Error::other(format!("it has {} bytes, a scene has at most {mib} MiB", about.len())));
    }
    let mut bytes = Vec::new();
    fs::File::open(path)?.take(LARGEST_BYTES).read_to_end(&mut bytes)?;
    String::from_utf8(bytes).map_err(|e| {
        let at = e.utf8_error().valid_up_to();
        io::Error::other(format!("it is not text in UTF-8: byte {at} is 0x{:02x}", e.as_bytes()[at]))
    })
}

fn refuse(wanted: &str, path: &Path, error: &io::Error) -> Error {
    let names = || list(built_in_names());
    let problem = if error.kind() == io::ErrorKind::NotFound {
        let problem = Problem::new(format!("There is no scene `{wanted}`"))
            .at(path)
            .because("there is no such file")
            .because(format!("built-in scenes are {}", names()));
        match nearest(wanted, path) {
            Some(near) => problem.hint(format!("did you mean `{near}`?")),
            None => problem.hint("give the path of a scene file, or the name of a built-in scene"),
        }
    } else {
        Problem::new(format!("Cannot read the scene `{wanted}`")).at(path).because(error)
    };
    Error::new(Code::Scene, problem)
}

/// A built-in scene or a scene file beside the wanted one that has almost its name.
fn nearest(wanted: &str, path: &Path) -> Option<String> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    // Every package of Rust has a file of this name, and it is no scene.
    let is_scene = |p: &PathBuf| p.extension().is_some_and(|e| e == "toml") && !p.ends_with("Cargo.toml");
    let beside = fs::read_dir(folder).into_iter().flatten().flatten().map(|e| e.path()).filter(is_scene);
    let mut names: Vec<String> = beside
        .map(|p| p.strip_prefix(".").unwrap_or(&p).display().to_string())
        .chain(built_in_names().map(str::to_owned))
        .collect();
    names.sort();
    near_miss(wanted, names.iter().map(String::as_str)).map(str::to_owned)
}

/// Reads a scene after changing values in it; gives its warnings beside it.
///
/// # Errors
/// Every mistake of the text and the changes.
pub(crate) fn parse(source: &Source, overrides: &[String], paint: Paint) -> Result<(Scene, Vec<Problem>), Error> {
    let problems = |found: &[Diagnostic]| -> Vec<Problem> {
        found.iter().map(|d| problem_of(paint, &source.shown, &source.text, d)).collect()
    };
    match parse_with(&source.text, overrides) {
        Ok((scene, warnings)) => Ok((scene, problems(&warnings))),
        Err(mut found) => {
            found.sort_by_key(|d| d.severity);
            let is_broken = found.iter().any(|d| d.severity == Severity::Error);
            debug_assert!(is_broken, "a scene without errors is a scene");
            Err(Error { code: Code::Scene, problems: problems(&found) })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_built_in_scene_is_a_scene_of_its_name() {
        for name in built_in_names() {
            let (scene, warnings) = parse(&load(name).unwrap(), &[], Paint::off()).unwrap();
            assert_eq!(scene.name, name);
            assert_eq!(warnings, []);
        }
        assert!(built_in_names().any(|n| n == DEFAULT));
    }

    #[test]
    fn a_slip_in_the_name_is_noticed() {
        let error = load("oscilator").unwrap_err();
        assert_eq!(error.code, Code::Scene);
        assert_eq!(error.problems[0].hint.as_deref(), Some("did you mean `oscillator`?"));
        let place = tempfile::tempdir().unwrap();
        fs::write(place.path().join("mudslide.toml"), "").unwrap();
        let wanted = place.path().join("mudslid.toml");
        let hint = load(&wanted.to_string_lossy()).unwrap_err().problems[0].hint.clone().unwrap();
        assert!(hint.contains("mudslide.toml"), "{hint}");
    }

    #[test]
    fn what_is_no_text_is_refused_with_the_place() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("x.toml");
        fs::write(&path, b"name = \"\xff\"").unwrap();
        let error = load(&path.to_string_lossy()).unwrap_err();
        assert!(error.problems[0].details[0].contains("byte 8 is 0xff"), "{error:?}");
        assert!(load(&place.path().to_string_lossy()).unwrap_err().problems[0].details[0].contains("not a file"));
    }

    #[test]
    fn changes_reach_the_scene_and_their_mistakes_are_shown() {
        let source = load(DEFAULT).unwrap();
        let (scene, _) = parse(&source, &["clock.window=0.005".into()], Paint::off()).unwrap();
        assert_eq!(scene.clock.window_s, Some(0.005));
        let error = parse(&source, &["clock.windw=0.005".into()], Paint::off()).unwrap_err();
        assert!(error.problems[0].message.contains("windw"), "{error:?}");
    }
}
