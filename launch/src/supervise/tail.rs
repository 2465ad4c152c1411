//! The last words of a process: the end of its standard error, bounded in lines and in their length.

use std::collections::VecDeque;
use std::fs::File;
use std::io::{Read, Write as _};
use std::sync::{Arc, Mutex, PoisonError};

/// Lines kept.
const LINES: usize = 50;
/// Longest part of a line that is kept, in bytes.
const LINE_BYTES: usize = 500;
/// Size at which a log file stops growing.
const LOG_BYTES: u64 = 16 << 20;
/// Last line of a log that stopped growing.
const CUT: &[u8] = b"\n[the log is cut here: it has reached 16 MiB]\n";

/// The last lines that were written to it.
#[derive(Debug, Default)]
struct Lines {
    whole: VecDeque<String>,
    open: Vec<u8>,
}

impl Lines {
    fn push(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            if byte == b'\n' {
                self.close();
            } else if self.open.len() <= LINE_BYTES {
                self.open.push(byte);
            }
        }
    }

    fn close(&mut self) {
        let is_cut = self.open.len() > LINE_BYTES;
        self.open.truncate(LINE_BYTES);
        let mut line = String::from_utf8_lossy(&self.open).trim_end_matches('\r').to_owned();
        if is_cut {
            line.push('…');
        }
        self.open.clear();
        if self.whole.len() == LINES {
            self.whole.pop_front();
        }
        self.whole.push_back(line);
    }
}

/// A tail that one thread fills and another reads.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tail(Arc<Mutex<Lines>>);

impl Tail {
    /// Reads a pipe to its end, into the log and the tail. Goes on reading when the log cannot be written, because a
    /// full pipe would stop the process.
    pub(crate) fn fill(&self, mut pipe: impl Read, mut log: File) {
        let mut buffer = [0; 8192];
        let mut written = 0;
        loop {
            let read = match pipe.read(&mut buffer) {
                Ok(0) => break,
                Ok(read) => read,
                Err(e) if e.kind() == std::io::ErrorKind::Interrupted => continue,
                Err(_) => break,
            };
            let bytes = &buffer[..read];
            if written < LOG_BYTES {
                written += read as u64;
                let cut = if written >= LOG_BYTES { CUT } else { b"" };
                if log.write_all(bytes).and_then(|()| log.write_all(cut)).is_err() {
                    written = LOG_BYTES;
                }
            }
            self.lines().push(bytes);
        }
        let mut lines = self.lines();
        if !lines.open.is_empty() {
            lines.close();
        }
    }

    /// The last lines, the oldest first.
    pub(crate) fn last(&self) -> Vec<String> {
        self.lines().whole.iter().cloned().collect()
    }

    fn lines(&self) -> std::sync::MutexGuard<'_, Lines> {
        // The lines are whole at every moment, so a panic elsewhere cannot have left them half done.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filled(bytes: &[u8]) -> (Vec<String>, String) {
        let tail = Tail::default();
        let log = tempfile::NamedTempFile::new().unwrap();
        tail.fill(bytes, log.reopen().unwrap());
        (tail.last(), String::from_utf8_lossy(&std::fs::read(log.path()).unwrap()).into_owned())
    }

    #[test]
    fn the_last_lines_are_kept_and_the_log_is_whole() {
        let lines: Vec<String> = (0..200).map(|i| format!("line {i}\n")).collect();
        let text = lines.concat() + "unfinished";
        let (last, log) = filled(text.as_bytes());
        assert_eq!(last.len(), LINES);
        assert_eq!(last.last().map(String::as_str), Some("unfinished"));
        assert_eq!(last[0], "line 151");
        assert_eq!(log, text);
    }

    #[test]
    fn endless_lines_and_broken_text_are_bounded() {
        let mut bytes = vec![b'x'; 100_000];
        bytes.extend_from_slice(b"\r\n\xff\xfe end\r\n");
        let (last, _) = filled(&bytes);
        assert_eq!(last.len(), 2);
        assert!(last[0].len() < LINE_BYTES + 10 && last[0].ends_with('…'));
        assert!(last[1].ends_with(" end"), "{last:?}");
    }

    #[test]
    fn a_log_stops_growing() {
        let tail = Tail::default();
        let log = tempfile::NamedTempFile::new().unwrap();
        tail.fill(std::io::repeat(b'y').take(LOG_BYTES + 100_000), log.reopen().unwrap());
        assert!(log.as_file().metadata().unwrap().len() < LOG_BYTES + 10_000);
    }
}
