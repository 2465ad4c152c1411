//! Names: their pattern, that each is given once, and that every mention of one has a bearer.

use std::collections::BTreeMap;

use super::node::Origin;
use super::report::{Report, quoted, suggestion};
use super::value::At;

/// Longest name, in characters; names become parts of bus keys and file names.
const LONGEST: usize = 48;

/// What bears a name. Bodies and static colliders share one set of names, the others have their own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Kind {
    Body,
    Static,
    Solver,
    Link,
    Joint,
    Probe,
}

impl Kind {
    fn word(self) -> &'static str {
        match self {
            Self::Body => "body",
            Self::Static => "static collider",
            Self::Solver => "solver",
            Self::Link => "link",
            Self::Joint => "joint",
            Self::Probe => "probe",
        }
    }

    /// The set in which the name is unique.
    fn set(self) -> Self {
        if self == Self::Static { Self::Body } else { self }
    }
}

/// A name given.
pub(super) struct Declaration {
    kind: Kind,
    name: String,
    origin: Origin,
    path: String,
}

/// A name used.
pub(super) struct Mention {
    kinds: &'static [Kind],
    name: String,
    origin: Origin,
    path: String,
}

/// Reads a name and remembers what bears it.
pub(super) fn declare(at: &At<'_>, kind: Kind) -> String {
    let name = at.name();
    declare_key(&name, kind, &at.node.origin, &at.path, at.report);
    name
}

/// Remembers a name that is a key.
pub(super) fn declare_key(name: &str, kind: Kind, origin: &Origin, path: &str, report: &Report) {
    let declaration = Declaration { kind, name: name.to_owned(), origin: origin.clone(), path: path.to_owned() };
    report.declarations.borrow_mut().push(declaration);
}

/// Reads the name of something that must be elsewhere in the scene.
pub(super) fn mention(at: &At<'_>, kinds: &'static [Kind]) -> String {
    let name = at.text();
    let mention = Mention { kinds, name: name.clone(), origin: at.node.origin.clone(), path: at.path.clone() };
    at.report.mentions.borrow_mut().push(mention);
    name
}

/// Complains about a name that is too long or has other characters than `[a-z0-9_-]`.
pub(super) fn check_pattern(name: &str, origin: &Origin, path: &str, report: &Report) {
    let is_allowed = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_' || c == '-';
    if name.is_empty() || !name.chars().all(is_allowed) {
        let better: String = name
            .chars()
            .map(|c| if is_allowed(c.to_ascii_lowercase()) { c.to_ascii_lowercase() } else { '-' })
            .collect();
        let help = "names are made of `a` to `z`, `0` to `9`, `_` and `-`";
        let help = if better.is_empty() { help.to_owned() } else { format!("{help}, for example {}", quoted(&better)) };
        report.error(origin, path, format!("{} cannot be a name", quoted(name)), Some(help));
    } else if name.len() > LONGEST {
        let message = format!("the name {} has {} characters, at most {LONGEST} are allowed", quoted(name), name.len());
        report.error(origin, path, message, None);
    }
}

/// Complains about names given twice and names that nothing bears.
pub(super) fn check(report: &Report) {
    let declarations = report.declarations.borrow();
    let mut bearers: BTreeMap<(Kind, &str), &Declaration> = BTreeMap::new();
    for declared in declarations.iter().filter(|d| !d.name.is_empty()) {
        if let Some(first) = bearers.get(&(declared.kind.set(), declared.name.as_str())) {
            let owner = first.path.trim_end_matches(".name");
            let message = format!("the name {} is taken by `{owner}`", quoted(&declared.name));
            report.error(&declared.origin, &declared.path, message, None);
        } else {
            bearers.insert((declared.kind.set(), &declared.name), declared);
        }
    }
    for mention in report.mentions.borrow().iter().filter(|m| !m.name.is_empty()) {
        check_mention(mention, &declarations, report);
    }
}

fn check_mention(mention: &Mention, declarations: &[Declaration], report: &Report) {
    let mut candidates: Vec<&str> = Vec::new();
    let mut other = None;
    for declared in declarations {
        if mention.kinds.contains(&declared.kind) {
            candidates.push(&declared.name);
        } else if declared.name == mention.name {
            other = Some(declared.kind);
        }
    }
    if candidates.contains(&mention.name.as_str()) {
        return;
    }
    let words: Vec<&str> = mention.kinds.iter().map(|kind| kind.word()).collect();
    let words = words.join(" or ");
    let message = format!("there is no {words} named {}", quoted(&mention.name));
    let help = match other {
        Some(kind) => Some(format!("{} is a {}", quoted(&mention.name), kind.word())),
        None => suggestion(&mention.name, &candidates, "there are"),
    };
    report.absence(&mention.origin, &mention.path, message, help);
}
