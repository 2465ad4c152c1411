//! A cloud of particles behind the contract of plugins.

use std::collections::BTreeMap;

use cosplat_core::boundary::{BoundaryState, Impulses, SampleStatics, Vec3, dot, norm, scale};
use cosplat_core::distance::Placed;
use cosplat_core::plan::LeftOut;
use cosplat_core::plugin::{
    BodyState, BoundaryOutput, Energy, Inputs, InterfaceReport, Outputs, PartnerSetup, PluginError, Pulse, Report,
    Setup, SetupBoundary, StateError, StateReader, StateSink, Step,
};

use super::kernel::Kernel;
use super::sampled::{Beads, Meeting};
use super::step::{Books, Course, stable};
use super::touch::{Solid, Walls};
use crate::model::{During, Face, Partner, mean};
use crate::params::Params;
use crate::partner::{covering, seen_samples, sound};
use crate::solids::Crossed;

/// What never changes.
#[derive(Clone, Debug)]
pub(crate) struct Fixed {
    pub(crate) name: String,
    pub(crate) params: Params,
    pub(crate) kernel: Kernel,
    /// Distance of particles at the start \[m\].
    pub(crate) spacing: f64,
    /// Mass \[kg\] and volume \[m³\] of a particle.
    pub(crate) mass: f64,
    pub(crate) volume: f64,
    /// What is left of gravity beside the lift of the air around: `1 - ρ_air/ρ`.
    pub(crate) heavier: f64,
    /// Share of the differences to neighbours that viscosity takes in a substep of the seed.
    pub(crate) viscosity: f64,
    pub(crate) start: Vec<Vec3>,
    /// Density that each particle may have, over that at rest: what it begins with, where that is more.
    pub(crate) rest: Vec<f64>,
    /// Static colliders and closed sides.
    pub(crate) walls: Vec<Solid>,
    pub(crate) partners: Vec<Face>,
    pub(crate) gravity: Vec<During>,
    pub(crate) wind: Vec<During>,
    /// Whether it has an interface, so that its particles are shown.
    pub(crate) coupled: bool,
    pub(crate) threads: usize,
}

/// A cloud of particles.
#[derive(Debug)]
pub(crate) struct Cloud {
    pub(crate) fixed: Fixed,
    /// Places \[m\] and velocities \[m/s\].
    pub(crate) x: Vec<Vec3>,
    pub(crate) v: Vec<Vec3>,
    /// Samples by row of the interfaces; empty for rigid partners.
    pub(crate) beads: Vec<Beads>,
    pub(crate) pool: Option<rayon::ThreadPool>,
}

impl Cloud {
    /// What a set-up answers.
    pub(crate) fn setup(&self, left_out: Vec<LeftOut>) -> Setup {
        let fixed = &self.fixed;
        let fastest = self.v.iter().map(|&v| norm(v)).fold(0.0, f64::max);
        let (dt, bound) = stable(fixed, fastest);
        let (body, energy) = self.state(0.0);
        let interfaces =
            fixed.partners.iter().map(|p| InterfaceReport { interface: p.interface, ..Default::default() });
        let report = Report {
            substep_bound_by: bound.clone(),
            bodies: vec![body],
            energy,
            interfaces: interfaces.collect(),
            ..Report::default()
        };
        let count = self.x.len();
        let statics = SampleStatics { volume_m3: vec![fixed.volume; count], ..SampleStatics::equal(count, fixed.mass) };
        let shown = self.boundaries().into_iter();
        Setup {
            boundaries: shown
                .map(|b| SetupBoundary { body: b.body, statics: statics.clone(), state: b.state })
                .collect(),
            report,
            stable_dt: Some((dt, bound)),
            particles: vec![count as u64],
            left_out,
        }
    }

    /// Learns what never changes about partners.
    pub(crate) fn connect(&mut self, setups: &[PartnerSetup]) -> Result<(), PluginError> {
        let fixed = &self.fixed;
        let one = |face: &Face| -> Result<Beads, PluginError> {
            match &face.partner {
                Partner::Rigid(_) => Ok(Beads::default()),
                Partner::Samples => {
                    let statics = sound(face, setups)?;
                    covering(face, statics, fixed.spacing, "particles of smoke", "spacing")?;
                    Ok(Beads::new(statics, fixed.spacing))
                }
            }
        };
        self.beads = fixed.partners.iter().map(one).collect::<Result<_, PluginError>>()?;
        Ok(())
    }

    /// Covers a step of the coupling.
    pub(crate) fn advance(
        &mut self,
        step: &Step,
        inputs: &Inputs,
        pulse: &mut dyn Pulse,
    ) -> Result<Outputs, PluginError> {
        let Self { fixed, x, v, beads, pool } = self;
        let mut walls = Walls::new(fixed.walls.clone());
        let mut meetings = Vec::new();
        for (row, face) in fixed.partners.iter().enumerate() {
            let missing =
                || PluginError::Unsupported(format!("a step without the boundary of partner `{}`", face.name));
            let input = inputs.partner(face.interface).ok_or_else(missing)?;
            match &face.partner {
                Partner::Rigid(shape) => {
                    let proxy = crate::partner::proxy(&face.name, &input.now)?;
                    let placed = Placed::new(shape.clone(), proxy.record.position, proxy.record.orientation);
                    walls.solids.push(Solid::Rigid(placed, Box::new(proxy), row));
                }
                Partner::Samples => {
                    let beads = beads.get(row).ok_or_else(missing)?;
                    let (places, speeds) = seen_samples(input, &face.name, beads.mass.len())?;
                    meetings.push(Meeting::new(beads, places, speeds, 0.5 * fixed.spacing, row));
                }
            }
        }
        let crossed = vec![Crossed::default(); fixed.partners.len()];
        let books = Books { crossed, ..Books::default() };
        let mut course = Course { fixed, x, v, walls, meetings, books };
        course.run([step.start_s, step.length_s], pulse, pool.as_ref())?;
        let taken = course.meetings.iter().map(|m| (m.row, m.taken.clone())).collect();
        let books = course.books;
        Ok(self.outputs(step.start_s + step.length_s, books, &taken))
    }

    fn outputs(&self, t: f64, books: Books, taken: &BTreeMap<usize, Vec<Vec3>>) -> Outputs {
        let (mut impulses, mut interfaces) = (Vec::new(), Vec::new());
        for (row, (face, crossed)) in self.fixed.partners.iter().zip(&books.crossed).enumerate() {
            let given = taken.get(&row).map_or(Impulses::Rigid(crossed.on_rigid), |all| Impulses::Samples(all.clone()));
            impulses.push((face.interface, given));
            interfaces.push(crossed.report(face.interface));
        }
        let (body, energy) = self.state(t);
        let [mean, most] = books.crowded.map(|share| (share * 1e6).round() as u64);
        let counters = [
            ("largest-mean-crowding-1e-6", mean),
            ("largest-crowding-1e-6", most),
            ("largest-particles-inside-solids", books.swallowed as u64),
        ];
        let report = Report {
            substeps: books.substeps,
            substep_bound_by: books.bound,
            bodies: vec![body],
            external: books.external,
            energy,
            interfaces,
            counters: counters.iter().map(|&(name, n)| (name.to_owned(), n)).collect(),
            ..Report::default()
        };
        Outputs { boundaries: self.boundaries(), impulses, report }
    }

    /// State of the body and the energies at `t` \[s\].
    fn state(&self, t: f64) -> (BodyState, Energy) {
        let (fixed, x, v) = (&self.fixed, &self.x, &self.v);
        let body = BodyState::of_points(fixed.mass, x, v, &fixed.start);
        let lift = scale(mean(&fixed.gravity, t, t + f64::MIN_POSITIVE.max(1e-9)), fixed.heavier);
        let kinetic = 0.5 * fixed.mass * v.iter().map(|&v| dot(v, v)).sum::<f64>();
        let potential = -fixed.mass * x.iter().map(|&x| dot(lift, x)).sum::<f64>();
        (body, Energy { kinetic_j: kinetic, potential_j: potential, dissipated_j: 0.0 })
    }

    fn boundaries(&self) -> Vec<BoundaryOutput> {
        let fixed = &self.fixed;
        let shown = || BoundaryOutput { body: fixed.name.clone(), state: BoundaryState::points(&self.x, &self.v) };
        fixed.coupled.then(shown).into_iter().collect()
    }

    /// Writes the state.
    pub(crate) fn save(&self, sink: &mut dyn StateSink) {
        sink.vec3s(&self.x);
        sink.vec3s(&self.v);
    }

    /// Reads what `save` wrote; what does not fit changes nothing.
    pub(crate) fn restore(&mut self, state: &[u8]) -> Result<(), StateError> {
        let (mut reader, count) = (StateReader::new(state), self.x.len());
        let (x, v) = (reader.vec3s("particles", count)?, reader.vec3s("velocities", count)?);
        reader.end()?;
        (self.x, self.v) = (x, v);
        Ok(())
    }
}
