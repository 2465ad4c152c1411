//! Published materials by name, each with where it stands and what its numbers really mean.
//!
//! The values are those that were printed. Where the simulator that produced the published pictures gives a number
//! another meaning than its unit says, the note tells which value repeats the pictures.

mod captured;
mod wonderplay;

use super::material::Material;
use super::pair::PairDefaults;

pub use wonderplay::{SIMULATION as WONDERPLAY_SIMULATION, SimulationDefaults};

/// A published material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Preset {
    /// Name in scene files.
    pub name: &'static str,
    /// The material, with the published numbers in SI units.
    pub material: Material,
    /// Document and table.
    pub source: &'static str,
    /// What the published numbers mean, and which had to be filled in.
    pub note: &'static str,
    /// Contact parameters that were published with it.
    pub coupling: Option<PairDefaults>,
}

/// Every preset, in the order of the tables.
pub fn presets() -> impl Iterator<Item = &'static Preset> {
    captured::PRESETS.iter().chain(wonderplay::PRESETS)
}

/// The preset of this name.
pub fn preset(name: &str) -> Option<&'static Preset> {
    presets().find(|preset| preset.name == name)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// Six digits of the table of derived material numbers (P-wave speed of the tables' E, ν, ρ).
    const PRINTED_DIGITS: f64 = 1e-5;

    fn wave_speed(name: &str) -> f64 {
        preset(name).and_then(|p| p.material.wave_speed_m_s()).expect("a preset with a wave")
    }

    #[test]
    fn wave_speeds_are_those_of_the_derived_table() {
        let derived = [
            ("can", 275.885),
            ("car", 275.885),
            ("plushie", 7.134_86),
            ("lunch-bag", 9.622_5),
            ("environment", 5736.87),
            ("wonderplay-elastic", 18.257_4),
            // The table takes the liquid for a solid; without shear its speed is √(ν/(1-ν)) = 1/2 of that.
            ("wonderplay-liquid", 105.409 / 2.0),
            ("wonderplay-granular", 33.333_3),
            // √(7 · 60 000 / 1000).
            ("mudslide", 20.493_9),
        ];
        for (name, expected) in derived {
            let speed = wave_speed(name);
            assert!((speed / expected - 1.0).abs() < PRINTED_DIGITS, "{name}: {speed} m/s, not {expected}");
        }
    }

    #[test]
    fn stable_steps_are_those_of_the_derived_table() {
        for (name, expected) in [("can", 3.6247e-5), ("plushie", 1.401_57e-3), ("environment", 1.743_11e-6)] {
            let step = preset(name).and_then(|p| p.material.stable_dt_s(0.01)).expect("a preset with a wave");
            assert!((step / expected - 1.0).abs() < PRINTED_DIGITS, "{name}: {step} s, not {expected}");
        }
    }

    #[test]
    fn names_are_unique_and_nothing_is_left_empty() {
        let names: BTreeSet<_> = presets().map(|p| p.name).collect();
        assert_eq!(names.len(), presets().count());
        assert_eq!(names.len(), 16);
        for preset in presets() {
            assert!(preset.name.bytes().all(|b| b.is_ascii_lowercase() || b == b'-'), "{}", preset.name);
            assert!(preset.source.contains("Table") && preset.note.len() > 20, "{}", preset.name);
        }
    }

    /// At the published 128 cells a metre and ten steps of 1 ms every MPM default breaks the Courant limit.
    #[test]
    fn published_step_is_too_long_for_the_published_materials() {
        let spacing_m = 1.0 / WONDERPLAY_SIMULATION.grid_density_1_m;
        let step_s = WONDERPLAY_SIMULATION.step_s / f64::from(WONDERPLAY_SIMULATION.substeps);
        for (name, factor) in [("wonderplay-elastic", 2.3), ("wonderplay-liquid", 6.7), ("wonderplay-granular", 4.3)] {
            let limit_s = preset(name).and_then(|p| p.material.stable_dt_s(spacing_m)).expect("a preset with a wave");
            assert!((step_s / limit_s - factor).abs() < 0.06, "{name}: {}", step_s / limit_s);
        }
    }
}
