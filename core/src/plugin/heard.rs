//! What partners said, checked before it is used: right form, right length, all numbers finite.

use super::exchange::{ImpulseInput, Inputs, PartnerInput};
use super::{InterfaceView, PartnerSetup, PluginError, Refusals};
use crate::boundary::{BoundaryState, Impulses, Samples, Vec3, Wrench};
use crate::plan::InterfaceId;

impl Inputs {
    /// Samples of the partner at an interface at the start of the step, of which there must be `count`.
    ///
    /// # Errors
    /// [`PluginError::Unsupported`] where the partner is missing, rigid or of another size, [`PluginError::Physics`]
    /// where a number is not finite.
    pub fn samples(&self, view: &InterfaceView, count: usize) -> Result<&Samples, PluginError> {
        let missing = || PluginError::Unsupported(format!("a step without the boundary of partner `{}`", view.partner));
        self.partner(view.id).ok_or_else(missing)?.samples(&view.partner, count)
    }

    /// Impulses on each of `count` own points at an interface; without any where the partner gave none.
    ///
    /// # Errors
    /// As [`ImpulseInput::on_points`].
    pub fn on_points(&self, view: &InterfaceView, count: usize) -> Result<ImpulseInput, PluginError> {
        let Some(input) = self.impulse(view.id) else {
            return Ok(ImpulseInput { interface: view.id, impulses: Impulses::Samples(Vec::new()), spread: true });
        };
        input.on_points(&view.own, &view.partner, count)?;
        Ok(input.clone())
    }
}

impl InterfaceView {
    /// Masses \[kg\] of the partner's `count` samples.
    ///
    /// # Errors
    /// [`PluginError::Unsupported`] where it has not as many, all with a positive mass.
    pub fn partner_masses(&self, partners: &[PartnerSetup], count: usize) -> Result<Vec<f64>, PluginError> {
        let found = partners.iter().find(|p| p.interface == self.id).map(|p| p.statics.mass_kg.as_slice());
        let fit = found.filter(|masses| masses.len() == count && masses.iter().all(|m| *m > 0.0));
        let why = || format!("partner `{}` must show {count} samples, each with a mass", self.partner);
        fit.map(<[f64]>::to_vec).ok_or_else(|| PluginError::Unsupported(why()))
    }
}

impl PartnerInput {
    /// Samples of the partner of that name at the start of the step, of which there must be `count`.
    ///
    /// # Errors
    /// [`PluginError::Unsupported`] for a rigid body or another number of samples, [`PluginError::Physics`] where a
    /// number is not finite.
    pub fn samples(&self, partner: &str, count: usize) -> Result<&Samples, PluginError> {
        let BoundaryState::Samples(samples) = &self.now else {
            return Err(PluginError::Unsupported(format!("`{partner}` is rigid and shows no samples")));
        };
        if (samples.position.len(), samples.velocity.len()) != (count, count) {
            let found = samples.position.len();
            return Err(PluginError::Unsupported(format!("`{partner}` has {found} samples instead of {count}")));
        }
        if samples.is_finite() {
            return Ok(samples);
        }
        Err(PluginError::Physics(format!("the boundary of partner `{partner}` is not finite")))
    }
}

impl ImpulseInput {
    /// Impulses \[N s\] of `partner` on each of the `count` points of body `own`.
    ///
    /// # Errors
    /// [`PluginError::Unsupported`] for an impulse on a rigid body or another number of points, [`PluginError::Physics`]
    /// where a number is not finite.
    pub fn on_points(&self, own: &str, partner: &str, count: usize) -> Result<&[Vec3], PluginError> {
        let Impulses::Samples(each) = &self.impulses else {
            return Err(PluginError::Unsupported(format!("a rigid impulse from `{partner}` on the points of `{own}`")));
        };
        if each.len() != count {
            let found = each.len();
            return Err(PluginError::Unsupported(format!(
                "{found} impulses from `{partner}` on `{own}`, which has {count} points"
            )));
        }
        if each.iter().flatten().all(|c| c.is_finite()) { Ok(each) } else { Err(not_finite(partner)) }
    }

    /// Impulse of `partner` on rigid body `own`.
    ///
    /// # Errors
    /// [`PluginError::Unsupported`] for impulses on samples, [`PluginError::Physics`] where a number is not finite.
    pub fn on_rigid(&self, own: &str, partner: &str) -> Result<Wrench, PluginError> {
        let Impulses::Rigid(wrench) = self.impulses else {
            return Err(PluginError::Unsupported(format!(
                "impulses from `{partner}` on samples of rigid body `{own}`"
            )));
        };
        let finite = wrench.linear.iter().chain(&wrench.angular).all(|c| c.is_finite());
        if finite { Ok(wrench) } else { Err(not_finite(partner)) }
    }
}

impl Inputs {
    /// What partners give to the rigid bodies of a step: by view, the wrench and whether it is spread over the step.
    /// A view is an interface, the name of the own body, and that of the partner.
    ///
    /// # Errors
    /// Boundaries of partners, impulses of other interfaces, on samples or twice from one partner, and such that are not
    /// finite.
    pub fn wrenches(
        &self,
        plugin: &str,
        views: &[(InterfaceId, &str, &str)],
    ) -> Result<Vec<Option<(Wrench, bool)>>, PluginError> {
        let refused = |what: &str| Refusals::one(plugin, what);
        if let Some(partner) = self.partners.first() {
            return Err(refused(&format!("the boundary of a partner (interface {})", partner.interface)));
        }
        let mut given = vec![None; views.len()];
        for input in &self.impulses {
            let Some(at) = views.iter().position(|view| view.0 == input.interface) else {
                return Err(refused(&format!("an input that interface {} does not have", input.interface)));
            };
            let (_, own, partner) = views[at];
            if given[at].replace((input.on_rigid(own, partner)?, input.spread)).is_some() {
                return Err(refused(&format!("two impulses from one partner (`{partner}`)")));
            }
        }
        Ok(given)
    }
}

fn not_finite(partner: &str) -> PluginError {
    PluginError::Physics(format!("the impulse from `{partner}` is not finite"))
}

#[cfg(test)]
mod tests {
    use super::super::fixtures::scene;
    use super::*;
    use crate::boundary::SampleStatics;
    use crate::scene::MotionRule;

    fn impulse(impulses: Impulses) -> ImpulseInput {
        ImpulseInput { interface: 0, impulses, spread: true }
    }

    #[test]
    fn impulses_on_points_fit_the_points() {
        let two = impulse(Impulses::Samples(vec![[1.0; 3], [2.0; 3]]));
        assert_eq!(two.on_points("cloud", "mud", 2), Ok(&[[1.0; 3], [2.0; 3]][..]));
        let why = two.on_points("cloud", "mud", 3).unwrap_err().to_string();
        assert_eq!(why, "2 impulses from `mud` on `cloud`, which has 3 points");
        assert!(matches!(two.on_rigid("cloud", "mud"), Err(PluginError::Unsupported(_))));
        let bad = impulse(Impulses::Samples(vec![[0.0, f64::NAN, 0.0]]));
        let why = PluginError::Physics("the impulse from `mud` is not finite".into());
        assert_eq!(bad.on_points("cloud", "mud", 1), Err(why));
    }

    #[test]
    fn the_impulses_of_an_interface_are_nothing_where_none_came() {
        let view = &scene().interfaces[0];
        let given = ImpulseInput { spread: false, ..impulse(Impulses::Samples(vec![[1.0; 3]])) };
        let inputs = Inputs { partners: Vec::new(), impulses: vec![given.clone()] };
        assert_eq!(inputs.on_points(view, 1), Ok(given));
        assert!(inputs.on_points(view, 2).is_err());
        assert_eq!(Inputs::default().on_points(view, 2), Ok(impulse(Impulses::Samples(Vec::new()))));
    }

    #[test]
    fn a_partner_has_as_many_masses_as_asked_for() {
        let view = &scene().interfaces[1];
        let partner = |mass| [PartnerSetup { interface: 1, statics: SampleStatics::equal(2, mass) }];
        assert_eq!(view.partner_masses(&partner(0.5), 2), Ok(vec![0.5; 2]));
        for (partners, count) in [(&partner(0.5)[..], 3), (&partner(0.0)[..], 2), (&[][..], 2)] {
            let why = view.partner_masses(partners, count).unwrap_err().to_string();
            assert_eq!(why, format!("partner `box` must show {count} samples, each with a mass"));
        }
    }

    #[test]
    fn impulses_on_rigid_bodies_are_one_wrench() {
        let wrench = Wrench { linear: [1.0; 3], angular: [2.0; 3] };
        assert_eq!(impulse(Impulses::Rigid(wrench)).on_rigid("box", "mud"), Ok(wrench));
        assert!(matches!(
            impulse(Impulses::Rigid(wrench)).on_points("box", "mud", 1),
            Err(PluginError::Unsupported(_))
        ));
        let bad = Wrench { angular: [0.0, 0.0, f64::INFINITY], ..wrench };
        assert!(matches!(impulse(Impulses::Rigid(bad)).on_rigid("box", "mud"), Err(PluginError::Physics(_))));
    }

    #[test]
    fn samples_of_a_partner_are_there_and_finite() {
        let view = &scene().interfaces[1];
        let heard = |x: Vec3| Inputs {
            partners: vec![PartnerInput {
                interface: view.id,
                rule: MotionRule::Hold,
                now: BoundaryState::points(&[x], &[[0.0; 3]]),
                next: None,
                length_s: 0.1,
            }],
            impulses: Vec::new(),
        };
        let one = heard([1.0; 3]);
        assert_eq!(one.samples(view, 1).map(|s| s.position.len()), Ok(1));
        assert!(matches!(one.samples(view, 2), Err(PluginError::Unsupported(_))));
        assert!(matches!(Inputs::default().samples(view, 1), Err(PluginError::Unsupported(_))));
        assert!(matches!(heard([f64::NAN; 3]).samples(view, 1), Err(PluginError::Physics(_))));
    }
}
