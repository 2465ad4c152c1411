//! Calls into the plugin. A panic in there is a failure with a name, not the end of the process.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use cosplat_core::checkpoint::Snapshot;
use cosplat_core::control::Times;
use cosplat_core::participant::{Answer, Event, Job};
use cosplat_core::plugin::{PartnerSetup, Plugin, PluginError, SolverScene, StateHasher};

use super::drive::Driver;
use super::pulse::HostPulse;
use crate::clock::monotonic_s;

/// Where the time between two steps went.
#[derive(Debug, Default)]
pub(crate) struct Stopwatch {
    /// End of the last step.
    ended: Option<Instant>,
    waited: Duration,
}

impl Stopwatch {
    pub(super) fn waited(&mut self, time: Duration) {
        self.waited += time;
    }

    /// A step begins: how long was waited for it, and how long everything else took since the last.
    fn begins(&mut self, now: Instant) -> (f64, f64) {
        let waited = std::mem::take(&mut self.waited);
        let since = self.ended.map_or(waited, |ended| now.duration_since(ended));
        (waited.as_secs_f64(), since.saturating_sub(waited).as_secs_f64())
    }
}

pub(super) fn set_up(driver: &mut Driver, plugin: &mut dyn Plugin, scene: &SolverScene, show: &[String]) {
    let answer = guarded(|| plugin.setup(scene).map(|setup| Answer::of(plugin, setup, true, show)));
    driver.note_failure(&answer);
    driver.answer(Event::SetUp(answer));
}

pub(super) fn connect(driver: &mut Driver, plugin: &mut dyn Plugin, partners: &[PartnerSetup]) {
    let answer = guarded(|| plugin.connect(partners));
    driver.note_failure(&answer);
    driver.answer(Event::Connected(answer));
}

pub(super) fn advance(driver: &mut Driver, plugin: &mut dyn Plugin, job: &Job) {
    driver.heartbeat().begins(job.step.window);
    let start = Instant::now();
    let (wait_s, transfer_s) = driver.watch.begins(start);
    let start_s = monotonic_s();
    let answer = guarded(|| {
        let mut pulse = HostPulse::new(driver);
        job.frames.iter().try_for_each(|frame| plugin.record(frame, &mut pulse))?;
        let outputs = plugin.advance(&job.step, &job.inputs, &mut pulse)?;
        Ok(Answer::of(plugin, outputs, job.hash_state, &job.show))
    });
    let end_s = monotonic_s();
    driver.watch.ended = Some(Instant::now());
    if answer != Err(PluginError::Aborted) {
        driver.note_failure(&answer);
    }
    let times = Times { start_s, end_s, compute_s: end_s - start_s, wait_s, transfer_s };
    driver.answer(Event::Computed(answer, times));
}

/// Takes up a saved state; what `save` writes after it shows whether it is the same.
pub(super) fn restore(driver: &mut Driver, plugin: &mut dyn Plugin, state: &[u8]) {
    let answer = guarded(|| {
        plugin.restore(state)?;
        let mut hasher = StateHasher::default();
        plugin.save(&mut hasher);
        Ok(hasher.finish())
    });
    driver.note_failure(&answer);
    driver.answer(Event::Restored(answer));
}

/// Takes a snapshot now, and has it stored meanwhile. A run goes on without one that cannot be taken.
pub(super) fn save(driver: &mut Driver, plugin: &mut dyn Plugin, snapshot: Snapshot, keep: Option<u64>) {
    let window = snapshot.window;
    let taken = guarded(|| {
        plugin.flush()?;
        Ok(snapshot.of(plugin))
    });
    match taken {
        Ok(bytes) => driver.keeper.store(window, bytes, keep),
        Err(error) => driver.answer(Event::Saved(window, Err(error.to_string()))),
    }
}

/// Runs plugin code. After a panic the plugin is not used again, so a state it left half-made does no harm.
fn guarded<T>(call: impl FnOnce() -> Result<T, PluginError>) -> Result<T, PluginError> {
    catch_unwind(AssertUnwindSafe(call))
        .unwrap_or_else(|panic| Err(PluginError::Physics(format!("the plugin panicked: {}", words(panic.as_ref())))))
}

fn words(panic: &(dyn Any + Send)) -> &str {
    panic
        .downcast_ref::<String>()
        .map(String::as_str)
        .or_else(|| panic.downcast_ref::<&str>().copied())
        .unwrap_or("without a message")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_a_physics_failure_with_its_words() {
        let caught = guarded::<()>(|| panic!("particle {} left", 7));
        assert_eq!(caught, Err(PluginError::Physics("the plugin panicked: particle 7 left".to_owned())));
    }

    #[test]
    fn the_stopwatch_splits_the_time_between_steps() {
        let now = Instant::now();
        let mut watch = Stopwatch::default();
        watch.waited(Duration::from_millis(3));
        assert_eq!(watch.begins(now), (0.003, 0.0));
        watch.ended = Some(now);
        watch.waited(Duration::from_millis(2));
        let (waited, rest) = watch.begins(now + Duration::from_millis(5));
        assert!((waited - 0.002).abs() < 1e-12 && (rest - 0.003).abs() < 1e-12);
    }
}
