//! Do the suites of `cosplat study` say what they should? A quick part of each, through real processes.

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use serde_json::Value;

fn study(folder: &Path, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cosplat"));
    command.arg("study").args(args).args(["--out", "result", "--quiet", "--format", "json"]);
    command.current_dir(folder).stdin(Stdio::null()).output().expect("cosplat starts")
}

#[track_caller]
fn answer(output: &Output, code: i32) -> Value {
    let talk = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{talk}\n{}", String::from_utf8_lossy(&output.stdout));
    serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {talk}"))
}

fn words<'a>(answer: &'a Value, list: &str, key: &str) -> Vec<&'a str> {
    let items = answer[list].as_array().expect("there is a list");
    items.iter().map(|item| item[key].as_str().expect("it has a word")).collect()
}

#[test]
fn the_map_of_extreme_settings_has_no_silent_failure() {
    let place = tempfile::tempdir().expect("a scratch folder");
    let found = answer(&study(place.path(), &["stability", "--only", "courant,liquid-of-points"]), 0);
    let behaviours = words(&found, "map", "behaviour");
    assert!(behaviours.len() == 8, "{behaviours:?}");
    assert!(behaviours.contains(&"correct") && behaviours.contains(&"degraded"), "{behaviours:?}");
    // The second seed's liquid at its published step: the solver takes shorter ones and keeps what it should.
    let mut liquid = found["map"].as_array().expect("a map").iter().filter(|f| f["case"] == "liquid-of-points");
    assert!(liquid.all(|f| f["behaviour"] == "correct"), "{found}");
    let page = fs::read_to_string(place.path().join("result/stability.html")).expect("there is a page");
    assert!(page.contains("fails in silence"), "the page says what was found");
    let table = fs::read_to_string(place.path().join("result/stability.csv")).expect("there is a table");
    assert_eq!(table.lines().count(), 1 + behaviours.len());
}

#[test]
fn a_case_that_is_not_there_is_a_mistake() {
    let place = tempfile::tempdir().expect("a scratch folder");
    let unknown = study(place.path(), &["stability", "--only", "no-such-case"]);
    assert_eq!(unknown.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&unknown.stderr).contains("There is no case `no-such-case`"));
}

#[test]
fn gates_notice_what_is_broken_on_purpose() {
    let place = tempfile::tempdir().expect("a scratch folder");
    let quick = "gravity,stale-boundary,drop-reaction,strong-reaction,inertia";
    let found = answer(&study(place.path(), &["negative-controls", "--only", quick]), 0);
    let controls = found["controls"].as_array().expect("there are controls");
    assert_eq!(controls.len(), 5);
    for control in controls {
        let passed = (control["sound"]["passed"].as_bool(), control["broken"]["passed"].as_bool());
        assert_eq!(passed, (Some(true), Some(false)), "{control}");
    }
}

/// Cases that take a second or less; the others are run by `cosplat study tests/verification`.
const QUICK: [&str; 6] = ["ballistic", "free-flight", "ladder", "pendulum", "spinning-disc", "tumbling-top"];

#[test]
fn quick_cases_hold_their_gates() {
    let place = tempfile::tempdir().expect("a scratch folder");
    let folder =
        Path::new(&std::env::var("CARGO_MANIFEST_DIR").expect("cargo runs the tests")).join("../tests/verification");
    for name in QUICK {
        let case = folder.join(format!("{name}.study.toml"));
        let case = case.to_str().expect("the folder's name is text");
        let found = answer(&study(place.path(), &[case, "--runs", "1"]), 0);
        let gates = found["cases"][0]["gates"].as_array().expect("there are gates");
        assert!(!gates.is_empty() && gates.iter().all(|gate| gate["passed"] == true), "{name}: {gates:?}");
    }
}

#[test]
fn what_has_no_effect_leaves_the_same_bytes() {
    let place = tempfile::tempdir().expect("a scratch folder");
    let found = answer(&study(place.path(), &["ablation", "oscillator"]), 0);
    let decisions = found["decisions"].as_array().expect("there are decisions");
    assert!(words(&found, "decisions", "name").contains(&"idle-process"));
    assert!(decisions.iter().all(|d| d["same_bytes"] == true && d["difference"] == 0.0), "{decisions:?}");
}
