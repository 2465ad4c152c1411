//! `run.toml`: what is needed to understand a run and to repeat it.

use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

use cosplat_core::control::PROTOCOL;
use cosplat_core::plan::{LeftOut, Plan};
use serde::Serialize;

use super::MARK;
use crate::exit::{Code, Error, Problem};

/// Everything the record says.
#[derive(Debug, Serialize)]
pub(crate) struct Record<'a> {
    run: Run,
    scene: SceneRecord<'a>,
    plugins: Vec<PluginRecord>,
    left_out: Vec<LeftOut>,
    plan: &'a Plan,
}

/// How the run was started.
#[derive(Debug, Serialize)]
struct Run {
    /// Version of this program.
    cosplat: &'static str,
    /// Version of the bus protocol.
    protocol: u16,
    /// Start of the run, UTC.
    started: String,
    /// Command line, program first.
    command: Vec<String>,
    /// Folder in which it was given.
    folder: String,
    /// Threads asked for; absent means the machine's cores.
    #[serde(skip_serializing_if = "Option::is_none")]
    threads: Option<usize>,
    /// Seed of random numbers.
    seed: &'static str,
    /// Operating system and processor.
    system: String,
}

/// The scene as given.
#[derive(Debug, Serialize)]
struct SceneRecord<'a> {
    name: &'a str,
    /// File, or `built-in`.
    source: String,
    /// Values changed on the command line.
    overrides: &'a [String],
    /// Plugins changed on the command line.
    solvers: &'a [String],
    /// Text of the scene file, without the overrides.
    text: &'a str,
}

/// A plugin of the run.
#[derive(Debug, Serialize)]
pub(crate) struct PluginRecord {
    /// Process that runs it.
    pub(crate) process: String,
    /// Name it gave.
    pub(crate) name: String,
    /// Version it gave.
    pub(crate) version: String,
    /// Command it was started with.
    pub(crate) command: Vec<String>,
}

/// What the record is made from, beside the plan.
#[derive(Debug)]
pub(crate) struct Facts<'a> {
    /// Name of the scene.
    pub(crate) name: &'a str,
    /// Its file; none for a built-in scene.
    pub(crate) file: Option<&'a Path>,
    /// Its text.
    pub(crate) text: &'a str,
    /// Values changed on the command line.
    pub(crate) overrides: &'a [String],
    /// Threads asked for.
    pub(crate) threads: Option<usize>,
    /// Moment at which the run began.
    pub(crate) started: SystemTime,
}

/// The record as text; `solvers` are the plugins changed on the command line.
///
/// # Errors
/// The plan holds something that TOML cannot.
pub(crate) fn text(
    facts: &Facts<'_>,
    solvers: &[String],
    plan: &Plan,
    plugins: Vec<PluginRecord>,
    left_out: &[LeftOut],
) -> Result<String, Error> {
    let record = Record {
        run: Run {
            cosplat: env!("CARGO_PKG_VERSION"),
            protocol: PROTOCOL,
            started: utc(facts.started),
            command: std::env::args_os().map(|a| a.to_string_lossy().into_owned()).collect(),
            folder: std::env::current_dir().map(|d| d.display().to_string()).unwrap_or_default(),
            threads: facts.threads,
            seed: "none: nothing in this run is random",
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
        },
        scene: SceneRecord {
            name: facts.name,
            source: facts.file.map_or_else(|| "built-in".into(), |f| f.display().to_string()),
            overrides: facts.overrides,
            solvers,
            text: facts.text,
        },
        plugins,
        left_out: left_out.to_vec(),
        plan,
    };
    let body = toml::to_string(&record).map_err(|e| {
        Error::new(Code::Environment, Problem::new("The record of the run cannot be written as TOML").because(e))
    })?;
    Ok(format!("{MARK} A folder with this file may be replaced by the next run.\n\n{body}"))
}

/// Seconds per day.
const DAY_S: u64 = 86_400;

/// A moment as `2026-01-31T12:00:00Z`.
pub(crate) fn utc(moment: SystemTime) -> String {
    let since = moment.duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
    let (days, second) = (since / DAY_S, since % DAY_S);
    // Days to a date in the proleptic Gregorian calendar, with years that begin in March.
    // Source: Howard Hinnant, "chrono-Compatible Low-Level Date Algorithms", civil_from_days.
    let shifted = days + 719_468;
    let (era, day_of_era) = (shifted / 146_097, shifted % 146_097);
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    let year = year_of_era + era * 400 + u64::from(month <= 2);
    let (hour, minute, second) = (second / 3600, second / 60 % 60, second % 60);
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}Z")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::folder::fixtures::plan;
    use std::time::Duration;

    #[test]
    fn the_record_is_toml_and_holds_the_scene_as_given() {
        let scene = "name = \"x\"\n# a comment, '''quotes''' and \"\"\"more\"\"\"\n\t[clock]\n";
        let overrides = ["clock.window=0.005".to_owned()];
        let facts =
            Facts { name: "x", file: None, text: scene, overrides: &overrides, threads: Some(2), started: UNIX_EPOCH };
        let left_out = LeftOut {
            what: "viewer".into(),
            why: "nobody asked".into(),
            indicator: None,
            limit: Some(0.5),
            saved: "not measured".into(),
        };
        let text = text(&facts, &[], &plan(3), Vec::new(), &[left_out]).unwrap();
        assert!(text.starts_with(MARK));
        let table: toml::Table = text.parse().unwrap();
        assert_eq!(table["scene"]["text"].as_str(), Some(scene));
        assert_eq!(table["scene"]["overrides"][0].as_str(), Some("clock.window=0.005"));
        assert_eq!(table["plan"]["clock"]["windows"].as_integer(), Some(3));
        assert_eq!(table["left_out"][0]["what"].as_str(), Some("viewer"));
    }

    #[test]
    fn moments_are_written_as_dates() {
        let at = |s| utc(UNIX_EPOCH + Duration::from_secs(s));
        assert_eq!(at(0), "1970-01-01T00:00:00Z");
        assert_eq!(at(951_827_696), "2000-02-29T12:34:56Z");
        assert_eq!(at(4_102_444_799), "2099-12-31T23:59:59Z");
    }
}
