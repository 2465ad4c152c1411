//! Surfaces whose measures are known.

#![allow(dead_code, reason = "every test file is a program of its own and uses a part")]

pub(crate) mod files;

use cosplat_core::asset::TriangleMesh;

/// A box with its corner at `at`, each face with vertices of its own, as modelling programs write it.
pub(crate) fn brick(at: [f64; 3], size: [f64; 3]) -> TriangleMesh {
    let corner = |i: usize| [0, 1, 2].map(|k| at[k] + if i >> k & 1 == 1 { size[k] } else { 0.0 });
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut mesh = TriangleMesh::default();
    for quad in quads {
        let n = mesh.vertices_m.len() as u32;
        mesh.vertices_m.extend(quad.map(corner));
        mesh.triangles.extend([[n, n + 1, n + 2], [n, n + 2, n + 3]]);
    }
    mesh
}

/// A torus around z.
pub(crate) fn torus(big: f64, small: f64, rings: u32, sides: u32) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    let tau = std::f64::consts::TAU;
    for i in 0..rings {
        for j in 0..sides {
            let (u, v) = (tau * f64::from(i) / f64::from(rings), tau * f64::from(j) / f64::from(sides));
            let r = big + small * v.cos();
            mesh.vertices_m.push([r * u.cos(), r * u.sin(), small * v.sin()]);
            let at = |i: u32, j: u32| i % rings * sides + j % sides;
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

/// Random numbers that are the same everywhere.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn between(&mut self, lower: f64, upper: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let mixed = (self.0 ^ (self.0 >> 32)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        lower + (upper - lower) * ((mixed >> 11) as f64 / (1_u64 << 53) as f64)
    }
}

/// The folder of meshes and captures, if there is one.
pub(crate) fn data() -> Option<std::path::PathBuf> {
    let folder = std::env::var_os("COSPLAT_DATA").map(std::path::PathBuf::from);
    if folder.is_none() {
        eprintln!("skipped: COSPLAT_DATA does not name a data folder");
    }
    folder
}
