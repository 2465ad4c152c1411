//! What stands in the gas: static solids, rigid partners, samples of others, and the mouths of inflows.
//!
//! A solid gives each face near it a part of its mass, and the gas and that part have one velocity there. In the
//! projection such a face is heavier by its mass over that of the gas, `r`: `u (1 + r) = u* + Σ r v - Δq`, so that
//! pressure acts on both at once. What the solid then has lost, `m r (v - u)`, is what the gas has gained, face by
//! face; a light sheet yields within the solution, which is why it stays stable where the gas around it is the heavier
//! of the two. A heavy solid is a wall that lets `1/(1 + r)` through.
//!
//! Samples give their mass to eight faces of each component, linearly, and are moved by what these faces took. Solids
//! with a shape fill the faces whose middle is inside.

use cosplat_core::boundary::{Vec3, Wrench, cross, norm, scale, sub};
use cosplat_core::distance::{Placed, Shape, SignedDistance};
use cosplat_core::plan::InterfaceId;
use cosplat_core::plugin::InterfaceReport;

use crate::grid::{Faces, Grid, offset};
use crate::plugs::Plugs;
use crate::proxy::Proxy;
use crate::sides::{Sides, free};

/// Mass of a solid over that of the gas beyond which it is not told apart from a heavier one: it lets a thousandth
/// through. More would cost digits of the pressure where a wind blows into a wall.
pub(crate) const HEAVIEST: f64 = 1e3;

/// A face inside a solid: component and cell.
pub(crate) type Inside = (usize, [isize; 3]);

/// Faces whose middle is inside a shape; `radius` \[m\] about `centre` holds all of it.
pub(crate) fn inside(grid: &Grid, placed: &Placed, ball: Option<(Vec3, f64)>) -> Vec<Inside> {
    let mut found = Vec::new();
    for a in 0..3 {
        let range = |k: usize| {
            let last = grid.n[k] as isize - isize::from(k != a);
            let Some((centre, radius)) = ball else { return 0..=last };
            let cell = |x: f64| ((x - grid.low[k]) / grid.h).clamp(-1.0, grid.n[k] as f64 + 1.0).floor() as isize;
            cell(centre[k] - radius).max(0)..=(cell(centre[k] + radius) + 1).min(last)
        };
        for z in range(2) {
            for y in range(1) {
                for x in range(0) {
                    let cell = [x, y, z];
                    if placed.distance(grid.face(a, cell)).0 < 0.0 {
                        found.push((a, cell));
                    }
                }
            }
        }
    }
    found
}

/// Radius about the origin that holds a shape \[m\]; none for what goes on for ever.
pub(crate) fn radius(shape: &Shape) -> Option<f64> {
    match shape {
        Shape::Plane(_) | Shape::HeightField(_) => None,
        Shape::Box(half) => Some(norm(*half)),
        Shape::Sphere(r) => Some(*r),
        Shape::Cylinder(r, half) => Some(r.hypot(*half)),
        Shape::Mesh(mesh) => Some(mesh.radius()),
    }
}

/// Who a solid is.
#[derive(Clone, Debug)]
pub(crate) enum Kind {
    /// Moves at that velocity \[m/s\] whatever happens: a wall, or the mouth of an inflow.
    Driven(Vec3),
    /// A rigid partner.
    Rigid(Box<Proxy>),
}

/// A solid that fills faces.
#[derive(Clone, Debug)]
pub(crate) struct Filled {
    pub(crate) kind: Kind,
    pub(crate) faces: Vec<Inside>,
    /// Its mass over that of the gas, on each face.
    pub(crate) ratio: f64,
    /// Row of the interface; none for what is outside the coupled system.
    pub(crate) row: Option<usize>,
}

/// A partner that shows samples.
#[derive(Clone, Debug)]
pub(crate) struct Sampled {
    pub(crate) x: Vec<Vec3>,
    pub(crate) v: Vec<Vec3>,
    /// Mass of each over that of the gas in a cell.
    pub(crate) ratio: Vec<f64>,
    /// Row of the interface.
    pub(crate) row: usize,
    /// Impulse on each sample so far \[N s\].
    pub(crate) taken: Vec<Vec3>,
}

/// What crossed at an interface, on the gas, about the origin; and for a rigid partner about its centre.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Crossed {
    pub(crate) received: Wrench,
    pub(crate) gross: f64,
    pub(crate) work: f64,
    pub(crate) on_rigid: Wrench,
}

/// All solids over a step of the coupling.
#[derive(Clone, Debug, Default)]
pub(crate) struct Solids {
    pub(crate) filled: Vec<Filled>,
    pub(crate) sampled: Vec<Sampled>,
    /// By row of the interfaces.
    pub(crate) crossed: Vec<Crossed>,
    /// Impulse of driven solids on the gas \[N s\].
    pub(crate) external: Wrench,
    /// Sum of mass ratios on each face, and of their product with velocities \[m/s\].
    pub(crate) ratio: Faces,
    pub(crate) pull: Faces,
    /// Faces of inlets with solids on them.
    pub(crate) plugs: Plugs,
}

impl Solids {
    /// Calls `each(component, number, share)` for the faces near a place \[m\].
    fn near(grid: &Grid, x: Vec3, mut each: impl FnMut(usize, usize, f64)) {
        for a in 0..3 {
            for (at, weight) in grid.around(x, offset(a)) {
                each(a, at, weight);
            }
        }
    }

    /// Largest speed \[m/s\].
    pub(crate) fn speed(&self) -> f64 {
        let samples = self.sampled.iter().flat_map(|s| &s.v).map(|&v| norm(v));
        let filled = self.filled.iter().filter(|f| !f.faces.is_empty()).map(|f| match &f.kind {
            Kind::Driven(v) => norm(*v),
            Kind::Rigid(proxy) => proxy.speed(0.0),
        });
        samples.chain(filled).fold(0.0, f64::max)
    }

    /// Puts all masses on the faces: once a window, in which nothing moves.
    pub(crate) fn place(&mut self, grid: &Grid, sides: Sides) {
        self.ratio = grid.faces();
        for f in &self.filled {
            for &(a, cell) in &f.faces {
                self.ratio[a][grid.at(cell)] += f.ratio;
            }
        }
        for set in &self.sampled {
            for (x, ratio) in set.x.iter().zip(&set.ratio) {
                Self::near(grid, *x, |a, at, weight| self.ratio[a][at] += weight * ratio);
            }
        }
        self.plugs = Plugs::find(grid, sides, &self.ratio);
    }

    /// Puts all velocities on the faces: before each substep.
    pub(crate) fn pull(&mut self, grid: &Grid) {
        self.pull.iter_mut().for_each(|all| {
            all.clear();
            all.resize(grid.size, 0.0);
        });
        for f in &self.filled {
            for &(a, cell) in &f.faces {
                let v = match &f.kind {
                    Kind::Driven(v) => *v,
                    Kind::Rigid(proxy) => proxy.at(grid.face(a, cell)),
                };
                self.pull[a][grid.at(cell)] += f.ratio * v[a];
            }
        }
        for set in &self.sampled {
            for ((x, v), ratio) in set.x.iter().zip(&set.v).zip(&set.ratio) {
                Self::near(grid, *x, |a, at, weight| self.pull[a][at] += weight * ratio * v[a]);
            }
        }
    }

    /// Books what each solid gave to gas that now has velocity `u`, with the rounding `slack` of the projection; `mass`
    /// \[kg\] is that of the gas in a cell.
    pub(crate) fn book(&mut self, grid: &Grid, sides: Sides, u: &Faces, slack: &Faces, mass: f64, dt: f64) {
        let ranges = [0, 1, 2].map(|a| free(grid, sides, a));
        for f in &mut self.filled {
            let (mut all, mut gross, mut work) = (Wrench::default(), 0.0, 0.0);
            for &(a, cell) in &f.faces {
                if !(ranges[a][0]..=ranges[a][1]).contains(&cell[a]) {
                    continue;
                }
                let x = grid.face(a, cell);
                let v = match &f.kind {
                    Kind::Driven(v) => *v,
                    Kind::Rigid(proxy) => proxy.at(x),
                };
                let now = u[a][grid.at(cell)];
                let mut j = [0.0; 3];
                j[a] = mass * f.ratio * (v[a] - now + slack[a][grid.at(cell)]);
                all = all.plus(Wrench { linear: j, angular: cross(x, j) });
                gross += j[a].abs();
                work += j[a] * now;
            }
            if let Kind::Rigid(proxy) = &mut f.kind {
                let centre = proxy.record.position;
                let on = all.negated().about([0.0; 3], centre);
                proxy.take(on.linear, on.angular, dt);
                if let Some(row) = f.row {
                    self.crossed[row].on_rigid = self.crossed[row].on_rigid.plus(on);
                }
            }
            match f.row {
                Some(row) => self.crossed[row].take(all, gross, work),
                None => self.external = self.external.plus(all),
            }
        }
        // Corners of cells whose component is free: a sample beside the domain touches only what is inside.
        let is_free = free_numbers(grid, &ranges);
        for set in &mut self.sampled {
            let (mut all, mut gross, mut work) = (Wrench::default(), 0.0, 0.0);
            for i in 0..set.x.len() {
                let (v, ratio) = (set.v[i], set.ratio[i]);
                // Each sample's sum first: a sum of so many terms would lose digits that its parts have.
                let mut given = Wrench::default();
                Self::near(grid, set.x[i], |a, at, weight| {
                    if let Some(cell) = is_free(a, at) {
                        let mut j = [0.0; 3];
                        j[a] = mass * weight * ratio * (v[a] - u[a][at] + slack[a][at]);
                        given = given.plus(Wrench { linear: j, angular: cross(grid.face(a, cell), j) });
                        work += j[a] * u[a][at];
                    }
                });
                all = all.plus(given);
                let given = given.linear;
                gross += norm(given);
                set.v[i] = sub(v, scale(given, 1.0 / (mass * ratio)));
                set.taken[i] = sub(set.taken[i], given);
            }
            self.crossed[set.row].take(all, gross, work);
        }
    }
}

impl Crossed {
    /// As the report of an interface.
    pub(crate) fn report(&self, interface: InterfaceId) -> InterfaceReport {
        let (received, gross, work_j) = (self.received, self.gross, self.work);
        InterfaceReport { interface, received, gross, work_j, residual: 0.0 }
    }

    pub(crate) fn take(&mut self, all: Wrench, gross: f64, work: f64) {
        self.received = self.received.plus(all);
        self.gross += gross;
        self.work += work;
    }
}

/// The cell of a face by its number, where its component is free.
fn free_numbers<'a>(grid: &'a Grid, ranges: &'a [[isize; 2]; 3]) -> impl Fn(usize, usize) -> Option<[isize; 3]> + 'a {
    move |a, at| {
        let cell = [at % grid.s[1], at % grid.s[2] / grid.s[1], at / grid.s[2]].map(|i| i as isize - 2);
        let fits = |k: usize| {
            let [first, last] = if k == a { ranges[a] } else { [0, grid.n[k] as isize - 1] };
            (first..=last).contains(&cell[k])
        };
        (0..3).all(fits).then_some(cell)
    }
}
