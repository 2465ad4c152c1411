//! What every source file keeps to.

use std::collections::BTreeSet;

use crate::code::{lines_with, masked, test_modules, without_tests};
use crate::tree::{lines, text, text_if_any, with_extension};

/// No source file is longer than this.
const LONGEST: usize = 500;
/// Nine of ten source files are no longer than this.
const COMMON: usize = 300;

/// What ends the program where an error should be passed on.
const ENDS_IN_PANIC: [&str; 5] = [".unwrap()", ".expect(", "todo!(", "unimplemented!(", "dbg!("];

/// Ways to the outside that a library without input and output does not know.
const OUTSIDE: [&str; 12] = [
    "std::fs",
    "std::net",
    "std::process",
    "std::env",
    "std::io",
    "std::thread",
    "Instant",
    "SystemTime",
    "print!",
    "println!",
    "eprint!",
    "eprintln!",
];

/// Where nothing of [`OUTSIDE`] stands: the core, and every solver library.
fn computes_only(path: &str) -> bool {
    let inside = |prefix: &str| path.starts_with(prefix) && path.contains("/src/");
    inside("core/") || (inside("solvers/") && !inside("solvers/dummy/"))
}

/// A source file and its code: no comments, no literals, no tests.
struct Source {
    path: String,
    code: String,
}

/// Every file that is built into something, without what exists in tests only.
fn sources() -> Vec<Source> {
    let all: Vec<Source> =
        with_extension("rs").into_iter().map(|path| Source { code: masked(&text(&path)), path }).collect();
    let tests: Vec<String> =
        all.iter().flat_map(|s| test_modules(&s.code).into_iter().map(|name| module_stem(&s.path, &name))).collect();
    let only_tests = |path: &str| {
        let folder = path.split('/').any(|part| ["tests", "examples", "benches"].contains(&part));
        folder || tests.iter().any(|stem| path == format!("{stem}.rs") || path.starts_with(&format!("{stem}/")))
    };
    let found: Vec<Source> = all
        .into_iter()
        .filter(|s| !only_tests(&s.path))
        .map(|s| Source { code: without_tests(&s.code), ..s })
        .collect();
    assert!(found.iter().any(|s| s.path == "core/src/lib.rs"), "the sources of the core are not found");
    found
}

/// Where the file of module `name`, declared in `path`, lies, without its ending.
fn module_stem(path: &str, name: &str) -> String {
    let (folder, file) = path.rsplit_once('/').unwrap_or(("", path));
    match file.trim_end_matches(".rs") {
        "mod" | "lib" | "main" => format!("{folder}/{name}"),
        stem => format!("{folder}/{stem}/{name}"),
    }
}

/// `path:line: pattern` for each place where one of the patterns stands.
fn places(sources: &[Source], patterns: &[&str]) -> Vec<String> {
    let in_one = |source: &Source| -> Vec<String> {
        let of = |pattern: &&str| {
            let numbers = lines_with(&source.code, pattern);
            numbers.into_iter().map(|n| format!("{}:{n}: `{pattern}`", source.path)).collect::<Vec<_>>()
        };
        patterns.iter().flat_map(of).collect()
    };
    sources.iter().flat_map(in_one).collect()
}

/// Files over the longest length, and whether enough are short.
fn lengths(files: &[(String, usize)]) -> (Vec<String>, bool) {
    let long = files.iter().filter(|(_, n)| *n > LONGEST).map(|(path, n)| format!("{path}: {n} lines")).collect();
    let short = files.iter().filter(|(_, n)| *n <= COMMON).count();
    (long, short * 10 >= files.len() * 9)
}

fn measured() -> Vec<(String, usize)> {
    with_extension("rs").into_iter().map(|path| (path.clone(), text(&path).lines().count())).collect()
}

#[test]
fn the_folder_is_asked_for_while_a_test_runs() {
    // A target folder may be shared: a test that another clone has built would look at that clone.
    let baked = concat!("env!(\"CARGO_MANIFEST", "_DIR\")");
    let found: Vec<String> = with_extension("rs").into_iter().filter(|path| text(path).contains(baked)).collect();
    assert!(found.is_empty(), "take `std::env::var` instead of `env!` in {found:?}");
}

#[test]
fn no_source_file_is_longer_than_500_lines() {
    let (long, _) = lengths(&measured());
    assert!(long.is_empty(), "a file is one idea; give these folders of their own and split them:{}", lines(&long));
}

#[test]
fn nine_of_ten_source_files_have_at_most_300_lines() {
    let files = measured();
    let mut long: Vec<String> =
        files.iter().filter(|(_, n)| *n > COMMON).map(|(path, n)| format!("{n} lines: {path}")).collect();
    long.sort();
    long.reverse();
    let (_, enough) = lengths(&files);
    assert!(enough, "{} of {} files are longer; split some of these:{}", long.len(), files.len(), lines(&long));
}

#[test]
fn long_files_are_noticed() {
    let file = |n: usize| (format!("{n}.rs"), n);
    let short: Vec<_> = (0..9).map(file).collect();
    assert_eq!(lengths(&[short.clone(), vec![file(500)]].concat()), (vec![], true));
    assert_eq!(lengths(&[short.clone(), vec![file(501)]].concat()), (vec!["501.rs: 501 lines".to_owned()], true));
    assert_eq!(lengths(&[short[1..].to_vec(), vec![file(301)]].concat()), (vec![], false));
}

#[test]
fn nothing_outside_tests_ends_in_a_panic_by_choice() {
    let found = places(&sources(), &ENDS_IN_PANIC);
    assert!(
        found.is_empty(),
        "return an error that says who, where, what and what to do, or use a form that cannot fail \
         (`unwrap_or_default`, `map_or`, `let ... else`):{}",
        lines(&found)
    );
}

#[test]
fn core_and_solver_libraries_do_no_input_or_output() {
    let pure: Vec<Source> = sources().into_iter().filter(|s| computes_only(&s.path)).collect();
    assert!(pure.iter().any(|s| s.path.starts_with("solvers/")), "the sources of the solvers are not found");
    let found = places(&pure, &OUTSIDE);
    assert!(
        found.is_empty(),
        "take it as an argument, or move it to `bridges/` or `launch/`: a library that only computes can be simulated, \
         replayed and run anywhere:{}",
        lines(&found)
    );
}

#[test]
fn unsafe_stands_nowhere() {
    let all: Vec<Source> =
        with_extension("rs").into_iter().map(|path| Source { code: masked(&text(&path)), path }).collect();
    let found = places(&all, &["unsafe"]);
    assert!(
        found.is_empty(),
        "use a safe form, or a package whose business it is (`bytemuck`, `rustix`):{}",
        lines(&found)
    );
}

#[test]
fn patterns_are_found_with_their_place() {
    let one = |code: &str| Source { path: "a.rs".into(), code: masked(code) };
    let source = one("fn f() {\n  g().unwrap();\n  println!();\n  let t = Instant::now();\n}\nstruct InstantRice;");
    assert_eq!(places(std::slice::from_ref(&source), &ENDS_IN_PANIC), ["a.rs:2: `.unwrap()`"]);
    assert_eq!(places(&[source], &OUTSIDE), ["a.rs:4: `Instant`", "a.rs:3: `println!`"]);
    assert!(places(&[one("a.unwrap_or(b)\n// c.unwrap()")], &ENDS_IN_PANIC).is_empty());
}

#[test]
fn modules_are_found_where_rust_looks_for_them() {
    assert_eq!(module_stem("core/src/lib.rs", "tests"), "core/src/tests");
    assert_eq!(module_stem("core/src/scene/read/mod.rs", "tests"), "core/src/scene/read/tests");
    assert_eq!(module_stem("core/src/scene/read.rs", "tests"), "core/src/scene/read/tests");
    assert!(computes_only("core/src/time.rs") && computes_only("solvers/rigid-lite/src/lib.rs"));
    assert!(!computes_only("solvers/dummy/src/lib.rs") && !computes_only("launch/src/main.rs"));
}

/// Paths of single machines and hosts of package registries, cut in two so that this file does not hold them.
const MACHINES: [(&str, &str); 10] = [
    ("/wo", "rk/"),
    ("/fa", "rm/"),
    ("/ro", "ot/"),
    ("/home", "/"),
    ("artif", "actory"),
    ("index.", "crates.io"),
    ("static.", "crates.io"),
    ("files.", "pythonhosted"),
    ("registry.", "npmjs"),
    ("deb.", "debian.org"),
];

/// `line: what` for each machine path or registry host in a text.
fn machines_in(text: &str) -> Vec<String> {
    let names: Vec<String> = MACHINES.iter().map(|(a, b)| format!("{a}{b}")).collect();
    let named = |(number, line): (usize, &str)| {
        let name = names.iter().find(|name| line.contains(name.as_str()))?;
        Some(format!("{}: `{name}`", number + 1))
    };
    text.lines().enumerate().filter_map(named).collect()
}

#[test]
fn no_text_names_a_path_of_one_machine_or_a_registry_host() {
    let in_file = |path: String| -> Vec<String> {
        let found = text_if_any(&path).map(|text| machines_in(&text)).unwrap_or_default();
        found.into_iter().map(|place| format!("{path}:{place}")).collect()
    };
    let found: BTreeSet<String> = crate::tree::files().into_iter().flat_map(in_file).collect();
    let found: Vec<String> = found.into_iter().collect();
    assert!(
        found.is_empty(),
        "write a path relative to the repository or below `$HOME`, and name packages without their registry:{}",
        lines(&found)
    );
}

#[test]
fn a_path_of_one_machine_is_noticed() {
    let bad: Vec<String> = MACHINES.iter().map(|(a, b)| format!("see {a}{b}main")).collect();
    assert_eq!(machines_in(&bad.join("\n")).len(), MACHINES.len());
    assert!(machines_in("network/work\nhttps://crates.io\nframework/x\n~/.cache").is_empty());
}
