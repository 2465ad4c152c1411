//! The part of a domain that is computed follows the smoke.

#[cfg(test)]
mod common;

use common::{Run, ball, gravity, scene};
use cosplat_core::plugin::Plugin;
use serde_json::json;

/// A warm puff of 0.2 m in a room of 1.2 m by 1.2 m by 1.8 m.
fn puff(still: f64, threads: usize) -> Run {
    let params = json!({
        "low": [-0.6, -0.6, 0.0], "high": [0.6, 0.6, 1.8], "cell": 0.025, "temperature": 340, "still": still
    });
    let ball = ball(1.204, 0.1, [0.0, 0.0, 0.35], 0.0125);
    let mut start = scene(ball, vec![gravity([0.0, 0.0, -9.81])], 0.03, &params);
    start.threads = threads;
    Run::new(start)
}

/// Mean height of the smoke after so many windows \[m\], and the most cells that were computed.
fn rises(run: &mut Run, windows: u32) -> (f64, u64) {
    let (mut z, mut most) = (0.0, 0);
    for _ in 0..windows {
        let out = run.step();
        z = out.report.bodies[0].position_m[2];
        most = most.max(out.report.counters["largest-cells-computed"]);
    }
    (z, most)
}

#[test]
fn still_air_costs_nothing_and_changes_little() {
    let (mut all, mut near) = (puff(0.0, 2), puff(0.05, 2));
    let ((high, cells), (found, computed)) = (rises(&mut all, 24), rises(&mut near, 24));
    println!("{high} m with {cells} cells, {found} m with {computed} at most");
    // Five blocks of six, six and nine along the axes.
    assert!(2 * computed < cells, "{computed} of {cells}");
    // What flows around a ball of radius R is that of a dipole, and a side where the pressure is that of still air acts
    // as its image, (R/2d)³ of it: 0.7 % where the box begins a block and a half, 0.3 m, from the middle. The puff
    // becomes half as wide again, which makes it 2 %.
    assert!(((found - 0.35) / (high - 0.35) - 1.0).abs() < 0.02, "{high} {found}");
    // What came into view and what left it is booked, to roundings of the sums over faces.
    for run in [&all, &near] {
        assert!(run.defect[0] < 1e-12 * run.gross && run.defect[1] < 1e-12 * run.gross, "{:?}", run.defect);
    }
}

#[test]
fn a_box_that_moves_is_restored_and_is_the_same_on_any_threads() {
    let (mut one, mut two) = (puff(0.05, 1), puff(0.05, 2));
    let whole = two.bytes();
    rises(&mut one, 4);
    rises(&mut two, 4);
    assert_eq!(one.hash(), two.hash());
    let (part, window) = (two.bytes(), two.window);
    assert!(2 * part.len() < whole.len(), "{} of {} bytes", part.len(), whole.len());
    rises(&mut two, 6);
    let later = two.bytes();
    // The whole domain where there was a part, and a part where there was the whole domain.
    let mut fresh = puff(0.05, 1);
    for (run, saved, window) in [(&mut two, &whole, 0), (&mut fresh, &part, window)] {
        run.plugin.restore(saved).expect("it fits");
        assert!(run.bytes() == *saved);
        let left = 10 - window as u32;
        run.window = window;
        rises(run, left);
        assert!(run.bytes() == later);
    }
    assert!(fresh.plugin.restore(&part[8..]).is_err());
    assert!(fresh.bytes() == later, "what does not fit changes nothing");
}
