//! `[solver.NAME]`.

use std::collections::BTreeMap;

use serde_json::{Map, Value as Json};

use super::fields::Fields;
use super::names::{self, Kind};
use super::node::{Origin, Value};
use super::report::Report;
use super::value::At;
use crate::scene::model::SolverSpec;

/// Names of processes that are no solvers.
const RESERVED: [&str; 3] = ["coordinator", "recorder", "viewer"];

/// All solver sections.
pub(super) fn solvers(root: &Fields<'_>) -> BTreeMap<String, SolverSpec> {
    let mut solvers = BTreeMap::new();
    root.named("solver", |name, origin, fields| {
        names::check_pattern(name, origin, &fields.path, fields.report);
        names::declare_key(name, Kind::Solver, origin, &fields.path, fields.report);
        check_free(name, origin, &fields.path, fields.report);
        solvers.insert(name.to_owned(), solver(fields));
    });
    solvers
}

/// Complains about a solver with the name of another participant.
pub(super) fn check_free(name: &str, origin: &Origin, path: &str, report: &Report) {
    if RESERVED.contains(&name) {
        report.error(origin, path, format!("`{name}` is not free: cosplat uses it itself"), None);
    }
}

fn solver(fields: &Fields<'_>) -> SolverSpec {
    SolverSpec {
        plugin: fields.opt("plugin", |at| at.name()),
        command: fields.opt("command", |at| command(&at)),
        params: fields.opt("params", |at| params(&at)).unwrap_or_default(),
    }
}

fn command(at: &At<'_>) -> Vec<String> {
    let words = at.items();
    if words.is_empty() && matches!(at.node.value, Value::List(_)) {
        at.error(
            "`command` is empty".to_owned(),
            Some("the program comes first, as in [\"python3\", \"x.py\"]".to_owned()),
        );
    }
    words.iter().map(At::text).collect()
}

fn params(at: &At<'_>) -> Map<String, Json> {
    match at.as_table().map(|_| json(at)) {
        Some(Json::Object(map)) => map,
        _ => Map::new(),
    }
}

/// The value as JSON; the plugin's own schema checks it.
fn json(at: &At<'_>) -> Json {
    match &at.node.value {
        Value::Text(text) | Value::Date(text) => Json::String(text.clone()),
        Value::Flag(flag) => Json::Bool(*flag),
        Value::Number { value, is_integer: true } if value.abs() < 2.0_f64.powi(53) => Json::from(*value as i64),
        Value::Number { value, .. } => {
            if !value.is_finite() {
                at.must_be("a finite number", None);
            }
            Json::from(*value)
        }
        Value::List(_) => Json::Array(at.items().iter().map(json).collect()),
        Value::Table(table) => {
            let member = |(key, entry): (&String, &super::node::Entry)| {
                let item = At { node: &entry.node, path: format!("{}.{key}", at.path), report: at.report };
                (key.clone(), json(&item))
            };
            Json::Object(table.0.iter().map(member).collect())
        }
    }
}
