//! What does a coupling window cost when the solvers do next to nothing?
//!
//! Two real processes of the emptiest solver exchange three-vectors both ways over the real bus: samples (position and velocity, 24 B each in
//! single precision) from the responder, impulses (24 B each in double precision) from the resolver, serial scheme.
//! The figure is the time between the starts of two consecutive windows of the resolver: median, 10th and 90th
//! percentile, after the first tenth of the run.
//!
//! Floor, by counting: a window is one round trip between two processes, two hops. A hop that finds its reader asleep
//! costs a wake-up of about 25 µs on the machine of the published figures, and there are three a hop: the sender's
//! transport, the reader's transport, the reader. For 10^5 samples 2.4 MB cross each way, copied about four times.
//!
//! Beside it, published for preCICE 3.4.1 serial-explicit on such a machine (2 virtual cores): 192 µs, 1.42 ms and
//! 15.8 ms for 10^3, 10^4 and 10^5 vertices with cores idle; 181 µs, 1.38 ms and 11.8 ms with cores kept awake.
//!
//! `cargo bench --bench coupling_window`

use std::path::Path;
use std::process::{Child, Command, Stdio};

/// Samples, windows, and preCICE's published time idle and awake \[µs\].
const CASES: [(usize, u64, f64, f64); 3] =
    [(1_000, 3_000, 192.0, 181.0), (10_000, 1_000, 1_420.0, 1_380.0), (100_000, 200, 15_800.0, 11_800.0)];

fn main() {
    // `cargo test` starts benchmarks with this flag to see that they still work; timing is not asked for then.
    if std::env::args().any(|a| a == "--test") {
        return;
    }
    println!(
        "{:>8} {:>6} {:>12} {:>22} {:>14} {:>7}",
        "samples", "cores", "median [us]", "10 %..90 % [us]", "preCICE [us]", "ratio"
    );
    for awake in [false, true] {
        let spinners = if awake { keep_awake() } else { Vec::new() };
        for (samples, windows, idle_us, awake_us) in CASES {
            let mut gaps = gaps_us(samples, windows);
            gaps.sort_by(f64::total_cmp);
            let at = |q: f64| gaps[((gaps.len() - 1) as f64 * q) as usize];
            let peer = if awake { awake_us } else { idle_us };
            let cores = if awake { "awake" } else { "idle" };
            let range = format!("{:.0}..{:.0}", at(0.1), at(0.9));
            println!("{samples:>8} {cores:>6} {:>12.1} {range:>22} {peer:>14.0} {:>7.2}", at(0.5), at(0.5) / peer);
        }
        spinners.into_iter().for_each(stop);
    }
}

/// A spinner of the lowest priority on each core, as when solvers are busy: nobody then has to wake a halted core.
fn keep_awake() -> Vec<Child> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let spin =
        || Command::new("chrt").args(["-i", "0", "sh", "-c", "while :; do :; done"]).stdin(Stdio::null()).spawn();
    (0..cores).filter_map(|_| spin().ok()).collect()
}

fn stop(mut child: Child) {
    let _ = child.kill();
    let _ = child.wait();
}

/// Times between the starts of consecutive windows of the resolver \[µs\].
fn gaps_us(samples: usize, windows: u64) -> Vec<f64> {
    let scratch = tempfile::tempdir().expect("a scratch folder");
    let cosplat = Path::new(env!("CARGO_BIN_EXE_cosplat"));
    let exchanger = cosplat.with_file_name("examples").join("exchanger");
    assert!(exchanger.exists(), "build the plugin first: cargo build --release --examples");
    let exchanger = exchanger.display();
    let body = |name: &str| {
        format!(
            "[solver.{name}]\nplugin = \"exchanger\"\ncommand = [\"{exchanger}\"]\n[[body]]\nname = \"{name}\"\nsolver = \"{name}\"\n\
             material = \"point-mass\"\nmass = 1.0\ncloud = {{ count = {samples}, size = [1.0, 1.0, 1.0] }}\n"
        )
    };
    let scene = format!(
        "format = 1\nname = \"exchange\"\ntitle = \"Two clouds that exchange\"\n[clock]\nduration = {:?}\n\
         window = 0.001\n[output]\ntrace = true\nledger_every = 1000000\n{}{}",
        windows as f64 * 1e-3,
        body("a"),
        body("b")
    );
    let file = scratch.path().join("scene.toml");
    std::fs::write(&file, scene).expect("the scene can be written");
    let out = scratch.path().join("out");
    let status = Command::new(cosplat).arg("run").arg(&file).arg("--quiet").arg("--out").arg(&out).status();
    assert!(status.is_ok_and(|s| s.success()), "the exchange ran");
    let trace = std::fs::read_to_string(out.join("trace.json")).expect("the run wrote a trace");
    let events: serde_json::Value = serde_json::from_str(&trace).expect("the trace is JSON");
    let starts: Vec<f64> = events
        .as_array()
        .expect("the trace is a list")
        .iter()
        .filter(|e| e["name"] == "compute" && e["pid"] == 1)
        .filter_map(|e| e["ts"].as_f64())
        .collect();
    let warm = starts.len() / 10;
    starts[warm..].windows(2).map(|w| w[1] - w[0]).collect()
}
