//! The pulse a computing plugin is given: while it beats, the protocol lives.

use std::time::{Duration, Instant};

use cosplat_core::plugin::{Pulse, Signal};

use super::drive::Driver;

/// Least time between two looks at the queue. A beat in between costs a clock reading.
const BREATH: Duration = Duration::from_millis(1);

/// Serves requests of partners and hears an abort, from inside the plugin's substeps.
pub(super) struct HostPulse<'a> {
    driver: &'a mut Driver,
    next: Instant,
    aborted: bool,
}

impl<'a> HostPulse<'a> {
    pub(super) fn new(driver: &'a mut Driver) -> Self {
        Self { driver, next: Instant::now() + BREATH, aborted: false }
    }
}

impl Pulse for HostPulse<'_> {
    fn beat(&mut self, done: u64, of: u64) -> Signal {
        self.driver.heartbeat().reached(done, of);
        if !self.aborted && Instant::now() >= self.next {
            self.aborted = !self.driver.breathe(done, of);
            self.next = Instant::now() + BREATH;
        }
        if self.aborted { Signal::Abort } else { Signal::Continue }
    }
}
