//! A participant's sessions: its keys, its streams, and the queue into which everything it hears is put.

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
    /// A snapshot of this window is stored, or why it could not be.
    Stored(u64, Result<(), String>),
    /// The launcher's end of the life-line is closed.
    LauncherGone,
}

/// The sessions of a participant: one with the coordinator, for control, and one with each partner, for data.
pub(crate) struct Wire {
    bus: Bus,
    ticket: JoinTicket,
    keys: Keys,
    post: Post<Incoming>,
    ack: Arc<Outlet>,
    presence: Presence,
    partners: Vec<Bus>,
    /// Per stream of the plan, one outlet per receiver.
    streams: Vec<Vec<Outlet>>,
    /// Per participant of the plan.
    requests: Vec<Option<Outlet>>,
}

impl Wire {
    /// Joins as the holder of `ticket`. Everything heard goes to `post`.
    pub(crate) fn open(ticket: &JoinTicket, patience: Duration, post: Post<Incoming>) -> Result<Self, BusError> {
        let config = config::participant(ticket, patience)?;
        let bus = Bus::open(config, &format!("`{}`", ticket.name), &ticket.endpoint)?;
        let keys = Keys::new(&ticket.run_id()?);
        let control = post.clone();
        bus.subscribe(&keys.ctl(&ticket.name), move |p| control.send(Incoming::Control(p)))?;
        let ack = Arc::new(bus.publisher(keys.ack(&ticket.name), Lane::Control)?);
        let presence = bus.show_presence(&keys.live(&ticket.name))?;
        Ok(Self {
            bus,
            ticket: ticket.clone(),
            keys,
            post,
            ack,
            presence,
            partners: Vec::new(),
            streams: Vec::new(),
            requests: Vec::new(),
        })
    }

    /// Where this participant speaks to the coordinator.
    pub(crate) fn ack(&self) -> &Arc<Outlet> {
        &self.ack
    }

    /// Opens the ways to all partners and declares the streams that `me` sends or reads, each once for the life of the
    /// process.
    pub(crate) fn declare(&mut self, plan: &Plan, me: ParticipantId) -> Result<(), BusError> {
        self.streams = plan.streams.iter().map(|_| Vec::new()).collect();
        self.requests = plan.participants.iter().map(|_| None).collect();
        for partner in std::mem::take(&mut self.ticket.partners) {
            let config = config::partner(&self.ticket, &partner, plan)?;
            let bus = Bus::open(config, &format!("`{}`", self.ticket.name), &partner.endpoint)?;
            if let Some(other) = plan.participant(&partner.name) {
                self.declare_with(&bus, plan, me, other)?;
            }
            self.partners.push(bus);
        }
        Ok(())
    }

    fn declare_with(
        &mut self,
        bus: &Bus,
        plan: &Plan,
        me: ParticipantId,
        other: ParticipantId,
    ) -> Result<(), BusError> {
        let (mut gives, mut takes) = (false, false);
        for (id, stream) in plan.sent_by(me).filter(|(_, s)| s.to.contains(&other)) {
            self.streams[usize::from(id)].push(bus.publisher(self.keys.stream(&stream.key), Lane::Data)?);
            gives = true;
        }
        for (_, stream) in plan.read_by(me).filter(|(_, s)| s.from == other) {
            let post = self.post.clone();
            bus.subscribe(&self.keys.stream(&stream.key), move |p| post.send(Incoming::Data(p)))?;
            takes = true;
        }
        if gives {
            let post = self.post.clone();
            bus.subscribe(&self.keys.resend(plan.name_of(me)), move |p| post.send(Incoming::Resend(p)))?;
        }
        if takes {
            let request = bus.publisher(self.keys.resend(plan.name_of(other)), Lane::Control)?;
            self.requests[usize::from(other)] = Some(request);
        }
        Ok(())
    }

    /// Puts a frame on a stream, once per receiver. What was not declared is not this participant's to send, and is
    /// left out.
    pub(crate) fn publish(&self, stream: StreamId, frame: &Frame) -> Result<(), BusError> {
        let mut receivers = self.streams.get(usize::from(stream)).into_iter().flatten();
        receivers.try_for_each(|outlet| outlet.send_frame(frame))
    }

    /// Asks a participant to send something again.
    pub(crate) fn request(&self, from: ParticipantId, bytes: Vec<u8>) -> Result<(), BusError> {
        let outlet = self.requests.get(usize::from(from)).and_then(Option::as_ref);
        outlet.map_or(Ok(()), |outlet| outlet.send(bytes))
    }

    /// Leaves, publishers first: a session that is closed under them leaks.
    pub(crate) fn close(self) {
        let Self { bus, ack, presence, mut partners, streams, requests, .. } = self;
        drop((ack, streams, requests, presence));
        partners.push(bus);
        Bus::close_all(partners);
    }
}
