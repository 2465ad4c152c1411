//! Sessions, publishers and subscribers, reduced to what lock-step needs.

use std::fmt;
use std::sync::mpsc;
use std::thread;
use std::time::Duration;

use bytes::Bytes;
use cosplat_core::participant::Frame;
use zenoh::bytes::ZBytes;
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::Publisher;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::sample::SampleKind;
use zenoh::{Config, Session, Wait};

use crate::error::BusError;

/// Longest wait for an orderly goodbye. The end of a process must not depend on it.
const CLOSE_PATIENCE: Duration = Duration::from_secs(2);

/// Kind of traffic. Nothing relies on the order between the two: each has its own queue in the transport.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lane {
    /// Small and urgent.
    Control,
    /// Bulk.
    Data,
}

/// An open session.
pub struct Bus {
    session: Session,
}

impl fmt::Debug for Bus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Bus").finish_non_exhaustive()
    }
}

impl Bus {
    /// Opens a session as `who`, at `endpoint` (both for messages only).
    ///
    /// # Errors
    /// [`BusError::Open`].
    pub fn open(config: Config, who: &str, endpoint: &str) -> Result<Self, BusError> {
        let session = zenoh::open(config).wait().map_err(|e| BusError::Open {
            who: who.to_owned(),
            endpoint: endpoint.to_owned(),
            why: words(&e),
        })?;
        Ok(Self { session })
    }

    /// Declares a key to publish on.
    ///
    /// # Errors
    /// [`BusError::Declare`].
    pub fn publisher(&self, key: String, lane: Lane) -> Result<Outlet, BusError> {
        let priority = match lane {
            Lane::Control => Priority::RealTime,
            Lane::Data => Priority::InteractiveHigh,
        };
        let publisher = self
            .session
            .declare_publisher(key.clone())
            // The default drops. Blocking is not lossless either, which is why core asks again for what is missing.
            .congestion_control(CongestionControl::Block)
            .priority(priority)
            .express(true)
            .wait()
            .map_err(|e| declare_error("a publisher", &key, &e))?;
        Ok(Outlet { publisher, key })
    }

    /// Calls `deliver` with every payload put on `key`, for as long as the session is open.
    ///
    /// It runs on zenoh's receiving thread, where blocking stops all traffic: it may only put the payload into a queue.
    ///
    /// # Errors
    /// [`BusError::Declare`].
    pub fn subscribe(&self, key: &str, deliver: impl Fn(Payload) + Send + Sync + 'static) -> Result<(), BusError> {
        self.session
            .declare_subscriber(key.to_owned())
            .callback(move |sample| {
                if sample.kind() == SampleKind::Put {
                    deliver(Payload(sample.payload().clone()));
                }
            })
            .background()
            .wait()
            .map_err(|e| declare_error("a subscriber", key, &e))
    }

    /// Shows presence on `key` until the answer is dropped or the connection ends.
    ///
    /// # Errors
    /// [`BusError::Declare`].
    pub fn show_presence(&self, key: &str) -> Result<Presence, BusError> {
        let token = self.session.liveliness().declare_token(key.to_owned()).wait();
        Ok(Presence { _token: token.map_err(|e| declare_error("a liveliness token", key, &e))? })
    }

    /// Calls `deliver` when somebody appears (true) or disappears (false) on `key`. A hint, never a proof.
    ///
    /// # Errors
    /// [`BusError::Declare`].
    pub fn watch_presence(&self, key: &str, deliver: impl Fn(bool) + Send + Sync + 'static) -> Result<(), BusError> {
        self.session
            .liveliness()
            .declare_subscriber(key.to_owned())
            .history(true)
            .callback(move |sample| deliver(sample.kind() == SampleKind::Put))
            .background()
            .wait()
            .map_err(|e| declare_error("a liveliness subscriber", key, &e))
    }

    /// Says goodbye, at most for two seconds. Drop publishers first.
    pub fn close(self) {
        Self::close_all(vec![self]);
    }

    /// Says goodbye on several buses, at most for two seconds in all.
    pub(crate) fn close_all(buses: Vec<Self>) {
        let (done, closed) = mpsc::channel::<()>();
        let closing = thread::Builder::new().name("bus-close".to_owned()).spawn(move || {
            for bus in buses {
                // Whatever the answer, the session is of no more use.
                let _ = bus.session.close().wait();
            }
            drop(done);
        });
        if closing.is_ok() {
            // Ends when the thread drops its side or the time is over.
            let _ = closed.recv_timeout(CLOSE_PATIENCE);
        }
    }
}

/// Presence on the bus.
pub struct Presence {
    _token: LivelinessToken,
}

/// A key to publish on.
pub struct Outlet {
    publisher: Publisher<'static>,
    key: String,
}

impl Outlet {
    /// Hands bytes to the transport.
    ///
    /// # Errors
    /// [`BusError::Publish`] when the connection is gone.
    pub fn send(&self, bytes: Vec<u8>) -> Result<(), BusError> {
        self.put(ZBytes::from(bytes))
    }

    /// Lends a frame to the transport; its owner keeps it for resending.
    ///
    /// # Errors
    /// [`BusError::Publish`] when the connection is gone.
    pub fn send_frame(&self, frame: &Frame) -> Result<(), BusError> {
        self.put(ZBytes::from(Bytes::from_owner(Shared(frame.clone()))))
    }

    fn put(&self, bytes: ZBytes) -> Result<(), BusError> {
        let put = self.publisher.put(bytes).wait();
        put.map_err(|e| BusError::Publish { key: self.key.clone(), why: words(&e) })
    }
}

/// A frame as its owner keeps it, lent to the transport without a copy.
struct Shared(Frame);

impl AsRef<[u8]> for Shared {
    fn as_ref(&self) -> &[u8] {
        &self.0
    }
}

/// Bytes as they lie in the transport's buffers; taking them out is left to the thread that uses them.
#[derive(Clone, Debug)]
pub struct Payload(ZBytes);

impl Payload {
    /// The bytes, in one copy.
    pub fn into_vec(self) -> Vec<u8> {
        // Of several fragments this makes one vector, of a single one a borrow: either way one copy.
        self.0.to_bytes().into_owned()
    }

    /// Number of bytes.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// zenoh's words, without the place in its sources that it appends.
fn words(error: &zenoh::Error) -> String {
    let text = error.to_string();
    text.split(" at /").next().unwrap_or(&text).to_owned()
}

fn declare_error(what: &'static str, key: &str, error: &zenoh::Error) -> BusError {
    BusError::Declare { what, key: key.to_owned(), why: words(error) }
}
