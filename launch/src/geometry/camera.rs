//! Where pictures are taken from.

use cosplat_core::scene::{CameraSpec, CameraTravel, Scene};
use cosplat_viewer::{Camera, Shot, Stop, Travel};
use nalgebra::Vector3;

use crate::frames::{Drawn, Look};

/// From where a scene without a camera is looked at: the front, a little from the right and above.
const FROM: [f64; 3] = [0.45, -1.0, 0.35];
const FIELD_OF_VIEW_DEG: f64 = 40.0;
const SIZE_PX: [usize; 2] = [960, 540];
/// Room around what is drawn.
const MARGIN: f64 = 1.15;
/// Moments at which it is looked whether a moving camera can take a picture.
const MOMENTS: u32 = 1000;

/// The camera of a scene and how it moves, or one that stands still and sees all that is drawn at the start.
///
/// # Errors
/// In words, where it cannot take a picture.
pub(super) fn shot(scene: &Scene, drawn: &[Drawn]) -> Result<Shot, String> {
    let Some(spec) = &scene.output.camera else {
        let camera = around(scene, drawn);
        return camera.view().map(|_| Shot::still(camera)).map_err(|e| format!("its camera: {e}"));
    };
    let duration_s = scene.clock.duration_s;
    let shot = Shot { camera: camera(spec), travel: travel(&spec.travel, duration_s) };
    let moments = if shot.travel == Travel::Still { 0 } else { MOMENTS };
    let every = (0..=moments).map(|i| duration_s * f64::from(i) / f64::from(moments.max(1)));
    // The stops themselves may lie between.
    let stops = match &shot.travel {
        Travel::Path(stops) => stops.iter().map(|s| s.time_s).collect(),
        _ => Vec::new(),
    };
    for moment in every.chain(stops) {
        shot.at(moment).view().map_err(|e| format!("its camera, {moment:.3} s after the start: {e}"))?;
    }
    Ok(shot)
}

fn camera(spec: &CameraSpec) -> Camera {
    let [width, height] = spec.size_px.map(|n| n as usize);
    Camera { eye: spec.eye_m, target: spec.target_m, up: spec.up, fov_y_deg: spec.field_of_view_deg, width, height }
}

fn travel(spec: &CameraTravel, duration_s: f64) -> Travel {
    match spec {
        CameraTravel::Still => Travel::Still,
        CameraTravel::Orbit { degrees } => Travel::Orbit { degrees: *degrees, duration_s },
        CameraTravel::Path { stops } => {
            let stop =
                |s: &cosplat_core::scene::CameraStop| Stop { time_s: s.time_s, eye: s.eye_m, target: s.target_m };
            Travel::Path(stops.iter().map(stop).collect())
        }
    }
}

/// A camera that sees all that is drawn at the start.
fn around(scene: &Scene, drawn: &[Drawn]) -> Camera {
    let (mut low, mut high) = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
    for point in drawn.iter().flat_map(points) {
        (low, high) = (low.inf(&point), high.sup(&point));
    }
    if !low.iter().all(|c| c.is_finite()) {
        for body in &scene.bodies {
            let at = Vector3::from(body.pose.position_m);
            (low, high) = (low.inf(&at), high.sup(&at));
        }
    }
    let (target, radius) = ((low + high) / 2.0, ((high - low).norm() / 2.0).max(0.1));
    let distance = MARGIN * radius / (FIELD_OF_VIEW_DEG.to_radians() / 2.0).sin();
    let eye = target + Vector3::from(FROM).normalize() * distance;
    let [width, height] = scene.output.preset.map_or(SIZE_PX, |preset| preset.size_px().map(|n| n as usize));
    Camera { eye: eye.into(), target: target.into(), up: [0.0, 0.0, 1.0], fov_y_deg: FIELD_OF_VIEW_DEG, width, height }
}

/// Where a body is at the start.
fn points(body: &Drawn) -> Vec<Vector3<f64>> {
    let own: Vec<[f32; 3]> = match &body.look {
        Look::Capture(staged) => staged.splats.positions.clone(),
        Look::Surface(samples) => samples.iter().map(|s| s.position).collect(),
        Look::Cloth(cloth) => cloth.rest.iter().map(|p| p.map(|v| v as f32)).collect(),
        Look::Mesh(mesh, _) => mesh.vertices_m().iter().map(|p| p.map(|v| v as f32)).collect(),
        Look::Dots(..) | Look::Smoke(..) => vec![[0.0; 3]],
    };
    own.into_iter().map(|p| body.pose.point(Vector3::from(p.map(f64::from)))).collect()
}
