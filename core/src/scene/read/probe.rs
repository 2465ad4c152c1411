//! `[[probe]]`.

use super::fields::Fields;
use super::limits::Limits;
use super::names::{self, Kind};
use crate::scene::model::{Probe, ProbeQuantity};

const QUANTITIES: [(&str, ProbeQuantity); 9] = [
    ("position", ProbeQuantity::Position),
    ("orientation", ProbeQuantity::Orientation),
    ("velocity", ProbeQuantity::Velocity),
    ("momentum", ProbeQuantity::Momentum),
    ("pressure", ProbeQuantity::Pressure),
    ("force", ProbeQuantity::Force),
    ("volume-fraction", ProbeQuantity::VolumeFraction),
    ("strain", ProbeQuantity::Strain),
    ("reach", ProbeQuantity::Reach),
];

/// One `[[probe]]`.
pub(super) fn probe(fields: &Fields<'_>) -> Option<Probe> {
    let name = fields.must("name", |at| names::declare(&at, Kind::Probe));
    let quantity = fields.must("quantity", |at| at.word(&QUANTITIES)).flatten();
    let body = fields.opt("body", |at| names::mention(&at, &[Kind::Body]));
    let at_m = fields.opt("at", |at| at.numbers(Limits::any("m")));
    let along = fields.opt("along", |at| at.direction());
    if let Some(quantity) = quantity {
        check_place(fields, quantity);
        check_direction(fields, quantity);
    }
    Some(Probe { name: name?, quantity: quantity?, body, at_m, along })
}

/// How far something reaches is asked along a direction; nothing else is.
fn check_direction(fields: &Fields<'_>, quantity: ProbeQuantity) {
    if quantity == ProbeQuantity::Reach {
        fields.need("along");
    } else if let Some(along) = fields.get("along") {
        along.error("only `reach` is measured along a direction".to_owned(), None);
    }
}

/// A quantity belongs either to a body or to a point.
fn check_place(fields: &Fields<'_>, quantity: ProbeQuantity) {
    let (needed, other) = match quantity {
        ProbeQuantity::Pressure | ProbeQuantity::VolumeFraction => ("at", "body"),
        _ => ("body", "at"),
    };
    fields.need(needed);
    if let Some(at) = fields.get(other) {
        at.error(format!("this quantity is measured with `{needed}`, not `{other}`"), None);
    }
}
