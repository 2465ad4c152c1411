//! Ten thousand windows must cost no more memory, descriptors or threads than a thousand.

mod support;

use support::{Oscillator, Program};

/// What a process holds.
#[derive(Clone, Copy, Debug)]
struct Holdings {
    resident_kib: u64,
    descriptors: u64,
    threads: u64,
}

fn holdings(pid: u32) -> Option<Holdings> {
    let status = std::fs::read_to_string(format!("/proc/{pid}/status")).ok()?;
    let field = |name: &str| {
        let line = status.lines().find(|l| l.starts_with(name))?;
        line.split_whitespace().nth(1)?.parse().ok()
    };
    Some(Holdings {
        resident_kib: field("VmRSS:")?,
        descriptors: std::fs::read_dir(format!("/proc/{pid}/fd")).ok()?.count() as u64,
        threads: field("Threads:")?,
    })
}

#[test]
fn ten_thousand_windows_grow_nothing() {
    // One ledger row in fifty windows, so that the file says where the run is and does not matter itself.
    let more = "[output]\nledger_every = 50\n";
    let scene = Oscillator { window: 0.01, duration: 110.0, scheme: "alternating", more, ..Oscillator::default() };
    let running = Program::run(&scene.scene(), &["--quiet"]).start();
    running.wait_for_lines("ledger.csv", 25);
    let mut pids = running.children();
    pids.push(running.child.id());
    assert_eq!(pids.len(), 3, "the program and two solvers");
    let early: Vec<_> = pids.iter().map(|&p| holdings(p).expect("it runs")).collect();
    running.wait_for_lines("ledger.csv", 200);
    let late: Vec<_> = pids.iter().map(|&p| holdings(p)).collect();
    running.finish().expect_code(0);
    for (early, late) in early.iter().zip(late) {
        let Some(late) = late else { continue };
        assert_eq!(late.threads, early.threads, "threads: {early:?} → {late:?}");
        assert!(late.descriptors <= early.descriptors + 1, "descriptors: {early:?} → {late:?}");
        // The allocator's pools and the transport's buffers still fill a little; a leak of one message a window would
        // be more than 4 MiB.
        assert!(late.resident_kib < early.resident_kib + 2048, "resident: {early:?} → {late:?}");
    }
}
