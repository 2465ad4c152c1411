//! `[output]`: what a run leaves beside its ledger.

use super::*;
use crate::scene::{
    CameraSpec, CameraStop, CameraTravel, MeshForm, OutputSpec, Preset, RendererSpec, Scene, SplatForm,
};

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
fn splat_files_have_a_form() {
    let form = |clock: &str, value: &str| {
        scene(clock, &format!("[output]\nsplats = {value}")).map(|s| (s.output.splats, s.output.splat_form))
    };
    for (value, wanted) in [
        ("true", (true, SplatForm::Ply)),
        ("false", (false, SplatForm::Ply)),
        ("\"ply\"", (true, SplatForm::Ply)),
        ("\"spz\"", (true, SplatForm::Spz)),
        ("\"compact\"", (true, SplatForm::Compact)),
    ] {
        assert_eq!(form("fps = 24", value), Ok(wanted), "{value}");
    }
    for (clock, value, word) in [
        ("fps = 24", "\"spy\"", "`splats` cannot be"),
        ("fps = 24", "3", "must be true or false"),
        ("", "\"spz\"", "`splats` needs frames"),
    ] {
        let found = form(clock, value).unwrap_err();
        assert!(found.len() == 1 && found[0].message.contains(word), "{value}: {found:?}");
    }
}

#[test]
fn surfaces_of_liquids_have_a_format() {
    let form =
        |clock: &str, value: &str| scene(clock, &format!("[output]\nsurfaces = {value}")).map(|s| s.output.surfaces);
    assert_eq!(scene("fps = 24", "").unwrap().output.surfaces, None);
    assert_eq!(form("fps = 24", "\"obj\""), Ok(Some(MeshForm::Obj)));
    assert_eq!(form("fps = 24", "\"ply\""), Ok(Some(MeshForm::Ply)));
    assert_eq!(form("", "false"), Ok(None));
    for (clock, value, word) in
        [("fps = 24", "\"stl\"", "`surfaces` cannot be"), ("fps = 24", "3", "must be"), ("", "\"obj\"", "needs frames")]
    {
        let found = form(clock, value).unwrap_err();
        assert!(found.len() == 1 && found[0].message.contains(word), "{value}: {found:?}");
    }
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
        travel: CameraTravel::Still,
    };
    assert_eq!(given, wanted);
    assert!(camera("eye = [0, -2, 1]").is_err());
    for wrong in ["size = [8, 540]", "field_of_view = 180", "background = [2, 0, 0]"] {
        let found = camera(&format!("eye = [0, -2, 1]\ntarget = [0, 0, 0]\n{wrong}")).unwrap_err();
        assert_eq!(found.len(), 1, "{wrong}: {found:?}");
    }
}

#[test]
fn a_camera_turns_about_its_target_or_passes_stops() {
    let camera = |text: &str| scene("fps = 24", &format!("[output.camera]\n{text}"));
    let travel = |text: &str| camera(text).map(|s| s.output.camera.map(|c| c.travel));
    let orbit = travel("eye = [0, -2, 1]\ntarget = [0, 0, 0]\norbit = { degrees = -90 }");
    assert_eq!(orbit, Ok(Some(CameraTravel::Orbit { degrees: -90.0 })));
    let path = "path = [{ time = 0, eye = [1, 0, 0], target = [0, 0, 0] }, { time = 0.5, eye = [0, 1, 0], target = [0, 0, 1] }]";
    let given = camera(path).unwrap().output.camera.unwrap();
    assert_eq!((given.eye_m, given.target_m), ([1.0, 0.0, 0.0], [0.0; 3]), "its first stop");
    let last = CameraStop { time_s: 0.5, eye_m: [0.0, 1.0, 0.0], target_m: [0.0, 0.0, 1.0] };
    assert!(matches!(given.travel, CameraTravel::Path { stops } if stops.len() == 2 && stops[1] == last));
    let stop = "eye = [1, 0, 0], target = [0, 0, 0]";
    for (wrong, word) in [
        (format!("{path}\neye = [0, 0, 1]"), "exclude each other"),
        (format!("{path}\norbit = {{ degrees = 3 }}"), "exclude each other"),
        (format!("path = [{{ time = 0, {stop} }}]"), "at least two stops, but has 1"),
        ("path = []".to_owned(), "at least two stops, but has 0"),
        ("path = 3".to_owned(), "must be a list"),
        (format!("path = [{{ time = 1, {stop} }}, {{ time = 1, {stop} }}]"), "here at 1 s"),
        (format!("path = [{{ time = -1, {stop} }}, {{ time = 1, {stop} }}]"), "`time` must be"),
        ("eye = [1, 0, 0]\ntarget = [0, 0, 0]\norbit = { degrees = 1e6 }".to_owned(), "`degrees` must be"),
    ] {
        let found = camera(&wrong).unwrap_err();
        assert!(found.len() == 1 && found[0].message.contains(word), "{wrong}: {found:?}");
    }
}

#[test]
fn a_film_is_asked_for_and_made_from_pictures() {
    let video = |clock: &str, output: &str| scene(clock, &format!("[output]\n{output}")).map(|s| s.output.video);
    assert_eq!(video("fps = 24", ""), Ok(false));
    assert_eq!(video("fps = 24", "video = true"), Ok(true));
    let found = video("fps = 24", "video = true\npictures = false").unwrap_err();
    assert!(found.len() == 1 && found[0].message.contains("made from pictures"), "{found:?}");
    assert!(video("", "video = true").unwrap_err()[0].message.contains("`video` needs frames"));
}

#[test]
fn a_preset_sets_frames_and_size() {
    let preset = |clock: &str, output: &str| scene(clock, &format!("[output]\npreset = \"video-model\"\n{output}"));
    let camera = "[output.camera]\neye = [1, 0, 0]\ntarget = [0, 0, 0]\n";
    for clock in ["", "fps = 48"] {
        let found = preset(clock, camera).unwrap();
        assert_eq!(found.clock.frames_per_second, Some(48.0), "49 frames in one second");
        assert_eq!(found.output.preset, Some(Preset::VideoModel));
        assert!(found.output.pictures && found.output.camera.is_some_and(|c| c.size_px == [720, 480]));
    }
    for (clock, output, word) in [
        ("fps = 24", "", "49 frames"),
        ("", "pictures = false", "made from pictures"),
        ("", "[output.camera]\neye = [1, 0, 0]\ntarget = [0, 0, 0]\nsize = [640, 480]", "720 × 480"),
    ] {
        let found = preset(clock, output).unwrap_err();
        assert!(found.len() == 1 && found[0].message.contains(word) && found[0].help.is_some(), "{found:?}");
    }
    assert!(scene("", "[output]\npreset = \"film\"").is_err());
}

#[test]
fn who_draws_is_asked_for_by_name() {
    let renderer = |word: &str| scene("", &format!("[output]\nrenderer = \"{word}\"")).map(|s| s.output.renderer);
    assert_eq!(scene("", "").unwrap().output.renderer, RendererSpec::Cpu);
    let all = [("cpu", RendererSpec::Cpu), ("gpu", RendererSpec::Gpu), ("auto", RendererSpec::Auto)];
    assert!(all.into_iter().all(|(word, spec)| renderer(word) == Ok(spec)));
    assert!(renderer("vulkan").is_err());
}
