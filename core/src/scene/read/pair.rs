//! `[[pair]]`, and frictions wherever they stand.

use std::collections::BTreeSet;

use super::fields::Fields;
use super::limits::{Limits, number};
use super::names::{self, Kind};
use super::report::quoted;
use crate::scene::model::{ContactLaw, PairSpec, Scene};
use crate::scene::pair::PairDefaults;

const FRICTION: Limits = Limits::not_negative("");
/// Both sides of a pair.
const TOUCHABLE: &[Kind] = &[Kind::Body, Kind::Static];

/// All `[[pair]]`s; what they leave open comes from the bodies of `scene`.
pub(super) fn pairs(root: &Fields<'_>, scene: &Scene) -> Vec<PairSpec> {
    let mut seen = BTreeSet::new();
    root.tables("pair", |fields| {
        let a = fields.must("a", |at| names::mention(&at, TOUCHABLE));
        let b = fields.must("b", |at| names::mention(&at, TOUCHABLE));
        let (a, b) = (a.unwrap_or_default(), b.unwrap_or_default());
        check_sides(fields, scene, [&a, &b]);
        let is_new = seen.insert(if a < b { (a.clone(), b.clone()) } else { (b.clone(), a.clone()) });
        if !is_new && !a.is_empty() && !b.is_empty() {
            fields.error(format!("the pair of {} and {} is given twice", quoted(&a), quoted(&b)), None);
        }
        Some(pair(fields, a, b, scene))
    })
}

fn check_sides(fields: &Fields<'_>, scene: &Scene, [a, b]: [&str; 2]) {
    let is_static = |name: &str| scene.statics.iter().any(|s| s.name == name);
    if a == b && !a.is_empty() {
        fields.error(format!("{} cannot be a pair with itself", quoted(a)), None);
    } else if is_static(a) && is_static(b) {
        fields.error("two static colliders never touch".to_owned(), None);
    }
}

fn pair(fields: &Fields<'_>, a: String, b: String, scene: &Scene) -> PairSpec {
    let defaults = scene.pair_defaults(&a, &b);
    let (static_friction, kinetic_friction) = frictions(fields, Some(defaults));
    PairSpec {
        static_friction,
        kinetic_friction,
        restitution: fields.num_or("restitution", defaults.restitution, Limits::between(0.0, 1.0, "")),
        softness_m: fields.num_or("softness", defaults.softness_m, Limits::positive("m")),
        contact: fields
            .opt("contact", |at| at.word(&[("physical", ContactLaw::Physical), ("genesis", ContactLaw::Genesis)]))
            .flatten()
            .unwrap_or(ContactLaw::Physical),
        resolver: fields.opt("resolver", |at| super::body::solver_name(&at)),
        enabled: fields.or("enabled", true, |at| at.flag()),
        a,
        b,
    }
}

/// `static_friction` and `kinetic_friction`, or `friction` for both. One alone stands for both; without any the
/// defaults count, and where there are none it is a mistake.
pub(super) fn frictions(fields: &Fields<'_>, defaults: Option<PairDefaults>) -> (f64, f64) {
    fields.exclude("friction", "static_friction");
    fields.exclude("friction", "kinetic_friction");
    let read = |key| fields.opt(key, |at| at.num(FRICTION));
    match (read("friction"), read("static_friction"), read("kinetic_friction")) {
        (Some(both), _, _) | (None, Some(both), None) | (None, None, Some(both)) => (both, both),
        (None, Some(static_friction), Some(kinetic_friction)) => {
            check_frictions(fields, static_friction, kinetic_friction);
            (static_friction, kinetic_friction)
        }
        (None, None, None) => defaults.map_or_else(
            || {
                fields.one_key(&["friction", "static_friction"]);
                (f64::NAN, f64::NAN)
            },
            |defaults| (defaults.static_friction, defaults.kinetic_friction),
        ),
    }
}

/// Kinetic friction never exceeds static friction.
pub(super) fn check_frictions(fields: &Fields<'_>, static_friction: f64, kinetic_friction: f64) {
    if kinetic_friction > static_friction {
        let (kinetic, limit) = (number(kinetic_friction), number(static_friction));
        fields.error(format!("`kinetic_friction` ({kinetic}) is greater than `static_friction` ({limit})"), None);
    }
}
