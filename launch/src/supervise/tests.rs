use std::fs;
use std::path::Path;
use std::time::Duration;

use super::*;

fn shell(script: &str) -> Command {
    command(&["/bin/sh", "-c", script].map(OsString::from), 1)
}

fn runtime() -> tokio::runtime::Runtime {
    tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap()
}

/// Spawns a shell and waits for its end.
fn ended(script: &str, folder: &Path) -> (Child, Exit) {
    let (post, mut exits) = unbounded_channel();
    let child = Child::spawn(7, shell(script), "ticket\n", &folder.join("log.txt"), post).unwrap();
    let exit = runtime().block_on(async { tokio::time::timeout(Duration::from_secs(5), exits.recv()).await });
    (child, exit.unwrap().unwrap())
}

fn is_gone(pid: &str) -> bool {
    fs::read_to_string(format!("/proc/{}/stat", pid.trim())).map_or(true, |s| s.contains(") Z "))
}

/// Waits at most two seconds for something that another process brings about.
fn soon(mut is_so: impl FnMut() -> bool) -> bool {
    (0..200).any(|_| {
        std::thread::sleep(Duration::from_millis(10));
        is_so()
    })
}

#[test]
fn the_ticket_arrives_and_the_end_is_told_with_its_words() {
    let place = tempfile::tempdir().unwrap();
    let (child, exit) = ended("read line; echo got $line >&2; exit 3", place.path());
    assert_eq!((exit.index, exit.how.as_str()), (7, "exit code 3"));
    assert_eq!(child.tail.last(), ["got ticket"]);
    assert_eq!(fs::read_to_string(place.path().join("log.txt")).unwrap(), "got ticket\n");
    assert!(!child.is_running());
}

#[test]
fn a_signal_has_its_name() {
    let place = tempfile::tempdir().unwrap();
    assert_eq!(ended("kill -9 $$", place.path()).1.how, "signal 9 (SIGKILL)");
    assert_eq!(ended("kill -SEGV $$", place.path()).1.how, "signal 11 (SIGSEGV)");
}

#[test]
fn what_a_process_leaves_behind_is_ended_with_it() {
    let place = tempfile::tempdir().unwrap();
    let script = format!("sleep 1000 & echo $! > {}/pid", place.path().display());
    let (_child, exit) = ended(&script, place.path());
    assert_eq!(exit.how, "exit code 0");
    let pid = fs::read_to_string(place.path().join("pid")).unwrap();
    assert!(soon(|| is_gone(&pid)));
}

#[test]
fn a_dropped_child_is_ended_with_its_children() {
    let place = tempfile::tempdir().unwrap();
    let (post, _exits) = unbounded_channel();
    let script = format!("trap '' TERM; sleep 1000 & echo $! > {}/pid; wait", place.path().display());
    let child = Child::spawn(0, shell(&script), "", &place.path().join("log.txt"), post).unwrap();
    let pid_file = place.path().join("pid");
    assert!(soon(|| fs::read_to_string(&pid_file).is_ok_and(|p| p.ends_with('\n'))));
    let (shell_pid, pid) = (child.pid().to_string(), fs::read_to_string(&pid_file).unwrap());
    drop(child);
    assert!(soon(|| is_gone(&shell_pid) && is_gone(&pid)));
}

#[test]
fn the_life_line_stays_open_until_the_process_is_asked_to_end() {
    let place = tempfile::tempdir().unwrap();
    let (post, mut exits) = unbounded_channel();
    let script = "trap '' TERM; cat > /dev/null; echo 'the line is cut' >&2";
    let mut child = Child::spawn(0, shell(script), "ticket\n", &place.path().join("log.txt"), post).unwrap();
    std::thread::sleep(Duration::from_millis(200));
    assert!(child.is_running());
    child.terminate();
    // The shell ignores the request, but its `cat` does not, and would end by itself as well.
    runtime().block_on(async { tokio::time::timeout(Duration::from_secs(5), exits.recv()).await }).unwrap().unwrap();
    assert_eq!(child.tail.last(), ["the line is cut"]);
}

#[cfg(target_os = "linux")]
#[test]
fn processor_time_of_a_short_process_is_seen_at_its_end() {
    let place = tempfile::tempdir().unwrap();
    let (child, _) = ended("i=0; while [ $i -lt 200000 ]; do i=$((i+1)); done", place.path());
    assert!(child.usage().cpu_s.is_some_and(|s| s >= 0.02), "{:?}", child.usage());
}
