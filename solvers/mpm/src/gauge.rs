//! What a scene asks of a body that its state does not tell: how far it is strained, how far it reaches.

use cosplat_core::boundary::dot;
use cosplat_core::plugin::Question;
use nalgebra::Matrix3;

use crate::real::Real;
use crate::sim::Sim;
use crate::store::B;

impl<R: Real> Sim<R> {
    /// The answer about a body now. Strain is the largest magnitude of a principal logarithmic one: the elastic strain
    /// `b_e - I` has the eigenvalues `exp(2 ε) - 1`.
    pub(crate) fn answer(&self, body: usize, question: Question) -> Option<f64> {
        let of = self.store.each().filter(|(block, _)| block.body as usize == body);
        let values = of.map(|(block, slot)| match question {
            Question::Strain => {
                let b: [f64; 6] = std::array::from_fn(|k| self.store.field(slot, B + k));
                let b = Matrix3::new(b[0], b[3], b[4], b[3], b[1], b[5], b[4], b[5], b[2]);
                b.symmetric_eigenvalues().iter().map(|e| 0.5 * e.ln_1p().abs()).fold(0.0, f64::max)
            }
            Question::Reach(along) => dot(self.store.position(block, slot, self.setting.dx), along),
        });
        values.reduce(f64::max)
    }
}
