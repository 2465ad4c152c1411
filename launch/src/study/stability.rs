//! What becomes of extreme settings: every run of a case is right, says itself that it is not, is refused with a reason,
//! or fails in silence. The last must not happen.

use serde::Serialize;

use super::case::Claim;
use super::outcome::Class;
use super::result::{CaseResult, Judged, Row};

/// How a run under extreme settings behaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Behaviour {
    /// Every criterion holds and the run has nothing to say against itself.
    Correct,
    /// The run ended and says itself what is wrong with it, whether or not a criterion is broken.
    Degraded,
    /// It was refused with a reason: before it began, or when the physics left the range of meaning.
    Refused,
    /// A criterion is broken, or no reason is given, and the run says nothing.
    Silent,
    /// A process died or fell silent.
    Crashed,
}

impl Behaviour {
    /// All of them, the best first.
    pub(crate) const ALL: [Self; 5] = [Self::Correct, Self::Degraded, Self::Refused, Self::Silent, Self::Crashed];

    /// Whether a suite may contain it.
    pub(crate) fn is_tolerable(self) -> bool {
        !matches!(self, Self::Silent | Self::Crashed)
    }

    /// As it is called in files and on pages.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Self::Correct => "correct",
            Self::Degraded => "degraded and reported",
            Self::Refused => "refused with a reason",
            Self::Silent => "silent failure",
            Self::Crashed => "crashed",
        }
    }
}

/// One field of the map.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Field {
    /// Case.
    pub(crate) case: String,
    /// What was varied.
    pub(crate) settings: String,
    /// How it behaves.
    pub(crate) behaviour: Behaviour,
    /// Criteria that are broken, with what was measured.
    pub(crate) broken: Vec<String>,
    /// What the run says: the reason why it was refused, and what it reports against itself.
    pub(crate) says: Vec<String>,
    /// Exit code of the run.
    pub(crate) exit_code: u8,
    /// Its folder.
    pub(crate) folder: String,
}

/// The map of a case: one field a run. Its gates on errors are the criteria, each for every run on its own.
pub(crate) fn map(case: &CaseResult) -> Vec<Field> {
    case.rows.iter().map(|row| field(case, row)).collect()
}

fn field(case: &CaseResult, row: &Row) -> Field {
    let has_ended = row.exit_code == 0 || row.exit_code == 7;
    let broken = if has_ended { broken(case, row) } else { Vec::new() };
    let says = row.why.clone().into_iter().chain(row.reported.iter().cloned()).collect();
    let reports = !row.reported.is_empty();
    let behaviour = match row.outcome {
        // A red verdict says so, whatever else is wrong.
        _ if row.exit_code == 7 => Behaviour::Degraded,
        Some(Class::Refused) if row.why.is_some() => Behaviour::Refused,
        // What ended well and left a result that is no number has not noticed.
        Some(Class::Failed) | None if row.exit_code != 0 => Behaviour::Crashed,
        Some(Class::Correct | Class::Degraded) if reports => Behaviour::Degraded,
        Some(Class::Correct | Class::Degraded) if broken.is_empty() => Behaviour::Correct,
        _ => Behaviour::Silent,
    };
    Field {
        case: case.name.clone(),
        settings: row.name(),
        behaviour,
        broken,
        says,
        exit_code: row.exit_code,
        folder: row.folder.clone(),
    }
}

/// Criteria that a run does not meet.
fn broken(case: &CaseResult, row: &Row) -> Vec<String> {
    let criteria = case.gates.iter().filter(|j| j.gate.r#where.iter().all(|wanted| row.settings.contains(wanted)));
    criteria.filter_map(|judged| unmet(case, row, judged)).collect()
}

fn unmet(case: &CaseResult, row: &Row, judged: &Judged) -> Option<String> {
    let Claim::Error(limit) = judged.gate.claim else { return None };
    let name = judged.gate.quantity.as_deref();
    let column = name.and_then(|name| case.quantities.iter().position(|q| q.name == name));
    let error = column.map_or(row.error, |i| row.errors.get(i).copied().flatten());
    let what = name.unwrap_or("error");
    match error {
        Some(error) if error <= limit => None,
        Some(error) => Some(format!("{what} {error:.2e} above {limit:.0e}: {}", judged.gate.reason)),
        None => Some(format!("{what} has no value: {}", judged.gate.reason)),
    }
}

/// The map as a table: one line a run.
pub(crate) fn csv(fields: &[Field]) -> String {
    let mut out = csv::Writer::from_writer(Vec::new());
    // Writing to memory cannot fail.
    let _ = out.write_record(["case", "settings", "behaviour", "exit_code", "broken", "says", "folder"]);
    for field in fields {
        let code = field.exit_code.to_string();
        let broken = field.broken.join("; ");
        let word = field.behaviour.word();
        let says = field.says.join("; ");
        let _ = out.write_record([&field.case, &field.settings, word, &code, &broken, &says, &field.folder]);
    }
    String::from_utf8(out.into_inner().unwrap_or_default()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::case::{Gate, Measure};
    use crate::study::result::Measured;

    fn case(rows: Vec<Row>) -> CaseResult {
        let gate = Gate {
            name: None,
            r#where: Vec::new(),
            quantity: Some("a.x".into()),
            claim: Claim::Error(0.1),
            reason: "it must not leave the box".into(),
            explained: None,
        };
        CaseResult {
            name: "x".into(),
            title: "x".into(),
            scene: "x".into(),
            reference: String::new(),
            quantities: vec![Measured { name: "a.x".into(), measure: Some(Measure::Max), reference: String::new() }],
            vary: Vec::new(),
            rows,
            groups: Vec::new(),
            front: Vec::new(),
            cheapest: Vec::new(),
            gates: vec![Judged { gate, passed: None, measured: String::new() }],
            notes: Vec::new(),
        }
    }

    fn row(outcome: Class, exit_code: u8, error: Option<f64>) -> Row {
        Row { outcome: Some(outcome), exit_code, error, errors: vec![error], ..Row::default() }
    }

    #[test]
    fn every_end_of_a_run_has_its_place_on_the_map() {
        use Behaviour::{Correct, Crashed, Degraded, Refused, Silent};
        let mut refused = row(Class::Refused, 4, None);
        refused.why = Some("the particles run away".into());
        let mut reported = row(Class::Degraded, 0, Some(0.5));
        reported.reported = vec!["mpm: 3 stretch-clamps".into()];
        let rows = vec![
            row(Class::Correct, 0, Some(0.05)),
            reported,
            row(Class::Degraded, 7, Some(0.5)),
            refused,
            row(Class::Correct, 0, Some(0.5)),
            row(Class::Correct, 0, None),
            row(Class::Failed, 0, None),
            row(Class::Refused, 4, None),
            row(Class::Failed, 5, None),
        ];
        let found: Vec<Behaviour> = map(&case(rows)).iter().map(|f| f.behaviour).collect();
        assert_eq!(found, [Correct, Degraded, Degraded, Refused, Silent, Silent, Silent, Silent, Crashed]);
    }

    #[test]
    fn the_map_says_which_criterion_is_broken() {
        let fields = map(&case(vec![row(Class::Correct, 0, Some(0.5))]));
        assert_eq!(fields[0].broken, ["a.x 5.00e-1 above 1e-1: it must not leave the box"]);
        let table = csv(&fields);
        assert!(table.lines().nth(1).is_some_and(|line| line.contains("silent failure")), "{table}");
    }
}
