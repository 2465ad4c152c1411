//! A run is watched with the programs that users have, where they are installed: rerun, and Chromium.

mod support;

use std::io::{BufRead as _, BufReader};
use std::net::{TcpListener, TcpStream};
use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use support::Program;

const FRAMES: [&str; 6] = ["--set", "clock.fps=50", "--set", "output.pictures=false", "--set", "output.splats=false"];

/// Pictures that Chromium may take until one shows the run.
const ATTEMPTS: usize = 6;

/// Whether programs are there; says so where one is not.
fn are_there(programs: &[&str]) -> bool {
    let is_there = |name: &&&str| {
        let asked = Command::new(name).arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
        asked.is_ok_and(|status| status.success())
    };
    let missing: Vec<_> = programs.iter().filter(|name| !is_there(name)).collect();
    if !missing.is_empty() {
        eprintln!("skipped: {missing:?} cannot be run here");
    }
    missing.is_empty()
}

/// A program with all it starts; ended with its owner.
struct Group(Child);

impl Group {
    fn start(command: &mut Command) -> Self {
        let quiet = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        Self(quiet.process_group(0).spawn().expect("it starts"))
    }

    /// Waits for its end, or gives up.
    fn wait(&mut self, longest: Duration) {
        let began = Instant::now();
        while began.elapsed() < longest && self.0.try_wait().is_ok_and(|status| status.is_none()) {
            std::thread::sleep(Duration::from_millis(50));
        }
    }
}

impl Drop for Group {
    fn drop(&mut self) {
        let _ = Command::new("kill").args(["-KILL", "--", &format!("-{}", self.0.id())]).stderr(Stdio::null()).status();
        let _ = self.0.wait();
    }
}

/// Waits until somebody listens.
fn wait_for(address: &str) {
    let began = Instant::now();
    while TcpStream::connect(address).is_err() {
        assert!(began.elapsed() < Duration::from_secs(20), "nobody listens at {address}");
        std::thread::sleep(Duration::from_millis(50));
    }
}

#[test]
fn rerun_takes_what_is_sent() {
    if !are_there(&["rerun"]) {
        return;
    }
    let port = TcpListener::bind("127.0.0.1:0").expect("a port").local_addr().expect("it has one").port();
    let place = tempfile::tempdir().expect("a scratch folder");
    let file = place.path().join("seen.rrd");
    let mut viewer = Command::new("rerun");
    viewer.args(["--bind", "127.0.0.1", "--port", &port.to_string(), "--save"]).arg(&file);
    let viewer = Group::start(&mut viewer);
    wait_for(&format!("127.0.0.1:{port}"));
    let live = format!("--live={port}");
    let args: Vec<&str> = FRAMES.iter().chain(&[live.as_str()]).copied().collect();
    Program::built_in("ball-on-block", &args).finish().expect_code(0);
    // What it has taken is written a moment later.
    std::thread::sleep(Duration::from_secs(1));
    drop(viewer);
    let said = Command::new("rerun").args(["rrd", "stats", "--continue-on-error"]).arg(&file).output();
    let said = String::from_utf8_lossy(&said.expect("rerun reads it").stdout).into_owned();
    assert!(said.contains("num_chunks") && std::fs::metadata(&file).is_ok_and(|f| f.len() > 100_000), "{said}");
}

#[test]
fn a_browser_shows_a_run_that_goes_on() {
    if !are_there(&["rerun", "chromium"]) {
        return;
    }
    let args: Vec<&str> = FRAMES.iter().chain(&["--serve", "--set", "clock.duration=30"]).copied().collect();
    let mut run = Program::built_in("ball-on-block", &args).start();
    let lines = BufReader::new(run.child.stderr.take().expect("it is a pipe")).lines().map_while(Result::ok);
    let mut lines = lines.skip_while(|line| !line.contains("http://"));
    let line = lines.next().expect("the address is said");
    let url = line.split_whitespace().find(|word| word.starts_with("http://")).expect("an address").to_owned();
    wait_for(url.split('/').nth(2).expect("a host and a port"));
    // The pipe must not fill.
    let rest = std::thread::spawn(move || lines.for_each(drop));
    let place = tempfile::tempdir().expect("a scratch folder");
    let picture = place.path().join("seen.png");
    // Its clock in this mode runs ahead of what it loads, so that it may take its picture before there is anything.
    let attempt = |_| {
        let mut chromium = Command::new("chromium");
        chromium.args(["--headless", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader"]);
        chromium.args(["--enable-unsafe-swiftshader", "--window-size=1280,720", "--virtual-time-budget=20000"]);
        chromium.arg(format!("--user-data-dir={}", place.path().join("profile").display()));
        chromium.arg(format!("--screenshot={}", picture.display())).arg(format!("{url}&renderer=webgl"));
        Group::start(&mut chromium).wait(Duration::from_mins(1));
        warm(&picture)
    };
    let is_seen = |&(coloured, all): &(usize, usize)| coloured * 200 > all;
    let seen = (0..ATTEMPTS).map(attempt).find(is_seen);
    run.signal("TERM");
    run.finish().expect_code(130);
    rest.join().expect("its words end with it");
    assert!(seen.is_some(), "the colours of the bodies are in none of {ATTEMPTS} pictures");
}

/// Pixels that are more red than blue, as bodies of the colour of earth and boundary particles are and the viewer's own
/// things are not.
fn warm(picture: &Path) -> (usize, usize) {
    let (width, height, rgb) = cosplat_viewer::png::read(picture).expect("a picture");
    let is_warm = |p: &[f32]| p[0] > p[2] + 0.04;
    (rgb.chunks_exact(3).filter(|p| is_warm(p)).count(), width * height)
}
