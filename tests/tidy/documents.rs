//! Do the documents say what the code says?

use std::collections::BTreeSet;
use std::mem::offset_of;

use cosplat_core::coordinator::Limits;
use cosplat_core::plan::{BoundaryForm, Content};
use cosplat_core::scene::Scheme;
use cosplat_core::wire::{CHUNK_BYTES, HEADER_BYTES, Header, schema_text};

use crate::markdown::{fenced, first_cells, links, literals, rows, section};
use crate::tree::{files, lines, root, text};

const README: &str = "README.md";
const ARCHITECTURE: &str = "ARCHITECTURE.md";
/// The two commands that a newcomer types.
const RUN: &str = "cargo run --release";
const TEST: &str = "cargo test --release";

/// What one list has and the other lacks, in words.
fn difference(documented: &BTreeSet<String>, there: &BTreeSet<String>, document: &str) -> Vec<String> {
    let missing = there.difference(documented).map(|x| format!("`{x}` is missing in {document}"));
    let gone = documented.difference(there).map(|x| format!("`{x}` stands in {document} and does not exist"));
    missing.chain(gone).collect()
}

/// First cells of the table in a section, without backticks.
fn listed(document: &str, heading: &str) -> BTreeSet<String> {
    let text = text(document);
    let part = section(&text, heading);
    let part = part.unwrap_or_else(|| panic!("{document} has no section `{heading}`"));
    first_cells(part).into_iter().map(|cell| cell.trim_matches('`').to_owned()).collect()
}

#[test]
fn lists_that_differ_are_noticed() {
    let set = |names: &[&str]| names.iter().map(|n| (*n).to_owned()).collect::<BTreeSet<_>>();
    assert!(difference(&set(&["a"]), &set(&["a"]), "X").is_empty());
    let found = difference(&set(&["a", "b"]), &set(&["b", "c"]), "X");
    assert_eq!(found, ["`c` is missing in X", "`a` stands in X and does not exist"]);
}

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

#[test]
fn the_architecture_is_read_in_ten_minutes() {
    let length = text(ARCHITECTURE).lines().count();
    assert!(length <= 250, "{ARCHITECTURE} has {length} lines; a map of more than 250 is not read, so shorten it");
}

/// Paths that a document names and that do not exist: literals that begin with a top folder, and links.
fn dead_paths(document: &str, there: &BTreeSet<String>) -> Vec<String> {
    let tops = ["core/", "solvers/", "bridges/", "viewer/", "launch/", "tests/"];
    let is_path = |word: &&str| tops.iter().any(|top| word.starts_with(top)) && !word.contains(['<', '*', ' ', '{']);
    let named = literals(document).into_iter().filter(is_path).chain(links(document));
    let dead = |path: &&str| {
        let path = path.split('#').next().unwrap_or_default();
        let folder = format!("{}/", path.trim_end_matches('/'));
        !(path.is_empty() || there.contains(path) || there.iter().any(|p| p.starts_with(&folder)))
    };
    named.filter(dead).map(str::to_owned).collect()
}

#[test]
fn paths_in_the_documents_exist() {
    let there: BTreeSet<String> = files().into_iter().collect();
    for document in [README, ARCHITECTURE, "CHANGELOG.md", "NOTICE"] {
        let dead = dead_paths(&text(document), &there);
        assert!(dead.is_empty(), "{document} names what is not there; bring it up to date:{}", lines(&dead));
    }
}

#[test]
fn a_path_that_does_not_exist_is_noticed() {
    let there = BTreeSet::from(["core/src/lib.rs".to_owned(), "README.md".to_owned()]);
    let text = "`core/src` `core/src/lib.rs` `core/` `core/gone` `core::time` `viewer/<x>` [a](README.md#b) [c](gone.md) \
                [d](https://x.y)";
    assert_eq!(dead_paths(text, &there), ["core/gone", "gone.md"]);
}

#[test]
fn the_header_table_is_the_header() {
    let fields = [
        ("magic", offset_of!(Header, magic)),
        ("version", offset_of!(Header, version)),
        ("kind", offset_of!(Header, kind)),
        ("run", offset_of!(Header, run)),
        ("schema", offset_of!(Header, schema)),
        ("epoch", offset_of!(Header, epoch)),
        ("sender", offset_of!(Header, sender)),
        ("stream", offset_of!(Header, stream)),
        ("index", offset_of!(Header, index)),
        ("iteration", offset_of!(Header, iteration)),
        ("count", offset_of!(Header, count)),
        ("seq", offset_of!(Header, seq)),
        ("chunk", offset_of!(Header, chunk)),
        ("chunks", offset_of!(Header, chunks)),
        ("length", offset_of!(Header, length)),
        ("content", offset_of!(Header, content)),
        ("hash", offset_of!(Header, hash)),
    ];
    let ends = fields.iter().skip(1).map(|(_, offset)| *offset).chain([HEADER_BYTES]);
    let real: Vec<[String; 3]> = fields
        .iter()
        .zip(ends)
        .map(|((name, offset), end)| [offset.to_string(), (end - offset).to_string(), format!("`{name}`")])
        .collect();
    let text = text(ARCHITECTURE);
    let part = section(&text, "Data frame").expect("ARCHITECTURE.md has a section `Data frame`");
    let written: Vec<[String; 3]> =
        rows(part).into_iter().filter_map(|row| row.get(..3)?.to_vec().try_into().ok()).collect();
    assert_eq!(written, real, "the table in ARCHITECTURE.md (left) must be what core/src/wire/header.rs says (right)");
}

#[test]
fn every_payload_layout_stands_in_the_architecture() {
    let architecture = text(ARCHITECTURE);
    let body = String::new;
    let boundary = |form| Content::Boundary { body: body(), form };
    let impulses = |form| Content::Impulses { interface: 0, form };
    let samples =
        [false, true].map(|normals| [BoundaryForm::SamplesF32 { normals }, BoundaryForm::SamplesF64 { normals }]);
    let mut contents: Vec<Content> = samples.into_iter().flatten().map(boundary).collect();
    contents.extend([Content::Statics { body: body() }, boundary(BoundaryForm::Proxy), impulses(BoundaryForm::Proxy)]);
    contents.push(impulses(BoundaryForm::SamplesF64 { normals: false }));
    for content in contents {
        let layout = schema_text(&content);
        assert!(architecture.contains(layout), "{ARCHITECTURE} must show the layout `{layout}`");
    }
}

#[test]
fn every_coupling_scheme_stands_in_the_architecture() {
    let name = |scheme: Scheme| match scheme {
        Scheme::Serial => "serial",
        Scheme::Parallel => "parallel",
        Scheme::Alternating => "alternating",
        Scheme::Centred => "centred",
    };
    let there = [Scheme::Serial, Scheme::Parallel, Scheme::Alternating, Scheme::Centred].map(name).map(str::to_owned);
    let found = difference(&listed(ARCHITECTURE, "Coupling schemes"), &there.into(), ARCHITECTURE);
    assert!(found.is_empty(), "the table has one row per scheme:{}", lines(&found));
}

#[test]
fn numbers_of_the_protocol_in_the_architecture_are_those_of_the_code() {
    let architecture = text(ARCHITECTURE);
    for phrase in [
        format!("{HEADER_BYTES} bytes"),
        format!("{} KiB", CHUNK_BYTES / 1024),
        format!("`Limits::ahead` = {}", Limits::default().ahead),
    ] {
        assert!(architecture.contains(&phrase), "{ARCHITECTURE} must say \"{phrase}\", as the code does");
    }
}
