//! `cosplat study`: error against run time.

use std::fs;
use std::path::{Path, PathBuf};
use std::thread::available_parallelism;

use clap::Args;
use serde::Serialize;

use crate::cli::Format;
use crate::exit::{Code, Error, Problem};
use crate::page;
use crate::render::{Paint, json, print, printable, talk};
use crate::scene_source::{self, Source};
use crate::study::case::{Case, Factor, Level};
use crate::study::conduct::{Conditions, News, conduct};
use crate::study::read::{ENDING, case};
use crate::study::result::CaseResult;
use crate::study::text::human;
use crate::study::{fingerprint, outcome::Class, rows};
use crate::supervise::signals::Signals;

/// One line a run.
const ROWS: &str = "study.csv";
/// Everything for programs.
const ANSWER: &str = "study.json";
/// Everything for people.
const PAGE: &str = "study.html";

const EXAMPLES: &str = "\
Examples:
  cosplat study oscillator --vary clock.window=0.02,0.01,0.005 --runs 1
  cosplat study oscillator --vary clock.link_scheme=serial,alternating --vary clock.window=0.02,0.01 --runs 1
  cosplat study verification --runs 1           every case of a folder, and one table of them all
  cosplat study verification/free-flight.study.toml --runs 1 --format json | jq .cases[0].cheapest";

/// `cosplat study`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct StudyArgs {
    /// Case (`NAME.study.toml`), folder of cases, scene file, or name of a built-in scene
    #[arg(value_name = "CASE|FOLDER|SCENE")]
    what: String,
    /// Vary a value of the scene, coarse to fine; the last one given is the axis of the order fit; may be repeated
    #[arg(long, value_name = "KEY=V1,V2,…", value_parser = factor)]
    vary: Vec<Factor>,
    /// Repetitions of each run: the median of their times counts
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u8).range(1..=100))]
    runs: u8,
    /// Folder of the study [default: out/NAME-study]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Form of the result on standard output
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
    /// Say nothing but errors; `--format json` still prints its result
    #[arg(long, short)]
    quiet: bool,
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
    /// Whether all gates hold that could be judged.
    passed: bool,
    /// Cases with their runs.
    cases: &'a [CaseResult],
}

/// Runs a study and writes what it has found out.
///
/// # Errors
/// A case or its scene cannot be used, or a file cannot be written. Runs that fail are results.
pub(crate) async fn study(args: &StudyArgs, signals: &mut Signals) -> Result<Code, Error> {
    let (name, cases) = cases(args)?;
    let out = args.out.clone().unwrap_or_else(|| PathBuf::from("out").join(format!("{name}-study")));
    fs::create_dir_all(&out).map_err(|e| Error::io("create", &out, &e))?;
    let program = fingerprint::of_this_program().map_err(|e| Error::io("read", Path::new("cosplat"), &e))?;
    let conditions = Conditions { out: &out, runs: usize::from(args.runs), program };
    let mut results = Vec::new();
    for case in &cases {
        let mut tell = |news| say(args.quiet, &case.name, news);
        let Some(result) = conduct(case, conditions, signals, &mut tell).await? else {
            talk("stopped: what has been run is kept, the same command goes on from there");
            return Ok(Code::Interrupted);
        };
        results.push(result);
    }
    let machine = machine();
    let answer = Answer {
        version: env!("CARGO_PKG_VERSION"),
        machine: &machine,
        page: out.join(PAGE).display().to_string(),
        passed: results.iter().all(CaseResult::is_green),
        cases: &results,
    };
    let command: Vec<String> = std::env::args().collect();
    let page = page::study::Page { cases: &results, command: &command, version: answer.version, machine: &machine };
    let text = json(&answer)?;
    write(&out, ROWS, &rows::csv(&results, answer.version, &machine))?;
    write(&out, ANSWER, &text)?;
    write(&out, PAGE, &page::study::html(&page))?;
    match args.format {
        Format::Json => print(&text)?,
        Format::Human if args.quiet => {}
        Format::Human => print(&human(&results, &out.join(PAGE), Paint::stdout()))?,
    }
    Ok(if answer.passed { Code::Ok } else { Code::Verdict })
}

fn write(out: &Path, name: &str, text: &str) -> Result<(), Error> {
    let path = out.join(name);
    fs::write(&path, text).map_err(|e| Error::io("write", &path, &e))
}

/// The cases that are meant, and a name for all of them.
fn cases(args: &StudyArgs) -> Result<(String, Vec<Case>), Error> {
    let path = Path::new(&args.what);
    let mut cases = if path.is_dir() {
        in_folder(path)?
    } else if args.what.ends_with(ENDING) {
        vec![case(path)?]
    } else {
        vec![of_scene(&scene_source::load(&args.what)?, &args.what, &args.vary)?]
    };
    for case in &mut cases {
        for factor in &args.vary {
            case.vary.retain(|known| known.key != factor.key);
            case.vary.push(factor.clone());
        }
    }
    let folder = || fs::canonicalize(path).ok()?.file_name().map(|n| n.to_string_lossy().into_owned());
    let name = match cases.as_slice() {
        [only] => only.name.clone(),
        _ => folder().unwrap_or_else(|| "cases".into()),
    };
    Ok((name, cases))
}

/// All cases of a folder by name; every mistake in any of them is reported.
fn in_folder(folder: &Path) -> Result<Vec<Case>, Error> {
    let cannot = |e: &std::io::Error| Error::io("read", folder, e);
    let entries =
        fs::read_dir(folder).and_then(Iterator::collect::<std::io::Result<Vec<_>>>).map_err(|e| cannot(&e))?;
    let mut files: Vec<PathBuf> = entries.into_iter().map(|entry| entry.path()).collect();
    files.retain(|path| path.to_string_lossy().ends_with(ENDING));
    files.sort_unstable();
    let (mut cases, mut problems) = (Vec::new(), Vec::new());
    for read in files.iter().map(|file| case(file)) {
        match read {
            Ok(case) => cases.push(case),
            Err(error) => problems.extend(error.problems),
        }
    }
    if cases.is_empty() && problems.is_empty() {
        let problem = Problem::new(format!("`{}` holds no case", folder.display())).at(folder);
        problems.push(problem.hint(format!("a case is a file `NAME{ENDING}` beside its scene")));
    }
    if problems.is_empty() { Ok(cases) } else { Err(Error { code: Code::Scene, problems }) }
}

/// A scene without a reference: its finest run stands in for one.
fn of_scene(source: &Source, wanted: &str, vary: &[Factor]) -> Result<Case, Error> {
    if vary.is_empty() {
        let problem = Problem::new(format!("Nothing says what to vary in `{wanted}`"));
        let hint = "add the values of a key, coarse to fine, as in `--vary clock.window=0.02,0.01,0.005`";
        return Err(Error::new(Code::Usage, problem.hint(hint)));
    }
    let plain = |key: &str| {
        let table: toml::Table = toml::from_str(&source.text).unwrap_or_default();
        table.get(key).and_then(toml::Value::as_str).map(str::to_owned)
    };
    let name = plain("name").unwrap_or_else(|| "scene".into());
    Ok(Case {
        title: plain("title").unwrap_or_else(|| name.clone()),
        name,
        scene: wanted.to_owned(),
        source: String::new(),
        quantities: Vec::new(),
        vary: Vec::new(),
        gates: Vec::new(),
    })
}

/// Reads `KEY=V1,V2`; values are TOML, plain words count as strings.
fn factor(text: &str) -> Result<Factor, String> {
    let (key, values) = text.split_once('=').ok_or("expected a key, `=` and values, as in `clock.window=0.02,0.01`")?;
    // Commas inside brackets and quotes belong to a value.
    let (mut parts, mut depth, mut quoted) = (vec![String::new()], 0_i32, false);
    for c in values.chars() {
        depth += i32::from("[{".contains(c)) - i32::from("]}".contains(c));
        quoted ^= c == '"';
        match parts.last_mut() {
            Some(part) if c != ',' || depth > 0 || quoted => part.push(c),
            _ => parts.push(String::new()),
        }
    }
    let values: Vec<Level> = parts.iter().map(|part| Level::of(part)).collect();
    if key.trim().is_empty() || values.iter().any(|value| value.toml.is_empty()) {
        return Err("expected a key, `=` and values with commas between, as in `clock.window=0.02,0.01`".into());
    }
    Ok(Factor { key: key.trim().to_owned(), values })
}

fn say(is_quiet: bool, case: &str, news: News) {
    if is_quiet {
        return;
    }
    match news {
        News::Begins(number, of, name) => talk(&format!("{case} {number}/{of}  {}", printable(&name))),
        News::Ended(Class::Correct, false) => {}
        News::Ended(class, cached) => talk(&format!("  {}{}", class.word(), if cached { ", kept" } else { "" })),
    }
}

/// Processor and cores, so that times can be read.
fn machine() -> String {
    let cores = available_parallelism().map_or(0, std::num::NonZero::get);
    let facts = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model =
        facts.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':').map(|(_, name)| name.trim()));
    format!("{}, {cores} cores", printable(model.unwrap_or(std::env::consts::ARCH)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_split_at_commas_that_are_not_inside_of_one() {
        let shown = |text: &str| factor(text).map(|f| f.values.into_iter().map(|v| v.shown).collect::<Vec<_>>());
        assert_eq!(shown("clock.window=0.02,1e-2").unwrap(), ["0.02", "0.01"]);
        assert_eq!(shown("body.a.position=[0, 1],[2, 3]").unwrap(), ["[0, 1]", "[2, 3]"]);
        assert_eq!(shown("x=\"a,b\",c").unwrap(), ["a,b", "c"]);
        for wrong in ["x", "=1", "x=", "x=1,,2"] {
            assert!(shown(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_scene_needs_something_to_vary() {
        let source = scene_source::load("oscillator").unwrap();
        assert_eq!(of_scene(&source, "oscillator", &[]).unwrap_err().code, Code::Usage);
        let case = of_scene(&source, "oscillator", &[factor("clock.window=0.1").unwrap()]).unwrap();
        assert_eq!((case.name.as_str(), case.quantities.len()), ("oscillator", 0));
    }
}
