//! A participant's session: its keys, its streams, and the queue into which everything it hears is put.

use std::sync::Arc;
use std::time::Duration;

use cosplat_core::participant::Frame;
use cosplat_core::plan::{ParticipantId, Plan, StreamId};

use crate::config;
use crate::error::BusError;
use crate::keys::Keys;
use crate::queue::Post;
use crate::session::{Bus, Lane, Outlet, Payload, Presence};
use crate::ticket::JoinTicket;

/// What a participant's loop is told.
#[derive(Debug)]
pub(crate) enum Incoming {
    /// On `ctl/<own name>`.
    Control(Payload),
    /// On a stream.
    Data(Payload),
    /// On `resend/<own name>`.
    Resend(Payload),
    /// The launcher's end of the life-line is closed.
    LauncherGone,
}

/// The session of a participant.
pub(crate) struct Wire {
    bus: Bus,
    keys: Keys,
    post: Post<Incoming>,
    ack: Arc<Outlet>,
    streams: Vec<Option<Outlet>>,
    requests: Vec<Option<Outlet>>,
    presence: Presence,
}

impl Wire {
    /// Joins as the holder of `ticket`. Everything heard goes to `post`.
    pub(crate) fn open(ticket: &JoinTicket, patience: Duration, post: Post<Incoming>) -> Result<Self, BusError> {
        let config = config::participant(ticket, patience)?;
        let bus = Bus::open(config, &format!("`{}`", ticket.name), &ticket.endpoint)?;
        let keys = Keys::new(&ticket.run_id()?);
        let (control, resend) = (post.clone(), post.clone());
        bus.subscribe(&keys.ctl(&ticket.name), move |p| control.send(Incoming::Control(p)))?;
        bus.subscribe(&keys.resend(&ticket.name), move |p| resend.send(Incoming::Resend(p)))?;
        let ack = Arc::new(bus.publisher(keys.ack(&ticket.name), Lane::Control)?);
        let presence = bus.show_presence(&keys.live(&ticket.name))?;
        Ok(Self { bus, keys, post, ack, streams: Vec::new(), requests: Vec::new(), presence })
    }

    /// Where this participant speaks to the coordinator.
    pub(crate) fn ack(&self) -> &Arc<Outlet> {
        &self.ack
    }

    /// Declares all streams that `me` sends or reads, each once for the life of the process.
    pub(crate) fn declare(&mut self, plan: &Plan, me: ParticipantId) -> Result<(), BusError> {
        self.streams = plan.streams.iter().map(|_| None).collect();
        self.requests = plan.participants.iter().map(|_| None).collect();
        for (id, stream) in plan.sent_by(me) {
            let outlet = self.bus.publisher(self.keys.stream(&stream.key), Lane::Data)?;
            self.streams[usize::from(id)] = Some(outlet);
        }
        for (_, stream) in plan.read_by(me) {
            let post = self.post.clone();
            self.bus.subscribe(&self.keys.stream(&stream.key), move |p| post.send(Incoming::Data(p)))?;
            if let Some(request) = self.requests.get_mut(usize::from(stream.from)).filter(|r| r.is_none()) {
                *request = Some(self.bus.publisher(self.keys.resend(plan.name_of(stream.from)), Lane::Control)?);
            }
        }
        Ok(())
    }

    /// Puts a frame on a stream. What was not declared is not this participant's to send, and is left out.
    pub(crate) fn publish(&self, stream: StreamId, frame: &Frame) -> Result<(), BusError> {
        send_on(&self.streams, usize::from(stream), |outlet| outlet.send_frame(frame))
    }

    /// Asks a participant to send something again.
    pub(crate) fn request(&self, from: ParticipantId, bytes: Vec<u8>) -> Result<(), BusError> {
        send_on(&self.requests, usize::from(from), |outlet| outlet.send(bytes))
    }

    /// Leaves, publishers first: a session that is closed under them leaks.
    pub(crate) fn close(self) {
        drop((self.ack, self.streams, self.requests, self.presence));
        self.bus.close();
    }
}

fn send_on(
    outlets: &[Option<Outlet>],
    at: usize,
    send: impl FnOnce(&Outlet) -> Result<(), BusError>,
) -> Result<(), BusError> {
    outlets.get(at).and_then(Option::as_ref).map_or(Ok(()), send)
}
