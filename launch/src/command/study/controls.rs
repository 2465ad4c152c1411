//! `cosplat study negative-controls`: whether the gates notice what is broken on purpose.

use std::fmt::Write as _;

use clap::Args;
use serde::Serialize;

use super::{Output, Pace, VERSION, conditions, conduct_all, machine, write};
use crate::exit::{Code, Error, Problem};
use crate::page;
use crate::render::{Paint, json, printable};
use crate::study::case::Case;
use crate::study::conduct::cores;
use crate::study::control::{Noticed, judge, read};
use crate::study::suite;
use crate::supervise::signals::Signals;

/// Everything for programs.
const ANSWER: &str = "negative-controls.json";
/// Everything for people.
const PAGE: &str = "negative-controls.html";

const EXAMPLES: &str = "\
Examples:
  cosplat study negative-controls --only stale-boundary";

/// `cosplat study negative-controls`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct ControlArgs {
    /// Only the controls with these names
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
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
    /// Whether every gate noticed.
    passed: bool,
    /// The controls.
    controls: &'a [Noticed],
}

/// Runs each case with and without its fault.
///
/// # Errors
/// A control cannot be used, or a file cannot be written.
pub(super) async fn controls(args: &ControlArgs, signals: &mut Signals) -> Result<Code, Error> {
    let out = args.output.folder("negative-controls")?;
    let mut controls = read(&suite::unpack(&out)?.join(suite::CONTROLS))?;
    let unknown = args.only.iter().find(|wanted| controls.iter().all(|control| control.name != **wanted));
    if let Some(unknown) = unknown {
        let names: Vec<&str> = controls.iter().map(|control| control.name.as_str()).collect();
        let problem = Problem::new(format!("There is no control `{unknown}`"));
        return Err(Error::new(Code::Usage, problem.hint(format!("there are {}", names.join(", ")))));
    }
    controls.retain(|control| args.only.is_empty() || args.only.contains(&control.name));
    let conditions = conditions(&out, 1, args.pace.jobs(cores()))?;
    let cases: Vec<Case> = controls.iter().flat_map(|control| [control.case.clone(), control.broken()]).collect();
    let Some(results) = conduct_all(&cases, conditions, args.output.quiet, signals).await? else {
        return Ok(Code::Interrupted);
    };
    let both = controls.iter().zip(results.chunks_exact(2));
    let noticed: Vec<Noticed> = both.filter_map(|(control, both)| judge(control, &both[0], &both[1])).collect();
    let passed = noticed.len() == controls.len() && noticed.iter().all(|n| n.passed);
    let machine = machine();
    let text = json(&Answer { version: VERSION, machine: &machine, passed, controls: &noticed })?;
    let command: Vec<String> = std::env::args().collect();
    let page = page::study::Page { cases: &[], catalogue: &[], command: &command, version: VERSION, machine: &machine };
    write(&out, ANSWER, &text)?;
    write(&out, PAGE, &page::study::controls(&page, &noticed))?;
    let people = human(&noticed, Paint::stdout());
    let people = people + &format!("\nwritten to {}\n", Paint::stdout().cyan(&out.join(PAGE).display().to_string()));
    args.output.show(&people, &text)?;
    Ok(if passed { Code::Ok } else { Code::Verdict })
}

fn human(noticed: &[Noticed], paint: Paint) -> String {
    let mut text = String::new();
    for one in noticed {
        let word = if one.passed { paint.good("noticed:") } else { paint.bad("not noticed:") };
        let line = format!(
            "{}: {} ({}: {} without, {} with the fault)",
            one.name, one.fault, one.case, one.sound.measured, one.broken.measured
        );
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{word} {}", printable(&line));
    }
    text
}
