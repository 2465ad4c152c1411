//! `cosplat study`: error against run time.

use std::fs;
use std::path::{Path, PathBuf};
use std::thread::available_parallelism;

use clap::Args;
use serde::Serialize;

use crate::cli::Format;
use crate::exit::{Code, Error, Problem};
use crate::page;
use crate::render::{Paint, json, print, printable, table, talk};
use crate::scene_source::{self, Source};
use crate::study::case::{Case, Factor, Level};
use crate::study::conduct::{Conditions, News, conduct};
use crate::study::read::{ENDING, case};
use crate::study::result::{CaseResult, Group, Row};
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
  cosplat study verification/oscillator.study.toml --runs 1 --format json | jq .cases[0].cheapest";

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
        match conduct(case, conditions, signals, &mut tell).await? {
            Some(result) => results.push(result),
            None => {
                talk("stopped: what has been run is kept, the same command goes on from there");
                return Ok(Code::Interrupted);
            }
        }
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
        Format::Human => print(&human(&results, &out, Paint::stdout()))?,
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
    let entries = fs::read_dir(folder).and_then(Iterator::collect::<std::io::Result<Vec<_>>>).map_err(|e| cannot(&e))?;
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
    let model = facts.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':').map(|(_, name)| name.trim()));
    format!("{}, {cores} cores", printable(model.unwrap_or(std::env::consts::ARCH)))
}

fn human(results: &[CaseResult], out: &Path, paint: Paint) -> String {
    let mut text = String::new();
    for case in results {
        if results.len() == 1 {
            text.push_str(&runs(case, paint));
        }
        text.push_str(&failed_gates(case, results.len() > 1, paint));
    }
    if results.len() > 1 {
        text.push_str(&matrix(results, paint));
    }
    text + &format!("\nwritten to {}\n", paint.cyan(&out.join(PAGE).display().to_string()))
}

fn number(value: Option<f64>) -> String {
    value.map_or_else(|| "–".into(), |v| format!("{v:.3e}"))
}

/// All runs of a case, its orders, and the cheapest runs.
fn runs(case: &CaseResult, paint: Paint) -> String {
    let head = ["error", "coupling", "solvers", "wall time [s]", "outcome"].map(str::to_owned);
    let mut lines: Vec<Vec<String>> = vec![case.vary.iter().map(|f| f.key.clone()).chain(head).collect()];
    lines.extend(case.rows.iter().map(|row: &Row| {
        let wall = row.cost.as_ref().map_or_else(|| "–".into(), |c| format!("{:.4}", c.wall_s));
        let why = row.why.as_ref().map(|why| format!(": {why}")).unwrap_or_default();
        let outcome = format!("{}{why}", row.outcome.map_or("", Class::word));
        let numbers = [row.error, row.error_coupling, row.error_solver].map(number);
        let cells = row.settings.iter().map(|(_, value)| value.clone()).chain(numbers).chain([wall, outcome]);
        cells.map(|cell| printable(&cell)).collect()
    }));
    let mut text = format!("{}\nreference: {}\n\n", paint.bold(&printable(&case.title)), printable(&case.reference));
    text.push_str(&table(paint, &lines));
    for group in case.groups.iter().filter(|g| g.fit.is_some()) {
        text.push_str(&format!("\norder {}", order(group)));
    }
    text.push_str("\n\n");
    for wanted in &case.cheapest {
        let found = wanted.row.and_then(|i| Some((&case.rows[i], case.rows[i].cost.as_ref()?.wall_s)));
        let answer = found.map_or_else(|| "none of these runs".into(), |(row, wall)| format!("{wall:.4} s with {}", row.name()));
        text.push_str(&format!("an error of {:>4} % costs {}\n", 100.0 * wanted.error, printable(&answer)));
    }
    for note in &case.notes {
        text.push_str(&format!("{} {}\n", paint.warn("note:"), printable(note)));
    }
    text
}

fn order(group: &Group) -> String {
    let Some(fit) = &group.fit else { return String::new() };
    let interval = fit.plus_minus.map(|half| format!(" ± {half:.3}")).unwrap_or_default();
    let floor = fit.with_floor.as_ref().map(|f| format!(", or {:.3} above a floor of {:.1e}", f.order, f.floor));
    let name = if group.name.is_empty() { String::new() } else { format!("  {}", printable(&group.name)) };
    format!("{:.3}{interval}{}{name}", fit.order, floor.unwrap_or_default())
}

fn failed_gates(case: &CaseResult, with_name: bool, paint: Paint) -> String {
    let judged = case.gates.iter().filter(|g| g.passed.is_some()).count();
    let mut text = String::new();
    for gate in case.gates.iter().filter(|gate| gate.passed == Some(false)) {
        let place: Vec<String> = gate.gate.r#where.iter().map(|(key, value)| format!("{key}={value}")).collect();
        let claim = match gate.gate.claim {
            crate::study::case::Claim::Order([least, most]) => format!("an order between {least} and {most}"),
            crate::study::case::Claim::Error(most) => format!("an error of at most {most}"),
            crate::study::case::Claim::Outcome(class) => format!("the outcome {}", class.word()),
        };
        let line = format!("{} {} should have {claim}, but has {}: {}", case.name, place.join(" "), gate.measured, gate.gate.reason);
        text.push_str(&format!("{} {}\n", paint.bad("gate failed:"), printable(&line)));
    }
    if text.is_empty() && judged > 0 && !with_name {
        text = format!("{} all {judged} gates hold\n", paint.good("ok:"));
    }
    text
}

/// One line a case.
fn matrix(results: &[CaseResult], paint: Paint) -> String {
    let head = ["case", "runs", "smallest error", "gates", "order", "time of that run [s]", "1 % costs [s]"];
    let mut lines = vec![head.map(str::to_owned).to_vec()];
    lines.extend(results.iter().map(|case| {
        let judged = case.gates.iter().filter(|g| g.passed.is_some()).count();
        let failed = case.gates.iter().filter(|g| g.passed == Some(false)).count();
        let wall = |place: Option<usize>| {
            let cost = place.and_then(|i| case.rows[i].cost.as_ref());
            cost.map_or_else(|| "–".into(), |c| format!("{:.4}", c.wall_s))
        };
        let orders: Vec<String> =
            case.groups.iter().filter_map(|g| g.fit.as_ref()).map(|fit| format!("{:.2}", fit.order)).collect();
        vec![
            case.name.clone(),
            case.rows.len().to_string(),
            number(case.smallest_error()),
            if failed > 0 { format!("{failed} of {judged} failed") } else { format!("{judged} hold") },
            if orders.is_empty() { "–".into() } else { orders.join(" ") },
            wall(case.front.last().copied()),
            wall(case.cheapest.iter().find(|c| c.error == 0.01).and_then(|c| c.row)),
        ]
    }));
    format!("\n{}", table(paint, &lines))
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
