//! Writes `report.html` from what a run has left in its folder.

use std::fs;

use cosplat_core::plan::{BoundaryForm, Plan};
use cosplat_core::scene::Scene;

use super::curves::Table;
use super::record::PluginRecord;
use super::summary::Summary;
use super::{LEDGER, PREVIEW, PROBES, REPORT, RunFolder};
use crate::exit::Error;
use crate::frames::Frames;
use crate::page::{self, Picture, Report};

/// What a report is made from, beside the files of the run.
pub(crate) struct Sources<'a> {
    /// The run folder.
    pub(crate) folder: &'a RunFolder,
    /// The scene as run.
    pub(crate) scene: &'a Scene,
    /// Its plan.
    pub(crate) plan: &'a Plan,
    /// Form in which each solver shows its bodies, in plan order.
    pub(crate) forms: Vec<BoundaryForm>,
    /// What each process ran.
    pub(crate) plugins: Vec<PluginRecord>,
    /// What was made of frames.
    pub(crate) frames: Option<&'a Frames>,
}

/// Writes the report of a run.
///
/// # Errors
/// A file of the run cannot be read, or the report cannot be written.
pub(crate) fn write(sources: &Sources<'_>, summary: &Summary) -> Result<(), Error> {
    let Sources { folder, scene, plan, .. } = sources;
    let read = |name: &str| fs::read(folder.file(name)).map_err(|e| Error::io("read", &folder.file(name), &e));
    let table = |name: &str| {
        Table::read(&folder.file(name), summary.windows).map_err(|e| Error::io("read", &folder.file(name), &e))
    };
    let ledger = table(LEDGER)?;
    let probes = if folder.file(PROBES).exists() { table(PROBES)? } else { Table::default() };
    let chosen = chosen(sources);
    let images: Vec<Vec<u8>> = chosen.iter().map(|(name, _)| read(name)).collect::<Result<_, _>>()?;
    let pictures: Vec<Picture<'_>> =
        chosen.iter().zip(&images).map(|((_, caption), png)| Picture { caption, png }).collect();
    let preview = if images.is_empty() { None } else { Some(read(PREVIEW)?) };
    let command: Vec<String> = std::env::args_os().map(|a| a.to_string_lossy().into_owned()).collect();
    let report = Report {
        summary,
        description: &scene.title,
        pictures: &pictures,
        preview: preview.as_deref().map(|png| Picture { caption: "All frames", png }),
        ledger: &ledger.ledger(plan, &sources.forms),
        probes: &probes.probes(),
        command: &command,
        versions: &versions(sources),
    };
    folder.put(REPORT, page::html(&report).as_bytes())
}

/// Names and captions of the first, the middle and the last picture.
fn chosen(sources: &Sources<'_>) -> Vec<(String, String)> {
    let Some(Frames { pictures, .. }) = sources.frames else { return Vec::new() };
    let fps = sources.scene.clock.frames_per_second.unwrap_or(1.0);
    let mut places = vec![0, pictures.len() / 2, pictures.len().saturating_sub(1)];
    places.dedup();
    let picture = |at: usize| Some((pictures.get(at)?.clone(), format!("{:.3} s", at as f64 / fps)));
    places.into_iter().filter_map(picture).collect()
}

fn versions(sources: &Sources<'_>) -> Vec<(String, String)> {
    let own = ("cosplat".to_owned(), env!("CARGO_PKG_VERSION").to_owned());
    let system = ("system".to_owned(), format!("{} {}", std::env::consts::OS, std::env::consts::ARCH));
    let plugins = sources.plugins.iter().map(|p| (format!("{} in process {}", p.name, p.process), p.version.clone()));
    [own, system].into_iter().chain(plugins).collect()
}
