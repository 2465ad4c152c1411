//! What a scene asks of a cloth that its state does not tell: how far it is stretched, how far it reaches.

use cosplat_core::boundary::{dot, norm, sub};
use cosplat_core::plugin::Question;

use crate::model::{Cloth, Model};

impl Model {
    /// The answer about a body now.
    pub(crate) fn answer(&self, body: usize, question: Question) -> Option<f64> {
        let cloth = self.cloths.get(body)?;
        Some(match question {
            Question::Strain => self.strain(cloth),
            Question::Reach(along) => {
                let own = self.sim.vertices[cloth.range.clone()].iter();
                own.map(|v| dot(v.x, along)).fold(f64::NEG_INFINITY, f64::max)
            }
        })
    }

    /// Largest part of its length by which an edge of a cloth, a thread or a diagonal, is off.
    fn strain(&self, cloth: &Cloth) -> f64 {
        let (mesh, vertices) = (&self.sim.mesh, &self.sim.vertices);
        let of = |[a, b]: [usize; 2]| {
            let rest = norm(sub(mesh.rest[a], mesh.rest[b]));
            (norm(sub(vertices[a].x, vertices[b].x)) / rest - 1.0).abs()
        };
        let edges = mesh.edges.iter().map(|e| e.map(|i| i as usize));
        edges.filter(|e| cloth.range.contains(&e[0])).map(of).fold(0.0, f64::max)
    }
}
