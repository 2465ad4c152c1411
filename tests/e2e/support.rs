//! Running the real program on real scenes.
#![allow(dead_code, reason = "each test binary uses its own part")]

use std::ffi::OsStr;
use std::fmt::Write as _;
use std::os::unix::process::ExitStatusExt as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

/// A scratch folder with a scene, and what a run left behind.
pub(crate) struct Run {
    /// Exit code; 128 + signal for a death by signal.
    pub(crate) code: i32,
    /// Standard output.
    pub(crate) stdout: String,
    /// Standard error.
    pub(crate) stderr: String,
    /// `summary.json`, null if there is none.
    pub(crate) summary: Value,
    /// Run folder.
    pub(crate) folder: PathBuf,
    /// How long it took.
    pub(crate) took: Duration,
    scratch: tempfile::TempDir,
}

impl Run {
    /// Asserts the exit code and shows what was said if it differs.
    #[track_caller]
    pub(crate) fn expect_code(self, code: i32) -> Self {
        assert_eq!(self.code, code, "stderr:\n{}\nstdout:\n{}", self.stderr, self.stdout);
        self
    }

    /// Chain of all states.
    #[track_caller]
    pub(crate) fn hash(&self) -> String {
        self.summary["state_hash"].as_str().expect("a run that settled windows has a hash").to_owned()
    }

    /// Goes on with the run, in the same folder.
    pub(crate) fn resume(self, args: &[&str]) -> Program {
        let command = Command::new(env!("CARGO_BIN_EXE_cosplat"));
        let mut program = Program { scratch: self.scratch, token: token(), command, folder: self.folder };
        program.command.args(["run", "--resume"]).arg(&program.folder).args(args);
        program.piped()
    }

    /// A column of the ledger, as text.
    pub(crate) fn ledger(&self, column: &str) -> Vec<String> {
        let text = std::fs::read_to_string(self.folder.join("ledger.csv")).expect("the run wrote it");
        let mut lines = text.lines().map(|l| l.split(',').map(str::to_owned).collect::<Vec<_>>());
        let header = lines.next().unwrap_or_default();
        let place = |name: &str| header.iter().position(|h| h == name).unwrap_or_else(|| panic!("no `{name}`"));
        let wanted = place(column);
        lines.filter_map(|l| l.get(wanted).cloned()).collect()
    }

    /// A CSV file of the run folder: header and rows of numbers (text that is no number becomes NaN).
    pub(crate) fn csv(&self, name: &str) -> (Vec<String>, Vec<Vec<f64>>) {
        let text = std::fs::read_to_string(self.folder.join(name)).expect("the run wrote it");
        let mut lines = text.lines();
        let header = lines.next().unwrap_or_default().split(',').map(str::to_owned).collect();
        let number = |cell: &str| cell.parse().unwrap_or(f64::NAN);
        (header, lines.map(|l| l.split(',').map(number).collect()).collect())
    }
}

/// The program with a scene in a scratch folder; not started yet.
pub(crate) struct Program {
    scratch: tempfile::TempDir,
    token: String,
    command: Command,
    folder: PathBuf,
}

impl Program {
    /// `cosplat run` on the text of a scene.
    pub(crate) fn run(scene: &str, args: &[&str]) -> Self {
        let scratch = tempfile::tempdir().expect("a scratch folder");
        let file = scratch.path().join("scene.toml");
        std::fs::write(&file, scene).expect("the scene can be written");
        Self::of(scratch, file.as_os_str(), args)
    }

    /// `cosplat run` on a scene inside the program.
    pub(crate) fn built_in(name: &str, args: &[&str]) -> Self {
        Self::of(tempfile::tempdir().expect("a scratch folder"), name.as_ref(), args)
    }

    fn of(scratch: tempfile::TempDir, scene: &OsStr, args: &[&str]) -> Self {
        let folder = scratch.path().join("out");
        let mut command = Command::new(env!("CARGO_BIN_EXE_cosplat"));
        command.arg("run").arg(scene).arg("--out").arg(&folder).args(args);
        Self { scratch, token: token(), command, folder }.piped()
    }

    fn piped(mut self) -> Self {
        self.command.env("COSPLAT_E2E_TOKEN", &self.token).stdin(Stdio::null());
        self.command.stdout(Stdio::piped()).stderr(Stdio::piped());
        self
    }

    /// Starts it.
    pub(crate) fn start(mut self) -> Running {
        let child = self.command.spawn().expect("cosplat starts");
        Running { child, program: self, began: Instant::now() }
    }

    /// Starts it, waits for its end, and checks that nothing of it is left running.
    pub(crate) fn finish(self) -> Run {
        self.start().finish()
    }
}

/// What the processes of one run are known by.
fn token() -> String {
    format!("e2e-{}-{:?}", std::process::id(), Instant::now())
}

/// A program that runs.
pub(crate) struct Running {
    /// The process.
    pub(crate) child: Child,
    program: Program,
    began: Instant,
}

impl Running {
    /// Sends a signal by name.
    pub(crate) fn signal(&self, name: &str) {
        send_signal(name, self.child.id());
    }

    /// Run folder.
    pub(crate) fn folder(&self) -> &Path {
        &self.program.folder
    }

    /// Processes of this run, the program itself apart.
    pub(crate) fn children(&self) -> Vec<u32> {
        processes_with(&self.program.token).into_iter().filter(|&p| p != self.child.id()).collect()
    }

    /// Waits until a file of the run folder has that many lines.
    pub(crate) fn wait_for_lines(&self, name: &str, lines: usize) {
        let file = self.folder().join(name);
        let deadline = Instant::now() + Duration::from_secs(15);
        while std::fs::read_to_string(&file).map_or(0, |t| t.lines().count()) < lines {
            assert!(Instant::now() < deadline, "`{name}` never had {lines} lines");
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Waits for its end, and checks that nothing of it is left running.
    pub(crate) fn finish(self) -> Run {
        let Self { child, program, began } = self;
        let output = child.wait_with_output().expect("cosplat can be waited for");
        let took = began.elapsed();
        let deadline = Instant::now() + Duration::from_secs(3);
        while !processes_with(&program.token).is_empty() {
            let left = processes_with(&program.token);
            assert!(Instant::now() < deadline, "still running after the end: {left:?}");
            std::thread::sleep(Duration::from_millis(20));
        }
        let summary = std::fs::read_to_string(program.folder.join("summary.json"));
        Run {
            code: output.status.code().unwrap_or_else(|| 128 + output.status.signal().unwrap_or(0)),
            stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
            stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
            summary: summary.ok().and_then(|t| serde_json::from_str(&t).ok()).unwrap_or(Value::Null),
            folder: program.folder,
            took,
            scratch: program.scratch,
        }
    }
}

/// Sends a signal by name to a process.
pub(crate) fn send_signal(name: &str, pid: u32) {
    let _ = Command::new("kill").args([format!("-{name}"), pid.to_string()]).status();
}

/// Processes that carry the token in their environment, zombies apart.
pub(crate) fn processes_with(token: &str) -> Vec<u32> {
    let Ok(entries) = std::fs::read_dir("/proc") else { return Vec::new() };
    entries
        .flatten()
        .filter_map(|e| e.file_name().to_str()?.parse::<u32>().ok())
        .filter(|pid| {
            let environment = std::fs::read(format!("/proc/{pid}/environ")).unwrap_or_default();
            String::from_utf8_lossy(&environment).contains(token)
        })
        .collect()
}

/// The executable of an example of this package.
pub(crate) fn example(name: &str) -> String {
    let cosplat = Path::new(env!("CARGO_BIN_EXE_cosplat"));
    let path = cosplat.with_file_name("examples").join(name);
    assert!(path.exists(), "`{}` is not there: `cargo test` builds examples", path.display());
    path.display().to_string()
}

/// The partitioned oscillator: two masses on springs to the world, joined by a third spring that is cut.
pub(crate) struct Oscillator<'a> {
    /// Longest window \[s\].
    pub(crate) window: f64,
    /// Simulated time \[s\].
    pub(crate) duration: f64,
    /// Link scheme.
    pub(crate) scheme: &'a str,
    /// Command of the left solver; empty for the built-in one.
    pub(crate) left: Vec<String>,
    /// Command of the right solver.
    pub(crate) right: Vec<String>,
    /// Start of the left mass \[m\].
    pub(crate) start: f64,
    /// More lines of TOML at the end.
    pub(crate) more: &'a str,
}

impl Default for Oscillator<'_> {
    fn default() -> Self {
        let (left, right) = (Vec::new(), Vec::new());
        Self { window: 0.01, duration: 1.0, scheme: "alternating", left, right, start: 1.0, more: "" }
    }
}

/// Spring to the world `4π²` and between the masses `16π²` \[N/m\].
pub(crate) const GROUND: f64 = 4.0 * std::f64::consts::PI * std::f64::consts::PI;

impl Oscillator<'_> {
    /// The scene.
    pub(crate) fn scene(&self) -> String {
        let mut text = format!(
            "format = 1\nname = \"oscillator\"\ntitle = \"Two masses, three springs\"\n[clock]\nduration = {:?}\n\
             window = {:?}\nlink_scheme = \"{}\"\n",
            self.duration, self.window, self.scheme
        );
        for (name, command) in [("left", &self.left), ("right", &self.right)] {
            let plugin = if command.is_empty() { "oscillator" } else { "saboteur" };
            let _ = writeln!(text, "[solver.{name}]\nplugin = \"{plugin}\"");
            if !command.is_empty() {
                let _ = writeln!(text, "command = {command:?}");
            }
        }
        for (name, x) in [("left", self.start), ("right", 0.0)] {
            let _ = write!(
                text,
                "[[body]]\nname = \"mass-{name}\"\nsolver = \"{name}\"\nmaterial = \"point-mass\"\nmass = 1.0\n\
                 points = [[{x:?}, 0.0, 0.0]]\n[[link]]\nname = \"ground-{name}\"\na = \"mass-{name}\"\n\
                 anchor = [0.0, 0.0, 0.0]\nstiffness = {GROUND:?}\n[[probe]]\nname = \"{name}\"\n\
                 quantity = \"position\"\nbody = \"mass-{name}\"\n"
            );
        }
        let _ = write!(
            text,
            "[[link]]\nname = \"middle\"\na = \"mass-left\"\nb = \"mass-right\"\nstiffness = {:?}\n\
             first = \"mass-left\"\n{}",
            4.0 * GROUND,
            self.more
        );
        text
    }

    /// A command line of the misbehaving plugin.
    pub(crate) fn saboteur(mode: &[&str]) -> Vec<String> {
        let mut command = vec![example("saboteur")];
        command.extend(mode.iter().map(|&m| m.to_owned()));
        command
    }
}
