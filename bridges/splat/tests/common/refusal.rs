//! Hostile files: a reader ends soon, takes little memory, and says in one line what is wrong.

#![allow(dead_code, reason = "every test file is a program of its own and uses a part")]

use std::fmt::Debug;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use peak_alloc::PeakAlloc;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;
static TURN: Mutex<()> = Mutex::new(());

/// Memory is counted for the whole process, so a test takes its turn before it makes its files: some are large while
/// they are made, and would count for a reader in another thread.
pub(crate) struct Turn(MutexGuard<'static, ()>);

/// Waits until no other test of the program has its turn.
pub(crate) fn turn() -> Turn {
    Turn(TURN.lock().unwrap_or_else(PoisonError::into_inner))
}

/// Longest time that a reader may take over a small file, and how often it is tried when the machine may have been busy.
const LIMIT: Duration = Duration::from_secs(1);
const TRIES: usize = 3;

/// How much memory reading a file may take.
#[derive(Clone, Copy)]
pub(crate) struct Allowed {
    /// Bytes for any file.
    pub(crate) free: usize,
    /// Bytes for each byte of it.
    pub(crate) each: usize,
}

/// A case: name, ending, bytes, kind of the fault, part of the error.
pub(crate) type Case<F> = (&'static str, &'static str, Vec<u8>, F, &'static str);

/// Reads a file of that length, soon and within the allowed memory.
pub(crate) fn bounded<T>(_turn: &Turn, length: usize, allowed: Allowed, read: impl Fn() -> T) -> T {
    MEMORY.reset_peak_usage();
    let before = MEMORY.current_usage();
    let timed = || {
        let start = Instant::now();
        (read(), start.elapsed())
    };
    let (result, time) = timed();
    let taken = MEMORY.peak_usage().saturating_sub(before);
    assert!(taken <= allowed.free + allowed.each * length, "{length} bytes took {taken} bytes of memory");
    assert!(time < LIMIT || (1..TRIES).any(|_| timed().1 < LIMIT), "{length} bytes took {time:?}");
    result
}

/// One line for a terminal, and not a long one.
pub(crate) fn assert_plain(error: &str) {
    assert!(error.len() < 1000 && !error.contains(char::is_control), "{error:?}");
}

/// Every case is refused for the right reason; all that are not are shown. `read` gives the fault and the error.
pub(crate) fn check<F: Debug + PartialEq>(
    turn: &Turn,
    cases: Vec<Case<F>>,
    allowed: Allowed,
    read: impl Fn(&[u8], &str) -> Result<(), (F, String)>,
) {
    let mut wrong = Vec::new();
    for (name, ending, bytes, fault, part) in cases {
        match bounded(turn, bytes.len(), allowed, || read(&bytes, ending)) {
            Ok(()) => wrong.push(format!("{name}: no error")),
            Err((found, error)) if found != fault || !error.contains(part) => {
                wrong.push(format!("{name}: {found:?} {error}, not {fault:?} with `{part}`"));
            }
            Err((_, error)) => assert_plain(&error),
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
