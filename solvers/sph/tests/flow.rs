//! Flows with a known answer.

#[cfg(test)]
mod common;

use common::{Run, liquid, scene, tank, water};
use cosplat_core::scene::{VelocityField, Wall};

/// Front of a collapsing column of width a = 0.146 m and height 2a, `(t √(2g/a), x/a)`: experiment of Koshizuka and Oka
/// (1996).
const MEASURED: [(f64, f64); 8] = [
    (0.381, 1.111),
    (0.769, 1.252),
    (1.153, 1.505),
    (1.537, 1.892),
    (1.935, 2.241),
    (2.323, 2.615),
    (2.719, 3.003),
    (3.096, 3.624),
];

/// The same of a column that is let go at once, without friction: a potential flow, by boundary elements, to 0.2 %
/// (`tests/verification/dam-break-front.study.toml` says how).
const IDEAL: [(f64, f64); 7] =
    [(0.4, 1.1212), (0.8, 1.3858), (1.2, 1.7462), (1.6, 2.1809), (2.0, 2.6764), (2.4, 3.2227), (2.8, 3.8122)];

/// The same as Martin and Moyce (1952) measured it for a = 2.25 inches, whose clock has no common zero with the paper that held
/// the column back: the potential flow runs through all five 0.31 earlier, which is taken off here.
const SET_RIGHT: [(f64, f64); 5] = [(0.522, 1.217), (0.909, 1.474), (1.687, 2.292), (2.237, 2.995), (3.035, 4.134)];

/// How a front runs.
struct Front {
    /// Deviation from a table, as a share of it.
    deviation: Vec<f64>,
    /// Its largest speed over `2 √(gH)`.
    speed: f64,
}

impl Front {
    /// Of water with a floor, that many particles across the column.
    fn of(across: f64, pressure: &str, floor: Wall, table: &[(f64, f64)]) -> Self {
        let (a, window) = (0.146, 2e-3);
        let (d, unit) = (a / across, (2.0_f64 * 9.81 / a).sqrt());
        let thick = 4.0 * d;
        // Ten times the largest speed of the fall.
        let sound = 10.0 * (2.0_f64 * 9.81 * 2.0 * a).sqrt();
        let column = liquid(water(sound, 1e-3), [a, thick, 2.0 * a], [0.5 * a, 0.5 * thick, a], d);
        // Far enough for all times of the tables.
        let mut walls = tank(5.0 * a, thick, Wall::Slip);
        walls[0].wall = floor;
        let mut start = scene(vec![column], walls, window);
        start.params.insert("pressure".into(), pressure.into());
        let mut run = Run::new(start);
        // The tongue begins where it has two rows across the tank: a lone drop is no front.
        let tongue = |run: &Run| {
            let mut all: Vec<f64> = run.particles().iter().map(|x| x[0]).collect();
            all.sort_by(f64::total_cmp);
            (all[all.len() - 8] + 0.5 * d) / a
        };
        let (mut path, mut deviation) = (vec![tongue(&run)], Vec::new());
        for &(t, x) in table {
            while run.time() * unit < t {
                run.step();
                path.push(tongue(&run));
            }
            let (late, n) = (run.time() - t / unit, path.len());
            let found = path[n - 1] - (path[n - 1] - path[n - 2]) * late / window;
            deviation.push(found / x - 1.0);
        }
        // Over five windows, a hundredth of a second.
        let speed = path.windows(6).map(|w| (w[5] - w[0]) * a / (5.0 * window)).fold(0.0, f64::max);
        println!("{pressure}: {} substeps, defect {:?} of {}, {deviation:.3?}", run.substeps, run.defect, run.gross);
        Self { deviation, speed: speed / (2.0 * (9.81_f64 * 2.0 * a).sqrt()) }
    }

    /// Mean and largest deviation.
    fn off(&self) -> [f64; 2] {
        let mean = self.deviation.iter().map(|x| x.abs()).sum::<f64>() / self.deviation.len() as f64;
        [mean, self.deviation.iter().map(|x| x.abs()).fold(0.0, f64::max)]
    }
}

#[test]
fn the_front_of_a_breaking_dam_is_not_behind_and_not_too_fast() {
    let Front { deviation, speed } = Front::of(20.0, "wcsph", Wall::NoSlip, &MEASURED);
    println!("largest speed {speed} of 2 sqrt(gH)");
    // Ritter's speed of a frictionless front of shallow water, which no real one exceeds.
    assert!(speed < 1.0, "{speed}");
    // The gate of the experiment takes time to open, that of the computation none: only the first instants, when a
    // kernel's width counts, may lag.
    assert!(deviation.iter().all(|&x| x > -0.05), "{deviation:?}");
}

#[test]
fn the_front_of_a_breaking_dam_runs_as_a_potential_flow_does() {
    for pressure in ["dfsph", "wcsph"] {
        let off = Front::of(20.0, pressure, Wall::Slip, &IDEAL).off();
        // The catalogue's gate. Most of what wcsph is late, 5 %, sound needs to let all of the column fall.
        assert!(off[0] < 0.05 && off[1] < 0.10, "{pressure}: {off:?}");
    }
}

#[test]
fn the_front_of_a_breaking_dam_runs_as_measured_once_the_clock_is_set_right() {
    let off = Front::of(20.0, "dfsph", Wall::Slip, &SET_RIGHT).off();
    // Spread of the published experiments: 5 % on average, 10 % at most.
    assert!(off[0] < 0.05 && off[1] < 0.10, "{off:?}");
}

#[test]
#[ignore = "not met, nor can it be: without a gate and friction the exact front, a potential flow, is ahead of this experiment by 13 % on average and 23 % at most; wcsph, which sound delays, by 6 % and 12 %, dfsph by 10 % and 17 %"]
fn the_front_of_a_breaking_dam_runs_as_measured() {
    let [mean, most] = Front::of(20.0, "wcsph", Wall::NoSlip, &MEASURED).off();
    // Spread of the published experiments: 5 % on average, 10 % at most.
    assert!(mean < 0.05 && most < 0.10, "mean {mean}, most {most}");
}

/// Power lost in a block of `n` cells a side that is sheared at 1/s, its lattice turned by that half angle about y, over
/// that of its volume \[Pa s\].
fn shear_loss(n: f64, half_angle: f64) -> f64 {
    let d = 0.01;
    let mut block = liquid(water(20.0, 10.0), [n * d; 3], [0.0; 3], d);
    block.pose.orientation = [0.0, half_angle.sin(), 0.0, half_angle.cos()];
    let gradient_1_s = [[0.0, 0.0, 1.0], [0.0; 3], [0.0; 3]];
    block.velocity = VelocityField::LinearMap { linear_m_s: [0.0; 3], gradient_1_s, about_m: [0.0; 3] };
    let mut start = scene(vec![block], Vec::new(), 1e-6);
    start.actions.clear();
    let lost = Run::new(start).step().report.energy.dissipated_j;
    lost / (1e-6 * (n * d).powi(3))
}

#[test]
fn shear_costs_what_the_viscosity_says() {
    // A particle near the surface lacks neighbours: what is lost by volume is μ γ² (1 - k/n) to first order in 1/n.
    let inside = |half_angle: f64| 2.0 * shear_loss(24.0, half_angle) - shear_loss(12.0, half_angle);
    // A cubic lattice has nearly the same viscosity along its axes and across them.
    let (across, along) = (inside(0.0), inside(std::f64::consts::FRAC_PI_8));
    let mean = (3.0 * across + 2.0 * along) / 5.0;
    println!("{across} across, {along} along the lattice: {mean} Pa s instead of 10");
    assert!((along / across - 1.0).abs() < 0.03, "{along} {across}");
    // Edges of order 1/n² = (2.4/12)² of the loss.
    assert!((mean / 10.0 - 1.0).abs() < 0.05, "{mean}");
}
