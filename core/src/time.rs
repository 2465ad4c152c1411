//! Simulated time as whole ticks, so that a run of many windows never sums floats.

use serde::{Deserialize, Serialize};

/// Ticks of one coupling window. Two, because the finest division any scheme needs is half a window.
pub const TICKS_PER_WINDOW: u64 = 2;

/// The clock of a run: windows of equal length from t = 0.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Clock {
    /// Length of a tick \[s\].
    pub tick_s: f64,
    /// Number of windows in the run.
    pub windows: u64,
}

impl Clock {
    /// A clock of `windows` windows that together last `duration_s` \[s\].
    pub fn new(duration_s: f64, windows: u64) -> Self {
        Self { tick_s: duration_s / (windows.max(1) * TICKS_PER_WINDOW) as f64, windows }
    }

    /// Length of a window \[s\].
    pub fn window_s(&self) -> f64 {
        self.tick_s * TICKS_PER_WINDOW as f64
    }

    /// Moment of a tick \[s\]: one product, the same on every machine.
    pub fn seconds(&self, tick: u64) -> f64 {
        tick as f64 * self.tick_s
    }

    /// First tick of a window.
    pub fn start_of(&self, window: u64) -> u64 {
        window * TICKS_PER_WINDOW
    }
}

/// A stretch of simulated time that a solver is asked to cover.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Span {
    /// First tick.
    pub from: u64,
    /// Tick after the last.
    pub to: u64,
}

impl Span {
    /// Number of ticks.
    pub fn ticks(self) -> u64 {
        self.to - self.from
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn five_hundred_windows_of_two_milliseconds_are_one_second() {
        let clock = Clock::new(1.0, 500);
        // Summing 0.002 five hundred times misses 1.0 by rounding; ticks do not.
        assert_eq!(clock.seconds(clock.start_of(500)).to_bits(), 1.0_f64.to_bits());
        assert_eq!(clock.start_of(500) - clock.start_of(499), TICKS_PER_WINDOW);
    }
}
