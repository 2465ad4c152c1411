//! Exact signed distance of a closed mesh: a tree of boxes over its triangles, and signs from pseudo-normals.

use std::collections::BTreeMap;

use crate::boundary::{add, cross, dot, norm, scale, sub};

use super::closest::{Part, closest};
use crate::distance::Distance;

/// Triangles in a leaf.
const LEAF: usize = 4;

/// Triangles below a box. Leaves name triangles, others the second of two children; the first follows at once.
#[derive(Clone, Copy, Debug)]
struct Node {
    low: [f64; 3],
    high: [f64; 3],
    /// First triangle and their number, or 0 and the second child.
    first: u32,
    count: u32,
}

/// One triangle with the normals by which it tells inside from outside.
#[derive(Clone, Copy, Debug)]
struct Triangle {
    corners: [[f64; 3]; 3],
    face: [f64; 3],
    /// From each corner to the next: sum of the two faces' normals.
    edges: [[f64; 3]; 3],
    /// Sum of the faces' normals weighted by their angle at the corner.
    vertices: [[f64; 3]; 3],
}

/// The tree.
#[derive(Clone, Debug)]
pub(super) struct Tree {
    nodes: Vec<Node>,
    triangles: Vec<Triangle>,
}

impl Tree {
    /// Over the triangles of a closed mesh.
    pub(super) fn new(vertices: &[[f64; 3]], triangles: &[[u32; 3]]) -> Self {
        let mut triangles = with_normals(vertices, triangles);
        let mut nodes = Vec::new();
        let all = triangles.len();
        split(&mut nodes, &mut triangles, 0, all);
        Self { nodes, triangles }
    }

    /// Distance \[m\], negative inside, and the direction away from the surface.
    ///
    /// The sign is that of the pseudo-normal of the nearest corner, edge or face. Source: Bærentzen and Aanæs, "Signed
    /// distance computation using the angle weighted pseudonormal" (2005).
    pub(super) fn distance(&self, x: [f64; 3]) -> Distance {
        let Nearest { point, normal } = self.nearest(x, f64::INFINITY);
        signed(x, point, normal, dot(sub(x, point), normal) < 0.0)
    }

    /// Nearest point of the surface, where one is closer than the root of `best` \[m²\].
    pub(super) fn nearest(&self, x: [f64; 3], mut best: f64) -> Nearest {
        let (mut nearest, mut normal) = (x, [0.0, 0.0, 1.0]);
        let mut open = vec![0_usize];
        while let Some(at) = open.pop() {
            let node = &self.nodes[at];
            if outside(node, x) >= best {
                continue;
            }
            if node.count > 0 {
                for triangle in &self.triangles[node.first as usize..(node.first + node.count) as usize] {
                    let (c, part) = closest(triangle.corners, x);
                    let to = sub(x, c);
                    if dot(to, to) < best {
                        (best, nearest) = (dot(to, to), c);
                        normal = match part {
                            Part::Corner(i) => triangle.vertices[i],
                            Part::Edge(i) => triangle.edges[i],
                            Part::Face => triangle.face,
                        };
                    }
                }
                continue;
            }
            let (a, b) = (at + 1, node.first as usize);
            // The nearer child is looked at first.
            let first_is_nearer = outside(&self.nodes[a], x) <= outside(&self.nodes[b], x);
            open.extend(if first_is_nearer { [b, a] } else { [a, b] });
        }
        Nearest { point: nearest, normal }
    }

    /// Calls `f` with every triangle that the line along z through `x`, `y` passes, and the height there \[m\]. Triangles
    /// that stand upright have none.
    pub(super) fn pierce(&self, x: f64, y: f64, mut f: impl FnMut(usize, f64)) {
        let mut open = vec![0_usize];
        while let Some(at) = open.pop() {
            let Node { low, high, first, count } = self.nodes[at];
            if x < low[0] || x > high[0] || y < low[1] || y > high[1] {
                continue;
            }
            if count == 0 {
                open.extend([first as usize, at + 1]);
                continue;
            }
            for i in first as usize..(first + count) as usize {
                if let Some(height) = height(&self.triangles[i], x, y) {
                    f(i, height);
                }
            }
        }
    }

    /// Corners of every triangle.
    pub(super) fn corners(&self) -> impl Iterator<Item = [[f64; 3]; 3]> {
        self.triangles.iter().map(|t| t.corners)
    }
}

/// Nearest point of a surface.
pub(super) struct Nearest {
    /// \[m\].
    pub(super) point: [f64; 3],
    /// Pseudo-normal there, of any length.
    pub(super) normal: [f64; 3],
}

/// Distance and direction from the nearest point of a surface to `x`.
pub(super) fn signed(x: [f64; 3], nearest: [f64; 3], normal: [f64; 3], is_inside: bool) -> Distance {
    let away = sub(x, nearest);
    let (distance, sign) = (norm(away), if is_inside { -1.0 } else { 1.0 });
    // On the surface itself the way there is rounding; only the pseudo-normal knows where outside is.
    let direction = if distance > ROUNDING * norm(x) && distance > f64::MIN_POSITIVE {
        scale(away, sign / distance)
    } else {
        unit(normal)
    };
    (sign * distance, direction)
}

/// Rounding of a place, in parts of its coordinates, with a margin of a hundred.
const ROUNDING: f64 = 1e-14;

/// Part of a triangle's edge by which a line may miss it: it then still meets one of two neighbours.
const MISS: f64 = 1e-9;

/// Height of a triangle above `x`, `y`; nothing beside it, or where it stands upright.
fn height(triangle: &Triangle, x: f64, y: f64) -> Option<f64> {
    if triangle.face[2].abs() < UPRIGHT {
        return None;
    }
    let [a, b, c] = triangle.corners;
    let turn = |p: [f64; 3], q: [f64; 3]| (p[0] - x) * (q[1] - y) - (q[0] - x) * (p[1] - y);
    let parts = [turn(b, c), turn(c, a), turn(a, b)];
    let whole = parts[0] + parts[1] + parts[2];
    let [u, v, w] = parts.map(|part| part / whole);
    (u.min(v).min(w) >= -MISS).then_some(u * a[2] + v * b[2] + w * c[2])
}

/// Vertical part of the normal below which a triangle stands upright and has no height of its own.
pub(super) const UPRIGHT: f64 = 1e-6;

pub(super) fn unit(n: [f64; 3]) -> [f64; 3] {
    let length = norm(n);
    if length > 0.0 { scale(n, 1.0 / length) } else { [0.0, 0.0, 1.0] }
}

/// Square of the distance from a box.
fn outside(node: &Node, x: [f64; 3]) -> f64 {
    let d = [0, 1, 2].map(|k| (node.low[k] - x[k]).max(x[k] - node.high[k]).max(0.0));
    dot(d, d)
}

fn with_normals(vertices: &[[f64; 3]], triangles: &[[u32; 3]]) -> Vec<Triangle> {
    let mut at_vertex = vec![[0.0; 3]; vertices.len()];
    let mut at_edge: BTreeMap<(u32, u32), [f64; 3]> = BTreeMap::new();
    let mut list = Vec::with_capacity(triangles.len());
    for ids in triangles {
        let corners = ids.map(|i| vertices[i as usize]);
        let face = unit(cross(sub(corners[1], corners[0]), sub(corners[2], corners[0])));
        for k in 0..3 {
            let (here, next, last) = (corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]);
            let (a, b) = (unit(sub(next, here)), unit(sub(last, here)));
            let angle = libm::atan2(norm(cross(a, b)), dot(a, b));
            let vertex = &mut at_vertex[ids[k] as usize];
            *vertex = add(*vertex, scale(face, angle));
            let (i, j) = (ids[k], ids[(k + 1) % 3]);
            let edge = at_edge.entry((i.min(j), i.max(j))).or_default();
            *edge = add(*edge, face);
        }
        list.push(Triangle { corners, face, edges: [[0.0; 3]; 3], vertices: [[0.0; 3]; 3] });
    }
    for (triangle, ids) in list.iter_mut().zip(triangles) {
        triangle.vertices = ids.map(|i| at_vertex[i as usize]);
        for k in 0..3 {
            let (i, j) = (ids[k], ids[(k + 1) % 3]);
            triangle.edges[k] = at_edge.get(&(i.min(j), i.max(j))).copied().unwrap_or(triangle.face);
        }
    }
    list
}

/// Adds the node of `triangles[from..to]` and all below it.
fn split(nodes: &mut Vec<Node>, triangles: &mut [Triangle], from: usize, to: usize) {
    let part = &mut triangles[from..to];
    let mut node = Node { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3], first: from as u32, count: 0 };
    for corner in part.iter().flat_map(|t| t.corners) {
        node.low = std::array::from_fn(|k| node.low[k].min(corner[k]));
        node.high = std::array::from_fn(|k| node.high[k].max(corner[k]));
    }
    if part.len() <= LEAF {
        nodes.push(Node { count: part.len() as u32, ..node });
        return;
    }
    let size = sub(node.high, node.low);
    let axis = (1..3).fold(0, |a, k| if size[k] > size[a] { k } else { a });
    let middle = |t: &Triangle| t.corners[0][axis] + t.corners[1][axis] + t.corners[2][axis];
    // Stable, so that equal middles keep the order of the file.
    part.sort_by(|a, b| middle(a).total_cmp(&middle(b)));
    let half = from + part.len() / 2;
    let at = nodes.len();
    nodes.push(node);
    split(nodes, triangles, from, half);
    nodes[at].first = nodes.len() as u32;
    split(nodes, triangles, half, to);
}
