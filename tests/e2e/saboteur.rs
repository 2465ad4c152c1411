//! An oscillator that misbehaves as its first argument says: the foreign plugin of the fault tests.
//!
//! `saboteur MODE [WINDOW]`. It is a plugin like any other and knows nothing that a foreign one could not know.

use std::io::{BufRead, Write};
use std::process::{Command, ExitCode, Stdio};
use std::time::Duration;

use cosplat_core::plugin::{
    Descriptor, Inputs, Outputs, PartnerSetup, Plugin, PluginError, Pulse, Setup, SolverScene, StateSink, Step,
};
use cosplat_oscillator::Oscillator;

/// The oscillator behind a mischief.
struct Saboteur {
    inner: Oscillator,
    mode: String,
    at: u64,
    noise: u64,
}

impl Saboteur {
    /// A number below `n`, another each time.
    fn below(&mut self, n: u64) -> u64 {
        self.noise ^= self.noise << 13;
        self.noise ^= self.noise >> 7;
        self.noise ^= self.noise << 17;
        self.noise % n
    }

    fn misbehave(&mut self) -> Result<(), PluginError> {
        // Time for the report of the window before to leave: the tests count what was finished.
        std::thread::sleep(Duration::from_millis(50));
        match self.mode.as_str() {
            "exit" => std::process::exit(0),
            "panic" => panic!("the saboteur was told to panic"),
            "kill" => signal_self("KILL"),
            "freeze" => signal_self("STOP"),
            "pause" => {
                let wake = format!("sleep 5; kill -CONT {}", std::process::id());
                let waker = Command::new("sh").args(["-c", &wake]).stdin(Stdio::null()).spawn();
                if waker.is_ok() {
                    signal_self("STOP");
                }
            }
            "physics" => return Err(PluginError::Physics("mass 1 left the known universe".to_owned())),
            "slow" => std::thread::sleep(Duration::from_secs(4)),
            _ => {}
        }
        Ok(())
    }
}

fn signal_self(signal: &str) {
    let _ = Command::new("kill").args([format!("-{signal}"), std::process::id().to_string()]).status();
    std::thread::sleep(Duration::from_millis(50));
}

impl Plugin for Saboteur {
    fn describe(&self) -> Descriptor {
        let mut descriptor = Descriptor { name: "saboteur".to_owned(), ..self.inner.describe() };
        if self.mode == "version" && !std::env::args().any(|a| a == "--describe") {
            descriptor.protocol = [9, 9];
        }
        descriptor
    }

    fn setup(&mut self, scene: &SolverScene) -> Result<Setup, PluginError> {
        self.inner.setup(scene)
    }

    fn connect(&mut self, partners: &[PartnerSetup]) -> Result<(), PluginError> {
        self.inner.connect(partners)
    }

    fn advance(&mut self, step: &Step, inputs: &Inputs, pulse: &mut dyn Pulse) -> Result<Outputs, PluginError> {
        if self.mode == "jitter" {
            let pause = self.below(2000);
            std::thread::sleep(Duration::from_micros(pause));
        } else if step.window == self.at {
            self.misbehave()?;
        }
        let mut outputs = self.inner.advance(step, inputs, pulse)?;
        if self.mode == "nan" && step.window == self.at {
            for shown in &mut outputs.boundaries {
                if let cosplat_core::boundary::BoundaryState::Samples(s) = &mut shown.state {
                    s.position[0][0] = f64::NAN;
                }
            }
        }
        Ok(outputs)
    }

    fn save(&self, sink: &mut dyn StateSink) {
        self.inner.save(sink);
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), PluginError> {
        self.inner.restore(state)
    }
}

/// Gives the same ticket to two processes.
fn join_twice() -> ExitCode {
    let mut ticket = String::new();
    let (Ok(_), Ok(me)) = (std::io::stdin().lock().read_line(&mut ticket), std::env::current_exe()) else {
        return ExitCode::FAILURE;
    };
    let start = || {
        let mut child = Command::new(&me).args(["jitter"]).stdin(Stdio::piped()).spawn().ok()?;
        let mut lifeline = child.stdin.take()?;
        lifeline.write_all(ticket.as_bytes()).ok()?;
        // Kept apart, because waiting for a child closes its standard input.
        Some((child, lifeline))
    };
    let (Some((mut first, _one)), Some((mut second, _other))) = (start(), start()) else { return ExitCode::FAILURE };
    let ends = [first.wait(), second.wait()];
    let joined = ends.iter().any(|e| e.as_ref().is_ok_and(std::process::ExitStatus::success));
    if joined { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn main() -> ExitCode {
    let mut args = std::env::args().skip(1);
    let mode = args.next().unwrap_or_default();
    let at = args.next().and_then(|a| a.parse().ok()).unwrap_or(10);
    let describing = std::env::args().any(|a| a == "--describe");
    match mode.as_str() {
        "garbage" if describing => {
            println!("%PDF-1.4 this is no descriptor");
            return ExitCode::SUCCESS;
        }
        "mute" if describing => {
            std::thread::sleep(Duration::from_mins(1));
            return ExitCode::SUCCESS;
        }
        "exit-at-once" if !describing => {
            eprintln!("saboteur: I would rather not");
            return ExitCode::from(3);
        }
        "missing" if !describing => {
            std::thread::sleep(Duration::from_mins(1));
            return ExitCode::SUCCESS;
        }
        "twice" if !describing => return join_twice(),
        "late" if !describing => std::thread::sleep(Duration::from_millis(300)),
        _ => {}
    }
    let noise = u64::from(std::process::id()).wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    cosplat_bus::run_plugin(&mut Saboteur { inner: Oscillator::default(), mode, at, noise })
}
