//! A camera that moves while a run goes on.

use nalgebra::{Rotation3, Unit, Vector3};

use crate::camera::Camera;

/// A place that a moving camera passes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// Moment \[s\].
    pub time_s: f64,
    /// Centre of projection, in scene units.
    pub eye: [f64; 3],
    /// A point on the optical axis.
    pub target: [f64; 3],
}

/// How a camera moves.
#[derive(Clone, Debug, PartialEq)]
pub enum Travel {
    /// Not at all.
    Still,
    /// About its target and its `up`, at a constant rate.
    Orbit {
        /// Angle from the start to the end, counter-clockwise seen from above \[°\].
        degrees: f64,
        /// Duration \[s\]; the camera rests afterwards.
        duration_s: f64,
    },
    /// Through stops in order of time; before the first and after the last it rests.
    Path(Vec<Stop>),
}

/// A camera and how it moves.
#[derive(Clone, Debug, PartialEq)]
pub struct Shot {
    /// The camera at the start; a path brings its own places.
    pub camera: Camera,
    /// How it moves.
    pub travel: Travel,
}

impl Shot {
    /// A camera that stands still.
    pub fn still(camera: Camera) -> Shot {
        Shot { camera, travel: Travel::Still }
    }

    /// The camera at a moment \[s\].
    pub fn at(&self, time_s: f64) -> Camera {
        let camera = self.camera;
        match &self.travel {
            Travel::Still => camera,
            Travel::Orbit { degrees, duration_s } => {
                let part = if *duration_s > 0.0 { (time_s / duration_s).clamp(0.0, 1.0) } else { 0.0 };
                Camera { eye: turned(&camera, degrees * part), ..camera }
            }
            Travel::Path(stops) => {
                let along = |of: fn(&Stop) -> [f64; 3]| on_curve(stops, of, time_s);
                match (along(|s| s.eye), along(|s| s.target)) {
                    (Some(eye), Some(target)) => Camera { eye, target, ..camera },
                    _ => camera,
                }
            }
        }
    }
}

/// Where a camera stands after a turn about its target and its `up` \[°\].
fn turned(camera: &Camera, degrees: f64) -> [f64; 3] {
    let Some(up) = Unit::try_new(Vector3::from(camera.up), 0.0) else { return camera.eye };
    let (eye, target) = (Vector3::from(camera.eye), Vector3::from(camera.target));
    (target + Rotation3::from_axis_angle(&up, degrees.to_radians()) * (eye - target)).into()
}

/// The Catmull–Rom curve through stops with their times as knots (Barry and Goldman 1988), so that the camera's
/// velocity is continuous also where stops are unevenly spaced in time. Between two stops it is the cubic with the slope
/// at each of the parabola through it and its neighbours; at the ends the slope is that of the straight line.
fn on_curve(stops: &[Stop], of: fn(&Stop) -> [f64; 3], time_s: f64) -> Option<[f64; 3]> {
    let point = |i: usize| Vector3::from(of(&stops[i]));
    let last = stops.len().checked_sub(1)?;
    let i = stops.partition_point(|s| s.time_s <= time_s);
    if i == 0 || i > last {
        return Some(point(i.min(last)).into());
    }
    let i = i - 1;
    let step = |k: usize| stops[k + 1].time_s - stops[k].time_s;
    let secant = |k: usize| (point(k + 1) - point(k)) / step(k);
    let slope = |k: usize| {
        if k == 0 {
            secant(0)
        } else if k == last {
            secant(last - 1)
        } else {
            (secant(k - 1) * step(k) + secant(k) * step(k - 1)) / (step(k - 1) + step(k))
        }
    };
    let (h, t) = (step(i), (time_s - stops[i].time_s) / step(i));
    let (t2, t3) = (t * t, t * t * t);
    let ends = point(i) * (2.0 * t3 - 3.0 * t2 + 1.0) + point(i + 1) * (3.0 * t2 - 2.0 * t3);
    Some((ends + (slope(i) * (t3 - 2.0 * t2 + t) + slope(i + 1) * (t3 - t2)) * h).into())
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAMERA: Camera = Camera {
        eye: [2.0, 0.0, 1.0],
        target: [1.0, 0.0, 0.0],
        up: [0.0, 0.0, 2.0],
        fov_y_deg: 40.0,
        width: 8,
        height: 6,
    };

    /// Roundings of numbers of order one.
    fn near(a: [f64; 3], b: [f64; 3]) -> bool {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12)
    }

    #[test]
    fn an_orbit_goes_round_its_target_and_rests() {
        let shot = Shot { camera: CAMERA, travel: Travel::Orbit { degrees: 180.0, duration_s: 2.0 } };
        assert_eq!(shot.at(0.0).target.map(f64::to_bits), CAMERA.target.map(f64::to_bits));
        for (time, eye) in [(-1.0, CAMERA.eye), (1.0, [1.0, 1.0, 1.0]), (2.0, [0.0, 0.0, 1.0]), (9.0, [0.0, 0.0, 1.0])]
        {
            assert!(near(shot.at(time).eye, eye), "{time}: {:?}", shot.at(time).eye);
        }
        assert_eq!(Shot::still(CAMERA).at(1.0), CAMERA);
    }

    #[test]
    fn a_path_passes_its_stops_with_a_continuous_velocity() {
        let stop = |time_s: f64, x: f64, y: f64| Stop { time_s, eye: [x, y, 1.0], target: [0.0, 0.0, x] };
        let stops = vec![stop(1.0, 0.0, 0.0), stop(1.5, 1.0, 2.0), stop(4.0, -2.0, 1.0), stop(5.0, 3.0, 0.0)];
        let shot = Shot { camera: CAMERA, travel: Travel::Path(stops.clone()) };
        for s in &stops {
            assert!(near(shot.at(s.time_s).eye, s.eye) && near(shot.at(s.time_s).target, s.target));
        }
        assert!(near(shot.at(0.0).eye, stops[0].eye) && near(shot.at(9.0).eye, stops[3].eye));
        for s in &stops[1..3] {
            // One-sided differences: their error is half the step times a second derivative of order 40.
            let d = 1e-6;
            let x = |t: f64| shot.at(t).eye[0];
            let (before, after) = ((x(s.time_s) - x(s.time_s - d)) / d, (x(s.time_s + d) - x(s.time_s)) / d);
            assert!((before - after).abs() < 1e-4, "{before} {after}");
        }
        // A straight line at a constant rate is followed exactly, whatever the times.
        let line = [0.0, 0.3, 2.0].map(|t| stop(t, 3.0 * t, -t)).to_vec();
        let shot = Shot { camera: CAMERA, travel: Travel::Path(line) };
        assert!(near(shot.at(1.1).eye, [3.3, -1.1, 1.0]));
    }

    #[test]
    fn a_path_without_stops_is_the_camera_and_one_stop_stands_still() {
        let path = |stops: Vec<Stop>| Shot { camera: CAMERA, travel: Travel::Path(stops) }.at(0.5);
        assert_eq!(path(Vec::new()), CAMERA);
        let one = Stop { time_s: 0.0, eye: [5.0; 3], target: [6.0; 3] };
        assert_eq!(path(vec![one]).eye.map(f64::to_bits), [5.0_f64.to_bits(); 3]);
    }
}
