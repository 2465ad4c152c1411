//! What of a cloth is nearest to a sample, layer by layer, and on which side of the cloth the sample is.
//!
//! A cloth is a surface with two sides, whatever the partner is like: the triangles about the nearest point say on which
//! of them a sample is, by the one that is faced most (the nearest point of an edge or a corner belongs to several
//! triangles, and those seen at a glancing angle can answer wrongly; Bærentzen and Aanæs, "Signed distance computation
//! using the angle weighted pseudonormal", 2005). Beyond the rim there are no sides.

use std::ops::Range;

use cosplat_core::boundary::{Vec3, cross, dot, norm, scale, sub};
use rayon::prelude::*;

use crate::closest::{at, on_triangle};
use crate::own::Mesh;
use crate::place::Place;
use crate::side::{Side, Sides};
use crate::vertex::Vertex;

/// Cosine up to which two directions from a sample lead to different layers.
const APART: f64 = 0.5;
/// Part of a squared distance by which that to a point that two triangles share may differ by rounding.
const SAME: f64 = 1e-9;
/// Cosine to the normal at the rim beyond which a side can be told.
const FACED: f64 = 0.5;

/// Triangles of a task.
const TASK: usize = 2048;

/// The triangles of one cloth in one substep.
#[derive(Clone, Debug)]
pub(crate) struct Cover<'a> {
    pub(crate) mesh: &'a Mesh,
    pub(crate) vertices: &'a [Vertex],
    /// Its triangles among those of all cloths.
    pub(crate) range: Range<usize>,
    /// Middle and radius of each of them \[m\].
    pub(crate) balls: Vec<(Vec3, f64)>,
}

/// Nearest point of one layer of a cloth to a sample, or of its rim to a seam of two.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contact {
    pub(crate) samples: [u32; 2],
    /// How far from the first to the second of a seam; 0 of a sample.
    pub(crate) share: f64,
    pub(crate) place: Place,
    /// The nearest triangle.
    pub(crate) triangle: u32,
    /// Unit vector from the sample to where the cloth belongs.
    pub(crate) out: Vec3,
    /// Distance of the surfaces \[m\].
    pub(crate) gap: f64,
}

/// Nearest point of a triangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Found {
    square: f64,
    triangle: u32,
    share: [f64; 3],
    /// From the sample \[m\].
    way: Vec3,
}

impl<'a> Cover<'a> {
    /// Of one body, `range` being its triangles; `parallel` shares them out.
    pub(crate) fn new(mesh: &'a Mesh, vertices: &'a [Vertex], range: Range<usize>, parallel: bool) -> Self {
        let ball = |t: &[u32; 3]| {
            let x = t.map(|i| vertices[i as usize].x);
            let middle = at(x, [1.0 / 3.0; 3]);
            let square = |x: Vec3| dot(sub(x, middle), sub(x, middle));
            (middle, x.map(square).into_iter().fold(0.0, f64::max).sqrt())
        };
        let triangles = &mesh.triangles[range.clone()];
        let balls = if parallel {
            triangles.par_iter().with_min_len(TASK).map(ball).collect()
        } else {
            triangles.iter().map(ball).collect()
        };
        Self { mesh, vertices, range, balls }
    }

    /// Positions of the vertices \[m\].
    pub(crate) fn places(&self) -> impl Iterator<Item = Vec3> {
        self.vertices.iter().map(|v| v.x)
    }

    fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.mesh.triangles[triangle as usize].map(|i| self.vertices[i as usize].x)
    }

    fn normal(&self, triangle: u32) -> Vec3 {
        let [a, b, c] = self.corners(triangle);
        let n = cross(sub(b, a), sub(c, a));
        let length = norm(n);
        if length > 0.0 { scale(n, 1.0 / length) } else { [0.0; 3] }
    }

    /// Distance of two triangles at rest, by one corner of each \[m\].
    fn apart(&self, a: u32, b: u32) -> f64 {
        let corner = |t: u32| self.mesh.rest[self.mesh.triangles[t as usize][0] as usize];
        norm(sub(corner(a), corner(b)))
    }

    /// Contact of the sample at `x` with each layer of the cloth that is nearer than twice the distance `touching` at
    /// which surfaces touch \[m\], and its sides of them; `list` are the triangles that can be so near, `before` the
    /// sides when it was last looked at, and `same` the distance at rest within which triangles are of one layer \[m\].
    pub(crate) fn meet(
        &self,
        (sample, x): (u32, Vec3),
        list: &[u32],
        before: &Sides,
        [touching, same]: [f64; 2],
        found: &mut Vec<Found>,
    ) -> (Sides, [Option<Contact>; 3]) {
        let (mut sides, mut contacts) = (Sides::default(), [None; 3]);
        let mut layers: Vec<Found> = Vec::new();
        self.find(x, list, 2.0 * touching, found);
        for (i, one) in found.iter().enumerate() {
            let is_same = |layer: &Found| {
                let cosine = APART * (layer.square * one.square).sqrt();
                self.apart(layer.triangle, one.triangle) < same || dot(layer.way, one.way) > cosine
            };
            if layers.len() == sides.len() || layers.iter().any(is_same) {
                continue;
            }
            let far = |side: &Side| self.apart(side.triangle, one.triangle);
            let last = before.iter().flatten().filter(|side| far(side) < same);
            let last = last.min_by(|a, b| far(a).total_cmp(&far(b)));
            let (side, out, gap) = self.side(one, &found[i..], last, touching);
            let place = Place::on(self.mesh.triangles[one.triangle as usize], one.share);
            sides[layers.len()] = side;
            contacts[layers.len()] =
                Some(Contact { samples: [sample; 2], share: 0.0, place, triangle: one.triangle, out, gap });
            layers.push(*one);
        }
        (sides, contacts)
    }

    /// Nearest points of the triangles within `reach` of `x`, nearest first.
    fn find(&self, x: Vec3, list: &[u32], reach: f64, found: &mut Vec<Found>) {
        found.clear();
        for &triangle in list {
            let (middle, radius) = self.balls[triangle as usize - self.range.start];
            let d = sub(middle, x);
            if dot(d, d) >= (reach + radius) * (reach + radius) {
                continue;
            }
            let corners = self.corners(triangle);
            let share = on_triangle(corners, x);
            let way = sub(at(corners, share), x);
            let square = dot(way, way);
            if square < reach * reach {
                found.push(Found { square, triangle, share, way });
            }
        }
        found.sort_unstable_by(|a, b| a.square.total_cmp(&b.square).then(a.triangle.cmp(&b.triangle)));
    }

    /// Side of a sample, the direction in which the cloth belongs, and the distance of the surfaces; `rest` begins with
    /// the point itself.
    fn side(&self, one: &Found, rest: &[Found], last: Option<&Side>, touching: f64) -> (Option<Side>, Vec3, f64) {
        let distance = one.square.sqrt();
        let equal = rest.iter().take_while(|f| f.square <= one.square * (1.0 + SAME));
        // How the sample lies to the normal of each triangle that has the point: positive above.
        let (mut faced, mut normal) = (0.0_f64, self.normal(one.triangle));
        for f in equal {
            let n = self.normal(f.triangle);
            let height = -dot(n, f.way);
            if height.abs() > faced.abs() {
                (faced, normal) = (height, n);
            }
        }
        let is_above = faced >= 0.0;
        if self.mesh.is_rim(one.triangle as usize, one.share) && distance > 0.0 {
            let told = faced.abs() > FACED * distance;
            let side = told.then_some(Side { triangle: one.triangle, is_above, is_through: false });
            return (side, scale(one.way, 1.0 / distance), distance - touching);
        }
        let belongs = last.map_or(is_above, |side| side.is_above);
        let is_through = last.is_some() && (belongs != is_above || faced == 0.0);
        let side = Side { triangle: one.triangle, is_above: belongs, is_through };
        let away = if belongs { -1.0 } else { 1.0 };
        if faced == 0.0 {
            return (Some(side), scale(normal, away), -touching);
        }
        let turn = if is_through { -1.0 } else { 1.0 };
        (Some(side), scale(one.way, turn / distance), turn * distance - touching)
    }
}
