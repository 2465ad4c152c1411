//! A thread that says the process lives when the loop itself has not spoken for a while: during a computation without
//! beats. A process that is stopped stops this too, so silence still means something.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

use cosplat_core::control::{Envelope, PROTOCOL, Progress, RunId, Up, encode};

use crate::error::BusError;
use crate::session::Outlet;

/// What the loop leaves for the thread to read. Each number is exact, their combination is for people only.
#[derive(Debug, Default)]
pub(crate) struct Sign {
    epoch: AtomicU32,
    window: AtomicU64,
    substep: AtomicU64,
    substeps: AtomicU64,
    /// Last moment at which the loop spoke for itself, in milliseconds of the thread's clock.
    spoken_ms: AtomicU64,
}

/// The running thread; ends when dropped.
pub(crate) struct Heartbeat {
    sign: Arc<Sign>,
    started: Instant,
    _stop: mpsc::Sender<()>,
}

impl Heartbeat {
    /// Starts the thread. It is quiet while the loop speaks at least every one and a half `period`s.
    pub(crate) fn start(ack: &Arc<Outlet>, run: RunId, instance: u64, period: Duration) -> Result<Self, BusError> {
        let (stop, stopped) = mpsc::channel::<()>();
        let sign = Arc::new(Sign::default());
        let started = Instant::now();
        // Weak, so that a thread that is blocked in the transport does not keep the publisher alive.
        let (ack, watched) = (Arc::downgrade(ack), sign.clone());
        let patience = period + period / 2;
        let beat = move || {
            while stopped.recv_timeout(period) == Err(RecvTimeoutError::Timeout) {
                let epoch = watched.epoch.load(Ordering::Relaxed);
                let spoken = Duration::from_millis(watched.spoken_ms.load(Ordering::Relaxed));
                if epoch == 0 || started.elapsed() < spoken + patience {
                    continue;
                }
                let Some(ack) = ack.upgrade() else { return };
                let body = Up::Heartbeat(watched.progress());
                // A lost connection is the loop's to notice.
                let _ = ack.send(encode(&Envelope { protocol: PROTOCOL, run, epoch, instance, body }));
            }
        };
        thread::Builder::new()
            .name("heartbeat".to_owned())
            .spawn(beat)
            .map_err(|source| BusError::Thread { name: "heartbeat", source })?;
        Ok(Self { sign, started, _stop: stop })
    }

    /// The loop has spoken to the coordinator of this epoch.
    pub(crate) fn spoke(&self, epoch: u32) {
        self.sign.epoch.store(epoch, Ordering::Relaxed);
        self.sign.spoken_ms.store(self.started.elapsed().as_millis() as u64, Ordering::Relaxed);
    }

    /// A step of this window begins.
    pub(crate) fn begins(&self, window: u64) {
        self.sign.window.store(window, Ordering::Relaxed);
        self.reached(0, 0);
    }

    /// Substep `done` of `of` is finished.
    pub(crate) fn reached(&self, done: u64, of: u64) {
        self.sign.substep.store(done, Ordering::Relaxed);
        self.sign.substeps.store(of, Ordering::Relaxed);
    }
}

impl Sign {
    fn progress(&self) -> Progress {
        Progress {
            window: self.window.load(Ordering::Relaxed),
            substep: self.substep.load(Ordering::Relaxed),
            substeps: self.substeps.load(Ordering::Relaxed),
            waiting_for: None,
        }
    }
}
