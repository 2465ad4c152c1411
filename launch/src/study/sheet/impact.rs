//! What an impact does: how deep the striker goes in, and how fast it comes back.

use cosplat_core::scene::{ProbeQuantity, Scene};
use serde::Serialize;

use crate::folder::curves::Table;

/// An impact, measured along the direction in which the striker came.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Impact {
    /// Begin of the window in which it first touches \[s\].
    pub(crate) touch_s: f64,
    /// Its speed then \[m/s\].
    pub(crate) approach_m_s: f64,
    /// How far it goes on from there before it first turns \[m\]: the dent, with whatever way the body gives as a whole.
    /// Exact to the way of one window; null where it never turns, because it goes through or slides off.
    pub(crate) dent_m: Option<f64>,
    /// Largest speed back before it turns again, over the speed at the touch; 0 where it never turns.
    pub(crate) rebound: f64,
}

/// Position \[m\] or velocity \[m/s\] over time \[s\].
type Path = Vec<(f64, [f64; 3])>;

impl Impact {
    /// The first impact of a body; none where its position and velocity are not probed, or nothing crosses.
    pub(crate) fn of(striker: &str, scene: &Scene, probes: &Table, ledger: &Table) -> Option<Self> {
        let of = |quantity| path(scene, striker, quantity, probes);
        let crossing: Vec<_> = ledger.value_names().filter(|name| is_crossing(name, striker)).collect();
        let curves = crossing.iter().filter_map(|name| ledger.curve(name));
        let settled_s = curves.flatten().filter(|(_, gross)| *gross > 0.0).map(|(t, _)| t).reduce(f64::min)?;
        measure(&of(ProbeQuantity::Position)?, &of(ProbeQuantity::Velocity)?, settled_s)
    }
}

/// Whether a column of the ledger is the gross impulse of an interface with this body, as in `target~striker.gross_n_s`.
fn is_crossing(column: &str, body: &str) -> bool {
    column.strip_suffix(".gross_n_s").is_some_and(|name| {
        // Two interfaces of the same bodies are told apart by a number behind `#`.
        let sides = name.rsplit_once('#').map_or(name, |(sides, _)| sides);
        sides.split('~').any(|side| side == body)
    })
}

fn path(scene: &Scene, body: &str, quantity: ProbeQuantity, probes: &Table) -> Option<Path> {
    let probe = scene.probes.iter().find(|p| p.quantity == quantity && p.body.as_deref() == Some(body))?;
    let [x, y, z] = ["x", "y", "z"].map(|axis| probes.curve(&format!("{}.{axis}", probe.name)));
    Some(x?.iter().zip(&y?).zip(&z?).map(|((x, y), z)| (x.0, [x.1, y.1, z.1])).collect())
}

/// `settled_s`: end of the first window with an impulse. Positions and velocities are those at the edges of windows.
fn measure(positions: &Path, velocities: &Path, settled_s: f64) -> Option<Impact> {
    // Times of two tables are the same product, but for what their printing rounds.
    let first = positions.iter().position(|(t, _)| *t > settled_s * (1.0 - 1e-9))?.checked_sub(1)?;
    let (touch_s, from) = positions[first];
    let speed = velocities.get(first)?.1;
    let approach_m_s = speed.map(|v| v * v).iter().sum::<f64>().sqrt();
    let along = |v: [f64; 3]| v.iter().zip(speed).map(|(a, b)| a * b).sum::<f64>() / approach_m_s;
    let depth = |p: [f64; 3]| along([0, 1, 2].map(|k| p[k] - from[k]));
    let turn = velocities.iter().enumerate().skip(first).find(|(_, (_, v))| along(*v) <= 0.0).map(|(at, _)| at);
    let dent_m = turn
        .and_then(|turn| positions.get(first..=turn))
        .map(|way| way.iter().map(|(_, p)| depth(*p)).fold(0.0, f64::max));
    let back = velocities.iter().skip(turn.unwrap_or(velocities.len())).map(|(_, v)| -along(*v));
    let rebound = back.take_while(|speed| *speed >= 0.0).fold(0.0, f64::max) / approach_m_s;
    (approach_m_s > 0.0 && rebound.is_finite()).then_some(Impact { touch_s, approach_m_s, dent_m, rebound })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_striker_is_followed_from_the_touch_to_its_turn_and_back() {
        // At 2 m/s downwards until 0.3 s, then 0.1 m of braking, back at 0.5 m/s from 0.5 s on, and away at last.
        let at = |t: f64| match t {
            t if t < 0.3 => (1.0 - 2.0 * t, -2.0),
            t if t < 0.4 => (0.4 - (t - 0.3), -1.0),
            t if t < 0.5 => (0.3, 0.0),
            t if t < 0.7 => (0.3 + 0.5 * (t - 0.5), 0.5),
            t => (0.4 - 5.0 * (t - 0.7), -5.0),
        };
        let times: Vec<f64> = (0..=100).map(|i| f64::from(i) * 0.01).collect();
        let curve = |pick: fn((f64, f64)) -> f64| times.iter().map(|&t| (t, [0.0, 0.0, pick(at(t))])).collect();
        let (positions, velocities): (Path, Path) = (curve(|a| a.0), curve(|a| a.1));
        let found = measure(&positions, &velocities, 0.3).unwrap();
        // The window that ends at 0.30 s begins 0.02 m above the place at which it ends.
        assert!((found.touch_s - 0.29).abs() < 1e-12 && (found.dent_m.unwrap() - 0.12).abs() < 1e-9, "{found:?}");
        assert!((found.approach_m_s - 2.0).abs() < 1e-12 && (found.rebound - 0.25).abs() < 1e-12, "{found:?}");
        assert_eq!(measure(&positions, &velocities, 2.0), None);
        let through = measure(&positions[..35].to_vec(), &velocities[..35].to_vec(), 0.3).unwrap();
        assert_eq!((through.dent_m, through.rebound), (None, 0.0));
    }

    #[test]
    fn interfaces_are_known_by_whole_names() {
        assert!(
            is_crossing("target~striker.gross_n_s", "striker") && !is_crossing("target~striker2.gross_n_s", "striker")
        );
        assert!(is_crossing("target~striker#2.gross_n_s", "striker"));
        assert!(!is_crossing("target~striker.transfer_defect_n_s", "striker"));
    }
}
