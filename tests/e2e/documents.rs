//! Does what the documents show work? Every command in the README and in the examples of `--help` is typed into a
//! shell, in a scratch folder with the files that the examples name.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// Commands that cannot be typed here, and why.
const NOT_TYPED: [(&str, &str); 5] = [
    ("cosplat", "the default scene takes half a minute: `.ci/run` runs it"),
    ("cosplat run", "the same"),
    ("cosplat solver rigid-lite < ticket.json", "a ticket is good for the run that wrote it alone"),
    ("cosplat study sheet impacts", "twelve impacts take minutes: `tests/e2e/study.rs` runs a row of them"),
    ("cosplat splat convert capture.sog capture.ply", "no `.sog` file is shipped: the tests of its reader convert one"),
];

fn root() -> PathBuf {
    PathBuf::from(std::env::var("CARGO_MANIFEST_DIR").expect("cargo runs the tests")).join("..")
}

fn program() -> PathBuf {
    PathBuf::from(env!("CARGO_BIN_EXE_cosplat"))
}

/// A command line in a shell that finds `cosplat`, its folders being below `place`.
fn shell(line: &str, place: &Path) -> Output {
    let bin = program().parent().expect("a program is in a folder").to_owned();
    let path = format!("{}:{}", bin.display(), std::env::var("PATH").unwrap_or_default());
    Command::new("sh")
        .args(["-c", &format!("set -e\n{line}")])
        .current_dir(place)
        .env("PATH", path)
        .env("HOME", place)
        .stdin(Stdio::null())
        .output()
        .expect("there is a shell")
}

#[track_caller]
fn succeed(line: &str, place: &Path) -> String {
    let output = shell(line, place);
    let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "`{line}` ended with {}:\n{err}\n{out}", output.status);
    out.into_owned()
}

/// The command of an example, without the words that explain it.
fn command_of(line: &str) -> &str {
    let line = line.trim();
    let end = line.find("   ").or_else(|| line.find(" # ")).unwrap_or(line.len());
    line[..end].trim()
}

/// Lines of the fenced shell blocks of the README that call the program.
fn of_the_readme() -> Vec<String> {
    let readme = fs::read_to_string(root().join("README.md")).expect("there is a README");
    let blocks = readme.split("```sh\n").skip(1).filter_map(|rest| rest.split_once("```").map(|(block, _)| block));
    let lines = blocks.flat_map(str::lines).map(|line| line.replace("cargo run --release -- ", "cosplat "));
    lines.filter(|line| line.starts_with("cosplat ")).map(|line| command_of(&line).to_owned()).collect()
}

/// Examples in the help of a command and of those below it.
fn of_the_help(command: &str, place: &Path, found: &mut Vec<String>) {
    let help = succeed(&format!("cosplat {command} --help"), place);
    let examples = help.split_once("Examples:\n").map_or("", |(_, rest)| rest);
    let examples = examples.lines().take_while(|line| line.starts_with("  "));
    found.extend(examples.map(command_of).filter(|line| line.starts_with("cosplat")).map(str::to_owned));
    let below = help.split_once("Commands:\n").map_or("", |(_, rest)| rest);
    for line in below.lines().take_while(|line| line.starts_with("  ")) {
        // Names stand two characters in, what explains them further.
        let name = line[2..].split(' ').next().unwrap_or_default();
        if !name.is_empty() && name != "help" {
            of_the_help(format!("{command} {name}").trim(), place, found);
        }
    }
}

/// A folder with everything that the examples name.
fn prepared() -> tempfile::TempDir {
    let place = tempfile::tempdir().expect("a scratch folder");
    let at = |name: &str| place.path().join(name);
    let folders =
        [".local/share/man/man1", ".local/share/bash-completion/completions", ".zfunc", ".config/fish/completions"];
    for folder in folders {
        fs::create_dir_all(at(folder)).expect("a folder can be made");
    }
    let scene = fs::read_to_string(root().join("launch/scenes/oscillator.toml")).expect("the scene is there");
    // With frames, which some examples show.
    let scene = scene.replacen("[clock]\n", "[clock]\nfps = 10\n", 1);
    for name in ["scene.toml", "my-scene.toml"] {
        fs::write(at(name), &scene).expect("a file");
    }
    fs::create_dir_all(at("verification")).expect("a folder can be made");
    for name in ["free-flight.study.toml", "hanging-strip.study.toml", "hanging-strip.toml"] {
        let case = root().join("tests/verification").join(name);
        fs::copy(case, at("verification").join(name)).expect("the case is there");
    }
    for name in ["plant.spz", "capture.spz"] {
        fs::copy(root().join("launch/scenes/assets/plant.v4.spz"), at(name)).expect("the capture is there");
    }
    succeed("cosplat splat convert plant.spz plant.ply && cp plant.ply capture.ply", place.path());
    place
}

/// What an example needs beside the files: runs to report, a scene that another example has written.
fn needs(line: &str) -> Option<&'static str> {
    if line.starts_with("cosplat report") {
        return Some("for run in a b coarse fine; do cosplat run oscillator --quiet --out out/$run; done");
    }
    if line.contains("--resume") {
        // Long enough for the disk to store one before the end.
        return Some("cosplat run my-scene.toml --quiet --checkpoint-every 0.5 --set clock.duration=40");
    }
    if line.contains("out/NAME/splats") {
        return Some("mkdir -p out/NAME/splats; for n in 10 11; do cp plant.ply out/NAME/splats/frame_00$n.ply; done");
    }
    if line.contains("--mask") {
        // What is light in a picture of the capture itself.
        return Some(
            "rm -f object.ply mask.png && cosplat splat render capture.ply mask.png --size 96x72 --eye 0,0,-2 --target 0,0,0 && \
             echo '{\"eye\": [0, 0, -2], \"target\": [0, 0, 0], \"up\": [0, -1, 0], \"fov_y_deg\": 40}' > camera.json",
        );
    }
    line.contains("first.toml").then_some("rm -f first.toml && cosplat new first")
}

/// Types every command that is shown and chosen.
fn type_all(chosen: impl Fn(&str) -> bool) {
    let place = prepared();
    let shown: Vec<String> = shown(place.path()).into_iter().filter(|line| chosen(line)).collect();
    let has_jq = shell("jq --version", place.path()).status.success();
    for line in shown.iter().filter(|line| NOT_TYPED.iter().all(|(excused, _)| excused != line)) {
        let typed = if has_jq { line.as_str() } else { line.split(" | jq").next().unwrap_or(line) };
        if let Some(before) = needs(typed) {
            succeed(before, place.path());
        }
        for made in ["first.toml", "plant.toml"].iter().filter(|_| typed.starts_with("cosplat new")) {
            let _ = fs::remove_file(place.path().join(made));
        }
        succeed(typed, place.path());
    }
}

/// Every command that a document shows, each once.
fn shown(place: &Path) -> BTreeSet<String> {
    let mut shown = of_the_readme();
    of_the_help("", place, &mut shown);
    // Not listed: people do not call it.
    of_the_help("solver", place, &mut shown);
    shown.into_iter().collect()
}

#[test]
fn every_excuse_is_needed() {
    let place = tempfile::tempdir().expect("a scratch folder");
    let shown = shown(place.path());
    assert!(shown.len() > 20, "only {} commands were found: {shown:?}", shown.len());
    for (line, _) in NOT_TYPED {
        assert!(shown.contains(line), "`{line}` is excused, but no document shows it");
    }
}

#[test]
fn every_command_that_is_shown_works() {
    type_all(|line| !line.starts_with("cosplat splat"));
}

#[test]
fn every_command_for_splat_files_that_is_shown_works() {
    type_all(|line| line.starts_with("cosplat splat"));
}

#[test]
fn every_built_in_scene_begins() {
    let place = tempfile::tempdir().expect("a scratch folder");
    let list = succeed("cosplat list --format json", place.path());
    let list: Vec<serde_json::Value> = serde_json::from_str(&list).expect("the list is JSON");
    assert!(list.len() > 5, "{list:?}");
    for scene in list {
        let name = scene["name"].as_str().expect("a scene has a name");
        // A few windows: that a whole run keeps its promises is the business of other tests.
        let line = format!(
            "cosplat run {name} --quiet --set clock.duration=0.01 --set output.pictures=false --set output.splats=false --set output.recording=false"
        );
        succeed(&line, place.path());
    }
}
