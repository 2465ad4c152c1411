//! `cosplat study sheet`: runs in rows and columns, their pictures, and what they measure.

use std::path::Path;

use clap::Args;
use cosplat_core::scene::Scene;
use cosplat_viewer::png;
use serde::Serialize;

use super::{Output, Pace, VERSION, conditions, machine, say, wanted, write};
use crate::exit::{Code, Error, Problem};
use crate::page;
use crate::render::{Paint, json, printable, table, talk};
use crate::scene_source;
use crate::study::ablation::case_of;
use crate::study::case::{Case, Factor, Level};
use crate::study::conduct::{Conditions, finish};
use crate::study::evaluate::Finished;
use crate::study::outcome::Class;
use crate::study::sheet::{self, Cell, ENDING, Line, Sheet, Tile, csv, lines, side_by_side};
use crate::supervise::signals::Signals;

/// One line a run.
const ROWS: &str = "sheet.csv";
/// Everything for programs.
const ANSWER: &str = "sheet.json";
/// Everything for people.
const PAGE: &str = "sheet.html";
/// The pictures alone.
const PICTURE: &str = "sheet.png";

const EXAMPLES: &str = "\
Examples:
  cosplat study sheet impacts                   four materials under three strikers
  cosplat study sheet my-scene.toml --rows clock.window=0.02,0.01";

const INSIDE: &str = "\
A key that is given again in another `--rows` varies together with the first: row i takes the i-th value of each. The \
first key names the rows. `NAME.sheet.toml` beside a scene says the same in a file: `scene`, `title`, `at`, `striker` \
and the tables `rows` and `columns` of keys with a list of values each.";

/// `cosplat study sheet`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES, after_long_help = format!("{EXAMPLES}\n\n{INSIDE}"))]
pub(super) struct SheetArgs {
    /// Name of a built-in scene that has a sheet, sheet file (`NAME.sheet.toml`), or any scene with `--rows`
    #[arg(value_name = "SHEET|SCENE")]
    what: String,
    /// Values of the rows; more keys vary together with the first
    #[arg(long, value_name = "KEY=V1,V2,…", value_parser = wanted::factor)]
    rows: Vec<Factor>,
    /// Values of the columns; more keys vary together with the first
    #[arg(long, value_name = "KEY=V1,V2,…", value_parser = wanted::factor)]
    columns: Vec<Factor>,
    /// Moment of the pictures [default: that of the sheet, or the end]
    #[arg(long, value_name = "SECONDS", value_parser = crate::cli::parse_seconds)]
    at: Option<f64>,
    /// Body whose dent and rebound are measured: the scene has probes of its position and its velocity
    #[arg(long, value_name = "BODY")]
    striker: Option<String>,
    /// Change a value of the scene in all runs; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
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
    /// Page for people.
    page: String,
    /// Whether all runs have a result that no verdict speaks against.
    passed: bool,
    /// The runs, row by row.
    runs: &'a [Cell],
}

/// Runs all cells of a sheet and lays them out.
///
/// # Errors
/// The sheet or its scene cannot be used, or a file cannot be written. Runs that fail are results.
pub(super) async fn sheet(args: &SheetArgs, signals: &mut Signals) -> Result<Code, Error> {
    let sheet = wanted_sheet(args)?;
    let scene = scene_of(&sheet, &args.set)?;
    let out = args.output.folder(&format!("{}-sheet", sheet.name))?;
    let conditions = Conditions { pictures: true, ..conditions(&out, 1, args.pace.jobs(1))? };
    let of = |(row, column): (&Line, &Line)| {
        case_of(&sheet.scene, [&name(row, column), ""], changes(&args.set, row, column))
    };
    let cases: Vec<Case> = places(&sheet).map(of).collect();
    let Some(runs) = finish(&cases, conditions, signals, &mut |news| say(args.output.quiet, &news)).await? else {
        talk("stopped: what has been run is kept, the same command goes on from there");
        return Ok(Code::Interrupted);
    };
    let cell = |((row, column), run): ((&Line, &Line), &Finished)| {
        Cell::of((row.name(), column.name()), run, &scene, sheet.at_s, sheet.striker.as_deref())
    };
    let cells: Vec<Cell> = places(&sheet).zip(runs.iter().flatten()).map(cell).collect();
    let tiles: Vec<Option<Tile>> = cells.iter().map(tile).collect::<Result<_, _>>()?;
    let rows: Vec<Vec<Option<Tile>>> = tiles.chunks(sheet.columns.len()).map(<[_]>::to_vec).collect();
    if tiles.iter().any(Option::is_some) {
        let path = out.join(PICTURE);
        png::write(&path, &side_by_side(&rows)).map_err(|e| cannot_draw(&path, &e))?;
    }
    let passed = cells.iter().all(Cell::is_good);
    let (machine, page_file) = (machine(), out.join(PAGE));
    let answer =
        Answer { version: VERSION, machine: &machine, page: page_file.display().to_string(), passed, runs: &cells };
    let text = json(&answer)?;
    let command: Vec<String> = std::env::args().collect();
    let page = page::study::Page { cases: &[], catalogue: &[], command: &command, version: VERSION, machine: &machine };
    write(&out, ROWS, &csv(&cells))?;
    write(&out, ANSWER, &text)?;
    write(&out, PAGE, &page::study::sheet(&page, &sheet, &cells, &tiles))?;
    let paint = Paint::stdout();
    let people = human(&cells, paint) + &format!("\nwritten to {}\n", paint.cyan(&page_file.display().to_string()));
    args.output.show(&people, &text)?;
    Ok(if passed { Code::Ok } else { Code::Verdict })
}

/// The sheet that is meant: what the command line says goes before what a file says.
fn wanted_sheet(args: &SheetArgs) -> Result<Sheet, Error> {
    let usage = |why: String, hint: &str| Error::new(Code::Usage, Problem::new(why).hint(hint));
    let known = sheet::load(&args.what)?;
    if known.is_none() && args.rows.is_empty() && args.columns.is_empty() {
        let hint = format!("add `--rows KEY=V1,V2` or `--columns KEY=V1,V2`, or give a file `NAME{ENDING}`");
        return Err(usage(format!("Nothing says what to vary in `{}`", args.what), &hint));
    }
    let name =
        || Path::new(&args.what).file_stem().map_or_else(|| "scene".into(), |n| n.to_string_lossy().into_owned());
    let mut sheet = known.unwrap_or_else(|| Sheet {
        name: name(),
        title: String::new(),
        scene: args.what.clone(),
        at_s: None,
        striker: None,
        rows: vec![Line::default()],
        columns: vec![Line::default()],
    });
    let axis = |keys: &[Factor]| lines(keys).map_err(|why| usage(why, "give as many values for each of its keys"));
    if !args.rows.is_empty() {
        sheet.rows = axis(&args.rows)?;
    }
    if !args.columns.is_empty() {
        sheet.columns = axis(&args.columns)?;
    }
    sheet.at_s = args.at.or(sheet.at_s);
    sheet.striker = args.striker.clone().or(sheet.striker);
    Ok(sheet)
}

/// The scene of the first run that is one: a scene that no values fit is a mistake, not a sheet of refusals.
fn scene_of(sheet: &Sheet, set: &[String]) -> Result<Scene, Error> {
    let source = scene_source::load(&sheet.scene)?;
    let mut first = None;
    for (row, column) in places(sheet) {
        let changes = changes(set, row, column);
        let overrides: Vec<String> = changes.iter().map(|(key, value)| format!("{key}={}", value.toml)).collect();
        match scene_source::parse(&source, &overrides, Paint::stderr()) {
            Ok((scene, _)) => return Ok(scene),
            Err(error) => first = first.or(Some(error)),
        }
    }
    let nothing = || Error::new(Code::Usage, Problem::new("The sheet has no place for a run"));
    Err(first.unwrap_or_else(nothing))
}

/// Rows and columns of all cells, row by row.
fn places(sheet: &Sheet) -> impl Iterator<Item = (&Line, &Line)> {
    sheet.rows.iter().flat_map(|row| sheet.columns.iter().map(move |column| (row, column)))
}

fn name(row: &Line, column: &Line) -> String {
    let words: Vec<&str> = [row.name(), column.name()].into_iter().filter(|word| !word.is_empty()).collect();
    words.join(" ")
}

/// What a run changes in the scene, from the general to its own.
fn changes(set: &[String], row: &Line, column: &Line) -> Vec<(String, Level)> {
    let given = set.iter().filter_map(|change| change.split_once('='));
    let given = given.map(|(key, value)| (key.to_owned(), Level::of(value)));
    given.chain(row.values.iter().chain(&column.values).cloned()).collect()
}

/// The picture of a run, small; none where it has drawn none.
fn tile(cell: &Cell) -> Result<Option<Tile>, Error> {
    let Some(path) = &cell.picture else { return Ok(None) };
    let (width, height, values) = png::read(path).map_err(|e| cannot_draw(path, &e))?;
    Ok(Some(Tile::of(width, height, &values)))
}

fn cannot_draw(path: &Path, why: &png::PngError) -> Error {
    Error::new(Code::Environment, Problem::new("The pictures cannot be laid out").at(path).because(why))
}

fn human(cells: &[Cell], paint: Paint) -> String {
    let head = ["row", "column", "dent [mm]", "rebound", "substeps", "core [s]", "wall time [s]", "outcome"];
    let mut all = vec![head.map(str::to_owned).to_vec()];
    let number = |value: Option<f64>, digits: usize| value.map_or_else(|| "–".into(), |v| format!("{v:.digits$}"));
    all.extend(cells.iter().map(|cell| {
        let why = cell.why.as_ref().map(|why| format!(": {why}")).unwrap_or_default();
        let cells = [
            cell.row.clone(),
            cell.column.clone(),
            number(cell.impact.and_then(|i| i.dent_m).map(|m| 1e3 * m), 1),
            number(cell.impact.map(|i| i.rebound), 2),
            cell.substeps.map_or_else(|| "–".into(), |n| n.to_string()),
            number(cell.core_s, 1),
            number(cell.wall_s, 1),
            format!("{}{why}", cell.outcome.map_or("", Class::word)),
        ];
        cells.map(|cell| printable(&cell)).to_vec()
    }));
    table(paint, &all)
}
