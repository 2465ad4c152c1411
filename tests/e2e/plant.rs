//! Is a captured plant hit by a rock, in pictures, splats and numbers, by real processes?
//!
//! The default scene with coarser particles and a shorter time, so that a run takes seconds.

mod support;

use std::fs;
use std::path::Path;

use support::{Program, Run};

const SCENE: &str = "plant-and-rock";
/// Coarse, and over soon after the rock has hit.
const COARSE: [&str; 5] = ["--quiet", "--set", "body.plant.spacing=0.012", "--set", "clock.duration=0.25"];

fn run(args: &[&str]) -> Run {
    Program::built_in(SCENE, &[&COARSE[..], args].concat()).finish().expect_code(0)
}

/// Without anything that needs frames: only the physics.
const BARE: [&str; 6] =
    ["--set", "output.pictures=false", "--set", "output.splats=false", "--set", "output.recording=false"];

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut names: Vec<String> = entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into()).collect();
    names.sort();
    names
}

/// Positions and all that follows of a binary PLY of 32-bit floats: count, bytes of a vertex, the vertices.
fn ply(path: &Path) -> (usize, usize, Vec<u8>) {
    let bytes = fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let end = bytes.windows(11).position(|w| w == b"end_header\n").expect("a header") + 11;
    let header = String::from_utf8_lossy(&bytes[..end]);
    let count = header.lines().find_map(|l| l.strip_prefix("element vertex ")).expect("vertices").parse();
    let count: usize = count.expect("a number");
    let width = 4 * header.lines().filter(|l| l.starts_with("property float ")).count();
    assert_eq!(bytes.len(), end + count * width, "{header}");
    (count, width, bytes[end..].to_vec())
}

#[test]
fn the_plant_is_hit_and_the_run_leaves_pictures_splats_a_recording_and_a_report() {
    let run = run(&[]);
    let interface = &run.summary["interfaces"][0];
    assert_eq!(interface["transfer_defect"].as_f64(), Some(0.0), "what was sent is what arrived, to the bit");
    assert!(interface["gross_impulse"].as_f64().is_some_and(|j| j > 0.05), "the rock touches: {interface}");
    let verdicts = run.summary["verdicts"].as_array().expect("verdicts");
    assert!(verdicts.len() >= 5 && verdicts.iter().all(|v| v["passed"] == true), "{verdicts:?}");

    let frames = 7; // 0.25 s at 24 a second, and the start
    let numbered = |ending: &str| (0..frames).map(|i| format!("frame_{i:04}.{ending}")).collect::<Vec<_>>();
    assert_eq!(names(&run.folder.join("frames")), numbered("png"));
    assert_eq!(names(&run.folder.join("splats")), numbered("ply"));
    assert_eq!(run.summary["frames"]["taken"], frames);

    let (count, width, first) = ply(&run.folder.join("splats/frame_0000.ply"));
    let (later_count, _, later) = ply(&run.folder.join("splats/frame_0006.ply"));
    let bodies = run.summary["bodies"].as_array().expect("bodies");
    let gaussians: u64 = bodies.iter().filter_map(|b| b["gaussians"].as_u64()).sum();
    // And about 16 000 for the floor, which is no body.
    assert!((15_000..17_000).contains(&(count as u64 - gaussians)), "{count} of {gaussians}: proxies are never drawn");
    assert_eq!(later_count, count, "every Gaussian in every frame");
    // Of the plant's Gaussians, those that can be seen ride on its particles: nearly all have moved by now.
    let plant = bodies.iter().find(|b| b["name"] == "plant").and_then(|b| b["gaussians"].as_u64()).expect("a plant");
    let vertices = |bytes: &[u8]| bytes.chunks(width).take(plant as usize).map(<[u8]>::to_vec).collect::<Vec<_>>();
    let moved = vertices(&first).iter().zip(vertices(&later)).filter(|(a, b)| **a != *b).count();
    assert!(moved as f64 > 0.9 * plant as f64, "{moved} of {plant} moved");

    let head = |name: &str, bytes: usize| fs::read(run.folder.join(name)).expect("a file")[..bytes].to_vec();
    assert_eq!(head("preview.png", 8), b"\x89PNG\r\n\x1a\n");
    assert_eq!(head("run.rrd", 4), b"RRF2", "the recording's own mark");
    let report = fs::read_to_string(run.folder.join("report.html")).expect("a report");
    assert!(report.starts_with("<!DOCTYPE html>") && report.contains(&run.hash()) && report.contains("<svg"));
    let outside = report.match_indices("http").filter(|(at, _)| !report[*at..].starts_with("http://www.w3.org/"));
    assert_eq!(outside.count(), 0, "the report needs nothing from outside");
}

#[test]
fn threads_and_frames_change_no_bit_of_the_state_and_one_ulp_of_the_input_does() {
    let one = run(&[&BARE[..], &["--threads", "1"]].concat());
    let expected = one.hash();
    assert!(one.summary["frames"].is_null() && !one.folder.join("frames").exists(), "nothing that is not wanted");
    let two = run(&["--threads", "2"]);
    assert_eq!(two.hash(), expected, "two threads and a recorder");
    let threads = |run: &Run| run.summary["processes"][0]["threads"].as_u64();
    assert_eq!((threads(&one), threads(&two)), (Some(1), Some(2)));
    let speed = format!("body.rock.velocity=[{:?}, 0.0, 0.5]", (-4.0_f64).next_up());
    let nudged = run(&[&BARE[..], &["--set", &speed]].concat());
    assert_ne!(nudged.hash(), expected, "one unit in the last place of the rock's speed");
}

/// The negative control: with the reaction thrown away the rock flies on as if there were no plant, and that shows.
#[test]
fn a_dropped_reaction_is_far_outside_the_gate() {
    let args = [&COARSE[..], &BARE[..], &["--set", "run.break=\"drop-reaction\""]].concat();
    let run = Program::built_in(SCENE, &args).finish().expect_code(7);
    let verdicts = run.summary["verdicts"].as_array().expect("verdicts");
    let rigid = verdicts.iter().find(|v| v["name"] == "closure-window" && v["of"] == "rigid").expect("a verdict");
    let (value, limit) = (rigid["value"].as_f64().expect("measured"), rigid["limit"].as_f64().expect("a limit"));
    assert!(value > 1e6 * limit, "{value:e} against {limit:e}");
}
