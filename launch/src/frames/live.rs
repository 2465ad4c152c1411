//! The recording of a run, shown while the run goes on.
//!
//! Whoever draws frames puts what changed into a mailbox, in which the newest of each entity replaces what nobody has
//! fetched, and never waits. A thread of its own fetches it and sends it to a viewer on this machine. A viewer that is
//! slow, frozen, closed or not yet open therefore costs the run nothing, and one that is opened later, or again, is first
//! given all that there is.

use std::collections::{BTreeMap, VecDeque};
use std::net::{SocketAddr, TcpStream};
use std::sync::mpsc::{Receiver, sync_channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use cosplat_viewer::recording::{Recording, RecordingError};

use super::moment::Item;
use super::rows::Row;
use super::stage::Stage;

/// Between two frames that are sent: twenty a second, about what is still seen as motion.
const FRAME: Duration = Duration::from_millis(50);
/// After each frame the thread rests for this many times as long as the frame has taken, so that it uses at most a
/// fifth of one core.
const REST: u32 = 4;
/// Moving Gaussians of a body that are sent at most; of more every second, third … is shown. A capture of a small object
/// has about this many, and a frame of them is 4 MB.
const GAUSSIANS: usize = 100_000;
/// Settled windows whose curves a viewer that is opened later is still given.
const WINDOWS: usize = 20_000;
/// Between two looks whether somebody listens.
const LOOK: Duration = Duration::from_millis(250);
/// Longest wait at the end of a run for a viewer that takes what was sent.
const GOODBYE: Duration = Duration::from_secs(3);

/// Where a viewer listens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct LiveTo {
    /// Its address, on this machine.
    pub(crate) address: SocketAddr,
    /// How long to wait at the end of a run for one that is not open yet.
    pub(crate) patience: Duration,
}

/// What nobody has fetched yet.
#[derive(Debug, Default)]
struct Mail {
    items: BTreeMap<String, Arc<Item>>,
    rows: Vec<Arc<Row>>,
    /// Window and moment \[s\] of the items.
    at: (u64, f64),
    is_over: bool,
}

type Mailbox = Arc<(Mutex<Mail>, Condvar)>;

/// A run that is shown while it goes on.
pub(super) struct Live {
    mailbox: Mailbox,
    /// Hears when the thread is done.
    done: Receiver<()>,
    patience: Duration,
}

impl Live {
    /// Begins to look for a viewer.
    ///
    /// # Errors
    /// In words, when there can be no thread.
    pub(super) fn start(to: LiveTo, stage: Stage) -> Result<Self, String> {
        let mailbox = Mailbox::default();
        let (say, done) = sync_channel(1);
        let sender = Sender {
            mailbox: Arc::clone(&mailbox),
            to,
            stage,
            all: BTreeMap::new(),
            rows: VecDeque::new(),
            viewer: None,
        };
        let work = move || {
            sender.work();
            // Nobody listens where the run did not wait.
            let _ = say.try_send(());
        };
        thread::Builder::new().name("live".into()).spawn(work).map_err(|e| e.to_string())?;
        Ok(Self { mailbox, done, patience: to.patience + GOODBYE })
    }

    /// Takes what has changed in a frame.
    pub(super) fn frame(&self, window: u64, time_s: f64, items: &[(String, Arc<Item>)]) {
        let mut mail = lock(&self.mailbox.0);
        mail.items.extend(items.iter().cloned());
        mail.at = (window, time_s);
        self.mailbox.1.notify_one();
    }

    /// Takes a settled window.
    pub(super) fn row(&self, row: &Arc<Row>) {
        let mut mail = lock(&self.mailbox.0);
        mail.rows.push(Arc::clone(row));
        let extra = mail.rows.len().saturating_sub(WINDOWS);
        mail.rows.drain(..extra);
    }

    /// Sends the rest, as far as somebody takes it in time.
    pub(super) fn finish(self) {
        lock(&self.mailbox.0).is_over = true;
        self.mailbox.1.notify_one();
        // A thread that is stuck in a frozen viewer is left behind and ends with the program.
        let _ = self.done.recv_timeout(self.patience);
    }
}

/// The thread that sends.
struct Sender {
    mailbox: Mailbox,
    to: LiveTo,
    stage: Stage,
    /// The newest of everything, for viewers that come later.
    all: BTreeMap<String, Arc<Item>>,
    rows: VecDeque<Arc<Row>>,
    viewer: Option<Recording>,
}

impl Sender {
    fn work(mut self) {
        loop {
            let mail = self.fetch();
            let began = Instant::now();
            let is_over = mail.is_over;
            self.all.extend(mail.items.iter().map(|(entity, item)| (entity.clone(), Arc::clone(item))));
            self.rows.extend(mail.rows.iter().cloned());
            let extra = self.rows.len().saturating_sub(WINDOWS);
            self.rows.drain(..extra);
            let sent = match &mut self.viewer {
                Some(viewer) => send(viewer, mail.at, &mail.items, mail.rows.iter()),
                None => self.greet(mail.at, if is_over { self.to.patience } else { Duration::ZERO }),
            };
            if sent.is_err() {
                // Closed, or stuck: whoever listens next is given everything.
                self.viewer = None;
            }
            if is_over {
                break;
            }
            thread::sleep(FRAME.max(began.elapsed() * REST));
        }
        if let Some(viewer) = self.viewer.take() {
            // The file of the run is whole, whatever a viewer has missed.
            let _ = viewer.finish();
        }
    }

    /// What is new; nothing after [`LOOK`].
    fn fetch(&self) -> Mail {
        let (mail, bell) = &*self.mailbox;
        let is_idle = |mail: &mut Mail| mail.items.is_empty() && mail.rows.is_empty() && !mail.is_over;
        let waited = bell.wait_timeout_while(lock(mail), LOOK, is_idle);
        let (mut mail, _) = waited.unwrap_or_else(PoisonError::into_inner);
        let at = mail.at;
        Mail { at, ..std::mem::replace(&mut *mail, Mail { at, ..Mail::default() }) }
    }

    /// Gives everything to a viewer, if there is one within a time.
    fn greet(&mut self, at: (u64, f64), patience: Duration) -> Result<(), RecordingError> {
        let until = Instant::now() + patience;
        while TcpStream::connect_timeout(&self.to.address, LOOK).is_err() {
            if Instant::now() >= until {
                return Ok(());
            }
            thread::sleep(LOOK);
        }
        let mut viewer = Recording::connect(self.to.address, &self.stage.layout())?;
        send(&mut viewer, at, &self.all, self.rows.iter())?;
        self.viewer = Some(viewer);
        Ok(())
    }
}

fn send<'a>(
    viewer: &mut Recording,
    (window, time_s): (u64, f64),
    items: &BTreeMap<String, Arc<Item>>,
    rows: impl Iterator<Item = &'a Arc<Row>>,
) -> Result<(), RecordingError> {
    viewer.frame(window, time_s);
    for (entity, item) in items {
        item.put(viewer, entity, GAUSSIANS)?;
    }
    for row in rows {
        row.put(viewer)?;
    }
    // Also with nothing to say: it tells whether the viewer is still there.
    viewer.flush()
}

fn lock(mail: &Mutex<Mail>) -> MutexGuard<'_, Mail> {
    // Every field is whole at every moment.
    mail.lock().unwrap_or_else(PoisonError::into_inner)
}
