//! Two solvers with a body each that touch: the softer computes the contact, the other takes the impulses.

use cosplat_core::boundary::{BoundaryState, Impulses, Samples};
use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{ImpulseInput, Inputs, Outputs, PartnerInput, PartnerSetup, Plugin, SolverScene, ViewRole};
use cosplat_core::scene::MotionRule;
use cosplat_mpm::Real;

use super::{Run, rock};

/// Both solvers, and what the responder shows.
pub(crate) struct Pair<R: Real> {
    pub(crate) resolver: Run<R>,
    pub(crate) responder: Run<R>,
    pub(crate) shown: Samples,
}

fn samples(state: &BoundaryState) -> Samples {
    let BoundaryState::Samples(samples) = state else { panic!("a solid shows samples") };
    samples.clone()
}

impl<R: Real> Pair<R> {
    /// Of two scenes with a body each.
    pub(crate) fn new(mut resolver: SolverScene, mut responder: SolverScene, friction: f64) -> Self {
        let (own, partner) = (resolver.bodies[0].name.clone(), responder.bodies[0].name.clone());
        let mut view = rock::view(ViewRole::ContactResolver, &own, friction);
        view.partner.clone_from(&partner);
        view.partner_form = BoundaryForm::SamplesF32 { normals: true };
        resolver.interfaces.push(view);
        let mut view = rock::view(ViewRole::ContactResponder, &partner, friction);
        view.partner = own;
        view.partner_form = BoundaryForm::SamplesF32 { normals: true };
        responder.interfaces.push(view);
        let (mut resolver, responder) = (Run::new(resolver), Run::<R>::new(responder));
        let shown = samples(&responder.setup.boundaries[0].state);
        let statics = responder.setup.boundaries[0].statics.clone();
        resolver.plugin.connect(&[PartnerSetup { interface: 0, statics }]).expect("samples with masses");
        Self { resolver, responder, shown }
    }

    /// One window, in the order of the scheme `serial`.
    pub(crate) fn step(&mut self) -> [Outputs; 2] {
        let length_s = self.resolver.scene.clock.window_s();
        let now = BoundaryState::Samples(self.shown.clone());
        let partner = PartnerInput { interface: 0, rule: MotionRule::Hold, now, next: None, length_s };
        let resolved = self.resolver.step_with(&Inputs { partners: vec![partner], impulses: Vec::new() });
        let impulses = resolved.impulses[0].1.clone();
        let input = ImpulseInput { interface: 0, impulses, spread: true };
        let responded = self.responder.step_with(&Inputs { partners: Vec::new(), impulses: vec![input] });
        self.shown = samples(&responded.boundaries[0].state);
        [resolved, responded]
    }
}

/// Sum of the impulses on the responder \[N s\].
pub(crate) fn given(resolved: &Outputs) -> [f64; 3] {
    let Impulses::Samples(each) = &resolved.impulses[0].1 else { panic!("impulses on samples") };
    each.iter().fold([0.0; 3], |sum, j| [0, 1, 2].map(|k| sum[k] + j[k]))
}
