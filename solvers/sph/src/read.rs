//! From a solver's part of a scene to a [`Model`], with every feature that is missing refused by name.

use std::collections::BTreeMap;

use cosplat_core::boundary::{Vec3, add, dot, norm, scale};
use cosplat_core::distance::{Placed, Shape, SignedDistance};
use cosplat_core::plan::{BoundaryForm, LeftOut};
use cosplat_core::plugin::{Descriptor, PluginError, Refusals, SolverScene, ViewRole};
use cosplat_core::scene::{ActionKind, Body, Material, PairSpec, Source, StaticCollider, TAIT_EXPONENT, Wall};

use crate::cohesion;
use crate::cut::cut;
use crate::fill::{fill, spacing};
use crate::frame::Frame;
use crate::gates::{Drain, Inflow, layer};
use crate::kernel::Kernel;
use crate::model::{Face, Gravity, Liquid, Model, Solid};
use crate::params::{Params, Pressure, rough};
use crate::shell::{Piece, shell};
use crate::sim::{Motion, stable};
use crate::store::{Listed, Store};

/// Spacings that differ by less than this share are the same.
const SAME: f64 = 0.01;
/// Share of ρ c² above which the pressure that surface tension causes inside compresses a liquid too much.
const MOST_PRESSED: f64 = 0.1;
/// How much longer substeps must become for implicit viscosity to pay: a solution costs about as much as these.
const PAYS: f64 = 4.0;
/// Distance from a static solid, in spacings, below which a particle is left out at the start: at rest it is half.
const TOO_NEAR: f64 = 0.25;

/// Particles through an inflow above which it is refused.
const MOST_ENTERING: f64 = 3e6;

/// A model, its particles at t = 0, and what was left out.
pub(crate) type Read = (Model, Store, Vec<LeftOut>);

/// Reads a scene.
pub(crate) fn read(scene: &SolverScene, descriptor: &Descriptor) -> Result<Read, PluginError> {
    let mut refusals = Refusals::undeclared(descriptor, scene);
    let mut chosen = f64::NAN;
    for body in &scene.bodies {
        match spacing(scene, body) {
            Err(why) => refusals.push(why),
            Ok(d) if chosen.is_nan() => chosen = d,
            Ok(d) if (d / chosen - 1.0).abs() > SAME => {
                refusals.push(format!("spacings of {chosen} m and {d} m in one solver (body `{}`)", body.name));
            }
            Ok(_) => {}
        }
    }
    let spacing = if chosen.is_nan() { 1.0 } else { chosen };
    let model = Model {
        liquids: Vec::new(),
        body: Vec::new(),
        mass: Vec::new(),
        start: Vec::new(),
        solids: Vec::new(),
        statics: Vec::new(),
        faces: Vec::new(),
        interfaces: scene.interfaces.iter().map(|v| v.id).collect(),
        gravity: Vec::new(),
        head: 0.0,
        inflows: Vec::new(),
        drains: Vec::new(),
        kernel: Kernel::new(spacing),
        spacing,
        params: Params::read(scene, spacing)?,
        threads: scene.threads,
    };
    let mut reader = Reader { scene, model, refusals, left_out: Vec::new(), velocity: Vec::new() };
    // Where solids overlap the first one counts: in a corner with a wall that slips, the mirror image of one that does not.
    let (rough, smooth): (Vec<_>, Vec<_>) = scene.statics.iter().partition(|wall| wall.wall != Wall::Slip);
    for wall in rough.into_iter().chain(smooth) {
        reader.wall(wall);
    }
    for (index, body) in scene.bodies.iter().enumerate() {
        reader.body(index, body);
    }
    reader.pairs();
    reader.partners();
    reader.gravity();
    reader.drains();
    reader.calm();
    reader.viscosity();
    reader.refusals.finish()?;
    let Reader { model, left_out, velocity, .. } = reader;
    let mut rho: Vec<f64> = model.body.iter().map(|&b| model.liquids[b as usize].rho).collect();
    for inflow in &model.inflows {
        rho[inflow.ids.clone()].fill(0.0);
    }
    let entered = vec![0; model.inflows.len()];
    let id = (0..model.mass.len() as u32).collect();
    let warm = vec![0.0; if model.params.pressure == Pressure::Incompressible { model.mass.len() } else { 0 }];
    let store = Store {
        id,
        x: model.start.clone(),
        v: velocity,
        rho,
        warm,
        acceleration: 0.0,
        dissipated: 0.0,
        entered,
        listed: Listed::default(),
        rubbed: Vec::new(),
    };
    Ok((model, store, left_out))
}

struct Reader<'a> {
    scene: &'a SolverScene,
    model: Model,
    refusals: Refusals,
    left_out: Vec<LeftOut>,
    velocity: Vec<Vec3>,
}

impl Reader<'_> {
    /// Shape of a solid in its own frame, or about its centre of mass.
    fn shape(&mut self, name: &str, source: &Source, about_centre: bool) -> Option<Shape> {
        let asset = self.scene.assets.get(name).map(AsRef::as_ref);
        let made = Shape::exact(source, asset, about_centre);
        made.map_err(|why| self.refusals.push(format!("`{name}` as a solid: {why}"))).ok()
    }

    /// Boundary particles of a shape in its own frame; none for planes.
    fn pieces(&mut self, name: &str, shape: &Shape) -> Option<Vec<Piece>> {
        let made = shell(shape, self.model.spacing, self.model.kernel.reach);
        made.map_err(|why| self.refusals.push(format!("`{name}` as a solid: {why}"))).ok()
    }

    fn wall(&mut self, wall: &StaticCollider) {
        if wall.motion.is_some() {
            self.refusals.push(format!("moving static colliders (`{}`)", wall.name));
        }
        let (frame, solid) = (Frame::at(&wall.pose), self.model.solids.len());
        let Some(shape) = self.shape(&wall.name, &wall.source, false) else { return };
        let made = if matches!(shape, Shape::Plane(_)) {
            Solid::Plane(frame, shape.clone())
        } else {
            let Some(pieces) = self.pieces(&wall.name, &shape) else { return };
            let world = pieces.into_iter().map(|(x, volume, depth)| (frame.out(x), volume, depth));
            Solid::Fixed(world.filter(|(x, ..)| !self.model.taken(*x, solid)).collect())
        };
        self.model.solids.push(made);
        self.model.statics.push((solid, Placed::at(shape, &wall.pose)));
        for (body, own) in self.scene.bodies.iter().enumerate() {
            let pair = self.pair(&own.name, &wall.name);
            let plain = match wall.wall {
                Wall::Slip => 0.0,
                Wall::NoSlip => 1.0,
                Wall::Friction { kinetic_friction, .. } => kinetic_friction,
            };
            let slips = pair.as_ref().map_or(plain, |p| p.kinetic_friction) <= 0.0 && wall.wall != Wall::NoSlip;
            if pair.is_none_or(|p| p.enabled) {
                self.model.faces.push(Face { body, solid, interface: None, slips });
            }
        }
        if let Wall::Friction { static_friction, kinetic_friction } = wall.wall
            && static_friction.max(kinetic_friction) > 0.0
        {
            self.leave_out(
                format!("Coulomb friction of `{}` on liquids", wall.name),
                "a liquid sticks to a rough wall: no slip, by its viscosity",
                None,
            );
        }
    }

    fn leave_out(&mut self, what: String, why: &str, indicator: Option<f64>) {
        let why = why.to_owned();
        self.left_out.push(LeftOut { what, why, indicator, limit: None, saved: "not measured".to_owned() });
    }

    /// What the scene says about a pair.
    fn pair(&self, a: &str, b: &str) -> Option<PairSpec> {
        self.scene.pairs.iter().find(|p| (p.a == a && p.b == b) || (p.a == b && p.b == a)).cloned()
    }

    fn body(&mut self, index: usize, body: &Body) {
        let Material::SphLiquid { density_kg_m3: rho, stiffness_pa, viscosity_pa_s, surface_tension_n_m } =
            body.material
        else {
            return;
        };
        let tension = self.surface_tension(body, rho, surface_tension_n_m);
        if body.mass_kg.is_some() {
            self.refusals.push(format!("a mass beside the density of the material (body `{}`)", body.name));
        }
        if !(rho > 0.0 && stiffness_pa > 0.0 && viscosity_pa_s >= 0.0) {
            self.refusals.push(format!("a density or stiffness that is not positive (body `{}`)", body.name));
        }
        let (points, volumes) = match fill(self.scene, body, self.model.spacing) {
            Ok(filled) => filled,
            Err(why) => return self.refusals.push(why),
        };
        let all: f64 = volumes.iter().sum();
        let moment = points.iter().zip(&volumes).fold([0.0; 3], |s, (&x, &v)| add(s, scale(body.pose.apply(x), v)));
        let centre = scale(moment, 1.0 / all.max(f64::MIN_POSITIVE));
        let first = self.model.mass.len();
        for (x, volume) in self.outside(body, points.iter().map(|&x| body.pose.apply(x)).zip(volumes).collect()) {
            self.model.body.push(index as u32);
            self.model.mass.push(rho * volume);
            self.model.start.push(x);
            self.velocity.push(body.velocity.at(x, centre));
        }
        let end = self.model.mass.len();
        self.inflows(index, body, rho);
        if end == first {
            self.refusals.push(format!("a body without particles (body `{}`)", body.name));
        }
        let sound = body.material.wave_speed_m_s().unwrap_or(1.0);
        self.model.liquids.push(Liquid {
            name: body.name.clone(),
            rho,
            stiffness: stiffness_pa,
            equation: self.model.params.equation,
            sound,
            viscosity: viscosity_pa_s,
            thickness: 0.0,
            cohesion: cohesion::factor(tension, all / points.len().max(1) as f64, &self.model.kernel),
            tension,
            ids: first..self.model.mass.len(),
            coupled: self.scene.is_coupled(&body.name),
        });
    }

    /// What is left of particles of a body, places and volumes, outside static colliders and partners; the rest is told.
    fn outside(&mut self, body: &Body, mut all: Vec<(Vec3, f64)>) -> Vec<(Vec3, f64)> {
        let (of, near) = (all.len(), TOO_NEAR * self.model.spacing);
        all.retain(|(x, _)| self.model.statics.iter().all(|(_, placed)| placed.distance(*x).0 >= near));
        let mut lost = vec![(of - all.len(), "a static collider".to_owned())];
        let scene = self.scene;
        for view in scene.interfaces.iter().filter(|v| v.role == ViewRole::ContactResolver && v.own == body.name) {
            let (Some(source), Some(pose)) = (&view.partner_source, &view.partner_pose) else { continue };
            let asset = scene.assets.get(&view.partner).map(AsRef::as_ref);
            // A rigid shape that cannot be had is refused with the partner; of a cloud of particles or a cloth there is none.
            let Ok(shape) = Shape::exact(source, asset, false) else { continue };
            lost.push((cut(&Placed::at(shape, pose), &mut all), format!("`{}`", view.partner)));
        }
        for (lost, inside) in lost.into_iter().filter(|l| l.0 > 0) {
            let what = format!("{lost} of {of} particles of `{}`", body.name);
            self.leave_out(what, &format!("they lay inside {inside}"), Some(lost as f64));
        }
        all
    }

    /// Surface tension \[N/m\], left out where even a single particle is too heavy for it, by its Bond number `ρ g d²/σ`.
    fn surface_tension(&mut self, body: &Body, rho: f64, tension: f64) -> f64 {
        if tension <= 0.0 {
            return 0.0;
        }
        let bond = cohesion::bond(self.scene, rho, tension, self.model.spacing);
        if bond < cohesion::WEAK {
            if self.model.params.pressure == Pressure::Incompressible {
                self.refusals.push(format!(
                    "surface tension of the incompressible liquid `{}`, whose drops swing two and a half times too slowly; \
                     use pressure = \"wcsph\" or set it to 0",
                    body.name
                ));
            }
            let sound = body.material.wave_speed_m_s().unwrap_or(1.0);
            let (pressed, least) = (cohesion::inside(tension, &self.model.kernel), rho * sound * sound * MOST_PRESSED);
            if self.model.params.pressure == Pressure::Weak && pressed > least {
                self.refusals.push(format!(
                    "a surface tension of {tension} N/m at a spacing of {} m, which presses `{}` by {pressed:.3e} Pa, \
                     more than {MOST_PRESSED} ρ c²: a `stiffness` of at least {:.3e} Pa would bear it",
                    self.model.spacing,
                    body.name,
                    pressed / MOST_PRESSED / TAIT_EXPONENT
                ));
            }
            return tension;
        }
        self.left_out.push(LeftOut {
            what: format!("surface tension of `{}`", body.name),
            why: "it holds no drop as large as a particle against gravity: ρ g d²/σ is above the limit".to_owned(),
            indicator: Some(bond),
            limit: Some(cohesion::WEAK),
            saved: "not measured".to_owned(),
        });
        0.0
    }

    /// Least viscosity: Monaghan's α as a viscosity in three dimensions (Monaghan, "Smoothed particle hydrodynamics", 2005,
    /// §4.1).
    ///
    /// An incompressible liquid has no sound. There it is ten times the speed of a fall through the height of all liquid, the
    /// sound that a weakly compressible one would need: without any, what a lattice releases as it buckles under pressure stays
    /// as a tremble of single particles, in which a tank at rest scatters its pressures by a fifth.
    fn calm(&mut self) {
        let Model { params, kernel, head, .. } = &self.model;
        let (weak, fall, scale) =
            (params.pressure == Pressure::Weak, (2.0 * head).sqrt(), params.artificial * kernel.h);
        let mut left_out = Vec::new();
        for liquid in &mut self.model.liquids {
            let artificial = liquid.rho * scale * if weak { liquid.sound / 10.0 } else { fall };
            if artificial > liquid.viscosity {
                let what = format!("the viscosity of `{}` below {artificial:.3e} Pa s", liquid.name);
                left_out.push((what, liquid.viscosity));
                liquid.viscosity = artificial;
            }
        }
        for (what, given) in left_out {
            self.leave_out(what, "`artificial_viscosity` keeps the motion of particles in order", Some(given));
        }
    }

    /// Makes viscosity implicit where that pays, or where the user wants it.
    fn viscosity(&mut self) {
        let motion = Motion { pressed: self.model.head, ..Motion::default() };
        let (before, _) = stable(&self.model, motion);
        let as_explicit = self.model.liquids.clone();
        for liquid in &mut self.model.liquids {
            (liquid.thickness, liquid.viscosity) = (liquid.viscosity, 0.0);
        }
        let (after, _) = stable(&self.model, motion);
        let pays = before * PAYS < after && !rough(self.scene);
        if !self.model.params.implicit.unwrap_or(pays) {
            self.model.liquids = as_explicit;
        }
    }

    /// Particles that will enter a body: they wait in their openings.
    fn inflows(&mut self, index: usize, body: &Body, rho: f64) {
        for action in self.scene.actions.iter().filter(|a| a.bodies.contains(&body.name)) {
            let ActionKind::Inflow { center_m, velocity_m_s, opening } = action.kind else { continue };
            let places = layer(opening, center_m, velocity_m_s, self.model.spacing);
            let clock = &self.scene.clock;
            let end = clock.seconds(clock.start_of(clock.windows));
            let inflow = Inflow {
                ids: self.model.mass.len()..self.model.mass.len(),
                layer: places.len(),
                velocity: velocity_m_s,
                from: action.from_s,
                every: self.model.spacing / norm(velocity_m_s),
            };
            let layers = inflow.layers(action.until_s.unwrap_or(end).min(end));
            if layers * places.len() as f64 > MOST_ENTERING {
                self.refusals.push(format!(
                    "more than {MOST_ENTERING} particles through an inflow (`{}`); a coarser spacing or an earlier `until` \
                     helps",
                    body.name
                ));
                continue;
            }
            for &x in (0..layers as usize).flat_map(|_| &places) {
                self.model.body.push(index as u32);
                self.model.mass.push(rho * self.model.spacing.powi(3));
                self.model.start.push(x);
                self.velocity.push([0.0; 3]);
            }
            self.model.inflows.push(Inflow { ids: inflow.ids.start..self.model.mass.len(), ..inflow });
        }
    }

    fn drains(&mut self) {
        for action in &self.scene.actions {
            let ActionKind::Drain { center_m: center, size_m } = action.kind else { continue };
            let acts = self.scene.bodies.iter().map(|b| action.bodies.contains(&b.name)).collect();
            let until = action.until_s.unwrap_or(f64::INFINITY);
            self.model.drains.push(Drain { acts, center, half: scale(size_m, 0.5), from: action.from_s, until });
        }
    }

    fn pairs(&mut self) {
        let own = |name: &str| self.scene.bodies.iter().any(|b| b.name == name);
        let apart = self.scene.pairs.iter().filter(|p| !p.enabled && own(&p.a) && own(&p.b));
        for pair in apart.collect::<Vec<_>>() {
            self.refusals.push(format!("liquids that do not touch (`{}` and `{}`)", pair.a, pair.b));
        }
    }

    fn partners(&mut self) {
        let mut known = BTreeMap::new();
        for view in self.scene.interfaces.iter().filter(|v| v.role == ViewRole::ContactResolver) {
            let Some(body) = self.scene.bodies.iter().position(|b| b.name == view.own) else {
                self.refusals.push(format!("interfaces of bodies it does not have (`{}`)", view.own));
                continue;
            };
            let solid = if let Some(&solid) = known.get(&view.partner) {
                solid
            } else {
                let made = if view.partner_form == BoundaryForm::Proxy {
                    let Some(source) = &view.partner_source else {
                        self.refusals.push(format!("rigid partners without a shape (`{}`)", view.partner));
                        continue;
                    };
                    let shape = self.shape(&view.partner, source, true);
                    let Some(pieces) = shape.and_then(|shape| self.pieces(&view.partner, &shape)) else { continue };
                    Solid::Rigid(view.partner.clone(), pieces)
                } else {
                    Solid::Sampled(view.partner.clone())
                };
                self.model.solids.push(made);
                known.insert(view.partner.clone(), self.model.solids.len() - 1);
                self.model.solids.len() - 1
            };
            let slips = view.pair.as_ref().is_some_and(|p| p.kinetic_friction <= 0.0);
            self.model.faces.push(Face { body, solid, interface: Some(view.id), slips });
        }
    }

    fn gravity(&mut self) {
        for action in &self.scene.actions {
            if let ActionKind::Gravity { acceleration_m_s2: acceleration } = action.kind {
                let all = action.bodies.is_empty();
                let acts = self.scene.bodies.iter().map(|b| all || action.bodies.contains(&b.name)).collect();
                let until = action.until_s.unwrap_or(f64::INFINITY);
                let always = action.always();
                self.model.gravity.push(Gravity { acceleration, acts, from: action.from_s, until, always });
                let along = |f: fn(f64, f64) -> f64, start: f64| {
                    self.model.start.iter().map(|&x| dot(acceleration, x)).fold(start, f)
                };
                let height = along(f64::max, f64::NEG_INFINITY) - along(f64::min, f64::INFINITY);
                self.model.head += height.max(0.0);
            }
        }
    }
}
