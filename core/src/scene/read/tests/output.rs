//! `[output]`: what a run leaves beside its ledger.

use super::*;
use crate::scene::{CameraSpec, OutputSpec, Scene};

fn scene(clock: &str, output: &str) -> Result<Scene, Vec<Diagnostic>> {
    let body = "[[body]]\nname = \"a\"\nsolver = \"s\"\nmaterial = \"point-mass\"\nmass = 1\npoints = [[0, 0, 0]]\n";
    let text = format!("format = 1\nname = \"x\"\n[clock]\nduration = 1\n{clock}\n{output}\n{body}");
    parse(&text).map(|(scene, _)| scene)
}

#[test]
fn frames_are_used_where_there_are_any() {
    let plain = scene("", "").unwrap().output;
    assert_eq!(plain, OutputSpec::default());
    assert!(!plain.draws() && plain.report && plain.trace);
    let framed = scene("fps = 24", "").unwrap().output;
    assert!(framed.pictures && framed.splats && framed.recording);
    let some = scene("fps = 24", "[output]\nsplats = false\nrecording = false").unwrap().output;
    assert_eq!((some.pictures, some.splats, some.recording), (true, false, false));
    let none = scene("fps = 24", "[output]\npictures = false\nsplats = false\nrecording = false").unwrap();
    assert!(!none.output.draws());
}

#[test]
fn pictures_without_a_frame_rate_are_a_mistake_with_a_way_out() {
    let found = scene("", "[output]\npictures = true").unwrap_err();
    assert_eq!(found.len(), 1);
    assert!(found[0].message.contains("`pictures` needs frames"), "{found:?}");
    assert!(found[0].help.as_deref().is_some_and(|h| h.contains("fps = 24")), "{found:?}");
    assert!(scene("", "[output]\npictures = false").is_ok());
}

#[test]
fn a_camera_needs_a_place_and_a_target() {
    let camera = |text: &str| scene("fps = 24", &format!("[output.camera]\n{text}"));
    let given = camera("eye = [0, -2, 1]\ntarget = [0, 0, 0.5]").unwrap().output.camera.unwrap();
    let wanted = CameraSpec {
        eye_m: [0.0, -2.0, 1.0],
        target_m: [0.0, 0.0, 0.5],
        up: [0.0, 0.0, 1.0],
        field_of_view_deg: 40.0,
        size_px: [960, 540],
        background: [1.0; 3],
    };
    assert_eq!(given, wanted);
    assert!(camera("eye = [0, -2, 1]").is_err());
    for wrong in ["size = [8, 540]", "field_of_view = 180", "background = [2, 0, 0]"] {
        let found = camera(&format!("eye = [0, -2, 1]\ntarget = [0, 0, 0]\n{wrong}")).unwrap_err();
        assert_eq!(found.len(), 1, "{wrong}: {found:?}");
    }
}
