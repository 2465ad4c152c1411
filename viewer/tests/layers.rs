//! What is known of a pixel beside its colour: depth, normal, object and flow of scenes that are known.

use cosplat_viewer::{Camera, Layers, NO_OBJECT, Next, Options, View, render, render_layers};
use nalgebra::{Quaternion, Rotation3, UnitQuaternion, Vector3};

mod common;

use common::{Set, camera, crowd};

type Map = fn(Vector3<f64>) -> Vector3<f64>;

fn moved(set: &Set, by: impl Fn(Vector3<f64>) -> Vector3<f64>) -> Vec<[f32; 3]> {
    let map = |p: &[f32; 3]| by(Vector3::from(p.map(f64::from))).map(|v| v as f32).into();
    set.positions.iter().map(map).collect()
}

/// Where a point is in the picture, after the definition of [`View`].
fn seen(view: &View, point: Vector3<f64>) -> [f64; 2] {
    let t = view.rows.map(|r| Vector3::from(r).dot(&(point - Vector3::from(view.eye))));
    [view.focal * t[0] / t[2] + view.width as f64 / 2.0, view.focal * t[1] / t[2] + view.height as f64 / 2.0]
}

fn layers(sets: &[&Set], view: &View, next: Option<&Next<'_>>) -> Layers {
    let sets: Vec<_> = sets.iter().map(|s| s.view()).collect();
    render_layers(&sets, view, &Options::default(), next).expect("every Gaussian has a next place")
}

/// A turn by one degree and a small step.
fn rigid(p: Vector3<f64>) -> Vector3<f64> {
    let centre = Vector3::new(0.1, -0.1, 2.2);
    Rotation3::from_euler_angles(0.01, 0.008, 0.012) * (p - centre) + centre + Vector3::new(0.013, -0.02, 0.03)
}

/// A moving camera, too.
fn later(view: &View) -> View {
    let camera = Camera {
        eye: [0.02, 0.01, -0.01],
        target: [0.03, 0.0, 1.0],
        up: [0.01, -1.0, 0.0],
        fov_y_deg: 2.0 * (0.5 * view.height as f64 / view.focal).atan().to_degrees(),
        width: view.width,
        height: view.height,
    };
    camera.view().expect("the camera sees")
}

/// Single Gaussians, far from each other: the flow is the difference of their projected means, at every pixel they touch.
/// Both means are rounded to nothing before they are subtracted; what is left is the rounding of a sum of one weight.
#[test]
fn the_flow_of_one_gaussian_is_the_motion_of_its_mean() {
    let view = camera(200, 140);
    for map in [rigid as Map, |p| p + Vector3::new(0.05, 0.0, 0.0), |p| p * 1.1] {
        for (x, y, z) in [(0.0, 0.0, 1.5), (0.6, -0.4, 2.0), (-0.9, 0.5, 2.5)] {
            let mut set = Set::default();
            set.push([x, y, z], [0.04; 3], 0.8, [0.5; 3]);
            for next_view in [view, later(&view)] {
                let positions = moved(&set, map);
                let next = Next { positions: vec![&positions], view: next_view };
                let layers = layers(&[&set], &view, Some(&next));
                let now = seen(&view, Vector3::from(set.positions[0].map(f64::from)));
                let then = seen(&next_view, Vector3::from(positions[0].map(f64::from)));
                let mut touched = 0;
                for (flow, rgba) in layers.flow.iter().zip(&layers.picture.rgba) {
                    assert_eq!(flow[0].is_nan(), rgba[3] == 0.0);
                    if !flow[0].is_nan() {
                        touched += 1;
                        let error = [0, 1].map(|k| (f64::from(flow[k]) - (then[k] - now[k])).abs());
                        assert!(error[0].max(error[1]) < 1e-4, "{error:?}");
                    }
                }
                assert!(touched > 20, "{touched}");
            }
        }
    }
}

/// A dense sheet that moves rigidly under a moving camera, against the motion of the very point that each pixel sees.
/// A pixel blends means up to 2 pixels away, and the flow changes by the strain of the picture, some 2 % of a pixel a
/// pixel; blending front to back is not quite symmetric, so that a part of that is left: less than 0.05 pixels.
#[test]
fn the_flow_of_a_rigid_motion_is_that_of_the_points() {
    let view = camera(200, 140);
    let mut set = Set::default();
    // A plane through (0, 0, 2), tilted: z = 2 + 0.3 x − 0.2 y.
    for i in -90..=90 {
        for j in -70..=70 {
            let (x, y) = (f64::from(i) * 0.02, f64::from(j) * 0.02);
            set.push([x, y, 2.0 + 0.3 * x - 0.2 * y].map(|v| v as f32), [0.012; 3], 0.95, [0.5; 3]);
        }
    }
    let positions = moved(&set, rigid);
    let next = Next { positions: vec![&positions], view: later(&view) };
    let layers = layers(&[&set], &view, Some(&next));
    let (mut errors, mut largest) = (Vec::new(), 0.0_f64);
    for (at, flow) in layers.flow.iter().enumerate() {
        let (px, py) = ((at % view.width) as f64 + 0.5, (at / view.width) as f64 + 0.5);
        // From the origin along +z with y down, so that the ray of a pixel is its place over the focal length.
        let ray = Vector3::new((px - 100.0) / view.focal, (py - 70.0) / view.focal, 1.0);
        let point = ray * (2.0 / (1.0 - 0.3 * ray.x + 0.2 * ray.y));
        if point.x.abs() > 1.7 || point.y.abs() > 1.3 {
            continue;
        }
        let then = seen(&next.view, rigid(point));
        let error = (f64::from(flow[0]) - (then[0] - px)).hypot(f64::from(flow[1]) - (then[1] - py));
        largest = largest.max((then[0] - px).hypot(then[1] - py));
        errors.push(error);
    }
    errors.sort_by(f64::total_cmp);
    let [median, worst] = [errors[errors.len() / 2], errors[errors.len() - 1]];
    println!(
        "flow up to {largest:.2} px over {} pixels: median error {median:.4} px, worst {worst:.4} px",
        errors.len()
    );
    assert!(errors.len() > 10_000 && largest > 2.0);
    assert!(worst <= 0.05, "{worst}");
}

/// What hides moves apart from what is hidden, and each pixel knows which it sees.
#[test]
fn an_occluder_has_its_own_flow_object_and_depth() {
    let (mut front, mut back) = (Set::default(), Set::default());
    front.push([0.0, 0.0, 1.0], [0.08, 0.08, 0.001], 0.99, [1.0, 0.0, 0.0]);
    for i in -20..=20 {
        for j in -20..=20 {
            back.push([i as f32 * 0.05, j as f32 * 0.05, 2.0], [0.03, 0.03, 0.001], 0.99, [0.0, 0.0, 1.0]);
        }
    }
    let view = camera(101, 101);
    let front_moved = moved(&front, |p| p + Vector3::new(0.03, 0.0, 0.0));
    let back_moved = moved(&back, |p| p - Vector3::new(0.0, 0.04, 0.0));
    let next = Next { positions: vec![&back_moved, &front_moved], view };
    let layers = layers(&[&back, &front], &view, Some(&next));
    let at = |x: usize, y: usize| y * 101 + x;
    let near = |a: f32, b: f32| (a - b).abs() < 0.05;
    let [middle, side] = [at(50, 50), at(85, 50)];
    // 100 · 0.03 / 1 to the right in front, 100 · 0.04 / 2 up behind; 1 % of what is behind shines through.
    let [u, v] = layers.flow[middle];
    assert!(near(u, 3.0) && near(v, 0.0) && layers.object[middle] == 1, "{u} {v}");
    assert!((layers.picture.depth[middle] - 1.0).abs() < 0.02);
    let [u, v] = layers.flow[side];
    assert!(near(u, 0.0) && near(v, -2.0) && layers.object[side] == 0, "{u} {v}");
    assert!((layers.picture.depth[side] - 2.0).abs() < 1e-3);
    let still = self::layers(&[&front], &view, None);
    assert!(still.flow.is_empty() && still.object[at(5, 5)] == NO_OBJECT);
    assert_eq!(still.normal[at(5, 5)].map(f32::to_bits), [0; 3]);
}

/// What is behind the next camera has no flow; what is beside it has.
#[test]
fn what_the_next_camera_cannot_see_has_no_flow() {
    let mut set = Set::default();
    set.push([-0.3, 0.0, 1.0], [0.05; 3], 0.9, [1.0; 3]);
    set.push([0.3, 0.0, 3.0], [0.05; 3], 0.9, [1.0; 3]);
    let view = camera(101, 81);
    let forward = View { eye: [0.0, 0.0, 2.0], ..view };
    let next = Next { positions: vec![&set.positions], view: forward };
    let layers = layers(&[&set], &view, Some(&next));
    let [left, right] = [20, 60].map(|x| layers.flow[40 * 101 + x]);
    assert!(left[0].is_nan() && (right[0] - 20.0).abs() < 1e-3, "{left:?} {right:?}");
}

/// A disc shows its face, turned to the camera.
#[test]
fn a_normal_is_the_shortest_axis_on_the_side_of_the_camera() {
    let view = camera(61, 61);
    for (tilt, flip) in [(0.0, 0.0), (0.5, 0.0), (-0.8, 3.0)] {
        let mut set = Set::default();
        set.push([0.0, 0.0, 2.0], [0.2, 0.2, 0.01], 0.9, [1.0; 3]);
        let turn =
            UnitQuaternion::from_euler_angles(tilt, 0.0, 0.0) * UnitQuaternion::from_euler_angles(0.0, flip, 0.0);
        let Quaternion { coords } = *turn.quaternion();
        set.rotations[0] = [coords.w, coords.x, coords.y, coords.z].map(|v| v as f32);
        let exact = turn * Vector3::z();
        let exact = if exact.z > 0.0 { -exact } else { exact };
        let got = layers(&[&set], &view, None).normal[30 * 61 + 30];
        let error = (Vector3::from(got.map(f64::from)) - exact).norm();
        // Rounding of a quaternion in single precision.
        assert!(error < 1e-6, "{got:?} {exact:?}");
    }
}

/// By-products change no colour, and threads change nothing.
#[test]
fn layers_have_the_picture_and_the_same_bytes_on_any_number_of_threads() {
    let (first, second) = (crowd(2000, 3), crowd(1000, 4));
    let view = camera(150, 90);
    let (a, b) = (moved(&first, rigid), moved(&second, rigid));
    let next = Next { positions: vec![&a, &b], view: later(&view) };
    let draw = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| layers(&[&first, &second], &view, Some(&next)))
    };
    let bits = |l: &Layers| -> Vec<u32> {
        let floats = l.picture.rgba.iter().flatten().chain(&l.picture.depth).chain(l.normal.iter().flatten());
        floats.chain(l.flow.iter().flatten()).map(|v| v.to_bits()).chain(l.object.iter().copied()).collect()
    };
    let one = draw(1);
    assert!([2, 5].into_iter().all(|threads| bits(&draw(threads)) == bits(&one)));
    let options = Options { depth: true, ..Options::default() };
    assert_eq!(render(&[first.view(), second.view()], &view, &options), one.picture);
}

#[test]
fn another_number_of_gaussians_is_refused() {
    let set = crowd(3, 1);
    let view = camera(20, 20);
    for positions in [vec![], vec![&set.positions[..2]], vec![&set.positions[..], &set.positions[..]]] {
        let next = Next { positions, view };
        let error = render_layers(&[set.view()], &view, &Options::default(), Some(&next)).unwrap_err();
        assert!(error.to_string().contains("next positions"), "{error}");
    }
}
