//! Vertices that are held: fixed to the world, moved, or attached to partners.

use cosplat_core::boundary::{Vec3, norm, sub};
use serde::Deserialize;

use crate::bond::Bond;
use crate::model::{Face, Part};
use crate::pull::Pull;
use crate::read::Reader;

/// Vertices that are moved.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PullSpec {
    /// Point of the world at t = 0 \[m\].
    at: Vec3,
    /// \[m/s\]
    velocity: Vec3,
    /// Time at which they stop \[s\].
    until: Option<f64>,
}

/// Vertices that are attached to a partner.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct BondSpec {
    /// Body of another solver.
    to: String,
    /// Points of the world at t = 0 \[m\].
    at: Vec<Vec3>,
}

/// What holds the vertices of one body, by their number in its source.
#[derive(Clone, Debug, Default)]
pub(crate) struct Held {
    pub(crate) fixed: Vec<bool>,
    /// Velocity and end.
    pub(crate) pulled: Vec<(usize, Vec3, f64)>,
    /// Name of the partner.
    pub(crate) bound: Vec<(usize, String)>,
}

impl Reader<'_> {
    /// What holds a body's vertices, which are at `x` \[m\]; a point means those within `reach` \[m\].
    pub(crate) fn held(&mut self, body: &str, x: &[Vec3], reach: f64) -> Held {
        let params = &self.params;
        let pins = params.pins.get(body).cloned().unwrap_or_default();
        let pulls = params.pulls.get(body).cloned().unwrap_or_default();
        let bonds = params.bonds.get(body).cloned().unwrap_or_default();
        let mut held = Held { fixed: vec![false; x.len()], ..Held::default() };
        let mut near = |what: &str, point: Vec3| {
            // Half a spacing reaches one vertex; rounding must not let it reach none.
            let close = |i: &usize| norm(sub(x[*i], point)) <= reach * (1.0 + 1e-9);
            let found: Vec<usize> = (0..x.len()).filter(close).collect();
            if found.is_empty() {
                self.refused.push(format!("a {what} of `{body}` at {point:?} m, {reach} m or more from any vertex"));
            }
            found
        };
        for pin in pins {
            for i in near("pin", pin) {
                held.fixed[i] = true;
            }
        }
        let mut wrong = Vec::new();
        for pull in pulls {
            let until = pull.until.unwrap_or(f64::INFINITY);
            if !(pull.velocity.iter().all(|v| v.is_finite()) && until >= 0.0) {
                wrong.push(format!("a pull of `{body}` at {:?} m/s until {until} s", pull.velocity));
            }
            for i in near("pull", pull.at) {
                if held.fixed[i] {
                    wrong.push(format!("a vertex of `{body}` at {:?} m that is pinned or pulled twice", x[i]));
                }
                held.fixed[i] = true;
                held.pulled.push((i, pull.velocity, until));
            }
        }
        for bond in bonds {
            for point in bond.at {
                held.bound.extend(near("bond", point).into_iter().map(|i| (i, bond.to.clone())));
            }
        }
        if let Some((i, to)) = held.bound.iter().find(|(i, _)| held.fixed[*i]) {
            wrong.push(format!("a vertex of `{body}` at {:?} m that is pinned and attached to `{to}`", x[*i]));
        }
        for what in wrong {
            self.refused.push(what);
        }
        held
    }

    /// Names of bodies in what is held that are not there. A process that was left without any body has nothing to be
    /// wrong about.
    pub(crate) fn strangers(&mut self) {
        let scene = self.scene;
        let is_strange = |name: &&String| !scene.bodies.is_empty() && !scene.bodies.iter().any(|b| b.name == **name);
        let params = &self.params;
        let names = [
            ("pins", params.pins.keys().collect::<Vec<_>>()),
            ("pulls", params.pulls.keys().collect()),
            ("bonds", params.bonds.keys().collect()),
        ];
        for (what, names) in names {
            for name in names.into_iter().filter(is_strange) {
                self.refused.push(format!("{what} of a body it does not have (`{name}`)"));
            }
        }
    }

    /// Attached vertices with the interface that each is attached at, sorted by vertex.
    pub(crate) fn bonds(&mut self, bound: &[(u32, usize, String)], faces: &[Face]) -> Vec<Bond> {
        let mut bonds = Vec::new();
        for (vertex, body, to) in bound {
            let resolves = |f: &Face| f.body == *body && f.partner == *to && f.part != Part::Respond;
            if let Some(face) = faces.iter().position(resolves) {
                bonds.push(Bond::new(*vertex, face));
            } else {
                let own = &self.scene.bodies[*body].name;
                let what =
                    format!("bonds of `{own}` to `{to}`: they need a contact of the two that this solver resolves");
                self.refused.push(what);
            }
        }
        bonds.sort_by_key(|b| (b.vertex, b.face));
        bonds
    }
}

impl Held {
    /// Pins that move, with their place in memory.
    pub(crate) fn pulls(&self, place: impl Fn(usize) -> u32) -> impl Iterator<Item = Pull> {
        self.pulled.iter().map(move |&(i, velocity, until)| Pull { vertex: place(i), velocity, until })
    }
}
