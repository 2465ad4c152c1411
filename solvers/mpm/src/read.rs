//! From a solver's part of a scene to a [`Model`], with every feature that is missing refused by name.

use cosplat_core::asset::{Asset, ParticleCloud};
use cosplat_core::plugin::{PluginError, SolverScene, part_actions};
use cosplat_core::scene::ActionKind;
use cosplat_core::scene::{Body, ContactLaw, PairSpec, Space};

use crate::contact::Pairs;
use crate::model::{Model, Shown};
use crate::params::Params;
use crate::read_regions::Parts;
use crate::real::Real;
use crate::sample::extent;
use crate::sim::Setting;
use crate::stable::Limits;
use crate::store::Seed;
use crate::walls::Surface;

/// Cells across the smallest extent of a body without a spacing.
const CELLS_ACROSS: f64 = 6.0;
/// Cells that sound crosses while particles of what flows keep the e-th part of what their motion has beside the grid's:
/// columns of sand and flow between plates change little beyond it, and grains that fly apart begin to gain energy at 10.
const MEMORY: f64 = 4.0;
/// Bodies and regions that fit into a sort key.
const MOST_PARTS: usize = 1 << 10;

/// Reads a scene; also what its particles start with.
pub(crate) fn read<R: Real>(scene: &SolverScene) -> Result<(Model<R>, Vec<Seed>), PluginError> {
    let params = Params::read(&scene.params).map_err(|wrong| refusal(&wrong))?;
    let mut reader = Reader { scene, params, dx: 1.0, refused: Vec::new() };
    reader.refuse_whole_features();
    reader.dx = reader.grid_spacing();
    let (mut seeds, mut shown, mut particles) = (Vec::new(), Vec::new(), Vec::new());
    let Parts { laws, owners, of } = reader.parts::<R>();
    for (i, (body, parts)) in scene.bodies.iter().zip(&of).enumerate() {
        let kinds: Vec<(u32, f64)> = parts.iter().map(|&p| (p, laws[p as usize].start())).collect();
        let first = seeds.len() as u32;
        let (new, show) = reader.body(body, i as u32, first, &kinds);
        particles.push(new.len() as u64);
        seeds.extend(new);
        shown.push(show);
    }
    let walls = scene.statics.iter().filter_map(|s| reader.wall(s)).collect();
    let pairs = reader.own_pairs(&shown);
    let (faces, partners, clouds) = reader.interfaces();
    if scene.actions.iter().any(|a| matches!(a.kind, ActionKind::Wind { .. })) {
        reader.refused.push("wind".into());
    }
    let masses: Vec<f64> = shown.iter().map(|s| s.mass).collect();
    let actions = part_actions(scene, &masses, &mut |what| reader.refused.push(what.into()));
    if !reader.refused.is_empty() {
        return Err(refusal(&reader.refused));
    }
    let takes = |i: usize| faces.iter().any(|f| f.body == i && f.role.takes_impulses());
    let carries = shown.iter().enumerate().map(|(i, s)| takes(i) || s.is_capture);
    let cells = reader.params.memory.unwrap_or(MEMORY);
    let keeps = laws
        .iter()
        .zip(&pairs.density)
        .map(|(law, density)| if law.flows() { cells * reader.dx / (law.stiffness() / density).sqrt() } else { 0.0 });
    let setting = Setting {
        dx: reader.dx,
        keeps: keeps.collect(),
        laws,
        owners,
        carries: carries.collect(),
        actions,
        pairs,
        partners,
        clouds,
        names: scene.bodies.iter().map(|b| b.name.clone()).collect(),
        limits: Limits {
            courant: reader.params.courant.unwrap_or(0.5),
            most: reader.params.most.unwrap_or(f64::INFINITY),
        },
        lightest: seeds.iter().map(|s: &Seed| s.mass).fold(f64::INFINITY, f64::min),
        largest: seeds.iter().map(|s: &Seed| s.volume).fold(0.0, f64::max),
        threads: scene.threads > 1,
    };
    let names = scene.bodies.iter().map(|b| b.name.clone()).collect();
    Ok((Model { names, shown, faces, walls, setting, particles, threads: scene.threads }, seeds))
}

fn refusal(list: &[String]) -> PluginError {
    PluginError::Unsupported(format!("the material point solver does not support: {}", list.join("; ")))
}

/// A scene on its way to a model.
pub(crate) struct Reader<'a> {
    pub(crate) scene: &'a SolverScene,
    pub(crate) params: Params,
    /// Grid spacing \[m\].
    pub(crate) dx: f64,
    /// What is missing, in words.
    pub(crate) refused: Vec<String>,
}

impl Reader<'_> {
    /// Notes a missing feature.
    pub(crate) fn refuse(&mut self, what: String) {
        self.refused.push(what);
    }

    fn refuse_whole_features(&mut self) {
        let scene = self.scene;
        if scene.space != Space::Full {
            self.refuse("slab".into());
        }
        self.refused.extend(scene.joints.iter().map(|j| format!("joints (`{}`)", j.name)));
        self.refused.extend(scene.links.iter().map(|l| format!("links (`{}`)", l.name)));
        if scene.bodies.iter().map(|b| 1 + b.regions.len()).sum::<usize>() > MOST_PARTS {
            self.refuse(format!("more than {MOST_PARTS} bodies and regions"));
        }
    }

    /// Particles that were prepared for a body.
    pub(crate) fn cloud(&self, body: &Body) -> Option<&ParticleCloud> {
        match self.scene.assets.get(&body.name).map(AsRef::as_ref) {
            Some(Asset::Particles(cloud)) => Some(cloud),
            _ => None,
        }
    }

    fn spacing_of(&self, body: &Body) -> Option<f64> {
        let given = self.cloud(body).map(|c| c.spacing_m).or(body.spacing_m);
        given.filter(|s| s.is_finite() && *s > 0.0)
    }

    fn grid_spacing(&self) -> f64 {
        let bodies = &self.scene.bodies;
        let given = bodies.iter().filter_map(|b| self.spacing_of(b)).fold(0.0, f64::max);
        let size = bodies.iter().filter_map(|b| extent(&b.source)).fold(f64::INFINITY, f64::min);
        let chosen = if given > 0.0 {
            2.0 * given
        } else if size.is_finite() {
            size / CELLS_ACROSS
        } else {
            1.0
        };
        self.params.spacing.unwrap_or(chosen)
    }

    /// The listed pair of two names.
    pub(crate) fn pair(&self, a: &str, b: &str) -> Option<&PairSpec> {
        self.scene.pairs.iter().find(|p| (p.a == a && p.b == b) || (p.a == b && p.b == a))
    }

    /// Surface of a listed pair; `None` where it is left out.
    pub(crate) fn surface(&mut self, pair: &PairSpec) -> Option<Surface> {
        if pair.enabled && pair.contact == ContactLaw::Genesis {
            self.refuse(format!("contact law genesis (`{}` and `{}`)", pair.a, pair.b));
        }
        if pair.enabled && pair.restitution != 0.0 {
            self.refuse(format!("restitution (`{}` and `{}`)", pair.a, pair.b));
        }
        pair.enabled.then_some(Surface::Coulomb(pair.static_friction, pair.kinetic_friction))
    }

    fn own_pairs(&mut self, shown: &[Shown]) -> Pairs {
        let bodies = &self.scene.bodies;
        let bonded =
            |a: &str, b: &str| self.params.bonded.iter().any(|[p, q]| (p == a && q == b) || (p == b && q == a));
        let sticks: Vec<Vec<bool>> =
            bodies.iter().map(|a| bodies.iter().map(|b| bonded(&a.name, &b.name)).collect()).collect();
        let surface = (0..bodies.len()).map(|a| {
            let row = (0..bodies.len()).map(|b| {
                if sticks[a][b] {
                    return Some(Surface::Stick);
                }
                let (a, b) = (&bodies[a], &bodies[b]);
                let defaults = cosplat_core::scene::PairDefaults::of_materials(&a.material, &b.material);
                match self.pair(&a.name, &b.name).cloned() {
                    Some(pair) => self.surface(&pair),
                    None => Some(Surface::Coulomb(defaults.static_friction, defaults.kinetic_friction)),
                }
            });
            row.collect()
        });
        Pairs { surface: surface.collect(), density: shown.iter().map(|s| s.mass / s.volume).collect() }
    }
}
