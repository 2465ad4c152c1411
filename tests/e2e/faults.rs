//! A process dies, freezes, lies or never comes: the run says who, in seconds, and leaves nothing behind.
//!
//! Every run here ends in [`support::Running::finish`], which checks that no process of it is left.

mod support;

use std::time::Duration;

use support::{Oscillator, Program, Run};

/// Runs the oscillator with a misbehaving right side.
fn with_right(mode: &[&str], more: &str) -> Run {
    let scene = Oscillator { right: Oscillator::saboteur(mode), more, ..Oscillator::default() }.scene();
    Program::run(&scene, &[]).finish()
}

#[track_caller]
fn assert_says(run: &Run, words: &[&str]) {
    for word in words {
        assert!(run.stderr.contains(word), "`{word}` is missing in:\n{}", run.stderr);
    }
}

#[test]
fn a_killed_solver_is_named_with_its_signal_and_window() {
    let run = with_right(&["kill", "10"], "").expect_code(5);
    assert_says(&run, &["`right`", "window 10", "signal 9"]);
    assert!(run.took < Duration::from_secs(5), "{:?}", run.took);
    assert_eq!(run.summary["windows"], 10, "what was settled before stays readable");
}

#[test]
fn a_solver_that_exits_in_the_middle_is_named() {
    let run = with_right(&["exit", "10"], "").expect_code(5);
    assert_says(&run, &["`right`", "window 10", "exit code 0"]);
}

#[test]
fn a_solver_that_exits_at_once_is_named_with_its_last_words() {
    let run = with_right(&["exit-at-once"], "").expect_code(5);
    assert_says(&run, &["`right`", "exit code 3", "I would rather not"]);
    assert!(run.took < Duration::from_secs(5), "{:?}", run.took);
}

#[test]
fn a_panic_in_a_solver_is_a_physics_failure_with_its_words() {
    let run = with_right(&["panic", "10"], "").expect_code(4);
    assert_says(&run, &["`right`", "window 10", "told to panic"]);
}

#[test]
fn a_blow_up_is_a_physics_failure_with_its_words() {
    let run = with_right(&["physics", "10"], "").expect_code(4);
    assert_says(&run, &["`right`", "window 10", "left the known universe"]);
}

#[test]
fn a_number_that_is_not_finite_is_found_before_it_leaves() {
    let run = with_right(&["nan", "10"], "").expect_code(4);
    assert_says(&run, &["`right`", "window 10", "number 0 of `position` is not finite"]);
}

#[test]
fn a_frozen_solver_is_noticed_and_ends_the_run() {
    let run = with_right(&["freeze", "10"], "[run]\nsilence_limit = 3.0\n").expect_code(5);
    assert_says(&run, &["`right`", "silent", "window 10"]);
    assert!(run.took < Duration::from_secs(12), "{:?}", run.took);
}

/// Shorter than the limit, a freeze is an inconvenience: people are told, and the result is the same to the bit.
#[test]
fn a_pause_of_five_seconds_is_told_and_changes_nothing() {
    let run = with_right(&["pause", "10"], "").expect_code(0);
    assert_says(&run, &["`right`", "window 10"]);
    let calm = Program::run(&Oscillator::default().scene(), &["--quiet"]).finish().expect_code(0);
    assert_eq!(run.hash(), calm.hash());
}

/// A solver that computes for long without a beat is slow, not dead.
#[test]
fn a_slow_solver_is_waited_for_by_name() {
    let run = with_right(&["slow", "10"], "[run]\nsilence_limit = 3.0\n").expect_code(0);
    assert_says(&run, &["waiting for", "`right`"]);
}

#[test]
fn a_plugin_whose_descriptor_is_garbage_is_refused_with_what_it_said() {
    let run = with_right(&["garbage"], "");
    assert!(run.code == 6 || run.code == 5, "exit code {}:\n{}", run.code, run.stderr);
    assert_says(&run, &["saboteur", "%PDF"]);
}

#[test]
fn a_solver_of_another_protocol_version_is_refused() {
    let run = with_right(&["version"], "").expect_code(5);
    assert_says(&run, &["`right`", "protocol 9"]);
}

#[test]
fn a_second_process_under_the_same_name_is_refused_and_the_run_goes_on() {
    let run = with_right(&["twice"], "").expect_code(0);
    assert_says(&run, &["second process", "`right`"]);
}

#[test]
fn a_solver_that_never_says_hello_is_named() {
    let run = with_right(&["missing"], "[run]\njoin_limit = 3.0\n").expect_code(5);
    assert_says(&run, &["`right`", "never said hello"]);
    assert!(run.took < Duration::from_secs(10), "{:?}", run.took);
}

#[test]
fn solvers_leave_when_the_coordinator_is_killed() {
    let scene = Oscillator { duration: 1000.0, ..Oscillator::default() }.scene();
    let running = Program::run(&scene, &["--quiet"]).start();
    running.wait_for_lines("ledger.csv", 5);
    assert_eq!(running.children().len(), 2, "two solver processes");
    running.signal("KILL");
    let run = running.finish().expect_code(128 + 9);
    assert!(!run.ledger("window").is_empty(), "what was settled stays readable");
}

#[test]
fn an_interrupt_at_any_time_ends_at_a_window_edge_with_readable_files() {
    for pause_ms in [0, 30, 90, 170, 400, 700] {
        let scene = Oscillator { duration: 1000.0, ..Oscillator::default() }.scene();
        let running = Program::run(&scene, &["--quiet"]).start();
        std::thread::sleep(Duration::from_millis(pause_ms));
        running.signal("INT");
        let run = running.finish();
        // Before the program has installed its handler an interrupt ends it as it ends any program: 128 + 2 as well.
        assert_eq!(run.code, 130, "{pause_ms} ms: {}", run.stderr);
        assert!(run.took < Duration::from_millis(pause_ms + 4000), "{pause_ms} ms: {:?}", run.took);
        if run.summary.is_object() {
            let settled = run.summary["windows"].as_u64().expect("a count") as usize;
            assert_eq!(run.ledger("window").len(), settled, "the ledger ends where the run ended");
        }
    }
}

#[test]
fn a_second_interrupt_ends_at_once() {
    let scene = Oscillator { duration: 1000.0, right: Oscillator::saboteur(&["slow", "10"]), ..Oscillator::default() };
    let running = Program::run(&scene.scene(), &["--quiet"]).start();
    running.wait_for_lines("ledger.csv", 5);
    running.signal("INT");
    std::thread::sleep(Duration::from_millis(200));
    let before = std::time::Instant::now();
    running.signal("INT");
    running.finish().expect_code(130);
    assert!(before.elapsed() < Duration::from_secs(2), "{:?}", before.elapsed());
}

#[test]
fn nothing_listens_beyond_the_socket_of_the_run() {
    let scene = Oscillator { duration: 1000.0, ..Oscillator::default() }.scene();
    let running = Program::run(&scene, &["--quiet"]).start();
    running.wait_for_lines("ledger.csv", 5);
    let mut pids = running.children();
    pids.push(running.child.id());
    for pid in pids {
        let inodes: Vec<String> = std::fs::read_dir(format!("/proc/{pid}/fd"))
            .expect("the process is ours")
            .flatten()
            .filter_map(|fd| std::fs::read_link(fd.path()).ok()?.to_str().map(str::to_owned))
            .filter_map(|link| Some(link.strip_prefix("socket:[")?.strip_suffix(']')?.to_owned()))
            .collect();
        for table in ["tcp", "tcp6", "udp", "udp6"] {
            let text = std::fs::read_to_string(format!("/proc/net/{table}")).unwrap_or_default();
            let open = text
                .lines()
                .skip(1)
                .find(|l| l.split_whitespace().nth(9).is_some_and(|inode| inodes.iter().any(|own| own == inode)));
            assert_eq!(open, None, "process {pid} has a {table} socket");
        }
    }
    running.signal("INT");
    running.finish().expect_code(130);
}
