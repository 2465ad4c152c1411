//! Geometry of a scene: read from files, brought to metres, filled, sampled and bound, before any process starts.
//!
//! Solvers get particles and meshes over the bus; what is only drawn stays here.

mod camera;
mod capture;
mod cloth;
mod files;
mod primitive;
mod shape;
mod up;

use std::collections::BTreeMap;
use std::sync::Arc;

use cosplat_core::asset::{Asset, ParticleCloud};
use cosplat_core::plan::{BoundaryForm, Refusal, source_kind};
use cosplat_core::plugin::{InterfaceView, SolverScene};
use cosplat_core::scene::{Body, BodyBinding, Material, Pose, Scene, Source, StaticCollider};
use cosplat_core::visual::VisualForm;
use cosplat_splat::Splats;
use cosplat_splat::bind::Frame;
use cosplat_splat::stage::Staged;
use cosplat_viewer::Shot;

pub(crate) use self::up::axis;
use crate::frames::{Drawn, Look};
use crate::scene_source;

/// Colour of what the scene gives none, linear RGB: that of dry earth.
const PLAIN: [f64; 3] = [0.32, 0.27, 0.22];

/// Everything that was made of a scene's sources.
#[derive(Debug, Default)]
pub(crate) struct Geometry {
    /// By the name of their body or static collider.
    assets: BTreeMap<String, Arc<Asset>>,
    /// What is drawn, in the order of the scene.
    pub(crate) drawn: Vec<Drawn>,
    /// Where pictures are taken from, where there are any.
    pub(crate) shot: Option<Shot>,
    /// What people should know about how it was made: body, words.
    pub(crate) notes: Vec<(String, String)>,
}

/// Edges of the box around a body \[m\], where its source tells: captures and points do not.
pub(crate) fn extent(body: &Body, source: &scene_source::Source) -> Option<[f64; 3]> {
    match &body.source {
        Source::Mesh { .. } => Maker { source, draws: false, bindings: &BTreeMap::new() }.mesh_extent(&body.source),
        shape => primitive::mesh(shape).map(|mesh| shape::extent(&mesh.vertices_m)),
    }
}

/// A captured body, and what of its file was dropped, both in the body's frame.
///
/// # Errors
/// In words, where its file cannot be used.
pub(crate) fn staged(scene: &Scene, source: &scene_source::Source, body: &Body) -> Result<(Staged, Splats), String> {
    Maker { source, draws: true, bindings: &scene.output.bindings }.with_dropped(body)
}

/// What came of one source.
struct Made {
    asset: Option<Asset>,
    look: Option<Look>,
    notes: Vec<String>,
}

/// Where sources are, and what is wanted of them.
struct Maker<'a> {
    source: &'a scene_source::Source,
    draws: bool,
    /// What the Gaussians of bodies are tied to, where the scene says so.
    bindings: &'a BTreeMap<String, BodyBinding>,
}

impl Geometry {
    /// Makes the geometry of all bodies and static colliders. `visual` tells how the plugin of a solver shows its
    /// bodies, if it does.
    ///
    /// # Errors
    /// Every source that cannot be used, by name.
    pub(crate) fn load(
        scene: &Scene,
        source: &scene_source::Source,
        visual: impl Fn(&str) -> Option<VisualForm>,
    ) -> Result<Self, Vec<Refusal>> {
        let maker = Maker { source, draws: scene.output.draws(), bindings: &scene.output.bindings };
        let (mut geometry, mut refused) = (Self::default(), Vec::new());
        for body in &scene.bodies {
            let made = maker.body(body, visual(&body.solver));
            geometry.take(&body.name, &body.pose, made, &mut refused, "body");
            for (i, region) in body.regions.iter().enumerate() {
                let words = format!("its region {i}, a {}, is {}", source_kind(&region.source), region.material.name());
                geometry.notes.push((body.name.clone(), words));
            }
        }
        for wall in &scene.statics {
            let made = maker.wall(wall);
            geometry.take(&wall.name, &wall.pose, made, &mut refused, "static");
        }
        if scene.output.draws() {
            match camera::shot(scene, &geometry.drawn) {
                Ok(shot) => geometry.shot = Some(shot),
                Err(why) => refused.push(Refusal { what: "output".to_owned(), why }),
            }
        }
        if refused.is_empty() { Ok(geometry) } else { Err(refused) }
    }

    fn take(&mut self, name: &str, pose: &Pose, made: Result<Made, String>, refused: &mut Vec<Refusal>, kind: &str) {
        let what = format!("{kind} `{name}`");
        let made = match made {
            Ok(made) => made,
            Err(why) => return refused.push(Refusal { what, why }),
        };
        if let Some(asset) = made.asset {
            self.assets.insert(name.to_owned(), Arc::new(asset));
        }
        self.notes.extend(made.notes.into_iter().map(|words| (name.to_owned(), words)));
        let Some(look) = made.look else { return };
        match Frame::of_pose(pose.position_m, pose.orientation) {
            Ok(pose) => self.drawn.push(Drawn { name: name.to_owned(), pose, look }),
            Err(e) => refused.push(Refusal { what, why: e.to_string() }),
        }
    }

    /// Gives each solver what belongs to its bodies, its static colliders and its partners: of those that deform the meshes,
    /// which say where they begin.
    pub(crate) fn hand_out(&self, scenes: &mut [SolverScene]) {
        for scene in scenes {
            let own = scene.bodies.iter().map(|b| &b.name);
            let walls = scene.statics.iter().map(|s| &s.name);
            let meant = |i: &&InterfaceView| {
                let mesh = matches!(self.assets.get(&i.partner).map(Arc::as_ref), Some(Asset::Mesh(_)));
                i.partner_source.is_some() && (mesh || i.partner_form == BoundaryForm::Proxy)
            };
            let partners = scene.interfaces.iter().filter(meant).map(|i| &i.partner);
            let wanted: Vec<&String> = own.chain(walls).chain(partners).collect();
            let found = wanted.into_iter().filter_map(|n| Some((n.clone(), Arc::clone(self.assets.get(n)?))));
            scene.assets = found.collect();
        }
    }

    /// Edges of the box around a body \[m\], also of a capture.
    pub(crate) fn extent(&self, body: &Body, source: &scene_source::Source) -> Option<[f64; 3]> {
        match self.assets.get(&body.name).map(Arc::as_ref) {
            Some(Asset::Particles(cloud)) => Some(shape::extent(&cloud.position_m)),
            _ => extent(body, source),
        }
    }

    /// Particles that were made of a body's file, in its own frame.
    pub(crate) fn particles(&self, body: &str) -> Option<&ParticleCloud> {
        match self.assets.get(body).map(Arc::as_ref) {
            Some(Asset::Particles(cloud)) => Some(cloud),
            _ => None,
        }
    }

    /// Gaussians that are drawn of a body.
    pub(crate) fn gaussians(&self, body: &str) -> u64 {
        self.drawn.iter().find(|d| d.name == body).map_or(0, Drawn::gaussians)
    }
}

impl Maker<'_> {
    fn body(&self, body: &Body, visual: Option<VisualForm>) -> Result<Made, String> {
        let colour = body.color.unwrap_or(PLAIN);
        let is_rigid = visual == Some(VisualForm::Pose);
        match &body.source {
            Source::Splat { .. } => self.capture(body),
            Source::Mesh { .. } if matches!(body.material, Material::Cloth { .. }) => self.sheet(body, colour),
            Source::Mesh { .. } if is_rigid => self.rigid_mesh(body, colour),
            Source::Mesh { .. } => self.filled_mesh(body, colour),
            _ if !self.draws || visual.is_none() => Ok(Made { asset: None, look: None, notes: Vec::new() }),
            Source::Plane { size_m: Some(size) } if matches!(body.material, Material::Cloth { .. }) => {
                let mesh = cloth::rectangle(*size, body.spacing_m);
                let look = mesh.map_or_else(
                    || Look::Dots(shape::spacing(body), colour),
                    |m| cloth::look(&m, &cloth::vertices(&m, colour), colour),
                );
                Ok(Made { asset: None, look: Some(look), notes: Vec::new() })
            }
            source if is_rigid => {
                Ok(Made { asset: None, look: shape::look(source, body.spacing_m, colour)?, notes: Vec::new() })
            }
            _ => {
                Ok(Made { asset: None, look: Some(shape::dots(body, shape::spacing(body), colour)), notes: Vec::new() })
            }
        }
    }

    /// Walls are drawn where the scene gives them a colour.
    fn wall(&self, wall: &StaticCollider) -> Result<Made, String> {
        let mut made = match &wall.source {
            Source::Mesh { .. } | Source::HeightField { .. } => {
                self.hard_mesh(&wall.source, None, wall.color.unwrap_or(PLAIN))?
            }
            source => {
                Made { asset: None, look: shape::look(source, None, wall.color.unwrap_or(PLAIN))?, notes: Vec::new() }
            }
        };
        made.look = made.look.filter(|_| self.draws && wall.color.is_some());
        Ok(made)
    }
}
