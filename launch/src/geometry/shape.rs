//! Meshes and primitives: what a solver is given of them and what is seen.

use std::borrow::Cow;

use cosplat_core::asset::{Asset, TriangleMesh};
use cosplat_core::boundary::Vec3;
use cosplat_core::scene::{BindingKind, Body, Material, Source};
use cosplat_mesh::format::{self, Beside};
use cosplat_mesh::{MeshError, Prepared, Recipe, Report, fill, surface_samples};
use cosplat_splat::bind::BindError;
use cosplat_splat::surfel::{Fabric, MeshSurfels, Sample, colour_by_vertices, display_of_linear, grained};

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
    pub(super) fn hard_mesh(&self, source: &Source, spacing: Option<f64>, colour: [f64; 3]) -> Result<Made, String> {
        let prepared = self.mesh(source)?;
        let count = if matches!(source, Source::HeightField { .. }) { PLANE_SAMPLES } else { SAMPLES };
        let seen = || Ok::<Look, String>(Look::Surface(surface(&prepared, spacing, colour, GRAIN, count)?));
        let look = self.draws.then(seen).transpose()?;
        Ok(Made { asset: Some(Asset::Mesh(prepared.mesh)), look, notes: notes(&prepared.report) })
    }

    /// A body that is a mesh and keeps its shape.
    pub(super) fn rigid_mesh(&self, body: &Body, colour: [f64; 3]) -> Result<Made, String> {
        let mut made = self.hard_mesh(&body.source, body.spacing_m, colour)?;
        if let Some(bound) = self.bound_mesh(body, colour)? {
            made.look = Some(bound);
        }
        Ok(made)
    }

    /// A mesh whose vertices are what moves: cloth.
    pub(super) fn sheet(&self, body: &Body, colour: [f64; 3]) -> Result<Made, String> {
        let prepared = self.mesh(&body.source)?;
        let plain = || self.draws.then(|| cloth::look(&prepared.mesh, &colours(&prepared, colour), colour));
        let look = self.bound_mesh(body, colour)?.or_else(plain);
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
        let plain = || self.draws.then(|| dots(body, spacing, colour));
        let look = self.bound_mesh(body, colour)?.or_else(plain);
        Ok(Made { asset: Some(Asset::Particles(cloud)), look, notes })
    }

    /// What is seen of a mesh whose Gaussians the scene ties to its vertices or triangles; nothing where it does not.
    fn bound_mesh(&self, body: &Body, colour: [f64; 3]) -> Result<Option<Look>, String> {
        let Some(binding) = self.bindings.get(&body.name).filter(|_| self.draws) else { return Ok(None) };
        let prepared = self.mesh(&body.source)?;
        let is_closed = prepared.report.open_edges == 0;
        let colours = colours(&prepared, colour).iter().map(|s| s.colour).collect();
        let fabric = Fabric { triangles: prepared.mesh.triangles.clone(), colours };
        let wrong = |e: BindError| e.to_string();
        let surfels = MeshSurfels::on_vertices(prepared.mesh.vertices_m.clone(), fabric, is_closed).map_err(wrong)?;
        let surfels = match (binding.spec.kind, &binding.splat) {
            (BindingKind::Triangles, Some(file)) => surfels.wearing(self.worn(&body.source, file)?).map_err(wrong)?,
            (BindingKind::Triangles, None) => {
                surfels.on_triangles(surface(&prepared, None, colour, GRAIN, SAMPLES)?).map_err(wrong)?
            }
            _ => surfels,
        };
        Ok(Some(Look::Mesh(Box::new(surfels), binding.spec.neighbours)))
    }

    /// Edges of the box around a mesh \[m\]; nothing where it cannot be read, which is said elsewhere.
    pub(super) fn mesh_extent(&self, source: &Source) -> Option<[f64; 3]> {
        self.mesh(source).ok().map(|prepared| extent(&prepared.mesh.vertices_m))
    }

    /// The up axis of a mesh's file, as scenes name it: the stated one, or that of its format.
    pub(super) fn up_of_mesh(&self, file: &str, stated: &str) -> Result<String, String> {
        let (bytes, path) = files::read(self.source, file)?;
        let known = format::of(&bytes, path.extension().and_then(|e| e.to_str()));
        let known = known.map_err(|e| e.in_file(path.display().to_string()).to_string())?;
        Ok(stated_or(stated, known.up, known.name).0.to_owned())
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
    let Some(mut samples) =
        primitive::mesh(source).map(|mesh| covered(&mesh, spacing, colour, grain, count)).transpose()?
    else {
        return Ok(None);
    };
    if is_plane {
        for sample in &mut samples {
            sample.position[2] -= SUNK * sample.area.sqrt();
        }
    }
    Ok(Some(Look::Surface(samples)))
}

/// Vertices as samples, in the colours of the file or in a plain one with grain.
fn colours(prepared: &Prepared, colour: [f64; 3]) -> Vec<Sample> {
    let mut samples = cloth::vertices(&prepared.mesh, colour);
    for (sample, own) in samples.iter_mut().zip(&prepared.colours) {
        sample.colour = own.map(|c| display_of_linear(f64::from(c)) as f32);
    }
    samples
}

/// Samples of a surface, in the colours of the file or in a plain one with grain.
fn surface(
    prepared: &Prepared,
    spacing: Option<f64>,
    colour: [f64; 3],
    grain: f64,
    count: f64,
) -> Result<Vec<Sample>, String> {
    let mut samples = covered(&prepared.mesh, spacing, colour, grain, count)?;
    if !prepared.colours.is_empty() {
        let TriangleMesh { vertices_m, triangles } = &prepared.mesh;
        colour_by_vertices(&mut samples, vertices_m, triangles, &prepared.colours).map_err(|e| e.to_string())?;
    }
    Ok(samples)
}

fn covered(
    mesh: &TriangleMesh,
    spacing: Option<f64>,
    colour: [f64; 3],
    grain: f64,
    count: f64,
) -> Result<Vec<Sample>, String> {
    let of = |t: &[u32; 3]| {
        let [a, b, c] = mesh.corners(*t);
        (b - a).cross(&(c - a)).norm() / 2.0
    };
    let area: f64 = mesh.triangles.iter().map(of).sum();
    let chosen = (area / count).sqrt();
    let samples = surface_samples(mesh, spacing.map_or(chosen, |s| s.min(chosen))).map_err(|e| e.to_string())?;
    Ok(grained(&samples.position_m, &samples.normal, &samples.area_m2, colour, grain))
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
