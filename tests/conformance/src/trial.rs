//! One plugin playing one case.

use cosplat_core::plugin::{Inputs, Outputs, Plugin, PluginError, Pulse, Setup, SolverScene, StateHasher, Steady};

use crate::rule::{Rule, Violation};
use crate::{Case, Make, parts};

/// Violations of one case.
pub(crate) struct Verdict {
    case: String,
    pub(crate) violations: Vec<Violation>,
}

impl Verdict {
    pub(crate) fn new(case: &str) -> Self {
        Self { case: case.to_owned(), violations: Vec::new() }
    }

    pub(crate) fn add(&mut self, rule: Rule, found: impl Into<String>) {
        self.violations.push(Violation { case: self.case.clone(), rule, found: found.into() });
    }

    /// Adds a violation unless `holds`.
    pub(crate) fn must(&mut self, holds: bool, rule: Rule, found: impl FnOnce() -> String) {
        if !holds {
            self.add(rule, found());
        }
    }
}

/// A plugin that has been set up and connected.
pub(crate) struct Trial<'c> {
    pub(crate) plugin: Box<dyn Plugin>,
    case: &'c Case,
}

impl<'c> Trial<'c> {
    pub(crate) fn start(make: Make<'_>, case: &'c Case) -> Result<(Self, Setup), PluginError> {
        Self::start_with(make, case, &case.scene)
    }

    /// Starts the case with another scene.
    pub(crate) fn start_with(
        make: Make<'_>,
        case: &'c Case,
        scene: &SolverScene,
    ) -> Result<(Self, Setup), PluginError> {
        let mut plugin = make();
        let setup = plugin.setup(scene)?;
        plugin.connect(&case.partners)?;
        Ok((Self { plugin, case }, setup))
    }

    /// Plays the first windows; in words where one fails.
    pub(crate) fn play(&mut self, windows: usize) -> Result<Vec<Outputs>, String> {
        (0..windows).map(|w| self.window(w).map_err(|why| format!("window {w} failed: {why}"))).collect()
    }

    /// Plays one window as the case has it.
    pub(crate) fn window(&mut self, window: usize) -> Result<Outputs, PluginError> {
        self.hear(window, &self.case.windows[window], &mut Steady)
    }

    /// Plays one window with other inputs or another pulse.
    pub(crate) fn hear(
        &mut self,
        window: usize,
        inputs: &Inputs,
        pulse: &mut dyn Pulse,
    ) -> Result<Outputs, PluginError> {
        self.plugin.advance(&parts::step(&self.case.scene.clock, window as u64), inputs, pulse)
    }

    pub(crate) fn saved(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.plugin.save(&mut bytes);
        bytes
    }

    pub(crate) fn hash(&self) -> u128 {
        let mut hasher = StateHasher::default();
        self.plugin.save(&mut hasher);
        hasher.finish()
    }
}

/// Every bit of an answer as text: shortest digits that name each number, signs of zeros and NaN included.
pub(crate) fn bits(of: &impl std::fmt::Debug) -> String {
    format!("{of:?}")
}
