//! `[[link]]` and `[[joint]]`.

use super::fields::Fields;
use super::limits::Limits;
use super::names::{self, Kind};
use super::report::quoted;
use super::value::At;
use crate::scene::model::{Joint, JointKind, Link};

const POSITION: Limits = Limits::any("m");

/// One `[[link]]`.
pub(super) fn link(fields: &Fields<'_>) -> Option<Link> {
    let name = fields.must("name", |at| names::declare(&at, Kind::Link));
    let (a, b) = ends(fields);
    if let (Some(_), Some(at)) = (&b, fields.get("anchor")) {
        at.error("`anchor` is for links to the world, but this one has `b`".to_owned(), None);
    }
    let first = fields.opt("first", |at| first(&at, &a, b.as_deref()));
    let anchor_m = fields.vec3_or_zero("anchor", POSITION);
    let stiffness_n_m = fields.num("stiffness", Limits::not_negative("N/m"));
    let damping_n_s_m = fields.num_or("damping", 0.0, Limits::not_negative("N s/m"));
    let rest_m = fields.vec3_or_zero("rest", POSITION);
    // All keys are read before this may end: one that was not would be called unknown.
    Some(Link { name: name?, anchor_m, stiffness_n_m, damping_n_s_m, rest_m, first, a, b })
}

/// The two bodies; without `b` the other end is the world.
fn ends(fields: &Fields<'_>) -> (String, Option<String>) {
    let a = fields.must("a", |at| names::mention(&at, &[Kind::Body])).unwrap_or_default();
    let b = fields.opt("b", |at| names::mention(&at, &[Kind::Body]));
    if b.as_ref().is_some_and(|b| *b == a && !a.is_empty()) {
        fields.error(format!("both ends are {}", quoted(&a)), None);
    }
    (a, b)
}

fn first(at: &At<'_>, a: &str, b: Option<&str>) -> String {
    let name = at.text();
    if !name.is_empty() && name != a && Some(name.as_str()) != b {
        let help = format!("it is `a` or `b` of the link: {} or {}", quoted(a), b.map_or("none".to_owned(), quoted));
        at.error(format!("`first` cannot be {}", quoted(&name)), Some(help));
    }
    name
}

/// One `[[joint]]`.
pub(super) fn joint(fields: &Fields<'_>) -> Option<Joint> {
    let name = fields.must("name", |at| names::declare(&at, Kind::Joint));
    let kind = fields.must("kind", |at| {
        at.word(&[("prismatic", JointKind::Prismatic), ("ball", JointKind::Ball), ("fixed", JointKind::Fixed)])
    });
    let (a, b) = ends(fields);
    let kind = kind.flatten();
    let axis = match kind {
        Some(JointKind::Prismatic) => fields.must("axis", |at| at.direction()),
        _ => fields.opt("axis", |at| {
            if kind.is_some() {
                at.error("only a `prismatic` joint has an `axis`".to_owned(), None);
            }
            at.direction()
        }),
    };
    let (spring, damper) = match kind {
        Some(JointKind::Ball) => ("N m/rad", "N m s/rad"),
        _ => ("N/m", "N s/m"),
    };
    for key in ["stiffness", "damping"] {
        if let (Some(JointKind::Fixed), Some(at)) = (kind, fields.get(key)) {
            at.error(format!("a `fixed` joint has no `{key}`: nothing is free"), None);
        }
    }
    let anchor_m = match kind {
        Some(JointKind::Ball) => fields.vec3("anchor", POSITION),
        _ => fields.vec3_or_zero("anchor", POSITION),
    };
    let stiffness = fields.num_or("stiffness", 0.0, Limits::not_negative(spring));
    let damping = fields.num_or("damping", 0.0, Limits::not_negative(damper));
    let axis = axis.unwrap_or([0.0, 0.0, 1.0]);
    Some(Joint { name: name?, kind: kind?, a, b, anchor_m, axis, stiffness, damping })
}
