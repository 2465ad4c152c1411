//! The plugin contract around the simulation.

use cosplat_core::boundary::{BoundaryState, Impulses, Vec3, norm, sub};
use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{
    BoundaryOutput, Descriptor, Energy, Inputs, InterfaceReport, InterfaceRole, Outputs, PartInfluence, PartnerSetup,
    Plugin, PluginError, Pulse, Questions, Refusals, Report, Setup, SetupBoundary, SolverScene, StateReader, StateSink,
    Step,
};
use cosplat_core::scene::ProbeQuantity;
use cosplat_core::visual::{VisualForm, VisualState};

use crate::behind;
use crate::bond::{self, Bond};
use crate::course::{Books, Course, Kick};
use crate::list::List;
use crate::model::{Model, Part};
use crate::near::Near;
use crate::params::schema;
use crate::proxy::Proxy;
use crate::read::read;
use crate::samples::{Known, Marks, Swarm};
use crate::shown::{Shown, swarms, tie};
use crate::side;
use crate::sim::COURANT;

/// The cloth solver.
#[derive(Debug, Default)]
pub struct Pbd {
    run: Option<Run>,
}

#[derive(Debug)]
struct Run {
    model: Model,
    questions: Questions,
    /// Of each interface.
    shown: Vec<Shown>,
    dissipated: f64,
    /// What is kinetic and stored now \[J\].
    mechanical: [f64; 2],
    /// Last velocity of the stand-in of each rigid partner.
    foreseen: Vec<Option<Vec3>>,
    pool: Option<rayon::ThreadPool>,
    near: Near,
}

impl Plugin for Pbd {
    fn describe(&self) -> Descriptor {
        let summary = "Cloth: extended position-based dynamics in small substeps, double precision";
        let features = ["statics", "gravity", "acceleration-field", "point-force", "impulse", "wind"];
        Descriptor {
            body_kinds: ["plane", "mesh"].map(String::from).into(),
            materials: vec!["cloth".into()],
            roles: vec![InterfaceRole::ResolveProxy, InterfaceRole::ResolveSamples, InterfaceRole::Respond],
            boundary: BoundaryForm::SamplesF64 { normals: true },
            visual: Some(VisualForm::Particles { gradients: false }),
            features: features.map(String::from).into(),
            probes: vec![ProbeQuantity::Strain, ProbeQuantity::Reach],
            params_schema: schema(),
            ..Descriptor::new("pbd", env!("CARGO_PKG_VERSION"), summary)
        }
    }

    fn setup(&mut self, scene: &SolverScene) -> Result<Setup, PluginError> {
        let mut model = read(&self.describe(), scene)?;
        let pool = (model.threads > 1)
            .then(|| rayon::ThreadPoolBuilder::new().num_threads(model.threads).build())
            .transpose()
            .map_err(|e| PluginError::Environment(format!("{} threads: {e}", model.threads)))?;
        let foreseen = vec![None; model.sim.setting.partners.len()];
        let shown = vec![Shown::default(); model.faces.len()];
        let (mechanical, near) = (model.mechanical(pool.as_ref()), Near::default());
        let questions = Questions::of(scene);
        let run = Run { model, questions, shown, dissipated: 0.0, mechanical, foreseen, pool, near };
        let setup = run.setup();
        self.run = Some(run);
        Ok(setup)
    }

    fn connect(&mut self, partners: &[PartnerSetup]) -> Result<(), PluginError> {
        let Some(run) = &mut self.run else { return Ok(()) };
        for (face, shown) in run.model.faces.iter().zip(&mut run.shown) {
            if !matches!(face.part, Part::Samples(_)) {
                continue;
            }
            let found = partners.iter().find(|p| p.interface == face.id);
            shown.marks = found
                .and_then(|p| Marks::new(&p.statics))
                .ok_or_else(|| refused(&format!("samples of `{}` that are not there or have no mass", face.partner)))?;
        }
        Ok(())
    }

    fn advance(&mut self, step: &Step, inputs: &Inputs, pulse: &mut dyn Pulse) -> Result<Outputs, PluginError> {
        let run = self.run.as_mut().ok_or_else(not_set_up)?;
        let (proxies, residuals) = run.proxies(inputs)?;
        let kicks = run.kicks(inputs)?;
        let known = run.shown.iter_mut().map(|s| std::mem::take(&mut s.known)).collect();
        let (swarms, meetings) = swarms(&run.model, &run.shown, known, inputs, step.length_s)?;
        let before: f64 = run.mechanical.iter().sum();
        let has_wind = run.model.sim.setting.actions.iter().any(|a| matches!(a.influence, PartInfluence::Wind(..)));
        let normals = if has_wind { run.model.all_normals() } else { Vec::new() };
        let (start, length, books) = (step.start_s, step.length_s, Books::default());
        let near = std::mem::take(&mut run.near);
        let bonds = std::mem::take(&mut run.model.bonds);
        let mut course = Course { start, length, proxies, swarms, meetings, kicks, bonds, normals, near, books };
        tie(&run.model, &mut course, inputs);
        run.model.sim.run(&mut course, run.pool.as_ref(), pulse)?;
        run.near = std::mem::take(&mut course.near);
        run.model.bonds = std::mem::take(&mut course.bonds);
        for (foreseen, proxy) in run.foreseen.iter_mut().zip(&course.proxies) {
            *foreseen = Some(proxy.twist()[0]);
        }
        let given: f64 = course.books.driven.work
            + course.books.held.work
            + course.books.kicks.iter().chain(&course.books.swarms).map(|t| t.work).sum::<f64>()
            + course.proxies.iter().flat_map(|p| &p.on_own).map(|t| t.work).sum::<f64>();
        run.mechanical = run.model.mechanical(run.pool.as_ref());
        run.dissipated += before + given - run.mechanical.iter().sum::<f64>();
        let energy = run.model.energy(course.start + course.length, run.mechanical, run.dissipated);
        let mut outputs = outputs(&run.model, &course, &residuals, energy);
        outputs.report.probes = run.questions.answers(|body, question| run.model.answer(body, question));
        let known: Vec<_> = course.swarms.into_iter().map(|swarm| swarm.leave(course.length)).collect();
        let faces = run.model.faces.iter().zip(&mut run.shown).filter(|(f, _)| matches!(f.part, Part::Samples(_)));
        for ((_, shown), known) in faces.zip(known) {
            shown.known = known;
        }
        Ok(outputs)
    }

    fn visual(&self, body: &str) -> Option<VisualState> {
        let model = &self.run.as_ref()?.model;
        let cloth = model.cloths.iter().find(|c| c.name == body)?;
        let position = cloth.order().map(|i| model.sim.vertices[i].x).collect();
        Some(VisualState::Particles { position, gradient: Vec::new() })
    }

    fn save(&self, sink: &mut dyn StateSink) {
        let Some(run) = &self.run else { return };
        sink.u64(run.model.sim.vertices.len() as u64);
        for vertex in &run.model.sim.vertices {
            sink.vec3(vertex.x);
            sink.vec3(vertex.u);
        }
        sink.f64(run.dissipated);
        for foreseen in &run.foreseen {
            sink.u64(u64::from(foreseen.is_some()));
            sink.vec3(foreseen.unwrap_or_default());
        }
        run.near.save(sink);
        for known in run.shown.iter().map(|shown| &shown.known) {
            side::save(&known.sides, sink);
            behind::save(&known.left, sink);
        }
        bond::save(&run.model.bonds, sink);
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), PluginError> {
        let run = self.run.as_mut().ok_or_else(not_set_up)?;
        let mut reader = StateReader::new(state);
        let (found, expected) = (reader.u64()?, run.model.sim.vertices.len() as u64);
        if found != expected {
            return Err(cosplat_core::plugin::StateError::Count { what: "vertices", found, expected }.into());
        }
        let mut places = Vec::with_capacity(run.model.sim.vertices.len());
        for _ in 0..expected {
            places.push([reader.vec3()?, reader.vec3()?]);
        }
        let dissipated = reader.f64()?;
        let mut foreseen = Vec::new();
        for _ in &run.foreseen {
            let known = reader.u64()? != 0;
            let velocity = reader.vec3()?;
            foreseen.push(known.then_some(velocity));
        }
        let setting = &run.model.sim.setting;
        let counts = [run.model.sim.vertices.len(), setting.walls.len(), setting.partners.len()];
        let near = Near::restore(&mut reader, counts)?;
        let mut all = Vec::new();
        for shown in &run.shown {
            let sides = side::restore(&mut reader, [shown.marks.len(), run.model.sim.mesh.triangles.len()])?;
            let left = behind::restore(&mut reader, shown.marks.len())?;
            all.push(Known { sides, left, list: List::default() });
        }
        let bonds = bond::restore(&run.model.bonds, &mut reader, |face| run.shown[face].marks.len())?;
        reader.end()?;
        run.model.bonds = bonds;
        for (vertex, [x, u]) in run.model.sim.vertices.iter_mut().zip(places) {
            (vertex.x, vertex.u) = (x, u);
        }
        (run.dissipated, run.foreseen, run.near) = (dissipated, foreseen, near);
        run.shown.iter_mut().zip(all).for_each(|(shown, known)| shown.known = known);
        run.mechanical = run.model.mechanical(run.pool.as_ref());
        Ok(())
    }
}

fn outputs(model: &Model, course: &Course, residuals: &[f64], energy: Energy) -> Outputs {
    let books = &course.books;
    let (mut impulses, mut interfaces, mut swarm) = (Vec::new(), Vec::new(), 0);
    for (index, face) in model.faces.iter().enumerate() {
        let mut row = InterfaceReport { interface: face.id, ..InterfaceReport::default() };
        match face.part {
            Part::Proxy(p) => {
                let proxy = &course.proxies[p];
                row = proxy.on_own[face.body].report(face.id, residuals[p]);
                impulses.push((face.id, Impulses::Rigid(proxy.on_partner[face.body])));
            }
            Part::Samples(_) => {
                row = books.swarms[swarm].report(face.id, 0.0);
                impulses.push((face.id, Impulses::Samples(course.swarms[swarm].impulse.clone())));
                swarm += 1;
            }
            Part::Respond => {
                if let Some(k) = course.kicks.iter().position(|k| k.face == index) {
                    row = books.kicks[k].report(face.id, 0.0);
                }
            }
        }
        interfaces.push(row);
    }
    let shown = model.cloths.iter().filter(|c| c.coupled);
    let widest = Bond::widest(&course.bonds, &model.sim.vertices, (&course.proxies, &course.swarms));
    let counters = [
        // A conversion stops at the largest number.
        ("largest-gap-of-a-bond-1e-6-m", (widest * 1e6) as u64),
        ("largest-stretch-left-1e-6", (books.left * 1e6) as u64),
        ("contacts", books.touches),
        ("substeps beyond a thickness", books.too_fast),
        ("samples gone through cloth", course.swarms.iter().map(|s| s.pierced).sum()),
        ("final-samples beyond cloth", books.beyond),
        ("final-neighbours with cloth between", books.cut),
        ("largest-overrun-1e-6-m", (course.swarms.iter().map(Swarm::overrun).fold(0.0, f64::max) * 1e6) as u64),
    ];
    let report = Report {
        substeps: books.substeps,
        substep_bound_by: model.bound(books.bound_by_speed),
        bodies: model.cloths.iter().map(|c| model.state(c)).collect(),
        external: books.driven.wrench.plus(books.held.wrench),
        supplied_j: books.supplied + books.held.work,
        energy,
        interfaces,
        counters: counters.map(|(name, n)| (name.to_owned(), n)).into(),
        ..Report::default()
    };
    let boundaries = shown.map(|c| BoundaryOutput { body: c.name.clone(), state: model.samples(c) }).collect();
    Outputs { boundaries, impulses, report }
}

impl Model {
    /// The term that binds a substep.
    fn bound(&self, by_speed: bool) -> String {
        let setting = &self.sim.setting;
        if by_speed {
            format!("speed: {COURANT} of the shortest edge, {:.3e} m", setting.shortest)
        } else {
            format!("max_substep_s: {:.3e} s", setting.longest)
        }
    }
}

impl Run {
    fn setup(&self) -> Setup {
        let model = &self.model;
        let shown = model.cloths.iter().filter(|c| c.coupled);
        let boundaries =
            shown.map(|c| SetupBoundary { body: c.name.clone(), statics: model.statics(c), state: model.samples(c) });
        let rows = model.faces.iter().map(|f| InterfaceReport { interface: f.id, ..InterfaceReport::default() });
        let report = Report {
            substep_bound_by: model.bound(false),
            bodies: model.cloths.iter().map(|c| model.state(c)).collect(),
            energy: model.energy(0.0, self.mechanical, 0.0),
            interfaces: rows.collect(),
            probes: self.questions.answers(|body, question| model.answer(body, question)),
            ..Report::default()
        };
        Setup {
            boundaries: boundaries.collect(),
            report,
            stable_dt: (!model.cloths.is_empty()).then(|| (model.sim.setting.longest, model.bound(false))),
            particles: model.cloths.iter().map(|c| c.places.len() as u64).collect(),
            left_out: model.left_out.clone(),
        }
    }

    /// Stand-ins of all rigid partners, and the speed by which each partner differs from what was foreseen.
    fn proxies(&self, inputs: &Inputs) -> Result<(Vec<Proxy>, Vec<f64>), PluginError> {
        let (mut proxies, mut residuals) = (Vec::new(), Vec::new());
        for (index, partner) in self.model.sim.setting.partners.iter().enumerate() {
            let faces = self.model.faces.iter().filter(|f| f.part == Part::Proxy(index));
            let mut found = None;
            for face in faces {
                let Some(BoundaryState::Proxy(record)) = inputs.partner(face.id).map(|input| &input.now) else {
                    return Err(refused(&format!("a step without the record of `{}`", partner.name)));
                };
                if !Proxy::is_sound(record) {
                    return Err(PluginError::Physics(format!("the record of `{}` is not finite", partner.name)));
                }
                found = found.or(Some(record));
            }
            let Some(record) = found else { continue };
            residuals.push(self.foreseen[index].map_or(0.0, |v| norm(sub(record.linear_velocity, v))));
            proxies.push(Proxy::new(record, self.model.cloths.len()));
        }
        Ok((proxies, residuals))
    }

    fn kicks(&self, inputs: &Inputs) -> Result<Vec<Kick>, PluginError> {
        let mut kicks = Vec::new();
        for (index, face) in self.model.faces.iter().enumerate().filter(|(_, f)| f.part == Part::Respond) {
            let Some(input) = inputs.impulse(face.id) else { continue };
            let cloth = &self.model.cloths[face.body];
            let each = input.on_points(&cloth.name, &face.partner, cloth.places.len())?;
            let mut impulse = vec![[0.0; 3]; self.model.sim.vertices.len()];
            cloth.order().zip(each).for_each(|(i, &j)| impulse[i] = j);
            kicks.push(Kick { face: index, impulse, spread: input.spread });
        }
        let known = |id| self.model.faces.iter().any(|f| f.id == id && f.part == Part::Respond);
        if let Some(input) = inputs.impulses.iter().find(|i| !known(i.interface)) {
            return Err(refused(&format!("impulses at interface {}", input.interface)));
        }
        Ok(kicks)
    }
}

pub(crate) fn refused(what: &str) -> PluginError {
    Refusals::one("pbd", what)
}

fn not_set_up() -> PluginError {
    PluginError::Contract("the cloth solver is asked to advance before it has a scene".into())
}
