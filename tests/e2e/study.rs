//! Does a study recover what is known? The partitioned oscillator through real processes: the orders of its schemes, the
//! files that a study leaves, a gate that turns red, and runs that are not made twice.

mod support;

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

/// Orders of Schüller, Rodenberg, Uekermann, Bungartz (2022); an interval of ±5 % is what windows of 20 to 5 ms leave of
/// the terms of higher order.
const CASE: &str = r#"
format = 1
title = "Orders of the link schemes"
scene = "oscillator"
source = "Schüller et al. 2022"

[[quantity]]
probe = "left.x"
exact = "0.5*(cos(2*PI*t) + cos(6*PI*t))"

[[quantity]]
probe = "right.x"
exact = "0.5*(cos(2*PI*t) - cos(6*PI*t))"

[vary]
"clock.link_scheme" = ["parallel", "serial", "alternating"]
"clock.window" = [0.01, 0.005, 0.0025]

[[gate]]
where = { "clock.link_scheme" = "parallel" }
order = [0.95, 1.05]
reason = "first order"

[[gate]]
where = { "clock.link_scheme" = "serial" }
order = [0.95, 1.05]
reason = "first order"

[[gate]]
where = { "clock.link_scheme" = "alternating" }
order = [1.95, 2.05]
reason = "second order"
"#;

fn study(folder: &Path, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cosplat"));
    command.arg("study").args(args).current_dir(folder).stdin(Stdio::null());
    command.output().expect("cosplat starts")
}

#[track_caller]
fn answer(output: &Output, code: i32) -> Value {
    let talk = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{talk}\n{}", String::from_utf8_lossy(&output.stdout));
    serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {talk}"))
}

const QUIET: [&str; 5] = ["--runs", "1", "--quiet", "--format", "json"];

#[test]
fn a_study_recovers_known_orders_and_does_nothing_twice() {
    let place = tempfile::tempdir().expect("a scratch folder");
    let file = place.path().join("c1.study.toml");
    fs::write(&file, CASE).expect("the case can be written");
    let args = [&["c1.study.toml", "--out", "result"], QUIET.as_slice()].concat();
    let first = answer(&study(place.path(), &args), 0);
    let case = &first["cases"][0];
    for (group, order) in [(0, 1.0), (1, 1.0), (2, 2.0)] {
        let fit = &case["groups"][group]["fit"];
        let found = fit["order"].as_f64().expect("three levels have an order");
        assert!((found - order).abs() < 0.05, "{fit}");
        assert!(fit["plus_minus"].as_f64().is_some_and(|half| half < 0.5), "{fit}");
    }
    let rows = case["rows"].as_array().expect("there are runs");
    assert!(rows.iter().all(|row| row["outcome"] == "correct" && row["cached"] == 0), "{rows:?}");
    // Coupling alone makes the error here: the distance from the finest window and its error add up to it.
    let number = |row: &Value, key: &str| row[key].as_f64().unwrap_or(f64::NAN);
    let parts = number(&rows[0], "error_coupling") + number(&rows[0], "error_solver");
    assert!((parts / number(&rows[0], "error") - 1.0).abs() < 0.1, "{}", rows[0]);
    let table = fs::read_to_string(place.path().join("result/study.csv")).expect("there is a table");
    assert_eq!(table.lines().count(), 1 + rows.len(), "{table}");
    assert!(table.starts_with("case,clock.link_scheme,clock.window,"), "{table}");
    let page = fs::read_to_string(place.path().join("result/study.html")).expect("there is a page");
    assert!(page.contains("Error against run time") && !page.contains("<script"), "the page has its diagram");
    let kept: Value = serde_json::from_slice(&fs::read(place.path().join("result/study.json")).expect("there is"))
        .expect("`study.json` is JSON");
    assert_eq!(kept, first);

    let began = Instant::now();
    // The gate that is wrong now turns the same runs red.
    fs::write(&file, CASE.replace("[1.95, 2.05]", "[2.5, 3.0]")).expect("the case can be written");
    let second = answer(&study(place.path(), &args), 7);
    assert!(began.elapsed() < Duration::from_secs(8), "nothing was to run: {:?}", began.elapsed());
    assert!(second["cases"][0]["rows"].as_array().is_some_and(|rows| rows.iter().all(|row| row["cached"] == 1)));
    let gates = second["cases"][0]["gates"].as_array().expect("gates are judged");
    assert_eq!(gates.iter().map(|gate| gate["passed"] == true).collect::<Vec<_>>(), [true, true, false]);

    // What is explained stays red, and is no failure of the study.
    let known = CASE.replace("[1.95, 2.05]", "[2.5, 3.0]") + "explained = \"Strang splitting is no better\"\n";
    fs::write(&file, known).expect("the case can be written");
    let third = answer(&study(place.path(), &args), 0);
    let gate = &third["cases"][0]["gates"][2];
    assert_eq!(
        (gate["passed"].as_bool(), gate["explained"].as_str()),
        (Some(false), Some("Strang splitting is no better"))
    );
    let talk = study(place.path(), &["c1.study.toml", "--out", "result", "--runs", "1"]);
    let talk = String::from_utf8_lossy(&talk.stdout).into_owned();
    assert!(talk.contains("gate failed:") && talk.contains("explained: Strang splitting is no better"), "{talk}");
}

/// Masses and springs twice as large swing alike; a length of two is one of the other scene, a second half a second.
const TWIN: &str = r#"
format = 1
scene = "oscillator"
source = "what is scaled alike moves alike"

[twin]
time = 0.5

[set]
"clock.duration" = 0.5
"clock.window" = 0.005
"body.left.mass" = 2
"body.right.mass" = 2
"body.left.position" = [2, 0, 0]
"link.left-wall.stiffness" = 315.82734083485946
"link.right-wall.stiffness" = 315.82734083485946
"link.between.stiffness" = 1263.3093633394378

[vary]
"clock.link_scheme" = ["serial", "alternating"]

[[quantity]]
probe = "right.x"
twin = 2

[[gate]]
error = 1e-9
reason = "roundings of two hundred windows"
"#;

#[test]
fn a_scene_may_be_compared_with_another_one() {
    let place = tempfile::tempdir().expect("a scratch folder");
    let file = place.path().join("twin.study.toml");
    fs::write(&file, TWIN).expect("the case can be written");
    let args = [&["twin.study.toml", "--out", "result"], QUIET.as_slice()].concat();
    let found = answer(&study(place.path(), &args), 0);
    assert_eq!(found["cases"].as_array().map(Vec::len), Some(1), "the twin is no case of its own");
    assert_eq!(found["cases"][0]["gates"][0]["passed"], true, "{found}");
    fs::write(&file, TWIN.replace("= 1263.3093633394378", "= 1264")).expect("the case can be written");
    assert_eq!(answer(&study(place.path(), &args), 7)["cases"][0]["gates"][0]["passed"], false);
}

#[test]
fn runs_side_by_side_give_the_same_results_and_say_that_their_times_are_not_their_own() {
    let place = tempfile::tempdir().expect("a scratch folder");
    let vary = ["oscillator", "--vary", "clock.link_scheme=serial,alternating", "--vary", "clock.window=-1,0.02,0.01"];
    let found = |more: &[&str]| {
        let out = ["--quiet", "--format", "json", "--out", more[0]];
        answer(&study(place.path(), &[&vary, out.as_slice(), &more[1..]].concat()), 0)["cases"][0].clone()
    };
    let alone = found(&["alone", "--runs", "1"]);
    let crowded = found(&["crowded", "--runs", "1", "--jobs", "3"]);
    let rows = |case: &Value| case["rows"].as_array().expect("there are runs").clone();
    assert_eq!(rows(&alone).len(), 6);
    for (one, other) in rows(&alone).iter().zip(&rows(&crowded)) {
        for key in ["settings", "outcome", "why", "error", "errors", "error_coupling", "state_hash", "substeps"] {
            assert_eq!(one[key], other[key], "{key}");
        }
    }
    let beside =
        |case: &Value| -> Vec<Value> { rows(case).iter().map(|r| r["cost"]["beside_others"].clone()).collect() };
    assert_eq!(beside(&alone)[1..3], [false, false]);
    assert_eq!(beside(&crowded)[1..3], [true, true]);
    assert!(crowded["notes"].to_string().contains("shared cores"), "{}", crowded["notes"]);
    // The second one of each is alone, and its time is the one that counts.
    let again = found(&["crowded", "--runs", "2", "--jobs", "3"]);
    assert!(rows(&again)[1]["cost"]["runs"] == 1 && beside(&again)[1] == false, "{again}");
    assert_eq!(rows(&again)[1]["cached"], 1);
}

#[test]
fn runs_that_cannot_be_made_are_results_and_mistakes_are_shown_at_once() {
    let place = tempfile::tempdir().expect("a scratch folder");
    let vary = ["oscillator", "--vary", "clock.window=-1,0.02,0.01", "--out", "result"];
    let answer = answer(&study(place.path(), &[&vary, QUIET.as_slice()].concat()), 0);
    let rows = answer["cases"][0]["rows"].as_array().expect("there are runs");
    assert_eq!(rows[0]["outcome"], "refused");
    assert!(rows[0]["why"].as_str().is_some_and(|why| why.contains("window")), "{}", rows[0]);
    assert!(rows[1]["error"].as_f64().is_some_and(|error| error > 0.0), "{}", rows[1]);
    // The finest run is the reference of a scene that has none.
    assert_eq!(rows[2]["error"], Value::Null);

    let broken = CASE.replace("probe = \"left.x\"", "prob = \"left.x\"").replace("cos(6*PI*t))\"", "cos(6*PI*t)\"");
    fs::write(place.path().join("broken.study.toml"), broken).expect("the case can be written");
    let output = study(place.path(), &["broken.study.toml"]);
    let talk = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{talk}");
    for part in ["broken.study.toml:8", "did you mean `probe`", "`)` is missing"] {
        assert!(talk.contains(part), "{part}\n{talk}");
    }
}

#[test]
fn a_sheet_has_a_picture_and_a_measured_impact_of_each_run() {
    let place = tempfile::tempdir().expect("a scratch folder");
    // The sheet of the program, cut to the softest body on a coarse lattice and to what the impact takes.
    let cut = ["--set", "clock.duration=0.16", "--set", "body.target.spacing=0.02", "--out", "result"];
    let rows = ["--rows", "body.target.material=lunch-bag", "--rows", "body.target.mesh.file=assets/lunch-bag.obj"];
    let args = [&["sheet", "impacts"], cut.as_slice(), &rows, &["--quiet", "--format", "json"]].concat();
    let answer = answer(&study(place.path(), &args), 0);
    let runs = answer["runs"].as_array().expect("there are runs");
    assert_eq!(runs.len(), 3, "one row of three strikers");
    for run in runs {
        let number = |key: &str| run["impact"][key].as_f64().unwrap_or(f64::NAN);
        // From 2.5 m/s and a fall of up to 0.25 m; the bag is 0.24 m tall and throws back less than it got.
        assert!((2.5..3.4).contains(&number("approach_m_s")), "{run}");
        assert!((0.002..0.24).contains(&number("dent_m")) && (0.0..1.0).contains(&number("rebound")), "{run}");
        assert!(run["substeps"].as_u64() > Some(100) && run["core_s"].as_f64() > Some(0.0), "{run}");
    }
    let file = |name: &str| fs::read(place.path().join("result").join(name)).expect("the sheet has its files");
    // Width and height of a PNG stand at bytes 16 and 20: three tiles of 320 pixels.
    assert_eq!(file("sheet.png")[16..20], 960_u32.to_be_bytes());
    assert_eq!(String::from_utf8_lossy(&file("sheet.csv")).lines().count(), 4);
    assert_eq!(String::from_utf8_lossy(&file("sheet.html")).matches("data:image/png").count(), 3);
}

#[test]
fn a_sheet_that_makes_no_sense_is_refused_at_once() {
    let place = tempfile::tempdir().expect("a scratch folder");
    let cases: [(&[&str], i32, &str); 4] = [
        (&["sheet", "oscillator"], 2, "--rows"),
        (&["sheet", "oscillator", "--rows", "clock.window=1,2", "--rows", "clock.fps=1"], 2, "`clock.fps` has 1"),
        (&["sheet", "oscillator", "--rows", "clock.windw=0.02,0.01"], 3, "did you mean `window`?"),
        (&["sheet", "none.sheet.toml"], 3, "NAME.sheet.toml"),
    ];
    for (args, code, says) in cases {
        let output = study(place.path(), args);
        let talk = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(code) && talk.contains(says), "{args:?}: {talk}");
    }
}

#[test]
fn ctrl_c_ends_a_study_and_its_run() {
    let place = tempfile::tempdir().expect("a scratch folder");
    let token = format!("study-{}", std::process::id());
    let mut command = Command::new(env!("CARGO_BIN_EXE_cosplat"));
    let args =
        ["study", "oscillator", "--vary", "clock.window=0.0001", "--vary", "clock.duration=1000,2000", "--quiet"];
    command.args(args).current_dir(place.path()).env("COSPLAT_E2E_TOKEN", &token).stdin(Stdio::null());
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("cosplat starts");
    let deadline = Instant::now() + Duration::from_secs(20);
    // The study, its run, and the two solvers of the run.
    while support::processes_with(&token).len() < 4 {
        assert!(Instant::now() < deadline, "the run never began");
        std::thread::sleep(Duration::from_millis(20));
    }
    support::send_signal("INT", child.id());
    let status = child.wait().expect("it can be waited for");
    assert_eq!(status.code(), Some(130));
    let deadline = Instant::now() + Duration::from_secs(3);
    while !support::processes_with(&token).is_empty() {
        assert!(Instant::now() < deadline, "something is left running");
        std::thread::sleep(Duration::from_millis(20));
    }
}
