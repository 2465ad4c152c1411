//! What a mesh touches with: its convex hull where that is nearly the mesh, else convex parts.

use cosplat_core::asset::TriangleMesh;
use cosplat_core::boundary::Vec3;
use cosplat_core::plan::LeftOut;
use rapier3d::geometry::SharedShape;
use rapier3d::math::Vector;
use rapier3d::parry::transformation::try_convex_hull;
use rapier3d::parry::transformation::vhacd::{VHACD, VHACDParameters};

use crate::V3;
use crate::shape::Part;
use crate::single::{double, vector};

/// Share of the hull's volume from which a mesh counts as convex: the hull then stands off by some hundredths of the
/// size, less than the resolution of a decomposition.
const CONVEX: f64 = 0.95;

/// Convex parts of a mesh with those vertices \[m\] and that volume \[m³\], and what they leave out.
pub(crate) fn collision_parts(
    name: &str,
    points: &[V3],
    mesh: &TriangleMesh,
    volume: f64,
) -> Result<(Vec<Part>, Option<LeftOut>), String> {
    let vertices: Vec<Vector> = points.iter().map(|&p| vector(p)).collect();
    let (hull, faces) = try_convex_hull(&vertices).map_err(|why| format!("no convex hull, {why}"))?;
    let share = volume / hull_volume(&hull, &faces)?;
    let what = format!("difference between the mesh of body `{name}` and what it touches with");
    let left_out = |why: String| LeftOut {
        what,
        why,
        indicator: Some(share),
        limit: Some(CONVEX),
        saved: "contact with every triangle; not measured".to_owned(),
    };
    if share >= CONVEX {
        let part = SharedShape::convex_mesh(hull.clone(), &faces).or_else(|| SharedShape::convex_hull(&hull));
        let part = Part::plain(part.ok_or("its convex hull is flat")?);
        // Nothing is left out where the hull is the mesh, to the rounding of single precision.
        let exact = share > 1.0 - 1e-5;
        return Ok((vec![part], (!exact).then(|| left_out("it touches with its convex hull".into()))));
    }
    let whole = VHACD::decompose(&VHACDParameters::default(), &vertices, &mesh.triangles, true);
    let hulls = whole.compute_exact_convex_hulls(&vertices, &mesh.triangles);
    let parts: Vec<Part> =
        hulls.into_iter().filter_map(|(v, f)| SharedShape::convex_mesh(v, &f)).map(Part::plain).collect();
    if parts.is_empty() {
        return Err("it falls into no convex parts".into());
    }
    let why = format!("it touches with {} convex parts", parts.len());
    Ok((parts, Some(left_out(why))))
}

/// Volume of a hull \[m³\].
fn hull_volume(vertices: &[Vector], triangles: &[[u32; 3]]) -> Result<f64, String> {
    let vertices_m: Vec<Vec3> = vertices.iter().map(|&v| double(v).into()).collect();
    let hull = TriangleMesh { vertices_m, triangles: triangles.to_vec() };
    hull.solid().map(|s| s.volume_m3).map_err(|why| format!("its convex hull fails, {why}"))
}
