//! What partners said to a step: sorted by coupling and checked before anything moves.

use cosplat_core::boundary::BoundaryState;
use cosplat_core::plugin::{Inputs, PluginError, Refusals};

use crate::V3;
use crate::model::{Coupling, Model};
use crate::modes::Cubic;

/// What partners said, in the order of the model's couplings.
#[derive(Clone, Debug)]
pub(crate) struct Heard {
    /// Path of the partner, for couplings that compute a spring.
    pub(crate) paths: Vec<Option<Cubic>>,
    /// Impulse on the own body and whether it is spread, for couplings that take impulses.
    pub(crate) impulses: Vec<Option<(V3, bool)>>,
}

impl Heard {
    /// Silence, for the report at t = 0.
    pub(crate) fn nothing(model: &Model) -> Self {
        let n = model.couplings.len();
        Self { paths: vec![None; n], impulses: vec![None; n] }
    }

    /// Sorts inputs by interface and checks them.
    pub(crate) fn new(model: &Model, inputs: &Inputs) -> Result<Self, PluginError> {
        let mut heard = Self::nothing(model);
        for input in &inputs.partners {
            let (at, coupling) = find(model, input.interface, Coupling::computes)?;
            for state in [Some(&input.now), input.next.as_ref()].into_iter().flatten() {
                if let BoundaryState::Samples(s) = state
                    && (s.position.len(), s.velocity.len()) != (1, 1)
                {
                    return Err(refused(&format!(
                        "a partner of {} samples (`{}`)",
                        s.position.len(),
                        coupling.partner
                    )));
                }
            }
            let path = input.path(0).map(V3::from);
            if path.iter().flat_map(V3::iter).any(|v| !v.is_finite()) {
                return Err(PluginError::Physics(format!("the path of partner `{}` is not finite", coupling.partner)));
            }
            if heard.paths[at].replace(path).is_some() {
                return Err(refused(&format!("two paths of one partner (`{}`)", coupling.partner)));
            }
        }
        for input in &inputs.impulses {
            let (at, coupling) = find(model, input.interface, |c| c.role.takes_impulses())?;
            let impulse = input.on_points(&model.bodies[coupling.own].name, &coupling.partner, 1)?[0];
            if heard.impulses[at].replace((impulse.into(), input.spread)).is_some() {
                return Err(refused(&format!("two impulses from one partner (`{}`)", coupling.partner)));
            }
        }
        let silent = |(c, path): &(&Coupling, &Option<Cubic>)| c.computes() && path.is_none();
        if let Some((coupling, _)) = model.couplings.iter().zip(&heard.paths).find(silent) {
            return Err(refused(&format!("a step without the boundary of linked partner `{}`", coupling.partner)));
        }
        Ok(heard)
    }
}

fn find(model: &Model, id: u16, fits: impl Fn(&Coupling) -> bool) -> Result<(usize, &Coupling), PluginError> {
    let found = model.couplings.iter().enumerate().find(|(_, c)| c.id == id);
    found.filter(|(_, c)| fits(c)).ok_or_else(|| refused(&format!("an input that interface {id} does not have")))
}

fn refused(what: &str) -> PluginError {
    Refusals::one("oscillator", what)
}
