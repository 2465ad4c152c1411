//! What the numbers of a file suggest: activations that were applied already, and which way is up.
//!
//! None of this changes how a file is read; it is said, and the user decides.

use cosplat_splat::Splats;
use serde::Serialize;

use super::statistics::{Extent, Statistics};

/// Slabs into which an extent is cut to look for a ground.
const SLABS: usize = 50;
/// Part of the surface that lies in two neighbouring slabs before they count as ground. An even box has 4 %.
const GROUND: f64 = 0.2;
/// How much more a ground holds than the densest slabs across the other two axes.
const CONTRAST: f64 = 1.5;
/// Fewer Gaussians show no ground.
const LEAST: usize = 100;
/// Nearly all logits and coefficients of a trained scene lie within this: 1 / (1 + e⁻¹⁶) is 1 to seven digits.
const BEYOND: f32 = 16.0;
/// Opacity from which a Gaussian counts as surface.
const SURFACE: f64 = 0.3;

/// Which way is up.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Up {
    /// By the convention of the format; absent where there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) convention: Option<&'static str>,
    /// Away from what looks like a ground; absent where nothing does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) from_ground: Option<&'static str>,
    /// What a comment of the file says.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) comment: Option<String>,
}

impl Up {
    /// Of a decoded file.
    pub(crate) fn of(splats: &Splats, notes: &[String]) -> Self {
        let says = |note: &&String| note.to_lowercase().contains("vertical axis");
        Self {
            convention: splats.axes.up(),
            from_ground: away_from_ground(splats),
            comment: notes.iter().find(says).cloned(),
        }
    }

    /// One line for people.
    pub(crate) fn line(&self) -> String {
        let line = match (self.convention, self.from_ground) {
            (Some(up), Some(ground)) if up == ground => {
                format!("{up} by convention, and away from what looks like a ground")
            }
            (Some(up), Some(ground)) => {
                format!("{up} by convention, but {ground} points away from what looks like a ground: draw it and look")
            }
            (Some(up), None) => format!("{up} by convention; no ground was found that could confirm it"),
            (None, Some(ground)) => format!("{ground}, away from what looks like a ground"),
            (None, None) => "unknown: draw it and look".to_owned(),
        };
        match &self.comment {
            Some(comment) => format!("{line}; a {comment}, which writers mean with either sign"),
            None => line,
        }
    }
}

/// The direction away from a thin layer at one end of the object that holds much of its surface.
fn away_from_ground(splats: &Splats) -> Option<&'static str> {
    let surface = |i: usize| splats.opacity(i) >= SURFACE;
    if (0..splats.len()).filter(|&i| surface(i)).count() < LEAST {
        return None;
    }
    let extent = Extent::of(splats, surface)?;
    let mut slabs = [[0.0_f64; SLABS]; 3];
    for i in (0..splats.len()).filter(|&i| surface(i)) {
        let [a, b, c] = splats.scales(i);
        // The largest face of the ellipsoid.
        let area = (a * b).max(b * c).max(a * c);
        let weight = splats.opacity(i) * area;
        for (k, slabs) in slabs.iter_mut().enumerate() {
            let t = (f64::from(splats.positions[i][k]) - extent.low[k]) / extent.size()[k].max(f64::MIN_POSITIVE);
            if weight.is_finite() && t.is_finite() {
                slabs[((t * SLABS as f64) as usize).min(SLABS - 1)] += weight;
            }
        }
    }
    let densest = slabs.map(|slabs| {
        let total: f64 = slabs.iter().sum();
        let pairs = slabs.windows(2).map(|pair| (pair[0] + pair[1]) / total.max(f64::MIN_POSITIVE)).enumerate();
        pairs.fold((0, 0.0), |best, pair| if pair.1 > best.1 { pair } else { best })
    });
    let axis = (1..3).fold(0, |best, k| if densest[k].1 > densest[best].1 { k } else { best });
    let (slab, share) = densest[axis];
    let others = (0..3).filter(|&k| k != axis).map(|k| densest[k].1).fold(0.0, f64::max);
    if share < GROUND || share < CONTRAST * others {
        return None;
    }
    match slab {
        0..16 => Some(["+x", "+y", "+z"][axis]),
        34.. => Some(["-x", "-y", "-z"][axis]),
        _ => None,
    }
}

/// What looks as if an activation had been applied before the file was written. Only formats that store the numbers
/// themselves can show it.
pub(crate) fn suspicions(splats: &Splats, statistics: &Statistics, format: &str) -> Vec<String> {
    let mut found = Vec::new();
    if format != "ply" || splats.is_empty() {
        return found;
    }
    let all =
        |test: fn(f32) -> bool, numbers: &mut dyn Iterator<Item = f32>| numbers.filter(|v| v.is_finite()).all(test);
    if all(|v| v > 0.0, &mut splats.log_scales.iter().flatten().copied()) {
        let sigma = statistics.sigma.median;
        found.push(format!(
            "every stored scale is positive: read as logarithms they make Gaussians of {sigma:.3} units; they may be linear \
             lengths, so write the file again with logarithms"
        ));
    }
    if all(|v| (0.0..=1.0).contains(&v), &mut splats.opacity_logits.iter().copied()) {
        found.push(
            "every stored opacity lies in 0 to 1: they may be opacities already and not their logits, so write the file \
             again with logits"
                .to_owned(),
        );
    }
    if all(|v| (0.0..=1.0).contains(&v), &mut splats.sh_dc.iter().flatten().copied()) {
        found.push(
            "every base colour lies in 0 to 1: they may be colours already and not coefficients of spherical harmonics"
                .to_owned(),
        );
    }
    let beyond = |numbers: &mut dyn Iterator<Item = f32>| numbers.filter(|v| v.is_finite() && v.abs() > BEYOND).count();
    let opacities = beyond(&mut splats.opacity_logits.iter().copied());
    if opacities > splats.len() / 100 {
        found.push(format!(
            "{opacities} stored opacities lie beyond -{BEYOND} to {BEYOND}, where a logit is 0 or 1 to seven digits: they may \
             be of 0 to 255 or of another scale"
        ));
    }
    let colours = beyond(&mut splats.sh_dc.iter().flatten().copied());
    if colours > 3 * splats.len() / 100 {
        found.push(format!(
            "{colours} base colours lie beyond -{BEYOND} to {BEYOND}, where 0 to 1 are -1.8 to 1.8: they may be of 0 to 255"
        ));
    }
    let unturned = splats.rotations.iter().filter(|q| q[1..].iter().all(|v| *v == 0.0)).count();
    if unturned == splats.len() && statistics.flatness.median > 1.0 {
        found.push("no Gaussian is turned although they are not round: the rotations may be missing".to_owned());
    }
    let longest = statistics.visible_extent.map_or(0.0, |e| e.longest());
    if longest > 0.0 && statistics.sigma.median > 0.25 * longest {
        found.push(format!(
            "half of the Gaussians are wider than a quarter of the object ({:.3} of {longest:.3} units)",
            statistics.sigma.median
        ));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A flat ground of 20 × 20 Gaussians with a tower of 100 on it, along an axis and a direction.
    fn tower(axis: usize, direction: f32) -> Splats {
        let mut splats = Splats::default();
        let mut push = |along: f32, u: f32, v: f32| {
            let mut p = [0.0; 3];
            (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (direction * along, u, v);
            splats.positions.push(p);
        };
        (0..400).for_each(|i| push(0.0, (i % 20) as f32 / 10.0, (i / 20) as f32 / 10.0));
        (0..100).for_each(|i| push(i as f32 / 50.0, 1.0, 1.0 + (i % 7) as f32 / 20.0));
        let n = splats.positions.len();
        splats.rotations = vec![[1.0, 0.0, 0.0, 0.0]; n];
        splats.log_scales = vec![[-3.0; 3]; n];
        splats.opacity_logits = vec![2.0; n];
        splats.sh_dc = vec![[0.0, 0.5, -0.5]; n];
        splats
    }

    #[test]
    fn up_is_away_from_the_ground() {
        for (axis, names) in [["+x", "-x"], ["+y", "-y"], ["+z", "-z"]].into_iter().enumerate() {
            for (direction, name) in [1.0, -1.0].into_iter().zip(names) {
                assert_eq!(away_from_ground(&tower(axis, direction)), Some(name));
            }
        }
        let mut ball = tower(0, 1.0);
        for (i, p) in ball.positions.iter_mut().enumerate() {
            let t = i as f32 * 2.4;
            *p = [t.cos() * (i as f32 / 500.0), t.sin() * (i as f32 / 500.0), (t * 0.7).sin()];
        }
        assert_eq!(away_from_ground(&ball), None);
        assert_eq!(away_from_ground(&Splats::default()), None);
    }

    #[test]
    fn applied_activations_are_noticed() {
        let good = tower(1, -1.0);
        let none = suspicions(&good, &Statistics::of(&good), "ply");
        assert_eq!(none, Vec::<String>::new());
        let mut bad = good;
        bad.log_scales = vec![[0.05; 3]; bad.len()];
        bad.opacity_logits = vec![0.9; bad.len()];
        bad.sh_dc = vec![[0.2; 3]; bad.len()];
        let found = suspicions(&bad, &Statistics::of(&bad), "ply");
        assert_eq!(found.len(), 4, "{found:?}");
        assert_eq!(suspicions(&bad, &Statistics::of(&bad), "spz"), Vec::<String>::new());
        for i in 0..bad.len() {
            bad.log_scales[i] = [-4.0, -4.0, -5.0];
            bad.opacity_logits[i] = (i % 256) as f32;
            bad.sh_dc[i] = [128.0, 255.0, 0.0];
        }
        let found = suspicions(&bad, &Statistics::of(&bad), "ply").join("\n");
        assert_eq!(found.lines().count(), 3, "{found}");
        for part in ["stored opacities lie beyond -16 to 16", "1000 base colours", "the rotations may be missing"] {
            assert!(found.contains(part), "{found}");
        }
    }

    #[test]
    fn the_line_says_where_it_comes_from() {
        let up = Up::of(&tower(1, -1.0), &["comment: Vertical axis: y".to_owned()]);
        assert_eq!((up.convention, up.from_ground), (Some("-y"), Some("-y")));
        assert!(up.line().starts_with("-y by convention, and away"), "{}", up.line());
        assert!(up.line().contains("Vertical axis: y"), "{}", up.line());
    }
}
