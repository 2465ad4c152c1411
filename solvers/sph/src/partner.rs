//! Partners over one window: what they show, and what the liquid does to them.

use cosplat_core::boundary::{BoundaryState, Impulses, Vec3, Wrench, add, cross, scale};
use cosplat_core::plugin::{Inputs, InterfaceReport, PartnerInput, PartnerSetup, PluginError};
use cosplat_core::scene::MotionRule;

use crate::model::{Model, Solid};
use crate::proxy::Proxy;
use crate::wall::{Walls, reaction, size};

/// Samples of a partner farther apart than this many spacings let the liquid through.
const WIDEST: f64 = 1.5;

/// Spacings below which a partner's thickness, its volume over its area, makes it a sheet: one layer, whatever its normals.
const THIN: f64 = 0.25;

/// Layers of boundary particles of a solid that shows samples with normals: the samples, and one a spacing below. What the
/// lower one takes goes to its sample; across a spacing that misses a moment of tangential forces only.
const LAYERS: usize = 2;

/// Sample to which the boundary particle with that number belongs.
pub(crate) fn sample_of(number: u32) -> usize {
    number as usize / LAYERS
}

/// Samples of a partner now.
#[derive(Clone, Debug)]
pub(crate) struct SampleSet {
    pub(crate) solid: usize,
    pub(crate) input: PartnerInput,
    /// Positions \[m\], velocities \[m/s\] and volumes \[m³\].
    pub(crate) x: Vec<Vec3>,
    pub(crate) v: Vec<Vec3>,
    /// Places at the start of the window \[m\].
    pub(crate) start: Vec<Vec3>,
    volume: Vec<f64>,
    /// Masses \[kg\].
    pub(crate) mass: Vec<f64>,
    /// Outward normals, where samples of a solid show them.
    normal: Vec<Vec3>,
    /// Distance of layers \[m\], and how much more volume one layer alone must have.
    depth: f64,
    alone: f64,
}

impl SampleSet {
    /// Boundary particles: their numbers, places \[m\], volumes \[m³\] and depths \[m\]: a sample stands for a layer of which it
    /// is the middle.
    pub(crate) fn pieces(&self) -> impl Iterator<Item = (usize, Vec3, f64, f64)> {
        let layers = if self.normal.is_empty() { 1 } else { LAYERS };
        let factor = if layers == 1 { self.alone } else { 1.0 };
        (0..self.x.len() * layers).map(move |i| {
            let number = i / layers * LAYERS + i % layers;
            let depth = (0.5 + (i % layers) as f64) * self.depth;
            (number, self.at(number).0, self.volume[i / layers] * factor, depth)
        })
    }

    /// Place and velocity of boundary particle `number`.
    pub(crate) fn at(&self, number: usize) -> (Vec3, Vec3) {
        let (sample, layer) = (number / LAYERS, number % LAYERS);
        let below = self.normal.get(sample).map_or([0.0; 3], |n| scale(*n, -(layer as f64) * self.depth));
        (add(self.x[sample], below), self.v[sample])
    }
}

/// What crossed at a face.
#[derive(Clone, Debug, Default)]
pub(crate) struct Crossed {
    /// On the own body, about the origin.
    received: Wrench,
    gross: f64,
    work: f64,
    /// On a rigid partner, about its centre at the start of the window.
    rigid: Wrench,
    /// On each sample \[N s\], and the part of it that is friction.
    pub(crate) samples: Vec<Vec3>,
    pub(crate) rubbed: Vec<Vec3>,
}

/// All partners over a window.
#[derive(Clone, Debug, Default)]
pub(crate) struct Partners {
    proxies: Vec<Proxy>,
    pub(crate) sets: Vec<SampleSet>,
    /// By face.
    pub(crate) crossed: Vec<Crossed>,
}

/// What never changes about a sampled partner.
#[derive(Clone, Debug, Default)]
pub(crate) struct Known {
    /// Number of its solid.
    solid: usize,
    /// Volumes that its samples stand for \[m³\], and their masses \[kg\]: infinite where it does not tell.
    volume: Vec<f64>,
    mass: Vec<f64>,
    /// Whether it is thin, with liquid on both sides.
    thin: bool,
}

/// Reads what never changes about sampled partners.
pub(crate) fn known(model: &Model, setups: &[PartnerSetup]) -> Result<Vec<Known>, PluginError> {
    let d = model.spacing;
    let mut all: Vec<Known> = Vec::new();
    for face in &model.faces {
        let Solid::Sampled(name) = &model.solids[face.solid] else { continue };
        if all.iter().any(|k| k.solid == face.solid) {
            continue;
        }
        let refuse = |what: String| Err(PluginError::Unsupported(format!("the sph solver does not support: {what}")));
        let Some(setup) = setups.iter().find(|s| Some(s.interface) == face.interface) else {
            return refuse(format!("partners without samples (`{name}`)"));
        };
        let statics = &setup.statics;
        let columns = [statics.area_m2.len(), statics.volume_m3.len()];
        if columns != [statics.len(); 2] || statics.area_m2.iter().chain(&statics.volume_m3).any(|v| !v.is_finite()) {
            return refuse(format!("partners whose samples have no area and volume (`{name}`)"));
        }
        let mean = statics.area_m2.iter().sum::<f64>() / statics.len().max(1) as f64;
        if mean > WIDEST * WIDEST * d * d {
            return refuse(format!(
                "samples {:.3} m apart, which a liquid of spacing {d} m passes (`{name}`): give `{name}` a spacing of at \
                 most {:.3} m, or the liquid a coarser one",
                mean.sqrt(),
                WIDEST * d
            ));
        }
        let one = |(&area, &volume): (&f64, &f64)| match (area > 0.0, volume > 0.0) {
            (true, _) => area * d,
            (false, true) => volume,
            (false, false) => d * d * d,
        };
        let thick: f64 =
            statics.volume_m3.iter().zip(&statics.area_m2).filter(|(_, a)| **a > 0.0).map(|(v, _)| v).sum();
        let thin = thick < THIN * d * statics.area_m2.iter().sum::<f64>();
        let volume = statics.area_m2.iter().zip(&statics.volume_m3).map(one).collect();
        let heavy = |i: usize| statics.mass_kg.get(i).copied().filter(|m| *m > 0.0).unwrap_or(f64::INFINITY);
        all.push(Known { solid: face.solid, volume, mass: (0..statics.len()).map(heavy).collect(), thin });
    }
    Ok(all)
}

impl Partners {
    /// What is heard of all partners at the start of a window.
    pub(crate) fn hear(model: &Model, known: &[Known], inputs: &Inputs) -> Result<Self, PluginError> {
        let mut all = Self { crossed: vec![Crossed::default(); model.faces.len()], ..Self::default() };
        for (f, face) in model.faces.iter().enumerate() {
            let Some(interface) = face.interface else { continue };
            let (Solid::Rigid(name, _) | Solid::Sampled(name)) = &model.solids[face.solid] else { continue };
            let missing = || PluginError::Unsupported(format!("a step without the boundary of partner `{name}`"));
            let input = inputs.partner(interface).ok_or_else(missing)?;
            match (&model.solids[face.solid], &input.now) {
                (Solid::Rigid(_, pieces), BoundaryState::Proxy(record)) => {
                    if !Proxy::is_sound(record) {
                        return Err(PluginError::Physics(format!("the record of partner `{name}` is not finite")));
                    }
                    if all.proxy(face.solid).is_none() {
                        all.proxies.push(Proxy::new(face.solid, record, pieces));
                    }
                }
                (Solid::Rigid(..), BoundaryState::Samples(_)) => {
                    return Err(PluginError::Unsupported(format!("`{name}` is rigid, but shows samples")));
                }
                (_, _) => {
                    let known = known.iter().find(|k| k.solid == face.solid).cloned().unwrap_or_default();
                    let Known { volume, mass, thin, .. } = known;
                    let mut set = SampleSet {
                        solid: face.solid,
                        input: input.clone(),
                        x: Vec::new(),
                        v: Vec::new(),
                        start: Vec::new(),
                        volume,
                        mass,
                        normal: Vec::new(),
                        depth: model.spacing,
                        alone: model.kernel.single_layer(model.spacing),
                    };
                    let count = set.volume.len();
                    let shown = input.samples(name, count)?;
                    if shown.normal.len() == count && !thin {
                        set.normal.clone_from(&shown.normal);
                    }
                    if let Some(next) = &input.next {
                        PartnerInput { now: next.clone(), next: None, ..input.clone() }.samples(name, count)?;
                    }
                    all.crossed[f].samples = vec![[0.0; 3]; count];
                    all.crossed[f].rubbed = vec![[0.0; 3]; count];
                    (set.x, set.v) = (vec![[0.0; 3]; count], vec![[0.0; 3]; count]);
                    if all.samples(face.solid).is_none() {
                        all.sets.push(set);
                    }
                }
            }
        }
        all.place(0.0);
        all.sets.iter_mut().for_each(|set| set.start.clone_from(&set.x));
        Ok(all)
    }

    /// Stand-in of a rigid solid.
    pub(crate) fn proxy(&self, solid: usize) -> Option<&Proxy> {
        self.proxies.iter().find(|p| p.solid == solid)
    }

    /// All stand-ins.
    pub(crate) fn proxies(&self) -> &[Proxy] {
        &self.proxies
    }

    /// Samples of a solid.
    pub(crate) fn samples(&self, solid: usize) -> Option<&SampleSet> {
        self.sets.iter().find(|s| s.solid == solid)
    }

    /// Places of all their boundary particles \[m\], face by face.
    pub(crate) fn places(&self, model: &Model) -> Vec<Vec3> {
        let mut all = Vec::new();
        for face in &model.faces {
            match &model.solids[face.solid] {
                Solid::Rigid(_, pieces) => {
                    let Some(proxy) = self.proxy(face.solid) else { continue };
                    all.extend(pieces.iter().map(|piece| proxy.frame.out(piece.0)));
                }
                Solid::Sampled(_) => {
                    let Some(samples) = self.samples(face.solid) else { continue };
                    all.extend(samples.pieces().map(|piece| piece.1));
                }
                Solid::Plane(..) | Solid::Fixed(_) => {}
            }
        }
        all
    }

    /// Largest speed of any partner \[m/s\].
    pub(crate) fn speed(&self) -> f64 {
        let samples = self.sets.iter().flat_map(|s| &s.v).map(|&v| cosplat_core::boundary::norm(v));
        self.proxies.iter().map(Proxy::speed).chain(samples).fold(0.0, f64::max)
    }

    /// Longest substep \[s\] in which a rigid partner cannot be thrown farther by the liquid that it compresses than it came,
    /// and its name: a mass m on a layer of liquid of stiffness `ρ c² A/d`, with the area A of its circumscribed circle.
    pub(crate) fn lightest<'a>(&self, model: &'a Model) -> Option<(f64, &'a str)> {
        let stiff = model.liquids.iter().map(|l| l.rho * l.sound * l.sound).fold(0.0, f64::max) / model.spacing;
        let each = self.proxies.iter().map(|p| (p.swing(stiff), p.solid));
        let (dt, solid) = each.min_by(|a, b| a.0.total_cmp(&b.0))?;
        if let Solid::Rigid(name, _) = &model.solids[solid] { Some((dt, name)) } else { None }
    }

    /// Moves samples to where they are `after` \[s\] the start of the window.
    ///
    /// Under the rule `hold` they stay, but the liquid sees the velocity that they show: it takes them to where they will
    /// be in the next window.
    pub(crate) fn place(&mut self, after: f64) {
        for set in &mut self.sets {
            let newest = set.input.next.as_ref().unwrap_or(&set.input.now);
            let BoundaryState::Samples(shown) = newest else { continue };
            for (i, (x, v)) in set.x.iter_mut().zip(&mut set.v).enumerate() {
                let [c0, c1, c2, c3] = set.input.path(i);
                *x = add(c0, scale(add(c1, scale(add(c2, scale(c3, after)), after)), after));
                *v = if set.input.rule == MotionRule::Hold {
                    shown.velocity[i]
                } else {
                    add(c1, scale(add(scale(c2, 2.0), scale(c3, 3.0 * after)), after))
                };
            }
        }
    }

    /// Books the impulses of one substep and gives rigid partners theirs.
    pub(crate) fn book(&mut self, model: &Model, walls: &Walls, dt: f64) {
        let mut owed = vec![[[0.0; 3]; 2]; self.proxies.len()];
        for piece in &walls.pieces {
            let face = &model.faces[piece.face as usize];
            if face.interface.is_none() {
                continue;
            }
            let on_liquid = Wrench { linear: piece.impulse, angular: cross(piece.x, piece.impulse) };
            let crossed = &mut self.crossed[piece.face as usize];
            crossed.received = crossed.received.plus(on_liquid);
            crossed.gross += size(piece);
            crossed.work += piece.work;
            if let Some(p) = self.proxies.iter().position(|p| p.solid == face.solid) {
                let proxy = &self.proxies[p];
                let (impulse, about_start) = reaction(piece, proxy.start);
                crossed.rigid = crossed.rigid.plus(Wrench { linear: impulse, angular: about_start });
                let (_, moment) = reaction(piece, proxy.frame.origin);
                owed[p] = [add(owed[p][0], impulse), add(owed[p][1], moment)];
            } else if let Some(sample) = crossed.samples.get_mut(sample_of(piece.index)) {
                *sample = add(*sample, scale(piece.impulse, -1.0));
                let rubbed = &mut crossed.rubbed[sample_of(piece.index)];
                *rubbed = add(*rubbed, scale(piece.rubbed, -1.0));
            }
        }
        for (proxy, [impulse, moment]) in self.proxies.iter_mut().zip(owed) {
            proxy.take(impulse, moment, dt);
        }
    }

    /// Moves rigid partners on.
    pub(crate) fn drift(&mut self, dt: f64) {
        self.proxies.iter_mut().for_each(|p| p.drift(dt));
    }

    /// Impulses on partners, and the own view of each interface.
    pub(crate) fn answer(self, model: &Model) -> (Vec<(u16, Impulses)>, Vec<InterfaceReport>) {
        let (mut given, mut reports) = (Vec::new(), Vec::new());
        for &interface in &model.interfaces {
            let mut report = InterfaceReport { interface, ..InterfaceReport::default() };
            if let Some(f) = model.faces.iter().position(|f| f.interface == Some(interface)) {
                let crossed = &self.crossed[f];
                (report.received, report.gross, report.work_j) = (crossed.received, crossed.gross, crossed.work);
                given.push(match &model.solids[model.faces[f].solid] {
                    Solid::Sampled(_) => (interface, Impulses::Samples(crossed.samples.clone())),
                    _ => (interface, Impulses::Rigid(crossed.rigid)),
                });
            }
            reports.push(report);
        }
        (given, reports)
    }
}
