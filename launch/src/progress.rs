//! What is said while a run goes on: a bar on a terminal, a line every few seconds elsewhere, and notices.
//!
//! All of it goes to standard error; standard output is for results.

use std::io::IsTerminal as _;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::render::{Paint, printable, talk};

/// Between two lines where there is no terminal.
const LINE_EVERY: Duration = Duration::from_secs(5);
/// Between two changes of the bar: windows may be much shorter than anybody can read.
const DRAW_EVERY: Duration = Duration::from_millis(100);

/// Says how far a run is.
pub(crate) struct Progress {
    bar: Option<ProgressBar>,
    is_quiet: bool,
    paint: Paint,
    duration_s: f64,
    simulated_s: f64,
    /// Start of the first window.
    started: Option<Instant>,
    /// Last line or change of the bar.
    said: Instant,
}

impl Progress {
    /// For a run of `windows` windows that last `duration_s` \[s\] together.
    pub(crate) fn new(windows: u64, duration_s: f64, is_quiet: bool) -> Self {
        let bar = (!is_quiet && std::io::stderr().is_terminal()).then(|| {
            let bar = ProgressBar::with_draw_target(Some(windows), ProgressDrawTarget::stderr());
            // A template that does not parse would leave the default one, which also does.
            if let Ok(style) = ProgressStyle::with_template("{prefix:>7} {wide_bar} {msg}") {
                bar.set_style(style.progress_chars("█▉▊▋▌▍▎▏ "));
            }
            bar.set_prefix("run");
            bar.set_message("starting");
            bar
        });
        let paint = Paint::stderr();
        Self { bar, is_quiet, paint, duration_s, simulated_s: 0.0, started: None, said: Instant::now() }
    }

    /// A line of talk that belongs to a label.
    pub(crate) fn say(&self, label: &str, text: &str) {
        if !self.is_quiet {
            self.print(&format!("{} {}", self.paint.bold(&format!("{label:>7}")), printable(text)));
        }
    }

    /// Something people should look at.
    pub(crate) fn warn(&self, text: &str) {
        if !self.is_quiet {
            self.print(&format!("{} {}", self.paint.warn(&format!("{:>7}", "note")), printable(text)));
        }
    }

    /// The first window begins.
    pub(crate) fn started(&mut self) {
        self.started = Some(Instant::now());
    }

    /// So many windows are settled, which end at `end_s` \[s\].
    pub(crate) fn settled(&mut self, windows: u64, end_s: f64) {
        self.simulated_s = end_s;
        if let Some(bar) = &self.bar
            && self.said.elapsed() >= DRAW_EVERY
        {
            self.said = Instant::now();
            bar.set_message(self.position());
            bar.set_position(windows);
        }
    }

    /// A moment has passed.
    pub(crate) fn tick(&mut self) {
        if self.bar.is_none() && self.started.is_some() && self.said.elapsed() >= LINE_EVERY {
            self.said = Instant::now();
            self.say("run", &self.position());
        }
    }

    /// Takes the bar away.
    pub(crate) fn finish(&mut self) {
        if let Some(bar) = self.bar.take() {
            bar.finish_and_clear();
        }
    }

    /// `0.42 s of 1 s, 3.1 times real time`.
    fn position(&self) -> String {
        let spent_s = self.started.map_or(0.0, |s| s.elapsed().as_secs_f64());
        let position = format!("{:.3} s of {} s", self.simulated_s, self.duration_s);
        if spent_s > 0.0 && self.simulated_s > 0.0 {
            format!("{position}, {}", real_time(self.simulated_s / spent_s))
        } else {
            position
        }
    }

    fn print(&self, line: &str) {
        match &self.bar {
            Some(bar) => bar.suspend(|| talk(line)),
            None => talk(line),
        }
    }
}

/// A ratio of simulated to wall time, with three digits.
pub(crate) fn real_time(ratio: f64) -> String {
    if ratio >= 99.95 { format!("{ratio:.0} times real time") } else { format!("{ratio:.2} times real time") }
}
