//! What a study is asked to find out: a scene, what its result is compared with, what is varied, and what must hold.

use serde::Serialize;

use super::formula::Formula;
use super::outcome::Class;

/// A case: a scene and its reference.
#[derive(Clone, Debug)]
pub(crate) struct Case {
    /// Short name: of its file, or of the scene.
    pub(crate) name: String,
    /// One line for people.
    pub(crate) title: String,
    /// Scene file or name of a built-in scene, as `cosplat run` takes it.
    pub(crate) scene: String,
    /// Where the reference is from; empty where the finest run is the reference.
    pub(crate) source: String,
    /// What is compared. Empty: all probes, with the finest run.
    pub(crate) quantities: Vec<Quantity>,
    /// Values of the scene that every run has: key and value.
    pub(crate) set: Vec<(String, Level)>,
    /// What is varied; the last one is the axis of the order fit, coarse to fine.
    pub(crate) vary: Vec<Factor>,
    /// Another scene that each run is compared with.
    pub(crate) twin: Option<Twin>,
    /// What must hold.
    pub(crate) gates: Vec<Gate>,
    /// Whether it takes minutes, so that a study of its folder leaves it out.
    pub(crate) slow: bool,
}

/// Another scene, run with everything that the case varies and without what it sets.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Twin {
    /// Scene file or name of a built-in scene, as `cosplat run` takes it.
    pub(crate) scene: String,
    /// Values of the scene that every run has: key and value.
    pub(crate) set: Vec<(String, Level)>,
    /// Time of the case over that of the twin, where their units differ.
    pub(crate) time: f64,
}

impl Case {
    /// A scene that nothing is known about: no reference, no gate, nothing varied.
    pub(crate) fn plain(name: &str, title: &str, scene: &str, set: Vec<(String, Level)>) -> Self {
        Self {
            name: name.to_owned(),
            title: title.to_owned(),
            scene: scene.to_owned(),
            source: String::new(),
            quantities: Vec::new(),
            set,
            vary: Vec::new(),
            twin: None,
            gates: Vec::new(),
            slow: false,
        }
    }

    /// What has to be run beside it, with the same values.
    pub(crate) fn beside(&self) -> Option<Self> {
        let twin = self.twin.as_ref()?;
        let name = format!("{}-twin", self.name);
        Some(Self { vary: self.vary.clone(), ..Self::plain(&name, &self.title, &twin.scene, twin.set.clone()) })
    }
}

/// A value of the scene that is varied.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Factor {
    /// Place in the scene, as in `clock.window`.
    pub(crate) key: String,
    /// Its values, coarse to fine.
    pub(crate) values: Vec<Level>,
}

/// One value of what is varied.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub(crate) struct Level {
    /// The value for people and comparisons: numbers in their shortest form, words without quotes.
    pub(crate) shown: String,
    /// The value as TOML.
    #[serde(skip)]
    pub(crate) toml: String,
}

impl Level {
    /// A value as it stands in a file or on the command line.
    pub(crate) fn of(toml: &str) -> Self {
        let plain = toml.trim();
        let shown = match plain.replace('_', "").parse::<f64>() {
            Ok(number) if number.is_finite() => number.to_string(),
            _ => plain.trim_matches(['"', '\'']).to_owned(),
        };
        Self { shown, toml: plain.to_owned() }
    }

    /// The value, where it is a number.
    pub(crate) fn number(&self) -> Option<f64> {
        self.shown.parse().ok().filter(|n: &f64| n.is_finite())
    }
}

/// Something measured.
#[derive(Clone, Debug)]
pub(crate) struct Quantity {
    /// Column of the probes, or the name of the invariant.
    pub(crate) name: String,
    /// How it is judged.
    pub(crate) kind: Kind,
}

/// How a quantity is judged.
#[derive(Clone, Debug)]
pub(crate) enum Kind {
    /// A column of the probes against a reference.
    Probe(Box<Comparison>),
    /// Something that must not change.
    Invariant(Invariant),
}

/// A column of the probes against a reference.
#[derive(Clone, Debug)]
pub(crate) struct Comparison {
    /// What is right.
    pub(crate) reference: Reference,
    /// Norm of the difference.
    pub(crate) measure: Measure,
    /// Replaces the norm of the reference, in the unit of the probe.
    pub(crate) scale: Option<f64>,
    /// Begin of the interval that is judged \[s\].
    pub(crate) from_s: f64,
    /// Its end \[s\].
    pub(crate) until_s: f64,
    /// Scatter of the reference, in the unit of the probe: differences below it count as none.
    pub(crate) spread: f64,
}

/// What is right.
#[derive(Clone, Debug)]
pub(crate) enum Reference {
    /// A closed form, compared at the times of the run.
    Exact(Formula),
    /// Time \[s\] and value, compared at these times.
    Table(Vec<(f64, f64)>),
    /// Anything between two values, in the unit of the probe: the distance from them counts.
    Between([f64; 2]),
    /// The finest run of the study, compared at the times of the run.
    Finest,
    /// The run of [`Case::twin`] with the same settings, compared at the times of the run: its values times this.
    Twin(f64),
}

/// Norm of a difference, relative to that of the reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Measure {
    /// Root of the mean square over the interval.
    L2,
    /// Largest magnitude.
    Max,
    /// At the end of the interval.
    Final,
    /// Mean over the interval: what a swing is about.
    Mean,
    /// Period of a swing, whatever its place and size.
    Period,
}

/// What must not change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Invariant {
    /// Total energy: largest deviation from the start, over `scale` \[J\] or the start itself.
    Energy {
        /// Replaces the energy at the start \[J\].
        scale: Option<f64>,
    },
    /// Total energy: by how much it rises above the start, over `scale` \[J\] or the start itself. What is lost to
    /// friction, damping and plasticity is no error.
    EnergyRise {
        /// Replaces the energy at the start \[J\].
        scale: Option<f64>,
    },
    /// The last picture is the first one: root of the mean squared difference of colours from 0 to 1.
    Picture,
    /// Momentum: what the impulses do not explain, over the largest gross momentum of the run.
    Momentum,
}

/// What must hold.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Gate {
    /// Name by which a negative control calls it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) name: Option<String>,
    /// Which runs: key and value, as they are varied. Empty: all.
    pub(crate) r#where: Vec<(String, String)>,
    /// Which quantity; the error of the case where none is named.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) quantity: Option<String>,
    /// What is claimed.
    #[serde(flatten)]
    pub(crate) claim: Claim,
    /// Why it must hold.
    pub(crate) reason: String,
    /// Why it is known not to hold, where that is understood: it stays red, and only the exit code passes over it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) explained: Option<String>,
}

/// What a gate claims.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Claim {
    /// The order of convergence lies between these.
    Order([f64; 2]),
    /// The factor by which the error changes per unit of the axis lies between these.
    Decay([f64; 2]),
    /// No error is larger.
    Error(f64),
    /// Every run ends like this.
    Outcome(Class),
}
