//! Numbers about a set of Gaussians.

use cosplat_splat::Splats;
use serde::Serialize;

/// Gaussians at least this opaque count as visible where an extent is asked for; haze and floaters lie below.
pub(crate) const VISIBLE: f64 = 0.1;

/// Lower and upper corner of a box along the axes of the file, in its units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Extent {
    /// Lower corner.
    pub(crate) low: [f64; 3],
    /// Upper corner.
    pub(crate) high: [f64; 3],
}

impl Extent {
    /// The box of the centres of Gaussians for which `which` holds; nothing if there is none.
    pub(crate) fn of(splats: &Splats, which: impl Fn(usize) -> bool) -> Option<Self> {
        let mut found: Option<Self> = None;
        for (i, position) in splats.positions.iter().enumerate() {
            let p = position.map(f64::from);
            if p.iter().all(|v| v.is_finite()) && which(i) {
                let Self { low, high } = found.unwrap_or(Self { low: p, high: p });
                let corner = |of: [f64; 3], pick: fn(f64, f64) -> f64| [0, 1, 2].map(|k| pick(of[k], p[k]));
                found = Some(Self { low: corner(low, f64::min), high: corner(high, f64::max) });
            }
        }
        found
    }

    /// The box of the centres that can be seen; of all of them if none can.
    pub(crate) fn visible(splats: &Splats) -> Option<Self> {
        Self::of(splats, |i| splats.opacity(i) >= VISIBLE).or_else(|| Self::of(splats, |_| true))
    }

    /// Edges.
    pub(crate) fn size(&self) -> [f64; 3] {
        [0, 1, 2].map(|k| self.high[k] - self.low[k])
    }

    /// Longest edge.
    pub(crate) fn longest(&self) -> f64 {
        self.size().into_iter().fold(0.0, f64::max)
    }

    /// Middle.
    pub(crate) fn centre(&self) -> [f64; 3] {
        [0, 1, 2].map(|k| f64::midpoint(self.low[k], self.high[k]))
    }
}

/// How numbers are spread: order statistics, by nearest rank.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(crate) struct Spread {
    /// Smallest.
    pub(crate) min: f64,
    /// One of a hundred is smaller.
    pub(crate) p01: f64,
    /// Half are smaller.
    pub(crate) median: f64,
    /// One of a hundred is larger.
    pub(crate) p99: f64,
    /// Largest.
    pub(crate) max: f64,
}

impl Spread {
    /// Of all numbers that are some; zeros if there is none.
    pub(crate) fn of(numbers: impl Iterator<Item = f64>) -> Self {
        let mut sorted: Vec<f64> = numbers.filter(|v| v.is_finite()).collect();
        sorted.sort_unstable_by(f64::total_cmp);
        let Some(last) = sorted.len().checked_sub(1) else { return Self::default() };
        let at = |share: f64| sorted[(share * last as f64).round() as usize];
        Self { min: at(0.0), p01: at(0.01), median: at(0.5), p99: at(0.99), max: at(1.0) }
    }
}

/// Everything at once.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Statistics {
    /// Box of all centres; absent where no centre is finite.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) extent: Option<Extent>,
    /// Box of the centres of opacity ≥ [`VISIBLE`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) visible_extent: Option<Extent>,
    /// Gaussians of opacity ≥ [`VISIBLE`].
    pub(crate) visible: usize,
    /// Gaussians below 1/255, which no picture of eight bits shows.
    pub(crate) invisible: usize,
    /// Opacities, 0 to 1.
    pub(crate) opacity: Spread,
    /// Largest standard deviation of each Gaussian, in units of the file.
    pub(crate) sigma: Spread,
    /// Largest over smallest standard deviation of each.
    pub(crate) flatness: Spread,
    /// Gaussians with a number that is none.
    pub(crate) not_finite: usize,
    /// Gaussians whose quaternion is zero.
    pub(crate) without_rotation: usize,
}

impl Statistics {
    /// Goes through all Gaussians.
    pub(crate) fn of(splats: &Splats) -> Self {
        let opacity = || (0..splats.len()).map(|i| splats.opacity(i));
        let pick = |i: usize, pick: fn(f64, f64) -> f64| splats.scales(i).into_iter().reduce(pick).unwrap_or(f64::NAN);
        let largest = |i: usize| pick(i, f64::max);
        let rules = cosplat_splat::clean::Rules { opacity: 0.0, inside: None, largest_sigma: None };
        let (_, report) = cosplat_splat::clean::clean(splats, &rules);
        Self {
            extent: Extent::of(splats, |_| true),
            visible_extent: Extent::of(splats, |i| splats.opacity(i) >= VISIBLE),
            visible: opacity().filter(|a| *a >= VISIBLE).count(),
            invisible: opacity().filter(|a| *a < 1.0 / 255.0).count(),
            opacity: Spread::of(opacity()),
            sigma: Spread::of((0..splats.len()).map(largest)),
            flatness: Spread::of((0..splats.len()).map(|i| largest(i) / pick(i, f64::min))),
            not_finite: report.non_finite,
            without_rotation: report.zero_rotation,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn three() -> Splats {
        Splats {
            positions: vec![[0.0, 1.0, 2.0], [4.0, -1.0, 2.0], [f32::NAN, 0.0, 9.0]],
            rotations: vec![[1.0, 0.0, 0.0, 0.0], [0.0; 4], [1.0; 4]],
            log_scales: vec![[0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0; 3]],
            opacity_logits: vec![0.0, -4.0, 3.0],
            sh_dc: vec![[0.0; 3]; 3],
            ..Splats::default()
        }
    }

    #[test]
    fn order_statistics_are_numbers_that_were_there() {
        let spread = Spread::of((0..=100).rev().map(f64::from).chain([f64::NAN]));
        assert_eq!(spread, Spread { min: 0.0, p01: 1.0, median: 50.0, p99: 99.0, max: 100.0 });
        assert_eq!(Spread::of(std::iter::empty()), Spread::default());
    }

    #[test]
    fn what_is_no_number_is_counted_and_left_out() {
        let statistics = Statistics::of(&three());
        assert_eq!((statistics.not_finite, statistics.without_rotation, statistics.visible), (1, 1, 2));
        assert_eq!(statistics.extent, Some(Extent { low: [0.0, -1.0, 2.0], high: [4.0, 1.0, 2.0] }));
        assert_eq!(statistics.visible_extent.map(|e| e.longest()), Some(0.0), "only the first can be seen and placed");
        assert!(
            (statistics.sigma.max - 1.0_f64.exp()).abs() < 1e-6
                && (statistics.flatness.max - 1.0_f64.exp()).abs() < 1e-6
        );
        assert_eq!(Extent::of(&Splats::default(), |_| true), None);
    }
}
