//! Frames: who records them, which streams carry them, and when.

use cosplat_core::plan::schedule::{published_at_start, steps};
use cosplat_core::plan::{Content, Plan, RECORDER};
use cosplat_core::plugin::Descriptor;
use cosplat_core::scene::{Fill, OutputSpec, Scene, Source};
use cosplat_core::visual::VisualForm;

use crate::cast::{LIQUID, body, elastic, plugins, scene};

const GRADIENTS: VisualForm = VisualForm::Particles { gradients: true };

/// Mud and a captured toy, at 10 frames a second in windows of 20 ms.
fn filmed() -> Scene {
    let mut toy = body("toy", "mpm", elastic(1e4));
    toy.source = Source::Splat {
        file: "toy.spz".into(),
        metres_per_unit: 1.0,
        up: "+z".into(),
        min_opacity: 0.0,
        keep_box: None,
        fill: Fill::default(),
    };
    let mut scene = scene([body("mud", "sph", LIQUID), toy]);
    scene.clock.frames_per_second = Some(10.0);
    scene.clock.window_s = Some(0.02);
    scene.output = OutputSpec { pictures: true, ..OutputSpec::default() };
    scene
}

fn planned(scene: &Scene, visual: impl Fn(&str) -> Option<VisualForm>) -> Plan {
    let mut known = plugins();
    for (name, descriptor) in &mut known {
        *descriptor = Descriptor { visual: visual(name), ..descriptor.clone() };
        descriptor.body_kinds.push("splat".into());
    }
    cosplat_core::plan::build(scene, &known, 4).unwrap_or_else(|r| panic!("{r:?}")).0
}

fn drawn(plan: &Plan) -> Vec<(&str, VisualForm)> {
    let form = |content: &Content| match content {
        Content::Visual { form, .. } => Some(*form),
        _ => None,
    };
    plan.streams.iter().filter_map(|s| Some((s.key.as_str(), form(&s.content)?))).collect()
}

#[test]
fn a_recorder_comes_last_and_gradients_travel_only_for_gaussians() {
    let plan = planned(&filmed(), |_| Some(GRADIENTS));
    let names: Vec<&str> = plan.participants.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["mpm", "sph", RECORDER]);
    assert_eq!((plan.solver_count(), plan.is_solver(1), plan.is_solver(2)), (2, true, false));
    let points = VisualForm::Particles { gradients: false };
    assert_eq!(drawn(&plan), [("out/mpm/toy", GRADIENTS), ("out/sph/mud", points)]);
    // The recorder takes no core from the solvers: each is alone on its level.
    assert_eq!(plan.participants.iter().map(|p| p.threads).collect::<Vec<_>>(), [4, 4, 4]);
}

#[test]
fn frames_are_shown_at_their_edges_and_drawn_in_the_window_that_ends_there() {
    let plan = planned(&filmed(), |_| Some(GRADIENTS));
    let recorder = plan.recorder.expect("a recorder");
    let every = recorder.windows_per_frame;
    let frames_s = plan.clock.window_s() * every as f64;
    assert!((frames_s - 0.1).abs() < 1e-12, "one frame is {every} windows");
    let toy = plan.streams.iter().position(|s| s.key == "out/mpm/toy").expect("a stream") as u16;
    let gives = |window| -> Vec<u64> {
        let all = steps(&plan, 0, window);
        all.iter().flat_map(|s| &s.gives).filter(|id| id.stream == toy).map(|id| id.index).collect()
    };
    let needs = |window| -> Vec<u64> {
        let all = steps(&plan, recorder.participant, window);
        all.iter().flat_map(|s| &s.needs).filter(|n| n.message.stream == toy).map(|n| n.message.index).collect()
    };
    for window in 0..3 * every {
        let ends_frame = (window + 1).is_multiple_of(every);
        let edge = ends_frame.then_some(window + 1);
        assert_eq!(gives(window), edge.into_iter().collect::<Vec<_>>(), "window {window}");
        let start = (window == 0).then_some(0);
        assert_eq!(needs(window), start.into_iter().chain(edge).collect::<Vec<_>>(), "window {window}");
    }
    assert!(published_at_start(&plan, 0).iter().any(|id| id.stream == toy && id.index == 0));
}

#[test]
fn what_shows_nothing_is_left_out_by_name_and_without_frames_there_is_no_recorder() {
    let blind = planned(&filmed(), |name| (name == "mpm").then_some(GRADIENTS));
    assert_eq!(drawn(&blind).len(), 1);
    let why = blind.left_out.iter().find(|l| l.what == "pictures of body `mud`").expect("an entry");
    assert_eq!(why.why, "plugin `sph` shows nothing of its bodies");
    let all_blind = planned(&filmed(), |_| None);
    assert_eq!((all_blind.recorder, all_blind.participants.len()), (None, 2));
    let mut unfilmed = filmed();
    unfilmed.output = OutputSpec::default();
    assert_eq!(planned(&unfilmed, |_| Some(GRADIENTS)).recorder, None);
}

#[test]
fn the_recorder_s_name_is_taken() {
    let mut scene = filmed();
    scene.bodies[0].solver = RECORDER.into();
    crate::cast::run_with(&mut scene, "sph", &[RECORDER]);
    let mut known = plugins();
    for descriptor in known.values_mut() {
        descriptor.visual = Some(GRADIENTS);
        descriptor.body_kinds.push("splat".into());
    }
    let refused = cosplat_core::plan::build(&scene, &known, 4).unwrap_err();
    assert!(refused.iter().any(|r| r.what == "solver `recorder`"), "{refused:?}");
}
