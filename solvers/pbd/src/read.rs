//! From a solver's part of a scene to a [`Model`], with every feature that is missing refused by name.

use cosplat_core::boundary::{Vec3, norm, scale, sub};
use cosplat_core::plan::LeftOut;
use cosplat_core::plugin::{Descriptor, PluginError, Refusals, SolverScene, part_actions};
use cosplat_core::scene::{Body, ContactLaw, Material, PairDefaults, PairSpec, Source};

use crate::bend::{Hinge, angle};
use crate::contact::Surface;
use crate::model::{Cloth, Model};
use crate::own::Mesh;
use crate::params::Params;
use crate::pull::Pull;
use crate::rim;
use crate::sheet::Sheet;
use crate::sim::{Setting, Sim};
use crate::stretch::Edge;
use crate::tiles::{Cut, Tiles};
use crate::vertex::{Phases, Vertex, block_size};

/// Squares along the longer side of a sheet without a spacing.
const SQUARES: f64 = 50.0;

/// A scene on its way to a model.
pub(crate) struct Reader<'a> {
    pub(crate) scene: &'a SolverScene,
    pub(crate) params: Params,
    pub(crate) refused: Refusals,
    /// Typical spacing of the cloths \[m\].
    pub(crate) spacing: f64,
}

/// Vertices and constraints of all bodies.
#[derive(Default)]
struct Parts {
    cloths: Vec<Cloth>,
    vertices: Vec<Vertex>,
    owner: Vec<u32>,
    area: Vec<f64>,
    edges: Vec<Edge>,
    hinges: Vec<Hinge>,
    masses: Vec<f64>,
    mesh: Mesh,
    cuts: Vec<Cut>,
    pulls: Vec<Pull>,
    /// Attached vertices, the body of each, and what it is attached to.
    bound: Vec<(u32, usize, String)>,
    shortest: f64,
}

/// Reads a scene.
pub(crate) fn read(plugin: &Descriptor, scene: &SolverScene) -> Result<Model, PluginError> {
    let mut refused = Refusals::undeclared(plugin, scene);
    let params = Params::read(&scene.params).map_err(|wrong| {
        for what in &wrong {
            refused.push(what);
        }
        refused.clone().finish().err().unwrap_or(PluginError::Aborted)
    })?;
    let mut reader = Reader { scene, params, refused, spacing: 0.01 };
    let mut parts = Parts { shortest: f64::INFINITY, ..Parts::default() };
    for body in &scene.bodies {
        reader.body(body, &mut parts);
    }
    reader.strangers();
    if parts.shortest.is_finite() {
        reader.spacing = parts.shortest;
    }
    let walls = scene.statics.iter().filter_map(|s| reader.wall(s)).collect();
    let (faces, partners) = reader.interfaces();
    let bonds = reader.bonds(&parts.bound, &faces);
    let actions = part_actions(scene, &parts.masses, &mut |what| reader.refused.push(what));
    parts.mesh.bodies = scene.bodies.len();
    parts.mesh.rim = rim::of(&parts.mesh.triangles);
    parts.mesh.friction = reader.own_friction();
    if !parts.mesh.friction.is_empty() {
        parts.mesh.tiles = Tiles::new(&parts.mesh, &parts.owner, parts.cuts);
    }
    let left_out = reader.left_out();
    reader.refused.finish()?;
    let params = reader.params;
    let fixed: Vec<bool> = parts.vertices.iter().map(|v| v.w <= 0.0).collect();
    let size = block_size(&parts.hinges).max(block_size(&parts.edges));
    let setting = Setting {
        actions,
        walls,
        partners,
        bodies: scene.bodies.len(),
        thickness: params.thickness,
        iterations: params.iterations,
        relaxed: params.relaxed,
        longest: params.longest,
        shortest: parts.shortest,
        damping: params.damping,
        turns: params.turns,
        parallel: scene.threads > 1 && fixed.len() > size,
    };
    let start = parts.vertices.iter().map(|v| v.x).collect();
    let sim = Sim {
        edges: Phases::new(&parts.edges, &fixed, size),
        hinges: Phases::new(&parts.hinges, &fixed, size),
        vertices: parts.vertices,
        owner: parts.owner,
        area: parts.area,
        mesh: parts.mesh,
        pulls: parts.pulls,
        size,
        setting,
    };
    Ok(Model { cloths: parts.cloths, faces, bonds, sim, start, left_out, threads: scene.threads })
}

impl Reader<'_> {
    fn body(&mut self, body: &Body, parts: &mut Parts) {
        let name = &body.name;
        let from = parts.vertices.len();
        let index = parts.cloths.len() as u32;
        let sheet = match self.sheet(body) {
            Ok(sheet) => sheet,
            Err(why) => {
                self.refused.push(format!("{why} (body `{name}`)"));
                Sheet::default()
            }
        };
        let Material::Cloth {
            areal_density_kg_m2,
            stretch_compliance_m_n,
            bending_compliance_rad_n,
            stretch_relaxation,
            bending_relaxation,
            ..
        } = body.material
        else {
            return;
        };
        let density = body.mass_kg.map_or(areal_density_kg_m2, |mass| mass / sheet.area().max(f64::MIN_POSITIVE));
        let compliances = [stretch_compliance_m_n, bending_compliance_rad_n];
        let sound = density.is_finite() && density > 0.0 && compliances.iter().all(|c| c.is_finite() && *c >= 0.0);
        if !sound {
            self.refused.push(format!("bodies without a positive mass per area and compliances (body `{name}`)"));
        }
        let places = sheet.places();
        let x: Vec<Vec3> = sheet.points.iter().map(|&p| body.pose.apply(p)).collect();
        let weighted =
            x.iter().zip(&sheet.areas).fold([0.0; 3], |sum, (&x, &a)| cosplat_core::boundary::add(sum, scale(x, a)));
        let centre = scale(weighted, 1.0 / sheet.area().max(f64::MIN_POSITIVE));
        let held = self.held(name, &x, 0.5 * sheet.spacing);
        let at = |i: usize| (from + places[i] as usize) as u32;
        parts.bound.extend(held.bound.iter().map(|(i, to)| (at(*i), index as usize, to.clone())));
        parts.pulls.extend(held.pulls(at));
        let fixed = &held.fixed;
        parts.vertices.resize(from + x.len(), Vertex::default());
        parts.area.resize(from + x.len(), 0.0);
        parts.owner.resize(from + x.len(), index);
        parts.mesh.rest.resize(from + x.len(), [0.0; 3]);
        for (i, &place) in places.iter().enumerate() {
            let (at, mass) = (from + place as usize, density * sheet.areas[i]);
            let u = if fixed[i] { [0.0; 3] } else { body.velocity.at(x[i], centre) };
            parts.vertices[at] = Vertex { x: x[i], u, w: if fixed[i] { 0.0 } else { 1.0 / mass }, mass };
            parts.area[at] = sheet.areas[i];
            parts.mesh.rest[at] = sheet.points[i];
        }
        for pull in parts.pulls.iter().filter(|pull| pull.vertex as usize >= from) {
            parts.vertices[pull.vertex as usize].u = pull.velocity;
        }
        let at = |i: u32| at(i as usize);
        for &(ends, is_diagonal) in &sheet.edges {
            let rest = norm(sub(sheet.points[ends[0] as usize], sheet.points[ends[1] as usize]));
            let shear = self.params.shear.filter(|_| is_diagonal);
            let compliance = shear.unwrap_or(stretch_compliance_m_n);
            parts.edges.push(Edge::new(ends.map(at), rest, compliance, stretch_relaxation));
            parts.shortest = parts.shortest.min(rest);
        }
        for &ends in &sheet.hinges {
            let found = angle(ends.map(|i| sheet.points[i as usize]));
            // The published method knows flat rest states only.
            let rest = if self.params.relaxed { 0.0 } else { found.map_or(0.0, |(theta, _)| theta) };
            parts.hinges.push(Hinge::new(ends.map(at), rest, bending_compliance_rad_n, bending_relaxation));
        }
        parts.cuts.push(Cut::new(&sheet.points, sheet.spacing, sheet.squares, 2.0 * self.params.thickness));
        parts.mesh.triangles.extend(sheet.triangles.iter().map(|t| t.map(at)));
        parts.mesh.edges.extend(sheet.edges.iter().map(|(ends, _)| ends.map(at)));
        parts.masses.push(density * sheet.area());
        let range = from..parts.vertices.len();
        if !parts.vertices[range.clone()].iter().all(|v| v.x.iter().chain(&v.u).all(|c| c.is_finite())) {
            self.refused.push(format!("positions or velocities that are not finite (body `{name}`)"));
        }
        let coupled = self.scene.is_coupled(name);
        parts.cloths.push(Cloth { name: name.clone(), range, places, triangles: sheet.triangles, coupled });
    }

    fn sheet(&self, body: &Body) -> Result<Sheet, String> {
        match &body.source {
            Source::Plane { size_m: Some(size) } => {
                let spacing = body.spacing_m.unwrap_or(size[0].max(size[1]) / SQUARES);
                let sound = |v: f64| v.is_finite() && v > 0.0;
                let made =
                    Sheet::rectangle(*size, spacing).filter(|_| sound(size[0]) && sound(size[1]) && sound(spacing));
                made.ok_or_else(|| format!("a sheet of {size:?} m at a spacing of {spacing} m"))
            }
            Source::Plane { size_m: None } => Err("cloth without an end: give the plane a size".into()),
            Source::Mesh { .. } => match self.scene.assets.get(&body.name).map(AsRef::as_ref) {
                Some(cosplat_core::asset::Asset::Mesh(mesh)) => Sheet::of_mesh(mesh),
                _ => Err("cloth from a mesh that was not prepared as triangles before the run".into()),
            },
            // Refused already.
            _ => Ok(Sheet::default()),
        }
    }

    /// The listed pair of two names.
    pub(crate) fn pair(&self, a: &str, b: &str) -> Option<&PairSpec> {
        self.scene.pairs.iter().find(|p| (p.a == a && p.b == b) || (p.a == b && p.b == a))
    }

    /// Surface of a pair; `None` where it is left out.
    pub(crate) fn surface(&mut self, pair: &PairSpec) -> Option<Surface> {
        if pair.enabled && pair.contact == ContactLaw::Genesis {
            self.refused.push(format!("contact law genesis (`{}` and `{}`)", pair.a, pair.b));
        }
        if pair.enabled && pair.restitution != 0.0 {
            self.refused.push(format!("restitution (`{}` and `{}`)", pair.a, pair.b));
        }
        pair.enabled.then_some(Surface::Coulomb(pair.static_friction, pair.kinetic_friction))
    }

    fn touches_itself(&self) -> bool {
        self.params.own && self.params.thickness > 0.0
    }

    /// Friction of each two bodies, row by row; nothing at all where cloths do not touch.
    fn own_friction(&mut self) -> Vec<Option<[f64; 2]>> {
        let bodies = &self.scene.bodies;
        if !self.touches_itself() {
            return Vec::new();
        }
        let mut table = Vec::new();
        for (a, b) in bodies.iter().flat_map(|a| bodies.iter().map(move |b| (a, b))) {
            table.push(if let Some(pair) = self.pair(&a.name, &b.name).cloned() {
                self.surface(&pair).map(|_| [pair.static_friction, pair.kinetic_friction])
            } else {
                let pair = PairDefaults::of_materials(&a.material, &b.material);
                Some([pair.static_friction, pair.kinetic_friction])
            });
        }
        table
    }

    /// By how much a metre of cloth that hangs gets longer by its compliance, and by corrections that are scaled by the
    /// factor `r` in place of it \[m\]: half of `α g ρ`, with the compliance `h² Σw (1 - φ)/φ`, `φ = 1 - (1 - r)^n`, of
    /// relaxed corrections at vertices of `ρ l²`.
    fn elongations(&self, density: f64, compliance: f64, r: f64) -> [f64; 2] {
        let (published, iterations) = if self.params.relaxed {
            (self.params.longest, self.params.iterations[0])
        } else {
            (crate::params::GENESIS_SUBSTEP, crate::params::GENESIS_ITERATIONS[0])
        };
        let left = libm::pow(1.0 - r, f64::from(iterations));
        let weight = 2.0 / (density * self.spacing * self.spacing);
        let relaxed = (compliance + published * published * weight) * (left / (1.0 - left)).max(1.0);
        [compliance, relaxed].map(|compliance| 0.5 * compliance * 9.81 * density)
    }

    fn left_out(&self) -> Vec<LeftOut> {
        let bodies = &self.scene.bodies;
        let one = |what: String, why: String| LeftOut {
            what,
            why,
            indicator: None,
            limit: None,
            saved: "not measured".to_owned(),
        };
        let why = if self.params.own { "a cloth without thickness" } else { "`params.self_collision` is false" };
        let untouched = !self.touches_itself();
        let itself = bodies.iter().filter(|_| untouched);
        let itself = itself.map(|b| one(format!("self-collision of `{}`", b.name), why.into()));
        let others = bodies.iter().enumerate().flat_map(|(i, a)| bodies[i + 1..].iter().map(move |b| (a, b)));
        let others = others.filter(|_| untouched);
        let others = others.map(|(a, b)| one(format!("contact `{}~{}`", a.name, b.name), why.into()));
        let relaxed = bodies.iter().filter_map(|b| {
            let Material::Cloth {
                areal_density_kg_m2: density,
                stretch_compliance_m_n: compliance,
                stretch_relaxation: s,
                bending_relaxation: r,
                ..
            } = b.material
            else {
                return None;
            };
            if s >= 1.0 && r >= 1.0 {
                return None;
            }
            let [exact, relaxed] = self.elongations(density, compliance, s);
            let told = format!("a hanging metre gets {exact:.1e} m longer by compliance, {relaxed:.1e} m by factors");
            Some(if self.params.relaxed {
                let why = "in mode `genesis` relaxation factors count, and stiffness depends on the substep";
                one(format!("compliances of `{}`", b.name), format!("{why}: {told}"))
            } else {
                let why =
                    "in mode `physical` compliances count; `params.mode = \"genesis\"` repeats published pictures";
                one(format!("relaxation factors {s} and {r} of `{}`", b.name), format!("{why}: {told}"))
            })
        });
        itself.chain(others).chain(relaxed).collect()
    }
}
