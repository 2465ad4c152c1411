//! `cosplat run`: checks a scene, runs it, and leaves a run folder.

use std::path::PathBuf;
use std::time::Duration;

use cosplat_bus::Life;
use cosplat_core::coordinator::Limits;
use cosplat_core::plan::Interface;
use cosplat_core::scene::{Break, Scene};

use super::conduct::Conduct;
use super::resume::Earlier;
use crate::cli::{Format, RunArgs, SceneArgs};
use crate::exit::{Code, Error};
use crate::folder::checkpoints::{Checkpoints, TakenUp};
use crate::folder::report::Sources;
use crate::folder::summary::{PresetNote, Status};
use crate::folder::{self, RunFolder, SUMMARY};
use crate::hint::count;
use crate::prepare::{Prepared, prepare};
use crate::progress::Progress;
use crate::render::{self, Paint, json, print, talk};
use crate::report;
use crate::scene_source::{self, DEFAULT};
use crate::supervise::signals::Signals;
use crate::supervise::{self, Job};
use crate::viewer::{Viewer, Wish};

/// Runs a scene.
///
/// # Errors
/// The scene cannot run, or the run folder cannot be used. A run that has begun and fails is reported here, with its
/// summary, and gives the exit code of its failure.
pub(crate) async fn run(args: &RunArgs, signals: &mut Signals) -> Result<Code, Error> {
    if args.ends_with_parent {
        // Where the system lacks it, a parent that is killed leaves this run to end by itself.
        let _ = rustix::process::set_parent_process_death_signal(Some(rustix::process::Signal::KILL));
    }
    let earlier = args.resume.as_ref().map(|folder| Earlier::open(folder, args.changes.threads)).transpose()?;
    let (source, changes) = match &earlier {
        Some(earlier) => (earlier.source.clone(), earlier.changes.clone()),
        None => (scene_source::load(args.scene.as_deref().unwrap_or(DEFAULT))?, args.changes.clone()),
    };
    let wish = Wish::of(args);
    let changes = SceneArgs { live: matches!(wish, Ok(Some(_))), ..changes };
    let prepared = tokio::select! {
        prepared = prepare(source, &changes, Paint::stderr()) => prepared?,
        _ = signals.next() => return Ok(Code::Interrupted),
    };
    let mut progress = Progress::new(prepared.plan.clock.windows, seconds(&prepared), args.quiet);
    introduce(&prepared, &progress, args.quiet);
    let Course { folder, checkpoints, taken_up, started } = course(args, earlier, &prepared)?;
    let from = taken_up.as_ref().map(|from| from.checkpoint.clone());
    if let Some(from) = &from {
        progress.say("resume", &format!("from the checkpoint of the start of window {}", from.window));
    }
    let every = checkpoints.as_ref().map(Checkpoints::every);
    let life = match &checkpoints {
        Some(checkpoints) => checkpoints.life(from)?,
        None => Life::first().map_err(|e| supervise::bus_error(&e))?,
    };
    let sums = taken_up.map(|from| from.sums);
    let mut conduct = Conduct::begin(&changes, &prepared, &folder, checkpoints, sums, started)?;
    let viewer = show(wish, &progress);
    let recorder = conduct.recorder_of_frames(viewer.as_ref())?;
    let job = Job {
        plan: &prepared.plan,
        scenes: prepared.scenes.clone(),
        commands: prepared.commands(),
        limits: Limits { checkpoint_every: every, ..limits(&prepared.scene) },
        life,
        folder: &folder,
        recorder,
    };
    let ended = supervise::run(job, signals, &mut |news| conduct.hear(news, &mut progress)).await;
    progress.finish();
    drop(viewer);
    let resumable = conduct.checkpoints.as_ref().and_then(|kept| kept.newest);
    let (summary, error, frames) = conduct.end(ended);
    let json = json(&summary)?;
    folder.put(SUMMARY, json.as_bytes())?;
    if prepared.scene.output.report {
        let sources = Sources {
            folder: &folder,
            scene: &prepared.scene,
            plan: &prepared.plan,
            forms: prepared.forms(),
            plugins: prepared.plugin_records(),
            frames: frames.as_ref(),
        };
        folder::report::write(&sources, &summary)?;
    }
    if let Some(error) = &error {
        talk(&render::error(Paint::stderr(), error));
    }
    if let (Some(window), Status::Failed | Status::Interrupted) = (resumable, summary.status) {
        progress
            .say("resume", &format!("`cosplat run --resume {}` goes on at window {window}", folder.path().display()));
    }
    match args.format {
        Format::Json => print(&json)?,
        Format::Human if args.quiet => {}
        Format::Human => print(&report::human(&summary, folder.path(), Paint::stdout()))?,
    }
    Ok(match (summary.status, error) {
        (Status::Ok, _) => Code::Ok,
        (Status::VerdictFailed, _) => Code::Verdict,
        (Status::Interrupted, _) => Code::Interrupted,
        (Status::Failed, error) => error.map_or(Code::Process, |e| e.code),
    })
}

/// Where a run writes, and where it begins.
struct Course {
    folder: RunFolder,
    /// Where checkpoints are wanted.
    checkpoints: Option<Checkpoints>,
    /// Where it does not begin at t = 0.
    taken_up: Option<TakenUp>,
    /// When it was begun, where that was before.
    started: Option<String>,
}

/// Claims the folder of a new run, or goes on in that of an earlier one.
fn course(args: &RunArgs, earlier: Option<Earlier>, prepared: &Prepared) -> Result<Course, Error> {
    // At least so much time lies between two; windows are the smallest part of it.
    let windows = |seconds: f64| (seconds / prepared.plan.clock.window_s()).ceil().max(1.0) as u64;
    let every = args.checkpoint_every.map(windows);
    if let Some(earlier) = earlier {
        let (checkpoints, taken_up) = earlier.take_up(prepared, every)?;
        earlier.folder.forget_end()?;
        let (folder, started) = (earlier.folder, Some(earlier.started));
        return Ok(Course { folder, checkpoints: Some(checkpoints), taken_up: Some(taken_up), started });
    }
    let path = args.out.clone().unwrap_or_else(|| PathBuf::from("out").join(&prepared.scene.name));
    let folder = RunFolder::claim(&path)?;
    let checkpoints = every.map(|every| Checkpoints::begin(&folder, every, &prepared.commands())).transpose()?;
    Ok(Course { folder, checkpoints, taken_up: None, started: None })
}

/// Opens what the run is shown in. Nothing about it is a reason not to run.
fn show(wish: Result<Option<Wish>, String>, progress: &Progress) -> Option<Viewer> {
    let viewer = wish.and_then(|wish| {
        let opened = wish.map(|wish| wish.open()).transpose();
        opened.map_err(|e| format!("the viewer cannot be opened: {e}; the run goes on without"))
    });
    match viewer {
        Ok(viewer) => {
            if let Some(viewer) = &viewer {
                progress.say("live", &viewer.says);
            }
            viewer
        }
        Err(why) => {
            progress.warn(&why);
            None
        }
    }
}

/// Simulated time of all windows \[s\].
fn seconds(prepared: &Prepared) -> f64 {
    let clock = prepared.plan.clock;
    clock.seconds(clock.start_of(clock.windows))
}

fn limits(scene: &Scene) -> Limits {
    let mut limits = Limits::default();
    // What is no duration keeps the default; the scene reader lets only positive numbers through.
    limits.silence = Duration::try_from_secs_f64(scene.run.silence_limit_s).unwrap_or(limits.silence);
    limits.join = Duration::try_from_secs_f64(scene.run.join_limit_s).unwrap_or(limits.join);
    limits
}

/// Says what is about to run.
fn introduce(prepared: &Prepared, progress: &Progress, is_quiet: bool) {
    let Prepared { scene, plan, warnings, .. } = prepared;
    if !is_quiet {
        for warning in warnings {
            talk(warning.drawn.as_deref().unwrap_or(&warning.message));
        }
    }
    progress.say("scene", &format!("{}: {}", scene.name, scene.title));
    let windows = usize::try_from(plan.clock.windows).unwrap_or(usize::MAX);
    let text = format!(
        "{}, {}, {} of {} s, bound by {}",
        count(plan.solver_count(), "process", "processes"),
        count(plan.interfaces.len(), "interface", "interfaces"),
        count(windows, "window", "windows"),
        plan.clock.window_s(),
        plan.window_bound_by
    );
    progress.say("plan", &text);
    for kept in &prepared.kept {
        progress.say("keep", &format!("{}: {}", kept.body, kept.kept()));
    }
    for (body, words) in &prepared.geometry.notes {
        progress.say("body", &format!("{body}: {words}"));
    }
    for preset in PresetNote::of(scene) {
        progress.say("preset", &preset.words());
    }
    let is_idle = plan.break_with.is_some_and(Break::needs_impulses);
    if is_idle && !plan.interfaces.iter().any(Interface::carries_impulses) {
        progress.warn("`run.break` does nothing here: no impulses cross between processes");
    }
}
