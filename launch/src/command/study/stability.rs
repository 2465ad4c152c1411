//! `cosplat study stability`: a map of what extreme settings do.

use std::fmt::Write as _;

use clap::Args;
use serde::Serialize;

use super::{Output, Pace, VERSION, conditions, conduct_all, machine, recorded, wanted, write};
use crate::exit::{Code, Error};
use crate::page;
use crate::render::{Paint, json, printable, table};
use crate::study::conduct::cores;
use crate::study::result::CaseResult;
use crate::study::stability::{Behaviour, Field, csv, map};
use crate::study::{recording, suite};
use crate::supervise::signals::Signals;

/// One line a run.
const ROWS: &str = "stability.csv";
/// Everything for programs.
const ANSWER: &str = "stability.json";
/// The map for people.
const PAGE: &str = "stability.html";
/// The map for the rerun viewer.
const RECORDING: &str = "stability.rrd";

const EXAMPLES: &str = "\
Examples:
  cosplat study stability --only liquid-of-points";

/// `cosplat study stability`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct StabilityArgs {
    /// Only the cases with these names
    #[arg(long, value_name = "CASE,…", value_delimiter = ',')]
    only: Vec<String>,
    #[command(flatten)]
    pace: Pace,
    #[command(flatten)]
    pub(super) output: Output,
}

/// The result for programs.
#[derive(Debug, Serialize)]
struct Answer<'a> {
    /// Version of this program.
    version: &'a str,
    /// What it ran on.
    machine: &'a str,
    /// Whether no run failed in silence or crashed, and all gates hold.
    passed: bool,
    /// One field a run.
    map: &'a [Field],
    /// Cases with their runs.
    cases: &'a [CaseResult],
}

/// Runs all cases at the edge of what can be computed, and draws the map.
///
/// # Errors
/// A case cannot be used, or a file cannot be written.
pub(super) async fn stability(args: &StabilityArgs, signals: &mut Signals) -> Result<Code, Error> {
    let out = args.output.folder("stability")?;
    let cases = wanted::chosen(wanted::in_folder(&suite::unpack(&out)?.join(suite::STABILITY))?, &args.only)?;
    let conditions = conditions(&out, 1, args.pace.jobs(cores()))?;
    let Some(results) = conduct_all(&cases, conditions, args.output.quiet, signals).await? else {
        return Ok(Code::Interrupted);
    };
    let fields: Vec<Field> = results.iter().flat_map(map).collect();
    let outcomes_hold = results.iter().all(CaseResult::has_its_outcomes);
    let passed = outcomes_hold && fields.iter().all(|field| field.behaviour.is_tolerable());
    let machine = machine();
    let text = json(&Answer { version: VERSION, machine: &machine, passed, map: &fields, cases: &results })?;
    let command: Vec<String> = std::env::args().collect();
    let page =
        page::study::Page { cases: &results, catalogue: &[], command: &command, version: VERSION, machine: &machine };
    write(&out, ROWS, &csv(&fields))?;
    write(&out, ANSWER, &text)?;
    write(&out, PAGE, &page::study::stability(&page, &fields))?;
    recorded(recording::write_map(&out.join(RECORDING), &results, &fields))?;
    let people = human(&results, &fields, Paint::stdout());
    let people = people + &format!("\nwritten to {}\n", Paint::stdout().cyan(&out.join(PAGE).display().to_string()));
    args.output.show(&people, &text)?;
    Ok(if passed { Code::Ok } else { Code::Verdict })
}

/// How many runs of each case behave how, and every run that must not.
fn human(cases: &[CaseResult], fields: &[Field], paint: Paint) -> String {
    let head = ["case", "correct", "degraded", "refused", "silent", "crashed"].map(str::to_owned);
    let mut lines = vec![head.to_vec()];
    lines.extend(cases.iter().map(|case| {
        let count = |how: Behaviour| fields.iter().filter(|f| f.case == case.name && f.behaviour == how).count();
        [case.name.clone()].into_iter().chain(Behaviour::ALL.map(|how| count(how).to_string())).collect()
    }));
    let mut text = format!("{}\n\n", table(paint, &lines));
    for field in fields.iter().filter(|f| !f.behaviour.is_tolerable()) {
        let why = field.broken.iter().chain(&field.says).next().map_or("", String::as_str);
        let line = format!("{} {}: {why}", field.case, field.settings);
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{} {}", paint.bad(&format!("{}:", field.behaviour.word())), printable(&line));
    }
    for (case, judged) in cases.iter().flat_map(|c| c.gates.iter().map(move |j| (c, j))) {
        if judged.is_outcome() && judged.passed == Some(false) {
            let line = format!("{}: {}: {}", case.name, judged.measured, judged.gate.reason);
            let _ = writeln!(text, "{} {}", paint.bad("another outcome:"), printable(&line));
        }
    }
    let good = fields.iter().filter(|f| f.behaviour.is_tolerable()).count();
    let _ = write!(text, "{good} of {} runs are right, say that they are not, or are refused", fields.len());
    text + "\n"
}
