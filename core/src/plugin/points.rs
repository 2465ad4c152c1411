//! A body made of points of one mass: what it is at t = 0, what it shows, and what an impulse does to it.

use super::PluginError;
use super::budget::Budget;
use super::exchange::{BodyState, BoundaryOutput, Energy, ImpulseInput, InterfaceReport, Report};
use super::scene::{Setup, SetupBoundary, SolverScene};
use super::state::{StateError, StateReader, StateSink};
use crate::boundary::{BoundaryState, Impulses, SampleStatics, Vec3, add, dot, scale};
use crate::scene::Body;

/// Equal points. Positions and velocities change in a run, the rest comes from the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Points {
    /// Name of the body.
    pub body: String,
    /// Mass of each point \[kg\].
    pub mass: f64,
    /// Positions at t = 0 \[m\].
    pub start: Vec<Vec3>,
    /// Positions \[m\].
    pub x: Vec<Vec3>,
    /// Velocities \[m/s\].
    pub v: Vec<Vec3>,
}

impl Points {
    /// The points of a body at t = 0; none without any point or without a positive mass.
    pub fn new(body: &Body) -> Option<Self> {
        let (x, v) = body.points().filter(|(x, _)| !x.is_empty())?;
        let mass = body.mass_kg.filter(|m| m.is_finite() && *m > 0.0)? / x.len() as f64;
        Some(Self { body: body.name.clone(), mass, start: x.clone(), x, v })
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// True when there are none.
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// What partners learn before the first window.
    pub fn setup_boundary(&self) -> SetupBoundary {
        let statics = SampleStatics::equal(self.len(), self.mass);
        SetupBoundary { body: self.body.clone(), statics, state: self.boundary().state }
    }

    /// What partners see.
    pub fn boundary(&self) -> BoundaryOutput {
        BoundaryOutput { body: self.body.clone(), state: BoundaryState::points(&self.x, &self.v) }
    }

    /// State for the report.
    pub fn state(&self) -> BodyState {
        BodyState::of_points(self.mass, &self.x, &self.v, &self.start)
    }

    /// Kinetic energy \[J\].
    pub fn kinetic_j(&self) -> f64 {
        self.v.iter().map(|&v| 0.5 * self.mass * dot(v, v)).sum()
    }

    /// Whether every number is one.
    pub fn is_finite(&self) -> bool {
        self.x.iter().chain(&self.v).flatten().all(|c| c.is_finite())
    }

    /// Gives each point `part` of its impulse \[N s\] at once, and books that.
    pub fn kick(&mut self, each: &[Vec3], part: f64, budget: &mut Budget) {
        for ((&x, v), &impulse) in self.x.iter().zip(&mut self.v).zip(each) {
            budget.add(Budget::kick(scale(impulse, part), self.mass, x, v));
        }
    }

    /// Moves each point straight on for `length_s` \[s\].
    pub fn drift(&mut self, length_s: f64) {
        for (x, v) in self.x.iter_mut().zip(&self.v) {
            *x = add(*x, scale(*v, length_s));
        }
    }

    /// Flies freely for `length_s` \[s\] under the impulses taken, and reports on each.
    ///
    /// A spread impulse acts half before and half after the flight, in the opposite order: that is a constant force,
    /// exact in path, moment and each one's work.
    ///
    /// # Errors
    /// [`PluginError::Physics`] where a point ends up nowhere.
    pub fn fly(&mut self, length_s: f64, taken: &[ImpulseInput]) -> Result<Vec<InterfaceReport>, PluginError> {
        let mut budgets = vec![Budget::default(); taken.len()];
        let (spread, at_once): (Vec<usize>, Vec<usize>) = (0..taken.len()).partition(|&i| taken[i].spread);
        let mut kick = |points: &mut Self, i: usize, part: f64| {
            if let Impulses::Samples(each) = &taken[i].impulses {
                points.kick(each, part, &mut budgets[i]);
            }
        };
        for &i in &at_once {
            kick(self, i, 1.0);
        }
        for &i in &spread {
            kick(self, i, 0.5);
        }
        self.drift(length_s);
        for &i in spread.iter().rev() {
            kick(self, i, 0.5);
        }
        if !self.is_finite() {
            return Err(PluginError::Physics(format!("a point of body `{}` is nowhere", self.body)));
        }
        let row = |(input, budget): (&ImpulseInput, Budget)| InterfaceReport {
            gross: input.impulses.gross(),
            ..budget.report(input.interface)
        };
        Ok(taken.iter().zip(budgets).map(row).collect())
    }

    /// Writes what changes in a run.
    pub fn save(&self, sink: &mut dyn StateSink) {
        sink.vec3s(&self.x);
        sink.vec3s(&self.v);
    }

    /// The same points in the state that was saved.
    ///
    /// # Errors
    /// [`StateError`] where it is the state of another number of points.
    pub fn restored(&self, reader: &mut StateReader<'_>) -> Result<Self, StateError> {
        let (x, v) = (reader.vec3s("positions", self.len())?, reader.vec3s("velocities", self.len())?);
        Ok(Self { x, v, ..self.clone() })
    }
}

impl Report {
    /// The state of bodies of points after one step without substeps.
    pub fn of_points(bodies: &[Points], dissipated_j: f64, interfaces: Vec<InterfaceReport>) -> Self {
        let kinetic_j = bodies.iter().map(Points::kinetic_j).sum();
        Self {
            substeps: 1,
            substep_bound_by: "nothing: one substep is exact".to_owned(),
            bodies: bodies.iter().map(Points::state).collect(),
            energy: Energy { kinetic_j, dissipated_j, ..Energy::default() },
            interfaces,
            ..Self::default()
        }
    }
}

impl Setup {
    /// The answer of a plugin of bodies of points that leaves out static colliders and needs no particular substep.
    pub fn of_points(plugin: &str, scene: &SolverScene, bodies: &[Points]) -> Self {
        let rows = scene.interfaces.iter().map(|view| Budget::default().report(view.id)).collect();
        let shown = bodies.iter().filter(|b| scene.is_coupled(&b.body));
        Self {
            boundaries: shown.map(Points::setup_boundary).collect(),
            report: Report::of_points(bodies, 0.0, rows),
            stable_dt: None,
            particles: bodies.iter().map(|b| b.len() as u64).collect(),
            left_out: scene.left_out_statics(plugin),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixtures::scene;
    use super::*;
    use crate::boundary::{Wrench, norm};
    use crate::scene::Source;

    #[test]
    fn a_body_without_points_or_mass_has_none() {
        let mut body = scene().bodies.remove(0);
        let points = Points::new(&body).unwrap();
        assert_eq!((points.len(), points.is_empty(), points.mass.to_bits()), (2, false, 0.5_f64.to_bits()));
        assert_eq!(points.setup_boundary().state, points.boundary().state);
        assert_eq!(points.setup_boundary().statics, SampleStatics::equal(2, 0.5));
        for mass in [None, Some(0.0), Some(f64::NAN)] {
            assert_eq!(Points::new(&Body { mass_kg: mass, ..body.clone() }), None);
        }
        body.source = Source::Points { positions_m: Vec::new() };
        assert_eq!(Points::new(&body), None);
    }

    #[test]
    fn a_kick_and_a_drift_are_in_the_books() {
        let mut points = Points::new(&scene().bodies[0]).unwrap();
        let (before, mut budget) = (points.state(), Budget::default());
        let each = [[1.0, 0.0, 0.0], [0.0, -2.0, 0.5]];
        points.kick(&each, 0.5, &mut budget);
        points.drift(0.25);
        points.kick(&each, 0.5, &mut budget);
        let change = points.state().momentum.minus(before.momentum);
        // All numbers are short binary fractions: the sums are exact.
        assert_eq!((change, points.kinetic_j()), (budget.wrench, budget.work_j));
        assert!(points.is_finite());
        points.v[1][2] = f64::INFINITY;
        assert!(!points.is_finite());
    }

    #[test]
    fn a_flight_reports_each_impulse_and_closes() {
        let mut points = Points::new(&scene().bodies[0]).unwrap();
        let before = points.clone();
        let taken = [(4, true), (5, false), (6, true)].map(|(interface, spread)| {
            let j = f64::from(interface);
            ImpulseInput { interface, impulses: Impulses::Samples(vec![[j, 0.5, -1.0], [0.0, -j, 2.0]]), spread }
        });
        let rows = points.fly(0.25, &taken).unwrap();
        let sum = rows.iter().fold(Wrench::default(), |sum, row| sum.plus(row.received));
        let open = points.state().momentum.minus(before.state().momentum).minus(sum);
        // Roundings of numbers of order ten.
        assert!(norm(open.linear) < 1e-14 && norm(open.angular) < 1e-14, "{open:?}");
        let work: f64 = rows.iter().map(|row| row.work_j).sum();
        assert!((points.kinetic_j() - before.kinetic_j() - work).abs() < 1e-12, "{work}");
        for (row, input) in rows.iter().zip(&taken) {
            assert_eq!((row.interface, row.gross.to_bits()), (input.interface, input.impulses.gross().to_bits()));
        }
        points.v[0][0] = f64::MAX;
        assert!(matches!(points.fly(1e9, &[]), Err(PluginError::Physics(_))));
    }

    #[test]
    fn set_up_and_report_list_every_body_and_interface() {
        let scene = scene();
        let points = [Points::new(&scene.bodies[0]).unwrap()];
        let setup = Setup::of_points("tester", &scene, &points);
        assert_eq!((setup.boundaries.len(), &setup.particles[..]), (1, &[2][..]));
        assert_eq!(setup.report.interfaces.iter().map(|row| row.interface).collect::<Vec<_>>(), [0, 1]);
        let report = Report::of_points(&points, 0.5, Vec::new());
        assert_eq!((report.bodies.len(), report.energy.dissipated_j.to_bits()), (1, 0.5_f64.to_bits()));
    }

    #[test]
    fn what_is_saved_is_restored() {
        let start = Points::new(&scene().bodies[0]).unwrap();
        let mut moved = start.clone();
        moved.kick(&[[1.0; 3], [2.0; 3]], 1.0, &mut Budget::default());
        moved.drift(0.1);
        let mut bytes = Vec::new();
        moved.save(&mut bytes);
        let mut reader = StateReader::new(&bytes);
        assert_eq!(start.restored(&mut reader), Ok(moved));
        assert_eq!(reader.end(), Ok(()));
        assert!(start.restored(&mut StateReader::new(&bytes[1..])).is_err());
    }
}
