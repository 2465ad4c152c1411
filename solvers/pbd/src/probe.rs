//! What a scene asks of a cloth that its state does not tell: how far it is stretched, how far it reaches.

use std::collections::BTreeMap;

use cosplat_core::boundary::{Vec3, dot, norm, sub};
use cosplat_core::scene::{Body, Probe, ProbeQuantity};

use crate::model::{Cloth, Model};

/// One question.
#[derive(Clone, Copy, Debug)]
enum Question {
    /// Largest part of its length by which a thread or a diagonal is off.
    Strain,
    /// Largest coordinate of a vertex along a unit vector \[m\].
    Reach(Vec3),
}

/// The questions of a scene, by the name of the probe and the place of the body.
#[derive(Clone, Debug, Default)]
pub(crate) struct Questions(Vec<(String, usize, Question)>);

impl Questions {
    /// Those of a scene.
    pub(crate) fn of(probes: &[Probe], bodies: &[Body]) -> Self {
        let one = |probe: &Probe| {
            let body = bodies.iter().position(|b| Some(&b.name) == probe.body.as_ref())?;
            let question = match probe.quantity {
                ProbeQuantity::Strain => Question::Strain,
                ProbeQuantity::Reach => Question::Reach(probe.along?),
                _ => return None,
            };
            Some((probe.name.clone(), body, question))
        };
        Self(probes.iter().filter_map(one).collect())
    }

    /// The answers now.
    pub(crate) fn answers(&self, model: &Model) -> BTreeMap<String, f64> {
        let answer = |(name, body, question): &(String, usize, Question)| {
            let cloth = model.cloths.get(*body)?;
            let most = match question {
                Question::Strain => model.strain(cloth),
                Question::Reach(along) => {
                    let own = model.sim.vertices[cloth.range.clone()].iter();
                    own.map(|v| dot(v.x, *along)).fold(f64::NEG_INFINITY, f64::max)
                }
            };
            Some((name.clone(), most))
        };
        self.0.iter().filter_map(answer).collect()
    }
}

impl Model {
    /// Largest part of its length by which an edge of a cloth is off.
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
