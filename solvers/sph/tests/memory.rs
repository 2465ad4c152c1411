//! Memory by particle, against the sum of what is kept of each.

#[cfg(test)]
mod common;

use common::{Run, liquid, scene, water};

/// Particles a side.
const SIDE: i32 = 44;

/// Places that a row has beyond its neighbours in the mean: it is filled up to whole groups of eight.
const FILLED: f64 = 3.5;

/// Resident memory of this process \[B\]; `None` where the system does not say.
fn resident() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmRSS:"))?;
    Some(1024.0 * line.trim().strip_suffix("kB")?.trim().parse::<f64>().ok()?)
}

/// Mean length of a row: neighbours within 2.4 spacings in a cube of particles, and what fills it up.
fn neighbours() -> f64 {
    let all = (-2..=2).flat_map(|i| (-2..=2).flat_map(move |j| (-2..=2).map(move |k| [i, j, k])));
    let near = all.filter(|o: &[i32; 3]| (1..6).contains(&o.iter().map(|k| k * k).sum::<i32>()));
    let share = |k: i32| f64::from(SIDE - k.abs()) / f64::from(SIDE);
    near.map(|o| o.map(share).iter().product::<f64>()).sum::<f64>() + FILLED
}

/// A cube of particles after a step, and what each takes \[B\].
fn held(count: i32, pressure: &str) -> Option<(Run, f64)> {
    let before = resident()?;
    let side = f64::from(count) * 0.01;
    let mut start = scene(vec![liquid(water(20.0, 1.0), [side; 3], [0.0; 3], 0.01)], Vec::new(), 1e-3);
    start.actions.clear();
    start.params.insert("pressure".into(), pressure.into());
    let mut run = Run::new(start);
    run.step();
    let each = (resident()? - before) / f64::from(count.pow(3));
    Some((run, each))
}

#[test]
fn a_particle_takes_what_is_kept_of_it() {
    // Identity, position, velocity, density and where it was listed; body, mass and start, and place and volume as it was
    // filled, whose memory stays with the process; pack, acceleration and the next density.
    let (state, fixed, work) = (4 + 24 + 24 + 8 + 24, 4 + 8 + 24 + 24 + 8, 64 + 24 + 8);
    // Warm pressure; velocity before, row, what it feels, whether it is free, place, velocity, rate and mean before pressure,
    // base; trial, pushed, moved and rate.
    let more = 8 + 24 + 72 + 56 + 8 + 16 + 16 + 8 + 8 + 8 + 32 + 4 + 16 + 8;
    let lists = f64::from(state + fixed + work) + 4.0 * neighbours();
    // What densities read, and pairs in the kernel's reach.
    let weak = lists + 32.0 + 8.0 * neighbours();
    let kept = lists + f64::from(more) + 8.0 * neighbours();
    // What all runs share is there before: a pool of threads and the code.
    drop(held(13, "dfsph"));
    let (Some((_one, found_weak)), Some((_other, found))) = (held(SIDE, "wcsph"), held(SIDE, "dfsph")) else {
        eprintln!("skipped: this system does not say how much memory a process has");
        return;
    };
    println!("wcsph {found_weak:.0} B of {weak:.0}, dfsph {found:.0} B of {kept:.0}");
    // A fifth: vectors that grow.
    assert!((found / kept - 1.0).abs() < 0.2, "dfsph {found} B of {kept}");
    assert!((found_weak / weak - 1.0).abs() < 0.2, "wcsph {found_weak} B of {weak}");
}
