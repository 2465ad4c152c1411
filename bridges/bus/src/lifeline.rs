//! The pipe that ties a participant to its launcher: first it carries the ticket, then nothing, and its end means that
//! the launcher is gone. It also works where the parent-death signal does not: across double forks and shells.

use std::io::{BufRead, BufReader, Read};
use std::sync::mpsc;
use std::thread;
use std::time::Duration;

use crate::error::BusError;
use crate::ticket::{JoinTicket, MAX_TICKET_BYTES};

/// Watches a pipe from a thread of its own, because a blocking read has no deadline.
pub struct Lifeline {
    first_line: mpsc::Receiver<Result<String, BusError>>,
    arm: mpsc::Sender<Box<dyn FnOnce() + Send>>,
}

impl Lifeline {
    /// Starts to read.
    ///
    /// # Errors
    /// [`BusError::Thread`].
    pub fn new(pipe: impl Read + Send + 'static) -> Result<Self, BusError> {
        let (line_out, first_line) = mpsc::channel();
        let (arm, armed) = mpsc::channel::<Box<dyn FnOnce() + Send>>();
        thread::Builder::new()
            .name("lifeline".to_owned())
            .spawn(move || {
                let mut pipe = BufReader::new(pipe);
                let line = read_line(&mut pipe);
                let usable = line.is_ok();
                if line_out.send(line).is_err() || !usable {
                    return;
                }
                wait_for_end(&mut pipe);
                // Nobody arms a line whose owner has left.
                if let Ok(at_end) = armed.recv() {
                    at_end();
                }
            })
            .map_err(|source| BusError::Thread { name: "lifeline", source })?;
        Ok(Self { first_line, arm })
    }

    /// The ticket, which must come within `deadline`.
    ///
    /// # Errors
    /// [`BusError::NoTicket`], [`BusError::BadTicket`].
    pub fn ticket(&self, deadline: Duration) -> Result<JoinTicket, BusError> {
        let late = |_| BusError::NoTicket { why: format!("nothing came within {} s", deadline.as_secs_f64()) };
        let line = self.first_line.recv_timeout(deadline).map_err(late)??;
        JoinTicket::from_line(&line)
    }

    /// Calls `at_end` once, on the line's own thread, when the other side is gone.
    pub fn at_end(self, at_end: impl FnOnce() + Send + 'static) {
        // The thread outlives this sender unless there was no ticket, and then there is nothing to watch.
        let _ = self.arm.send(Box::new(at_end));
    }
}

fn read_line(pipe: &mut impl BufRead) -> Result<String, BusError> {
    let none = |why: String| BusError::NoTicket { why };
    let mut line = Vec::new();
    let mut limited = pipe.take(MAX_TICKET_BYTES as u64);
    let read = limited.read_until(b'\n', &mut line).map_err(|e| none(e.to_string()))?;
    if read == 0 {
        return Err(none("it is closed".to_owned()));
    }
    if line.last() != Some(&b'\n') {
        return Err(none("what came is not a finished line".to_owned()));
    }
    String::from_utf8(line).map_err(|_| none("what came is not text".to_owned()))
}

/// Reads until the end; what comes is of no interest.
fn wait_for_end(pipe: &mut impl Read) {
    let mut scrap = [0; 256];
    loop {
        match pipe.read(&mut scrap) {
            Ok(0) => return,
            Err(e) if e.kind() != std::io::ErrorKind::Interrupted => return,
            Ok(_) | Err(_) => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cosplat_core::control::{FIRST_EPOCH, PROTOCOL};
    use std::io::Write;

    fn ticket() -> JoinTicket {
        JoinTicket {
            protocol: PROTOCOL,
            run: "0".repeat(32),
            name: "a".to_owned(),
            endpoint: String::new(),
            user: "a".to_owned(),
            password: String::new(),
            threads: 1,
            partners: Vec::new(),
            epoch: FIRST_EPOCH,
            checkpoints: None,
        }
    }

    #[test]
    fn the_ticket_arrives_and_the_end_is_noticed() {
        let (reader, mut writer) = std::io::pipe().unwrap();
        let line = Lifeline::new(reader).unwrap();
        writer.write_all(ticket().to_line().as_bytes()).unwrap();
        assert_eq!(line.ticket(Duration::from_secs(2)).unwrap(), ticket());
        let (gone, noticed) = mpsc::channel();
        line.at_end(move || gone.send(()).unwrap());
        assert!(noticed.recv_timeout(Duration::from_millis(50)).is_err());
        drop(writer);
        noticed.recv_timeout(Duration::from_secs(2)).unwrap();
    }

    #[test]
    fn silence_and_an_early_end_are_no_ticket() {
        let (reader, writer) = std::io::pipe().unwrap();
        let line = Lifeline::new(reader).unwrap();
        assert!(matches!(line.ticket(Duration::from_millis(20)), Err(BusError::NoTicket { .. })));
        drop(writer);
        assert!(matches!(line.ticket(Duration::from_secs(2)), Err(BusError::NoTicket { .. })));
    }

    #[test]
    fn an_endless_line_is_not_collected() {
        let line = Lifeline::new(std::io::repeat(b'x')).unwrap();
        assert!(matches!(line.ticket(Duration::from_secs(2)), Err(BusError::NoTicket { .. })));
    }
}
