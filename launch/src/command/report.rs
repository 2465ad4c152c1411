//! `cosplat report`: runs on one page, and the comparison of those of one scene.

use std::fs;
use std::path::{Component, Path, PathBuf};

use clap::Args;
use serde::Serialize;

use crate::cli::Format;
use crate::exit::{Code, Error, Problem};
use crate::folder::{REPORT, is_of_a_run};
use crate::gallery::Gallery;
use crate::gallery::compare::Comparison;
use crate::gallery::read::{ArchivedRun, run_folders};
use crate::page;
use crate::render::{Paint, json, print, printable, table, talk};

/// Name of the page, where none is given.
const GALLERY: &str = "gallery.html";
/// Where runs are looked for, where no folder is given: there `cosplat run` puts them.
const RUNS: &str = "out";

const EXAMPLES: &str = "\
Examples:
  cosplat report                                all runs in `out`, as `out/gallery.html`
  cosplat report out/coarse out/fine --out compared.html
  cosplat report out/a out/b --format json | jq .comparisons[0].probes";

/// `cosplat report`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct ReportArgs {
    /// Run folders, or folders around them; of several runs of one scene the first is the reference [default: out]
    #[arg(value_name = "FOLDER")]
    pub(crate) folders: Vec<PathBuf>,
    /// Page to write [default: gallery.html in the folder around the first run]
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    /// Form of the answer on standard output
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
}

/// The answer for programs.
#[derive(Debug, Serialize)]
struct Answer<'a> {
    page: String,
    runs: Vec<String>,
    unreadable: &'a [(String, String)],
    comparisons: &'a [Comparison],
}

/// Writes the page and prints the comparisons.
///
/// # Errors
/// A folder holds no run, none of the runs can be read, or the page cannot be written.
pub(crate) fn report(args: &ReportArgs) -> Result<Code, Error> {
    let given = if args.folders.is_empty() { vec![PathBuf::from(RUNS)] } else { args.folders.clone() };
    let (mut runs, mut unreadable) = (Vec::new(), Vec::new());
    for folder in run_folders(&given)? {
        match ArchivedRun::read(&folder) {
            Ok(run) => runs.push(run),
            Err(why) => unreadable.push((folder.display().to_string(), why)),
        }
    }
    if runs.is_empty() {
        return Err(nothing_to_show(&unreadable));
    }
    let page = args.out.clone().unwrap_or_else(|| default_page(&given[0]));
    let gallery = Gallery::of(runs, unreadable);
    write(&gallery, &page)?;
    match args.format {
        Format::Json => print(&json(&Answer {
            page: page.display().to_string(),
            runs: gallery.runs.iter().map(|run| run.folder.display().to_string()).collect(),
            unreadable: &gallery.unreadable,
            comparisons: &gallery.comparisons,
        })?)?,
        Format::Human => print(&human(&gallery, &page, Paint::stdout()))?,
    }
    Ok(Code::Ok)
}

fn nothing_to_show(unreadable: &[(String, String)]) -> Error {
    let mut problem = Problem::new("None of the runs can be shown");
    for (folder, why) in unreadable {
        problem = problem.because(format!("`{folder}`: {why}"));
    }
    Error::new(Code::Scene, problem.hint("run the scene again with `cosplat run`"))
}

/// Beside the runs: in the folder around them.
fn default_page(first: &Path) -> PathBuf {
    let around = if is_of_a_run(first) { first.parent().unwrap_or(first) } else { first };
    around.join(GALLERY)
}

fn write(gallery: &Gallery, page: &Path) -> Result<(), Error> {
    let cannot = |e: &std::io::Error| Error::io("write", page, e);
    let around = page.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    fs::create_dir_all(around).map_err(|e| cannot(&e))?;
    let around = fs::canonicalize(around).map_err(|e| cannot(&e))?;
    let link = |run: &ArchivedRun| {
        let report = fs::canonicalize(run.folder.join(REPORT)).ok().filter(|_| run.has_report)?;
        Some(address(&around, &report))
    };
    fs::write(page, page::gallery::html(gallery, link)).map_err(|e| cannot(&e))
}

/// Address of a file for a page in the folder `around`; both are absolute.
fn address(around: &Path, file: &Path) -> String {
    let shared = around.components().zip(file.components()).take_while(|(a, b)| a == b).count();
    let up = around.components().skip(shared).map(|_| "..".to_owned());
    let down = file.components().skip(shared).map(|c| match c {
        Component::Normal(name) => escaped(&name.to_string_lossy()),
        other => other.as_os_str().to_string_lossy().into_owned(),
    });
    up.chain(down).collect::<Vec<_>>().join("/")
}

/// A name as a part of an address (RFC 3986, section 2).
fn escaped(name: &str) -> String {
    let plain = |b: u8| b.is_ascii_alphanumeric() || b"-._~".contains(&b);
    name.bytes().map(|b| if plain(b) { char::from(b).to_string() } else { format!("%{b:02X}") }).collect()
}

fn human(gallery: &Gallery, page: &Path, paint: Paint) -> String {
    let mut rows = vec![["run", "scene", "simulated", "wall time", "state"].map(str::to_owned).to_vec()];
    rows.extend(gallery.runs.iter().map(|run| {
        let summary = &run.summary;
        let hash = summary.state_hash.clone().unwrap_or_else(|| "none".into());
        let (simulated, wall) = (format!("{} s", summary.simulated_s), format!("{:.1} s", summary.wall_s));
        vec![run.folder.display().to_string(), summary.scene.clone(), simulated, wall, hash]
    }));
    let mut text = table(paint, &rows);
    for compared in &gallery.comparisons {
        text += "\n";
        text += &printable(&format!("Runs of {}, against the first", compared.scene));
        text += "\n";
        text.push_str(&table(paint, &comparison(compared)));
    }
    text += "\nwritten to ";
    text += &paint.cyan(&page.display().to_string());
    text += "\n";
    for (folder, why) in &gallery.unreadable {
        talk(&printable(&format!("`{folder}` is not shown: {why}")));
    }
    text
}

fn comparison(compared: &Comparison) -> Vec<Vec<String>> {
    let number = |v: &Option<f64>| v.map_or_else(|| "–".into(), |v| format!("{v:.4e}"));
    let mut rows = vec![["quantity".to_owned()].into_iter().chain(compared.runs.iter().cloned()).collect::<Vec<_>>()];
    for q in &compared.quantities {
        let name = format!("{} [{}]", q.name, q.unit);
        rows.push([name].into_iter().chain(q.values.iter().map(number)).collect());
    }
    for apart in &compared.probes {
        let cells = apart.differences.iter().map(|d| d.map_or_else(|| "–".into(), |d| format!("{:.4e}", d.max)));
        rows.push([format!("{}: largest difference", apart.column)].into_iter().chain(cells).collect());
    }
    rows.iter().map(|row| row.iter().map(|cell| printable(cell)).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_relative_to_the_page_and_escaped() {
        let from = Path::new("/a/out");
        assert_eq!(address(from, Path::new("/a/out/my run/report.html")), "my%20run/report.html");
        assert_eq!(address(from, Path::new("/a/else/report.html")), "../else/report.html");
    }
}
