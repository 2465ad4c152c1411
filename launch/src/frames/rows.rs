//! What settled windows add to a recording: curves, and arrows for impulses.

use cosplat_core::boundary::{Vec3, add};
use cosplat_core::control::Done;
use cosplat_core::ledger::WindowRecord;
use cosplat_core::plan::Plan;
use cosplat_viewer::recording::{Curves, Recording, RecordingError};

/// Plots of a recording, from the top.
pub(super) const CURVES: [Curves<'static>; 5] = [
    Curves {
        path: "curves/closure",
        title: "log10 of the closure: momentum the states do not explain, of the largest",
    },
    Curves { path: "curves/impulse", title: "impulse that crossed in a window [N s]" },
    Curves { path: "curves/residual", title: "stand-in against partner [m/s]" },
    Curves { path: "curves/energy", title: "energy [J]" },
    Curves { path: "curves/step", title: "wall time of a window's computation [ms]" },
];

/// Logarithm that stands for zero.
const FLOOR: f64 = -20.0;

/// One settled window.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Row {
    pub(super) window: u64,
    pub(super) end_s: f64,
    /// Points of curves.
    pub(super) points: Vec<(String, f64)>,
    /// Impulses on bodies: name of the interface, where it acts, the impulse \[N s\].
    pub(super) impulses: Vec<(String, Vec3, Vec3)>,
}

impl Row {
    /// What a settled window adds.
    pub(crate) fn new(plan: &Plan, record: &WindowRecord, done: &[Done]) -> Self {
        let mut row = Self { window: record.window, end_s: record.end_s, ..Self::default() };
        for ((participant, solver), done) in plan.solvers().iter().zip(&record.solvers).zip(done) {
            let name = &participant.name;
            // The viewer has no logarithmic axis.
            row.point("closure", name, solver.closure.log10().max(FLOOR));
            row.point("energy", &format!("{name}-kinetic"), solver.kinetic_j);
            row.point("energy", &format!("{name}-potential"), solver.potential_j);
            row.point("step", name, done.times.compute_s * 1e3);
        }
        for (interface, now) in plan.interfaces.iter().zip(&record.interfaces) {
            row.point("impulse", &interface.name, now.gross);
            row.point("residual", &interface.name, now.residual);
            let owner = usize::from(interface.b.participant);
            let at = plan.participants.get(owner).and_then(|p| p.bodies.iter().position(|b| *b == interface.b.body));
            let body = at.and_then(|at| done.get(owner)?.report.bodies.get(at));
            if let Some(body) = body.filter(|_| interface.carries_impulses()) {
                row.impulses.push((interface.name.clone(), body.position_m, now.received));
            }
        }
        row.point("energy", "total", record.total_energy_j);
        row
    }

    /// Adds its points to the curves of a recording.
    pub(super) fn put(&self, recording: &mut Recording) -> Result<(), RecordingError> {
        let mut points = self.points.iter();
        points.try_for_each(|(path, value)| recording.series(path, self.window, self.end_s, *value))
    }

    fn point(&mut self, plot: &str, curve: &str, value: f64) {
        self.points.push((format!("curves/{plot}/{curve}"), value));
    }
}

/// Impulses since the last frame, by interface.
#[derive(Debug, Default)]
pub(super) struct Sums(Vec<(String, Vec3, Vec3)>);

impl Sums {
    /// Adds those of a window; each acts where its body is now.
    pub(super) fn add(&mut self, impulses: &[(String, Vec3, Vec3)]) {
        for (name, at, impulse) in impulses.iter().cloned() {
            match self.0.iter_mut().find(|(known, ..)| *known == name) {
                Some((_, place, sum)) => (*place, *sum) = (at, add(*sum, impulse)),
                None => self.0.push((name, at, impulse)),
            }
        }
    }

    /// Hands them over and begins anew, remembering whose arrows there are.
    pub(super) fn take(&mut self) -> Vec<(String, Vec3, Vec3)> {
        let taken = self.0.clone();
        self.0.iter_mut().for_each(|(_, _, sum)| *sum = [0.0; 3]);
        taken
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impulses_between_two_frames_add_up_where_the_body_is_last() {
        let mut sums = Sums::default();
        let named = |at: f64, j: f64| vec![("a~b".to_owned(), [at, 0.0, 0.0], [0.0, 0.0, j])];
        sums.add(&named(1.0, 0.25));
        sums.add(&named(2.0, 0.5));
        assert_eq!(sums.take(), named(2.0, 0.75));
        assert_eq!(sums.take(), named(2.0, 0.0), "an arrow that is over is drawn with no length");
    }
}
