//! Where pictures are taken from.

use cosplat_core::scene::{OutputSpec, Scene};
use cosplat_viewer::Camera;
use nalgebra::Vector3;

use crate::frames::{Drawn, Look};

/// From where a scene without a camera is looked at: the front, a little from the right and above.
const FROM: [f64; 3] = [0.45, -1.0, 0.35];
const FIELD_OF_VIEW_DEG: f64 = 40.0;
const SIZE_PX: [usize; 2] = [960, 540];
/// Room around what is drawn.
const MARGIN: f64 = 1.15;

/// The camera of a scene, or one that sees all that is drawn at the start.
pub(super) fn camera(scene: &Scene, drawn: &[Drawn]) -> Camera {
    let OutputSpec { camera, .. } = &scene.output;
    if let Some(c) = camera {
        let [width, height] = c.size_px.map(|n| n as usize);
        return Camera { eye: c.eye_m, target: c.target_m, up: c.up, fov_y_deg: c.field_of_view_deg, width, height };
    }
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
    let [width, height] = SIZE_PX;
    Camera { eye: eye.into(), target: target.into(), up: [0.0, 0.0, 1.0], fov_y_deg: FIELD_OF_VIEW_DEG, width, height }
}

/// Where a body is at the start.
fn points(body: &Drawn) -> Vec<Vector3<f64>> {
    let own: Vec<[f32; 3]> = match &body.look {
        Look::Capture(staged) => staged.splats.positions.clone(),
        Look::Surface(samples) => samples.iter().map(|s| s.position).collect(),
        Look::Dots(..) => vec![[0.0; 3]],
    };
    own.into_iter().map(|p| body.pose.point(Vector3::from(p.map(f64::from)))).collect()
}
