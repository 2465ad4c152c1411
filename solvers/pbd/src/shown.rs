//! Partners that show samples, and vertices that are attached to partners, in one step.

use cosplat_core::boundary::{BoundaryState, norm};
use cosplat_core::plugin::{Inputs, PluginError};

use crate::course::{Course, Meeting};
use crate::cover::Cover;
use crate::model::{Model, Part};
use crate::plugin::refused;
use crate::samples::{Known, Marks, Swarm};

/// Ties attached vertices to what their partners show in this step.
pub(crate) fn tie(model: &Model, course: &mut Course, inputs: &Inputs) {
    for bond in &mut course.bonds {
        let (face, x) = (&model.faces[bond.face], model.sim.vertices[bond.vertex as usize].x);
        match face.part {
            Part::Proxy(p) => bond.tie_rigid(p, &course.proxies[p], x),
            Part::Samples(_) => {
                let swarm = model.faces[..bond.face].iter().filter(|f| matches!(f.part, Part::Samples(_))).count();
                let Some(BoundaryState::Samples(samples)) = inputs.partner(face.id).map(|i| &i.now) else { continue };
                bond.tie_sample(swarm, &samples.position, x);
            }
            Part::Respond => {}
        }
    }
    for (s, swarm) in course.swarms.iter_mut().enumerate() {
        swarm.follow(course.bonds.iter().filter_map(|b| b.sample_of(s)));
    }
}

/// What is known of a partner that shows samples.
#[derive(Clone, Debug, Default)]
pub(crate) struct Shown {
    pub(crate) marks: Marks,
    pub(crate) known: Known,
}

/// Partners' samples, and which triangles each of them can meet in `length` \[s\].
pub(crate) fn swarms<'a>(
    model: &Model,
    shown: &'a [Shown],
    known: Vec<Known>,
    inputs: &'a Inputs,
    length: f64,
) -> Result<(Vec<Swarm<'a>>, Vec<Meeting>), PluginError> {
    let (mut swarms, mut meetings) = (Vec::new(), Vec::new());
    for ((face, Shown { marks, .. }), known) in model.faces.iter().zip(shown).zip(known) {
        let Part::Samples(surface) = face.part else { continue };
        let missing = || refused(&format!("a step without the boundary of `{}`", face.partner));
        let input = inputs.partner(face.id).ok_or_else(missing)?;
        let samples = input.samples(&face.partner, marks.len())?;
        let theirs = samples.velocity.iter().map(|&v| norm(v)).fold(0.0, f64::max);
        let way = (theirs + model.sim.fastest()) * length;
        let triangles = model.sim.triangles(face.body);
        let cover = Cover::new(&model.sim.mesh, &model.sim.vertices, triangles.clone(), false);
        let sizes = [way, 0.5 * model.sim.setting.thickness];
        swarms.push(Swarm::new(marks, (samples, input), &cover, sizes, known));
        meetings.push(Meeting { surface, triangles });
    }
    Ok((swarms, meetings))
}
