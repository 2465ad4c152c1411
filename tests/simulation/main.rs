//! Does the protocol hold when everything that can happen to a message happens?
//!
//! Each seed is a run of 3 to 5 participants over 200 windows (or 12 with large messages), once calm and once with
//! losses, duplicates, delays, bit flips, forgeries and a blow such as a kill, after which it may have to be resumed from
//! its newest checkpoint. The seeds are dealt to eight tests so that they run side by side and none takes
//! long.

use cosplat_core::checks::{ALL, Without};
use cosplat_core::sim;

fn check(seeds: impl Iterator<Item = u64>) {
    let violations: Vec<String> =
        seeds.filter_map(|seed| sim::check_seed(seed).err()).map(|v| v.to_string()).take(5).collect();
    assert!(violations.is_empty(), "{}", violations.join("\n"));
}

#[test]
fn invariants_hold_for_seeds_0_to_250() {
    check(0..250);
}

#[test]
fn invariants_hold_for_seeds_250_to_500() {
    check(250..500);
}

#[test]
fn invariants_hold_for_seeds_500_to_750() {
    check(500..750);
}

#[test]
fn invariants_hold_for_seeds_750_to_1000() {
    check(750..1000);
}

#[test]
fn invariants_hold_for_seeds_1000_to_1250() {
    check(1000..1250);
}

#[test]
fn invariants_hold_for_seeds_1250_to_1500() {
    check(1250..1500);
}

#[test]
fn invariants_hold_for_seeds_1500_to_1750() {
    check(1500..1750);
}

#[test]
fn invariants_hold_for_seeds_1750_to_2000() {
    check(1750..2000);
}

/// The command that a violation prints leads here; without the variable it runs seed 0.
#[test]
fn one_seed() {
    let seed = std::env::var("COSPLAT_SIM_SEED").ok().and_then(|s| s.parse().ok()).unwrap_or(0);
    let scenario = sim::Scenario::from_seed(seed);
    println!("seed {seed}: {:?} at {} µs, {:?}", scenario.trouble, scenario.trouble_at_us, scenario.faults);
    println!("{:#?}", scenario.plan.interfaces);
    match sim::check_seed(seed) {
        Ok(report) => println!("{report:?}"),
        Err(violation) => panic!("{violation}"),
    }
}

/// The same seed gives the same run, delivery for delivery: otherwise a violation could not be replayed.
#[test]
fn a_seed_is_a_run() {
    for seed in [1, 7, 42] {
        let (one, two) = (sim::check_seed(seed).unwrap(), sim::check_seed(seed).unwrap());
        assert_eq!((one.messages, one.state_hash, one.outcome), (two.messages, two.state_hash, two.outcome));
    }
}

/// Many runs that are killed go on from a checkpoint: others are killed before the first or have no room to store it.
#[test]
fn crashed_runs_are_resumed() {
    let crashes = |seed: &u64| sim::Scenario::from_seed(*seed).trouble == sim::Trouble::Crash;
    let reports: Vec<sim::Report> = (0..300).filter(crashes).map(|seed| sim::check_seed(seed).unwrap()).collect();
    let resumed = reports.iter().filter(|report| report.resumed > 0).count();
    assert!(3 * resumed > reports.len(), "{resumed} of {} crashed runs had a checkpoint", reports.len());
}

/// Every check of the protocol, switched off alone, is a bug that some seed notices.
#[test]
fn every_hand_made_protocol_bug_is_caught() {
    let survivors: Vec<String> = ALL
        .into_iter()
        .filter(|&check| (0..400).all(|seed| sim::check_seed_with(seed, Without(check)).is_ok()))
        .map(|check| format!("{check:?}"))
        .collect();
    assert!(survivors.is_empty(), "no seed notices when these are gone: {survivors:?}");
}
