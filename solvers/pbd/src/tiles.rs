//! Cloth cut into small tiles, and where it is so flat that no two of its pieces can touch.
//!
//! Of a piece of sheet that is convex at rest, let `F` be the deformation gradient and `R` any two orthogonal unit
//! vectors. Where the symmetric part of `Rᵀ F` is at least `c`, then along the straight way between two points, `p` and
//! `q` at rest, `(x(p) - x(q)) · R (p - q) ≥ c |p - q|²`, so that they are at least `c |p - q|` apart (a gradient map of a
//! convex domain that is monotone is one-to-one). Pieces that are left alone at rest below a distance `r` are therefore
//! further apart than `c r` all over a flat piece, and none of them needs to be looked at.

use cosplat_core::boundary::{Vec3, add, dot, norm, scale, sub};

use crate::own::Mesh;
use crate::pieces::{Bounds, around};
use crate::vertex::Vertex;

/// Side of a tile, in edges.
const SIDE: f64 = 2.0;
/// Places of a block of two by two tiles.
const SQUARE: [[i64; 2]; 4] = [[0, 0], [0, 1], [1, 0], [1, 1]];

/// A tile: its place at rest, and what belongs to it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tile {
    pub(crate) body: usize,
    place: [i64; 3],
    pub(crate) vertices: Vec<u32>,
    pub(crate) edges: Vec<u32>,
    pub(crate) triangles: Vec<u32>,
    /// Vertices of all of these, and their box at rest.
    pub(crate) corners: Vec<u32>,
    pub(crate) rest: Bounds,
    /// Tiles of the block of two by two that it begins, and tiles that begin a block with it in it: of the last, those
    /// one place back along neither, the second, the first and both axes.
    block: [Option<u32>; 4],
    begins: [Option<u32>; 4],
}

/// How one body is cut.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cut {
    /// Side of a tile along each axis \[m\].
    side: Vec3,
    /// Least corner of the body \[m\].
    low: Vec3,
    /// Least distance of two pieces of a convex sheet that are not left alone \[m\]; nothing of another surface.
    least: Option<f64>,
}

/// All tiles.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tiles {
    pub(crate) all: Vec<Tile>,
    cuts: Vec<Cut>,
    /// Inverse of the edges of each triangle at rest, in the plane of its sheet.
    inverse: Vec<[f64; 4]>,
}

impl Cut {
    /// Of a body with these points at rest \[m\] and mean edge \[m\]; `sheet` are the sides of the squares of a sheet
    /// \[m\], `alone` the distance at rest below which pieces are left alone \[m\].
    pub(crate) fn new(points: &[Vec3], spacing: f64, sheet: Option<[f64; 2]>, alone: f64) -> Self {
        let low = points.iter().fold([f64::INFINITY; 3], |low, p| std::array::from_fn(|k| low[k].min(p[k])));
        let side = sheet.map_or([SIDE * spacing; 3], |[x, y]| [SIDE * x, SIDE * y, SIDE * spacing]);
        // In a lattice of right-angled triangles nothing is nearer than the shorter side but what lies on either side of
        // a diagonal; in one of squares, up to 1 %, what is further than a side is a diagonal away.
        let least = sheet.map(|[x, y]| {
            let second = if (x - y).abs() < 0.01 * x { 0.98 * x.hypot(y) } else { 0.0 };
            let all = [x * y / x.hypot(y), x.min(y), second];
            let is_more = |d: &f64| d * (1.0 - 1e-9) > alone && (*d < second || alone > x.max(y));
            all.into_iter().find(is_more).unwrap_or(alone)
        });
        Self { side, low, least }
    }

    fn place(&self, x: Vec3) -> [i64; 3] {
        std::array::from_fn(|k| ((x[k] - self.low[k]) / self.side[k]).floor() as i64)
    }
}

impl Tiles {
    /// Cuts all bodies, `owner` being the body of each vertex.
    pub(crate) fn new(mesh: &Mesh, owner: &[u32], cuts: Vec<Cut>) -> Self {
        let rest = |i: u32| mesh.rest[i as usize];
        let tile = |ends: &[u32]| {
            let body = owner[ends[0] as usize] as usize;
            let sum = ends.iter().fold([0.0; 3], |sum, &i| add(sum, rest(i)));
            (body, cuts[body].place(scale(sum, 1.0 / ends.len() as f64)))
        };
        let vertices: Vec<_> = (0..owner.len() as u32).map(|i| tile(&[i])).collect();
        let edges: Vec<_> = mesh.edges.iter().map(|e| tile(e)).collect();
        let triangles: Vec<_> = mesh.triangles.iter().map(|t| tile(t)).collect();
        let mut order: Vec<_> = vertices.iter().chain(&edges).chain(&triangles).copied().collect();
        order.sort_unstable();
        order.dedup();
        let mut all: Vec<Tile> = order.iter().map(|&(body, place)| Tile { body, place, ..Tile::default() }).collect();
        let at = |key: &(usize, [i64; 3])| order.binary_search(key).ok();
        let find = |key: &(usize, [i64; 3])| at(key).unwrap_or(0);
        (0..).zip(&vertices).for_each(|(i, key)| all[find(key)].vertices.push(i));
        (0..).zip(&edges).for_each(|(i, key)| all[find(key)].edges.push(i));
        (0..).zip(&triangles).for_each(|(i, key)| all[find(key)].triangles.push(i));
        for tile in &mut all {
            tile.corners.extend(&tile.vertices);
            tile.corners.extend(tile.edges.iter().flat_map(|&e| mesh.edges[e as usize]));
            tile.corners.extend(tile.triangles.iter().flat_map(|&t| mesh.triangles[t as usize]));
            tile.corners.sort_unstable();
            tile.corners.dedup();
            tile.rest = around(tile.corners.iter().map(|&i| rest(i)));
            let [i, j, k] = tile.place;
            let beside =
                |way: i64| SQUARE.map(|[a, b]| at(&(tile.body, [i + way * a, j + way * b, k])).map(|n| n as u32));
            (tile.block, tile.begins) = (beside(1), beside(-1));
        }
        let inverse = |t: &[u32; 3]| {
            let [a, b, c] = t.map(rest);
            let (u, v) = (sub(b, a), sub(c, a));
            let det = u[0] * v[1] - u[1] * v[0];
            if det == 0.0 { [0.0; 4] } else { [v[1], -v[0], -u[1], u[0]].map(|x| x / det) }
        };
        let inverse = mesh.triangles.iter().map(inverse).collect();
        Self { all, cuts, inverse }
    }

    /// How far pieces of the block of two by two tiles that begins with `tile` are apart at least \[m\]; 0 where that is
    /// not known. `room` is room to work in.
    pub(crate) fn apart(&self, mesh: &Mesh, vertices: &[Vertex], tile: usize, room: &mut Vec<[Vec3; 2]>) -> f64 {
        let gradient = |&t: &u32| {
            let [a, b, c] = mesh.triangles[t as usize].map(|i| vertices[i as usize].x);
            let (u, v, [p, q, r, s]) = (sub(b, a), sub(c, a), self.inverse[t as usize]);
            [add(scale(u, p), scale(v, r)), add(scale(u, q), scale(v, s))]
        };
        let tile = &self.all[tile];
        let Some(least) = self.cuts[tile.body].least else { return 0.0 };
        room.clear();
        for n in tile.block.into_iter().flatten() {
            room.extend(self.all[n as usize].triangles.iter().map(gradient));
        }
        let [a, b] = room.iter().fold([[0.0; 3]; 2], |sum, f| [add(sum[0], f[0]), add(sum[1], f[1])]);
        let Some(frame) = frame(a, b) else { return 0.0 };
        let stretch = |f: &[Vec3; 2]| {
            let [[xx, xy], [yx, yy]] = frame.map(|r| [dot(r, f[0]), dot(r, f[1])]);
            let (mean, off) = (0.5 * (xx + yy), 0.5 * (xy + yx));
            mean - (0.25 * (xx - yy) * (xx - yy) + off * off).sqrt()
        };
        room.iter().map(stretch).fold(f64::INFINITY, f64::min).max(0.0) * least
    }

    /// Tiles that begin a block with two tiles in it.
    pub(crate) fn blocks(&self, a: usize, b: usize) -> impl Iterator<Item = usize> {
        let (a, b) = (&self.all[a], &self.all[b]);
        let way: [i64; 3] = std::array::from_fn(|k| b.place[k] - a.place[k]);
        let beside = a.body == b.body && way.iter().all(|d| d.abs() <= 1) && way[2] == 0;
        // How far back from the first of them blocks begin: one place where the second is behind it, none where it is
        // ahead, both where it is beside.
        let holds = move |back: &[i64; 2]| beside && (0..2).all(|k| way[k] == 0 || back[k] == i64::from(way[k] < 0));
        let begins = SQUARE.iter().zip(a.begins).filter(move |(back, _)| holds(back));
        begins.filter_map(|(_, tile)| tile.map(|n| n as usize))
    }
}

/// The orthogonal unit vectors nearest to two vectors.
fn frame(a: Vec3, b: Vec3) -> Option<[Vec3; 2]> {
    let unit = |v: Vec3| {
        let length = norm(v);
        (length > 0.0).then(|| scale(v, 1.0 / length))
    };
    let (a, b) = (unit(a)?, unit(b)?);
    let (sum, difference) = (unit(add(a, b))?, unit(sub(a, b))?);
    let half = std::f64::consts::FRAC_1_SQRT_2;
    Some([scale(add(sum, difference), half), scale(sub(sum, difference), half)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closest::{at, edges_apart, on_triangle};
    use crate::sheet::Sheet;
    use cosplat_core::boundary::cross;

    /// A sheet of squares of 1 cm, and its tiles where pieces nearer than `alone` are left alone.
    fn cut(alone: f64) -> (Mesh, Tiles) {
        let sheet = Sheet::rectangle([0.12, 0.09], 0.01).expect("small");
        let edges = sheet.edges.iter().map(|e| e.0).collect();
        let mesh = Mesh { triangles: sheet.triangles, edges, rest: sheet.points, ..Mesh::default() };
        let cuts = vec![Cut::new(&mesh.rest, 0.01, Some([0.01, 0.01]), alone)];
        let tiles = Tiles::new(&mesh, &vec![0; mesh.rest.len()], cuts);
        (mesh, tiles)
    }

    /// Least distance of two edges, or a vertex and a triangle, that are at least `alone` apart at rest \[m\].
    fn least(mesh: &Mesh, x: &[Vec3], alone: f64) -> f64 {
        let mut least = f64::INFINITY;
        let ends = |e: [u32; 2], x: &[Vec3]| e.map(|i| x[i as usize]);
        for (i, &e) in mesh.edges.iter().enumerate() {
            for &f in &mesh.edges[..i] {
                if edges_apart(ends(e, &mesh.rest), ends(f, &mesh.rest)).sqrt() >= alone {
                    least = least.min(edges_apart(ends(e, x), ends(f, x)).sqrt());
                }
            }
        }
        let far = |x: &[Vec3], v: usize, t: [u32; 3]| {
            let corners = t.map(|i| x[i as usize]);
            norm(sub(at(corners, on_triangle(corners, x[v])), x[v]))
        };
        for v in 0..x.len() {
            for &t in mesh.triangles.iter().filter(|t| far(&mesh.rest, v, **t) >= alone) {
                least = least.min(far(x, v, t));
            }
        }
        least
    }

    #[test]
    fn every_piece_is_in_one_tile_and_what_is_left_alone_is_known() {
        for alone in [0.002, 0.0075, 0.012] {
            let (mesh, tiles) = cut(alone);
            let count = |f: fn(&Tile) -> usize| tiles.all.iter().map(f).sum::<usize>();
            assert_eq!(count(|t| t.vertices.len()), mesh.rest.len());
            assert_eq!(count(|t| t.edges.len()), mesh.edges.len());
            assert_eq!(count(|t| t.triangles.len()), mesh.triangles.len());
            let told = tiles.cuts[0].least.expect("a sheet");
            let found = least(&mesh, &mesh.rest, alone);
            // Roundings of centimetres.
            assert!(told <= found + 1e-15, "{told} {found}");
        }
    }

    #[test]
    fn pieces_of_what_is_called_flat_are_out_of_reach() {
        let alone = 0.006;
        let (mesh, tiles) = cut(alone);
        for bend in [0.0, 5.0, 12.0, 20.0, 40.0] {
            // Rolled up about a cylinder of radius 1 / bend, and sheared.
            let roll = |p: &Vec3| match bend {
                0.0 => [p[0], p[1], 0.0],
                bend => [(bend * p[0]).sin() / bend, p[1] + 0.2 * p[0], (1.0 - (bend * p[0]).cos()) / bend],
            };
            let x: Vec<Vec3> = mesh.rest.iter().map(roll).collect();
            let vertices: Vec<Vertex> = x.iter().map(|&x| Vertex { x, ..Vertex::default() }).collect();
            let reach = 0.0052;
            let flat = |n: usize| tiles.apart(&mesh, &vertices, n, &mut Vec::new()) > reach;
            // Blocks that begin behind the last square are empty.
            let is_flat = |n: usize| flat(n) || tiles.all[n].triangles.is_empty();
            assert!(bend > 12.0 || (0..tiles.all.len()).all(is_flat), "{bend}");
            for (a, b) in (0..tiles.all.len()).flat_map(|a| (0..=a).map(move |b| (a, b))) {
                if !tiles.blocks(a, b).any(flat) {
                    continue;
                }
                let edges = [a, b].map(|n| tiles.all[n].edges.iter().map(|&e| mesh.edges[e as usize]).collect());
                let [one, other]: [Vec<[u32; 2]>; 2] = edges;
                for (e, f) in one.iter().flat_map(|e| other.iter().map(move |f| (e, f))) {
                    let ends = |e: &[u32; 2], x: &[Vec3]| e.map(|i| x[i as usize]);
                    let rest = edges_apart(ends(e, &mesh.rest), ends(f, &mesh.rest)).sqrt();
                    let now = edges_apart(ends(e, &x), ends(f, &x)).sqrt();
                    assert!(rest < alone || now > reach, "{e:?} {f:?}");
                }
            }
        }
        let nowhere = vec![Vertex::default(); mesh.rest.len()];
        assert!((0..tiles.all.len()).all(|n| tiles.apart(&mesh, &nowhere, n, &mut Vec::new()) <= 0.0));
    }

    #[test]
    fn a_frame_is_orthogonal_and_shared_out_to_both() {
        let [r, s] = frame([2.0, 0.0, 0.0], [0.5, 1.0, 0.0]).expect("two directions");
        assert!(dot(r, s).abs() < 1e-15 && (norm(r) - 1.0).abs() < 1e-15);
        assert!(cross(r, s)[2] > 0.999_999 && frame([1.0, 0.0, 0.0], [1.0, 0.0, 0.0]).is_none());
    }
}
