//! Bodies and floors made of triangles.

mod common;

use std::sync::Arc;

use common::{G, STILL, body, collider, play, rough, scene, start};
use cosplat_conformance::parts::gravity;
use cosplat_core::asset::{Asset, TriangleMesh};
use cosplat_core::boundary::{BoundaryState, Vec3, norm, sub};
use cosplat_core::plugin::{Plugin, PluginError, SolverScene};
use cosplat_core::scene::Source;
use cosplat_core::visual::VisualState;
use cosplat_rigid::Rigid;

fn file() -> Source {
    Source::Mesh { file: "prepared".into(), metres_per_unit: 1.0, up: "+z".into() }
}

/// Outlines extruded along y from 0 to `depth` \[m\]: corners in x and z, counter-clockwise seen from -y, and the
/// triangles that fill them.
fn extruded(outline: &[[f64; 2]], filling: &[[u32; 3]], depth: f64) -> TriangleMesh {
    let n = outline.len() as u32;
    let corner = |y: f64| outline.iter().map(move |&[x, z]| [x, y, z]);
    let sides = (0..n).flat_map(|i| {
        let k = (i + 1) % n;
        [[i, n + k, k], [i, n + i, n + k]]
    });
    let front = filling.iter().copied();
    let back = filling.iter().map(|&[a, b, c]| [n + a, n + c, n + b]);
    TriangleMesh {
        vertices_m: corner(0.0).chain(corner(depth)).collect(),
        triangles: front.chain(back).chain(sides).collect(),
    }
}

fn brick(size: Vec3, at: Vec3) -> TriangleMesh {
    let [x, z] = [size[0], size[2]];
    let mut mesh = extruded(&[[0.0, 0.0], [x, 0.0], [x, z], [0.0, z]], &[[0, 1, 2], [0, 2, 3]], size[1]);
    mesh.vertices_m.iter_mut().for_each(|v| *v = std::array::from_fn(|k| v[k] + at[k]));
    mesh
}

fn with(mut scene: SolverScene, name: &str, mesh: TriangleMesh) -> SolverScene {
    scene.assets.insert(name.into(), Arc::new(Asset::Mesh(mesh)));
    scene
}

#[test]
fn a_mesh_has_the_inertia_of_what_it_encloses_about_its_own_centre() {
    let size = [0.2, 0.3, 0.5];
    let mut only = body("brick", file(), 1.0, [1.0, 2.0, 3.0], STILL, [0.0, 0.0, 2.0]);
    only.mass_kg = None;
    let mut scene = with(scene(vec![only], 50, 0.01), "brick", brick(size, [0.0; 3]));
    scene.interfaces = vec![common::contact(0, "brick")];
    let mut solver = Rigid::default();
    let setup = solver.setup(&scene).unwrap();
    assert!(setup.left_out.is_empty(), "its hull is the mesh: {:?}", setup.left_out);
    let BoundaryState::Proxy(proxy) = &setup.boundaries[0].state else { panic!("not a proxy") };
    // 1000 kg/m³ of 0.03 m³; the frame's origin is a corner.
    let [x, y, z] = size.map(|s| s * s);
    let expected = [y + z, x + z, x + y].map(|s| 30.0 * s / 12.0);
    // The mesh's own sums lose three digits of sixteen.
    assert!((proxy.mass - 30.0).abs() < 1e-11);
    assert!(norm(sub(proxy.position, [1.1, 2.15, 3.25])) < 1e-12);
    let (diagonal, products) = proxy.inertia.split_at(3);
    assert!(diagonal.iter().zip(expected).all(|(found, i)| (found / i - 1.0).abs() < 1e-11), "{diagonal:?}");
    assert!(products.iter().all(|p| p.abs() < 1e-12), "{products:?}");
    let Some(VisualState::Pose { position, .. }) = solver.visual("brick") else { panic!("no picture") };
    assert!(norm(sub(position, [1.0, 2.0, 3.0])) < 1e-12, "{position:?}");
    // It turns about its centre, and its frame with it.
    let last = play(&scene, |_, _| {});
    assert!(norm(sub(last.bodies[0].position_m, [1.1, 2.15, 3.25])) < 1e-12);
}

#[test]
fn a_hollow_shape_falls_into_parts_and_stands_over_what_fits_into_it() {
    // A bridge: legs of 5 cm, a gap of 20 cm under a beam.
    let outline = [[0.0, 0.0], [0.05, 0.0], [0.05, 0.2], [0.25, 0.2], [0.25, 0.0], [0.3, 0.0], [0.3, 0.3], [0.0, 0.3]];
    let filling = [[0, 1, 2], [0, 2, 7], [2, 3, 6], [2, 6, 7], [3, 4, 5], [3, 5, 6]];
    let mesh = extruded(&outline, &filling, 0.1);
    assert_eq!(mesh.open_edges(), 0);
    let bridge = body("bridge", file(), 2.0, [0.0, 0.0, 0.002], STILL, STILL);
    let ball = body("ball", Source::Sphere { radius_m: 0.05 }, 1.0, [0.15, 0.05, 0.05], STILL, STILL);
    let mut scene = with(scene(vec![bridge, ball], 100, 0.01), "bridge", mesh);
    scene.actions = vec![gravity()];
    // The floor is a mesh too.
    scene.statics = vec![collider("floor", file(), STILL, [0.0, 0.0, 0.0, 1.0], rough(0.5))];
    scene.assets.insert("floor".into(), Arc::new(Asset::Mesh(brick([4.0, 4.0, 0.5], [-2.0, -2.0, -0.5]))));
    let setup = Rigid::default().setup(&scene).unwrap();
    println!("{:?}", setup.left_out);
    assert!(setup.left_out[0].why.contains("convex parts"));
    let first = start(&scene).1;
    let last = play(&scene, |_, _| {});
    let moved = |k: usize| norm(sub(last.bodies[k].position_m, first.bodies[k].position_m));
    println!("bridge moved {} m, ball {} m, {:?}", moved(0), moved(1), last.counters);
    // The bridge falls its 2 mm; the legs of the decomposition are up to a voxel, 1/64 of 0.3 m, off. A hull would have
    // thrown the ball out.
    assert!(moved(0) < 7e-3 && moved(1) < 2e-3, "{} {}", moved(0), moved(1));
    assert!(last.bodies.iter().all(|b| norm(b.linear_velocity_m_s) < 0.01 * G));
}

#[test]
fn meshes_that_enclose_nothing_are_refused_by_name() {
    let mut open = brick([0.1; 3], [0.0; 3]);
    open.triangles.pop();
    let only = || scene(vec![body("shard", file(), 1.0, STILL, STILL, STILL)], 1, 0.01);
    for (scene, why) in [(only(), "prepared"), (with(only(), "shard", open), "open")] {
        let Err(PluginError::Unsupported(found)) = Rigid::default().setup(&scene) else { panic!("accepted") };
        assert!(found.contains("shard") && found.contains(why), "{found}");
    }
}
