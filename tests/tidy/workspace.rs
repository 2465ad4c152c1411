//! The shape of the workspace: what stands at the top, what is built, and that every crate keeps to the lints.

use std::collections::BTreeSet;

use crate::dependencies::graph;
use crate::tree::{files, lines, root, text, tracked};

/// Folders at the top level. One that does not exist yet appears with its first use.
const FOLDERS: [&str; 6] = ["bridges", "core", "launch", "solvers", "tests", "viewer"];

/// Files at the top level.
const FILES: [&str; 10] = [
    "ARCHITECTURE.md",
    "CHANGELOG.md",
    "Cargo.lock",
    "Cargo.toml",
    "LICENSE-APACHE",
    "LICENSE-MIT",
    "NOTICE",
    "README.md",
    "clippy.toml",
    "rustfmt.toml",
];

/// What does not belong at the top level, and what is missing there. Names that begin with a dot are free.
fn strange_at_the_top(paths: &[String]) -> Vec<String> {
    let mut found = BTreeSet::new();
    for path in paths.iter().filter(|path| !path.starts_with('.')) {
        match path.split_once('/') {
            Some((folder, _)) if !FOLDERS.contains(&folder) => found.insert(format!("folder `{folder}` is not known")),
            None if !FILES.contains(&path.as_str()) => found.insert(format!("file `{path}` is not known")),
            _ => false,
        };
    }
    found.extend(FILES.iter().filter(|f| !paths.iter().any(|p| p == *f)).map(|f| format!("file `{f}` is missing")));
    found.into_iter().collect()
}

#[test]
fn the_top_level_holds_six_folders_and_the_files_that_belong_there() {
    let found = strange_at_the_top(&files());
    assert!(
        found.is_empty(),
        "move it into one of the folders {}, or name it in tests/tidy/workspace.rs:{}",
        FOLDERS.join(", "),
        lines(&found)
    );
}

#[test]
fn a_strange_folder_and_a_missing_file_are_noticed() {
    let mut paths: Vec<String> = FILES.iter().skip(1).map(|f| (*f).to_owned()).collect();
    paths.extend([".ci/run", "core/src/lib.rs", "docs/plan.md", "notes.txt"].map(str::to_owned));
    let found = strange_at_the_top(&paths);
    assert_eq!(
        found,
        ["file `ARCHITECTURE.md` is missing", "file `notes.txt` is not known", "folder `docs` is not known"]
    );
}

#[test]
fn the_workspace_has_one_program() {
    let mut programs: Vec<String> = Vec::new();
    for package in graph().members() {
        let own = package.targets.iter().filter(|t| t.is_bin());
        programs.extend(own.map(|t| format!("`{}` of crate `{}`", t.name, package.name)));
    }
    assert_eq!(
        programs,
        ["`cosplat` of crate `cosplat`"],
        "`cargo run --release` needs to know what to run: built-in solvers are run as `cosplat solver NAME`, foreign \
         ones are examples of their crate"
    );
}

#[test]
fn every_crate_is_built_and_tested_by_default() {
    let metadata = graph().metadata();
    let members: BTreeSet<_> = metadata.workspace_members.iter().collect();
    let default: BTreeSet<_> = metadata.workspace_default_members.iter().collect();
    let left_out: Vec<String> = members.difference(&default).map(|id| format!("{id}")).collect();
    assert!(
        left_out.is_empty(),
        "name it in `default-members` too: only then do `cargo run --release` and `cargo test --release` share what \
         they build:{}",
        lines(&left_out)
    );
}

#[test]
fn every_committed_manifest_is_one_of_the_workspace() {
    let members = graph().members();
    let is_member = |path: &String| members.iter().any(|p| p.manifest_path.as_std_path() == root().join(path));
    let outside: Vec<String> =
        tracked().into_iter().filter(|path| path.ends_with("/Cargo.toml") && !is_member(path)).collect();
    assert!(
        outside.is_empty(),
        "name its folder in `members` and `default-members` of Cargo.toml, or it is neither built nor tested:{}",
        lines(&outside)
    );
}

/// Whether a manifest takes its lints from the workspace.
fn takes_lints(manifest: &str) -> bool {
    let mut rest = manifest.lines().map(str::trim).skip_while(|line| *line != "[lints]").skip(1);
    rest.find(|line| !line.is_empty() && !line.starts_with('#'))
        .is_some_and(|line| line.replace(' ', "") == "workspace=true")
}

#[test]
fn every_crate_keeps_to_the_lints_of_the_workspace() {
    let without: Vec<String> = graph()
        .members()
        .iter()
        .filter_map(|p| Some(p.manifest_path.as_std_path().strip_prefix(root()).ok()?.display().to_string()))
        .filter(|manifest| !takes_lints(&text(manifest)))
        .collect();
    assert!(without.is_empty(), "add `[lints]` with `workspace = true` below it:{}", lines(&without));
}

#[test]
fn a_manifest_without_lints_is_noticed() {
    assert!(takes_lints("[package]\nname = \"a\"\n\n[lints]\n# all\nworkspace = true\n"));
    assert!(!takes_lints("[package]\nname = \"a\"\n"));
    assert!(!takes_lints("[lints]\n[dependencies]\nworkspace = true\n"));
    assert!(!takes_lints("[lints.rust]\nunsafe_code = \"allow\"\n"));
}
