//! `cosplat study ablation`: what each decision to leave something out changes and saves.

use std::fmt::Write as _;

use clap::Args;
use serde::Serialize;

use super::{Output, Pace, VERSION, conditions, machine, say, write};
use crate::exit::{Code, Error, Problem};
use crate::page;
use crate::render::{Paint, json, printable, table};
use crate::scene_source::{load, parse};
use crate::study::ablation::{Decision, Kept, Worth, case_of, decisions, kept, worth};
use crate::study::case::{Case, Level};
use crate::study::conduct::{Conditions, finish};
use crate::supervise::signals::Signals;

/// Everything for programs.
const ANSWER: &str = "ablation.json";
/// Everything for people.
const PAGE: &str = "ablation.html";

const EXAMPLES: &str = "\
Examples:
  cosplat study ablation oscillator
  cosplat study ablation ball-on-block --set clock.duration=0.05";

/// `cosplat study ablation`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct AblationArgs {
    /// Scene file, or name of a built-in scene
    #[arg(value_name = "SCENE")]
    scene: String,
    /// Change a value of the scene; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Repetitions of each run: the median of their times counts
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=100))]
    runs: u8,
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
    /// Whether nothing changed that was not allowed to.
    passed: bool,
    /// The decisions.
    decisions: &'a [Worth],
    /// What could be left out and is not.
    kept: &'a [Kept],
}

/// Runs a scene with each decision the other way round.
///
/// # Errors
/// The scene cannot be used or has no result, or a file cannot be written.
pub(super) async fn ablation(args: &AblationArgs, signals: &mut Signals) -> Result<Code, Error> {
    let (scene, _) = parse(&load(&args.scene)?, &args.set, Paint::stderr())?;
    let out = args.output.folder(&format!("{}-ablation", scene.name))?;
    let conditions = conditions(&out, usize::from(args.runs), args.pace.jobs(1))?;
    let mut tell = |news| say(args.output.quiet, &news);
    let given = args.set.iter().filter_map(|change| change.split_once('='));
    let given: Vec<_> = given.map(|(key, value)| (key.to_owned(), Level::of(value))).collect();
    let case = |name: [&str; 2], set| case_of(&args.scene, name, set);
    // Alone, whatever comes after it.
    let first = Conditions { jobs: 1, ..conditions };
    let plain = finish(&[case(["as-it-is", ""], given.clone())], first, signals, &mut tell).await?;
    let Some(plain) = plain.and_then(|cases| cases.into_iter().flatten().next()) else { return Ok(Code::Interrupted) };
    let Some(summary) = plain.summary() else {
        let problem = Problem::new(format!("`{}` has no result to compare with", args.scene));
        let why = plain.complaint().unwrap_or_default();
        return Err(Error::new(Code::Physics, problem.because(why)));
    };
    let decisions = decisions(&scene, summary);
    let other = |decision: &Decision| {
        case([&decision.name, &decision.instead], given.iter().cloned().chain(changes(decision)).collect())
    };
    let others: Vec<Case> = decisions.iter().map(other).collect();
    let Some(others) = finish(&others, conditions, signals, &mut tell).await? else { return Ok(Code::Interrupted) };
    let pairs: Vec<_> = decisions.iter().zip(others.iter().flatten()).collect();
    let beside = |decision: &Decision| {
        let other = pairs.iter().find(|(known, _)| Some(known.name.as_str()) == decision.beside);
        other.map_or(&plain, |(_, run)| *run)
    };
    let found: Vec<Worth> = pairs.iter().map(|(decision, other)| worth(decision, beside(decision), other)).collect();
    let passed = found.iter().all(|worth| worth.passed);
    let machine = machine();
    let text = json(&Answer { version: VERSION, machine: &machine, passed, decisions: &found, kept: kept() })?;
    let command: Vec<String> = std::env::args().collect();
    let page = page::study::Page { cases: &[], catalogue: &[], command: &command, version: VERSION, machine: &machine };
    write(&out, ANSWER, &text)?;
    write(&out, PAGE, &page::study::ablation(&page, &scene.name, &found, kept()))?;
    let paint = Paint::stdout();
    let people =
        human(&found, paint) + &format!("\nwritten to {}\n", paint.cyan(&out.join(PAGE).display().to_string()));
    args.output.show(&people, &text)?;
    Ok(if passed { Code::Ok } else { Code::Verdict })
}

fn changes(decision: &Decision) -> impl Iterator<Item = (String, Level)> {
    decision.set.iter().map(|(key, value)| (key.clone(), Level::of(value)))
}

fn human(found: &[Worth], paint: Paint) -> String {
    let head = [
        "decision",
        "the other way round",
        "state",
        "probes differ by",
        "pictures",
        "saves [s]",
        "of cores [s]",
        "of frames [s]",
        "[MiB]",
        "messages",
    ];
    let mut lines = vec![head.map(str::to_owned).to_vec()];
    let number = |value: Option<f64>| value.map_or_else(|| "–".into(), |v| format!("{v:.3}"));
    lines.extend(found.iter().map(|worth| {
        let state = match &worth.why_not {
            Some(why) => why.clone(),
            None => if worth.same_bytes { "the same bytes" } else { "another" }.to_owned(),
        };
        let differences = [worth.difference, worth.pictures_difference];
        let differences = differences.map(|d| d.map_or_else(|| "–".into(), |d| format!("{d:.2e}")));
        let saved = [
            number(worth.saved_s),
            number(worth.saved_core_s),
            number(worth.saved_frames_s),
            number(worth.saved_mib),
            worth.saved_messages.to_string(),
        ];
        let cells = [worth.name.clone(), worth.instead.clone(), state].into_iter().chain(differences).chain(saved);
        cells.map(|cell| printable(&cell)).collect()
    }));
    let mut text = format!("{}\n", table(paint, &lines));
    for worth in found.iter().filter(|worth| !worth.passed) {
        let line = format!("{}: its indicator says that it has no effect, and the result differs", worth.name);
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{} {}", paint.bad("it matters:"), printable(&line));
    }
    text
}
