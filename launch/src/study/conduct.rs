//! Runs cases: every combination of what is varied in each.

use std::path::Path;
use std::thread::available_parallelism;

use super::case::{Case, Level};
use super::design::{Settings, settings};
use super::evaluate::{Finished, evaluate};
use super::fingerprint;
use super::outcome::Class;
use super::pool::{Wanted, carry_out};
use super::result::CaseResult;
use crate::exit::Error;
use crate::render::Paint;
use crate::scene_source::{self, Source};
use crate::supervise::signals::Signals;

/// Pictures, which only sheets need.
const PICTURES: &str = "output.pictures=false";
/// What a study does without: it measures solvers and coupling, not files and pictures.
const WITHOUT: [&str; 6] = [
    "output.trace=false",
    "output.report=false",
    PICTURES,
    "output.splats=false",
    "output.surfaces=false",
    "output.recording=false",
];
/// Longest part of a folder's name that says what was varied.
const LONGEST: usize = 60;

/// How a study is carried out.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Conditions<'a> {
    /// Folder of the study.
    pub(crate) out: &'a Path,
    /// Repetitions of each run.
    pub(crate) runs: usize,
    /// Hash of this program.
    pub(crate) program: u128,
    /// Runs that are made side by side.
    pub(crate) jobs: usize,
    /// Whether pictures are drawn.
    pub(crate) pictures: bool,
}

/// What is going on.
#[derive(Clone, Debug)]
pub(crate) enum News {
    /// The run of this name begins.
    Begins(String),
    /// It has ended: its class, and whether all of it was there already.
    Ended(String, Class, bool),
}

/// Cores that this program may use.
pub(crate) fn cores() -> usize {
    available_parallelism().map_or(1, std::num::NonZero::get)
}

/// Runs and evaluates cases; none where the user has stopped it.
///
/// # Errors
/// A scene cannot be used with any of the values, or this machine refuses what is needed to run it. A run that fails
/// is no error but a result.
pub(crate) async fn conduct(
    cases: &[Case],
    conditions: Conditions<'_>,
    signals: &mut Signals,
    tell: &mut impl FnMut(News),
) -> Result<Option<Vec<CaseResult>>, Error> {
    let all: Vec<Case> = cases.iter().flat_map(|case| [Some(case.clone()), case.beside()]).flatten().collect();
    for case in &all {
        check(&scene_source::load(&case.scene)?, &case.set, &settings(&case.vary))?;
    }
    let finished = finish(&all, conditions, signals, tell).await?;
    Ok(finished.map(|finished| {
        let mut runs = finished.into_iter();
        let evaluated = cases.iter().map(|case| {
            let own = runs.next().unwrap_or_default();
            let twins = case.twin.as_ref().and_then(|_| runs.next()).unwrap_or_default();
            evaluate(case, &own, &twins)
        });
        evaluated.collect()
    }))
}

/// Runs cases; none where the user has stopped it.
///
/// # Errors
/// This machine refuses what is needed to run them. A run that fails is no error but a result.
pub(crate) async fn finish(
    cases: &[Case],
    conditions: Conditions<'_>,
    signals: &mut Signals,
    tell: &mut impl FnMut(News),
) -> Result<Option<Vec<Vec<Finished>>>, Error> {
    let mut wanted = Vec::new();
    let all: Vec<Vec<Settings>> = cases.iter().map(|case| settings(&case.vary)).collect();
    for (case, all) in cases.iter().zip(&all) {
        let source = scene_source::load(&case.scene)?;
        for (i, settings) in all.iter().enumerate() {
            let name = match all.len() {
                1 => format!("{}  {}", case.name, case.title),
                many => format!("{} {}/{many}  {}", case.name, i + 1, settings.name()),
            };
            wanted.push(self::wanted(case, &source, settings, conditions, name));
        }
    }
    let Some(trials) = carry_out(&wanted, conditions, signals, tell).await? else { return Ok(None) };
    let mut done = all.iter().flatten().zip(wanted).zip(trials).map(|((settings, wanted), trials)| {
        let folder = wanted.folder.join("1").display().to_string();
        Finished { settings: settings.clone(), trials, folder }
    });
    Ok(Some(all.iter().map(|all| done.by_ref().take(all.len()).collect()).collect()))
}

/// A scene that none of the values fits is a mistake, not a study of refusals.
fn check(source: &Source, set: &[(String, Level)], all: &[Settings]) -> Result<(), Error> {
    let mut first = None;
    for settings in all {
        let overrides: Vec<String> = fixed(set).chain(settings.overrides()).collect();
        match scene_source::parse(source, &overrides, Paint::stderr()) {
            Ok(_) => return Ok(()),
            Err(error) => {
                first.get_or_insert(error);
            }
        }
    }
    first.map_or(Ok(()), Err)
}

/// Values that every run has, as changes for `cosplat run --set`.
fn fixed(set: &[(String, Level)]) -> impl Iterator<Item = String> {
    set.iter().map(|(key, level)| format!("{key}={}", level.toml))
}

fn wanted(case: &Case, source: &Source, settings: &Settings, conditions: Conditions<'_>, name: String) -> Wanted {
    let without = WITHOUT.iter().filter(|what| !(conditions.pictures && **what == PICTURES));
    let mut overrides: Vec<String> = without.map(|&what| what.to_owned()).collect();
    overrides.extend(fixed(&case.set).chain(settings.overrides()));
    let hash = match scene_source::parse(source, &overrides, Paint::stderr()) {
        Ok((scene, _)) => fingerprint::of_run(conditions.program, source, &scene, &overrides),
        // It will be refused, whatever the files are that it would have named.
        Err(_) => fingerprint::of_text(conditions.program, source, &overrides),
    };
    let folder = conditions.out.join("runs").join(folder_name(case, settings, &hash));
    Wanted { scene: case.scene.clone(), overrides, folder, name }
}

/// A name that people can read, with a part of the hash that makes it this run's own.
fn folder_name(case: &Case, settings: &Settings, hash: &str) -> String {
    let values = settings.values.iter().map(|(_, level)| level.shown.as_str());
    let text = [case.name.as_str()].into_iter().chain(values).collect::<Vec<_>>().join("-");
    let plain = |c: char| if c.is_ascii_alphanumeric() || ".-_".contains(c) { c } else { '_' };
    let text: String = text.chars().map(plain).take(LONGEST).collect();
    format!("{text}-{}", &hash[..12])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_that_no_scene_has_is_a_mistake_and_a_value_that_does_not_fit_is_a_result() {
        let source = scene_source::load("oscillator").unwrap();
        let of = |key: &str, values: &[&str]| {
            let values = values.iter().map(|v| Level::of(v)).collect();
            check(&source, &[], &settings(&[super::super::case::Factor { key: key.into(), values }]))
        };
        assert!(of("clock.window", &["-1", "0.01"]).is_ok());
        let error = of("clock.windw", &["0.02", "0.01"]).unwrap_err();
        assert!(error.problems[0].message.contains("windw"), "{error:?}");
    }
}
