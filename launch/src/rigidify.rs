//! Bodies whose deformation cannot be seen become rigid: no particles, no grid, one process less where none is left.
//!
//! Three estimates of how far a body deforms are compared with a quarter of its grid spacing: sagging under its own
//! weight, the elastic and the plastic dent of the striker that dents it most. `run.rigidify = false` keeps all of them
//! deformable. Sand, snow, liquids and viscoplastic bodies flow, however stiff they are: they stay as they are.

use std::f64::consts::PI;

use cosplat_core::boundary::{norm, sub};
use cosplat_core::plan::LeftOut;
use cosplat_core::scene::{ActionKind, Body, Field, Material, Scene, Source, VelocityField};

/// Part of the grid spacing that is too small to be seen.
const UNSEEN: f64 = 0.25;
/// Grid spacing over particle spacing.
const GRID: f64 = 2.0;
/// Particle spacings across the smallest extent of a body that has no spacing.
const ACROSS: f64 = 12.0;
/// Friction of a surface whose material names none.
const FRICTION: f64 = 0.5;
/// Solver of rigid bodies.
const RIGID: &str = "rigid";

/// How far a body is expected to deform \[m\].
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Estimate {
    /// Body.
    pub(crate) body: String,
    /// Under its own weight, `ρ g H L / (λ + 2μ)`.
    pub(crate) sag_m: f64,
    /// Elastic dent of the worst striker, `(15 m v² / (16 E* √R))^(2/5)` (Hertz).
    pub(crate) elastic_m: f64,
    /// Plastic dent, `v √(m / (5.6 π R σ_y))`; 0 for what does not yield.
    pub(crate) plastic_m: f64,
    /// The striker, if there is one.
    pub(crate) striker: Option<String>,
    /// What could just be seen.
    pub(crate) limit_m: f64,
}

impl Estimate {
    fn largest_m(&self) -> f64 {
        self.sag_m.max(self.elastic_m).max(self.plastic_m)
    }

    fn words(&self) -> String {
        let striker = self.striker.as_ref().map_or("no striker".to_owned(), |s| format!("struck by `{s}`"));
        format!(
            "own weight {:.1e} m, elastic dent {:.1e} m, plastic dent {:.1e} m ({striker}), visible from {:.1e} m",
            self.sag_m, self.elastic_m, self.plastic_m, self.limit_m
        )
    }

    /// For people, where the body stays deformable.
    pub(crate) fn kept(&self) -> String {
        let verdict = if self.largest_m() < self.limit_m { "could be rigid" } else { "deforms visibly" };
        format!("{verdict}: {}", self.words())
    }
}

/// What was decided.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Decisions {
    /// Bodies that became rigid.
    pub(crate) left_out: Vec<LeftOut>,
    /// Bodies that stay deformable, and why.
    pub(crate) kept: Vec<Estimate>,
}

/// Makes those bodies of a scene rigid whose deformation cannot be seen. `extent` tells the edges of the box around a
/// body \[m\], where they are known.
pub(crate) fn rigidify(scene: &mut Scene, extent: impl Fn(&Body) -> Option<[f64; 3]>) -> Decisions {
    if !scene.run.rigidify {
        return Decisions::default();
    }
    let estimates: Vec<Option<Estimate>> = scene.bodies.iter().map(|b| estimate(scene, b, &extent)).collect();
    let mut decisions = Decisions::default();
    for (body, estimate) in scene.bodies.iter_mut().zip(estimates) {
        let Some(estimate) = estimate else { continue };
        let has_shape = !matches!(body.source, Source::Splat { .. });
        let density = body.material.density();
        match density.filter(|_| has_shape && estimate.largest_m() < estimate.limit_m) {
            Some(density_kg_m3) => {
                decisions.left_out.push(left_out(&estimate, &body.solver));
                body.material = Material::Rigid { density_kg_m3, friction: FRICTION };
                RIGID.clone_into(&mut body.solver);
            }
            None => decisions.kept.push(estimate),
        }
    }
    decisions
}

/// Estimates of the captures of a scene, which cannot become rigid here: their particles are what carries their Gaussians.
pub(crate) fn of_captures(scene: &Scene, extent: impl Fn(&Body) -> Option<[f64; 3]>) -> Vec<Estimate> {
    let captures = scene.bodies.iter().filter(|b| scene.run.rigidify && matches!(b.source, Source::Splat { .. }));
    captures.filter_map(|body| estimate(scene, body, &extent)).collect()
}

fn left_out(estimate: &Estimate, solver: &str) -> LeftOut {
    LeftOut {
        what: format!("deformation of body `{}`", estimate.body),
        why: format!("it becomes rigid: {}; `run.rigidify = false` keeps it", estimate.words()),
        indicator: Some(estimate.largest_m()),
        limit: Some(estimate.limit_m),
        saved: format!("its particles in solver `{solver}`; not measured"),
    }
}

/// The estimate of a solid that may deform.
fn estimate(scene: &Scene, body: &Body, extent: &impl Fn(&Body) -> Option<[f64; 3]>) -> Option<Estimate> {
    let (Material::Elastic { density_kg_m3, youngs_modulus_pa, poissons_ratio, .. }
    | Material::Elastoplastic { density_kg_m3, youngs_modulus_pa, poissons_ratio, .. }) = body.material
    else {
        return None;
    };
    if !body.regions.is_empty() {
        // The estimates are those of one material.
        return None;
    }
    let size = extent(body)?;
    let longest = size.into_iter().fold(0.0, f64::max);
    let shortest = size.into_iter().fold(f64::INFINITY, f64::min);
    let spacing = body.spacing_m.unwrap_or(shortest / ACROSS);
    let stiffness = body.material.lame()?.p_wave_modulus_pa();
    let effective_pa = youngs_modulus_pa / (1.0 - poissons_ratio * poissons_ratio);
    let yield_pa = match body.material {
        Material::Elastoplastic { yield_stress_pa, .. } => Some(yield_stress_pa),
        _ => None,
    };
    let dents = |other: &Body| {
        let (m, v, r) = strike(scene, body, other, extent)?;
        let elastic = (15.0 * m * v * v / (16.0 * effective_pa * r.sqrt())).powf(0.4);
        let plastic = yield_pa.map_or(0.0, |y| v * (m / (5.6 * PI * r * y)).sqrt());
        Some((elastic, plastic, other.name.clone()))
    };
    let others = scene.bodies.iter().filter(|o| o.name != body.name);
    let worst = others.filter_map(dents).max_by(|a, b| a.0.max(a.1).total_cmp(&b.0.max(b.1)));
    let (elastic_m, plastic_m, striker) = worst.map_or((0.0, 0.0, None), |(e, p, s)| (e, p, Some(s)));
    Some(Estimate {
        body: body.name.clone(),
        sag_m: density_kg_m3 * gravity_m_s2(scene) * size[2] * longest / stiffness,
        elastic_m,
        plastic_m,
        striker,
        limit_m: UNSEEN * GRID * spacing,
    })
}

/// Mass \[kg\], speed \[m/s\] and radius \[m\] with which one body may strike another.
fn strike(
    scene: &Scene,
    body: &Body,
    other: &Body,
    extent: &impl Fn(&Body) -> Option<[f64; 3]>,
) -> Option<(f64, f64, f64)> {
    if !scene.pair(&body.name, &other.name).enabled {
        return None;
    }
    let [x, y, z] = extent(other)?;
    // Of the box around it: a solid has about half of that, which is well within what an estimate can say.
    let volume = 0.5 * x * y * z;
    let mass = other.mass_kg.or_else(|| Some(other.material.density()? * volume))?;
    let radius = (3.0 * volume / (4.0 * PI)).cbrt();
    let gap = (sub(body.pose.position_m, other.pose.position_m)[2]).abs();
    let speed = norm(sub(speed_of(body), speed_of(other)));
    Some((mass, (speed * speed + 2.0 * gravity_m_s2(scene) * gap).sqrt(), radius))
}

fn speed_of(body: &Body) -> [f64; 3] {
    match body.velocity {
        VelocityField::Twist { linear_m_s, .. } | VelocityField::LinearMap { linear_m_s, .. } => linear_m_s,
        VelocityField::Rotation { .. } => [0.0; 3],
    }
}

/// Strongest gravity of the scene \[m/s²\].
fn gravity_m_s2(scene: &Scene) -> f64 {
    let strength = |kind: &ActionKind| match kind {
        ActionKind::Gravity { acceleration_m_s2 }
        | ActionKind::AccelerationField { field: Field::Constant { acceleration_m_s2 } } => norm(*acceleration_m_s2),
        _ => 0.0,
    };
    scene.actions.iter().map(|a| strength(&a.kind)).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use cosplat_core::scene::read::parse;

    const SCENE: &str = r#"
format = 1
name = "x"
[clock]
duration = 1
[[body]]
name = "block"
material = { kind = "elastoplastic", density = 1000, youngs_modulus = 1e9, poissons_ratio = 0.25, yield_stress = 1e7 }
solver = "mpm"
box = [0.4, 0.3, 0.2]
spacing = 0.01
[[body]]
name = "stone"
material = "rigid"
solver = "rigid"
mass = 0.5
box = [0.1, 0.1, 0.1]
position = [0, 0, 0.5]
velocity = [0, 0, -3]
[[action]]
kind = "gravity"
acceleration = [0, 0, -9.81]
"#;

    fn extent(body: &Body) -> Option<[f64; 3]> {
        match body.source {
            Source::Box { size_m } => Some(size_m),
            _ => None,
        }
    }

    fn decided(changes: &[(&str, &str)]) -> (Scene, Decisions) {
        let text = changes.iter().fold(SCENE.to_owned(), |text, (from, to)| text.replace(from, to));
        let (mut scene, _) = parse(&text).unwrap();
        let decisions = rigidify(&mut scene, extent);
        (scene, decisions)
    }

    #[test]
    fn the_three_estimates_are_those_of_the_formulas() {
        // A softer block stays deformable, so that its estimates can be seen.
        let (_, decisions) = decided(&[("1e9", "1e6"), ("1e7", "1e4")]);
        let found = &decisions.kept[0];
        // λ + 2μ = 1.2 E at ν = 1/4; ρ g H L = 1000 · 9.81 · 0.2 · 0.4 Pa m.
        assert!((found.sag_m / (784.8 / 1.2e6) - 1.0).abs() < 1e-12, "{found:?}");
        // v² = 9 + 2 · 9.81 · 0.5; R from half of the litre around the stone.
        let (v2, r) = (9.0 + 9.81_f64, (3.0 * 0.5e-3 / (4.0 * PI)).cbrt());
        let elastic = (15.0 * 0.5 * v2 / (16.0 * 1e6 / (1.0 - 0.0625) * r.sqrt())).powf(0.4);
        assert!((found.elastic_m / elastic - 1.0).abs() < 1e-12, "{found:?}");
        let plastic = (v2 * 0.5 / (5.6 * PI * r * 1e4)).sqrt();
        assert!((found.plastic_m / plastic - 1.0).abs() < 1e-12, "{found:?}");
        assert_eq!((found.striker.as_deref(), found.limit_m), (Some("stone"), 0.005));
    }

    #[test]
    fn a_stiff_block_becomes_rigid_and_the_entry_says_what_is_missed() {
        let (scene, decisions) = decided(&[]);
        assert_eq!(scene.bodies[0].solver, "rigid");
        assert_eq!(scene.bodies[0].material.density(), Some(1000.0));
        assert_eq!(scene.bodies[0].material.name(), "rigid");
        let entry = &decisions.left_out[0];
        assert_eq!(entry.what, "deformation of body `block`");
        assert!(entry.indicator < entry.limit && entry.why.contains("plastic dent"), "{entry:?}");
    }

    #[test]
    fn a_harder_blow_no_gap_and_force_keep_it() {
        assert_eq!(decided(&[("[0, 0, -3]", "[0, 0, -30]")]).0.bodies[0].solver, "mpm");
        assert_eq!(decided(&[("1e7", "1e5")]).0.bodies[0].solver, "mpm");
        let forced = decided(&[("duration = 1", "duration = 1\n[run]\nrigidify = false")]);
        assert_eq!((forced.0.bodies[0].solver.as_str(), forced.1), ("mpm", Decisions::default()));
    }
}
