//! What a scene asks of bodies that their states do not tell: how far they are strained, how far they reach.

use std::collections::BTreeMap;

use super::SolverScene;
use crate::boundary::Vec3;
use crate::scene::ProbeQuantity;

/// A question about a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Question {
    /// Largest strain; the plugin's description of itself says of which measure.
    Strain,
    /// Largest coordinate along this unit vector \[m\].
    Reach(Vec3),
}

/// The questions of a scene: name of the probe, place of the body in the scene, what is asked.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Questions(Vec<(String, usize, Question)>);

impl Questions {
    /// Those of a scene about its bodies.
    pub fn of(scene: &SolverScene) -> Self {
        let asked = scene.probes.iter().filter_map(|probe| {
            let body = scene.bodies.iter().position(|b| Some(&b.name) == probe.body.as_ref())?;
            let question = match probe.quantity {
                ProbeQuantity::Strain => Question::Strain,
                ProbeQuantity::Reach => Question::Reach(probe.along?),
                _ => return None,
            };
            Some((probe.name.clone(), body, question))
        });
        Self(asked.collect())
    }

    /// What `answer` says of each body, by the name of the probe; a question without an answer is left out.
    pub fn answers(&self, answer: impl Fn(usize, Question) -> Option<f64>) -> BTreeMap<String, f64> {
        let named =
            |(name, body, question): &(String, usize, Question)| Some((name.clone(), answer(*body, *question)?));
        self.0.iter().filter_map(named).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plugin::fixtures::scene;
    use crate::scene::Probe;

    #[test]
    fn questions_are_about_bodies_of_the_scene() {
        let mut scene = scene();
        let own = scene.bodies[0].name.clone();
        let probe = |name: &str, quantity, body: &str| Probe {
            name: name.into(),
            quantity,
            body: Some(body.into()),
            at_m: None,
            along: Some([0.0, 0.0, 1.0]),
        };
        scene.probes = vec![
            probe("high", ProbeQuantity::Reach, &own),
            probe("strained", ProbeQuantity::Strain, &own),
            probe("elsewhere", ProbeQuantity::Strain, "stranger"),
            probe("place", ProbeQuantity::Position, &own),
        ];
        let answers = Questions::of(&scene).answers(|body, question| match question {
            Question::Reach(along) => Some(along[2] + body as f64),
            Question::Strain => None,
        });
        assert_eq!(answers, [("high".to_owned(), 1.0)].into());
    }
}
