//! A rigid partner's stand-in over one window, and its contact with the grid in each substep.
//!
//! With P = n nᵀ where a node slides and I where it sticks, `G_i = [I, -[r_i]×]`, target gap speed -φ⁺/dt:
//!
//! `(w M + Σ m Gᵀ P G) V' = w M (V* + dt b) + Σ m Gᵀ P (v* + n φ⁺/dt)`
//!
//! Passes repeat until the set of touching and sticking nodes is settled; then each node takes its impulse and the
//! stand-in exactly the opposite. Always solvable; without the sum on the left it would diverge once the touching mass
//! exceeds the body's.

use cosplat_core::boundary::{ProxyRecord, Wrench, add, cross, dot, norm, scale, sub};
use cosplat_core::plan::InterfaceId;
use nalgebra::{Matrix3, Matrix6, Quaternion, UnitQuaternion, Vector3, Vector6};

use crate::grid::{Grid, Substep};
use crate::reach::{Node, Touch, in_reach};
use crate::real::{Lanes, Real};
use crate::shape::{Placed, Shape};
use crate::tally::Tally;
use crate::walls::{Surface, Walls};

/// Passes over the contact set of one substep.
const PASSES: usize = 8;

/// What never changes about a rigid partner.
#[derive(Clone, Debug)]
pub(crate) struct Partner {
    /// Body.
    pub(crate) name: String,
    /// Shape about its centre of mass.
    pub(crate) shape: Shape,
    /// Interface and surface for each own body.
    pub(crate) pairs: Vec<Option<(InterfaceId, Surface)>>,
}

/// The stand-in.
#[derive(Clone, Debug)]
pub(crate) struct Proxy {
    /// Index of the partner.
    pub(crate) partner: usize,
    /// Share of the mass \[kg\] and of the inertia \[kg m²\] about the centre, in the frame at the start.
    mass: f64,
    inertia: Matrix3<f64>,
    /// Since the start of the window.
    turned: UnitQuaternion<f64>,
    start: ProxyRecord,
    center: [f64; 3],
    twist: Vector6<f64>,
    background: Vector6<f64>,
    /// Effect on own bodies.
    pub(crate) on_own: Vec<Tally>,
    /// Impulse on the partner by own body, about its centre at the start of the window.
    pub(crate) on_partner: Vec<Wrench>,
}

impl Proxy {
    /// Stand-in for a partner from its record, for so many own bodies.
    pub(crate) fn new(partner: usize, record: &ProxyRecord, bodies: usize) -> Self {
        let [xx, yy, zz, xy, xz, yz] = record.inertia;
        let six = |a: [f64; 3], b: [f64; 3]| Vector6::new(a[0], a[1], a[2], b[0], b[1], b[2]);
        Self {
            partner,
            mass: record.mass * record.share,
            inertia: Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) * record.share,
            turned: UnitQuaternion::identity(),
            start: *record,
            center: record.position,
            twist: six(record.linear_velocity, record.angular_velocity),
            background: six(record.background_linear, record.background_angular),
            on_own: vec![Tally::default(); bodies],
            on_partner: vec![Wrench::default(); bodies],
        }
    }

    /// Whether every number of a record is one; the mass of a scripted body may be infinite.
    pub(crate) fn is_sound(record: &ProxyRecord) -> bool {
        let r = record;
        let vectors = [r.position, r.linear_velocity, r.angular_velocity, r.background_linear, r.background_angular];
        let mut numbers = vectors.iter().flatten().chain(&r.orientation).chain([&r.share]);
        let inertia = r.mass.is_infinite() || r.inertia.iter().all(|i| i.is_finite());
        numbers.all(|x| x.is_finite()) && inertia && r.mass > 0.0
    }

    /// Velocity and angular velocity now.
    pub(crate) fn twist(&self) -> ([f64; 3], [f64; 3]) {
        let t = &self.twist;
        ([t[0], t[1], t[2]], [t[3], t[4], t[5]])
    }

    /// Its shape where it is now.
    pub(crate) fn placed(&self, shape: Shape) -> Placed {
        let [x, y, z, w] = self.start.orientation;
        let q = self.turned * UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        Placed::new(shape, self.center, [q.i, q.j, q.k, q.w])
    }

    /// Free motion over `dt`; contact comes after it.
    pub(crate) fn push(&mut self, dt: f64) {
        self.twist += self.background * dt;
    }

    /// Moves by its twist.
    pub(crate) fn drift(&mut self, dt: f64) {
        let (v, w) = self.twist();
        self.center = add(self.center, scale(v, dt));
        self.turned = UnitQuaternion::from_scaled_axis(Vector3::from(w) * dt) * self.turned;
    }

    fn point_velocity(&self, twist: &Vector6<f64>, x: [f64; 3]) -> [f64; 3] {
        let r = sub(x, self.center);
        add([twist[0], twist[1], twist[2]], cross([twist[3], twist[4], twist[5]], r))
    }

    /// Mass matrix, or nothing for a scripted body.
    fn mass_matrix(&self) -> Option<Matrix6<f64>> {
        if !self.mass.is_finite() {
            return None;
        }
        let rotation = self.turned.to_rotation_matrix();
        let inertia = rotation.matrix() * self.inertia * rotation.matrix().transpose();
        let mut matrix = Matrix6::zeros();
        matrix.fixed_view_mut::<3, 3>(0, 0).copy_from(&(Matrix3::identity() * self.mass));
        matrix.fixed_view_mut::<3, 3>(3, 3).copy_from(&inertia);
        Some(matrix)
    }

    /// `Gᵀ j` of an impulse at `x`.
    fn generalised(&self, x: [f64; 3], j: [f64; 3]) -> Vector6<f64> {
        let turn = cross(sub(x, self.center), j);
        Vector6::new(j[0], j[1], j[2], turn[0], turn[1], turn[2])
    }

    fn solve(&self, nodes: &[Node]) -> Vector6<f64> {
        let Some(mut matrix) = self.mass_matrix() else { return self.twist };
        let mut right = matrix * self.twist;
        for node in nodes {
            let gap = scale(node.normal, node.gap_speed);
            match node.state {
                Touch::Off => {}
                Touch::Slides => {
                    let g = self.generalised(node.x, node.normal);
                    matrix += g * g.transpose() * node.mass;
                    right += g * (node.mass * (dot(node.velocity, node.normal) - node.gap_speed));
                    right -= self.generalised(node.x, node.drag);
                }
                Touch::Sticks => {
                    let columns =
                        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|e| self.generalised(node.x, e));
                    for g in &columns {
                        matrix += g * g.transpose() * node.mass;
                    }
                    right += self.generalised(node.x, scale(sub(node.velocity, gap), node.mass));
                }
            }
        }
        matrix.cholesky().map_or(self.twist, |c| c.solve(&right))
    }

    /// One step of the contact set. Returns whether it changed.
    fn settle(&self, nodes: &mut [Node], twist: &Vector6<f64>) -> bool {
        let mut changed = false;
        for node in nodes {
            let wanted = add(self.point_velocity(twist, node.x), scale(node.normal, node.gap_speed));
            let full = scale(sub(wanted, node.velocity), node.mass);
            let normal = dot(full, node.normal);
            let along = sub(full, scale(node.normal, normal));
            let size = norm(along);
            let (state, drag) = match node.surface {
                Surface::Stick => (Touch::Sticks, [0.0; 3]),
                Surface::Coulomb(..) if normal <= 0.0 => (Touch::Off, [0.0; 3]),
                Surface::Coulomb(fixed, _) if size <= fixed * normal => (Touch::Sticks, [0.0; 3]),
                Surface::Coulomb(_, kinetic) => (Touch::Slides, scale(along, (kinetic * normal / size).min(1.0))),
            };
            let moved = norm(sub(drag, node.drag)) > 1e-9 * norm(drag);
            changed |= state != node.state || (state == Touch::Slides && moved);
            (node.state, node.drag) = (state, drag);
            node.impulse = match state {
                Touch::Off => [0.0; 3],
                Touch::Sticks => full,
                Touch::Slides => add(scale(node.normal, normal), drag),
            };
        }
        changed
    }
}

/// Contact of all stand-ins with the grid in one substep. Returns nodes within reach of two of them or of a wall.
pub(crate) fn resolve<R: Real>(
    step: &Substep,
    grid: &mut Grid<R>,
    walls: &Walls,
    partners: &[Partner],
    proxies: &mut [Proxy],
) -> u64 {
    for proxy in proxies.iter_mut() {
        proxy.push(step.dt);
    }
    let (mut sets, shared) = in_reach(step, grid, walls, partners, proxies);
    for (proxy, nodes) in proxies.iter_mut().zip(&mut sets) {
        let mut twist = proxy.twist;
        proxy.settle(nodes, &twist);
        for _ in 0..PASSES {
            twist = proxy.solve(nodes);
            if !proxy.settle(nodes, &twist) {
                break;
            }
        }
        let mut reaction = Vector6::zeros();
        for node in nodes.iter().filter(|n| n.state != Touch::Off) {
            let slot = &mut grid.nodes[node.entry][node.n];
            let m = slot.array()[3];
            let new = [0, 1, 2].map(|k| R::of(node.velocity[k] + node.impulse[k] / node.mass));
            *slot = R::V::from_array([new[0], new[1], new[2], m]);
            // What the grid really took, rounding included.
            let j = scale(sub(new.map(R::f64), node.velocity), node.mass);
            proxy.on_own[node.body].change(node.mass, node.x, node.velocity, new.map(R::f64));
            let about = cross(sub(node.x, proxy.start.position), j);
            proxy.on_partner[node.body] = proxy.on_partner[node.body].minus(Wrench { linear: j, angular: about });
            reaction -= proxy.generalised(node.x, j);
        }
        if let Some(inverse) = proxy.mass_matrix().and_then(Matrix6::cholesky) {
            proxy.twist += inverse.solve(&reaction);
        }
        proxy.drift(step.dt);
    }
    shared
}
