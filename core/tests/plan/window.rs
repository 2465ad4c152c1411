//! The coupling window: the largest that every interface bears, the term that binds it, and when there is none.

use cosplat_core::plan::window::{SHORTEST_WINDOW_S, bond_term, contact_terms};
use cosplat_core::scene::{Body, Material, Motion, Scene, SolverSpec, VelocityField};

use crate::cast::{CLOTH, LIQUID, RIGID, SMOKE, body, elastic, joined, planned, refused, scene};

fn spaced(name: &str, solver: &str, material: Material, spacing_m: f64) -> Body {
    Body { spacing_m: Some(spacing_m), ..body(name, solver, material) }
}

fn moving(mut body: Body, linear_m_s: [f64; 3]) -> Body {
    body.velocity = VelocityField::Twist { linear_m_s, angular_rad_s: [0.0; 3] };
    body
}

/// Windows of all terms of a contact \[s\].
fn terms(resolver: &Body, responder: &Body) -> Vec<f64> {
    contact_terms("a~b", resolver, responder).iter().map(|t| t.seconds).collect()
}

/// Equal but for a few roundings: each formula has fewer than ten operations.
fn close(found: &[f64], wanted: &[f64]) -> bool {
    found.len() == wanted.len() && found.iter().zip(wanted).all(|(f, w)| (f - w).abs() <= 10.0 * f64::EPSILON * w)
}

fn check(found: &[f64], wanted: &[f64]) {
    assert!(close(found, wanted), "{found:?} instead of {wanted:?}");
}

#[test]
fn bodies_approach_by_less_than_a_third_of_the_coarser_spacing() {
    let mud = moving(spaced("mud", "sph", LIQUID, 0.01), [3.0, 0.0, 0.0]);
    let rock = moving(spaced("rock", "rigid", RIGID, 0.04), [0.0, -4.0, 0.0]);
    check(&terms(&mud, &rock), &[0.3 * 0.04 / 5.0]);
    let rock = moving(body("rock", "rigid", RIGID), [0.0, -4.0, 0.0]);
    check(&terms(&mud, &rock), &[0.3 * 0.01 / 5.0]);
    assert!(terms(&body("mud", "sph", LIQUID), &rock).is_empty(), "without a spacing nothing is known");
    assert!(terms(&mud, &moving(body("rock", "rigid", RIGID), [3.0, 0.0, 0.0])).is_empty(), "they do not approach");
}

#[test]
fn the_velocity_of_a_body_is_that_of_its_centre() {
    let mud = spaced("mud", "sph", LIQUID, 0.01);
    let mut rock = body("rock", "rigid", RIGID);
    rock.pose.position_m = [2.0, 0.0, 0.0];
    rock.velocity = VelocityField::Rotation { angular_rad_s: [0.0, 0.0, 3.0], about_m: [1.0, 0.0, 0.0] };
    check(&terms(&mud, &rock), &[0.3 * 0.01 / 3.0]);
    rock.velocity = VelocityField::LinearMap {
        linear_m_s: [0.0, 0.0, 4.0],
        gradient_1_s: [[3.0, 0.0, 0.0], [0.0; 3], [0.0; 3]],
        about_m: [1.0, 0.0, 0.0],
    };
    check(&terms(&mud, &rock), &[0.3 * 0.01 / 5.0]);
}

#[test]
fn a_prescribed_motion_counts_as_the_velocity() {
    let mud = spaced("mud", "sph", LIQUID, 0.01);
    let mut paddle = body("paddle", "rigid", RIGID);
    paddle.prescribed = Some(Motion::Twist { linear_m_s: [0.0, 2.0, 0.0], angular_rad_s: [0.0; 3] });
    check(&terms(&mud, &paddle), &[0.3 * 0.01 / 2.0]);
    paddle.prescribed = Some(Motion::Oscillation { amplitude_m: [0.03, 0.0, 0.04], frequency_hz: 2.0 });
    check(&terms(&moving(mud, [1.0, 0.0, 0.0]), &paddle), &[0.3 * 0.01 / (1.0 + std::f64::consts::TAU * 2.0 * 0.05)]);
}

#[test]
fn the_elastic_wave_of_a_soft_responder_crosses_one_and_a_half_spacings() {
    // Without lateral contraction the wave speed is √(E/ρ): 10 m/s.
    let toy = spaced("toy", "mpm", elastic(1e5), 0.02);
    check(&terms(&spaced("silk", "pbd", CLOTH, 0.01), &toy), &[1.4 * 0.02 / 10.0]);
    // 50 m/s is still soft.
    let edge = spaced("toy", "mpm", elastic(2.5e6), 0.02);
    check(&terms(&spaced("silk", "pbd", CLOTH, 0.01), &edge), &[1.4 * 0.02 / 50.0]);
}

#[test]
fn a_stiff_responder_bounds_the_window_at_a_millisecond_whatever_the_spacing() {
    let stiff = |spacing_m| Body { spacing_m, ..body("toy", "mpm", elastic(1e7)) };
    for spacing_m in [None, Some(0.001), Some(1.0)] {
        check(&terms(&body("silk", "pbd", CLOTH), &stiff(spacing_m)), &[1e-3]);
    }
}

/// Silk and a toy, touching.
fn silk_and_toy(bonds: Option<&str>) -> Scene {
    let silk = spaced("silk", "pbd", CLOTH, 0.01);
    let mut scene = scene([silk, spaced("toy", "mpm", elastic(1e5), 0.02)]);
    scene.clock.window_s = None;
    if let Some(to) = bonds {
        let params = serde_json::json!({ "bonds": { "silk": [{ "to": to, "at": [[0.0, 0.0, 0.0]] }] } });
        let params = params.as_object().expect("an object").clone();
        scene.solvers.insert("pbd".into(), SolverSpec { plugin: None, command: None, params });
    }
    scene
}

#[test]
fn cloth_that_is_attached_to_a_soft_body_swings_with_it() {
    let scene = silk_and_toy(Some("toy"));
    let term = |holder: usize, held: usize, scene: &Scene| {
        bond_term(scene, "silk~toy", &scene.bodies[holder], &scene.bodies[held])
    };
    // 0.2 kg/m² of 1 cm by 1 cm on a spring of 1e5 Pa times 2 cm: ω = 1e4 1/s.
    let found = term(0, 1, &scene).expect("a bond");
    check(&[found.seconds], &[0.2 / 1e4]);
    assert!(term(1, 0, &scene).is_none(), "the toy holds nothing");
    assert!(term(0, 1, &silk_and_toy(Some("floor"))).is_none() && term(0, 1, &silk_and_toy(None)).is_none());
    let mut rigid = scene.clone();
    rigid.bodies[1].material = RIGID;
    assert!(term(0, 1, &rigid).is_none(), "a rigid body moves in the steps of the cloth");
    // The plan takes it where it is the shortest, and names it.
    let plan = planned(&scene);
    assert!(
        plan.window_bound_by.starts_with("`silk~toy`: a fifth of 1/ω of bonds to `toy`"),
        "{}",
        plan.window_bound_by
    );
    assert!(plan.clock.window_s() <= 0.2 / 1e4 * (1.0 + 1e-9));
    let free = planned(&silk_and_toy(None));
    assert!(free.window_bound_by.starts_with("`silk~toy`: 1.4 spacings"), "{}", free.window_bound_by);
}

#[test]
fn a_liquid_is_bounded_by_the_surface_layer_of_what_deforms() {
    let mud = spaced("mud", "sph", LIQUID, 0.02);
    // ρ c² = 7 · 6e4 Pa; a layer of 1000 kg/m³ and of the toy's own spacing, 0.01 m.
    let rho_c2: f64 = 7.0 * 6e4;
    let toy = spaced("toy", "mpm", elastic(1e7), 0.01);
    check(&terms(&mud, &toy), &[0.75 * (1000.0 * 0.01 * 0.02 / rho_c2).sqrt()]);
    check(&terms(&mud, &body("silk", "pbd", CLOTH)), &[0.75 * (0.2 * 0.02 / rho_c2).sqrt()]);
    assert!(terms(&mud, &body("rock", "rigid", RIGID)).is_empty(), "a rigid body is a proxy inside the liquid's steps");
}

#[test]
fn nothing_that_is_told_how_to_move_bounds_the_exchange() {
    let mut toy = spaced("toy", "mpm", elastic(1e7), 0.01);
    toy.prescribed = Some(Motion::Twist { linear_m_s: [0.0; 3], angular_rad_s: [0.0; 3] });
    assert!(terms(&spaced("mud", "sph", LIQUID, 0.02), &toy).is_empty());
}

fn approaching(speed_m_s: f64) -> Scene {
    let mud = moving(spaced("mud", "sph", LIQUID, 0.01), [speed_m_s, 0.0, 0.0]);
    let mut scene = scene([mud, body("rock", "rigid", RIGID)]);
    scene.clock.window_s = None;
    scene
}

#[test]
fn the_smallest_term_binds_and_is_named() {
    let mut scene = approaching(1.0);
    let plan = planned(&scene);
    // 0.003 s do not divide a second: the next shorter window that does.
    assert_eq!(plan.clock.windows, 334);
    assert!(plan.window_bound_by.starts_with("`mud~rock`: 0.3 of the spacing 0.01 m"), "{}", plan.window_bound_by);
    scene.clock.window_s = Some(0.002);
    let plan = planned(&scene);
    assert_eq!((plan.clock.windows, plan.window_bound_by.as_str()), (500, "`clock.window` of the scene"));
    scene.clock.window_s = Some(0.004);
    assert!(planned(&scene).window_bound_by.starts_with("`mud~rock`"), "a user's window is a maximum");
}

#[test]
fn windows_below_ten_microseconds_are_refused() {
    // 0.003 m at 299 m/s take 1.003e-5 s, at 301 m/s less than 1e-5 s.
    assert_eq!(planned(&approaching(299.0)).clock.windows, 99_667);
    let text = refused(&approaching(301.0));
    assert!(text.starts_with("clock: ") && text.contains("`mud~rock`") && text.contains("coarser spacing"), "{text}");
    let mut scene = approaching(0.0);
    scene.clock.window_s = Some(0.99 * SHORTEST_WINDOW_S);
    let text = refused(&scene);
    assert!(text.contains("`clock.window`") && text.contains("longer one"), "{text}");
    scene.clock.window_s = Some(SHORTEST_WINDOW_S);
    assert_eq!(planned(&scene).clock.windows, 100_000);
    scene.clock.window_s = None;
    scene.clock.frames_per_second = Some(1e6);
    assert!(refused(&scene).contains("`clock.fps`"));
}

#[test]
fn frames_end_windows_and_a_frame_may_bind() {
    let mut scene = approaching(0.0);
    scene.clock.duration_s = 2.0;
    for (fps, window_s, per_frame) in [(25.0, None, 4), (24.0, None, 5), (250.0, None, 1), (30.0, Some(0.02), 2)] {
        scene.clock.frames_per_second = Some(fps);
        scene.clock.window_s = window_s;
        let plan = planned(&scene);
        assert_eq!(plan.clock.windows, (2.0 * fps) as u64 * per_frame, "{fps} frames/s");
        // A frame time is a product of two rounded numbers.
        let frame_s = plan.clock.seconds(plan.clock.start_of(per_frame));
        assert!((frame_s - 1.0 / fps).abs() <= 2.0 * f64::EPSILON / fps, "{fps} frames/s: {frame_s} s");
        assert_eq!(plan.window_bound_by.contains("fps"), fps > 100.0, "{}", plan.window_bound_by);
    }
}

#[test]
fn the_last_frame_is_whole() {
    let mut scene = approaching(0.0);
    scene.clock.duration_s = 0.105;
    scene.clock.frames_per_second = Some(10.0);
    let plan = planned(&scene);
    // Ten windows a frame: 0.105 s end in the eleventh.
    assert_eq!(plan.clock.windows, 11);
    assert!(plan.clock.seconds(plan.clock.start_of(11)) >= 0.105);
}

#[test]
fn what_nothing_binds_is_written_a_hundred_times_a_second() {
    let mut scene = joined(&["a", "b"]);
    scene.clock.window_s = None;
    let plan = planned(&scene);
    assert_eq!(plan.clock.windows, 100);
    assert!(plan.window_bound_by.starts_with("nothing"), "{}", plan.window_bound_by);
    scene.clock.window_s = Some(0.25);
    assert_eq!(planned(&scene).clock.windows, 4, "a user's window may be longer than that");
    scene.clock.window_s = None;
    scene.clock.duration_s = 0.004;
    let plan = planned(&scene);
    assert_eq!((plan.clock.windows, plan.clock.window_s()), (1, 0.004));
    assert!(plan.window_bound_by.contains("`clock.duration`"), "{}", plan.window_bound_by);
}

#[test]
fn a_run_of_many_windows_ends_on_time() {
    let mut scene = approaching(0.0);
    for (duration_s, window_s, windows) in
        [(1.0, 1e-5, 100_000), (3600.0, 1e-4, 36_000_000), (0.3, 0.1, 3), (1e6, 1e-3, 1_000_000_000)]
    {
        scene.clock.duration_s = duration_s;
        scene.clock.window_s = Some(window_s);
        let clock = planned(&scene).clock;
        assert_eq!(clock.windows, windows, "{duration_s} s in windows of {window_s} s");
        // One product of a rounded tick: half a unit in the last place each.
        let end_s = clock.seconds(clock.start_of(windows));
        assert!((end_s - duration_s).abs() <= f64::EPSILON * duration_s, "{end_s} s");
    }
}

#[test]
fn a_stand_in_is_used_for_twenty_substeps() {
    let toy = spaced("toy", "mpm", elastic(1e5), 0.02);
    let rock = body("rock", "rigid", RIGID);
    // A substep of Courant number 0.5 on a grid of two spacings: 0.02 m at 10 m/s.
    check(&terms(&toy, &rock), &[20.0 * 0.02 / 10.0]);
    let told = Body { prescribed: Some(Motion::Twist { linear_m_s: [0.0; 3], angular_rad_s: [0.0; 3] }), ..rock };
    assert!(terms(&toy, &told).is_empty(), "who follows a script cannot be foreseen wrongly");
}

#[test]
fn smoke_is_bounded_by_approach_alone() {
    let cloud = moving(spaced("cloud", "smoke", SMOKE, 0.01), [2.0, 0.0, 0.0]);
    let toy = spaced("toy", "mpm", elastic(1e7), 0.01);
    check(&terms(&cloud, &toy), &[0.3 * 0.01 / 2.0]);
    assert!(terms(&spaced("cloud", "smoke", SMOKE, 0.01), &toy).is_empty(), "a gas does not feel how stiff a solid is");
}
