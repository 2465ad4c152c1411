//! `cosplat study`: error against run time.

mod ablation;
mod controls;
mod sheet;
mod stability;
mod wanted;

use std::fs;
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};
use cosplat_viewer::recording::RecordingError;
use serde::Serialize;

use crate::cli::Format;
use crate::exit::{Code, Error, Problem};
use crate::page;
use crate::render::{Paint, json, print, printable, talk};
use crate::study::case::{Case, Factor};
use crate::study::catalogue::Entry;
use crate::study::conduct::{Conditions, News, conduct, cores};
use crate::study::result::CaseResult;
use crate::study::text::human;
use crate::study::{fingerprint, outcome::Class, recording, rows};
use crate::supervise::signals::Signals;

/// Version of this program.
const VERSION: &str = env!("CARGO_PKG_VERSION");
/// One line a run.
const ROWS: &str = "study.csv";
/// Everything for programs.
const ANSWER: &str = "study.json";
/// Everything for people.
const PAGE: &str = "study.html";
/// The diagrams and tables for the rerun viewer.
const RECORDING: &str = "study.rrd";

const EXAMPLES: &str = "\
Examples:
  cosplat study oscillator --vary clock.window=0.02,0.01,0.005 --runs 1
  cosplat study oscillator --vary clock.link_scheme=serial,alternating --vary clock.window=0.02,0.01 --runs 1
  cosplat study stability --only liquid-of-points
  cosplat study negative-controls --only stale-boundary
  cosplat study verification --runs 1           every case of a folder, and one table of them all
  cosplat study verification/free-flight.study.toml --runs 1 --format json | jq .cases[0].cheapest";

/// `cosplat study`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES, args_conflicts_with_subcommands = true)]
pub(crate) struct StudyArgs {
    /// Case (`NAME.study.toml`), folder of cases, scene file, or name of a built-in scene
    #[arg(value_name = "CASE|FOLDER|SCENE")]
    what: Option<String>,
    /// Vary a value of the scene, coarse to fine; the last one given is the axis of the order fit; may be repeated
    #[arg(long, value_name = "KEY=V1,V2,…", value_parser = wanted::factor)]
    vary: Vec<Factor>,
    /// Repetitions of each run: the median of their times counts
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u8).range(1..=100))]
    runs: u8,
    /// Of a folder, also the cases that take minutes
    #[arg(long)]
    slow: bool,
    #[command(flatten)]
    pace: Pace,
    #[command(flatten)]
    output: Output,
    #[command(subcommand)]
    suite: Option<Suite>,
}

/// Studies that need no case of their own.
#[derive(Clone, Debug, Subcommand)]
enum Suite {
    /// Extreme settings of all solvers and schemes: what is right, reported, refused, or fails in silence
    Stability(stability::StabilityArgs),
    /// Breaks one thing at a time: the gate that is there for it must turn red
    NegativeControls(controls::ControlArgs),
    /// Takes each decision to leave something out the other way round: what it changes, and what it saves
    Ablation(ablation::AblationArgs),
    /// Runs a scene with one value a row and another a column: a sheet of pictures, and a table of what they measure
    Sheet(sheet::SheetArgs),
}

/// How many runs are made at once.
#[derive(Clone, Copy, Debug, Args)]
struct Pace {
    /// Runs side by side, each with its share of the cores: the first one of each; its time counts only where no
    /// repetition has the machine to itself [default: 1; one for each core where no times are asked for]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    jobs: Option<u16>,
}

impl Pace {
    /// Runs side by side; so many where the user does not say it.
    fn jobs(self, usual: usize) -> usize {
        self.jobs.map_or(usual, usize::from)
    }
}

/// Where results go.
#[derive(Clone, Debug, Args)]
struct Output {
    /// Folder of the study [default: out/NAME-study]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Form of the result on standard output
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Say nothing but errors; `--format json` still prints its result
    #[arg(long, short)]
    quiet: bool,
}

impl Output {
    /// The folder of the study, which is made where it is missing.
    fn folder(&self, name: &str) -> Result<PathBuf, Error> {
        let out = self.out.clone().unwrap_or_else(|| PathBuf::from("out").join(format!("{name}-study")));
        fs::create_dir_all(&out).map_err(|e| Error::io("create", &out, &e))?;
        Ok(out)
    }

    /// Shows a result: to people or to programs.
    fn show(&self, people: &str, programs: &str) -> Result<(), Error> {
        match self.format {
            Format::Json => print(programs),
            Format::Human if self.quiet => Ok(()),
            Format::Human => print(people),
        }
    }
}

impl StudyArgs {
    /// Form of the result on standard output.
    pub(crate) fn format(&self) -> Format {
        match &self.suite {
            None => self.output.format,
            Some(Suite::Stability(args)) => args.output.format,
            Some(Suite::NegativeControls(args)) => args.output.format,
            Some(Suite::Ablation(args)) => args.output.format,
            Some(Suite::Sheet(args)) => args.output.format,
        }
    }
}

/// The result for programs.
#[derive(Debug, Serialize)]
struct Answer<'a> {
    /// Version of this program.
    version: &'a str,
    /// What it ran on.
    machine: &'a str,
    /// Page for people.
    page: String,
    /// Whether all gates hold that could be judged, but for those whose cases explain why they do not.
    passed: bool,
    /// Cases with their runs.
    cases: &'a [CaseResult],
    /// Published cases, and which of these answer them.
    #[serde(skip_serializing_if = "<[Entry]>::is_empty")]
    catalogue: &'a [Entry],
}

/// Runs a study and writes what it has found out.
///
/// # Errors
/// A case or its scene cannot be used, or a file cannot be written. Runs that fail are results.
pub(crate) async fn study(args: &StudyArgs, signals: &mut Signals) -> Result<Code, Error> {
    match &args.suite {
        None => of_cases(args, signals).await,
        Some(Suite::Stability(args)) => stability::stability(args, signals).await,
        Some(Suite::NegativeControls(args)) => controls::controls(args, signals).await,
        Some(Suite::Ablation(args)) => ablation::ablation(args, signals).await,
        Some(Suite::Sheet(args)) => sheet::sheet(args, signals).await,
    }
}

async fn of_cases(args: &StudyArgs, signals: &mut Signals) -> Result<Code, Error> {
    let (name, cases) = wanted::cases(args)?;
    let catalogue = wanted::catalogue(args, &cases)?;
    let out = args.output.folder(&name)?;
    let conditions = conditions(&out, usize::from(args.runs), args.pace.jobs(1))?;
    let Some(results) = conduct_all(&cases, conditions, args.output.quiet, signals).await? else {
        return Ok(Code::Interrupted);
    };
    let machine = machine();
    let answer = Answer {
        version: VERSION,
        machine: &machine,
        page: out.join(PAGE).display().to_string(),
        passed: results.iter().all(CaseResult::is_accounted_for),
        cases: &results,
        catalogue: &catalogue,
    };
    let command: Vec<String> = std::env::args().collect();
    let page = page::study::Page {
        cases: &results,
        catalogue: &catalogue,
        command: &command,
        version: VERSION,
        machine: &machine,
    };
    let text = json(&answer)?;
    write(&out, ROWS, &rows::csv(&results, VERSION, &machine))?;
    write(&out, ANSWER, &text)?;
    write(&out, PAGE, &page::study::html(&page))?;
    recorded(recording::write(&out.join(RECORDING), &name, &results))?;
    args.output.show(&human(&results, &out.join(PAGE), Paint::stdout()), &text)?;
    Ok(if answer.passed { Code::Ok } else { Code::Verdict })
}

/// How the runs of a study are made.
fn conditions(out: &Path, runs: usize, jobs: usize) -> Result<Conditions<'_>, Error> {
    let program = fingerprint::of_this_program().map_err(|e| Error::io("read", Path::new("cosplat"), &e))?;
    Ok(Conditions { out, runs, program, jobs, pictures: false })
}

/// Carries out all cases; none where the user has stopped it.
async fn conduct_all(
    cases: &[Case],
    conditions: Conditions<'_>,
    is_quiet: bool,
    signals: &mut Signals,
) -> Result<Option<Vec<CaseResult>>, Error> {
    let results = conduct(cases, conditions, signals, &mut |news| say(is_quiet, &news)).await?;
    if results.is_none() {
        talk("stopped: what has been run is kept, the same command goes on from there");
    }
    Ok(results)
}

/// What came of writing a recording.
fn recorded(result: Result<(), RecordingError>) -> Result<(), Error> {
    let problem = |e| Problem::new("The recording of the study cannot be written").because(e);
    result.map_err(|e| Error::new(Code::Environment, problem(e)))
}

fn write(out: &Path, name: &str, text: &str) -> Result<(), Error> {
    let path = out.join(name);
    fs::write(&path, text).map_err(|e| Error::io("write", &path, &e))
}

fn say(is_quiet: bool, news: &News) {
    if is_quiet {
        return;
    }
    match news {
        News::Begins(name) => talk(&printable(name)),
        News::Ended(_, Class::Correct, false) => {}
        News::Ended(name, class, cached) => {
            talk(&format!("{}: {}{}", printable(name), class.word(), if *cached { ", kept" } else { "" }));
        }
    }
}

/// Processor and cores, so that times can be read.
fn machine() -> String {
    let facts = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model =
        facts.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':').map(|(_, name)| name.trim()));
    format!("{}, {} cores", printable(model.unwrap_or(std::env::consts::ARCH)), cores())
}
