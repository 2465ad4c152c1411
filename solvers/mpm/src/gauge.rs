//! What a scene asks of a body that its state does not tell: how far it is strained, how far it reaches.

use std::collections::BTreeMap;

use cosplat_core::boundary::dot;
use cosplat_core::scene::{Probe, ProbeQuantity};
use nalgebra::Matrix3;

use crate::real::Real;
use crate::sim::Sim;
use crate::store::B;

/// One question.
#[derive(Clone, Copy, Debug)]
enum Question {
    /// Largest magnitude of a principal logarithmic strain.
    Strain,
    /// Largest coordinate along a unit vector \[m\].
    Reach([f64; 3]),
}

/// The questions of a scene, by the name of the probe and the place of the body.
#[derive(Clone, Debug, Default)]
pub(crate) struct Gauges(Vec<(String, u32, Question)>);

impl Gauges {
    /// Those of a scene about bodies with these names.
    pub(crate) fn of(probes: &[Probe], names: &[String]) -> Self {
        let one = |probe: &Probe| {
            let body = names.iter().position(|name| Some(name) == probe.body.as_ref())?;
            let question = match probe.quantity {
                ProbeQuantity::Strain => Question::Strain,
                ProbeQuantity::Reach => Question::Reach(probe.along?),
                _ => return None,
            };
            Some((probe.name.clone(), body as u32, question))
        };
        Self(probes.iter().filter_map(one).collect())
    }

    /// The answers now. The elastic strain `b_e - I` has the eigenvalues `exp(2 ε) - 1`.
    pub(crate) fn answers<R: Real>(&self, sim: &Sim<R>) -> BTreeMap<String, f64> {
        let answer = |(name, body, question): &(String, u32, Question)| {
            let of = sim.store.each().filter(|(block, _)| block.body == *body);
            let values = of.map(|(block, slot)| match question {
                Question::Strain => {
                    let b: [f64; 6] = std::array::from_fn(|k| sim.store.field(slot, B + k));
                    let b = Matrix3::new(b[0], b[3], b[4], b[3], b[1], b[5], b[4], b[5], b[2]);
                    b.symmetric_eigenvalues().iter().map(|e| 0.5 * e.ln_1p().abs()).fold(0.0, f64::max)
                }
                Question::Reach(along) => dot(sim.store.position(block, slot, sim.setting.dx), *along),
            });
            values.reduce(f64::max).map(|most| (name.clone(), most))
        };
        self.0.iter().filter_map(answer).collect()
    }
}
