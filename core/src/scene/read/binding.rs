//! `binding` of a body: what its Gaussians are tied to. A matter of what is drawn, never of what is computed.

use super::fields::Fields;
use super::node::Value;
use crate::scene::model::{BindingKind, BindingSpec, BodyBinding, Source};

const KINDS: [(&str, BindingKind); 5] = [
    ("affine", BindingKind::Affine),
    ("mean", BindingKind::Mean),
    ("particle", BindingKind::Particle),
    ("vertices", BindingKind::Vertices),
    ("triangles", BindingKind::Triangles),
];
/// More neighbours than this are no neighbourhood.
const MOST: u64 = 64;

/// The binding of a body, if it states one.
pub(super) fn binding(fields: &Fields<'_>) -> Option<BodyBinding> {
    let table = |fields: &Fields<'_>| {
        let kind = fields.must("kind", |at| at.word(&KINDS)).flatten();
        let neighbours = fields.opt("neighbours", |at| {
            if kind == Some(BindingKind::Particle) {
                let help = "leave `neighbours` away, or take `affine` or `mean`".to_owned();
                at.error("a Gaussian that follows one particle has no other neighbours".to_owned(), Some(help));
            }
            at.count(1..=MOST) as usize
        });
        let splat = fields.opt("splat", |at| {
            if kind.is_some_and(|kind| kind != BindingKind::Triangles) {
                at.error(
                    "only triangles hold the Gaussians of another file".to_owned(),
                    Some("take `kind = \"triangles\"`, or leave `splat` away".to_owned()),
                );
            }
            at.text()
        });
        kind.map(|kind| {
            let spec = BindingSpec { kind, neighbours: neighbours.unwrap_or(kind.neighbours()) };
            BodyBinding { spec, splat }
        })
    };
    fields
        .opt("binding", |at| match at.node.value {
            Value::Table(_) => at.table(table).flatten(),
            _ => at.word(&KINDS).map(BodyBinding::from),
        })
        .flatten()
}

/// Complains about a binding that needs what the body is not made of.
pub(super) fn check(fields: &Fields<'_>, binding: Option<&BodyBinding>, source: &Source) {
    let (Some(binding), Some(at)) = (binding, fields.get("binding")) else { return };
    let (is_capture, is_mesh) = (matches!(source, Source::Splat { .. }), matches!(source, Source::Mesh { .. }));
    let fits = if binding.spec.kind.is_of_mesh() { is_mesh } else { is_capture };
    if fits {
        return;
    }
    let (message, help) = match (is_capture, is_mesh) {
        (true, _) => ("a capture has no vertices and no triangles", "take `affine`, `mean` or `particle`"),
        (_, true) => ("a mesh has no Gaussians of its own", "take `vertices` or `triangles`"),
        _ => ("only a `splat` or a `mesh` has Gaussians that are bound", "leave `binding` away"),
    };
    at.error(message.to_owned(), Some(help.to_owned()));
}
