//! Order of convergence, by least squares on the logarithms.

use serde::Serialize;

/// Fewest levels of a fit with an interval: two make a straight line through whatever they are.
const FEWEST: usize = 3;
/// Fewest levels that tell a floor from an order.
const FEWEST_FOR_FLOOR: usize = 4;

/// 97.5 % quantiles of Student's t distribution for 1, 2, … degrees of freedom (any table of it, e.g. NIST/SEMATECH
/// e-Handbook of Statistical Methods, 1.3.6.7.2).
const STUDENT: [f64; 10] = [12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228];
/// The same for very many degrees of freedom.
const NORMAL: f64 = 1.960;

/// `e = C Δ^p`, fitted to levels of refinement.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Fit {
    /// The order `p`.
    pub(crate) order: f64,
    /// Half of the 95 % interval of the order; absent with less than three levels.
    pub(crate) plus_minus: Option<f64>,
    /// `C`, in the unit that makes it fit.
    pub(crate) factor: f64,
    /// Levels that were fitted.
    pub(crate) levels: usize,
    /// With the floor; absent with less than four levels, or where no floor makes the fit better.
    pub(crate) with_floor: Option<Floor>,
}

/// `e = e₀ + C Δ^p`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Floor {
    /// `e₀`: what is left of the error however fine the axis is.
    pub(crate) floor: f64,
    /// The order above it.
    pub(crate) order: f64,
}

/// Fits step sizes and errors; none with less than two levels. Zeros and what is not finite are left out.
pub(crate) fn fit(levels: &[(f64, f64)]) -> Option<Fit> {
    let usable = |&&(step, error): &&(f64, f64)| step > 0.0 && error > 0.0 && step.is_finite() && error.is_finite();
    let levels: Vec<(f64, f64)> = levels.iter().filter(usable).copied().collect();
    let line = Line::through(&levels, 0.0)?;
    let freedom = levels.len().saturating_sub(2);
    let student = STUDENT.get(freedom.wrapping_sub(1)).copied().unwrap_or(NORMAL);
    let deviation = (line.residual / freedom as f64 / line.spread).sqrt();
    Some(Fit {
        order: line.slope,
        plus_minus: (levels.len() >= FEWEST).then_some(student * deviation),
        factor: line.offset.exp(),
        levels: levels.len(),
        with_floor: floor(&levels, &line),
    })
}

/// Factor by which errors change per unit of the axis, `e = C f^x`, by least squares on `log(e)`; none where a level
/// is not positive, or with less than two.
pub(crate) fn decay(levels: &[(f64, f64)]) -> Option<f64> {
    let count = levels.len() as f64;
    let mean = |part: &dyn Fn(&(f64, f64)) -> f64| levels.iter().map(part).sum::<f64>() / count;
    let (x, y) = (mean(&|l| l.0), mean(&|l| l.1.ln()));
    let spread: f64 = levels.iter().map(|l| (l.0 - x).powi(2)).sum();
    let factor = (levels.iter().map(|l| (l.0 - x) * (l.1.ln() - y)).sum::<f64>() / spread).exp();
    (levels.len() > 1 && factor.is_finite() && factor > 0.0).then_some(factor)
}

/// A straight line through logarithms.
struct Line {
    slope: f64,
    offset: f64,
    /// Sum of the squared differences of `log(e)`.
    residual: f64,
    /// Sum of the squared distances of `log(Δ)` from their mean.
    spread: f64,
}

impl Line {
    /// Through the errors above a floor; what is left over is that of the errors themselves.
    fn through(levels: &[(f64, f64)], floor: f64) -> Option<Self> {
        let points: Vec<(f64, f64)> = levels.iter().map(|&(step, e)| (step.ln(), (e - floor).ln())).collect();
        let count = points.len() as f64;
        let mean = |part: fn(&(f64, f64)) -> f64| points.iter().map(part).sum::<f64>() / count;
        let (x, y) = (mean(|p| p.0), mean(|p| p.1));
        let spread: f64 = points.iter().map(|p| (p.0 - x).powi(2)).sum();
        if points.len() < 2 || spread <= 0.0 {
            return None;
        }
        let slope = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum::<f64>() / spread;
        let offset = y - slope * x;
        let model = |step: f64| (floor + (offset + slope * step.ln()).exp()).ln();
        let residual = levels.iter().map(|&(step, error)| (error.ln() - model(step)).powi(2)).sum();
        Some(Self { slope, offset, residual, spread })
    }
}

/// The floor that leaves the least over, by steps of a thousandth of the smallest error.
fn floor(levels: &[(f64, f64)], without: &Line) -> Option<Floor> {
    const STEPS: u32 = 1000;
    if levels.len() < FEWEST_FOR_FLOOR {
        return None;
    }
    let smallest = levels.iter().map(|l| l.1).fold(f64::INFINITY, f64::min);
    let tried = (1..STEPS).filter_map(|i| {
        let floor = smallest * f64::from(i) / f64::from(STEPS);
        Some((floor, Line::through(levels, floor)?))
    });
    let (floor, line) = tried.min_by(|a, b| a.1.residual.total_cmp(&b.1.residual))?;
    // A floor below a tenth of the smallest error, or one that explains less than half of what the straight line
    // leaves over, is noise of the fit.
    let counts = floor > 0.1 * smallest && line.residual < 0.5 * without.residual;
    counts.then_some(Floor { floor, order: line.slope })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn levels(count: i32, error: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
        (0..count).map(|i| 0.1 * 0.5_f64.powi(i)).map(|step| (step, error(step))).collect()
    }

    #[test]
    fn powers_have_their_order() {
        let found = fit(&levels(5, |step| 3.0 * step * step)).unwrap();
        // Logarithms of exact powers: rounding alone.
        assert!((found.order - 2.0).abs() < 1e-12 && (found.factor - 3.0).abs() < 1e-11, "{found:?}");
        assert!(found.plus_minus.unwrap() < 1e-12 && found.with_floor.is_none(), "{found:?}");
        assert_eq!(fit(&levels(2, |step| step)).unwrap().plus_minus, None);
        assert_eq!(fit(&levels(1, |step| step)), None);
        assert_eq!(fit(&[(0.1, 1.0), (0.1, 2.0)]), None);
        assert_eq!(fit(&[(0.2, f64::INFINITY), (0.1, 0.0), (0.05, 1.0)]), None);
    }

    /// Slope and standard error were computed with another program (numpy).
    #[test]
    fn the_interval_is_that_of_a_linear_regression() {
        let found = fit(&[(0.04, 0.41), (0.02, 0.2), (0.01, 0.105), (0.005, 0.05)]).unwrap();
        assert!((found.order - 1.003_648_2).abs() < 1e-6, "{found:?}");
        assert!((found.plus_minus.unwrap() - 4.303 * 0.018_296_1).abs() < 1e-6, "{found:?}");
    }

    #[test]
    fn a_floor_is_found_where_there_is_one() {
        let found = fit(&levels(6, |step| 1e-3 + 2.0 * step * step)).unwrap();
        assert!(found.order < 1.9, "{found:?}");
        let floor = found.with_floor.unwrap();
        // The floor is searched in steps of a thousandth of the smallest error.
        assert!((floor.floor / 1e-3 - 1.0).abs() < 0.01 && (floor.order - 2.0).abs() < 0.02, "{floor:?}");
    }
}
