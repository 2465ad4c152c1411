//! `trace.json`: where the wall time went, for <https://ui.perfetto.dev> or `chrome://tracing`.
//!
//! The Chrome trace format as a JSON array, which its readers also take without the closing bracket, so that the file
//! of a killed run still opens. Per participant and window there are slices `wait`, `transfer` and `compute`. Computing
//! has its true place; a host reports only sums of the others, which are drawn before it in that order.
//!
//! The file stops growing at [`LIMIT_BYTES`] and says so; a run is never slowed down or filled up by its trace.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write as _};
use std::path::Path;

use cosplat_core::control::{Done, Times};
use cosplat_core::plan::Plan;
use serde_json::{Value, json};

use super::replace;

/// Size at which the trace stops growing: 64 MiB, about 200 000 windows of a participant.
pub(crate) const LIMIT_BYTES: u64 = 64 << 20;

/// Writes the trace.
#[derive(Debug)]
pub(crate) struct Trace {
    out: BufWriter<File>,
    written: u64,
    limit: u64,
    is_full: bool,
    /// Moment of the first slice on the monotonic clock \[s\], at `begins_s` of the trace.
    origin_s: Option<f64>,
    /// Where the first slice is drawn \[s\]: behind those of an earlier life of the run.
    begins_s: f64,
    /// End of each participant's last slice on that clock \[s\].
    ends_s: Vec<f64>,
}

/// Moment at which a window's waiting and transfer began, if they came in one piece before its first step \[s\].
///
/// A window of several steps has some of both between them; that part lies inside the slice of the computation.
fn begin_s(times: &Times) -> f64 {
    let between_s = (times.end_s - times.start_s - times.compute_s).max(0.0);
    times.start_s - (times.wait_s + times.transfer_s - between_s).max(0.0)
}

/// Microseconds, to the nanosecond.
fn micros(seconds: f64) -> f64 {
    (seconds * 1e9).round() / 1e3
}

impl Trace {
    /// Begins the trace with the names of the participants.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(crate) fn create(path: &Path, plan: &Plan) -> io::Result<Self> {
        Self::with_limit(path, plan, LIMIT_BYTES)
    }

    fn with_limit(path: &Path, plan: &Plan, limit: u64) -> io::Result<Self> {
        let out = BufWriter::with_capacity(1 << 16, File::create(path)?);
        let mut trace =
            Self { out, written: 0, limit, is_full: false, origin_s: None, begins_s: 0.0, ends_s: Vec::new() };
        for (i, participant) in plan.participants.iter().enumerate() {
            let name = format!("{} ({})", participant.name, participant.plugin);
            trace.event(&json!({"ph": "M", "name": "process_name", "pid": i + 1, "args": {"name": name}}))?;
        }
        trace.out.flush()?;
        Ok(trace)
    }

    /// Goes on with the trace of an earlier life of the run: windows from `from` on are computed again.
    ///
    /// # Errors
    /// The file cannot be read or written.
    pub(crate) fn reopen(path: &Path, from: u64) -> io::Result<Self> {
        let text = fs::read_to_string(path)?;
        let Kept { events, end_us, is_full } = Kept::before(&text, from);
        let kept = format!("[\n{}", events.join(",\n"));
        replace(path, kept.as_bytes())?;
        let out = BufWriter::with_capacity(1 << 16, File::options().append(true).open(path)?);
        let written = if events.is_empty() { 0 } else { kept.len() as u64 };
        let begins_s = end_us / 1e6;
        Ok(Self { out, written, limit: LIMIT_BYTES, is_full, origin_s: None, begins_s, ends_s: Vec::new() })
    }

    /// Waits until all that was written is on disk.
    ///
    /// # Errors
    /// It cannot be written.
    pub(crate) fn sync(&self) -> io::Result<()> {
        self.out.get_ref().sync_data()
    }

    /// Adds the slices of a settled window.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(crate) fn settled(&mut self, window: u64, done: &[Done]) -> io::Result<()> {
        self.ends_s.resize(done.len(), f64::NEG_INFINITY);
        let origin_s =
            *self.origin_s.get_or_insert_with(|| done.iter().map(|d| begin_s(&d.times)).fold(f64::INFINITY, f64::min));
        let origin_s = origin_s - self.begins_s;
        for (i, done) in done.iter().enumerate() {
            self.window(i, window, done, origin_s)?;
        }
        self.out.flush()
    }

    fn window(&mut self, index: usize, window: u64, done: &Done, origin_s: f64) -> io::Result<()> {
        let times = &done.times;
        let from_s = begin_s(times).max(self.ends_s[index]).min(times.start_s);
        let moved_s = (times.start_s - from_s).min(times.transfer_s);
        let transfer_s = times.start_s - moved_s;
        let about = json!({"window": window, "substeps": done.report.substeps});
        let slices = [
            ("wait", from_s, transfer_s, json!({"total_s": times.wait_s})),
            ("transfer", transfer_s, times.start_s, json!({"total_s": times.transfer_s})),
            ("compute", times.start_s, times.end_s, about),
        ];
        for (name, from_s, to_s, args) in slices {
            if to_s > from_s {
                let (ts, dur) = (micros(from_s - origin_s), micros(to_s - from_s));
                let pid = index + 1;
                self.event(
                    &json!({"ph": "X", "name": name, "pid": pid, "tid": 1, "ts": ts, "dur": dur, "args": args}),
                )?;
            }
        }
        self.ends_s[index] = times.end_s;
        Ok(())
    }

    fn event(&mut self, event: &Value) -> io::Result<()> {
        if self.is_full {
            return Ok(());
        }
        let mut text = event.to_string();
        if self.written + text.len() as u64 > self.limit {
            self.is_full = true;
            text = json!({"ph": "M", "name": "process_labels", "pid": 1, "args": {"labels": "trace cut here"}})
                .to_string();
        }
        let before = if self.written == 0 { "[\n" } else { ",\n" };
        self.written += (before.len() + text.len()) as u64;
        self.out.write_all(before.as_bytes())?;
        self.out.write_all(text.as_bytes())
    }

    /// True when the size limit was reached and later windows are missing.
    pub(crate) fn is_full(&self) -> bool {
        self.is_full
    }

    /// Closes the array.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(crate) fn finish(&mut self) -> io::Result<()> {
        self.out.write_all(if self.written == 0 { b"[]\n" } else { b"\n]\n" })?;
        self.out.flush()
    }
}

/// What stays of a trace.
#[derive(Default)]
struct Kept<'t> {
    events: Vec<&'t str>,
    /// End of the last slice \[µs\].
    end_us: f64,
    is_full: bool,
}

impl<'t> Kept<'t> {
    /// The events of windows before `from`. Each is a line of its own, and of a window's slices the computation is last.
    fn before(text: &'t str, from: u64) -> Self {
        let mut kept = Self::default();
        let mut underway = Vec::new();
        for line in text.lines().skip(1) {
            let line = line.strip_suffix(',').unwrap_or(line);
            let Ok(event) = serde_json::from_str::<Value>(line) else { break };
            underway.push(line);
            if event["ph"] == "X" && event["name"] != "compute" {
                continue;
            }
            if event["args"]["window"].as_u64().is_some_and(|window| window >= from) {
                break;
            }
            kept.is_full |= event["name"] == "process_labels";
            let end = event["ts"].as_f64().zip(event["dur"].as_f64()).map_or(0.0, |(ts, dur)| ts + dur);
            kept.end_us = kept.end_us.max(end);
            kept.events.append(&mut underway);
        }
        kept
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::folder::fixtures::{done, plan};

    fn timed(start_s: f64) -> Done {
        let times = Times { start_s, end_s: start_s + 0.004, compute_s: 0.004, wait_s: 0.005, transfer_s: 0.001 };
        Done { times, ..done(0) }
    }

    fn events(path: &Path) -> Vec<Value> {
        serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
    }

    #[test]
    fn an_unfinished_trace_is_an_array_without_its_bracket() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("trace.json");
        let mut trace = Trace::create(&path, &plan(2)).unwrap();
        trace.settled(0, &[timed(100.0), timed(100.001)]).unwrap();
        let text = std::fs::read_to_string(&path).unwrap() + "]";
        let unfinished: Vec<Value> = serde_json::from_str(&text).unwrap();
        assert_eq!(unfinished.len(), 2 + 2 * 3);
        trace.finish().unwrap();
        let place_of = |i: usize| (events(&path)[i]["ts"].as_f64().unwrap(), events(&path)[i]["dur"].as_f64().unwrap());
        assert_eq!([place_of(2), place_of(3), place_of(4)], [(0.0, 5000.0), (5000.0, 1000.0), (6000.0, 4000.0)]);
        assert_eq!(place_of(5), (1000.0, 5000.0));
    }

    #[test]
    fn slices_of_a_participant_do_not_overlap() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("trace.json");
        let mut trace = Trace::create(&path, &plan(2)).unwrap();
        for window in 0..4 {
            // Shorter apart than the reported waiting, as with a wait that was counted twice.
            trace.settled(window, &[timed(1.0 + 0.006 * window as f64)]).unwrap();
        }
        trace.finish().unwrap();
        let mut end = 0.0;
        for event in &events(&path)[2..] {
            let (ts, dur) = (event["ts"].as_f64().unwrap(), event["dur"].as_f64().unwrap());
            assert!(ts > end - 0.01, "{event}");
            end = ts + dur;
        }
    }

    #[test]
    fn a_resumed_trace_goes_on_behind_the_windows_that_stay() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("trace.json");
        let mut trace = Trace::create(&path, &plan(2)).unwrap();
        for window in 0..4 {
            trace.settled(window, &[timed(100.0 + 0.01 * window as f64), timed(100.0 + 0.01 * window as f64)]).unwrap();
        }
        drop(trace);
        // Another boot: the monotonic clock began anew.
        let mut trace = Trace::reopen(&path, 2).unwrap();
        trace.settled(2, &[timed(1.0), timed(1.0)]).unwrap();
        trace.finish().unwrap();
        let computed: Vec<Value> = events(&path).into_iter().filter(|e| e["name"] == "compute").collect();
        let windows: Vec<u64> = computed.iter().map(|e| e["args"]["window"].as_u64().unwrap()).collect();
        assert_eq!(windows, [0, 0, 1, 1, 2, 2]);
        let starts: Vec<f64> = computed.iter().map(|e| e["ts"].as_f64().unwrap()).collect();
        assert!(starts.is_sorted(), "{starts:?}");
    }

    #[test]
    fn the_trace_stops_growing_and_stays_valid() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("trace.json");
        let mut trace = Trace::with_limit(&path, &plan(2), 2000).unwrap();
        for window in 0..100 {
            trace.settled(window, &[timed(window as f64)]).unwrap();
        }
        trace.finish().unwrap();
        assert!(trace.is_full());
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.len() < 2300, "{}", text.len());
        assert!(serde_json::from_str::<Vec<Value>>(&text).is_ok());
    }
}
