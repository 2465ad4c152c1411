//! The plane on which a capture stands.

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;
use thiserror::Error;

use crate::linalg::{svd, wide};
use crate::splats::Splats;

/// Gaussians that make a ground at least.
const LEAST: usize = 100;
/// Planes through three Gaussians that are tried.
const TRIES: u64 = 2000;
/// Gaussians by which each of them is judged, at most.
const JUDGES: usize = 4000;
/// Fits to what lies near the plane.
const FITS: usize = 5;
/// Part of the surface that lies near a ground at least: an even box has twice the tolerance, 4 %, along each axis.
const GROUND: f64 = 0.1;
/// Part of the surface that lies below it at most: what lies in a pot or on a table is no ground.
const BELOW: f64 = 0.2;

/// How a ground is looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Gaussians more transparent than this are no ground.
    pub opacity: f64,
    /// What is nearer to the plane than this part of the diagonal lies in it.
    pub tolerance: f64,
    /// Which way is up, roughly; without it the side on which more lies.
    pub up: Option<[f64; 3]>,
    /// How far the ground may be tilted against `up` \[°\].
    pub tilt_deg: f64,
    /// Of the planes that are tried.
    pub seed: u64,
}

impl Default for Settings {
    fn default() -> Settings {
        Settings { opacity: 0.3, tolerance: 0.01, up: None, tilt_deg: 30.0, seed: 1 }
    }
}

/// A plane n · x = `height`, in units of the splats.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// Unit normal n, up.
    pub normal: [f64; 3],
    /// Of the plane along the normal.
    pub height: f64,
    /// Part of the surface, by opacity and area, that lies in the plane.
    pub share: f64,
    /// Part of the rest that is above; 1 where there is no rest.
    pub above: f64,
    /// Root mean square of the distance of what lies in it.
    pub roughness: f64,
}

/// No ground.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum GroundError {
    /// Nothing to stand on.
    #[error("{0} Gaussians are opaque enough to be a ground and {LEAST} are needed; lower the least opacity")]
    TooFew(usize),
    /// The up axis has no direction.
    #[error("the up axis must be a finite vector other than zero, the tolerance and the tilt positive numbers")]
    Settings,
    /// No plane holds enough, or what it holds is not below the rest.
    #[error(
        "the plane that holds most has {:.1} % of the surface in it and {:.1} % below; a ground has at least {:.0} % and at \
         most {:.0} %",
        100.0 * .0, 100.0 * .1, 100.0 * GROUND, 100.0 * BELOW
    )]
    None(f64, f64),
}

/// A place with the opacity and the area of its Gaussian.
type Place = (Vector3<f64>, f64);

/// Finds the plane that holds most of the surface: by random sample consensus (Fischler & Bolles 1981), each Gaussian
/// weighing its opacity times its largest face, then by least squares over what lies in it.
///
/// # Errors
/// [`GroundError`].
pub fn ground(splats: &Splats, settings: &Settings) -> Result<Ground, GroundError> {
    let up = match settings.up.map(|up| Vector3::from(up).try_normalize(0.0)) {
        Some(up) => Some(up.filter(|u| u.iter().all(|v| v.is_finite())).ok_or(GroundError::Settings)?),
        None => None,
    };
    if [settings.tolerance, settings.tilt_deg].iter().any(|v| !(v.is_finite() && *v > 0.0)) {
        return Err(GroundError::Settings);
    }
    let places = surface(splats, settings.opacity);
    if places.len() < LEAST {
        return Err(GroundError::TooFew(places.len()));
    }
    let ends = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
    let (lower, upper) = places.iter().fold(ends, |(l, u), (p, _)| (l.inf(p), u.sup(p)));
    let near = settings.tolerance * (upper - lower).norm();
    let steep = settings.tilt_deg.to_radians().cos();
    let allowed = |n: &Vector3<f64>| up.is_none_or(|up| n.dot(&up).abs() >= steep);
    let mut best = (0.0, Vector3::z(), 0.0);
    let judges: Vec<&Place> = places.iter().step_by(places.len().div_ceil(JUDGES)).collect();
    let judged = |number: u64| {
        let (n, height) = through(&places, settings.seed, number).filter(|(n, _)| allowed(n))?;
        let inside = judges.iter().filter(|(p, _)| (n.dot(p) - height).abs() <= near);
        Some((inside.map(|(_, w)| w).sum::<f64>(), n, height))
    };
    let all: Vec<_> = (0..TRIES).into_par_iter().map(judged).collect();
    // The first of equals.
    for found in all.into_iter().flatten() {
        best = if found.0 > best.0 { found } else { best };
    }
    let (_, mut normal, mut height) = best;
    for _ in 0..FITS {
        let Some((n, h)) = fit(&places, normal, height, near).filter(|(n, _)| allowed(n)) else { break };
        (normal, height) = (n, h);
    }
    let mut found = measured(&places, normal, height, near);
    if up.map_or(found.above < 0.5, |up| normal.dot(&up) < 0.0) {
        found = measured(&places, -normal, -height, near);
    }
    let below = (1.0 - found.share) * (1.0 - found.above);
    let enough = found.share >= GROUND && below <= BELOW;
    if enough { Ok(found) } else { Err(GroundError::None(found.share, below)) }
}

/// Opaque Gaussians with what they weigh.
fn surface(splats: &Splats, opacity: f64) -> Vec<Place> {
    let of = |i: usize| {
        let [a, b, c] = splats.scales(i);
        let weight = splats.opacity(i) * (a * b).max(b * c).max(a * c);
        let p = wide(splats.positions[i]);
        let counts = splats.opacity(i) >= opacity && weight.is_finite() && weight > 0.0;
        (counts && p.iter().all(|v| v.is_finite())).then_some((p, weight))
    };
    let mut places: Vec<Place> = (0..splats.len()).filter_map(of).collect();
    // Blobs of haze would outweigh everything: none counts for more than a hundred usual ones.
    let mut weights: Vec<f64> = places.iter().map(|p| p.1).collect();
    weights.sort_by(f64::total_cmp);
    let most = weights.get(weights.len() / 2).map_or(0.0, |median| 100.0 * median);
    for place in &mut places {
        place.1 = place.1.min(most);
    }
    places
}

/// The plane through three places chosen by a number.
fn through(places: &[Place], seed: u64, number: u64) -> Option<(Vector3<f64>, f64)> {
    let [a, b, c] = [0, 1, 2].map(|k| places[(random(seed, 3 * number + k) % places.len() as u64) as usize].0);
    let normal = (b - a).cross(&(c - a)).try_normalize(1e-300)?;
    Some((normal, normal.dot(&a)))
}

/// Least squares over what is near: the direction in which it spreads least.
fn fit(places: &[Place], normal: Vector3<f64>, height: f64, near: f64) -> Option<(Vector3<f64>, f64)> {
    let inside = || places.iter().filter(|(p, _)| (normal.dot(p) - height).abs() <= near);
    let total: f64 = inside().map(|(_, w)| w).sum();
    let mean = inside().map(|(p, w)| p * *w).sum::<Vector3<f64>>() / total;
    let spread: Matrix3<f64> = inside().map(|(p, w)| (p - mean) * (p - mean).transpose() * *w).sum();
    if !(total > 0.0 && spread.iter().all(|v| v.is_finite())) {
        return None;
    }
    let parts = svd(&spread);
    let n = parts.u.column(Vector3::from(parts.s).imin()).into_owned();
    let n = if n.dot(&normal) < 0.0 { -n } else { n };
    Some((n, n.dot(&mean)))
}

fn measured(places: &[Place], normal: Vector3<f64>, height: f64, near: f64) -> Ground {
    let (mut inside, mut above, mut below, mut squares) = (0.0, 0.0, 0.0, 0.0);
    for (p, weight) in places {
        let d = normal.dot(p) - height;
        if d.abs() <= near {
            (inside, squares) = (inside + weight, squares + weight * d * d);
        } else if d > 0.0 {
            above += weight;
        } else {
            below += weight;
        }
    }
    let part = |a: f64, b: f64| if b > 0.0 { a / b } else { 0.0 };
    Ground {
        normal: normal.into(),
        height,
        share: part(inside, inside + above + below),
        above: if below > 0.0 { part(above, above + below) } else { 1.0 },
        roughness: part(squares, inside).sqrt(),
    }
}

/// `SplitMix64` (Steele, Lea, Flood 2014) at a place of its sequence.
fn random(seed: u64, number: u64) -> u64 {
    let mut z = seed.wrapping_add(number.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ground of 60 × 60 and a ball of 1500 on it, turned and moved.
    fn scene(turn: &Matrix3<f64>) -> Splats {
        let jitter = |i: u64| (random(7, i) >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
        let flat = (0..3600)
            .map(|i| Vector3::new((i % 60) as f64 / 30.0 - 1.0, (i / 60) as f64 / 30.0 - 1.0, 0.004 * jitter(i)));
        let ball = (0..1500).map(|i| {
            let z = 2.0 * jitter(2 * i + 9000);
            let (s, c) = (7.0 * jitter(2 * i + 9001)).sin_cos();
            let r = (1.0 - z * z).sqrt();
            Vector3::new(r * c, r * s, z + 1.0) * 0.4
        });
        let places = flat.chain(ball).map(|p| turn * p + Vector3::new(3.0, -2.0, 5.0));
        let positions: Vec<[f32; 3]> = places.map(|p| p.map(|v| v as f32).into()).collect();
        let n = positions.len();
        let (log_scales, opacity_logits) = (vec![[-4.0, -4.0, -6.0]; n], vec![2.0; n]);
        Splats {
            positions,
            log_scales,
            opacity_logits,
            rotations: vec![[1.0, 0.0, 0.0, 0.0]; n],
            sh_dc: vec![[0.0; 3]; n],
            ..Splats::default()
        }
    }

    #[test]
    fn the_ground_is_found_and_up_is_where_things_stand() {
        for angles in [[0.0; 3], [0.3, 0.2, 1.0], [2.0, -1.0, 0.5]] {
            let turn = nalgebra::Rotation3::from_euler_angles(angles[0], angles[1], angles[2]).into_inner();
            let up = turn.column(2).into_owned();
            let splats = scene(&turn);
            let found = ground(&splats, &Settings::default()).unwrap();
            // A roughness of 0.004/√12 over 3600 places on a side of 2 leaves the normal within 10⁻⁴; the ball's foot,
            // within the tolerance of 0.03, pulls the fit by a little more.
            assert!(Vector3::from(found.normal).dot(&up) > 1.0 - 1e-5, "{found:?}");
            assert!((found.height - up.dot(&Vector3::new(3.0, -2.0, 5.0))).abs() < 2e-3, "{found:?}");
            assert!(found.share > 0.6 && found.above > 0.99 && found.roughness < 0.01, "{found:?}");
            // Stated the other way round, everything hangs below it, so it is none.
            let below = Settings { up: Some((-up).into()), ..Settings::default() };
            assert!(
                matches!(ground(&splats, &below), Err(GroundError::None(share, below)) if share > 0.6 && below > 0.25)
            );
            // And not one that is tilted too far.
            let across = Settings { up: Some(turn.column(0).into_owned().into()), ..Settings::default() };
            assert!(matches!(ground(&splats, &across), Err(GroundError::None(..))), "{:?}", ground(&splats, &across));
        }
    }

    #[test]
    fn what_has_no_ground_says_so() {
        let mut splats = scene(&Matrix3::identity());
        assert_eq!(ground(&Splats::default(), &Settings::default()), Err(GroundError::TooFew(0)));
        let wrong = Settings { up: Some([0.0; 3]), ..Settings::default() };
        assert_eq!(ground(&splats, &wrong), Err(GroundError::Settings));
        // A bare ground is one.
        let bare: Vec<u32> = (0..3600).collect();
        assert!(ground(&splats.select(&bare), &Settings::default()).is_ok_and(|g| g.share > 0.99));
        let ball: Vec<u32> = (3600..5100).collect();
        splats = splats.select(&ball);
        assert!(matches!(ground(&splats, &Settings::default()), Err(GroundError::None(..))));
        splats.positions.fill([1.0; 3]);
        assert!(ground(&splats, &Settings::default()).is_err());
    }
}
