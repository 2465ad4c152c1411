//! `[[body.region]]`: parts of a body of another material.

use super::fields::Fields;
use super::{material, motion, source};
use crate::scene::model::{Region, Source};

/// One `[[body.region]]`.
pub(super) fn region(fields: &Fields<'_>) -> Option<Region> {
    let material = fields.must("material", |at| material::material(&at, false)).flatten();
    let source = source::source(fields);
    let pose = motion::pose(fields);
    if let (Some(material), Some(at)) = (&material, fields.get("material"))
        && material.lame().is_none()
    {
        let help = "take `elastic`, `elastoplastic`, `viscoplastic` or `snow`, or make it a `[[body]]` of its own";
        at.error(format!("no part of a body can be `{}`: it has no stiffness", material.name()), Some(help.to_owned()));
    }
    let is_solid =
        |source: &Source| matches!(source, Source::Box { .. } | Source::Sphere { .. } | Source::Cylinder { .. });
    if source.as_ref().is_some_and(|source| !is_solid(source)) {
        let help = "its place is in the body's own frame [m], as in box = [0.1, 0.1, 0.1], position = [0, 0, 0.2]";
        fields.error("a region is a `box`, a `sphere` or a `cylinder`".to_owned(), Some(help.to_owned()));
    }
    Some(Region { material: material?, source: source?, pose })
}
