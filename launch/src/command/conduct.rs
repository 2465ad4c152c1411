//! A run that goes on: what is heard about it is written down, counted, and judged at the end.

use std::sync::mpsc::{Sender, channel};
use std::time::{Instant, SystemTime};

use cosplat_bus::CoordinatorEvent;
use cosplat_core::checkpoint::Checkpoint;
use cosplat_core::control::FIRST_EPOCH;
use cosplat_core::coordinator::Outcome;

use super::failure;
use crate::cli::SceneArgs;
use crate::estimate::{EnergyBudget, estimates, foresight, resolutions};
use crate::exit::{Code, Error, Problem};
use crate::folder::checkpoints::{Checkpoints, Sums};
use crate::folder::record::{self, Facts};
use crate::folder::recorder::Recorder;
use crate::folder::summary::{self, PresetNote, Status, Summary};
use crate::folder::{RUN, RunFolder, recording};
use crate::frames::{FrameRecorder, Frames, Row, Wanted, liquids};
use crate::prepare::Prepared;
use crate::progress::Progress;
use crate::supervise::usage::Usage;
use crate::supervise::{Ended, News};
use crate::viewer::Viewer;

/// A run that has begun: what is written while it goes on, and what is known about it at its end.
pub(super) struct Conduct<'a> {
    prepared: &'a Prepared,
    folder: &'a RunFolder,
    recorder: Recorder<'a>,
    facts: Facts<'a>,
    solvers: Vec<String>,
    /// Where curves for a recording go, where there is one.
    rows: Option<Sender<Row>>,
    /// Where any are kept.
    pub(super) checkpoints: Option<Checkpoints>,
    /// When the run was begun, where that was before: its record is kept as it is.
    begun: Option<String>,
    started: Instant,
    /// Wall time of earlier lives of the run \[s\].
    before_s: f64,
    /// Wall time from the start of the run to the last settled window \[s\].
    wall_s: f64,
}

impl<'a> Conduct<'a> {
    /// Opens the files, anew or behind what an earlier life of the run has counted.
    ///
    /// # Errors
    /// A file cannot be read or written.
    pub(super) fn begin(
        changes: &'a SceneArgs,
        prepared: &'a Prepared,
        folder: &'a RunFolder,
        checkpoints: Option<Checkpoints>,
        sums: Option<Sums>,
        begun: Option<String>,
    ) -> Result<Self, Error> {
        let facts = Facts {
            name: &prepared.scene.name,
            file: prepared.source.file.as_deref(),
            text: &prepared.source.text,
            overrides: &changes.set,
            threads: prepared.scene.run.threads,
            started: SystemTime::now(),
        };
        let solvers = changes.solver.iter().map(|(key, plugin)| format!("{key}={plugin}")).collect();
        let before_s = sums.as_ref().map_or(0.0, |sums| sums.wall_s);
        let recorder = match sums {
            Some(sums) => Recorder::reopen(folder, &prepared.plan, &prepared.scene, sums.tally)?,
            None => Recorder::create(folder, &prepared.plan, &prepared.scene, prepared.forms())?,
        };
        let (started, rows) = (Instant::now(), None);
        let wall_s = before_s;
        let conduct =
            Self { prepared, folder, recorder, facts, solvers, rows, checkpoints, begun, started, before_s, wall_s };
        conduct.write_record()?;
        Ok(conduct)
    }

    /// What takes the frames, where the plan has any.
    pub(super) fn recorder_of_frames(&mut self, viewer: Option<&Viewer>) -> Result<Option<FrameRecorder>, Error> {
        let Prepared { scene, plan, geometry, .. } = self.prepared;
        let (Some(recorder), Some(frames_per_second), Some(shot)) =
            (plan.recorder, scene.clock.frames_per_second, geometry.shot.clone())
        else {
            return Ok(None);
        };
        let (post, rows) = channel();
        self.rows = Some(post);
        let wanted = Wanted {
            folder: self.folder.path().to_owned(),
            scene: scene.name.clone(),
            run: format!("{}-{}", scene.name, self.begun.clone().unwrap_or_else(|| record::utc(self.facts.started))),
            recording: recording(self.checkpoints.as_ref().map_or(FIRST_EPOCH, Checkpoints::epoch)),
            is_kept: self.checkpoints.is_some(),
            output: scene.output.clone(),
            frames_per_second,
            windows_per_frame: recorder.windows_per_frame,
            shot,
            live: viewer.map(|v| v.to),
            liquids: liquids(scene),
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
        if self.begun.is_some() {
            return Ok(());
        }
        let Self { prepared, recorder, facts, solvers, .. } = self;
        let text = record::text(facts, solvers, &prepared.plan, prepared.plugin_records(), &recorder.left_out())?;
        self.folder.put(RUN, text.as_bytes())
    }

    pub(super) fn hear(&mut self, news: News, progress: &mut Progress) -> Result<(), Error> {
        match news {
            News::Spawned(who, pid) => {
                let plan = &self.prepared.plan;
                let plugin = plan.participants.get(usize::from(who)).map_or("?", |p| p.plugin.as_str());
                progress.say("start", &format!("{} ({plugin}), process {pid}", plan.name_of(who)));
            }
            News::Stopping(asked) => {
                let how = if self.checkpoints.is_some() { ", with a checkpoint" } else { "" };
                progress
                    .warn(&format!("{asked}: the run ends at the edge of a window{how}; once more ends it at once"));
            }
            News::Tick => progress.tick(),
            News::Checkpoint(checkpoint, handle) => {
                let stored = self.store(&checkpoint);
                handle.recorded(checkpoint.window, stored.map_err(|e| e.to_string()));
            }
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
                    self.wall_s = self.before_s + self.started.elapsed().as_secs_f64();
                    if let Some(checkpoints) = &mut self.checkpoints {
                        checkpoints.note(&self.recorder.tally, self.wall_s);
                    }
                    progress.settled(record.window + 1, record.end_s);
                }
                CoordinatorEvent::Notice(text) => progress.warn(&text),
                CoordinatorEvent::Checkpoint(_) | CoordinatorEvent::Ended(_) => {}
            },
        }
        Ok(())
    }

    /// Stores a checkpoint, behind all that it stands for.
    fn store(&mut self, checkpoint: &Checkpoint) -> std::io::Result<()> {
        self.recorder.sync()?;
        let Some(checkpoints) = &mut self.checkpoints else { return Ok(()) };
        checkpoints.store(checkpoint, &self.recorder.tally, self.wall_s)
    }

    /// Closes the files and judges the run.
    pub(super) fn end(mut self, ended: Result<Ended, Error>) -> (Summary, Option<Error>, Option<Frames>) {
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
        let scene = self.prepared.scene.clone();
        let mut summary = self.summary(status, usage);
        let interfaces = &summary.interfaces;
        let of_scene = [resolutions(&scene, interfaces), foresight(&scene, interfaces, summary.window_s)];
        summary.verdicts = verdicts;
        summary.estimates = estimates(&summary);
        summary.energy_budget = EnergyBudget::of(&summary);
        summary.estimates.extend(of_scene.into_iter().flatten());
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
            estimates: Vec::new(),
            energy_budget: None,
            presets: PresetNote::of(&self.prepared.scene),
            left_out: left_out.iter().map(Into::into).collect(),
            files,
        }
    }
}

fn frames_of(frames: &Frames) -> summary::Frames {
    let Frames { taken, skin_s, draw_s, write_s, record_s, .. } = *frames;
    summary::Frames { taken, skin_s, draw_s, write_s, record_s, drawn_by: frames.drawn_by.clone() }
}
