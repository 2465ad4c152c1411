//! Nobody gets in, or says anything, who should not. On the real zenoh, because all of this is its doing.
#![allow(clippy::unwrap_used, reason = "helpers outside of test functions")]

mod common;

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::time::Duration;

use common::{GRACE, PATIENCE, Router, enter, next, say_until_heard};
use cosplat_bus::{Bus, JoinTicket, Keys, Lane, Mailbox, Payload, config};
use cosplat_core::plan::Plan;
use zenoh::Wait;

fn temp() -> tempfile::TempDir {
    tempfile::tempdir_in("/tmp").unwrap()
}

#[test]
fn a_wrong_password_a_stranger_and_no_password_are_refused() {
    let base = temp();
    let router = Router::open(base.path());
    only_with_its_own_password(&router.ticket("soft"));
    let hard = router.meet("hard");
    only_with_its_own_password(&router.ticket_to_hard());
    let coordinators = JoinTicket { password: router.ticket("soft").password, ..router.ticket_to_hard() };
    enter(&coordinators).expect_err("another door, another password");
    hard.close();
}

fn only_with_its_own_password(right: &JoinTicket) {
    for ticket in [
        JoinTicket { password: "guess".to_owned(), ..right.clone() },
        JoinTicket { user: "hard".to_owned(), ..right.clone() },
        JoinTicket { user: "mallory".to_owned(), ..right.clone() },
        JoinTicket { password: String::new(), ..right.clone() },
    ] {
        let error = enter(&ticket).expect_err("should not be let in");
        assert!(error.to_string().contains("soft"), "{error}");
    }
    enter(right).unwrap().close();
}

/// What `soft` says on `key` to the coordinator, which listens to everything.
fn heard_from_soft(router: &Router, key: &str) -> Option<Vec<u8>> {
    heard(router.hear("**"), &router.ticket("soft"), &router.keys.ack("soft"), key)
}

/// What the holder of `ticket` says on `key` to somebody who listens to `all` and surely hears `may`.
fn heard(mut all: Mailbox<Payload>, ticket: &JoinTicket, may: &str, key: &str) -> Option<Vec<u8>> {
    // Without a declared publisher nothing is held back by the sender, as a hostile one would not.
    let soft = zenoh::open(config::participant(ticket, PATIENCE).unwrap()).wait().unwrap();
    say_until_heard(|| soft.put(may, b"mine").wait().unwrap(), &mut all);
    soft.put(key, b"not mine").wait().unwrap();
    // On the same way and behind it.
    soft.put(may, b"last").wait().unwrap();
    let heard: Vec<Vec<u8>> = std::iter::from_fn(|| next(&mut all, GRACE)).collect();
    assert!(heard.iter().any(|said| said == b"last"));
    soft.close().wait().unwrap();
    heard.into_iter().find(|said| said == b"not mine")
}

#[test]
fn a_participant_can_put_on_its_own_keys_only() {
    let base = temp();
    let router = Router::open(base.path());
    let other_run = Keys::new(&[0x11; 16]);
    for key in [
        router.keys.ack("hard"),
        router.keys.ctl("hard"),
        router.keys.ctl("soft"),
        router.keys.resend("hard"),
        router.keys.resend("soft"),
        router.keys.stream("b/hard/hard-body"),
        router.keys.stream("b/soft/soft-body"),
        router.keys.stream("b/soft/another-body"),
        other_run.ack("soft"),
        "anything/else".to_owned(),
    ] {
        assert_eq!(heard_from_soft(&router, &key), None, "{key}");
    }
}

/// Nothing but the streams of the plan and requests for them passes between partners.
#[test]
fn a_partner_can_put_on_its_own_streams_only() {
    let base = temp();
    let router = Router::open(base.path());
    let may = router.keys.stream("b/soft/soft-body");
    let attempt = |hard: &Bus, key: &str| heard(common::hear(hard, "**"), &router.ticket_to_hard(), &may, key);
    let hard = router.meet("hard");
    let other_run = Keys::new(&[0x11; 16]);
    for key in [
        router.keys.stream("b/hard/hard-body"),
        router.keys.stream("b/soft/another-body"),
        router.keys.stream("imp/soft/hard/0"),
        // `hard` gives nothing that could be asked for again.
        router.keys.resend("hard"),
        router.keys.resend("soft"),
        router.keys.ack("soft"),
        router.keys.ctl("hard"),
        other_run.stream("b/soft/soft-body"),
        "anything/else".to_owned(),
    ] {
        assert_eq!(attempt(&hard, &key), None, "{key}");
    }
    hard.close();
    let mut open = router.way("hard");
    open.insert_json5("access_control/enabled", "false").unwrap();
    let hard = Bus::open(open, "hard", "its door").unwrap();
    let key = router.keys.ctl("hard");
    assert!(attempt(&hard, &key).is_some(), "without the rules the same attempt succeeds");
    hard.close();
}

/// The partner that enters is as closed as the one that listens.
#[test]
fn a_listening_partner_reaches_requests_only() {
    let base = temp();
    let router = Router::open(base.path());
    let soft = router.meet("soft");
    let mut asked = common::hear(&soft, &router.keys.resend("soft"));
    let mut foreign = [router.keys.ctl("soft"), router.keys.stream("b/hard/hard-body"), router.keys.resend("hard")]
        .map(|key| (common::hear(&soft, &key), key));
    let mut careless = router.way("hard");
    careless.insert_json5("access_control/enabled", "false").unwrap();
    let hard = zenoh::open(careless).wait().unwrap();
    let own = router.keys.resend("soft");
    let all = || {
        for (_, key) in &foreign {
            hard.put(key, b"not to be heard").wait().unwrap();
        }
        hard.put(&own, b"again").wait().unwrap();
    };
    assert_eq!(say_until_heard(all, &mut asked), b"again");
    for (mailbox, key) in &mut foreign {
        assert_eq!(next(mailbox, GRACE), None, "{key}");
    }
    soft.close();
    hard.close().wait().unwrap();
}

/// What is said between partners stays between them, whatever a third one asks for.
#[test]
fn data_does_not_reach_the_coordinator() {
    let base = temp();
    let router = Router::open(base.path());
    let (mut all, stream) = (router.hear("**"), router.keys.stream("b/soft/soft-body"));
    let (hard, soft) = (router.meet("hard"), router.meet("soft"));
    let (control, ack) = (router.join("soft"), router.keys.ack("soft"));
    let mut told = router.hear(&ack);
    let mut read = common::hear(&hard, &stream);
    let send = soft.publisher(stream, Lane::Data).unwrap();
    say_until_heard(|| send.send(b"data".to_vec()).unwrap(), &mut read);
    let ack = control.publisher(ack, Lane::Control).unwrap();
    say_until_heard(|| ack.send(b"control".to_vec()).unwrap(), &mut told);
    assert_eq!(next(&mut all, GRACE).as_deref(), Some(&b"control"[..]));
    while let Some(heard) = next(&mut all, GRACE) {
        assert_eq!(heard, b"control");
    }
    drop((send, ack));
    [hard, soft, control].into_iter().for_each(Bus::close);
}

/// Without the rules the same attempts succeed, so it is the rules that stop them.
#[test]
fn without_the_rules_the_same_attempts_succeed() {
    let base = temp();
    let router = Router::open_with(base.path(), |c| c.insert_json5("access_control/enabled", "false").unwrap());
    for key in [router.keys.ack("hard"), Keys::new(&[0x11; 16]).ack("soft")] {
        assert!(heard_from_soft(&router, &key).is_some(), "{key}");
    }
}

#[test]
fn a_participant_hears_its_own_keys_only() {
    let base = temp();
    let router = Router::open(base.path());
    let soft = router.join("soft");
    let mut own = common::hear(&soft, &router.keys.ctl("soft"));
    let mut foreign = [router.keys.ctl("hard"), router.keys.ack("hard"), router.keys.ctl("*"), "**".to_owned()]
        .map(|key| common::hear(&soft, &key));
    let to_hard = router.bus.publisher(router.keys.ctl("hard"), Lane::Control).unwrap();
    let to_soft = router.bus.publisher(router.keys.ctl("soft"), Lane::Control).unwrap();
    let both = || {
        to_hard.send(b"for hard".to_vec()).unwrap();
        to_soft.send(b"for soft".to_vec()).unwrap();
    };
    assert_eq!(say_until_heard(both, &mut own), b"for soft");
    for mailbox in &mut foreign {
        // A wider subscription of its own hears what passes anyway, which is its own key.
        while let Some(heard) = next(mailbox, GRACE) {
            assert_eq!(heard, b"for soft");
        }
    }
    drop((to_hard, to_soft));
    soft.close();
}

/// Inodes of this process's sockets that the kernel lists in `table` with `state` (any, when `None`).
fn own_sockets(table: &str, state: Option<&str>) -> Vec<String> {
    let own: Vec<String> = fs::read_dir("/proc/self/fd")
        .unwrap()
        .flatten()
        .filter_map(|e| {
            fs::read_link(e.path()).ok()?.to_str()?.strip_prefix("socket:[")?.strip_suffix(']').map(str::to_owned)
        })
        .collect();
    let listed = fs::read_to_string(format!("/proc/net/{table}")).unwrap_or_default();
    listed
        .lines()
        .skip(1)
        .map(|line| line.split_whitespace().collect::<Vec<_>>())
        .filter(|f| f.len() > 9 && state.is_none_or(|s| f[3] == s) && own.iter().any(|inode| inode == f[9]))
        .map(|f| f[1].to_owned())
        .collect()
}

#[test]
fn only_the_unix_socket_listens_and_only_its_owner_reaches_it() {
    const LISTEN: &str = "0A";
    let base = temp();
    let router = Router::open(base.path());
    let soft = router.join("soft");
    let partners = [router.meet("hard"), router.meet("soft")];
    for table in ["tcp", "tcp6"] {
        assert_eq!(own_sockets(table, Some(LISTEN)), Vec::<String>::new(), "{table}");
    }
    for table in ["udp", "udp6"] {
        assert_eq!(own_sockets(table, None), Vec::<String>::new(), "{table}");
    }
    // The probe itself works.
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    assert_eq!(own_sockets("tcp", Some(LISTEN)).len(), 1);
    drop(listener);
    let mode = |p: &std::path::Path| fs::metadata(p).unwrap().permissions().mode() & 0o777;
    assert_eq!(mode(router.folder.path()), 0o700);
    assert!(router.folder.path().join("0-1").exists(), "the socket of the two");
    for list in ["users", "0-1.users"] {
        assert_eq!(mode(&router.folder.path().join(list)), 0o600);
    }
    soft.close();
    partners.into_iter().for_each(Bus::close);
}

#[test]
fn what_is_larger_than_any_honest_message_is_dropped_and_the_session_survives() {
    let base = temp();
    let router = Router::open(base.path());
    let soft = router.meet("soft");
    let hard = router.meet("hard");
    let stream = router.keys.stream("b/soft/soft-body");
    let mut read = common::hear(&hard, &stream);
    let send = soft.publisher(stream, Lane::Data).unwrap();
    say_until_heard(|| send.send(b"small".to_vec()).unwrap(), &mut read);
    while next(&mut read, GRACE).is_some() {}
    send.send(vec![1; 2 << 20]).unwrap();
    send.send(vec![2; 1 << 20]).unwrap();
    let heard = next(&mut read, Duration::from_secs(2)).expect("a full chunk passes");
    assert!(heard.len() == 1 << 20 && heard[0] == 2);
    drop(send);
    soft.close();
    hard.close();
}

#[test]
fn nothing_stays_after_closing() {
    let base = temp();
    let router = Router::open(base.path());
    let soft = router.join("soft");
    let partners = [router.meet("hard"), router.meet("soft")];
    let Router { bus, folder, .. } = router;
    let path = folder.path().to_owned();
    assert!(path.join("bus.sock").exists() && path.join("0-1").exists());
    soft.close();
    partners.into_iter().for_each(Bus::close);
    bus.close();
    assert!(!path.join("bus.sock").exists() && !path.join("0-1").exists(), "zenoh removes its sockets");
    drop(folder);
    assert_eq!(fs::read_dir(base.path()).unwrap().count(), 0);
}

#[test]
fn a_plan_with_a_name_that_would_change_a_rule_is_refused() {
    let mut plan = common::plan();
    plan.streams[0].key = "b/*/x".to_owned();
    let keys = Keys::new(&common::RUN);
    let refuse = |plan: &Plan| config::coordinator(plan, &keys, "unixsock-stream//tmp/x", "/tmp/u".as_ref());
    assert!(refuse(&plan).is_err());
    let mut plan = common::plan();
    plan.participants[0].name = "a:b".to_owned();
    assert!(refuse(&plan).is_err());
    plan.participants.clear();
    plan.streams.clear();
    assert!(refuse(&plan).is_err(), "without users zenoh lets everybody in");
}

#[test]
fn a_dead_endpoint_is_an_error_within_the_patience() {
    let base = temp();
    let ticket = Router::open(base.path()).ticket("soft");
    let start = std::time::Instant::now();
    assert!(enter(&ticket).is_err());
    assert!(start.elapsed() < Duration::from_secs(3));
}

#[test]
fn three_megabytes_arrive_intact() {
    let base = temp();
    let router = Router::open(base.path());
    let soft: Bus = router.join("soft");
    let mut own = common::hear(&soft, &router.keys.ctl("soft"));
    let mut up = router.hear(&router.keys.ack("soft"));
    let down = router.bus.publisher(router.keys.ctl("soft"), Lane::Control).unwrap();
    let ack = soft.publisher(router.keys.ack("soft"), Lane::Control).unwrap();
    let big: Vec<u8> = (0..3_000_000_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
    assert!(say_until_heard(|| down.send(big.clone()).unwrap(), &mut own) == big);
    assert!(say_until_heard(|| ack.send(big.clone()).unwrap(), &mut up) == big);
    drop((down, ack));
    soft.close();
}
