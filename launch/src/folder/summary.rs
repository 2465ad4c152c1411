//! `summary.json`: outcome and budgets of a run, for programs. The schema is committed beside the sources.
//!
//! Every number in it was measured in the run it describes. SI units; hashes are hexadecimal.

use std::collections::BTreeMap;

use cosplat_core::scene::Scene;
use cosplat_core::scene::presets::preset;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::estimate::{EnergyBudget, Estimate};
use crate::verdict::Verdict;

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Status {
    /// All windows are settled and every verdict is good.
    Ok,
    /// All windows are settled, but a verdict says that the result is not to be trusted.
    VerdictFailed,
    /// Ended early.
    Failed,
    /// Stopped by the user at the edge of a window.
    Interrupted,
}

/// Outcome and budgets of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(title = "Summary of a Cosplat run")]
pub(crate) struct Summary {
    /// How the run ended.
    pub(crate) status: Status,
    /// Exit code of the program.
    pub(crate) exit_code: u8,
    /// Why it ended early, in words.
    pub(crate) failure: Option<String>,
    /// Name of the scene.
    pub(crate) scene: String,
    /// Settled coupling windows.
    pub(crate) windows: u64,
    /// Length of a window [s].
    pub(crate) window_s: f64,
    /// The term that bounds the window.
    pub(crate) window_bound_by: String,
    /// Simulated time of the settled windows [s].
    pub(crate) simulated_s: f64,
    /// Wall time from the start of the run, before its processes, to the last settled window [s].
    pub(crate) wall_s: f64,
    /// Chain of the state hashes of all settled windows, 32 hex digits; null before the first one.
    pub(crate) state_hash: Option<String>,
    /// What decides whether the result is to be trusted.
    pub(crate) verdicts: Vec<Verdict>,
    /// Solver processes, in name order.
    pub(crate) processes: Vec<Process>,
    /// What was made of frames beside the solvers; null where there are none.
    pub(crate) frames: Option<Frames>,
    /// Bodies, by process and in scene order.
    pub(crate) bodies: Vec<Body>,
    /// Pairs of bodies in different processes that touch or are joined.
    pub(crate) interfaces: Vec<Interface>,
    /// Energies of each process, of each link between processes, and of the whole.
    pub(crate) energy: Vec<Energy>,
    /// Whether energy and what was dissipated of it stay at the start; null where the energy at t = 0 is not known.
    #[serde(default)]
    pub(crate) energy_budget: Option<EnergyBudget>,
    /// Clamps, quarantines, overflows and the like, by process; absent means none.
    pub(crate) counters: BTreeMap<String, BTreeMap<String, u64>>,
    /// How wrong the run is by its own measurements, what that means, and what lowers it.
    #[serde(default)]
    pub(crate) estimates: Vec<Estimate>,
    /// Published materials that the scene takes, and how their numbers are read.
    #[serde(default)]
    pub(crate) presets: Vec<PresetNote>,
    /// What was not started, computed, sent or written, and why.
    pub(crate) left_out: Vec<LeftOut>,
    /// Files of the run, below its folder.
    pub(crate) files: BTreeMap<String, String>,
}

/// A solver process.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub(crate) struct Process {
    /// Name on the bus.
    pub(crate) name: String,
    /// Plugin it ran.
    pub(crate) solver: String,
    /// Threads it was given.
    pub(crate) threads: usize,
    /// Processor time, user and system [s]; null where the system does not tell.
    pub(crate) cpu_s: Option<f64>,
    /// Wall time inside the solver [s].
    pub(crate) compute_s: f64,
    /// Wall time waiting for partners or for the clock [s].
    pub(crate) wait_s: f64,
    /// Wall time encoding, sending and decoding [s].
    pub(crate) transfer_s: f64,
    /// Substeps in all settled windows.
    pub(crate) substeps: u64,
    /// The term that bound the substep of the last window.
    pub(crate) substep_bound_by: String,
    /// Largest resident memory [MiB], sampled twice a second; null where the system does not tell.
    pub(crate) peak_rss_mib: Option<f64>,
}

/// Frames drawn, written and recorded by the launcher while the solvers went on.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub(crate) struct Frames {
    /// Frames taken, the state at t = 0 among them.
    pub(crate) taken: u64,
    /// Wall time of moving Gaussians [s].
    pub(crate) skin_s: f64,
    /// Wall time of drawing and writing pictures [s].
    pub(crate) draw_s: f64,
    /// Wall time of writing splat files [s].
    pub(crate) write_s: f64,
    /// Wall time of recording [s].
    pub(crate) record_s: f64,
    /// Who drew the pictures: the CPU, or a graphics processor by its name, and why; empty in older summaries.
    #[serde(default)]
    pub(crate) drawn_by: String,
}

/// A body.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub(crate) struct Body {
    /// Name.
    pub(crate) name: String,
    /// Process that owns it.
    pub(crate) solver: String,
    /// Gaussians that follow it.
    pub(crate) gaussians: u64,
    /// Particles its solver made of it.
    pub(crate) particles: u64,
    /// Mass [kg].
    pub(crate) mass_kg: f64,
    /// Largest distance of a particle from its start, over all settled windows [m].
    pub(crate) max_displacement_m: f64,
}

/// Two bodies in different processes that touch or are joined.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub(crate) struct Interface {
    /// Resolver of a contact or centred link; the side that goes first of another link.
    pub(crate) a: String,
    /// The other side.
    pub(crate) b: String,
    /// `contact` or `link`.
    pub(crate) kind: String,
    /// Process that computes the force, where one does and impulses cross; null for links computed by both sides.
    pub(crate) resolver: Option<String>,
    /// Sum of the impulses given by `a`, by component [N s].
    pub(crate) impulse_given: [f64; 3],
    /// Sum of the impulses received by `b`, by component [N s].
    pub(crate) impulse_received: [f64; 3],
    /// Sum of the magnitudes of all impulses [N s].
    pub(crate) gross_impulse: f64,
    /// Sum over the windows of |given - received| [N s]: exactly 0 where impulses cross, of first order in the window
    /// for other links.
    pub(crate) transfer_defect: f64,
    /// Angular momentum made or lost in the crossing, summed over the windows [N m s]: zero for rigid bodies; impulses
    /// on samples act where these are, not where the partner computed them.
    pub(crate) moment_defect: f64,
    /// Larger closure of its two processes in the worst window: what the states do not explain, relative to the
    /// run's largest gross momentum.
    pub(crate) closure: f64,
    /// Larger of the relative transfer defect (over the gross impulse) and the closure.
    pub(crate) momentum_defect: f64,
    /// Energy made (positive) or lost (negative) by the exchange over the run [J].
    pub(crate) work_defect: f64,
    /// Largest difference between a stand-in and the partner itself.
    pub(crate) residual: f64,
    /// Largest distance of a body on a link from where the other side took it to be in a window [m]; 0 for contacts.
    #[serde(default)]
    pub(crate) foreseen_m: f64,
}

/// Energy of a part of the system.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub(crate) struct Energy {
    /// Process, interface, or `total`.
    pub(crate) name: String,
    /// Kinetic and potential at t = 0 [J]; null where no state at t = 0 tells it.
    pub(crate) initial_j: Option<f64>,
    /// After the first window [J].
    pub(crate) first_j: f64,
    /// After the last settled window [J].
    pub(crate) final_j: f64,
    /// Smallest after any window [J].
    pub(crate) min_j: f64,
    /// Largest after any window [J].
    pub(crate) max_j: f64,
    /// Lost to friction, damping and plasticity since t = 0 [J].
    pub(crate) dissipated_j: f64,
    /// Given from outside since t = 0 [J]: by wind, kicks, pulled pins, driven bodies, and what flowed in less what flowed
    /// out.
    pub(crate) supplied_j: f64,
    /// Largest of it after any window [J]: what is given may be taken back.
    #[serde(default)]
    pub(crate) max_supplied_j: f64,
    /// Largest after any window of what is left when that is taken off [J]: above the start, it came from nowhere.
    pub(crate) max_unsupplied_j: f64,
    /// The same with what was dissipated [J]: where every loss is measured by itself, this stays at the start.
    pub(crate) max_balance_j: f64,
    /// Smallest potential, stored in it included, at t = 0 or after any window [J].
    #[serde(default)]
    pub(crate) min_potential_j: f64,
}

/// A published material that the scene takes, and what its numbers mean.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub(crate) struct PresetNote {
    /// Name in scene files.
    pub(crate) name: String,
    /// Document and table.
    pub(crate) source: String,
    /// How the published numbers are read, and which had to be filled in.
    pub(crate) note: String,
}

impl PresetNote {
    /// Of each that a scene takes.
    pub(crate) fn of(scene: &Scene) -> Vec<Self> {
        let known = scene.presets.iter().filter_map(|name| preset(name));
        known.map(|p| Self { name: p.name.into(), source: p.source.into(), note: p.note.into() }).collect()
    }

    /// In one line.
    pub(crate) fn words(&self) -> String {
        format!("`{}` of {}: {}", self.name, self.source, self.note)
    }
}

impl Summary {
    /// Energy that is gone and in no book \[J\]: impact took it, and the damping of the methods. Nothing where the energy at
    /// t = 0 is not known.
    pub(crate) fn lost_j(&self) -> Option<f64> {
        let total = self.energy.last()?;
        Some(total.initial_j? + total.supplied_j - total.dissipated_j - total.final_j)
    }
}

/// A thing not started, computed, sent or written.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub(crate) struct LeftOut {
    /// What.
    pub(crate) what: String,
    /// Why, in words.
    pub(crate) why: String,
    /// Value on which the decision rests.
    pub(crate) indicator: Option<f64>,
    /// Limit it was compared with.
    pub(crate) limit: Option<f64>,
    /// What was saved, or `not measured`.
    pub(crate) saved: String,
}

impl From<&cosplat_core::plan::LeftOut> for LeftOut {
    fn from(from: &cosplat_core::plan::LeftOut) -> Self {
        Self {
            what: from.what.clone(),
            why: from.why.clone(),
            indicator: from.indicator,
            limit: from.limit,
            saved: from.saved.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Set to write the schema instead of comparing with it.
    const UPDATE: &str = "COSPLAT_UPDATE_SCHEMA";

    #[test]
    fn the_committed_schema_is_current() {
        let path = std::path::PathBuf::from(std::env::var("CARGO_MANIFEST_DIR").expect("cargo runs the tests"))
            .join("summary.schema.json");
        let current = serde_json::to_string_pretty(&schemars::schema_for!(Summary)).unwrap() + "\n";
        if std::env::var_os(UPDATE).is_some() {
            std::fs::write(&path, &current).unwrap();
        }
        let committed = std::fs::read_to_string(&path).unwrap_or_default();
        assert_eq!(committed, current, "run the tests once with {UPDATE}=1 and commit {}", path.display());
    }
}
