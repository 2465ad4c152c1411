//! `probes.csv`: what the scene asked to be measured, one row per window, the state at t = 0 first.
//!
//! Columns are `<probe>.x`, `<probe>.y`, `<probe>.z` (and `.w` for orientations), or `<probe>.value` for a number. Values
//! come from the body states, the impulses, and the answers to probes, that each solver reports with a finished window.

use std::fs::{self, File};
use std::io;
use std::path::Path;

use cosplat_core::boundary::{add, scale};
use cosplat_core::control::Done;
use cosplat_core::ledger::WindowRecord;
use cosplat_core::plan::{Interface, InterfaceId, LeftOut, Plan};
use cosplat_core::plugin::{BodyState, Report};
use cosplat_core::scene::{Probe, ProbeQuantity};

use super::ledger::{number, reopen_table};

/// Where the value of a probe is found.
#[derive(Debug)]
enum Source {
    /// In the state of a body.
    Body { quantity: ProbeQuantity, participant: usize, body: usize },
    /// In what a body received through its interfaces.
    Force { participant: usize, interfaces: Vec<InterfaceId>, window_s: f64 },
    /// In the answer of the first of so many participants that has one.
    Answer { name: String, participants: usize },
}

impl Source {
    /// Names of its columns.
    fn axes(&self) -> &'static [&'static str] {
        match self {
            Self::Body { quantity, .. } => axes(*quantity),
            Self::Force { .. } => axes(ProbeQuantity::Force),
            Self::Answer { .. } => &["value"],
        }
    }

    /// Its values; none where nobody knows.
    fn values<'a>(&self, report: impl Fn(usize) -> Option<&'a Report>) -> Option<Vec<f64>> {
        match self {
            Self::Body { quantity, participant, body } => {
                report(*participant).and_then(|r| r.bodies.get(*body)).map(|state| values(*quantity, state))
            }
            Self::Force { participant, interfaces, window_s } => {
                let received = report(*participant)?.interfaces.iter().filter(|i| interfaces.contains(&i.interface));
                let impulse = received.fold([0.0; 3], |sum, i| add(sum, i.received.linear));
                Some(scale(impulse, 1.0 / window_s).to_vec())
            }
            Self::Answer { name, participants } => {
                let mut answers = (0..*participants).filter_map(|p| report(p)?.probes.get(name).copied());
                answers.next().map(|answer| vec![answer])
            }
        }
    }
}

/// Writes the table.
#[derive(Debug)]
pub(crate) struct Probes {
    out: csv::Writer<File>,
    sources: Vec<Source>,
}

impl Probes {
    /// Begins the table; `None` when the scene has no probe that can be answered, then no file is made.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(crate) fn create(path: &Path, plan: &Plan, probes: &[Probe]) -> io::Result<Option<Self>> {
        let (header, sources) = columns(plan, probes);
        if sources.is_empty() {
            return Ok(None);
        }
        let mut out = csv::WriterBuilder::new().buffer_capacity(1 << 16).from_writer(File::create(path)?);
        out.write_record(&header)?;
        out.flush()?;
        Ok(Some(Self { out, sources }))
    }

    /// Goes on with the table of an earlier life of the run: windows from `from` on are computed again.
    ///
    /// # Errors
    /// The file cannot be read or written, or it lacks windows.
    pub(crate) fn reopen(path: &Path, plan: &Plan, probes: &[Probe], from: u64) -> io::Result<Option<Self>> {
        let (_, sources) = columns(plan, probes);
        if sources.is_empty() {
            return Ok(None);
        }
        let text = fs::read_to_string(path)?;
        let (header, rows) = text.split_once('\n').unwrap_or_default();
        // The state at t = 0 comes before the first window.
        let kept: Vec<&str> =
            rows.lines().take(usize::try_from(from).unwrap_or(usize::MAX).saturating_add(1)).collect();
        if kept.len() as u64 != from + 1 {
            return Err(io::Error::other(format!("it lacks windows before window {from}")));
        }
        let out = csv::WriterBuilder::new().buffer_capacity(1 << 16).from_writer(reopen_table(path, header, &kept)?);
        Ok(Some(Self { out, sources }))
    }

    /// Waits until all that was written is on disk.
    ///
    /// # Errors
    /// It cannot be written.
    pub(crate) fn sync(&self) -> io::Result<()> {
        self.out.get_ref().sync_data()
    }

    /// Writes the state at t = 0.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(crate) fn started(&mut self, reports: &[Report]) -> io::Result<()> {
        self.write(0.0, |participant| reports.get(participant))
    }

    /// Writes the state at the end of a window.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(crate) fn settled(&mut self, record: &WindowRecord, done: &[Done]) -> io::Result<()> {
        self.write(record.end_s, |participant| done.get(participant).map(|d| &d.report))
    }

    fn write<'a>(&mut self, time_s: f64, report: impl Fn(usize) -> Option<&'a Report>) -> io::Result<()> {
        let mut row = vec![number(time_s)];
        for source in &self.sources {
            match source.values(&report) {
                Some(values) => row.extend(values.into_iter().map(number)),
                None => row.extend(source.axes().iter().map(|_| String::new())),
            }
        }
        self.out.write_record(&row)?;
        self.out.flush()
    }
}

/// Names of the columns, and where the values of each probe are found.
fn columns(plan: &Plan, probes: &[Probe]) -> (Vec<String>, Vec<Source>) {
    let mut header = vec!["time_s".to_owned()];
    let mut sources = Vec::new();
    for probe in probes {
        let Some(source) = source(plan, probe) else { continue };
        header.extend(source.axes().iter().map(|axis| format!("{}.{axis}", probe.name)));
        sources.push(source);
    }
    (header, sources)
}

/// Probes that no body state answers, for the list of what was left out.
pub(crate) fn unanswered(plan: &Plan, probes: &[Probe]) -> Vec<LeftOut> {
    let missing = probes.iter().filter(|p| source(plan, p).is_none());
    missing
        .map(|probe| LeftOut {
            what: format!("probe `{}`", probe.name),
            why: format!("no state of a body answers `{}`", quantity_name(probe.quantity)),
            indicator: None,
            limit: None,
            saved: "not measured".into(),
        })
        .collect()
}

/// A quantity as a scene writes it.
fn quantity_name(quantity: ProbeQuantity) -> String {
    serde_json::to_value(quantity).ok().and_then(|v| v.as_str().map(str::to_owned)).unwrap_or_default()
}

fn source(plan: &Plan, probe: &Probe) -> Option<Source> {
    if matches!(probe.quantity, ProbeQuantity::Pressure | ProbeQuantity::Strain | ProbeQuantity::Reach) {
        return Some(Source::Answer { name: probe.name.clone(), participants: plan.participants.len() });
    }
    if axes(probe.quantity).is_empty() {
        return None;
    }
    let body = probe.body.as_deref()?;
    plan.participants.iter().enumerate().find_map(|(participant, p)| {
        let (name, body) = (body, p.bodies.iter().position(|b| b == body)?);
        if probe.quantity == ProbeQuantity::Force {
            let mine = |i: &Interface| {
                [&i.a, &i.b].iter().any(|side| usize::from(side.participant) == participant && side.body == name)
            };
            let interfaces =
                plan.interfaces.iter().enumerate().filter(|(_, i)| mine(i)).map(|(id, _)| id as InterfaceId);
            return Some(Source::Force {
                participant,
                interfaces: interfaces.collect(),
                window_s: plan.clock.window_s(),
            });
        }
        Some(Source::Body { quantity: probe.quantity, participant, body })
    })
}

/// Components of a quantity; none for those that a body state does not hold.
fn axes(quantity: ProbeQuantity) -> &'static [&'static str] {
    match quantity {
        ProbeQuantity::Position | ProbeQuantity::Velocity | ProbeQuantity::Momentum | ProbeQuantity::Force => {
            &["x", "y", "z"]
        }
        ProbeQuantity::Orientation => &["x", "y", "z", "w"],
        _ => &[],
    }
}

fn values(quantity: ProbeQuantity, state: &BodyState) -> Vec<f64> {
    match quantity {
        ProbeQuantity::Position => state.position_m.to_vec(),
        ProbeQuantity::Velocity => state.linear_velocity_m_s.to_vec(),
        ProbeQuantity::Momentum => state.momentum.linear.to_vec(),
        ProbeQuantity::Orientation => state.orientation.to_vec(),
        _ => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use cosplat_core::boundary::Wrench;
    use cosplat_core::plugin::InterfaceReport;

    use super::*;
    use crate::folder::fixtures::{done, plan, record};

    fn probe(name: &str, quantity: ProbeQuantity, body: &str) -> Probe {
        Probe { name: name.into(), quantity, body: Some(body.into()), at_m: None, along: None }
    }

    #[test]
    fn the_first_row_is_the_state_at_zero() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("probes.csv");
        let probes = [probe("where", ProbeQuantity::Position, "b"), probe("how", ProbeQuantity::Orientation, "a")];
        let mut table = Probes::create(&path, &plan(2), &probes).unwrap().unwrap();
        table.started(&[done(0).report, done(0).report]).unwrap();
        table.settled(&record(0), &[done(0), done(7)]).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "time_s,where.x,where.y,where.z,how.x,how.y,how.z,how.w");
        assert!(lines[1].starts_with("0,0,") && lines[2].starts_with("0.01,7,"), "{text}");
    }

    #[test]
    fn a_resumed_table_goes_on_behind_the_windows_that_stay() {
        let probes = [probe("where", ProbeQuantity::Position, "a")];
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("probes.csv");
        let mut table = Probes::create(&path, &plan(9), &probes).unwrap().unwrap();
        table.started(&[done(0).report, done(0).report]).unwrap();
        (0..3).for_each(|window| table.settled(&record(window), &[done(0), done(window)]).unwrap());
        let whole = std::fs::read_to_string(&path).unwrap();
        let mut table = Probes::reopen(&path, &plan(9), &probes, 1).unwrap().unwrap();
        (1..3).for_each(|window| table.settled(&record(window), &[done(0), done(window)]).unwrap());
        assert_eq!(std::fs::read_to_string(&path).unwrap(), whole);
        assert!(Probes::reopen(&path, &plan(9), &probes, 4).is_err(), "a window is missing");
    }

    #[test]
    fn a_number_at_a_point_is_in_its_column_and_missing_where_nobody_has_it() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("probes.csv");
        let at = Probe {
            name: "floor".into(),
            quantity: ProbeQuantity::Pressure,
            body: None,
            at_m: Some([0.0; 3]),
            along: None,
        };
        let mut table = Probes::create(&path, &plan(2), &[at]).unwrap().unwrap();
        let mut answered = done(0).report;
        answered.probes.insert("floor".into(), 101.5);
        table.started(&[done(0).report, answered]).unwrap();
        table.settled(&record(0), &[done(0), done(7)]).unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "time_s,floor.value\n0,101.5\n0.01,\n");
    }

    #[test]
    fn a_force_is_what_crossed_the_interfaces_of_a_body_over_the_window() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("probes.csv");
        let mut table = Probes::create(&path, &plan(2), &[probe("push", ProbeQuantity::Force, "b")]).unwrap().unwrap();
        let mut pushed = done(0);
        let received = Wrench { linear: [0.0, -0.5, 1.0], ..Wrench::default() };
        pushed.report.interfaces = vec![InterfaceReport { interface: 0, received, ..InterfaceReport::default() }];
        table.started(&[done(0).report, done(0).report]).unwrap();
        table.settled(&record(0), &[done(0), pushed]).unwrap();
        // Windows of 0.01 s.
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "time_s,push.x,push.y,push.z\n0,0,0,0\n0.01,0,-50,100\n");
    }

    #[test]
    fn what_nothing_answers_is_named() {
        let probes = [probe("p", ProbeQuantity::VolumeFraction, "a")];
        let place = tempfile::tempdir().unwrap();
        assert!(Probes::create(&place.path().join("x"), &plan(2), &probes).unwrap().is_none());
        assert!(!place.path().join("x").exists());
        assert_eq!(unanswered(&plan(2), &probes)[0].what, "probe `p`");
    }
}
