//! Does a run that was killed or stopped go on as if nothing had happened?
//!
//! Everything that does not hold wall time is compared byte by byte with a run that nobody disturbed.

mod support;

use cosplat_core::control::PROTOCOL;
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use support::{Oscillator, Program, Run, Running, send_signal};

/// Windows from one checkpoint to the next: `--checkpoint-every 0.5` of windows of 0.01 s.
const EVERY: [&str; 2] = ["--checkpoint-every", "0.5"];

/// A run long enough to be disturbed: 1000 windows with a side that dawdles up to 2 ms in each.
fn oscillator() -> String {
    let right = Oscillator::saboteur(&["jitter"]);
    Oscillator { duration: 10.0, right, more: "[output]\nreport = false\n", ..Oscillator::default() }.scene()
}

/// The same run, undisturbed and without checkpoints.
fn calm() -> Run {
    let run = Program::run(&oscillator(), &["--quiet"]).finish().expect_code(0);
    assert!(!run.folder.join("checkpoints").exists(), "a run that does not ask keeps nothing");
    run
}

/// Waits until the run has a checkpoint of that window or a later one; `None` if it ends first.
fn wait_for_checkpoint(running: &mut Running, window: u64) -> Option<()> {
    let is_there = |running: &Running| {
        let entries = fs::read_dir(running.folder().join("checkpoints")).into_iter().flatten().flatten();
        let names = entries.filter_map(|entry| entry.file_name().into_string().ok());
        let mut windows = names.filter_map(|name| name.strip_suffix(".checkpoint")?.parse::<u64>().ok());
        windows.any(|found| found >= window)
    };
    let deadline = Instant::now() + Duration::from_mins(2);
    while !is_there(running) {
        if running.child.try_wait().expect("a child").is_some() {
            return None;
        }
        assert!(Instant::now() < deadline, "there never was a checkpoint of window {window}");
        std::thread::sleep(Duration::from_millis(5));
    }
    Some(())
}

/// A run that is disturbed when it has a checkpoint of that window; `None` if it ends first.
fn disturbed(program: Program, window: u64, disturb: impl FnOnce(&Running)) -> Option<Run> {
    let mut running = program.start();
    let found = wait_for_checkpoint(&mut running, window);
    if found.is_some() {
        disturb(&running);
    }
    let run = running.finish();
    // It may have ended right before it was disturbed.
    found.filter(|()| run.code != 0).map(|()| run)
}

/// Tries again where a run ended before it could be disturbed: these last a second, and a busy disk may take longer than that
/// to store a checkpoint, which no run waits for.
fn tried(test: impl Fn() -> Option<()>) {
    assert!((0..10).any(|_| test().is_some()), "ten runs ended before their checkpoints were stored");
}

fn begun() -> Program {
    Program::run(&oscillator(), &[&["--quiet"], &EVERY[..]].concat())
}

#[track_caller]
fn assert_same(found: &Run, wanted: &Run, files: &[&str]) {
    assert_eq!(found.hash(), wanted.hash());
    for file in files {
        let read = |run: &Run| fs::read(run.folder.join(file)).unwrap_or_else(|e| panic!("{file}: {e}"));
        assert!(read(found) == read(wanted), "`{file}` differs from that of an undisturbed run");
    }
}

const TABLES: [&str; 2] = ["ledger.csv", "probes.csv"];

#[test]
fn after_the_program_was_killed() {
    tried(|| {
        let run = disturbed(begun(), 200, |running| running.signal("KILL"))?.expect_code(128 + 9);
        assert!(run.summary.is_null(), "nobody was left to write it");
        let run = run.resume(&["--quiet"]).finish().expect_code(0);
        assert_same(&run, &calm(), &TABLES);
        assert_eq!(run.summary["windows"], 1000);
        let trace = fs::read_to_string(run.folder.join("trace.json")).expect("a trace");
        let events: serde_json::Value = serde_json::from_str(&trace).expect("JSON");
        let computed = events.as_array().expect("a list").iter().filter(|e| e["name"] == "compute" && e["pid"] == 1);
        let windows: Vec<u64> = computed.filter_map(|e| e["args"]["window"].as_u64()).collect();
        assert_eq!(windows, (0..1000).collect::<Vec<_>>(), "each window is in the trace once");
        Some(())
    });
}

#[test]
fn after_a_solver_was_killed() {
    tried(|| {
        let kill = |running: &Running| running.children().into_iter().take(1).for_each(|pid| send_signal("KILL", pid));
        let program = Program::run(&oscillator(), &EVERY);
        let run = disturbed(program, 200, kill)?.expect_code(5);
        assert!(run.stderr.contains("cosplat run --resume"), "what to do is said: {}", run.stderr);
        let run = run.resume(&["--quiet", "--threads", "1"]).finish().expect_code(0);
        assert_same(&run, &calm(), &TABLES);
        Some(())
    });
}

#[test]
fn after_it_was_stopped_twice() {
    tried(|| {
        let run = disturbed(begun(), 100, |running| running.signal("INT"))?.expect_code(130);
        let first = run.summary["windows"].as_u64().expect("a count");
        let again = run.resume(&["--quiet", "--checkpoint-every", "0.3"]);
        let run = disturbed(again, first + 100, |running| running.signal("INT"))?.expect_code(130);
        assert!(run.summary["windows"].as_u64() > Some(first + 100), "it goes on from where it was: {}", run.summary);
        let run = run.resume(&["--quiet"]).finish().expect_code(0);
        assert_same(&run, &calm(), &TABLES);
        Some(())
    });
}

/// Names of all files in a folder.
fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut names: Vec<String> = entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into()).collect();
    names.sort();
    names
}

/// Every picture, every splat file, and the animation that was gathered from the pictures of both lives.
#[track_caller]
fn same_frames_after_a_kill(scene: &str, args: &[&str], window: u64) {
    let calm = Program::built_in(scene, args).finish().expect_code(0);
    tried(|| {
        let begun = Program::built_in(scene, &[args, &["--checkpoint-every", "0.02"]].concat());
        let run = disturbed(begun, window, |running| running.signal("KILL"))?.expect_code(128 + 9);
        let run = run.resume(&["--quiet"]).finish().expect_code(0);
        let mut files = vec!["preview.png".to_owned()];
        for folder in ["frames", "splats"] {
            let there = names(&calm.folder.join(folder));
            assert_eq!(names(&run.folder.join(folder)), there);
            files.extend(there.iter().map(|name| format!("{folder}/{name}")));
        }
        let files: Vec<&str> = files.iter().map(String::as_str).chain(TABLES).collect();
        assert_same(&run, &calm, &files);
        assert_eq!(run.summary["frames"]["taken"], calm.summary["frames"]["taken"]);
        assert!(run.folder.join("run.rrd").exists() && run.folder.join("run-2.rrd").exists());
        Some(())
    });
}

#[test]
fn pictures_of_both_lives_are_those_of_an_undisturbed_run() {
    let quick = ["--quiet", "--set", "body.block.spacing=0.05", "--set", "clock.duration=0.3", "--set", "clock.fps=20"];
    same_frames_after_a_kill("ball-on-block", &quick, 100);
}

/// Gaussians of a capture are moved from where they stood in the first frame, which was drawn in the first life.
#[test]
fn a_capture_goes_on_from_where_it_first_stood() {
    let coarse = ["--quiet", "--set", "body.plant.spacing=0.015", "--set", "clock.duration=0.15"];
    same_frames_after_a_kill("plant-and-rock", &coarse, 20);
}

#[track_caller]
fn refused(run: Run, words: &[&str]) -> Run {
    let run = run.resume(&[]).finish().expect_code(3);
    for word in words {
        assert!(run.stderr.contains(word), "`{word}` is missing in:\n{}", run.stderr);
    }
    run
}

fn change(run: &Run, file: &str, from: &str, to: &str) {
    let path = run.folder.join(file);
    let text = fs::read_to_string(&path).expect("the run wrote it");
    assert!(text.contains(from), "`{from}` is not in `{file}`:\n{text}");
    fs::write(&path, text.replace(from, to)).expect("it can be written");
}

#[test]
fn what_cannot_be_resumed_is_refused_by_name() {
    let short = Oscillator { duration: 0.2, ..Oscillator::default() }.scene();
    let none = Program::run(&short, &["--quiet"]).finish().expect_code(0);
    refused(none, &["no complete checkpoint"]);

    tried(|| {
        let run = disturbed(begun(), 100, |running| running.signal("INT"))?.expect_code(130);
        let ours = format!("protocol = {PROTOCOL}");
        change(&run, "run.toml", &ours, "protocol = 1");
        let run = refused(run, &["cannot be resumed", "protocol is 1"]);
        change(&run, "run.toml", "protocol = 1", &ours);
        change(&run, "run.toml", "duration = 10.0", "duration = 12.0");
        let run = refused(run, &["not of this run", "another scene or plan"]);
        change(&run, "run.toml", "duration = 12.0", "duration = 10.0");
        let about = fs::read_to_string(run.folder.join("checkpoints/about.json")).expect("it is there");
        let hash = about.lines().find_map(|l| l.split_once("saboteur\": \"")).expect("the program is listed").1;
        change(&run, "checkpoints/about.json", &hash[..16], "0123456789abcdef");
        let run = refused(run, &["another program", "saboteur"]);
        change(&run, "checkpoints/about.json", "0123456789abcdef", &hash[..16]);
        run.resume(&["--quiet"]).finish().expect_code(0);
        Some(())
    });
}

#[test]
fn a_folder_that_is_written_to_is_not_taken_over() {
    tried(|| {
        let mut running = begun().start();
        wait_for_checkpoint(&mut running, 50)?;
        let folder = running.folder().to_owned();
        let output =
            std::process::Command::new(env!("CARGO_BIN_EXE_cosplat")).args(["run", "--resume"]).arg(&folder).output();
        let output = output.expect("cosplat starts");
        assert_eq!(output.status.code(), Some(3));
        assert!(String::from_utf8_lossy(&output.stderr).contains("Another run is writing"), "{output:?}");
        running.signal("INT");
        running.finish().expect_code(130);
        Some(())
    });
}
