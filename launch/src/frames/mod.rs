//! Frames of a run: drawn, written and recorded beside the solvers, from what they show.
//!
//! The recorder is a participant like any other, inside this program. It hands each frame to a worker of its own and
//! says at once that its window is done; when two frames are waiting it waits, and with it the clock.

mod body;
mod conditions;
mod files;
mod film;
mod live;
mod moment;
mod opening;
mod rows;
mod sequence;
mod stage;
mod surfaces;
mod worker;

use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use cosplat_core::plan::RECORDER;
use cosplat_core::plugin::{
    Descriptor, Inputs, Outputs, Plugin, PluginError, Pulse, Report, Setup, Signal, SolverScene, StateReader,
    StateSink, Step,
};
use cosplat_core::visual::VisualFrame;

pub(crate) use body::{Cloth, Drawn, Look, borrowed};
pub(crate) use files::{Frames, Wanted, picture};
pub(crate) use live::LiveTo;
pub(crate) use rows::Row;
pub(crate) use surfaces::{Liquid, liquids};
use worker::Worker;

/// Frames that may wait for the worker.
const IN_FLIGHT: usize = 2;
/// Between two looks whether the worker has room.
const LOOK: Duration = Duration::from_millis(2);

/// What the worker is asked for.
enum Order {
    /// Go on where an earlier life of the run had taken so many frames; this is how everything stood in the first one.
    Open(Box<VisualFrame>, u64),
    /// Take a frame.
    Take(VisualFrame),
    /// Say when all frames are on disk.
    Flush(SyncSender<()>),
}

/// The participant that takes frames.
pub(crate) struct FrameRecorder {
    post: Option<SyncSender<Order>>,
    /// Frames taken, and the first of them where the run keeps checkpoints.
    taken: u64,
    first: Vec<u8>,
    is_kept: bool,
    /// Why the worker stopped, if it did before its time.
    broken: Receiver<String>,
    worker: Option<JoinHandle<Result<Frames, String>>>,
}

impl FrameRecorder {
    /// Starts a worker that makes what is wanted of each frame.
    ///
    /// # Errors
    /// In words, when a folder or file cannot be made, or no thread.
    pub(crate) fn start(wanted: Wanted) -> Result<Self, String> {
        let (post, frames) = sync_channel(IN_FLIGHT);
        let (say, broken) = sync_channel(1);
        let is_kept = wanted.is_kept;
        let worker = Worker::new(wanted)?;
        let work = move || {
            let done = worker.work(&frames);
            if let Err(why) = &done {
                // Nobody listens where the run has ended already; the result says it again.
                let _ = say.try_send(why.clone());
            }
            done
        };
        let worker = thread::Builder::new().name("frames".into()).spawn(work).map_err(|e| e.to_string())?;
        Ok(Self { post: Some(post), taken: 0, first: Vec::new(), is_kept, broken, worker: Some(worker) })
    }

    /// Waits for the last frame.
    ///
    /// # Errors
    /// In words, what could not be written.
    pub(crate) fn finish(mut self) -> Result<Frames, String> {
        drop(self.post.take());
        let Some(worker) = self.worker.take() else { return Ok(Frames::default()) };
        worker.join().unwrap_or_else(|_| Err("the thread that draws frames panicked".to_owned()))
    }

    fn failure(&self) -> PluginError {
        PluginError::Environment(self.broken.try_recv().unwrap_or_else(|_| "frames are no longer drawn".to_owned()))
    }
}

impl Plugin for FrameRecorder {
    fn describe(&self) -> Descriptor {
        Descriptor::new(RECORDER, env!("CARGO_PKG_VERSION"), "draws and writes the frames of a run")
    }

    fn setup(&mut self, _scene: &SolverScene) -> Result<Setup, PluginError> {
        Ok(Setup {
            boundaries: Vec::new(),
            report: Report::default(),
            stable_dt: None,
            particles: Vec::new(),
            left_out: Vec::new(),
        })
    }

    fn record(&mut self, frame: &VisualFrame, pulse: &mut dyn Pulse) -> Result<(), PluginError> {
        let Some(post) = &self.post else { return Err(self.failure()) };
        let mut order = Order::Take(frame.clone());
        loop {
            match post.try_send(order) {
                Ok(()) => break,
                Err(TrySendError::Disconnected(_)) => return Err(self.failure()),
                Err(TrySendError::Full(same)) => order = same,
            }
            if pulse.beat(0, 1) == Signal::Abort {
                return Err(PluginError::Aborted);
            }
            thread::sleep(LOOK);
        }
        if self.is_kept && self.taken == 0 {
            self.first = opening::encode(frame);
        }
        self.taken += 1;
        Ok(())
    }

    fn flush(&mut self) -> Result<(), PluginError> {
        let (say, flushed) = sync_channel(1);
        let asked = self.post.as_ref().is_some_and(|post| post.send(Order::Flush(say)).is_ok());
        if asked && flushed.recv().is_ok() { Ok(()) } else { Err(self.failure()) }
    }

    fn advance(&mut self, _step: &Step, _inputs: &Inputs, _pulse: &mut dyn Pulse) -> Result<Outputs, PluginError> {
        Ok(Outputs { boundaries: Vec::new(), impulses: Vec::new(), report: Report::default() })
    }

    fn save(&self, sink: &mut dyn StateSink) {
        if self.is_kept {
            sink.u64(self.taken);
            sink.bytes(&self.first);
        }
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), PluginError> {
        let mut input = StateReader::new(state);
        let taken = input.u64()?;
        let first = input.bytes(state.len().saturating_sub(size_of::<u64>()))?.to_vec();
        if taken > 0 {
            let order = Order::Open(Box::new(opening::decode(&first)?), taken);
            let sent = self.post.as_ref().is_some_and(|post| post.send(order).is_ok());
            sent.then_some(()).ok_or_else(|| self.failure())?;
        }
        (self.taken, self.first) = (taken, first);
        Ok(())
    }
}
