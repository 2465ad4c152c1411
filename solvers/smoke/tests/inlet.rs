//! An inlet with a solid in it: no air comes out of a wall.

#[cfg(test)]
mod common;

use common::{Run, ball, scene, wall, wind};
use cosplat_core::scene::Source;
use serde_json::json;

/// Mean velocity along a duct of 0.8 m by 0.4 m by 0.4 m in a wind of 1 m/s, at the start and after a while \[m/s\];
/// half of its inlet is closed by a block, or all of it is open.
fn through(blocked: bool) -> [f64; 2] {
    let params = json!({
        "low": [0, 0, 0], "high": [0.8, 0.4, 0.4], "cell": 0.025, "open": ["-x", "+x"], "divergence": 1e-5
    });
    let mut start = scene(ball(1.204, 0.1, [0.4, 0.2, 0.2], 0.0125), vec![wind([1.0, 0.0, 0.0])], 0.01, &params);
    if blocked {
        start.statics.push(wall("block", Source::Box { size_m: [0.2, 0.4, 0.4] }, [0.0, 0.4, 0.2]));
    }
    let mut run = Run::new(start);
    let begin = run.momentum.linear[0];
    (0..5).for_each(|_| drop(run.step()));
    // Roundings of sums over the faces of walls, as in `books`.
    assert!(run.defect[0] < 1e-12 * run.gross, "{:?}", run.defect);
    [begin, run.momentum.linear[0]].map(|p| p / (1.204 * 0.8 * 0.4 * 0.4))
}

#[test]
fn no_air_comes_out_of_a_block_in_an_inlet() {
    let (free, half) = (through(false), through(true));
    println!("{free:?} and {half:?} m/s");
    // The gas has the faces of the outlet and none of those of the inlet, so its momentum is that of as many cross
    // sections as there are cells; what flows through each is what comes in. A wall lets a thousandth through, and the
    // projection leaves 1e-5 of the largest speed in each of 32 cells.
    for (free, half) in free.into_iter().zip(half) {
        assert!((free - 1.0).abs() < 1e-3, "{free}");
        assert!((half - 0.5005).abs() < 1e-3, "{half}");
    }
}
