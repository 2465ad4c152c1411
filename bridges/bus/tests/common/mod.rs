//! A plan of two participants and the sessions to go with it.
#![allow(dead_code, reason = "each test file uses a part of it")]

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use cosplat_bus::{Bus, Keys, Mailbox, Payload, RunFolder, Spin, config, mailbox, run_to_hex};
use cosplat_bus::{BusError, JoinTicket};
use cosplat_core::control::{PROTOCOL, RunId};
use cosplat_core::plan::{BoundaryForm, Content, Participant, Plan, Stream};
use cosplat_core::time::Clock;

pub(crate) const RUN: RunId = [0x5a; 16];
pub(crate) const FORM: BoundaryForm = BoundaryForm::SamplesF32 { normals: false };
/// Long enough for anything that will arrive at all.
pub(crate) const PATIENCE: Duration = Duration::from_secs(3);
/// After something else has arrived on the same way, what is still missing will not come.
pub(crate) const GRACE: Duration = Duration::from_millis(150);

pub(crate) fn participant(name: &str) -> Participant {
    Participant { name: name.to_owned(), plugin: name.to_owned(), bodies: vec![format!("{name}-body")], threads: 1 }
}

/// `soft` shows its boundary to `hard`.
pub(crate) fn plan() -> Plan {
    Plan {
        clock: Clock::new(0.1, 10),
        window_bound_by: "test".to_owned(),
        participants: vec![participant("hard"), participant("soft")],
        interfaces: Vec::new(),
        streams: vec![Stream {
            key: "b/soft/soft-body".to_owned(),
            from: 1,
            to: vec![0],
            content: Content::Boundary { body: "soft-body".to_owned(), form: FORM },
        }],
        left_out: Vec::new(),
        break_with: None,
    }
}

/// An open router with the rules of [`plan`].
pub(crate) struct Router {
    pub(crate) bus: Bus,
    pub(crate) keys: Keys,
    pub(crate) endpoint: String,
    pub(crate) folder: RunFolder,
    users: PathBuf,
}

impl Router {
    pub(crate) fn open(base: &Path) -> Self {
        Self::open_with(base, |_| {})
    }

    /// With a changed configuration, for control experiments.
    pub(crate) fn open_with(base: &Path, change: impl FnOnce(&mut zenoh::Config)) -> Self {
        let folder = RunFolder::below(base, &RUN).unwrap();
        let names = ["hard", "soft"].map(|n| (n.to_owned(), password_of(n)));
        let users = folder.write_users(&names).unwrap();
        let keys = Keys::new(&RUN);
        let endpoint = folder.endpoint();
        let mut config = config::coordinator(&plan(), &keys, &endpoint, &users).unwrap();
        change(&mut config);
        let bus = Bus::open(config, "router", &endpoint).unwrap();
        Self { bus, keys, endpoint, folder, users }
    }

    pub(crate) fn ticket(&self, name: &str) -> JoinTicket {
        JoinTicket {
            protocol: PROTOCOL,
            run: run_to_hex(&RUN),
            name: name.to_owned(),
            endpoint: self.endpoint.clone(),
            user: name.to_owned(),
            password: password_of(name),
            threads: 1,
        }
    }

    pub(crate) fn join(&self, name: &str) -> Bus {
        enter(&self.ticket(name)).unwrap()
    }

    pub(crate) fn hear(&self, key: &str) -> Mailbox<Payload> {
        hear(&self.bus, key)
    }
}

pub(crate) fn password_of(name: &str) -> String {
    format!("password-of-{name}")
}

pub(crate) fn enter(ticket: &JoinTicket) -> Result<Bus, BusError> {
    Bus::open(config::participant(ticket, Duration::from_millis(700))?, &ticket.name, &ticket.endpoint)
}

pub(crate) fn hear(bus: &Bus, key: &str) -> Mailbox<Payload> {
    let (post, mailbox) = mailbox(Spin::default());
    bus.subscribe(key, move |p| post.send(p)).unwrap();
    mailbox
}

pub(crate) fn next(mailbox: &mut Mailbox<Payload>, patience: Duration) -> Option<Vec<u8>> {
    mailbox.receive_until(Instant::now() + patience).map(Payload::into_vec)
}

/// Says the same until it is heard: declarations travel in their own time.
pub(crate) fn say_until_heard(say: impl Fn(), mailbox: &mut Mailbox<Payload>) -> Vec<u8> {
    let start = Instant::now();
    while start.elapsed() < PATIENCE {
        say();
        if let Some(heard) = next(mailbox, Duration::from_millis(20)) {
            return heard;
        }
    }
    panic!("nothing heard within {PATIENCE:?}");
}
