//! Particles inside a closed mesh.

use cosplat_core::asset::{ParticleCloud, TriangleMesh};
use nalgebra::Vector3;
use rayon::prelude::*;

use crate::distance::SignedDistance;
use crate::error::{Fault, MeshError};

/// Lattice points at most.
const MOST: f64 = 2e8;

/// One particle at each point (k + ½) h of a lattice that lies inside, by z, then y, then x. Each stands for the same
/// share of the solid's volume, so that their sum is exact: near h³, the difference being what the lattice misses at
/// the surface.
///
/// # Errors
/// The mesh encloses nothing, or the spacing gives no particles or too many.
pub fn fill(mesh: &TriangleMesh, spacing_m: f64) -> Result<ParticleCloud, MeshError> {
    let h = spacing_m;
    if !(h.is_finite() && h > 0.0) {
        let what = format!("the spacing is {h} m");
        return Err(MeshError::whole(Fault::Spacing, what, "give a positive number"));
    }
    let distance = SignedDistance::new(mesh)?;
    let ends = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
    let (lower, upper) =
        mesh.vertices_m.iter().fold(ends, |(l, u), v| (l.inf(&Vector3::from(*v)), u.sup(&Vector3::from(*v))));
    let first = (lower / h).map(f64::floor);
    let counts = (upper / h).map(f64::floor) - first + Vector3::repeat(1.0);
    if counts.product() > MOST {
        let what = format!("a spacing of {h} m needs {:.1e} lattice points", counts.product());
        return Err(MeshError::whole(Fault::Spacing, what, "use a larger spacing"));
    }
    let [nx, ny, nz] = [0, 1, 2].map(|k| counts[k] as usize);
    let plane = |z: usize| {
        let at = |x: usize, y: usize| {
            let p = first + Vector3::new(x as f64 + 0.5, y as f64 + 0.5, z as f64 + 0.5);
            <[f64; 3]>::from(p * h)
        };
        let row = |y: usize| (0..nx).map(move |x| at(x, y));
        (0..ny).flat_map(row).filter(|p| distance.at(*p) < 0.0).collect::<Vec<_>>()
    };
    let planes: Vec<Vec<[f64; 3]>> = (0..nz).into_par_iter().map(plane).collect();
    let position_m = planes.concat();
    if position_m.is_empty() {
        let what = format!("no point of a lattice of {h} m lies inside");
        return Err(MeshError::whole(Fault::Spacing, what, "use a smaller spacing"));
    }
    let each = distance.solid().volume_m3 / position_m.len() as f64;
    Ok(ParticleCloud { spacing_m: h, volume_m3: vec![each; position_m.len()], position_m })
}
