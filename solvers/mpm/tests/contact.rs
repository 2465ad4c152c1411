//! Where contact happens and how hard it is: floors between nodes, meshes, a sphere on an elastic layer.

use std::sync::Arc;

use crate::common::rock::{Rock, ball, brick, mesh_source, with_rock};
use crate::common::{Run, TO_MINUS_X, TO_MINUS_Y, TO_X, TO_Y, body, cuboid, elastic, gravity, moving, plane, scene};
use cosplat_core::asset::{Asset, TriangleMesh};
use cosplat_core::boundary::{dot, norm, scale, sub};
use cosplat_core::plugin::{Plugin, SolverScene};
use cosplat_core::scene::{Source, Wall};
use cosplat_mpm::Mpm;

const DX: f64 = 0.02;

/// Lowest place that the underside of a thrown cube reaches above the floor, in cells. The floor lies `offset` cells
/// above a node and has the normal `n`; the cube is aligned with it.
fn stops(offset: f64, turn: [f64; 4], n: [f64; 3], speed: f64) -> f64 {
    let floor = scale(n, offset * DX);
    let at = [0, 1, 2].map(|k| floor[k] + n[k] * (0.1 + 2.0 * DX));
    let mut cube = body("cube", elastic(1000.0, 1e6, 0.3), cuboid([0.2; 3]), at, DX / 2.0);
    cube.pose.orientation = turn;
    let mut start = scene(vec![moving(cube, scale(n, -speed), [0.0; 3])], 0.2 * DX / speed);
    start.statics = vec![plane("floor", floor, turn, Wall::Slip)];
    let mut run = Run::<f32>::new(start);
    let (mut lowest, mut back) = (f64::INFINITY, false);
    while !back && run.window < 100 {
        back = dot(run.step().report.bodies[0].linear_velocity_m_s, n) > 0.0;
        let height = |x: &[f64; 3]| dot(sub(*x, floor), n) / DX - 0.25;
        lowest = lowest.min(run.particles("cube").iter().map(height).fold(f64::INFINITY, f64::min));
    }
    assert!(back, "it turns round");
    lowest
}

#[test]
fn a_falling_cube_stops_at_the_floor_wherever_the_nodes_are() {
    // A turn of 25° about y.
    let turned = [0.0, 12.5_f64.to_radians().sin(), 0.0, 12.5_f64.to_radians().cos()];
    let leaning = [25.0_f64.to_radians().sin(), 0.0, 25.0_f64.to_radians().cos()];
    for (offset, turn, n) in [
        (0.0, crate::common::UPRIGHT, [0.0, 0.0, 1.0]),
        (0.3, crate::common::UPRIGHT, [0.0, 0.0, 1.0]),
        (0.7, crate::common::UPRIGHT, [0.0, 0.0, 1.0]),
        (0.4, turned, leaning),
    ] {
        for speed in [0.1, 1.0] {
            let gap = stops(offset, turn, n, speed);
            println!("floor {offset} cells above a node, {speed} m/s: underside at {gap} cells");
            // The middle of the lowest particle moves towards the floor by a quarter of a cell times the strain, which
            // is up to v / c = 1 / 37; impulses are settled to 1e-3 and an overlap is given back over twenty substeps.
            assert!(gap.abs() < 0.05, "{gap}");
        }
    }
}

/// Centre of mass of a cube in the end, below its start, on a smooth floor that lies `offset` cells above a node.
fn sinks(offset: f64) -> f64 {
    let floor = offset * DX;
    let cube = body("cube", elastic(1000.0, 2e5, 0.0), cuboid([0.12; 3]), [0.003, 0.001, floor + 0.06], DX / 2.0);
    let mut start = scene(vec![cube], 1e-3);
    start.statics = vec![plane("floor", [0.0, 0.0, floor], crate::common::UPRIGHT, Wall::Slip)];
    start.actions.push(gravity(-9.81));
    let mut run = Run::<f32>::new(start);
    let from = run.setup.report.bodies[0].position_m[2];
    // One period of the slowest longitudinal wave, 4 H/c: the mean of a swing about rest.
    let period = (4.0 * 0.12 / 200.0_f64.sqrt() / 1e-3).round() as u32;
    (0..4 * period).map(|_| from - run.step().report.bodies[0].position_m[2]).sum::<f64>() / f64::from(4 * period)
}

#[test]
fn a_cube_rests_on_the_floor_wherever_the_nodes_are() {
    // ∫ ρ g (H - z) / E: the mean over the height is ρ g H² / 3E.
    let exact = 1000.0 * 9.81 * 0.12 * 0.12 / (3.0 * 2e5);
    let found = [0.0, 0.3, 0.7].map(sinks);
    println!("centre sinks {found:?} m of {exact}");
    for sunk in found {
        // Six cells over the height, and a swing that is not quite a whole number of windows long.
        assert!((sunk / exact - 1.0).abs() < 0.03, "{sunk}");
        assert!((sunk / found[0] - 1.0).abs() < 0.03, "{found:?}");
    }
}

#[test]
fn a_sliding_cube_is_slowed_by_coulomb_friction_and_rest_costs_nothing() {
    let cube = body("cube", elastic(1000.0, 1e6, 0.3), cuboid([0.2, 0.2, 0.1]), [0.003, 0.001, 0.05], DX / 2.0);
    let mut start = scene(vec![moving(cube, [0.6, 0.8, 0.0], [0.0; 3])], 1e-3);
    let rough = Wall::Friction { static_friction: 0.3, kinetic_friction: 0.2 };
    start.statics = vec![plane("floor", [0.0; 3], crate::common::UPRIGHT, rough)];
    start.actions.push(gravity(-9.81));
    let mut run = Run::<f32>::new(start);
    for _ in 0..300 {
        run.step();
    }
    let report = run.step().report;
    let speed = norm(report.bodies[0].linear_velocity_m_s);
    let (exact, lost) = (1.0 - 0.2 * 9.81 * 0.301, 0.5 * 4.0 * (1.0 - speed * speed));
    println!("speed {speed} of {exact}, lost {} J of {lost}", report.energy.dissipated_j);
    // Gravity is switched on at once: the cube swings on the floor by 10 % of its weight while it slides.
    assert!((speed / exact - 1.0).abs() < 0.02, "{speed}");
    // Not booked is what the transfers take from the vibrations that sliding starts in the lowest cells.
    let share = report.energy.dissipated_j / lost;
    assert!((0.95..1.01).contains(&share), "{share}");
    for _ in 0..400 {
        run.step();
    }
    let still = run.step().report;
    for _ in 0..200 {
        run.step();
    }
    let end = run.step().report;
    println!("at rest {:?}, later {:?}", still.energy, end.energy);
    assert!(norm(end.bodies[0].linear_velocity_m_s) < 5e-3, "what is left of the swing");
    // 0.2 s of rest against the 2 J of the slide.
    assert!((end.energy.dissipated_j - still.energy.dissipated_j).abs() < 2e-3);
}

/// A ball of 0.5 kg dropped on a block on a floor: velocity after 80 ms and its lowest place.
fn dropped(prepare: impl FnOnce(&mut SolverScene)) -> ([f64; 3], f64) {
    let window = 1e-3;
    let block = body("block", elastic(300.0, 1e5, 0.3), cuboid([0.28, 0.28, 0.16]), [0.0, 0.0, 0.08], DX / 2.0);
    let mut start = scene(vec![block], window);
    start.statics = vec![plane("floor", [0.0; 3], crate::common::UPRIGHT, Wall::NoSlip)];
    prepare(&mut start);
    let mut rock = Rock::new(0.5, 0.4 * 0.5 * 0.0049, [0.02, 0.0, 0.24], [0.2, 0.0, -2.0], [0.0; 3]);
    let mut run = Run::<f32>::new(start);
    let mut lowest = f64::INFINITY;
    for _ in 0..80 {
        let out = run.step_with(&rock.inputs(window));
        rock.take(&out, window);
        lowest = lowest.min(rock.record.position[2]);
    }
    assert!(run.defect[0] < 1e-6 * run.gross && run.defect[1] < 1e-6 * run.gross, "{:?} of {}", run.defect, run.gross);
    (rock.record.linear_velocity, lowest)
}

#[test]
fn a_ball_of_triangles_is_a_ball() {
    let (exact, lowest) = dropped(|start| with_rock(start, "block", &Source::Sphere { radius_m: 0.07 }, 0.5));
    // Its frame lies beside its centre of mass, which is where the record is.
    let mesh = ball([0.3, -0.1, 0.2], 0.07, 4);
    let (found, low) = dropped(|start| {
        start.assets.insert("rock".into(), Arc::new(Asset::Mesh(mesh)));
        with_rock(start, "block", &mesh_source(), 0.5);
    });
    println!("velocity {exact:?} {found:?}, lowest {lowest} {low}");
    // 2048 triangles lie up to edge²/8R = 0.1 mm inside the sphere: 0.5 % of the way that it is pressed in, and the
    // velocity after a bounce, which repeats that error in force and time.
    assert!((low - lowest).abs() < 2e-4, "{low} {lowest}");
    assert!(norm(sub(exact, found)) < 0.03 * norm(exact), "{found:?} {exact:?}");
}

/// A cube thrown on a table: height of its centre and velocity after 40 ms.
fn on_table(prepare: impl FnOnce(&mut SolverScene)) -> [f64; 2] {
    let cube = body("cube", elastic(500.0, 2e5, 0.3), cuboid([0.12; 3]), [0.01, 0.0, 0.15], DX / 2.0);
    let mut start = scene(vec![moving(cube, [0.0, 0.0, -2.0], [0.0; 3])], 1e-3);
    let rough = Wall::Friction { static_friction: 0.5, kinetic_friction: 0.5 };
    start.statics = vec![plane("table", [0.0; 3], crate::common::UPRIGHT, rough)];
    prepare(&mut start);
    let mut run = Run::<f32>::new(start);
    for _ in 0..39 {
        run.step();
    }
    let state = run.step().report.bodies[0];
    [state.position_m[2], state.linear_velocity_m_s[2]]
}

#[test]
fn a_table_of_triangles_is_a_table() {
    let size = [0.3, 0.4, 0.1];
    let exact = on_table(|start| {
        start.statics[0].source = cuboid(size);
        start.statics[0].pose.position_m = [0.0, 0.0, 0.02];
    });
    let found = on_table(|start| {
        start.statics[0].source = mesh_source();
        start.assets.insert("table".into(), Arc::new(Asset::Mesh(brick([0.0, 0.0, 0.02], size))));
    });
    println!("{exact:?} {found:?}");
    // The cache holds a face exactly, to single precision; the impulses that turn 3.4 m/s round are settled to 1e-3, and
    // the cube flies on for 20 ms.
    assert!((exact[0] - found[0]).abs() < 7e-5 && (exact[1] - found[1]).abs() < 3.4e-3, "{exact:?} {found:?}");
    assert!(exact[1] > 0.5, "it bounced: {exact:?}");
}

fn refusal(asset: Option<TriangleMesh>) -> String {
    let block = body("block", elastic(300.0, 1e5, 0.3), cuboid([0.2; 3]), [0.0; 3], DX);
    let mut start = scene(vec![block], 1e-3);
    start.assets.extend(asset.map(|mesh| ("rock".into(), Arc::new(Asset::Mesh(mesh)))));
    with_rock(&mut start, "block", &mesh_source(), 0.5);
    Mpm::<f32>::default().setup(&start).expect_err("no solid").to_string()
}

#[test]
fn what_is_no_solid_is_refused_with_advice() {
    let mut open = brick([0.0; 3], [0.1; 3]);
    open.triangles.pop();
    let why = refusal(Some(open.clone()));
    assert!(why.contains("`rock`") && why.contains("the mesh is open: 3") && why.contains("close its holes"), "{why}");
    open.triangles.push([0, 1, 99]);
    assert!(refusal(Some(open)).contains("names vertex 99"), "an index without a vertex");
    let why = refusal(None);
    assert!(why.contains("`rock`") && why.contains("closed triangle meshes"), "no asset: {why}");
}

/// Case C10 in a quarter: a sphere of 0.2 m and 83.776 kg at 0.2 m/s on an elastic layer. Deepest place \[m\] and time of
/// contact \[s\].
fn press(dx: f64) -> [f64; 2] {
    let (half, height, window) = (0.36, 0.6, 1e-3);
    let layer = body(
        "layer",
        elastic(1000.0, 1e6, 0.3),
        cuboid([half, half, height]),
        [0.5 * half, 0.5 * half, -0.3],
        dx / 2.0,
    );
    let mut start = scene(vec![layer], window);
    start.threads = 2;
    start.statics = vec![
        plane("foot", [0.0, 0.0, -height], crate::common::UPRIGHT, Wall::NoSlip),
        plane("left", [0.0; 3], TO_X, Wall::Slip),
        plane("front", [0.0; 3], TO_Y, Wall::Slip),
        plane("right", [half, 0.0, 0.0], TO_MINUS_X, Wall::Slip),
        plane("back", [0.0, half, 0.0], TO_MINUS_Y, Wall::Slip),
    ];
    with_rock(&mut start, "layer", &Source::Sphere { radius_m: 0.2 }, 0.0);
    let mut rock = Rock::new(83.776 / 4.0, 1e6, [0.0, 0.0, 0.2], [0.0, 0.0, -0.2], [0.0; 3]);
    let mut run = Run::<f32>::new(start);
    let (mut deepest, mut met, mut left) = (0.0_f64, None, 0.0);
    while run.window < 160 {
        let before = rock.record.linear_velocity[2];
        let out = run.step_with(&rock.inputs(window));
        rock.take(&out, window);
        // The symmetry of the whole sphere.
        let r = &mut rock.record;
        (r.linear_velocity, r.position) = ([0.0, 0.0, r.linear_velocity[2]], [0.0, 0.0, r.position[2]]);
        deepest = deepest.max(0.2 - r.position[2]);
        if (r.linear_velocity[2] - before).abs() > 1e-6 {
            met.get_or_insert(run.window);
            left = run.window as f64 * window;
        }
    }
    println!("dx {dx}: depth {deepest}, contact until {left}, left with {}", rock.record.linear_velocity[2]);
    [deepest, left]
}

#[test]
fn a_sphere_is_pressed_in_as_hertz_says() {
    let [depth, time] = press(0.03);
    // Table D18 with the correction for a layer of finite thickness: 8.193 mm, 0.1202 s. The catalogue asks for 8 % and
    // 5 % at 10 mm; here the circle of contact has a radius of 41 mm, little more than one cell.
    assert!((depth / 8.193e-3 - 1.0).abs() < 0.08 && (time / 0.1202 - 1.0).abs() < 0.05, "{depth} {time}");
}
