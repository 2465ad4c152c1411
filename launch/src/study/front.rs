//! What a given error costs: the Pareto front, and the cheapest run below each of four errors.

use serde::Serialize;

/// Errors that a user may ask for.
pub(crate) const TARGETS: [f64; 4] = [0.1, 0.03, 0.01, 0.001];

/// The cheapest run that is good enough.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Cheapest {
    /// Largest error that is good enough.
    pub(crate) error: f64,
    /// Place of the run among all; none is good enough where it is absent.
    pub(crate) row: Option<usize>,
}

/// Places of the runs that no other run beats in both time and error, the fastest first.
pub(crate) fn pareto(costs: &[Option<(f64, f64)>]) -> Vec<usize> {
    let mut places: Vec<usize> = (0..costs.len()).filter(|&i| costs[i].is_some()).collect();
    places.sort_by(|&a, &b| {
        let [a, b] = [a, b].map(|i| costs[i].unwrap_or_default());
        a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    let mut best = f64::INFINITY;
    places.retain(|&i| {
        let error = costs[i].map_or(f64::INFINITY, |c| c.1);
        let is_better = error < best;
        best = best.min(error);
        is_better
    });
    places
}

/// The cheapest run for each of [`TARGETS`].
pub(crate) fn cheapest(costs: &[Option<(f64, f64)>]) -> Vec<Cheapest> {
    let front = pareto(costs);
    let reaches = |error: f64| move |&i: &usize| costs[i].is_some_and(|c| c.1 <= error);
    TARGETS.map(|error| Cheapest { error, row: front.iter().copied().find(reaches(error)) }).to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_nothing_beats_is_on_the_front() {
        let costs =
            [Some((1.0, 0.2)), Some((2.0, 0.05)), Some((3.0, 0.06)), None, Some((4.0, 0.005)), Some((1.0, 0.3))];
        assert_eq!(pareto(&costs), [0, 1, 4]);
        let rows: Vec<_> = cheapest(&costs).into_iter().map(|c| c.row).collect();
        assert_eq!(rows, [Some(1), Some(4), Some(4), None]);
    }
}
