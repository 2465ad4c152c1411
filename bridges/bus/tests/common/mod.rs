//! A plan of two participants and the sessions to go with it.
#![allow(dead_code, reason = "each test file uses a part of it")]

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use cosplat_bus::{Bus, BusError, Door, JoinTicket, Keys, Mailbox, Partner, Payload, RunFolder, Spin};
use cosplat_bus::{config, introduce, mailbox, run_to_hex};
use cosplat_core::control::{FIRST_EPOCH, PROTOCOL, RunId};
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
        recorder: None,
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
    partners: Vec<Vec<Partner>>,
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
        let partners = introduce(&plan(), &folder).unwrap();
        Self { bus, keys, endpoint, folder, users, partners }
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
            partners: self.partners[usize::from(plan().participant(name).unwrap())].clone(),
            epoch: FIRST_EPOCH,
            checkpoints: None,
        }
    }

    /// Configuration of this one's side of the way to the other.
    pub(crate) fn way(&self, name: &str) -> zenoh::Config {
        let ticket = self.ticket(name);
        config::partner(&ticket, &ticket.partners[0], &plan()).unwrap()
    }

    /// Opens this one's side of the way to the other.
    pub(crate) fn meet(&self, name: &str) -> Bus {
        Bus::open(self.way(name), name, "the way between the two").unwrap()
    }

    /// What somebody needs who enters at `hard`'s as he would at the coordinator's, without `soft`'s manners.
    pub(crate) fn ticket_to_hard(&self) -> JoinTicket {
        let ticket = self.ticket("soft");
        let [Partner { endpoint, door: Door::Enter(password), .. }] = &ticket.partners[..] else {
            panic!("{ticket:?}")
        };
        JoinTicket { endpoint: endpoint.clone(), password: password.clone(), ..ticket.clone() }
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
