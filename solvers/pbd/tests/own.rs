//! Cloth against itself and against other cloth.

mod common;

use std::sync::Arc;

use common::{Run, cloth, floor};
use cosplat_conformance::parts;
use cosplat_core::asset::{Asset, TriangleMesh};
use cosplat_core::boundary::{add, cross, dot, norm, scale, sub};
use cosplat_core::plugin::SolverScene;
use cosplat_core::scene::{Body, Source, Wall};

type Triangles = Vec<[usize; 3]>;

const ROUGH: Wall = Wall::Friction { static_friction: 0.3, kinetic_friction: 0.2 };

/// A flat mesh of `n` by `m` squares of a size, its points moved by `place`.
fn mesh([n, m]: [usize; 2], size: f64, place: impl Fn(f64, f64) -> [f64; 3]) -> (TriangleMesh, Triangles) {
    let corners = |i: usize, j: usize| [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| j * (n + 1) + i);
    let halves = |(i, j): (usize, usize)| match corners(i, j) {
        [a, b, c, d] if (i + j) % 2 == 0 => [[a, b, c], [a, c, d]],
        [a, b, c, d] => [[a, b, d], [b, c, d]],
    };
    let triangles: Triangles = (0..m).flat_map(|j| (0..n).map(move |i| (i, j))).flat_map(halves).collect();
    let at = |i: usize, half: usize| size * (i as f64 - 0.5 * half as f64);
    let vertices_m =
        (0..=m).flat_map(|j| (0..=n).map(move |i| (i, j))).map(|(i, j)| place(at(i, n), at(j, m))).collect();
    let numbers = triangles.iter().map(|t| t.map(|i| i as u32)).collect();
    (TriangleMesh { vertices_m, triangles: numbers }, triangles)
}

fn body(name: &str, mesh: &TriangleMesh, scene: &mut SolverScene) -> Body {
    scene.assets.insert(name.into(), Arc::new(Asset::Mesh(mesh.clone())));
    let source = Source::Mesh { file: "sheet.obj".into(), metres_per_unit: 1.0, up: "+z".into() };
    parts::body(name, cloth(1e-5, 1e5), source, [0.0; 3])
}

/// Edges that pierce triangles they do not belong to.
fn pierced(v: &[[f64; 3]], triangles: &Triangles) -> usize {
    let side = |a: usize, b: usize, c: usize, p: usize| dot(cross(sub(v[b], v[a]), sub(v[c], v[a])), sub(v[p], v[a]));
    let mut edges: Vec<[usize; 2]> =
        triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).map(|[a, b]| [a.min(b), a.max(b)]).collect();
    edges.sort_unstable();
    edges.dedup();
    let crosses = |t: &[usize; 3], e: &[usize; 2]| {
        let [a, b, c] = *t;
        let ends = e.map(|p| side(a, b, c, p));
        // Both ends off the plane, by more than rounding in a flat sheet: 0.1 µm times twice an area of 2 cm².
        let off = ends[0] * ends[1] < 0.0 && ends.iter().all(|s| s.abs() > 4e-11);
        if t.iter().any(|i| e.contains(i)) || !off {
            return false;
        }
        let turns = [side(e[0], e[1], a, b), side(e[0], e[1], b, c), side(e[0], e[1], c, a)];
        turns.iter().all(|s| *s > 0.0) || turns.iter().all(|s| *s < 0.0)
    };
    triangles.iter().map(|t| edges.iter().filter(|e| crosses(t, e)).count()).sum()
}

/// Least distance of a vertex from the triangles that it is not next to at rest, seen from 45 points of each \[m\].
fn nearest(v: &[[f64; 3]], rest: &[[f64; 3]], triangles: &Triangles, ignored: f64) -> f64 {
    let at = |x: &[[f64; 3]], t: &[usize; 3], a: f64, b: f64| {
        add(add(scale(x[t[0]], 1.0 - a - b), scale(x[t[1]], a)), scale(x[t[2]], b))
    };
    let mut least = f64::INFINITY;
    for t in triangles {
        for (i, j) in (0..=8).flat_map(|i| (0..=8 - i).map(move |j| (i, j))) {
            let [a, b] = [i, j].map(|k: i32| f64::from(k) / 8.0);
            let (now, then) = (at(v, t, a, b), at(rest, t, a, b));
            for (x, r) in v.iter().zip(rest) {
                if norm(sub(*r, then)) > ignored {
                    least = least.min(norm(sub(*x, now)));
                }
            }
        }
    }
    least
}

#[test]
fn a_folded_sheet_rests_on_itself_a_thickness_apart() {
    // A sheet of 40 cm, folded about its middle with a bow of 2 cm radius, falls flat.
    let fold = |x: f64, y: f64| {
        let bow = std::f64::consts::PI * 0.02;
        let angle = (x / (0.5 * bow)).clamp(-1.0, 1.0) * std::f64::consts::FRAC_PI_2;
        let straight = (x.abs() - 0.5 * bow).max(0.0);
        [0.02 * angle.cos() - straight, y, 0.0225 + 0.02 * angle.sin()]
    };
    let (flat, triangles) = mesh([20, 6], 0.02, fold);
    let mut scene = parts::solver_scene("pbd", Vec::new(), 150, 0.005);
    scene.bodies = vec![body("sheet", &flat, &mut scene)];
    scene.statics = vec![floor(ROUGH)];
    scene.actions = vec![parts::gravity()];
    scene.params.insert("thickness_m".into(), 0.004.into());
    scene.params.insert("damping_1_s".into(), 2.0.into());
    let mut run = Run::new(scene);
    (0..150).for_each(|_| drop(run.step()));
    let v = run.vertices("sheet");
    let rest = mesh([20, 6], 0.02, |x, y| [x, y, 0.0]).0.vertices_m;
    let apart = nearest(&v, &rest, &triangles, 0.03);
    let above = (0..7).all(|j| v[j * 21 + 20][2] > v[j * 21][2]);
    println!("{apart} m apart, above {above}, pierced {}", pierced(&v, &triangles));
    assert!(above && pierced(&v, &triangles) == 0);
    // What the weight above does to eight turns of contact in a substep: g h² = 0.6 µm a layer, and the tenth of an
    // overlap that is given back.
    assert!(apart > 0.004 * 0.99, "{apart}");
    assert!(run.defect[0] < 1e-12 * run.gross && run.defect[1] < 1e-12 * run.gross, "{:?}", run.defect);
}

#[test]
fn a_crumpled_sheet_does_not_pass_through_itself() {
    // Edge first onto a rough floor at 3 m/s, a little bent.
    let (bent, triangles) =
        mesh([20, 20], 0.02, |x, y| [x, 0.01 * (9.0 * x).sin() + 0.02 * (11.0 * y).cos(), y + 0.202]);
    let mut scene = parts::solver_scene("pbd", Vec::new(), 120, 0.005);
    scene.bodies = vec![body("sheet", &bent, &mut scene)];
    scene.bodies[0].velocity = parts::twist([0.0, 0.0, -3.0], [0.0, 0.0, 1.0]);
    scene.statics = vec![floor(ROUGH)];
    scene.actions = vec![parts::gravity()];
    scene.params.insert("thickness_m".into(), 0.004.into());
    let mut run = Run::new(scene);
    let start = run.setup.report.energy;
    let (mut most, mut contacts, mut gained) = (0, 0, f64::NEG_INFINITY);
    for i in 0..120 {
        let report = run.step().report;
        contacts += report.counters["contacts"];
        gained = gained.max(report.energy.kinetic_j + report.energy.potential_j);
        if i % 10 == 9 {
            most = most.max(pierced(&run.vertices("sheet"), &triangles));
        }
    }
    println!("{most} pierced, {contacts} contacts");
    assert!(most == 0 && contacts > 0, "{most}");
    // Contact gives back a tenth of an overlap in a substep at 0.5 m/s at most: little beside 3 m/s.
    assert!(gained < 1.02 * (start.kinetic_j + start.potential_j), "{gained} {start:?}");
    assert!(run.defect[0] < 1e-12 * run.gross && run.defect[1] < 1e-12 * run.gross, "{:?}", run.defect);
}

#[test]
fn a_sheet_thrown_at_another_at_20_m_s_does_not_pass() {
    let (target, mut triangles) = mesh([12, 12], 0.02, |x, y| [x, y, 0.0]);
    let (thrown, others) = mesh([6, 6], 0.02, |x, y| [x + 0.003, y + 0.007, 0.05 + 0.2 * x]);
    triangles.extend(others.iter().map(|t| t.map(|i| i + target.vertices_m.len())));
    let mut scene = parts::solver_scene("pbd", Vec::new(), 20, 0.001);
    scene.bodies = vec![body("target", &target, &mut scene), body("thrown", &thrown, &mut scene)];
    scene.bodies[1].velocity = parts::twist([0.0, 0.0, -20.0], [0.0; 3]);
    let mut run = Run::new(scene);
    let before = run.momentum;
    let middle = |run: &Run, name: &str| {
        let v = run.vertices(name);
        v.iter().map(|x| x[2]).sum::<f64>() / v.len() as f64
    };
    for _ in 0..20 {
        run.step();
        let all = [run.vertices("target"), run.vertices("thrown")].concat();
        assert_eq!(pierced(&all, &triangles), 0, "window {}", run.window);
    }
    // Free to fly both, they go on together; the thrown one stays behind.
    let [below, above] = ["target", "thrown"].map(|name| middle(&run, name));
    println!("{below} {above}");
    assert!(below < -0.01 && above > below - 0.1, "{below} {above}");
    let after = run.momentum;
    // Roundings of 3 g at 20 m/s.
    assert!(norm(sub(after.linear, before.linear)) < 1e-14 && norm(sub(after.angular, before.angular)) < 1e-14);
}
