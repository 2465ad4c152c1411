//! The plugin contract around the simulation.

use std::collections::BTreeMap;

use cosplat_core::boundary::{BoundaryState, SampleStatics, Samples};
use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{
    BoundaryOutput, Descriptor, Inputs, InterfaceReport, InterfaceRole, Outputs, PartnerSetup, Plugin, PluginError,
    Pulse, Report, Setup, SetupBoundary, SolverScene, StateReader, StateSink, Step,
};
use cosplat_core::scene::ProbeQuantity;
use cosplat_core::visual::{VisualForm, VisualState};

use crate::model::Model;
use crate::params::schema;
use crate::partner::{Known, Partners, known};
use crate::probe::Points;
use crate::read::read;
use crate::report::{quality, states};
use crate::sim::{Books, Course, Motion, Scratch, stable};
use crate::store::Store;

/// The liquid solver.
#[derive(Debug, Default)]
pub struct Sph {
    run: Option<Run>,
}

#[derive(Debug)]
struct Run {
    model: Model,
    store: Store,
    scratch: Scratch,
    known: Vec<Known>,
    points: Points,
    pool: Option<rayon::ThreadPool>,
}

impl Plugin for Sph {
    fn describe(&self) -> Descriptor {
        Descriptor {
            body_kinds: ["box", "sphere", "cylinder", "points", "mesh", "splat"].map(String::from).into(),
            materials: vec!["sph-liquid".into()],
            roles: vec![InterfaceRole::ResolveSamples, InterfaceRole::ResolveProxy],
            boundary: BoundaryForm::SamplesF32 { normals: false },
            visual: Some(VisualForm::Particles { gradients: false }),
            features: ["statics", "height-fields", "gravity", "inflow", "drain"].map(String::from).into(),
            probes: vec![ProbeQuantity::Pressure, ProbeQuantity::Reach],
            params_schema: schema(),
            ..Descriptor::new("sph", env!("CARGO_PKG_VERSION"), "Liquids as smoothed particles")
        }
    }

    fn setup(&mut self, scene: &SolverScene) -> Result<Setup, PluginError> {
        let (model, store, left_out) = read(scene, &self.describe())?;
        let pool = (model.threads > 1)
            .then(|| rayon::ThreadPoolBuilder::new().num_threads(model.threads).build())
            .transpose()
            .map_err(|e| PluginError::Environment(format!("{} threads: {e}", model.threads)))?;
        let speed = store.v.iter().map(|&v| cosplat_core::boundary::norm(v)).fold(0.0, f64::max);
        let (dt, mut bound) = stable(&model, Motion { speed, acceleration: 0.0, pressed: model.head });
        if model.is_thick() {
            bound.push_str("; viscosity is implicit, as it would bind otherwise or is wanted so");
        }
        if let Some(reason) = &model.params.reason {
            bound.push_str("; ");
            bound.push_str(reason);
        }
        let (bodies, energy) = states(&model, &store);
        let points = Points::of(scene);
        let interfaces = model.interfaces.iter().map(|&i| InterfaceReport { interface: i, ..Default::default() });
        let report = Report {
            substep_bound_by: bound.clone(),
            bodies,
            energy,
            interfaces: interfaces.collect(),
            probes: points.answers(&model, &store),
            ..Report::default()
        };
        let run = Run { model, store, scratch: Scratch::default(), known: Vec::new(), points, pool };
        let boundaries = run.boundaries().into_iter().zip(run.statics());
        let setup = Setup {
            boundaries: boundaries
                .map(|(b, statics)| SetupBoundary { body: b.body, statics, state: b.state })
                .collect(),
            report,
            stable_dt: (!run.model.liquids.is_empty()).then_some((dt, bound)),
            particles: run.model.liquids.iter().map(|l| l.ids.len() as u64).collect(),
            left_out,
        };
        self.run = Some(run);
        Ok(setup)
    }

    fn connect(&mut self, partners: &[PartnerSetup]) -> Result<(), PluginError> {
        let run = self.run.as_mut().ok_or_else(not_set_up)?;
        run.known = known(&run.model, partners)?;
        Ok(())
    }

    fn advance(&mut self, step: &Step, inputs: &Inputs, pulse: &mut dyn Pulse) -> Result<Outputs, PluginError> {
        let run = self.run.as_mut().ok_or_else(not_set_up)?;
        if let Some(input) = inputs.impulses.first() {
            let what = format!("the sph solver does not support: impulses at interface {}", input.interface);
            return Err(PluginError::Unsupported(what));
        }
        let partners = Partners::hear(&run.model, &run.known, inputs)?;
        let Run { model, store, scratch, pool, .. } = run;
        let (start, length, books) = (step.start_s, step.length_s, Books::default());
        store.dissipated += partners.settle(model, &store.rubbed);
        let mut course = Course { model, store, scratch, partners, books, start, length };
        // A pulse belongs to the calling thread: only chunks of particles go to the pool.
        course.run(pulse, pool.as_ref())?;
        let (partners, books) = (course.partners, course.books);
        store.rubbed = partners.rubbed(model, length);
        Ok(run.outputs(partners, books))
    }

    fn visual(&self, body: &str) -> Option<VisualState> {
        let run = self.run.as_ref()?;
        let liquid = run.model.liquids.iter().find(|l| l.name == body)?;
        let mut position = vec![[0.0; 3]; liquid.ids.len()];
        run.each(&liquid.ids, |slot, i| position[slot] = run.store.x[i]);
        Some(VisualState::Particles { position, gradient: Vec::new() })
    }

    fn save(&self, sink: &mut dyn StateSink) {
        if let Some(run) = &self.run {
            run.store.save(sink);
        }
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), PluginError> {
        let run = self.run.as_mut().ok_or_else(not_set_up)?;
        let mut reader = StateReader::new(state);
        let store = run.store.load(&mut reader)?;
        reader.end()?;
        (run.store, run.scratch) = (store, Scratch::default());
        Ok(())
    }
}

impl Run {
    /// Calls `found(place in the body, place among the particles)` for each particle with those identities.
    fn each(&self, ids: &std::ops::Range<usize>, mut found: impl FnMut(usize, usize)) {
        for (i, &id) in self.store.id.iter().enumerate().filter(|(_, id)| ids.contains(&(**id as usize))) {
            found(id as usize - ids.start, i);
        }
    }

    fn boundaries(&self) -> Vec<BoundaryOutput> {
        let shown = self.model.liquids.iter().filter(|l| l.coupled);
        let one = |l: &crate::model::Liquid| {
            let nowhere = vec![[0.0; 3]; l.ids.len()];
            let mut samples = Samples { position: nowhere.clone(), velocity: nowhere, normal: Vec::new() };
            self.each(&l.ids, |slot, i| {
                (samples.position[slot], samples.velocity[slot]) = (self.store.x[i], self.store.v[i]);
            });
            BoundaryOutput { body: l.name.clone(), state: BoundaryState::Samples(samples) }
        };
        shown.map(one).collect()
    }

    fn statics(&self) -> Vec<SampleStatics> {
        let shown = self.model.liquids.iter().filter(|l| l.coupled);
        let one = |l: &crate::model::Liquid| SampleStatics {
            id: (0..l.ids.len() as u64).collect(),
            area_m2: vec![0.0; l.ids.len()],
            volume_m3: self.model.mass[l.ids.clone()].iter().map(|m| m / l.rho).collect(),
            mass_kg: self.model.mass[l.ids.clone()].to_vec(),
        };
        shown.map(one).collect()
    }

    fn outputs(&self, partners: Partners, books: Books) -> Outputs {
        let (bodies, energy) = states(&self.model, &self.store);
        let (most, strayed) = quality(&self.model, &self.store);
        let (impulses, interfaces) = partners.answer(&self.model);
        let counters = [
            ("largest-compression-1e-6", most),
            ("strayed-particles", strayed),
            ("pressure-iterations", books.solved.iterations),
            ("energy-returned-by-pressure-1e-6-j", (books.returned * 1e6).round() as u64),
            ("viscosity-iterations", books.thick),
            ("solutions-above-tolerance", books.solved.unfinished),
            ("largest-boundary-particles", books.boundary),
            ("sorts", books.sorts),
            ("quarantined-particles", books.aside),
            ("admitted-particles", books.entered),
            ("drained-particles", books.drained),
        ];
        let report = Report {
            substeps: books.substeps,
            substep_bound_by: books.bound,
            bodies,
            external: books.external,
            supplied_j: books.supplied,
            energy,
            interfaces,
            counters: counters.iter().map(|&(name, n)| (name.to_owned(), n)).collect::<BTreeMap<_, _>>(),
            probes: self.points.answers(&self.model, &self.store),
        };
        Outputs { boundaries: self.boundaries(), impulses, report }
    }
}

fn not_set_up() -> PluginError {
    PluginError::Contract("the sph solver has no scene yet".into())
}
