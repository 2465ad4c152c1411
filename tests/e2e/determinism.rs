//! Same scene, same bytes: whatever starts first, arrives late or runs on more threads. And other scenes, other bytes.

mod support;

use support::{Oscillator, Program};

fn hash_of(scene: &str, args: &[&str]) -> String {
    Program::run(scene, args).finish().expect_code(0).hash()
}

#[test]
fn start_order_delays_and_threads_do_not_change_a_bit() {
    for scheme in ["alternating", "centred"] {
        let plain = Oscillator { scheme, ..Oscillator::default() };
        let expected = hash_of(&plain.scene(), &["--quiet", "--threads", "1"]);
        assert_eq!(hash_of(&plain.scene(), &["--quiet", "--threads", "2"]), expected, "threads");
        let late = Oscillator { left: Oscillator::saboteur(&["late"]), scheme, ..Oscillator::default() };
        assert_eq!(hash_of(&late.scene(), &["--quiet"]), expected, "the left process started last");
        let late = Oscillator { right: Oscillator::saboteur(&["late"]), scheme, ..Oscillator::default() };
        assert_eq!(hash_of(&late.scene(), &["--quiet"]), expected, "the right process started last");
        let jitter = Oscillator::saboteur(&["jitter"]);
        let delayed = Oscillator { left: jitter.clone(), right: jitter, scheme, ..Oscillator::default() };
        assert_eq!(hash_of(&delayed.scene(), &["--quiet"]), expected, "messages delayed at random");
    }
}

#[test]
fn consecutive_windows_have_different_states() {
    let run = Program::run(&Oscillator::default().scene(), &["--quiet"]).finish().expect_code(0);
    let mut hashes = run.ledger("state_hash");
    assert_eq!(hashes.len(), 100, "one row a window");
    hashes.sort_unstable();
    hashes.dedup();
    assert_eq!(hashes.len(), 100, "no state hash comes twice");
}

#[test]
fn one_unit_in_the_last_place_of_the_input_changes_the_hash() {
    let plain = Oscillator::default();
    let nudged = Oscillator { start: 1.0_f64.next_up(), ..Oscillator::default() };
    assert_ne!(hash_of(&plain.scene(), &["--quiet"]), hash_of(&nudged.scene(), &["--quiet"]));
}

/// The negative control of the ledger: impulses that arrive and are thrown away must not go unnoticed.
#[test]
fn a_dropped_reaction_turns_the_closure_gate_red() {
    let broken = Oscillator { scheme: "centred", more: "[run]\nbreak = \"drop-reaction\"\n", ..Oscillator::default() };
    let run = Program::run(&broken.scene(), &["--quiet"]).finish().expect_code(7);
    let interface = &run.summary["interfaces"][0];
    let closure = interface["closure"].as_f64().expect("closure is measured");
    assert!(closure > 1e-2, "{closure:e}");
    assert_eq!(interface["transfer_defect"].as_f64(), Some(0.0), "an echo of what was sent proves nothing");
    assert_eq!(run.summary["status"], "verdict-failed");
}
