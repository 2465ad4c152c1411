//! The files of the repository.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Folders that hold what programs made.
const MADE: [&str; 3] = [".git", "target", "out"];

/// The folder that holds the workspace.
pub(crate) fn root() -> PathBuf {
    // Asked while it runs: a test that another clone has built in a shared target folder would look there otherwise.
    let tests = std::env::var_os("CARGO_MANIFEST_DIR").expect("cargo runs the tests");
    Path::new(&tests).parent().expect("the tests lie in a folder of the workspace").to_owned()
}

/// Every file that is or could be committed, relative to [`root`], with `/` between its parts, in order.
pub(crate) fn files() -> Vec<String> {
    present(listed_by_git(&["--cached", "--others", "--exclude-standard"]).unwrap_or_else(walked))
}

/// Every file that is committed or about to be; all files where there is no git.
pub(crate) fn tracked() -> Vec<String> {
    present(listed_by_git(&["--cached"]).unwrap_or_else(walked))
}

fn present(mut found: Vec<String>) -> Vec<String> {
    // A file that was removed and not yet committed is still listed.
    found.retain(|path| root().join(path).is_file());
    found.sort();
    found.dedup();
    assert!(
        found.iter().any(|path| path == "Cargo.toml"),
        "`Cargo.toml` is not among the files below {}",
        root().display()
    );
    found
}

/// What git lists when asked so; nothing where there is no git or no repository.
fn listed_by_git(which: &[&str]) -> Option<Vec<String>> {
    let answer = Command::new("git").arg("-C").arg(root()).args(["ls-files", "-z"]).args(which).output().ok()?;
    let text = String::from_utf8(answer.stdout).ok()?;
    let files: Vec<String> = text.split('\0').filter(|path| !path.is_empty()).map(str::to_owned).collect();
    (answer.status.success() && !files.is_empty()).then_some(files)
}

fn walked() -> Vec<String> {
    let mut found = Vec::new();
    walk(&root(), "", &mut found);
    found
}

fn walk(folder: &Path, prefix: &str, found: &mut Vec<String>) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let Ok(name) = entry.file_name().into_string() else { continue };
        let path = format!("{prefix}{name}");
        if entry.path().is_dir() {
            if !MADE.contains(&name.as_str()) {
                walk(&entry.path(), &format!("{path}/"), found);
            }
        } else {
            found.push(path);
        }
    }
}

/// Files with that extension.
pub(crate) fn with_extension(extension: &str) -> Vec<String> {
    files().into_iter().filter(|path| has_extension(path, extension)).collect()
}

fn has_extension(path: &str, extension: &str) -> bool {
    Path::new(path).extension().is_some_and(|end| end == extension)
}

/// Text of a file that must be there.
pub(crate) fn text(path: &str) -> String {
    let read = fs::read_to_string(root().join(path));
    read.unwrap_or_else(|error| panic!("`{path}` cannot be read: {error}"))
}

/// Text of a file, if it is text.
pub(crate) fn text_if_any(path: &str) -> Option<String> {
    String::from_utf8(fs::read(root().join(path)).ok()?).ok().filter(|text| !text.contains('\0'))
}

/// One finding a line, for a message.
pub(crate) fn lines(found: &[String]) -> String {
    found.iter().fold(String::new(), |text, line| text + "\n  " + line)
}

#[test]
fn git_and_a_walk_find_the_same_sources() {
    let sources = |files: Vec<String>| {
        let mut files: Vec<String> = files
            .into_iter()
            .filter(|path| path.contains("/src/") && has_extension(path, "rs") && root().join(path).is_file())
            .collect();
        files.sort();
        files
    };
    let Some(listed) = listed_by_git(&["--cached", "--others", "--exclude-standard"]) else { return };
    assert_eq!(sources(listed), sources(walked()), "`.gitignore` or the list of made folders hides a source file");
}
