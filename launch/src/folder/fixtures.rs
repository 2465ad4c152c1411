//! A small plan and reports for it, for tests of what writes and sums them.

use cosplat_core::control::Done;
use cosplat_core::ledger::{InterfaceRecord, SolverRecord, WindowRecord};
use cosplat_core::plan::{Interface, InterfaceKind, Participant, Plan, Side};
use cosplat_core::plugin::{BodyState, Report};
use cosplat_core::scene::{MotionRule, Scheme};
use cosplat_core::time::Clock;

/// Two processes with a body each, joined by one interface that carries impulses.
pub(crate) fn plan(windows: u64) -> Plan {
    let participant = |name: &str, body: &str| Participant {
        name: name.into(),
        plugin: "oscillator".into(),
        bodies: vec![body.into()],
        threads: 1,
    };
    let side = |participant, body: &str| Side { participant, body: body.into() };
    Plan {
        clock: Clock::new(0.01 * windows as f64, windows),
        window_bound_by: "the scene".into(),
        participants: vec![participant("left", "a"), participant("right", "b")],
        interfaces: vec![Interface {
            name: "a~b".into(),
            kind: InterfaceKind::Contact,
            scheme: Scheme::Serial,
            rule: MotionRule::Hold,
            a: side(0, "a"),
            b: side(1, "b"),
            at_once: false,
            from_a: None,
            from_b: 0,
            impulses: Some(1),
            links: Vec::new(),
        }],
        streams: Vec::new(),
        left_out: Vec::new(),
        recorder: None,
        break_with: None,
    }
}

/// A settled window without any defect.
pub(crate) fn record(window: u64) -> WindowRecord {
    WindowRecord {
        window,
        end_s: 0.01 * (window + 1) as f64,
        state_hash: 0xab,
        solvers: vec![SolverRecord::default(); 2],
        interfaces: vec![InterfaceRecord { gross: 1.0, ..InterfaceRecord::default() }],
        total_energy_j: 2.0,
    }
}

/// A report whose one body is at x = `window`.
pub(crate) fn done(window: u64) -> Done {
    let state = BodyState { position_m: [window as f64, 0.0, 0.0], ..BodyState::default() };
    Done { window, report: Report { substeps: 3, bodies: vec![state], ..Report::default() }, ..Done::default() }
}
