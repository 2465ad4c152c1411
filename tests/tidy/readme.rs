//! Does the README say what the program does?

use std::collections::BTreeSet;

use crate::documents::{README, difference, listed};
use crate::markdown::fenced;
use crate::tree::{files, lines, root, text};

/// The two commands that a newcomer types.
const RUN: &str = "cargo run --release";
const TEST: &str = "cargo test --release";

#[test]
fn every_scene_is_in_the_readme() {
    let stem = |path: &String| Some(path.strip_prefix("launch/scenes/")?.strip_suffix(".toml")?.to_owned());
    let there: BTreeSet<String> = files().iter().filter_map(stem).collect();
    assert!(!there.is_empty(), "no scene is found in launch/scenes/");
    let found = difference(&listed(README, "Scenes"), &there, "the table of scenes in README.md");
    assert!(found.is_empty(), "one row per scene, its name first:{}", lines(&found));
}

/// Subcommands by the names of the enum's variants.
fn commands(cli: &str) -> BTreeSet<String> {
    let body = cli.split_once("enum Command {").map_or("", |(_, rest)| rest);
    let body = body.split_once("\n}").map_or(body, |(body, _)| body);
    let variant = |line: &str| {
        let name = line.strip_prefix("    ")?.split_once('(')?.0;
        name.starts_with(char::is_uppercase).then(|| kebab(name))
    };
    body.lines().filter_map(variant).collect()
}

/// `TwoWords` as `two-words`.
fn kebab(name: &str) -> String {
    name.chars().enumerate().fold(String::new(), |mut out, (i, c)| {
        if i > 0 && c.is_uppercase() {
            out.push('-');
        }
        out.extend(c.to_lowercase());
        out
    })
}

#[test]
fn every_command_is_in_the_readme() {
    let there = commands(&text("launch/src/cli.rs"));
    assert!(there.contains("run"), "the commands are not found in launch/src/cli.rs");
    let documented = listed(README, "Commands");
    let names = documented.iter().filter_map(|c| c.strip_prefix("cosplat ")?.split_whitespace().next());
    let found = difference(&names.map(str::to_owned).collect(), &there, "the table of commands in README.md");
    assert!(found.is_empty(), "one row per command, as `cosplat NAME …`:{}", lines(&found));
}

#[test]
fn commands_are_read_from_their_enum() {
    let cli = "enum Other {\n    A(B),\n}\nenum Command {\n    /// Run (a)\n    Run(RunArgs),\n    #[command(hide = true)]\n    \
               TwoWords(X),\n}\nenum Later {\n    C(D),\n}";
    assert_eq!(commands(cli).into_iter().collect::<Vec<_>>(), ["run", "two-words"]);
}

#[test]
fn commands_in_the_readme_can_be_typed() {
    let readme = text(README);
    let known = commands(&text("launch/src/cli.rs"));
    for line in fenced(&readme, "sh").lines() {
        let Some((_, typed)) = line.split_once("cosplat ").or_else(|| line.split_once("cargo run --release -- "))
        else {
            continue;
        };
        let command = typed.split_whitespace().next().unwrap_or_default();
        assert!(known.contains(command), "README.md shows `{line}`, but there is no command `{command}`");
        let scene = typed.split_whitespace().nth(1).filter(|_| ["run", "check"].contains(&command));
        if let Some(scene) = scene.filter(|s| !s.starts_with('-') && !s.contains('.')) {
            let there = root().join(format!("launch/scenes/{scene}.toml")).exists();
            assert!(there, "README.md shows `{line}`, but there is no scene `{scene}`");
        }
    }
}

#[test]
fn the_two_commands_of_the_readme_are_what_is_run() {
    let readme = text(README);
    let shown = fenced(&readme, "sh");
    for command in [RUN, TEST] {
        let typed = shown.lines().any(|line| line.split('#').next().is_some_and(|l| l.trim() == command));
        assert!(typed, "README.md must show `{command}` on a line of its own");
        let script = text(".ci/run");
        assert!(script.contains(command), ".ci/run must run `{command}`, exactly as README.md says");
    }
}

/// Exit codes as the help lists them.
fn exit_codes(cli: &str) -> BTreeSet<String> {
    let list = cli.split_once("Exit codes:").and_then(|(_, rest)| rest.split_once("\";")).map_or("", |(list, _)| list);
    list.lines()
        .filter_map(|line| line.split_whitespace().next())
        .filter(|w| w.parse::<u8>().is_ok())
        .map(str::to_owned)
        .collect()
}

#[test]
fn every_exit_code_is_in_the_readme() {
    let there = exit_codes(&text("launch/src/cli.rs"));
    assert!(there.contains("0"), "the exit codes are not found in launch/src/cli.rs");
    let found = difference(&listed(README, "Exit codes"), &there, "the table of exit codes in README.md");
    assert!(found.is_empty(), "one row per code:{}", lines(&found));
}

#[test]
fn exit_codes_are_read_from_the_help() {
    let cli = "const EXIT_CODES: &str = \"\\\nExit codes:\n    0  good\n   13  worse than\n       7 lines\n\";\n 9 \";";
    assert_eq!(exit_codes(cli).into_iter().collect::<Vec<_>>(), ["0", "13", "7"]);
}

/// Files of a run folder by their constants.
fn run_files(module: &str) -> BTreeSet<String> {
    let value = |line: &str| {
        let (_, value) = line.strip_prefix("pub(crate) const ")?.split_once(": &str = \"")?;
        let name = value.strip_suffix("\";")?;
        (!name.contains(' ')).then(|| name.to_owned())
    };
    module.lines().filter_map(value).collect()
}

#[test]
fn every_file_of_a_run_folder_is_in_the_readme() {
    let there = run_files(&text("launch/src/folder/mod.rs"));
    assert!(there.contains("summary.json"), "the names of the files are not found in launch/src/folder/mod.rs");
    let documented: BTreeSet<String> =
        listed(README, "Run folder").iter().map(|name| name.trim_end_matches('/').to_owned()).collect();
    let found = difference(&documented, &there, "the table of the run folder in README.md");
    assert!(found.is_empty(), "one row per file:{}", lines(&found));
}

#[test]
fn files_of_a_run_folder_are_read_from_their_constants() {
    let module = "pub(crate) const RUN: &str = \"run.toml\";\npub(crate) const MARK: &str = \"# A line.\";\nconst X: &str = \"x\";";
    assert_eq!(run_files(module).into_iter().collect::<Vec<_>>(), ["run.toml"]);
}
