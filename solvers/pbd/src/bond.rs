//! Vertices that are attached to a partner: to a point of a rigid body, or to a sample.
//!
//! A bond closes its gap within the substep, in every direction: the impulse `K⁻¹ (v + d/h)` with `d` the gap, `v` how
//! fast it opens and `K` the velocity per impulse of both sides. What is attached to a rigid body is a point of it. What
//! is attached to a sample keeps its place relative to it without turning, so that more than one vertex is needed where a
//! body turns.

use cosplat_core::boundary::{Vec3, add, norm, scale, sub};
use cosplat_core::plugin::{StateError, StateReader, StateSink};
use nalgebra::{Matrix3, Vector3};

use crate::contact::{Cause, Others};
use crate::proxy::Proxy;
use crate::samples::Swarm;
use crate::tally::Tally;
use crate::vertex::Vertex;

/// What a vertex is attached to, once it has been seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Anchor {
    /// Nearest sample; 0 of a rigid body.
    pub(crate) sample: u32,
    /// Point of the rigid body in its own frame, or the way from the sample \[m\].
    at: Vec3,
}

/// An attached vertex.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bond {
    pub(crate) vertex: u32,
    /// Interface, by its index.
    pub(crate) face: usize,
    pub(crate) anchor: Option<Anchor>,
    /// Stand-in or swarm of this step.
    pub(crate) cause: Cause,
    /// Impulse on the vertex in this substep so far \[N s\].
    given: Vec3,
}

impl Bond {
    /// Of a vertex at an interface.
    pub(crate) fn new(vertex: u32, face: usize) -> Self {
        Self { vertex, face, anchor: None, cause: Cause::Wall, given: [0.0; 3] }
    }

    /// Ties it to the point of a rigid partner where the vertex is at `x`, if it is not tied yet.
    pub(crate) fn tie_rigid(&mut self, index: usize, proxy: &Proxy, x: Vec3) {
        self.cause = Cause::Proxy(index);
        self.anchor.get_or_insert_with(|| Anchor { sample: 0, at: proxy.local(x) });
    }

    /// Ties it to the nearest of some samples.
    pub(crate) fn tie_sample(&mut self, index: usize, samples: &[Vec3], x: Vec3) {
        let away = |i: usize| norm(sub(x, samples[i]));
        let nearest = || (0..samples.len()).min_by(|&a, &b| away(a).total_cmp(&away(b))).unwrap_or(0);
        let anchor = *self.anchor.get_or_insert_with(|| {
            let i = nearest();
            Anchor { sample: i as u32, at: samples.get(i).map_or([0.0; 3], |&s| sub(x, s)) }
        });
        self.cause = Cause::Sample(index, anchor.sample);
    }

    /// The sample of a swarm that it is tied to.
    pub(crate) fn sample_of(&self, swarm: usize) -> Option<u32> {
        match self.cause {
            Cause::Sample(s, sample) if s == swarm => Some(sample),
            _ => None,
        }
    }

    /// Where its vertex ought to be \[m\], how fast that moves \[m/s\] and its velocity per impulse \[1/kg\].
    fn target(&self, proxies: &[Proxy], swarms: &[Swarm], x: Vec3) -> Option<(Vec3, Vec3, Matrix3<f64>)> {
        let anchor = self.anchor?;
        match self.cause {
            Cause::Wall | Cause::Seam(..) => None,
            Cause::Proxy(p) => {
                let proxy = &proxies[p];
                Some((proxy.world(anchor.at), proxy.velocity(x), proxy.mobility(x)))
            }
            Cause::Sample(s, i) => {
                let (at, u) = swarms[s].state(i);
                Some((add(at, anchor.at), u, Matrix3::identity() * swarms[s].inverse(i)))
            }
        }
    }

    /// Greatest gap of some bonds \[m\].
    pub(crate) fn widest(bonds: &[Self], vertices: &[Vertex], (proxies, swarms): (&[Proxy], &[Swarm])) -> f64 {
        let gap = |bond: &Self| {
            let x = vertices[bond.vertex as usize].x;
            bond.target(proxies, swarms, x).map_or(0.0, |(at, ..)| norm(sub(x, at)))
        };
        bonds.iter().map(gap).fold(0.0, f64::max)
    }
}

/// Starts a substep.
pub(crate) fn begin(bonds: &mut [Bond]) {
    for bond in bonds {
        bond.given = [0.0; 3];
    }
}

/// Closes all gaps in turn.
pub(crate) fn hold(bonds: &mut [Bond], vertices: &mut [Vertex], owner: &[u32], others: &mut Others, h: f64) {
    for bond in bonds {
        let vertex = &mut vertices[bond.vertex as usize];
        let x = vertex.x;
        let Some((at, u, partner)) = bond.target(others.proxies, others.swarms, x) else { continue };
        let Some(stiff) = (partner + Matrix3::identity() * vertex.w).try_inverse() else { continue };
        let opens = add(sub(vertex.u, u), scale(sub(x, at), 1.0 / h));
        let impulse: Vec3 = (stiff * Vector3::from(scale(opens, -1.0))).into();
        let body = owner[bond.vertex as usize] as usize;
        bond.given = add(bond.given, impulse);
        others.give_back(bond.cause, body, x, impulse).give(vertex, impulse);
    }
}

/// Books the work of bonds on vertices that had the velocities `start` \[m/s\].
pub(crate) fn earn(bonds: &[Bond], vertices: &[Vertex], start: &[Vec3], owner: &[u32], others: &mut Others) {
    for bond in bonds {
        let i = bond.vertex as usize;
        let tally: &mut Tally = match bond.cause {
            Cause::Wall | Cause::Seam(..) => continue,
            Cause::Proxy(p) => &mut others.proxies[p].on_own[owner[i] as usize],
            Cause::Sample(s, _) => &mut others.on_own[s],
        };
        tally.earn(bond.given, [start[i], vertices[i].u]);
    }
}

/// Writes the anchors.
pub(crate) fn save(bonds: &[Bond], sink: &mut dyn StateSink) {
    for bond in bonds {
        let anchor = bond.anchor.unwrap_or(Anchor { sample: 0, at: [0.0; 3] });
        sink.u64(bond.anchor.is_some().into());
        sink.u64(anchor.sample.into());
        sink.vec3(anchor.at);
    }
}

/// Reads them back; `samples` is how many an interface shows.
pub(crate) fn restore(
    bonds: &[Bond],
    reader: &mut StateReader,
    samples: impl Fn(usize) -> usize,
) -> Result<Vec<Bond>, StateError> {
    let mut read = Vec::new();
    for bond in bonds {
        let (known, found, at) = (reader.u64()? != 0, reader.u64()?, reader.vec3()?);
        let expected = samples(bond.face) as u64;
        if known && found > 0 && found >= expected {
            return Err(StateError::Count { what: "samples that cloth is attached to", found, expected });
        }
        read.push(Bond { anchor: known.then_some(Anchor { sample: found as u32, at }), ..*bond });
    }
    Ok(read)
}
