//! Does the preset for video models leave its 49 frames with all that belongs to them?

mod support;

use std::fs;

use support::Program;

const FRAMES: usize = 49;
const WIDTH: usize = 720;
const HEIGHT: usize = 480;

/// The scene has no frame rate of its own: the preset sets it. What is needed for nothing here is left away.
const ARGS: [&str; 10] = [
    "--quiet",
    "--set",
    "clock.duration=0.12",
    "--set",
    "output.preset=\"video-model\"",
    "--set",
    "output.recording=false",
    "--set",
    "output.splats=false",
    "--set=output.report=false",
];

#[test]
fn a_video_model_is_given_colour_flow_depth_and_mask_of_every_frame() {
    let run = Program::built_in("ball-on-block", &ARGS).finish().expect_code(0);
    assert_eq!(run.summary["frames"]["taken"], FRAMES);
    assert!(run.summary["frames"]["drawn_by"].as_str().is_some_and(|by| by.contains("CPU")));
    let folder = run.folder.join("conditions");
    let read = |name: String| fs::read(folder.join(&name)).unwrap_or_else(|e| panic!("{name}: {e}"));
    let about: serde_json::Value = serde_json::from_slice(&read("about.json".into())).expect("JSON");
    assert_eq!((&about["frames"], &about["size_px"]), (&FRAMES.into(), &serde_json::json!([WIDTH, HEIGHT])));
    let value = |name: &str| {
        let bodies = about["bodies"].as_array().expect("bodies");
        let body = bodies.iter().find(|b| b["name"] == name).unwrap_or_else(|| panic!("`{name}` in {about}"));
        assert_eq!(body["moves"], true);
        body["value"].as_u64().expect("a number")
    };
    assert!(value("ball") != value("block"));
    let mut largest = 0.0_f32;
    for number in 0..FRAMES {
        assert!(run.folder.join(format!("frames/frame_{number:04}.png")).is_file());
        assert!(read(format!("mask_{number:04}.png")).starts_with(b"\x89PNG"));
        let depth = read(format!("depth_{number:04}.npy"));
        assert!(depth.starts_with(b"\x93NUMPY") && depth.len() > 4 * WIDTH * HEIGHT);
        if number + 1 == FRAMES {
            assert!(!folder.join(format!("flow_{number:04}.flo")).exists(), "there is no frame behind the last");
            continue;
        }
        let flow = read(format!("flow_{number:04}.flo"));
        assert_eq!(flow.len(), 12 + 8 * WIDTH * HEIGHT);
        let numbers = flow[12..].as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b));
        largest = numbers.filter(|v| *v < 1e9).map(f32::abs).fold(largest, f32::max);
    }
    assert!(largest > 0.1 && largest < 100.0, "something moves, and nothing jumps: {largest}");
}
