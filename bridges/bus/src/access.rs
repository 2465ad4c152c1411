//! The access lists of a run, made from its plan: what is not named here passes no door.
//!
//! Directions are those of the side that applies the list: *ingress* is what the other one sends. At the coordinator's
//! each participant is a subject of its own, known by the user name with which it was let in; between two partners
//! nobody else is there. Either way the key of a message proves who sent it.

use cosplat_core::plan::{ParticipantId, Plan};
use serde_json::{Value, json};

use crate::error::BusError;
use crate::keys::{Keys, check_name, check_stream};

/// Largest frame: a chunk and its header, with room to spare.
const MAX_FRAME_BYTES: usize = (1 << 20) + 4096;
/// Largest message to the coordinator: a descriptor, or a report on many bodies.
const MAX_ACK_BYTES: usize = 8 << 20;
/// Largest request to send something again.
const MAX_RESEND_BYTES: usize = 4096;

/// Keys that somebody may use at the door of somebody else.
struct Grants {
    put: Vec<String>,
    hear: Vec<String>,
    live: Option<String>,
}

/// What a participant may at the coordinator's.
fn control_grants(plan: &Plan, keys: &Keys, id: ParticipantId) -> Grants {
    let name = plan.name_of(id);
    Grants { put: vec![keys.ack(name)], hear: vec![keys.ctl(name)], live: Some(keys.live(name)) }
}

/// What a participant may at `host`'s: the streams from one to the other, and to ask for them again.
fn data_grants(plan: &Plan, keys: &Keys, host: ParticipantId, guest: ParticipantId) -> Grants {
    let way = |from: ParticipantId, to: ParticipantId| -> Vec<String> {
        plan.sent_by(from).filter(|(_, s)| s.to.contains(&to)).map(|(_, s)| keys.stream(&s.key)).collect()
    };
    let (mut put, mut hear) = (way(guest, host), way(host, guest));
    let asks = |streams: &[String], whom: ParticipantId| (!streams.is_empty()).then(|| keys.resend(plan.name_of(whom)));
    let (heard_here, heard_there) = (asks(&hear, host), asks(&put, guest));
    put.extend(heard_here);
    hear.extend(heard_there);
    Grants { put, hear, live: None }
}

/// Whoever is known by `user` (everybody, if there is no name) may what the grants say, and nothing else.
fn access_list(plan: &Plan, guests: Vec<(&str, Option<&str>, Grants)>) -> Result<Value, BusError> {
    let (mut rules, mut subjects, mut policies) = (Vec::new(), Vec::new(), Vec::new());
    for stream in &plan.streams {
        check_stream(&stream.key)?;
    }
    for (name, user, may) in guests {
        check_name(name)?;
        let mut names = Vec::new();
        let mut allow = |what: &str, messages: &[&str], flow: &str, key_exprs: &[String]| {
            let rule = format!("{name}:{what}");
            rules.push(json!({
                "id": rule, "permission": "allow", "messages": messages, "flows": [flow], "key_exprs": key_exprs
            }));
            names.push(rule);
        };
        allow("says", &["put"], "ingress", &may.put);
        allow("listens", &["declare_subscriber"], "ingress", &may.hear);
        if let Some(live) = &may.live {
            allow("is-there", &["liveliness_token"], "ingress", std::slice::from_ref(live));
        }
        allow("hears", &["put"], "egress", &may.hear);
        // Nobody sends what he knows nobody listens to, so he must be told of his own listeners.
        allow("is-heard", &["declare_subscriber"], "egress", &may.put);
        let mut subject = json!({ "id": name, "link_protocols": ["unixsock-stream"] });
        if let Some(user) = user {
            subject["usernames"] = json!([user]);
        }
        subjects.push(subject);
        policies.push(json!({ "rules": names, "subjects": [name] }));
    }
    Ok(json!({
        "enabled": true, "default_permission": "deny", "rules": rules, "subjects": subjects, "policies": policies
    }))
}

/// The coordinator's `access_control` section: control only, data has no way through it.
///
/// # Errors
/// [`BusError::Name`] for names that could change the meaning of a rule.
pub(crate) fn control_access(plan: &Plan, keys: &Keys) -> Result<Value, BusError> {
    let names = plan.participants.iter().map(|p| p.name.as_str()).zip(0..);
    access_list(plan, names.map(|(name, id)| (name, Some(name), control_grants(plan, keys, id))).collect())
}

/// The `access_control` section of `host`'s side of the way between it and `guest`.
///
/// The side that enters knows no user name of the other: whoever holds the socket in the run's folder is the one, and
/// nobody else is on this bus of two.
///
/// # Errors
/// [`BusError::Name`] for names that could change the meaning of a rule.
pub(crate) fn data_access(
    plan: &Plan,
    keys: &Keys,
    host: ParticipantId,
    guest: ParticipantId,
    listens: bool,
) -> Result<Value, BusError> {
    let name = plan.name_of(guest);
    access_list(plan, vec![(name, listens.then_some(name), data_grants(plan, keys, host, guest))])
}

fn limit(id: &str, key_exprs: &[String], bytes: usize) -> Value {
    let (messages, flows) = (["put"], ["ingress"]);
    json!({ "id": id, "messages": messages, "flows": flows, "key_exprs": key_exprs, "size_limit": bytes })
}

/// The coordinator's `low_pass_filter` section: what is larger than any honest message is dropped at the door.
pub(crate) fn control_limits(keys: &Keys) -> Value {
    Value::Array(vec![limit("ack", &[keys.ack("*")], MAX_ACK_BYTES)])
}

/// The `low_pass_filter` section between partners.
pub(crate) fn data_limits(plan: &Plan, keys: &Keys) -> Value {
    let streams: Vec<String> = plan.streams.iter().map(|s| keys.stream(&s.key)).collect();
    let resend = limit("resend", &[keys.resend("*")], MAX_RESEND_BYTES);
    Value::Array(vec![resend, limit("streams", &streams, MAX_FRAME_BYTES)])
}
