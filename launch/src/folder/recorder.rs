//! Writes the run folder while a run goes on.

use std::collections::BTreeMap;
use std::io;
use std::path::Path;

use cosplat_core::control::{Done, ReadyInfo};
use cosplat_core::ledger::WindowRecord;
use cosplat_core::plan::{BoundaryForm, LeftOut, ParticipantId, Plan};
use cosplat_core::scene::Scene;

use super::ledger::Ledger;
use super::probes::{self, Probes};
use super::tally::Tally;
use super::trace::Trace;
use super::{
    CONDITIONS, LEDGER, PICTURES, PREVIEW, PROBES, RECORDING, RUN, RunFolder, SPLATS, SUMMARY, SURFACES, TRACE, VIDEO,
};
use crate::exit::{Code, Error, Problem};
use crate::frames::Frames;

/// Every file that grows with the run, and the sums for its summary.
#[derive(Debug)]
pub(crate) struct Recorder<'a> {
    folder: &'a RunFolder,
    plan: &'a Plan,
    scene: &'a Scene,
    ledger: Ledger,
    probes: Option<Probes>,
    trace: Option<Trace>,
    ready: Vec<Option<ReadyInfo>>,
    /// Sums for the summary.
    pub(crate) tally: Tally,
    /// What was made of frames, once it is known.
    pub(crate) frames: Option<Frames>,
    /// The run is taken up in the middle: what there is to know about its beginning is known.
    is_resumed: bool,
}

impl<'a> Recorder<'a> {
    /// Opens the files that the scene asks for.
    ///
    /// # Errors
    /// A file cannot be written.
    pub(crate) fn create(
        folder: &'a RunFolder,
        plan: &'a Plan,
        scene: &'a Scene,
        forms: Vec<BoundaryForm>,
    ) -> Result<Self, Error> {
        let ledger = Ledger::create(&folder.file(LEDGER), plan, scene.output.ledger_every);
        let probes = Probes::create(&folder.file(PROBES), plan, &scene.probes);
        let trace = scene.output.trace.then(|| Trace::create(&folder.file(TRACE), plan)).transpose();
        Ok(Self {
            folder,
            plan,
            scene,
            ledger: named(ledger, &folder.file(LEDGER))?,
            probes: named(probes, &folder.file(PROBES))?,
            trace: named(trace, &folder.file(TRACE))?,
            ready: vec![None; plan.participants.len()],
            tally: Tally::new(plan, forms),
            frames: None,
            is_resumed: false,
        })
    }

    /// Goes on with the files of an earlier life of the run, behind the windows that `tally` has counted.
    ///
    /// # Errors
    /// A file cannot be read or written, or lacks windows.
    pub(crate) fn reopen(folder: &'a RunFolder, plan: &'a Plan, scene: &'a Scene, tally: Tally) -> Result<Self, Error> {
        let from = tally.windows;
        let ledger = Ledger::reopen(&folder.file(LEDGER), plan, scene.output.ledger_every, from);
        let probes = Probes::reopen(&folder.file(PROBES), plan, &scene.probes, from);
        let trace = scene.output.trace.then(|| Trace::reopen(&folder.file(TRACE), from)).transpose();
        Ok(Self {
            folder,
            plan,
            scene,
            ledger: taken_up(ledger, &folder.file(LEDGER))?,
            probes: taken_up(probes, &folder.file(PROBES))?,
            trace: taken_up(trace, &folder.file(TRACE))?,
            ready: vec![None; plan.participants.len()],
            tally,
            frames: None,
            is_resumed: true,
        })
    }

    /// Waits until all that was written is on disk.
    ///
    /// # Errors
    /// A file cannot be written.
    pub(crate) fn sync(&self) -> io::Result<()> {
        self.ledger.sync()?;
        self.probes.as_ref().map_or(Ok(()), Probes::sync)?;
        self.trace.as_ref().map_or(Ok(()), Trace::sync)
    }

    /// A participant has joined.
    pub(crate) fn ready(&mut self, who: ParticipantId, info: ReadyInfo) {
        if let Some(place) = self.ready.get_mut(usize::from(who)) {
            *place = Some(info);
        }
    }

    /// The first window begins.
    ///
    /// # Errors
    /// A file cannot be written.
    pub(crate) fn started(&mut self) -> Result<(), Error> {
        if self.is_resumed {
            return Ok(());
        }
        let ready: Vec<ReadyInfo> = self.ready.iter_mut().map(|r| r.take().unwrap_or_default()).collect();
        self.tally.started(self.plan, self.scene, &ready);
        if let Some(probes) = &mut self.probes {
            let reports: Vec<_> = ready.into_iter().map(|r| r.report).collect();
            named(probes.started(&reports), &self.folder.file(PROBES))?;
        }
        Ok(())
    }

    /// A window is settled.
    ///
    /// # Errors
    /// A file cannot be written.
    pub(crate) fn settled(&mut self, record: &WindowRecord, done: &[Done]) -> Result<(), Error> {
        self.tally.settled(record, done);
        named(self.ledger.settled(record, done), &self.folder.file(LEDGER))?;
        if let Some(probes) = &mut self.probes {
            named(probes.settled(record, done), &self.folder.file(PROBES))?;
        }
        if let Some(trace) = &mut self.trace {
            named(trace.settled(record.window, done), &self.folder.file(TRACE))?;
        }
        Ok(())
    }

    /// No window follows.
    ///
    /// # Errors
    /// A file cannot be written.
    pub(crate) fn finish(&mut self) -> Result<(), Error> {
        named(self.ledger.finish(), &self.folder.file(LEDGER))?;
        if let Some(trace) = &mut self.trace {
            named(trace.finish(), &self.folder.file(TRACE))?;
        }
        Ok(())
    }

    /// Everything that was left out: by the plan, by the solvers, and here.
    pub(crate) fn left_out(&self) -> Vec<LeftOut> {
        let mut all = self.plan.left_out.clone();
        all.extend(self.tally.left_out.iter().cloned());
        all.extend(probes::unanswered(self.plan, &self.scene.probes));
        all.extend(self.frames.iter().flat_map(|frames| frames.left_out.iter().cloned()));
        if self.trace.as_ref().is_some_and(Trace::is_full) {
            all.push(LeftOut {
                what: format!("later windows in `{TRACE}`"),
                why: "the trace has reached its largest size in bytes".into(),
                indicator: None,
                limit: Some(super::trace::LIMIT_BYTES as f64),
                saved: "not measured".into(),
            });
        }
        all
    }

    /// Files of the run by their part, below the folder.
    pub(crate) fn files(&self) -> BTreeMap<String, String> {
        let mut files: BTreeMap<String, String> =
            [("run", RUN), ("ledger", LEDGER), ("summary", SUMMARY)].map(|(k, v)| (k.into(), v.into())).into();
        if self.probes.is_some() {
            files.insert("probes".into(), PROBES.into());
        }
        if self.trace.is_some() {
            files.insert("trace".into(), TRACE.into());
        }
        files.extend(self.report_file());
        let frames = self.frames.iter();
        for (part, name) in frames.flat_map(|frames| self.frame_files(frames)) {
            files.insert(part.into(), name.into());
        }
        for participant in self.plan.solvers() {
            files.insert(format!("log.{}", participant.name), RunFolder::log_name(&participant.name));
        }
        files
    }
}

impl Recorder<'_> {
    /// `report.html`, where the scene wants one.
    fn report_file(&self) -> Option<(String, String)> {
        self.scene.output.report.then(|| ("report".into(), super::REPORT.into()))
    }

    fn frame_files(&self, frames: &Frames) -> Vec<(&'static str, &'static str)> {
        let output = &self.scene.output;
        let all = [
            (!frames.pictures.is_empty(), "pictures", PICTURES),
            (!frames.pictures.is_empty(), "preview", PREVIEW),
            (frames.has_film, "video", VIDEO),
            (output.preset.is_some() && !frames.pictures.is_empty(), "conditions", CONDITIONS),
            (!frames.splats.is_empty(), "splats", SPLATS),
            (!frames.surfaces.is_empty(), "surfaces", SURFACES),
            (output.recording, "recording", RECORDING),
        ];
        all.into_iter().filter(|(is_there, ..)| *is_there).map(|(_, part, name)| (part, name)).collect()
    }
}

/// What an earlier life of the run has left is not this machine's fault.
fn taken_up<T>(result: io::Result<T>, path: &Path) -> Result<T, Error> {
    result.map_err(|e| {
        let problem = Problem::new(format!("Cannot go on with `{}`", path.display())).at(path).because(e);
        Error::new(Code::Scene, problem.hint("begin the run anew with `cosplat run`"))
    })
}

fn named<T>(result: io::Result<T>, path: &Path) -> Result<T, Error> {
    result.map_err(|e| Error::io("write", path, &e))
}
