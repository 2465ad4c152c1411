//! Runs a case: every combination of what is varied, one process after the other, because times are taken.

use std::path::Path;

use super::case::{Case, Level};
use super::design::{Settings, settings};
use super::evaluate::{Finished, evaluate};
use super::fingerprint;
use super::outcome::Class;
use super::result::CaseResult;
use super::trial::{self, Trial};
use crate::exit::Error;
use crate::render::Paint;
use crate::scene_source::{self, Source};
use crate::supervise::signals::Signals;

/// What a study does without: it measures solvers and coupling, not files and pictures.
const WITHOUT: [&str; 5] = [
    "output.trace=false",
    "output.report=false",
    "output.pictures=false",
    "output.splats=false",
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
}

/// What is going on.
#[derive(Clone, Debug)]
pub(crate) enum News {
    /// This run begins: its number from 1, of how many, and its name.
    Begins(usize, usize, String),
    /// This run has ended: its class, and whether all of it was there already.
    Ended(Class, bool),
}

/// Runs and evaluates a case; none where the user has stopped it.
///
/// # Errors
/// The scene cannot be used with any of the values, or this machine refuses what is needed to run it. A run that fails
/// is no error but a result.
pub(crate) async fn conduct(
    case: &Case,
    conditions: Conditions<'_>,
    signals: &mut Signals,
    tell: &mut impl FnMut(News),
) -> Result<Option<CaseResult>, Error> {
    let source = scene_source::load(&case.scene)?;
    let all = settings(&case.vary);
    check(&source, &case.set, &all)?;
    let mut finished = Vec::new();
    for (i, settings) in all.iter().enumerate() {
        tell(News::Begins(i + 1, all.len(), settings.name()));
        let Some(done) = repeat(case, &source, settings, conditions, signals).await? else { return Ok(None) };
        if let Some(first) = done.trials.first() {
            tell(News::Ended(first.class(), done.trials.iter().all(|t| t.cached)));
        }
        finished.push(done);
    }
    Ok(Some(evaluate(case, &finished)))
}

/// Runs a scene that nothing is varied in; none where the user has stopped it.
///
/// # Errors
/// This machine refuses what is needed to run it. A run that fails is no error but a result.
pub(crate) async fn once(
    case: &Case,
    conditions: Conditions<'_>,
    signals: &mut Signals,
) -> Result<Option<Finished>, Error> {
    let source = scene_source::load(&case.scene)?;
    repeat(case, &source, &Settings { values: Vec::new() }, conditions, signals).await
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

async fn repeat(
    case: &Case,
    source: &Source,
    settings: &Settings,
    conditions: Conditions<'_>,
    signals: &mut Signals,
) -> Result<Option<Finished>, Error> {
    let mut overrides: Vec<String> = WITHOUT.map(str::to_owned).to_vec();
    overrides.extend(fixed(&case.set).chain(settings.overrides()));
    let hash = match scene_source::parse(source, &overrides, Paint::stderr()) {
        Ok((scene, _)) => fingerprint::of_run(conditions.program, source, &scene, &overrides),
        // It will be refused, whatever the files are that it would have named.
        Err(_) => fingerprint::of_text(conditions.program, source, &overrides),
    };
    let folder = conditions.out.join("runs").join(folder_name(case, settings, &hash));
    let mut trials: Vec<Trial> = Vec::new();
    for number in 1..=conditions.runs {
        let place = folder.join(number.to_string());
        let trial = match Trial::kept(&place) {
            Some(kept) => kept,
            None => match run(&case.scene, &overrides, &folder, &place, signals).await? {
                Some(trial) => trial,
                None => return Ok(None),
            },
        };
        // What has no result takes no time worth measuring.
        let is_worth_repeating = matches!(trial.class(), Class::Correct | Class::Degraded);
        trials.push(trial);
        if !is_worth_repeating {
            break;
        }
    }
    Ok(Some(Finished { settings: settings.clone(), trials, folder: folder.join("1").display().to_string() }))
}

async fn run(
    scene: &str,
    overrides: &[String],
    folder: &Path,
    place: &Path,
    signals: &mut Signals,
) -> Result<Option<Trial>, Error> {
    std::fs::create_dir_all(folder).map_err(|e| Error::io("create", folder, &e))?;
    trial::run(scene, overrides, place, signals).await
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
