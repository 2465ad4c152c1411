//! A recording is read back by rerun's own decoder.
#![cfg(feature = "recording")]

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use cosplat_viewer::recording::diagram::{Diagram, Series, Text, write_diagrams};
use cosplat_viewer::recording::{Curves, Layout, Recording, RecordingError};
use cosplat_viewer::{Camera, Gaussians};
use rerun::StoreKind;
use rerun::external::re_log_encoding::DecoderApp;
use rerun::log::{Chunk, LogMsg};

const CURVES: [Curves<'static>; 2] =
    [Curves { path: "curves/closure", title: "Closure [1]" }, Curves { path: "curves/energy", title: "Energy [J]" }];

fn camera() -> Camera {
    Camera { eye: [0.0, -3.0, 1.0], target: [0.0; 3], up: [0.0, 0.0, 1.0], fov_y_deg: 45.0, width: 96, height: 54 }
}

fn layout(camera: &Camera) -> Layout<'_> {
    let (up, curves) = ([0.0, 0.0, 1.0], &CURVES[..]);
    Layout { scene: "test", run: "run-1", up, camera: Some(camera), background: [0.1, 0.2, 0.3], curves }
}

/// Removed when the test ends.
struct File(PathBuf);

impl File {
    fn new(name: &str) -> File {
        File(std::env::temp_dir().join(format!("cosplat-{}-{name}.rrd", std::process::id())))
    }
}

impl Drop for File {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

/// Two Gaussians, the second turned by a quaternion that is not of length one.
fn with_gaussians<T>(height: f32, then: impl FnOnce(&Gaussians<'_>) -> T) -> T {
    then(&Gaussians {
        positions: &[[0.0, 0.0, height], [1.0, 0.0, height]],
        rotations: &[[1.0, 0.0, 0.0, 0.0], [2.0, 0.0, 0.0, 2.0]],
        log_scales: &[[-3.0; 3], [-2.0, -3.0, -4.0]],
        opacity_logits: &[0.0, 100.0],
        sh_dc: &[[0.0; 3], [1.0, 0.0, -10.0]],
        sh_rest: &[[0.1, 0.2, 0.3]; 6],
        sh_degree: 1,
        antialiased: false,
    })
}

fn fill(recording: &mut Recording) -> Result<(), RecordingError> {
    with_gaussians(0.0, |g| recording.static_splats("world/ground", g))?;
    for window in 0..4_u64 {
        let time_s = 0.01 * window as f64;
        recording.frame(window, time_s);
        with_gaussians(window as f32, |g| recording.splats("world/jelly", g))?;
        recording.points("world/boundary", &[[0.0; 3], [1.0; 3]], &[[255, 0, 0, 255]], &[0.01, 0.02])?;
        recording.arrow("world/impulse", [0.0; 3], [0.0, 0.0, 1.0])?;
        recording.transform("world/ball", [0.0, 0.0, time_s], [0.0, 0.0, 0.0, 1.0])?;
        for sub in 0..10 {
            let (window, time_s) = (10 * window + sub, time_s + 0.001 * sub as f64);
            recording.series("curves/closure/left", window, time_s, 1e-15)?;
        }
        recording.series("curves/energy/total", window, time_s, 2.0)?;
        recording.flush()?;
    }
    Ok(())
}

/// Chunks of a file by store and entity, and how many layouts it makes active.
fn read(bytes: &[u8]) -> (BTreeMap<(bool, String), Vec<Chunk>>, usize) {
    let (mut chunks, mut active) = (BTreeMap::<_, Vec<Chunk>>::new(), 0);
    for message in DecoderApp::decode_lazy(bytes).map_while(Result::ok) {
        match message {
            LogMsg::ArrowMsg(store, message) => {
                let chunk = Chunk::from_arrow_msg(&message).expect("a chunk");
                let key = (store.kind() == StoreKind::Recording, chunk.entity_path().to_string());
                chunks.entry(key).or_default().push(chunk);
            }
            LogMsg::BlueprintActivationCommand(_) => active += 1,
            LogMsg::SetStoreInfo(_) => (),
        }
    }
    (chunks, active)
}

/// Rows of the recording by entity, without those that have no time.
fn rows(bytes: &[u8]) -> BTreeMap<String, usize> {
    let chunks = read(bytes).0.into_iter().filter(|((recording, _), _)| *recording);
    let timed = |chunks: &[Chunk]| chunks.iter().filter(|c| !c.is_static()).map(Chunk::num_rows).sum();
    chunks.map(|((_, entity), chunks)| (entity, timed(&chunks))).collect()
}

#[test]
fn everything_is_read_back() {
    let file = File::new("whole");
    let camera = camera();
    let mut recording = Recording::create(&file.0, &layout(&camera)).unwrap();
    fill(&mut recording).unwrap();
    recording.finish().unwrap();
    let bytes = std::fs::read(&file.0).unwrap();
    assert_eq!(&bytes[..4], b"RRF2");
    let rows = rows(&bytes);
    let of = |entity: &str| rows.get(entity).copied();
    let moving = ["/world/jelly", "/world/boundary", "/world/impulse", "/world/ball", "/curves/energy/total"];
    assert_eq!(moving.map(of), [Some(4); 5], "{rows:?}");
    assert_eq!((of("/curves/closure/left"), of("/world/ground")), (Some(40), Some(0)));
}

#[test]
fn what_does_not_change_is_written_once() {
    let file = File::new("once");
    let camera = camera();
    let mut recording = Recording::create(&file.0, &layout(&camera)).unwrap();
    fill(&mut recording).unwrap();
    recording.finish().unwrap();
    let (chunks, _) = read(&std::fs::read(&file.0).unwrap());
    let jelly = &chunks[&(true, "/world/jelly".to_owned())];
    let with = |component: &str| {
        let has = |c: &&Chunk| c.components_identifiers().any(|id| id.as_str() == component);
        let found: Vec<_> = jelly.iter().filter(has).collect();
        (found.len(), found.iter().all(|c| c.is_static()))
    };
    assert_eq!(with("GaussianSplats3D:colors"), (1, false));
    assert_eq!(with("GaussianSplats3D:scales"), (1, false));
    assert_eq!(with("GaussianSplats3D:quaternions"), (1, false));
    assert_eq!(with("GaussianSplats3D:sh_coefficients"), (1, true));
    assert_eq!(with("GaussianSplats3D:centers"), (4, false));
}

#[test]
fn the_layout_is_in_the_file_and_the_same_for_every_run() {
    let entities = |name: &str| {
        let file = File::new(name);
        let camera = camera();
        Recording::create(&file.0, &layout(&camera)).unwrap().finish().unwrap();
        let (chunks, active) = read(&std::fs::read(&file.0).unwrap());
        let layout: Vec<String> = chunks.into_keys().filter(|(recording, _)| !recording).map(|(_, e)| e).collect();
        (layout, active)
    };
    let (layout, active) = entities("layout-1");
    assert_eq!(active, 1);
    assert_eq!(layout.iter().filter(|e| e.ends_with("/ViewContents")).count(), 1 + CURVES.len());
    // The viewer keeps both in one tree and never returns from it if an identity is there twice.
    let mut parts: Vec<&str> = layout.iter().filter_map(|e| e.split('/').nth(2)).collect();
    let nodes: BTreeSet<_> =
        layout.iter().map(|e| e.split('/').take(3).collect::<Vec<_>>()).filter(|p| p.len() > 2).collect();
    parts.sort_unstable();
    parts.dedup();
    assert_eq!((parts.len(), nodes.len()), (2 + 1 + CURVES.len(), 2 + 1 + CURVES.len()), "{layout:?}");
    assert!(layout.iter().any(|e| e.ends_with("/EyeControls3D")) && layout.contains(&"/viewport".to_owned()));
    assert_eq!(entities("layout-2"), (layout, active));
}

/// What the system holds after a flush is what a kill would leave.
#[test]
fn a_run_that_is_killed_leaves_what_was_flushed() {
    let file = File::new("killed");
    let camera = camera();
    let mut recording = Recording::create(&file.0, &layout(&camera)).unwrap();
    fill(&mut recording).unwrap();
    let bytes = std::fs::read(&file.0).unwrap();
    let flushed = rows(&bytes);
    assert_eq!((flushed["/world/jelly"], flushed["/curves/closure/left"]), (4, 40));
    // Cut anywhere, it gives what came before.
    let half = rows(&bytes[..bytes.len() / 2]);
    assert!(half.values().sum::<usize>() < flushed.values().sum::<usize>());
    drop(recording);
    assert_eq!(rows(&std::fs::read(&file.0).unwrap()), flushed);
}

#[test]
fn bad_input_is_refused() {
    let camera = camera();
    let nowhere = std::path::Path::new("/no such folder/run.rrd");
    assert!(matches!(Recording::create(nowhere, &layout(&camera)), Err(RecordingError::Create(..))));
    let file = File::new("bad");
    let mut recording = Recording::create(&file.0, &layout(&camera)).unwrap();
    let short = with_gaussians(0.0, |g| recording.splats("world/x", &Gaussians { rotations: &[], ..*g }));
    assert!(short.unwrap_err().to_string().starts_with("world/x: rotations"));
    let points = recording.points("world/x", &[[0.0; 3]; 3], &[[0; 4]; 2], &[0.1]);
    assert!(points.unwrap_err().to_string().contains("3 points need 1 or 3 colours"));
    // Nothing that is no number may panic.
    recording.frame(u64::MAX, f64::NAN);
    recording.transform("world/x", [f64::NAN; 3], [f64::INFINITY; 4]).unwrap();
    recording.series("curves/closure/x", 0, f64::INFINITY, f64::NAN).unwrap();
    with_gaussians(f32::NAN, |g| recording.splats("world/y", g)).unwrap();
    recording.flush().unwrap();
}

#[test]
fn a_diagram_is_in_the_file_with_every_series_that_can_be_drawn() {
    let file = File::new("diagram");
    let series = |name: &str, marked: bool| Series {
        name: name.into(),
        colour: [0, 114, 178],
        marked,
        joined: true,
        points: vec![(0.1, 1e-2, "coarse".into()), (f64::NAN, 1.0, "lost".into()), (10.0, 1e-4, "fine".into())],
    };
    let one = |title: &str| Diagram {
        group: "case".into(),
        title: title.into(),
        axes: ["time [s]".into(), "error [1]".into()],
        series: vec![series("runs", true), series("a/b", false)],
    };
    let text = Text { group: "case".into(), title: "gates".into(), markdown: "| a |\n|---|\n| b |".into() };
    write_diagrams(&file.0, "study", "run-1", &[one("first"), one("second")], &[text]).unwrap();
    let (chunks, active) = read(&std::fs::read(&file.0).unwrap());
    assert_eq!(active, 1);
    let entities: Vec<&str> = chunks.keys().filter(|(recording, _)| *recording).map(|(_, e)| e.as_str()).collect();
    assert!(entities.contains(&"/text/0"), "{entities:?}");
    for part in ["grid", "axes", "0\\ runs", "0\\ runs/line", "1\\ a\\ b/line"] {
        let path = format!("/diagram/1/{part}");
        assert!(entities.contains(&path.as_str()), "{path}: {entities:?}");
    }
}
