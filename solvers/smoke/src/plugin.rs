//! The plugin contract around the simulation.

use std::collections::BTreeMap;

use cosplat_core::boundary::{BoundaryState, SampleStatics};
use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{
    BoundaryOutput, Descriptor, Inputs, InterfaceReport, InterfaceRole, Outputs, PartnerSetup, Plugin, PluginError,
    Pulse, Refusals, Report, Setup, SetupBoundary, SolverScene, StateReader, StateSink, Step,
};
use cosplat_core::visual::{VisualForm, VisualState};

use crate::follow::{Part, follow};
use crate::model::Model;
use crate::params::schema;
use crate::partner::{Masses, answer, hear, masses};
use crate::positions::{self, Cloud};
use crate::read::{asked, read};
use crate::report::{potential, state};
use crate::solids::Solids;
use crate::step::{Books, Course, Scratch, stable};
use crate::store::Store;

/// The smoke solver.
#[derive(Debug, Default)]
pub struct Smoke {
    stage: Stage,
}

/// What a solver is at.
#[derive(Debug, Default)]
enum Stage {
    /// It has no scene yet.
    #[default]
    New,
    /// Its scene has no smoke.
    Idle,
    /// It has smoke in a gas.
    Busy(Box<Run>),
    /// It has smoke as particles with constraints on their density.
    Cloud(Box<Cloud>),
}

#[derive(Debug)]
struct Run {
    model: Model,
    store: Store,
    scratch: Scratch,
    masses: Masses,
    pool: Option<rayon::ThreadPool>,
}

impl Plugin for Smoke {
    fn describe(&self) -> Descriptor {
        Descriptor {
            body_kinds: ["box", "sphere", "cylinder", "points", "mesh", "splat"].map(String::from).into(),
            materials: vec!["smoke".into()],
            roles: vec![InterfaceRole::ResolveSamples, InterfaceRole::ResolveProxy],
            boundary: BoundaryForm::SamplesF32 { normals: false },
            visual: Some(VisualForm::Particles { gradients: false }),
            features: ["statics", "height-fields", "gravity", "wind", "sudden-impulses"].map(String::from).into(),
            params_schema: schema(),
            ..Descriptor::new("smoke", env!("CARGO_PKG_VERSION"), "Smoke in an incompressible gas")
        }
    }

    fn setup(&mut self, scene: &SolverScene) -> Result<Setup, PluginError> {
        if scene.bodies.is_empty() {
            Refusals::undeclared(&self.describe(), scene).finish()?;
            self.stage = Stage::Idle;
            return Ok(nothing());
        }
        let asked = asked(scene, &self.describe())?;
        let pool = (scene.threads > 1)
            .then(|| rayon::ThreadPoolBuilder::new().num_threads(scene.threads).build())
            .transpose()
            .map_err(|e| PluginError::Environment(format!("{} threads: {e}", scene.threads)))?;
        if asked.params.positions {
            let (cloud, left_out) = positions::read(scene, asked)?;
            let setup = cloud.setup(left_out);
            self.stage = Stage::Cloud(Box::new(Cloud { pool, ..cloud }));
            return Ok(setup);
        }
        let (model, store, scratch, left_out) = read(scene, asked)?;
        let (dt, bound) = stable(&model, model.ambient(0.0).map(f64::abs), model.gravity(0.0, 1e-9));
        let (body, energy) = state(&model, &store, 0.0);
        let interfaces =
            model.partners.iter().map(|p| InterfaceReport { interface: p.interface, ..Default::default() });
        let report = Report {
            substep_bound_by: bound.clone(),
            bodies: vec![body],
            energy,
            interfaces: interfaces.collect(),
            ..Report::default()
        };
        let run = Run { model, store, scratch, masses: Vec::new(), pool };
        let [mass, volume] = run.model.particle;
        let count = run.store.x.len();
        let statics = SampleStatics { volume_m3: vec![volume; count], ..SampleStatics::equal(count, mass) };
        let boundaries = run.boundaries(0.0).into_iter();
        let setup = Setup {
            boundaries: boundaries
                .map(|b| SetupBoundary { body: b.body, statics: statics.clone(), state: b.state })
                .collect(),
            report,
            stable_dt: Some((dt, bound)),
            particles: vec![count as u64],
            left_out,
        };
        self.stage = Stage::Busy(Box::new(run));
        Ok(setup)
    }

    fn connect(&mut self, partners: &[PartnerSetup]) -> Result<(), PluginError> {
        match &mut self.stage {
            Stage::Cloud(cloud) => cloud.connect(partners)?,
            stage => {
                if let Some(run) = stage.run()? {
                    run.masses = masses(&run.model, partners)?;
                }
            }
        }
        Ok(())
    }

    fn advance(&mut self, step: &Step, inputs: &Inputs, pulse: &mut dyn Pulse) -> Result<Outputs, PluginError> {
        if let Some(input) = inputs.impulses.first() {
            let what = format!("the smoke solver does not support: impulses at interface {}", input.interface);
            return Err(PluginError::Unsupported(what));
        }
        if let Stage::Cloud(cloud) = &mut self.stage {
            return cloud.advance(step, inputs, pulse);
        }
        let Some(run) = self.stage.run()? else {
            let report = Report { substeps: 1, substep_bound_by: "nothing: no smoke".to_owned(), ..Report::default() };
            return Ok(Outputs { boundaries: Vec::new(), impulses: Vec::new(), report });
        };
        let held = potential(&run.model, &run.store, step.start_s);
        let shown = follow(&mut run.model, &mut run.store, &mut run.scratch, inputs, step.start_s);
        let solids = hear(&run.model, &run.masses, inputs)?;
        let Run { model, store, scratch, pool, .. } = &mut *run;
        let (start, length) = (step.start_s, step.length_s);
        let books = Books { external: shown, ..Books::default() };
        let mut course = Course { model, store, scratch, solids, books, start, length };
        // A pulse belongs to the calling thread: only chunks of the grid go to the pool.
        course.run(pulse, pool.as_ref())?;
        let (solids, books) = (course.solids, course.books);
        let pushed = books.pushed;
        let mut outputs = run.outputs(start + length, &solids, books);
        // Buoyancy takes what it gives from the potential energy. What is beyond that, a source, an open side or
        // confinement gave.
        outputs.report.supplied_j = pushed + outputs.report.energy.potential_j - held;
        Ok(outputs)
    }

    fn visual(&self, body: &str) -> Option<VisualState> {
        let (name, x) = match &self.stage {
            Stage::Busy(run) => (&run.model.name, &run.store.x),
            Stage::Cloud(cloud) => (&cloud.fixed.name, &cloud.x),
            Stage::New | Stage::Idle => return None,
        };
        (name == body).then(|| VisualState::Particles { position: x.clone(), gradient: Vec::new() })
    }

    fn save(&self, sink: &mut dyn StateSink) {
        match &self.stage {
            Stage::Busy(run) => {
                run.model.part.save(sink);
                run.store.save(sink);
            }
            Stage::Cloud(cloud) => cloud.save(sink),
            Stage::New | Stage::Idle => {}
        }
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), PluginError> {
        if let Stage::Cloud(cloud) = &mut self.stage {
            return Ok(cloud.restore(state)?);
        }
        let run = self.stage.run()?;
        let mut reader = StateReader::new(state);
        let Some(run) = run else { return Ok(reader.end()?) };
        let part = Part::load(&mut reader, &Part::all(&run.model.whole.grid))?;
        let now = run.model.part;
        run.model.show(part);
        let scratch = Scratch::new(&run.model.grid);
        let blank = Store::new(&run.model.grid, scratch.pressures(), run.store.x.clone());
        match blank.load(&mut reader).and_then(|store| reader.end().map(|()| store)) {
            Ok(store) => (run.store, run.scratch) = (store, scratch),
            Err(why) => {
                run.model.show(now);
                return Err(why.into());
            }
        }
        Ok(())
    }
}

impl Stage {
    fn run(&mut self) -> Result<Option<&mut Run>, PluginError> {
        match self {
            Self::New => Err(PluginError::Contract("the smoke solver has no scene yet".into())),
            Self::Idle | Self::Cloud(_) => Ok(None),
            Self::Busy(run) => Ok(Some(run)),
        }
    }
}

/// Set-up of a process without smoke.
fn nothing() -> Setup {
    Setup {
        boundaries: Vec::new(),
        report: Report::default(),
        stable_dt: None,
        particles: Vec::new(),
        left_out: Vec::new(),
    }
}

impl Run {
    /// Particles with the velocity of the gas around them; those that an inflow holds back rest.
    fn boundaries(&self, t: f64) -> Vec<BoundaryOutput> {
        if !self.model.coupled {
            return Vec::new();
        }
        let (x, born) = (&self.store.x, self.model.born(t));
        let speed = |(i, &x)| if i < born { self.model.grid.velocity(&self.store.u, x) } else { [0.0; 3] };
        let v: Vec<_> = x.iter().enumerate().map(speed).collect();
        vec![BoundaryOutput { body: self.model.name.clone(), state: BoundaryState::points(x, &v) }]
    }

    fn outputs(&self, t: f64, solids: &Solids, books: Books) -> Outputs {
        let (body, energy) = state(&self.model, &self.store, t);
        let (impulses, interfaces) = answer(&self.model, solids);
        let (low, high) = (self.model.whole.grid.low, self.model.whole.grid.high());
        let is_out = |x: &&[f64; 3]| (0..3).any(|k| x[k] < low[k] || x[k] > high[k]);
        let unseen = solids.filled.iter().filter(|f| f.row.is_some() && f.faces.is_empty()).count();
        let counters = [
            ("pressure-iterations", books.iterations),
            ("solutions-above-tolerance", books.unfinished),
            ("largest-divergence-1e-6", (books.divergence * 1e6).round() as u64),
            ("largest-cells-computed", self.model.grid.cells() as u64),
            ("largest-particles-outside", self.store.x.iter().filter(is_out).count() as u64),
            ("largest-rigid-partners-outside-or-thinner-than-a-cell", unseen as u64),
        ];
        let report = Report {
            substeps: books.substeps,
            substep_bound_by: books.bound,
            bodies: vec![body],
            external: books.external,
            energy,
            interfaces,
            counters: counters.iter().map(|&(name, n)| (name.to_owned(), n)).collect::<BTreeMap<_, _>>(),
            ..Report::default()
        };
        Outputs { boundaries: self.boundaries(t), impulses, report }
    }
}
