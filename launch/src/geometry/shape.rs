//! Meshes and primitives: what a solver is given of them and what is seen.

use std::borrow::Cow;

use cosplat_core::asset::{Asset, TriangleMesh};
use cosplat_core::boundary::Vec3;
use cosplat_core::scene::{Body, Material, Source};
use cosplat_mesh::format::{self, Beside};
use cosplat_mesh::{MeshError, Prepared, Recipe, Report, fill, surface_samples};
use cosplat_splat::surfel::grained;

use super::up::{axis, stated_or};
use super::{Made, Maker, cloth, files, primitive};
use crate::frames::Look;

/// Samples of a surface that is drawn, about: enough for a smooth outline, few enough to be redrawn at every frame.
const SAMPLES: f64 = 6000.0;
/// The same for planes and terrain, which never move and are large.
const PLANE_SAMPLES: f64 = 16_000.0;
/// By what part samples of a plain surface differ in brightness, so that it is seen to turn.
const GRAIN: f64 = 0.35;
/// The same for planes, which turn in no scene: enough to see that there is something.
const PLANE_GRAIN: f64 = 0.06;
/// By how much of the root of a sample's area a plane is drawn lower than it is: its Gaussians have a thickness, and
/// would hide what lies on it.
const SUNK: f32 = 0.4;
/// Spacing of particles whose solver chooses it \[m\].
const DOTS_M: f64 = 0.02;

impl Maker<'_> {
    /// A mesh that keeps its shape.
    pub(super) fn rigid_mesh(&self, source: &Source, spacing: Option<f64>, colour: [f64; 3]) -> Result<Made, String> {
        let prepared = self.mesh(source)?;
        let count = if matches!(source, Source::HeightField { .. }) { PLANE_SAMPLES } else { SAMPLES };
        let look = if self.draws { Some(surface(&prepared.mesh, spacing, colour, GRAIN, count)?) } else { None };
        Ok(Made { asset: Some(Asset::Mesh(prepared.mesh)), look, notes: notes(&prepared.report) })
    }

    /// A mesh whose vertices are what moves: cloth.
    pub(super) fn sheet(&self, body: &Body, colour: [f64; 3]) -> Result<Made, String> {
        let prepared = self.mesh(&body.source)?;
        let look = self.draws.then(|| cloth::look(&prepared.mesh, colour));
        Ok(Made { asset: Some(Asset::Mesh(prepared.mesh)), look, notes: notes(&prepared.report) })
    }

    /// A mesh full of particles.
    pub(super) fn filled_mesh(&self, body: &Body, colour: [f64; 3]) -> Result<Made, String> {
        let prepared = self.mesh(&body.source)?;
        let size = [0, 1, 2].map(|k| prepared.report.box_m[1][k] - prepared.report.box_m[0][k]);
        let spacing = body.spacing_m.unwrap_or(size.into_iter().fold(0.0, f64::max) / 40.0);
        let cloud = fill(&prepared.mesh, spacing).map_err(|e| e.to_string())?;
        let mut notes = notes(&prepared.report);
        notes.push(format!("{} particles", cloud.position_m.len()));
        let look = self.draws.then(|| dots(body, spacing, colour));
        Ok(Made { asset: Some(Asset::Particles(cloud)), look, notes })
    }

    /// Edges of the box around a mesh \[m\]; nothing where it cannot be read, which is said elsewhere.
    pub(super) fn mesh_extent(&self, source: &Source) -> Option<[f64; 3]> {
        self.mesh(source).ok().map(|prepared| extent(&prepared.mesh.vertices_m))
    }

    fn mesh(&self, source: &Source) -> Result<Prepared, String> {
        let (Source::Mesh { file, metres_per_unit, up } | Source::HeightField { file, metres_per_unit, up }) = source
        else {
            return Err("its source is no mesh".to_owned());
        };
        let (bytes, path) = files::read(self.source, file)?;
        let named = |e: MeshError| e.in_file(path.display().to_string()).to_string();
        let ending = path.extension().and_then(|e| e.to_str());
        let known = format::of(&bytes, ending).map_err(named)?;
        let (up, assumed) = stated_or(up, known.up, known.name);
        let recipe = Recipe { metres_per_unit: *metres_per_unit, up: axis(up) };
        // Assets inside this program have nothing beside them.
        let beside = if matches!(bytes, Cow::Borrowed(_)) { Beside::Nothing } else { Beside::of(&path) };
        let mut prepared = Prepared::from_bytes(&bytes, ending, beside, &recipe).map_err(named)?;
        prepared.report.notes.extend(assumed);
        Ok(prepared)
    }
}

/// What people should know about a mesh.
fn notes(report: &Report) -> Vec<String> {
    std::iter::once(report.to_string()).chain(report.notes.iter().cloned()).collect()
}

/// Edges of the box around points \[m\].
pub(super) fn extent(points: &[Vec3]) -> [f64; 3] {
    [0, 1, 2].map(|k| {
        let along = || points.iter().map(|p| p[k]);
        along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
    })
}

/// What is seen of a primitive.
pub(super) fn look(source: &Source, spacing: Option<f64>, colour: [f64; 3]) -> Result<Option<Look>, String> {
    let is_plane = matches!(source, Source::Plane { .. });
    let (grain, count) = if is_plane { (PLANE_GRAIN, PLANE_SAMPLES) } else { (GRAIN, SAMPLES) };
    let Some(mut look) =
        primitive::mesh(source).map(|mesh| surface(&mesh, spacing, colour, grain, count)).transpose()?
    else {
        return Ok(None);
    };
    if let (true, Look::Surface(samples)) = (is_plane, &mut look) {
        for sample in samples {
            sample.position[2] -= SUNK * sample.area.sqrt();
        }
    }
    Ok(Some(look))
}

fn surface(
    mesh: &TriangleMesh,
    spacing: Option<f64>,
    colour: [f64; 3],
    grain: f64,
    count: f64,
) -> Result<Look, String> {
    let of = |t: &[u32; 3]| {
        let [a, b, c] = mesh.corners(*t);
        (b - a).cross(&(c - a)).norm() / 2.0
    };
    let area: f64 = mesh.triangles.iter().map(of).sum();
    let chosen = (area / count).sqrt();
    let samples = surface_samples(mesh, spacing.map_or(chosen, |s| s.min(chosen))).map_err(|e| e.to_string())?;
    Ok(Look::Surface(grained(&samples.position_m, &samples.normal, &samples.area_m2, colour, grain)))
}

/// What is seen of particles.
pub(super) fn dots(body: &Body, spacing: f64, colour: [f64; 3]) -> Look {
    match body.material {
        Material::Smoke { .. } => Look::Smoke(spacing, colour),
        _ => Look::Dots(spacing, colour),
    }
}

/// Spacing of the particles of a body \[m\].
pub(super) fn spacing(body: &Body) -> f64 {
    body.spacing_m.unwrap_or(DOTS_M)
}
