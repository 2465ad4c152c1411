//! `--set path=value`: replaces values of the parsed file before it is read.

use std::rc::Rc;

use toml::de::DeValue;

use super::node::{Entry, Node, Origin, Table, Value};
use super::report::{Report, quoted, suggestion};
use crate::scene::diagnostic::Diagnostic;

/// Deepest path; scene files have fewer levels.
const DEEPEST: usize = 16;

/// Applies the overrides in their order.
pub(super) fn apply(table: &mut Table, overrides: &[String], report: &Report) {
    for assignment in overrides {
        if let Err((message, help)) = apply_one(table, assignment) {
            let message = format!("override {}: {message}", quoted(assignment));
            report.push(Diagnostic { help, ..Diagnostic::error(message) });
        }
    }
}

/// What is wrong with an override, and what would help.
type Problem = (String, Option<String>);

fn apply_one(table: &mut Table, assignment: &str) -> Result<(), Problem> {
    let shape = || Some("write it as path=value, as in clock.window=0.005".to_owned());
    let (path, value) = assignment.split_once('=').ok_or_else(|| ("there is no `=`".to_owned(), shape()))?;
    let keys: Vec<&str> = path.trim().split('.').collect();
    if keys.iter().any(|key| key.is_empty()) || keys.len() > DEEPEST {
        return Err((format!("{} is no path", quoted(path.trim())), shape()));
    }
    let origin: Rc<str> = assignment.into();
    let node = parse_value(value.trim(), &origin)?;
    assign(table, &keys, node, &origin)
}

/// The value as TOML; what is no TOML but a plain word is a string, so that a shell needs no second quotes.
fn parse_value(text: &str, origin: &Rc<str>) -> Result<Node, Problem> {
    match DeValue::parse(text) {
        Ok(value) => Ok(Node::from_override(&value, origin)),
        Err(_) if !text.is_empty() && !text.contains(['"', '\'', '[', ']', '{', '}', '\n']) => {
            Ok(Node { value: Value::Text(text.to_owned()), origin: Origin::Override(origin.clone()) })
        }
        Err(error) => Err((format!("the value cannot be read: {}", error.message().trim()), None)),
    }
}

fn assign(table: &mut Table, keys: &[&str], node: Node, origin: &Rc<str>) -> Result<(), Problem> {
    let Some((key, rest)) = keys.split_first() else { return Ok(()) };
    let made_here = || Origin::Override(origin.clone());
    if rest.is_empty() {
        table.0.insert((*key).to_owned(), Entry { key: made_here(), node });
        return Ok(());
    }
    let entry = table.0.entry((*key).to_owned()).or_insert_with(|| Entry {
        key: made_here(),
        node: Node { value: Value::Table(Table::default()), origin: made_here() },
    });
    match &mut entry.node.value {
        Value::Table(inner) => assign(inner, rest, node, origin),
        Value::List(items) => assign_item(items, key, rest, node, origin),
        other => Err((format!("`{key}` is {}, so nothing can be set below it", other.type_name()), None)),
    }
}

/// Goes into the item with a name or at an index.
fn assign_item(items: &mut [Node], list: &str, keys: &[&str], node: Node, origin: &Rc<str>) -> Result<(), Problem> {
    let Some((key, rest)) = keys.split_first() else { return Ok(()) };
    let index = items.iter().position(|item| name_of(item) == Some(*key)).or_else(|| key.parse().ok());
    match index.and_then(|index| items.get_mut(index)) {
        None => {
            let names: Vec<&str> = items.iter().filter_map(name_of).collect();
            let help = suggestion(key, &names, "there are");
            Err((format!("`{list}` has no member {}", quoted(key)), help))
        }
        Some(item) if rest.is_empty() => {
            *item = node;
            Ok(())
        }
        Some(Node { value: Value::Table(inner), .. }) => assign(inner, rest, node, origin),
        Some(Node { value: Value::List(items), .. }) => assign_item(items, key, rest, node, origin),
        Some(other) => Err((format!("`{list}.{key}` is {}", other.value.type_name()), None)),
    }
}

fn name_of(node: &Node) -> Option<&str> {
    let Value::Table(table) = &node.value else { return None };
    match &table.0.get("name")?.node.value {
        Value::Text(name) => Some(name),
        _ => None,
    }
}
