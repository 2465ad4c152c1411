//! `[[action]]`.

use super::fields::Fields;
use super::limits::{Limits, number};
use super::names;
use super::value::At;
use crate::scene::model::{Action, ActionKind, Field, Opening};

const POSITION: Limits = Limits::any("m");
const ACCELERATION: Limits = Limits::any("m/s²");

/// Density of air at 15 °C and sea level \[kg/m³\]. Source: ISO 2533, standard atmosphere.
const AIR_DENSITY_KG_M3: f64 = 1.225;

/// Kinds of actions, each with its own keys.
#[derive(Clone, Copy)]
enum Kind {
    Gravity,
    Wind,
    AccelerationField,
    PointForce,
    Impulse,
    Reverse,
    Inflow,
    Drain,
}

const KINDS: [(&str, Kind); 8] = [
    ("gravity", Kind::Gravity),
    ("wind", Kind::Wind),
    ("acceleration-field", Kind::AccelerationField),
    ("point-force", Kind::PointForce),
    ("impulse", Kind::Impulse),
    ("reverse", Kind::Reverse),
    ("inflow", Kind::Inflow),
    ("drain", Kind::Drain),
];

/// One `[[action]]`.
pub(super) fn action(fields: &Fields<'_>, duration_s: f64) -> Option<Action> {
    let kind = fields.must("kind", |at| at.word(&KINDS)).flatten();
    let bodies = fields.or("bodies", Vec::new(), |at| {
        at.items().iter().map(|item| names::mention(item, &[names::Kind::Body])).collect()
    });
    let from_s = fields.num_or("from", 0.0, Limits::not_negative("s"));
    let until_s = fields.opt("until", |at| until(&at, from_s));
    if let Some(at) = fields.get("from").filter(|_| from_s > duration_s) {
        at.warning(format!("the run ends at {} s, before this begins", number(duration_s)), None);
    }
    let Some(kind) = kind else {
        // Which keys belong here depends on the kind; without it only that is worth a word.
        fields.accept_all_keys();
        return None;
    };
    Some(Action { kind: of_kind(kind, fields)?, bodies, from_s, until_s })
}

fn until(at: &At<'_>, from_s: f64) -> f64 {
    let until_s = at.num(Limits::positive("s"));
    if until_s <= from_s {
        at.error(format!("`until` ({} s) is not after `from` ({} s)", number(until_s), number(from_s)), None);
    }
    until_s
}

fn of_kind(kind: Kind, fields: &Fields<'_>) -> Option<ActionKind> {
    Some(match kind {
        Kind::Gravity => ActionKind::Gravity { acceleration_m_s2: fields.vec3("acceleration", ACCELERATION) },
        Kind::Wind => ActionKind::Wind {
            velocity_m_s: fields.vec3("velocity", Limits::any("m/s")),
            air_density_kg_m3: fields.num_or("air_density", AIR_DENSITY_KG_M3, Limits::positive("kg/m³")),
            drag_coefficient: fields.num_or("drag_coefficient", 1.0, Limits::not_negative("")),
        },
        Kind::AccelerationField => {
            let field = fields.must("field", |at| at.table(field)).flatten().flatten()?;
            ActionKind::AccelerationField { field }
        }
        Kind::PointForce => {
            let force_n = fields.vec3("force", Limits::any("N"));
            ActionKind::PointForce { force_n, at_m: point_of_action(fields) }
        }
        Kind::Impulse => {
            sudden(fields, "an impulse");
            let impulse_n_s = fields.vec3("impulse", Limits::any("N s"));
            ActionKind::Impulse { impulse_n_s, at_m: point_of_action(fields) }
        }
        Kind::Reverse => {
            sudden(fields, "a reversal");
            ActionKind::Reverse
        }
        Kind::Inflow => inflow(fields)?,
        Kind::Drain => {
            fields.need("bodies");
            let size_m = fields.must("size", |at| at.numbers(Limits::positive("m"))).unwrap_or_default();
            ActionKind::Drain { center_m: fields.vec3("center", POSITION), size_m }
        }
    })
}

/// What is sudden has no end.
fn sudden(fields: &Fields<'_>, what: &str) {
    if let Some(at) = fields.get("until") {
        at.error(format!("{what} is sudden: it acts at `from` and has no `until`"), None);
    }
}

fn inflow(fields: &Fields<'_>) -> Option<ActionKind> {
    let one = |at: &At<'_>| at.items().len() == 1;
    if let Some(at) = fields.need("bodies").filter(|at| !one(at)) {
        at.error("an inflow is of one body".to_owned(), Some("write one `[[action]]` for each".to_owned()));
    }
    let center_m = fields.vec3("center", POSITION);
    let velocity_m_s: [f64; 3] = fields.vec3("velocity", Limits::any("m/s"));
    if let Some(at) = fields.get("velocity").filter(|_| velocity_m_s.iter().all(|v| v.abs() <= 0.0)) {
        at.error("an inflow needs a velocity: nothing enters at rest".to_owned(), None);
    }
    let opening = match fields.one_key(&["radius", "size"])? {
        ("radius", at) => Opening::Disc { radius_m: at.num(Limits::positive("m")) },
        (_, at) => Opening::Rectangle { size_m: at.numbers(Limits::positive("m")) },
    };
    Some(ActionKind::Inflow { center_m, velocity_m_s, opening })
}

fn field(fields: &Fields<'_>) -> Option<Field> {
    match fields.one_key(&["constant", "cylinder", "point"])? {
        ("constant", at) => {
            at.table(|fields| Field::Constant { acceleration_m_s2: fields.vec3("acceleration", ACCELERATION) })
        }
        ("cylinder", at) => at.table(|fields| Field::Cylinder {
            strength_m_s2: fields.num("strength", ACCELERATION),
            direction: fields.must("direction", |at| at.direction()).unwrap_or_default(),
            center_m: fields.vec3("center", POSITION),
            radius_m: fields.num("radius", Limits::positive("m")),
        }),
        (_, at) => at.table(|fields| Field::Point {
            strength_m_s2: fields.num("strength", ACCELERATION),
            center_m: fields.vec3("center", POSITION),
            falloff: fields.num_or("falloff", 0.0, Limits::not_negative("")),
        }),
    }
}

/// What acts at a point must say on which bodies; without a point it acts at their centres of mass.
fn point_of_action(fields: &Fields<'_>) -> Option<[f64; 3]> {
    fields.need("bodies");
    fields.opt("at", |at| at.numbers(POSITION))
}
