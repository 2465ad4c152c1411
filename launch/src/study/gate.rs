//! Whether what must hold holds.

use super::case::{Claim, Gate, Quantity};
use super::order;
use super::result::{Group, Judged, Row};

/// Judges a gate.
pub(crate) fn judge(gate: &Gate, quantities: &[Quantity], rows: &[Row], groups: &[Group]) -> Judged {
    let column = gate.quantity.as_ref().and_then(|name| quantities.iter().position(|q| q.name == *name));
    let error = |row: &Row| match column {
        Some(i) => row.errors.get(i).copied().flatten(),
        None => row.error,
    };
    let meant = |row: &Row| gate.r#where.iter().all(|wanted| row.settings.contains(wanted));
    let chosen: Vec<&Row> = rows.iter().filter(|row| meant(row)).collect();
    let (passed, measured) = if chosen.is_empty() {
        (None, "no run was made that it is about".to_owned())
    } else {
        match gate.claim {
            Claim::Error(limit) => error_below(limit, &chosen, error),
            Claim::Outcome(class) => {
                let others: Vec<&&Row> = chosen.iter().filter(|row| row.outcome != Some(class)).collect();
                let word = |row: &&Row| row.outcome.map_or("", super::outcome::Class::word);
                match others.first() {
                    None => (Some(true), format!("{} of {} runs", chosen.len(), chosen.len())),
                    Some(row) => (Some(false), format!("{}: {}", row.name(), word(row))),
                }
            }
            Claim::Order(range) | Claim::Decay(range) => {
                let groups = groups.iter().filter(|g| g.rows.iter().any(|&i| meant(&rows[i])));
                let fit = if matches!(gate.claim, Claim::Order(_)) { an_order } else { a_decay };
                within(range, fit, groups, rows, error)
            }
        }
    };
    Judged { gate: gate.clone(), passed, measured }
}

fn error_below(limit: f64, rows: &[&Row], error: impl Fn(&Row) -> Option<f64>) -> (Option<bool>, String) {
    if let Some(row) = rows.iter().find(|row| error(row).is_none()) {
        let why = row.why.clone().unwrap_or_else(|| "it has nothing to compare".into());
        return (Some(false), format!("{} has no error: {why}", row.name()));
    }
    let worst = rows.iter().filter_map(|row| error(row)).fold(0.0, f64::max);
    (Some(worst <= limit), format!("{worst:.4e}"))
}

/// What is fitted along the axis, and in words; none where there are too few levels.
type Fitted = Option<(f64, String)>;

fn an_order(levels: &[(f64, f64)]) -> Fitted {
    let fit = order::fit(levels).filter(|fit| fit.levels == levels.len())?;
    Some(match fit.plus_minus {
        Some(interval) => (fit.order, format!("{:.3} ± {interval:.3}", fit.order)),
        None => (fit.order, format!("{:.3}", fit.order)),
    })
}

fn a_decay(levels: &[(f64, f64)]) -> Fitted {
    order::decay(levels).map(|factor| (factor, format!("{factor:.6} per unit")))
}

fn within<'a>(
    [least, most]: [f64; 2],
    fit: impl Fn(&[(f64, f64)]) -> Fitted,
    groups: impl Iterator<Item = &'a Group>,
    rows: &[Row],
    error: impl Fn(&Row) -> Option<f64>,
) -> (Option<bool>, String) {
    let (mut passed, mut measured) = (true, Vec::new());
    for group in groups {
        let levels: Vec<_> = group.rows.iter().filter_map(|&i| Some((rows[i].axis?, error(&rows[i])?))).collect();
        // A level without an error would be the one that spoils the fit.
        let fit = fit(&levels).filter(|_| levels.len() == group.rows.len());
        passed &= fit.as_ref().is_some_and(|(value, _)| (least..=most).contains(value));
        measured.push(match fit {
            None => format!("only {} of {} runs can be fitted", levels.len(), group.rows.len()),
            Some((_, words)) => words,
        });
    }
    (Some(passed && !measured.is_empty()), measured.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::outcome::Class;

    fn row(window: f64, error: Option<f64>) -> Row {
        Row {
            settings: vec![("clock.window".into(), window.to_string())],
            axis: Some(window),
            error,
            outcome: Some(if error.is_some() { Class::Correct } else { Class::Refused }),
            ..Row::default()
        }
    }

    fn judged(place: &[(&str, &str)], claim: Claim, rows: &[Row]) -> Judged {
        let place = place.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect();
        let gate = Gate { name: None, r#where: place, quantity: None, claim, reason: "a test".into(), explained: None };
        let groups = [Group { name: String::new(), rows: (0..rows.len()).collect(), fit: None }];
        judge(&gate, &[], rows, &groups)
    }

    #[test]
    fn gates_hold_or_not_and_say_what_was_measured() {
        let rows = [row(0.1, Some(0.04)), row(0.05, Some(0.01)), row(0.025, Some(0.0025))];
        let passed = |place: &[(&str, &str)], claim| judged(place, claim, &rows).passed;
        assert_eq!(passed(&[], Claim::Order([1.9, 2.1])), Some(true));
        assert_eq!(passed(&[], Claim::Order([0.9, 1.1])), Some(false));
        assert_eq!(passed(&[("clock.window", "0.05")], Claim::Error(0.02)), Some(true));
        assert_eq!(passed(&[], Claim::Error(0.02)), Some(false));
        assert_eq!(passed(&[("clock.window", "7")], Claim::Error(0.02)), None);
        assert_eq!(passed(&[], Claim::Outcome(Class::Correct)), Some(true));
        assert!(judged(&[], Claim::Order([1.9, 2.1]), &rows).measured.starts_with("2.000"));
    }

    #[test]
    fn a_decay_is_a_factor_per_unit_of_the_axis() {
        let rows = [100.0, 200.0, 300.0].map(|sweeps| row(sweeps, Some(0.3 * 0.99_f64.powf(sweeps))));
        assert_eq!(judged(&[], Claim::Decay([0.989_99, 0.990_01]), &rows).passed, Some(true));
        assert_eq!(judged(&[], Claim::Decay([0.991, 0.992]), &rows).passed, Some(false));
        assert_eq!(judged(&[], Claim::Decay([0.98, 1.0]), &rows[..1]).passed, Some(false));
    }

    #[test]
    fn a_run_without_a_result_holds_no_gate() {
        let rows = [row(0.1, Some(0.04)), row(0.05, None), row(0.025, Some(0.0025))];
        assert_eq!(judged(&[], Claim::Order([1.9, 2.1]), &rows).passed, Some(false));
        assert_eq!(judged(&[], Claim::Error(1.0), &rows).passed, Some(false));
        assert_eq!(judged(&[("clock.window", "0.05")], Claim::Outcome(Class::Refused), &rows).passed, Some(true));
    }
}
