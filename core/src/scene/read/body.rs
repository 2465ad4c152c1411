//! `[[body]]` and `[[static]]`.

use super::fields::Fields;
use super::limits::Limits;
use super::names::{self, Kind};
use super::node::{Origin, Value};
use super::report::{nearest, quoted};
use super::value::At;
use super::{binding, material, motion, pair, region, source};
use crate::scene::material::Material;
use crate::scene::model::{Body, BodyBinding, Source, StaticCollider, Wall};
use crate::scene::pair::DEFAULT_FRICTION;

/// One `[[body]]` and what its Gaussians are tied to; none if something that others depend on could not be read.
pub(super) fn body(fields: &Fields<'_>) -> Option<(Body, Option<BodyBinding>)> {
    let name = fields.must("name", |at| names::declare(&at, Kind::Body));
    let has_mass = fields.has("mass");
    let material = fields.must("material", |at| material::material(&at, has_mass)).flatten();
    let regions = fields.tables("region", region::region);
    let source = source::source(fields);
    let solver = fields.opt("solver", |at| solver_name(&at));
    let (pose, velocity) = (motion::pose(fields), motion::initial_velocity(fields));
    let prescribed = fields.opt("prescribed", |at| motion::motion(&at)).flatten();
    for key in ["velocity", "angular_velocity", "velocity_field"] {
        fields.exclude("prescribed", key);
    }
    let mass_kg = fields.opt("mass", |at| at.num(Limits::positive("kg")));
    let spacing_m = fields.opt("spacing", |at| at.num(Limits::positive("m")));
    let color = motion::color(fields);
    let binding = binding::binding(fields);
    check_fit(fields, material.as_ref(), source.as_ref());

    let (name, material, source) = (name?, material?, source?);
    binding::check(fields, binding.as_ref(), &source);
    let solver = solver.unwrap_or_else(|| material.default_solver().to_owned());
    let body = Body { name, solver, material, regions, source, pose, mass_kg, spacing_m, velocity, prescribed, color };
    Some((body, binding))
}

/// Complains about materials and shapes that do not go together.
fn check_fit(fields: &Fields<'_>, material: Option<&Material>, source: Option<&Source>) {
    if matches!(material, Some(Material::PointMass)) {
        fields.need("mass");
        if !matches!(source, None | Some(Source::Points { .. } | Source::Cloud { .. })) {
            let help = "give `points`, for example points = [[0, 0, 0]]";
            fields.error("a point mass is made of points, not of a shape".to_owned(), Some(help.to_owned()));
        }
    }
    if let (Some(Source::HeightField { .. }), Some(at)) = (source, fields.get("height_field")) {
        let help = "make it a `[[static]]`, or take a closed `mesh`";
        at.error("a body cannot be a height field, which encloses nothing".to_owned(), Some(help.to_owned()));
    }
    if let (Some(Source::Plane { size_m: None }), Some(at)) = (source, fields.get("plane")) {
        let help = "give it a size, as in plane = [2.0, 2.0], or make it a `[[static]]`";
        at.error("a body cannot be an infinite plane".to_owned(), Some(help.to_owned()));
    }
}

/// A solver by name. Which plugins there are is not known here, so only a name close to a section is refused.
pub(super) fn solver_name(at: &At<'_>) -> String {
    let name = at.name();
    super::solver::check_free(&name, &at.node.origin, &at.path, at.report);
    let used = SolverUse { name: name.clone(), origin: at.node.origin.clone(), path: at.path.clone() };
    at.report.solver_uses.borrow_mut().push(used);
    name
}

/// A solver named somewhere, checked when all solver sections are known.
pub(super) struct SolverUse {
    pub(super) name: String,
    origin: Origin,
    path: String,
}

/// Complains about solver names that are almost those of a section.
pub(super) fn check_solver_names(fields: &Fields<'_>, sections: &[&str]) {
    for used in fields.report.solver_uses.borrow().iter().filter(|used| !used.name.is_empty()) {
        if sections.contains(&used.name.as_str()) || is_known_plugin(&used.name) {
            continue;
        }
        if let Some(near) = nearest(&used.name, sections.iter().copied()) {
            let message = format!("there is no solver named {}", quoted(&used.name));
            let help = format!("did you mean `{near}`? A plugin {0} needs a section `[solver.{0}]`", used.name);
            fields.report.absence(&used.origin, &used.path, message, Some(help));
        }
    }
}

/// Whether some material goes there by default.
fn is_known_plugin(name: &str) -> bool {
    crate::scene::presets::presets().any(|preset| preset.material.default_solver() == name)
        || Material::PointMass.default_solver() == name
}

/// One `[[static]]`.
pub(super) fn static_collider(fields: &Fields<'_>) -> Option<StaticCollider> {
    let name = fields.must("name", |at| names::declare(&at, Kind::Static));
    let source = source::source(fields);
    if let Some(Source::Points { .. } | Source::Cloud { .. }) = source {
        fields.error("a static collider needs a surface, not points".to_owned(), None);
    }
    let default = Wall::Friction { static_friction: DEFAULT_FRICTION, kinetic_friction: DEFAULT_FRICTION };
    let pose = motion::pose(fields);
    let wall = fields.opt("wall", |at| wall(&at)).flatten().unwrap_or(default);
    let motion = fields.opt("motion", |at| motion::motion(&at)).flatten();
    let color = motion::color(fields);
    Some(StaticCollider { name: name?, source: source?, pose, wall, motion, color })
}

fn wall(at: &At<'_>) -> Option<Wall> {
    if let Value::Table(_) = at.node.value {
        return at.table(|fields| {
            let (static_friction, kinetic_friction) = pair::frictions(fields, None);
            Wall::Friction { static_friction, kinetic_friction }
        });
    }
    at.word(&[("slip", Wall::Slip), ("no-slip", Wall::NoSlip)])
}
