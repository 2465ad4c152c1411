//! What any solver plugin must pass, whoever wrote it.
//!
//! [`check`] drives a plugin through its contract, scene by scene, and lists every [`Violation`] with the rule it breaks
//! and why the rule matters; [`assert_conforms`] fails a test with that list. A scene to play is a [`Case`]: the part of
//! the scene, what never changes about its partners, and what it hears in each window. [`parts`] helps to write scenes.
//!
//! ```no_run
//! # fn make() -> Box<dyn cosplat_core::plugin::Plugin> { unimplemented!() }
//! use cosplat_conformance::{Case, assert_conforms, parts};
//!
//! let scene = parts::solver_scene("mine", vec![parts::point("bead", 1.0, [0.0; 3], [1.0, 0.0, 0.0])], 3, 0.01);
//! assert_conforms(&make, &[Case::new("free flight", scene)]);
//! ```

mod books;
mod descriptor;
mod hostile;
pub mod parts;
mod refusal;
mod repeat;
mod rule;
mod shape;
mod trial;

use cosplat_core::plugin::{Inputs, PartnerSetup, Plugin, SolverScene};

pub use rule::{Rule, Violation};

use trial::{Trial, Verdict};

/// A scene to play.
#[derive(Clone, Debug)]
pub struct Case {
    /// Name in reports.
    pub name: String,
    /// The plugin's part of the scene.
    pub scene: SolverScene,
    /// What never changes about its partners.
    pub partners: Vec<PartnerSetup>,
    /// What it hears in each window; as many windows are played, one at least.
    pub windows: Vec<Inputs>,
    /// Largest closure of linear and angular momentum in a window, relative to the largest momenta of the run.
    ///
    /// 1e-12 for plugins that compute in double precision, max(1e-6, 6e-8 × substeps) in single precision.
    pub closure_gate: f64,
    /// Whether something moves, so that the state after a window differs from the state before.
    pub moves: bool,
}

impl Case {
    /// A moving scene without partners, played for three windows at the gate of double precision.
    pub fn new(name: &str, scene: SolverScene) -> Self {
        Self {
            name: name.to_owned(),
            scene,
            partners: Vec::new(),
            windows: vec![Inputs::default(); 3],
            closure_gate: 1e-12,
            moves: true,
        }
    }

    /// The same with partners: what never changes about them and what is heard in each window.
    #[must_use]
    pub fn hearing(self, partners: Vec<PartnerSetup>, windows: Vec<Inputs>) -> Self {
        Self { partners, windows, ..self }
    }
}

/// Makes a plugin that has not been set up.
pub type Make<'m> = &'m dyn Fn() -> Box<dyn Plugin>;

/// Everything that a plugin breaks in these cases; empty for a plugin that may join a run.
pub fn check(make: Make<'_>, cases: &[Case]) -> Vec<Violation> {
    let mut verdict = Verdict::new("the plugin itself");
    descriptor::check(make, &mut verdict);
    let mut found = verdict.violations;
    for case in cases {
        let mut verdict = Verdict::new(&case.name);
        let played = Trial::start(make, case).map_err(|why| format!("set-up failed: {why}"));
        // Where a scene cannot be played at all, nothing else can be said about it.
        if let Err(why) = played.and_then(|(mut trial, _)| trial.play(case.windows.len())) {
            verdict.add(Rule::ScenePlays, why);
        } else {
            shape::check(make, case, &mut verdict);
            books::check(make, case, &mut verdict);
            repeat::check(make, case, &mut verdict);
            hostile::check(make, case, &mut verdict);
            refusal::check(make, case, &mut verdict);
        }
        found.append(&mut verdict.violations);
    }
    found
}

/// Fails with the whole list of violations, if there are any.
///
/// # Panics
/// When the plugin breaks a rule.
pub fn assert_conforms(make: Make<'_>, cases: &[Case]) {
    let found = check(make, cases);
    let list: Vec<String> = found.iter().map(ToString::to_string).collect();
    assert!(list.is_empty(), "{} violations of the plugin contract:\n{}", list.len(), list.join("\n"));
}
