//! `cosplat run`: checks a scene, runs it, and leaves a run folder.

use std::path::PathBuf;
use std::sync::mpsc::{Sender, channel};
use std::time::{Duration, Instant, SystemTime};

use cosplat_bus::CoordinatorEvent;
use cosplat_core::coordinator::{Limits, Outcome};
use cosplat_core::plan::Interface;
use cosplat_core::scene::Scene;

use super::failure;
use crate::cli::{Format, RunArgs};
use crate::exit::{Code, Error, Problem};
use crate::folder::record::{self, Facts};
use crate::folder::recorder::Recorder;
use crate::folder::report::Sources;
use crate::folder::summary::{self, Status, Summary};
use crate::folder::{self, RUN, RunFolder, SUMMARY};
use crate::frames::{FrameRecorder, Frames, Row, Wanted};
use crate::hint::count;
use crate::prepare::{Prepared, prepare};
use crate::progress::Progress;
use crate::render::{self, Paint, json, print, talk};
use crate::report;
use crate::scene_source::DEFAULT;
use crate::supervise::signals::Signals;
use crate::supervise::usage::Usage;
use crate::supervise::{self, Ended, Job, News};

/// Runs a scene.
///
/// # Errors
/// The scene cannot run, or the run folder cannot be used. A run that has begun and fails is reported here, with its
/// summary, and gives the exit code of its failure.
pub(crate) async fn run(args: &RunArgs, signals: &mut Signals) -> Result<Code, Error> {
    let wanted = args.scene.as_deref().unwrap_or(DEFAULT);
    let prepared = tokio::select! {
        prepared = prepare(wanted, &args.changes, Paint::stderr()) => prepared?,
        _ = signals.next() => return Ok(Code::Interrupted),
    };
    let mut progress = Progress::new(prepared.plan.clock.windows, seconds(&prepared), args.quiet);
    introduce(&prepared, &progress, args.quiet);
    let path = args.out.clone().unwrap_or_else(|| PathBuf::from("out").join(&prepared.scene.name));
    let folder = RunFolder::claim(&path)?;
    let mut conduct = Conduct::begin(args, &prepared, &folder)?;
    let recorder = conduct.recorder_of_frames()?;
    let job = Job {
        plan: &prepared.plan,
        scenes: prepared.scenes.clone(),
        commands: prepared.commands(),
        limits: limits(&prepared.scene),
        folder: &folder,
        recorder,
    };
    let ended = supervise::run(job, signals, &mut |news| conduct.hear(news, &mut progress)).await;
    progress.finish();
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
    if plan.break_with.is_some() && !plan.interfaces.iter().any(Interface::carries_impulses) {
        progress.warn("`run.break` does nothing here: no impulses cross between processes");
    }
}

fn frames_of(frames: &Frames) -> summary::Frames {
    let Frames { taken, skin_s, draw_s, write_s, record_s, .. } = *frames;
    summary::Frames { taken, skin_s, draw_s, write_s, record_s }
}

/// A run that has begun: what is written while it goes on, and what is known about it at its end.
struct Conduct<'a> {
    prepared: &'a Prepared,
    folder: &'a RunFolder,
    recorder: Recorder<'a>,
    facts: Facts<'a>,
    solvers: Vec<String>,
    /// Where curves for a recording go, where there is one.
    rows: Option<Sender<Row>>,
    started: Instant,
    /// Wall time from the start of the run to the last settled window \[s\].
    wall_s: f64,
}

impl<'a> Conduct<'a> {
    fn begin(args: &'a RunArgs, prepared: &'a Prepared, folder: &'a RunFolder) -> Result<Self, Error> {
        let facts = Facts {
            name: &prepared.scene.name,
            file: prepared.source.file.as_deref(),
            text: &prepared.source.text,
            overrides: &args.changes.set,
            threads: prepared.scene.run.threads,
            started: SystemTime::now(),
        };
        let solvers = args.changes.solver.iter().map(|(key, plugin)| format!("{key}={plugin}")).collect();
        let recorder = Recorder::create(folder, &prepared.plan, &prepared.scene, prepared.forms())?;
        let (started, wall_s) = (Instant::now(), 0.0);
        let conduct = Self { prepared, folder, recorder, facts, solvers, rows: None, started, wall_s };
        conduct.write_record()?;
        Ok(conduct)
    }

    /// What takes the frames, where the plan has any.
    fn recorder_of_frames(&mut self) -> Result<Option<FrameRecorder>, Error> {
        let Prepared { scene, plan, geometry, .. } = self.prepared;
        let (Some(recorder), Some(frames_per_second), Some(camera)) =
            (plan.recorder, scene.clock.frames_per_second, geometry.camera)
        else {
            return Ok(None);
        };
        let (post, rows) = channel();
        self.rows = Some(post);
        let wanted = Wanted {
            folder: self.folder.path().to_owned(),
            scene: scene.name.clone(),
            run: format!("{}-{}", scene.name, record::utc(self.facts.started)),
            output: scene.output.clone(),
            frames_per_second,
            windows_per_frame: recorder.windows_per_frame,
            camera,
            drawn: geometry.drawn.clone(),
            rows,
        };
        let refused = |why: String| {
            let problem = Problem::new("Cannot begin to write frames").because(why);
            Error::new(Code::Environment, problem.hint("choose a folder that you may write to with `--out DIR`"))
        };
        FrameRecorder::start(wanted).map(Some).map_err(refused)
    }

    /// Writes the record with what is known by now about what was left out.
    fn write_record(&self) -> Result<(), Error> {
        let Self { prepared, recorder, facts, solvers, .. } = self;
        let text = record::text(facts, solvers, &prepared.plan, prepared.plugin_records(), &recorder.left_out())?;
        self.folder.put(RUN, text.as_bytes())
    }

    fn hear(&mut self, news: News, progress: &mut Progress) -> Result<(), Error> {
        match news {
            News::Spawned(who, pid) => {
                let plan = &self.prepared.plan;
                let plugin = plan.participants.get(usize::from(who)).map_or("?", |p| p.plugin.as_str());
                progress.say("start", &format!("{} ({plugin}), process {pid}", plan.name_of(who)));
            }
            News::Stopping(asked) => {
                progress.warn(&format!("{asked}: the run ends at the edge of a window; once more ends it at once"));
            }
            News::Tick => progress.tick(),
            News::Bus(event) => match event {
                CoordinatorEvent::Ready(who, info) => self.recorder.ready(who, *info),
                CoordinatorEvent::Started => {
                    progress.started();
                    self.recorder.started()?;
                    self.write_record()?;
                }
                CoordinatorEvent::Settled(record, done) => {
                    self.recorder.settled(&record, &done)?;
                    if let Some(rows) = &self.rows {
                        // Where the recorder has failed, the run is about to say so.
                        let _ = rows.send(Row::new(&self.prepared.plan, &record, &done));
                    }
                    self.wall_s = self.started.elapsed().as_secs_f64();
                    progress.settled(record.window + 1, record.end_s);
                }
                CoordinatorEvent::Notice(text) => progress.warn(&text),
                CoordinatorEvent::Ended(_) => {}
            },
        }
        Ok(())
    }

    /// Closes the files and judges the run.
    fn end(mut self, ended: Result<Ended, Error>) -> (Summary, Option<Error>, Option<Frames>) {
        let finished = self.recorder.finish();
        // What ended the run is worth more than a file that could not be closed after it.
        let ended = ended.and_then(|ended| finished.map(|()| ended));
        let (outcome, usage, error) = match ended {
            Err(error) => (None, Vec::new(), Some(error)),
            Ok(Ended { outcome, usage, last_words, frames }) => {
                self.recorder.frames = frames;
                let error = match &outcome {
                    Some(Outcome::Failed(f)) => {
                        Some(failure::explain(f, &self.prepared.plan, self.folder, &last_words))
                    }
                    _ => None,
                };
                (outcome, usage, error)
            }
        };
        let verdicts = self.recorder.tally.verdicts();
        let status = match (&error, outcome) {
            (Some(_), _) => Status::Failed,
            (None, Some(Outcome::Finished)) if verdicts.iter().all(|v| v.passed) => Status::Ok,
            (None, Some(Outcome::Finished)) => Status::VerdictFailed,
            (None, _) => Status::Interrupted,
        };
        let frames = self.recorder.frames.clone();
        let mut summary = self.summary(status, usage);
        summary.verdicts = verdicts;
        if let Some(error) = &error {
            summary.exit_code = error.code as u8;
            summary.failure = error.problems.first().map(|p| p.message.clone());
        }
        (summary, error, frames)
    }

    fn summary(self, status: Status, usage: Vec<Usage>) -> Summary {
        let plan = &self.prepared.plan;
        let left_out = self.recorder.left_out();
        let frames = self.recorder.frames.as_ref().map(frames_of);
        let files = self.recorder.files();
        let tally = self.recorder.tally;
        let mut bodies = tally.bodies;
        for body in &mut bodies {
            body.gaussians = self.prepared.geometry.gaussians(&body.name);
        }
        let mut processes = tally.processes;
        for (process, usage) in processes.iter_mut().zip(usage) {
            process.cpu_s = usage.cpu_s;
            process.peak_rss_mib = usage.peak_rss_mib;
        }
        Summary {
            status,
            exit_code: match status {
                Status::Ok => Code::Ok,
                Status::VerdictFailed => Code::Verdict,
                Status::Interrupted => Code::Interrupted,
                Status::Failed => Code::Process,
            } as u8,
            failure: None,
            scene: self.prepared.scene.name.clone(),
            windows: tally.windows,
            window_s: plan.clock.window_s(),
            window_bound_by: plan.window_bound_by.clone(),
            simulated_s: tally.simulated_s,
            wall_s: self.wall_s,
            state_hash: tally.state_hash.map(|h| format!("{h:032x}")),
            verdicts: Vec::new(),
            processes,
            frames,
            bodies,
            interfaces: tally.interfaces,
            energy: tally.energy,
            counters: tally.counters,
            left_out: left_out.iter().map(Into::into).collect(),
            files,
        }
    }
}
