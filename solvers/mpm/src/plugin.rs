//! The plugin contract around the simulation.

use std::collections::BTreeMap;

use cosplat_core::boundary::Impulses;
use cosplat_core::control::PROTOCOL;
use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{
    BoundaryOutput, Descriptor, Inputs, InterfaceReport, InterfaceRole, Outputs, PartnerSetup, Plugin, PluginError,
    Pulse, Questions, Report, Saves, Setup, SetupBoundary, SolverScene, StateReader, StateSink, Step,
};
use cosplat_core::scene::ProbeQuantity;
use cosplat_core::visual::{VisualForm, VisualState};

use crate::hear::Residuals;
use crate::model::Model;
use crate::nodes::Nodes;
use crate::params::schema;
use crate::patch::Marks;
use crate::read::read;
use crate::real::Real;
use crate::show::statics;
use crate::sim::{Books, Course, Sim};
use crate::store::Store;
use crate::swarm::{Felt, Swarm};
use crate::walls::Walls;

/// Stretch clamps per particle and substep above which a result means nothing.
const MOST_CLAMPED: f64 = 1e-3;

/// The material point solver in single (`Mpm<f32>`) or double precision (`Mpm<f64>`).
#[derive(Debug, Default)]
pub struct Mpm<R: Real> {
    run: Option<Run<R>>,
}

#[derive(Debug)]
pub(crate) struct Run<R: Real> {
    pub(crate) model: Model<R>,
    pub(crate) sim: Sim<R>,
    questions: Questions,
    /// Positions at t = 0, by identity \[m\].
    start: Vec<[f64; 3]>,
    dissipated: f64,
    /// Last velocity and angular velocity of each partner's stand-in.
    pub(crate) foreseen: Vec<Option<[[f64; 3]; 2]>>,
    /// What the samples of each partner that shows some felt in the last step.
    pub(crate) felt: Vec<Felt>,
    pool: Option<rayon::ThreadPool>,
}

impl<R: Real> Plugin for Mpm<R> {
    fn describe(&self) -> Descriptor {
        let double = size_of::<R>() == 8;
        let features =
            ["statics", "height-fields", "gravity", "acceleration-field", "point-force", "impulse", "regions"];
        Descriptor {
            name: if double { "mpm-f64" } else { "mpm" }.into(),
            version: env!("CARGO_PKG_VERSION").into(),
            summary: format!("Material points: elastic and elastoplastic solids, sand, snow, liquid, {}", R::NAME),
            protocol: [PROTOCOL, PROTOCOL],
            body_kinds: ["box", "sphere", "cylinder", "points", "cloud", "mesh", "splat"].map(String::from).into(),
            materials: ["elastic", "elastoplastic", "viscoplastic", "granular", "snow", "mpm-liquid"]
                .map(String::from)
                .into(),
            roles: vec![InterfaceRole::ResolveProxy, InterfaceRole::ResolveSamples, InterfaceRole::Respond],
            boundary: if double {
                BoundaryForm::SamplesF64 { normals: true }
            } else {
                BoundaryForm::SamplesF32 { normals: true }
            },
            visual: Some(VisualForm::Particles { gradients: true }),
            features: features.map(String::from).into(),
            probes: vec![ProbeQuantity::Strain, ProbeQuantity::Reach],
            saves: Saves { bytes: true, deterministic: true },
            params_schema: schema(),
        }
    }

    fn setup(&mut self, scene: &SolverScene) -> Result<Setup, PluginError> {
        let (model, seeds): (Model<R>, _) = read(scene)?;
        let with_gradients = model.setting.carries.contains(&true);
        let store = Store::new(&seeds, model.setting.dx, with_gradients)
            .ok_or_else(|| PluginError::Unsupported("a body is more than 500 000 grid cells from the origin".into()))?;
        let start = seeds.iter().map(|s| s.position).collect();
        drop(seeds);
        let sim = Sim::new(model.setting.clone(), store, Walls::new(model.walls.clone()));
        let pool = (model.threads > 1)
            .then(|| rayon::ThreadPoolBuilder::new().num_threads(model.threads).build())
            .transpose()
            .map_err(|e| PluginError::Unsupported(format!("{} threads: {e}", model.threads)))?;
        let foreseen = vec![None; model.setting.partners.len()];
        let felt = vec![Felt::default(); model.setting.clouds.len()];
        let questions = Questions::of(scene);
        let run = Run { model, sim, questions, start, dissipated: 0.0, foreseen, felt, pool };
        let setup = run.setup();
        self.run = Some(run);
        Ok(setup)
    }

    fn connect(&mut self, partners: &[PartnerSetup]) -> Result<(), PluginError> {
        let Some(run) = &mut self.run else { return Ok(()) };
        for face in &run.model.faces {
            let Some(cloud) = face.cloud.and_then(|k| run.sim.setting.clouds.get_mut(k)) else { continue };
            let found = partners.iter().find(|p| p.interface == face.id);
            cloud.marks = found
                .and_then(|p| Marks::new(&p.statics))
                .ok_or_else(|| refused(&format!("samples of `{}` that are not there or have no mass", cloud.name)))?;
        }
        Ok(())
    }

    fn advance(&mut self, step: &Step, inputs: &Inputs, pulse: &mut dyn Pulse) -> Result<Outputs, PluginError> {
        let run = self.run.as_mut().ok_or_else(not_set_up)?;
        let proxies = run.proxies(inputs)?;
        let (swarms, by_samples) = run.swarms(inputs, step.length_s)?;
        let residuals = Residuals { proxies: run.residuals(&proxies), swarms: by_samples };
        let kicks = run.kicks(inputs)?;
        let books = Books { dissipated: run.dissipated, ..Books::default() };
        let length = step.length_s;
        let sim = &mut run.sim;
        let mut course = Course { start: step.start_s, length, proxies, swarms, kicks, books };
        sim.run(&mut course, run.pool.as_ref(), pulse)?;
        run.dissipated = course.books.dissipated;
        for proxy in &course.proxies {
            let (v, w) = proxy.twist();
            run.foreseen[proxy.partner] = Some([v, w]);
        }
        run.felt = course.swarms.iter().map(Swarm::felt).collect();
        run.check(&course)?;
        Ok(run.outputs(step.start_s + length, &course, &residuals))
    }

    fn visual(&self, body: &str) -> Option<VisualState> {
        let run = self.run.as_ref()?;
        let index = run.model.names.iter().position(|name| name == body)?;
        let firsts = run.model.firsts();
        Some(run.sim.visual(firsts[index]..firsts[index + 1], run.model.shown[index].is_capture))
    }

    fn save(&self, sink: &mut dyn StateSink) {
        let Some(run) = &self.run else { return };
        run.sim.store.save(sink);
        run.sim.contact.save(sink);
        sink.f64(run.dissipated);
        for foreseen in &run.foreseen {
            sink.u64(u64::from(foreseen.is_some()));
            foreseen.unwrap_or_default().into_iter().for_each(|v| sink.vec3(v));
        }
        run.felt.iter().for_each(|felt| felt.save(sink));
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), PluginError> {
        let run = self.run.as_mut().ok_or_else(not_set_up)?;
        let mut reader = StateReader::new(state);
        let store = run.sim.store.load(&mut reader, &run.sim.setting.owners)?;
        let colliders = run.model.walls.len() + run.sim.setting.partners.len() + run.felt.len();
        let memory = Nodes::load(&mut reader, store.len() as u64, colliders as u64)?;
        let dissipated = reader.f64()?;
        let mut foreseen = Vec::new();
        for _ in &run.foreseen {
            let known = reader.u64()? != 0;
            let twist = [reader.vec3()?, reader.vec3()?];
            foreseen.push(known.then_some(twist));
        }
        let clouds = &run.sim.setting.clouds;
        let felt = clouds.iter().map(|c| Felt::load(&mut reader, c.marks.len())).collect::<Result<_, _>>()?;
        reader.end()?;
        run.sim.store = store;
        run.sim.contact.resume(memory);
        (run.dissipated, run.foreseen, run.felt) = (dissipated, foreseen, felt);
        run.sim.rebuild(true);
        Ok(())
    }
}

impl<R: Real> Run<R> {
    fn setup(&self) -> Setup {
        let firsts = self.model.firsts();
        let shown = self.model.shown.iter().enumerate().filter(|(_, s)| s.has_interface);
        let boundaries = shown.map(|(i, shown)| SetupBoundary {
            body: self.model.names[i].clone(),
            statics: statics(shown, firsts[i] as u32, self.sim.resisting(shown, firsts[i]..firsts[i + 1])),
            state: self.sim.samples(shown),
        });
        let stable = self.sim.stable(f64::INFINITY);
        let words = stable.bound.words(&self.model.names, &self.sim.setting.limits);
        let (bodies, energy, _) = self.sim.states(&self.start, 0.0, 0.0);
        let interfaces =
            self.model.faces.iter().map(|f| InterfaceReport { interface: f.id, ..InterfaceReport::default() });
        let report = Report {
            substep_bound_by: words.clone(),
            bodies,
            energy,
            interfaces: interfaces.collect(),
            probes: self.questions.answers(|body, question| self.sim.answer(body, question)),
            ..Report::default()
        };
        Setup {
            boundaries: boundaries.collect(),
            report,
            stable_dt: stable.dt.is_finite().then_some((stable.dt, words)),
            particles: self.model.particles.clone(),
            left_out: Vec::new(),
        }
    }

    fn check(&self, course: &Course) -> Result<(), PluginError> {
        let clamped = course.books.clamped as f64;
        if clamped > MOST_CLAMPED * (self.sim.store.len() as f64) * course.books.substeps as f64 {
            return Err(PluginError::Physics(format!(
                "stretches of particles left the range 0.05 to 20 {clamped} times in {} substeps",
                course.books.substeps
            )));
        }
        Ok(())
    }

    fn outputs(&self, t: f64, course: &Course, residuals: &Residuals) -> Outputs {
        let shown = self.model.shown.iter().enumerate().filter(|(_, s)| s.has_interface);
        let boundaries =
            shown.map(|(i, s)| BoundaryOutput { body: self.model.names[i].clone(), state: self.sim.samples(s) });
        let mut impulses = Vec::new();
        let mut interfaces = Vec::new();
        for (index, face) in self.model.faces.iter().enumerate() {
            let mut report = InterfaceReport { interface: face.id, ..InterfaceReport::default() };
            if let Some(partner) = face.partner {
                let proxy = &course.proxies[partner];
                let own = &proxy.on_own[face.body];
                (report.received, report.gross, report.work_j) = (own.wrench, own.gross, own.work);
                report.residual = residuals.proxies[partner];
                impulses.push((face.id, Impulses::Rigid(proxy.on_partner[face.body])));
            } else if let Some(cloud) = face.cloud {
                let swarm = &course.swarms[cloud];
                let own = &swarm.on_own[face.body];
                (report.received, report.gross, report.work_j) = (own.wrench, own.gross, own.work);
                report.residual = residuals.swarms[cloud];
                impulses.push((face.id, Impulses::Samples(swarm.on_partner[face.body].clone())));
            } else if let Some(kick) = course.kicks.0.iter().find(|k| k.index == index) {
                (report.received, report.gross, report.work_j) = kick.totals();
            }
            interfaces.push(report);
        }
        let books = &course.books;
        let (bodies, energy, stretch) = self.sim.states(&self.start, t, books.dissipated);
        let counters = [
            ("stretch-clamps", books.clamped),
            ("largest-stretch-1e-6", (stretch * 1e6) as u64),
            ("rollbacks", books.rollbacks),
            ("quarantined-particles", books.quarantined),
            ("contact-places", books.places),
            ("contact-passes", books.passes),
            ("contact-unsettled", books.unsettled),
            ("sorts", books.sorts),
        ];
        let report = Report {
            substeps: books.substeps,
            substep_bound_by: books.bound.words(&self.model.names, &self.sim.setting.limits),
            bodies,
            external: books.external.wrench,
            supplied_j: books.supplied,
            energy,
            interfaces,
            counters: counters.iter().map(|&(name, n)| (name.to_owned(), n)).collect::<BTreeMap<_, _>>(),
            probes: self.questions.answers(|body, question| self.sim.answer(body, question)),
        };
        Outputs { boundaries: boundaries.collect(), impulses, report }
    }
}

pub(crate) fn refused(what: &str) -> PluginError {
    PluginError::Unsupported(format!("the material point solver does not support: {what}"))
}

fn not_set_up() -> PluginError {
    PluginError::Unsupported("the material point solver cannot advance before it has a scene".into())
}
