//! Does a million windows lose energy or memory?
//!
//! Two real processes of the solver `oscillator`, which is exact between windows, joined by a spring over the real bus in
//! the alternating scheme, which keeps the total energy but for rounding. The rounded coefficients of a window's rotation
//! are off by up to ε = 1.1e-16 for ever the same way: at most n ε in n windows, 1e-10 in a million. A leak of one byte a
//! window and process is a megabyte here.
//!
//! Floor: a window is one round trip of two hops, as in `coupling_window`; solving takes below a microsecond.
//!
//! `cargo bench --bench long_run` for 10⁶ windows, `cargo bench --bench long_run -- 100000` for as many as are named.

use std::path::{Path, PathBuf};
use std::process::{Child, Command};
use std::time::{Duration, Instant};

/// Length of a window \[s\].
const WINDOW_S: f64 = 0.01;
/// Rows of the ledger, whatever the length.
const ROWS: u64 = 1000;

fn main() {
    // `cargo test` starts benchmarks with this flag to see that they still work; timing is not asked for then.
    if std::env::args().any(|a| a == "--test") {
        return;
    }
    let windows = std::env::args().find_map(|a| a.parse().ok()).unwrap_or(1_000_000_u64).max(ROWS);
    let scratch = tempfile::tempdir().expect("a scratch folder");
    let out = scratch.path().join("out");
    let begun = Instant::now();
    let mut run = start(scratch.path(), &out, windows);
    let early = wait_for_rows(&mut run, &out, ROWS / 10);
    let late = wait_for_rows(&mut run, &out, ROWS * 9 / 10);
    assert!(run.wait().is_ok_and(|s| s.success()), "the run ended well");
    let taken = begun.elapsed().as_secs_f64();
    println!("{windows} windows in {taken:.1} s: {:.1} us a window", taken * 1e6 / windows as f64);
    for ((name, early), (_, late)) in early.iter().zip(&late) {
        let per_window = 1024.0 * (*late as f64 - *early as f64) / (0.8 * windows as f64);
        println!("{name:>12}: resident {early} KiB after a tenth, {late} KiB after nine: {per_window:+.3} B a window");
    }
    let energy = energies(&out);
    let swing = |part: &[f64]| {
        let mean = part.iter().sum::<f64>() / part.len() as f64;
        (mean, part.iter().map(|e| (e - mean).abs()).fold(0.0, f64::max))
    };
    let ((first, around), (last, _)) = (swing(&energy[..energy.len() / 10]), swing(&energy[energy.len() * 9 / 10..]));
    println!(
        "total energy: {first:.12} J in the first tenth (swings by {:.1e}), drift to the last tenth {:+.1e}",
        around / first,
        (last - first) / first
    );
}

fn start(folder: &Path, out: &Path, windows: u64) -> Child {
    let mass = |name: &str, x: f64| {
        format!(
            "[solver.{name}]\nplugin = \"oscillator\"\n[[body]]\nname = \"{name}\"\nsolver = \"{name}\"\n\
             material = \"point-mass\"\nmass = 1.0\npoints = [[0, 0, 0]]\nposition = [{x:?}, 0.0, 0.0]\n\
             [[link]]\nname = \"{name}-wall\"\na = \"{name}\"\nanchor = [0.0, 0.0, 0.0]\nstiffness = 39.47841760435743\n"
        )
    };
    let scene = format!(
        "format = 1\nname = \"long-run\"\ntitle = \"Two masses for long\"\n[clock]\nduration = {:?}\nwindow = {WINDOW_S:?}\n\
         link_scheme = \"alternating\"\n[output]\nledger_every = {}\n{}{}[[link]]\nname = \"between\"\na = \"left\"\nb = \"right\"\n\
         stiffness = 157.91367041742973\n",
        windows as f64 * WINDOW_S,
        windows / ROWS,
        mass("left", 1.0),
        mass("right", 0.0),
    );
    let file = folder.join("scene.toml");
    std::fs::write(&file, scene).expect("the scene can be written");
    let cosplat = env!("CARGO_BIN_EXE_cosplat");
    let run = Command::new(cosplat).arg("run").arg(&file).arg("--quiet").arg("--out").arg(out).spawn();
    run.expect("the program starts")
}

/// Waits until the ledger has as many rows; resident memory then \[KiB\] of the program and of its children.
fn wait_for_rows(run: &mut Child, out: &Path, rows: u64) -> Vec<(String, u64)> {
    let ledger = out.join("ledger.csv");
    let is_there = || std::fs::read_to_string(&ledger).is_ok_and(|text| text.lines().count() as u64 > rows);
    while !is_there() {
        assert!(run.try_wait().is_ok_and(|status| status.is_none()), "the run ended before row {rows}");
        std::thread::sleep(Duration::from_millis(100));
    }
    let program = run.id();
    let mut found: Vec<(String, u64)> =
        processes().into_iter().filter_map(|folder| holdings(&folder, program)).collect();
    found.sort();
    found
}

fn processes() -> Vec<PathBuf> {
    std::fs::read_dir("/proc").into_iter().flatten().flatten().map(|entry| entry.path()).collect()
}

/// Name and resident memory \[KiB\] of a process, if it is `program` or a child of it.
fn holdings(folder: &Path, program: u32) -> Option<(String, u64)> {
    let status = std::fs::read_to_string(folder.join("status")).ok()?;
    let field = |name: &str| status.lines().find_map(|l| l.strip_prefix(name))?.split_whitespace().next();
    let (pid, parent): (u32, u32) = (field("Pid:")?.parse().ok()?, field("PPid:")?.parse().ok()?);
    let name = if pid == program { "program".to_owned() } else { format!("solver {pid}") };
    (pid == program || parent == program).then_some((name, field("VmRSS:")?.parse().ok()?))
}

fn energies(out: &Path) -> Vec<f64> {
    let text = std::fs::read_to_string(out.join("ledger.csv")).expect("the run wrote a ledger");
    let mut rows = text.lines().map(|row| row.split(','));
    let header: Vec<&str> = rows.next().expect("a header").collect();
    let column = header.iter().position(|c| *c == "total_energy_j").expect("the ledger tells the energy");
    rows.filter_map(|mut row| row.nth(column)?.parse().ok()).collect()
}
