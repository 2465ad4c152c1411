//! The access list of a run, made from its plan: what is not named here does not pass the coordinator's router.
//!
//! Directions are the router's: *ingress* is what a participant sends. Each participant is a subject of its own, known
//! by the user name with which it was let in, so that the key of a message proves who sent it.

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

/// Keys that a participant may use.
struct Grants {
    put: Vec<String>,
    hear: Vec<String>,
    live: String,
}

fn grants(plan: &Plan, keys: &Keys, id: ParticipantId) -> Grants {
    let name = plan.name_of(id);
    let mut put = vec![keys.ack(name)];
    put.extend(plan.sent_by(id).map(|(_, s)| keys.stream(&s.key)));
    let mut hear = vec![keys.ctl(name), keys.resend(name)];
    hear.extend(plan.read_by(id).map(|(_, s)| keys.stream(&s.key)));
    let mut asked: Vec<ParticipantId> = plan.read_by(id).map(|(_, s)| s.from).collect();
    asked.sort_unstable();
    asked.dedup();
    put.extend(asked.iter().map(|&q| keys.resend(plan.name_of(q))));
    Grants { put, hear, live: keys.live(name) }
}

/// The `access_control` section.
///
/// # Errors
/// [`BusError::Name`] for names that could change the meaning of a rule.
pub(crate) fn access_control(plan: &Plan, keys: &Keys) -> Result<Value, BusError> {
    let (mut rules, mut subjects, mut policies) = (Vec::new(), Vec::new(), Vec::new());
    for stream in &plan.streams {
        check_stream(&stream.key)?;
    }
    for (id, participant) in plan.participants.iter().enumerate() {
        let name = &participant.name;
        check_name(name)?;
        let may = grants(plan, keys, id as ParticipantId);
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
        allow("is-there", &["liveliness_token"], "ingress", std::slice::from_ref(&may.live));
        allow("hears", &["put"], "egress", &may.hear);
        // A participant does not send what it knows nobody listens to, so it must be told of its own listeners.
        allow("is-heard", &["declare_subscriber"], "egress", &may.put);
        subjects.push(json!({ "id": name, "usernames": [name], "link_protocols": ["unixsock-stream"] }));
        policies.push(json!({ "rules": names, "subjects": [name] }));
    }
    Ok(json!({
        "enabled": true, "default_permission": "deny", "rules": rules, "subjects": subjects, "policies": policies
    }))
}

/// The `low_pass_filter` section: what is larger than any honest message is dropped at the door.
pub(crate) fn size_limits(plan: &Plan, keys: &Keys) -> Value {
    let limit = |id: &str, key_exprs: Vec<String>, bytes: usize| {
        let (messages, flows) = (["put"], ["ingress"]);
        json!({ "id": id, "messages": messages, "flows": flows, "key_exprs": key_exprs, "size_limit": bytes })
    };
    let mut limits = vec![
        limit("ack", vec![keys.ack("*")], MAX_ACK_BYTES),
        limit("resend", vec![keys.resend("*")], MAX_RESEND_BYTES),
    ];
    if !plan.streams.is_empty() {
        let streams = plan.streams.iter().map(|s| keys.stream(&s.key)).collect();
        limits.push(limit("streams", streams, MAX_FRAME_BYTES));
    }
    Value::Array(limits)
}
