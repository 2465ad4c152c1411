//! Where the nodes of a document are.

use nalgebra::{Matrix4, Quaternion, UnitQuaternion, Vector3};

use super::schema::{Document, Node};
use super::{EXPORT, fault, item};
use crate::error::{Fault, MeshError};

/// Every node of the scene with its place in the world, in order; of a document without scenes every node that hangs
/// below no other.
pub(super) fn nodes(document: &Document) -> Result<Vec<(usize, Matrix4<f64>)>, MeshError> {
    let roots = match document.scenes.get(document.scene.unwrap_or(0)) {
        Some(scene) => scene.nodes.clone(),
        None if document.scene.is_some() => {
            return Err(fault("scene", format!("number {:?} of {} is named", document.scene, document.scenes.len())));
        }
        None => parentless(document),
    };
    let mut seen = vec![false; document.nodes.len()];
    let mut out = Vec::with_capacity(seen.len());
    let mut open: Vec<(usize, Matrix4<f64>)> = roots.into_iter().rev().map(|n| (n, Matrix4::identity())).collect();
    while let Some((number, above)) = open.pop() {
        let node = item(&document.nodes, number, "node")?;
        if std::mem::replace(&mut seen[number], true) {
            let what = "it hangs below itself or below two others";
            return Err(fault(format!("node {number}"), what));
        }
        let placed = above * local(node, number)?;
        out.push((number, placed));
        open.extend(node.children.iter().rev().map(|child| (*child, placed)));
    }
    Ok(out)
}

fn parentless(document: &Document) -> Vec<usize> {
    let mut has_parent = vec![false; document.nodes.len()];
    for child in document.nodes.iter().flat_map(|node| &node.children) {
        if let Some(flag) = has_parent.get_mut(*child) {
            *flag = true;
        }
    }
    (0..has_parent.len()).filter(|node| !has_parent[*node]).collect()
}

/// The matrix of a node: its own, or translation · rotation · scale.
fn local(node: &Node, number: usize) -> Result<Matrix4<f64>, MeshError> {
    let wrong = |what: &str| MeshError::new(Fault::Value, format!("node {number}"), what, EXPORT);
    let matrix = if let Some(columns) = node.matrix {
        Matrix4::from_column_slice(&columns)
    } else {
        let [x, y, z, w] = node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
        let turn = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-9);
        let turn = turn.ok_or_else(|| wrong("its rotation is zero"))?;
        Matrix4::new_translation(&Vector3::from(node.translation.unwrap_or_default()))
            * turn.to_homogeneous()
            * Matrix4::new_nonuniform_scaling(&Vector3::from(node.scale.unwrap_or([1.0; 3])))
    };
    if matrix.iter().all(|v| v.is_finite()) { Ok(matrix) } else { Err(wrong("its place is not finite")) }
}
