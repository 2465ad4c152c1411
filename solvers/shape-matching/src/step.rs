//! One step of all bodies, and the books.

use cosplat_core::boundary::Wrench;
use cosplat_core::plugin::{Budget, InfluenceKind, PluginError, Pulse, Signal, Step};

use crate::V3;
use crate::contact::{Touch, find, settle};
use crate::model::{Model, State};

/// Substeps of a step beyond which a body is not fast but blowing up.
const MOST_SUBSTEPS: f64 = 1e6;
/// Part of its radius that a body may move in a substep.
const COURANT: f64 = 0.1;

/// Impulses of a partner in a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Given {
    pub(crate) linear: V3,
    /// About the centre of mass at the start of the step.
    pub(crate) angular: V3,
    /// Over the whole step, or at once at its start.
    pub(crate) spread: bool,
}

/// What has acted in a step.
#[derive(Clone, Debug)]
pub(crate) struct Books {
    pub(crate) substeps: u64,
    /// Gravity, other influences and walls.
    pub(crate) external: Budget,
    /// Work of influences \[J\].
    pub(crate) driven_j: f64,
    /// Of it, the work of those without a potential energy \[J\].
    pub(crate) supplied_j: f64,
    /// By view.
    pub(crate) received: Vec<Budget>,
    /// Of walls and other bodies on each body: impulse, and angular impulse about its centre.
    pub(crate) pushed: Vec<[V3; 2]>,
    pub(crate) contacts: u64,
    /// Deepest overlap at the start of a substep \[m\].
    pub(crate) deepest: f64,
}

/// Covers a step.
pub(crate) fn run(
    model: &Model,
    state: &mut State,
    given: &[Option<Given>],
    step: &Step,
    pulse: &mut dyn Pulse,
) -> Result<Books, PluginError> {
    let all = model.bodies.iter().zip(&state.bodies);
    let rate = all.map(|(b, m)| m.velocity.norm() / b.radius + b.omega(m).norm()).fold(0.0, f64::max);
    let longest = model.longest.min(COURANT / rate.max(f64::MIN_POSITIVE));
    // A whole number of longest substeps must not become one more by rounding.
    let count = (step.length_s / longest - 1e-9).ceil().max(1.0);
    if !(1.0..MOST_SUBSTEPS).contains(&count) {
        return Err(PluginError::Physics(format!("a body moves or turns by {rate:.3e} of its radius a second")));
    }
    let (count, h) = (count as u64, step.length_s / count);
    let mut books = Books {
        substeps: count,
        external: Budget::default(),
        driven_j: 0.0,
        supplied_j: 0.0,
        received: vec![Budget::default(); model.views.len()],
        pushed: vec![[V3::zeros(); 2]; model.bodies.len()],
        contacts: 0,
        deepest: 0.0,
    };
    let at_start: Vec<V3> = state.bodies.iter().map(|m| m.position).collect();
    let before = model.kinetic(state);
    for i in 0..count {
        let t = step.start_s + i as f64 * h;
        push(model, state, [t, t + h], &mut books);
        for ((view, given), received) in model.views.iter().zip(given).zip(&mut books.received) {
            let Some(given) = given.filter(|g| g.spread || i == 0) else { continue };
            let share = if given.spread { 1.0 / count as f64 } else { 1.0 };
            let (linear, angular) = (given.linear * share, given.angular * share);
            let (body, moving) = (&model.bodies[view.own], &mut state.bodies[view.own]);
            // About the place where it was given, so that the angular momentum about any fixed point changes by it.
            let point = at_start[view.own];
            let work_j = body.push(moving, linear, angular + (point - moving.position).cross(&linear));
            let about = (angular + point.cross(&linear)).into();
            received.add(Budget { wrench: Wrench { linear: linear.into(), angular: about }, work_j });
        }
        let mut touches = find(model, state, h);
        books.contacts += touches.len() as u64;
        books.deepest = touches.iter().map(Touch::depth).fold(books.deepest, f64::max);
        settle(model, state, &mut touches, h, &mut books.external, &mut books.pushed);
        for (body, moving) in model.bodies.iter().zip(&mut state.bodies) {
            body.fly(moving, h);
        }
        if pulse.beat(i + 1, count) == Signal::Abort {
            return Err(PluginError::Aborted);
        }
    }
    if let Some((body, _)) = model.bodies.iter().zip(&state.bodies).find(|(_, m)| !m.is_finite()) {
        return Err(PluginError::Physics(format!("`{}` is nowhere: use a shorter `max_substep_s`", body.name)));
    }
    let given: f64 = books.received.iter().map(|b| b.work_j).sum::<f64>() + books.driven_j;
    state.dissipated += before + given - model.kinetic(state);
    Ok(books)
}

/// Outside influences over a substep from `start` to `end` \[s\].
fn push(model: &Model, state: &mut State, [start, end]: [f64; 2], books: &mut Books) {
    for influence in &model.influences {
        let seconds = (end.min(influence.until) - start.max(influence.from)).max(0.0);
        let begins = influence.from >= start && influence.from < end;
        for &i in &influence.bodies {
            let (body, moving) = (&model.bodies[i], &mut state.bodies[i]);
            let (impulse, at) = match influence.kind {
                InfluenceKind::Kick(impulse, at) if begins => (impulse, at.unwrap_or(moving.position)),
                InfluenceKind::Kick(..) => continue,
                _ => (influence.force(body.mass) * seconds, moving.position),
            };
            let work_j = body.kick(moving, impulse, at);
            books.driven_j += work_j;
            if !influence.has_potential() {
                books.supplied_j += work_j;
            }
            let wrench = Wrench { linear: impulse.into(), angular: at.cross(&impulse).into() };
            books.external.add(Budget { wrench, work_j });
        }
    }
}
