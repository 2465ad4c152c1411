//! Outside influences on bodies that move as one: what they do to which of them, and when.

use super::Refusals;
use super::scene::SolverScene;
use crate::scene::{Action, ActionKind, Field};

type V3 = nalgebra::Vector3<f64>;

/// An outside influence on some bodies in a range of time.
#[derive(Clone, Debug, PartialEq)]
pub struct Influence {
    /// What it does.
    pub kind: InfluenceKind,
    /// Places in the solver's list of those bodies that are free to move.
    pub bodies: Vec<usize>,
    /// \[s\].
    pub from: f64,
    /// \[s\].
    pub until: f64,
    /// Whether it acts at all times.
    pub always: bool,
    /// For a force at a point of its bodies: the first of its lever arms, one per body, in a list of those of all
    /// influences ([`hooks`]). A solver fills them in when the force begins.
    pub hooks: Option<usize>,
}

/// What an influence does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum InfluenceKind {
    /// \[m/s²\], with the potential energy `-m g·x` where it always acts.
    Gravity(V3),
    /// \[m/s²\].
    Acceleration(V3),
    /// \[N\], at the point of the body that is at that place of the world when the force begins; else at the centre of
    /// mass.
    Force(V3, Option<V3>),
    /// \[N s\] at `from`, at a point of the world; else at the centre of mass.
    Kick(V3, Option<V3>),
    /// Velocity and spin become their opposites at `from`.
    Reverse,
}

/// What a plugin can do with points beside the centre of mass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OffCentre {
    /// Forces.
    pub forces: bool,
    /// Sudden impulses.
    pub kicks: bool,
}

impl Influence {
    /// Whether it acts at `t` \[s\].
    pub fn acts_at(&self, t: f64) -> bool {
        t >= self.from && t < self.until
    }

    /// Whether it begins in `start..end` \[s\].
    pub fn begins_in(&self, start: f64, end: f64) -> bool {
        self.from >= start && self.from < end
    }

    /// Whether it acts at once, when it begins.
    pub fn is_sudden(&self) -> bool {
        matches!(self.kind, InfluenceKind::Kick(..) | InfluenceKind::Reverse)
    }

    /// What it does at once to a body at `position` \[m\] with that momentum \[kg m/s\] and spin \[kg m²/s\]: an impulse
    /// \[N s\], the point of the world where it acts \[m\], and an angular impulse about that point \[N m s\].
    pub fn blow(&self, position: V3, momentum: V3, spin: V3) -> Option<(V3, V3, V3)> {
        match self.kind {
            InfluenceKind::Kick(impulse, at) => Some((impulse, at.unwrap_or(position), V3::zeros())),
            InfluenceKind::Reverse => Some((momentum * -2.0, position, spin * -2.0)),
            _ => None,
        }
    }

    /// Whether its potential energy is in the books: gravity that always acts. One that begins or ends would make or take
    /// energy at once; its work is supplied.
    pub fn has_potential(&self) -> bool {
        matches!(self.kind, InfluenceKind::Gravity(_)) && self.always
    }

    /// Constant force on a body of that mass while it acts \[N\].
    pub fn force(&self, mass: f64) -> V3 {
        match self.kind {
            InfluenceKind::Gravity(g) | InfluenceKind::Acceleration(g) => g * mass,
            InfluenceKind::Force(f, _) => f,
            InfluenceKind::Kick(..) | InfluenceKind::Reverse => V3::zeros(),
        }
    }
}

/// Lever arms that all influences need.
pub fn hooks(influences: &[Influence]) -> usize {
    influences.iter().filter(|i| i.hooks.is_some()).map(|i| i.bodies.len()).sum()
}

/// Moments strictly inside `(start, end)` \[s\] at which an influence begins or ends, in order, each once.
pub fn switches(influences: &[Influence], start: f64, end: f64) -> Vec<f64> {
    let ends = |i: &Influence| if i.is_sudden() { [i.from, i.from] } else { [i.from, i.until] };
    let mut cuts: Vec<f64> = influences.iter().flat_map(ends).filter(|&t| t > start && t < end).collect();
    cuts.sort_by(f64::total_cmp);
    cuts.dedup();
    cuts
}

impl Refusals {
    /// The actions of a scene, or refusals of what depends on the place of a body's parts, and of points beside the
    /// centre of mass that the plugin cannot play. Kinds of actions that its descriptor lacks are left to
    /// [`Refusals::undeclared`].
    pub fn influences(&mut self, scene: &SolverScene, off_centre: OffCentre) -> Vec<Influence> {
        let mut list: Vec<Influence> = Vec::new();
        for action in &scene.actions {
            let Some(kind) = self.influence(action, off_centre) else { continue };
            let acts = |b: &crate::scene::Body| action.bodies.is_empty() || action.bodies.contains(&b.name);
            let free = scene.bodies.iter().enumerate().filter(|(_, b)| acts(b) && b.prescribed.is_none());
            let bodies = free.map(|(i, _)| i).collect();
            let hooks = matches!(kind, InfluenceKind::Force(_, Some(_))).then(|| hooks(&list));
            let until = action.until_s.unwrap_or(f64::INFINITY);
            list.push(Influence { kind, bodies, from: action.from_s, until, always: action.always(), hooks });
        }
        list
    }

    fn influence(&mut self, action: &Action, off_centre: OffCentre) -> Option<InfluenceKind> {
        let beside = |can: bool, at: Option<[f64; 3]>| !can && at.is_some();
        match action.kind {
            ActionKind::Gravity { acceleration_m_s2 } => Some(InfluenceKind::Gravity(acceleration_m_s2.into())),
            ActionKind::AccelerationField { field: Field::Constant { acceleration_m_s2 } } => {
                Some(InfluenceKind::Acceleration(acceleration_m_s2.into()))
            }
            ActionKind::AccelerationField { .. } => {
                self.push("acceleration fields that vary in space");
                None
            }
            ActionKind::PointForce { at_m, .. } if beside(off_centre.forces, at_m) => {
                self.push("point forces beside the centre of mass (`at_m`)");
                None
            }
            ActionKind::PointForce { force_n, at_m } => Some(InfluenceKind::Force(force_n.into(), at_m.map(V3::from))),
            ActionKind::Impulse { at_m, .. } if beside(off_centre.kicks, at_m) => {
                self.push("impulses beside the centre of mass (`at_m`)");
                None
            }
            ActionKind::Impulse { impulse_n_s, at_m } => {
                Some(InfluenceKind::Kick(impulse_n_s.into(), at_m.map(V3::from)))
            }
            ActionKind::Reverse => Some(InfluenceKind::Reverse),
            ActionKind::Wind { .. } | ActionKind::Inflow { .. } | ActionKind::Drain { .. } => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixtures::scene;
    use super::*;

    fn action(kind: ActionKind, from_s: f64, until_s: Option<f64>) -> Action {
        Action { kind, bodies: Vec::new(), from_s, until_s }
    }

    #[test]
    fn lever_arms_are_counted_over_all_influences_and_points_are_refused_where_they_cannot_be_played() {
        let mut scene = scene();
        let n = scene.bodies.len();
        let force = |at_m| ActionKind::PointForce { force_n: [1.0, 0.0, 0.0], at_m };
        scene.actions = vec![
            action(ActionKind::Gravity { acceleration_m_s2: [0.0, 0.0, -2.0] }, 0.0, None),
            action(force(Some([1.0; 3])), 0.5, Some(1.0)),
            action(force(None), 0.0, Some(0.5)),
            action(force(Some([2.0; 3])), 0.25, Some(0.75)),
        ];
        let mut none = Refusals::new("x");
        let both = OffCentre { forces: true, kicks: true };
        let list = none.influences(&scene, both);
        assert!(none.finish().is_ok());
        assert_eq!(list.iter().map(|i| i.hooks).collect::<Vec<_>>(), [None, Some(0), None, Some(n)]);
        assert_eq!(hooks(&list), 2 * n);
        assert_eq!(switches(&list, 0.0, 1.0), [0.25, 0.5, 0.75]);
        assert_eq!(list[0].force(3.0), V3::new(0.0, 0.0, -6.0));
        let mut some = Refusals::new("x");
        assert_eq!(some.influences(&scene, OffCentre::default()).len(), 2);
        assert!(some.finish().unwrap_err().to_string().contains("beside the centre of mass"));
    }

    #[test]
    fn what_turns_round_goes_as_fast_the_other_way() {
        let mut scene = scene();
        scene.actions = vec![action(ActionKind::Reverse, 0.5, None)];
        let list = Refusals::new("x").influences(&scene, OffCentre::default());
        assert!(list[0].is_sudden() && list[0].force(2.0) == V3::zeros());
        let [at, momentum, spin] = [V3::x(), V3::y() * 3.0, V3::z()];
        assert_eq!(list[0].blow(at, momentum, spin), Some((momentum * -2.0, at, spin * -2.0)));
        assert_eq!(switches(&list, 0.0, 1.0), [0.5]);
    }

    #[test]
    fn what_moves_as_it_was_told_takes_no_influence() {
        let mut scene = scene();
        scene.bodies[0].prescribed =
            Some(crate::scene::Motion::Twist { linear_m_s: [1.0, 0.0, 0.0], angular_rad_s: [0.0; 3] });
        scene.actions = vec![action(ActionKind::Gravity { acceleration_m_s2: [0.0; 3] }, 0.0, None)];
        let list = Refusals::new("x").influences(&scene, OffCentre::default());
        assert!(!list[0].bodies.contains(&0));
    }
}
