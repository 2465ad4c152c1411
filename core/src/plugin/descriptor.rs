//! What a plugin says about itself before it joins anything.

use serde::{Deserialize, Serialize};

use crate::plan::BoundaryForm;
use crate::scene::ProbeQuantity;

/// Answer to `--describe`: JSON on standard output.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Descriptor {
    /// Name of the plugin, `[a-z0-9-]+`.
    pub name: String,
    /// Version of the plugin.
    pub version: String,
    /// One line for people.
    pub summary: String,
    /// Lowest and highest protocol version it speaks.
    pub protocol: [u16; 2],
    /// Body sources it takes: `points`, `box`, `mesh`, `splat` …
    pub body_kinds: Vec<BodyKind>,
    /// Materials it takes, by the name of their kind.
    pub materials: Vec<String>,
    /// Parts it can play at an interface.
    pub roles: Vec<InterfaceRole>,
    /// Form in which it shows its bodies.
    pub boundary: BoundaryForm,
    /// Scene features it takes beside bodies: `joints`, `links`, `statics`, `prescribed`, `slab`, and actions by kind.
    pub features: Vec<String>,
    /// Probes it can answer beside those made from body states.
    pub probes: Vec<ProbeQuantity>,
    /// How it can save its state.
    pub saves: Saves,
    /// JSON Schema of its `params`.
    pub params_schema: serde_json::Value,
}

/// A source of bodies, by the key used in scenes.
pub type BodyKind = String;

/// A part a plugin can play at an interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum InterfaceRole {
    /// Computes contact with partners that show samples.
    ResolveSamples,
    /// Computes contact with rigid partners.
    ResolveProxy,
    /// Takes impulses on its bodies.
    Respond,
    /// Computes link forces with the partner's position held.
    Link,
}

/// How a plugin can save its state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Saves {
    /// To bytes, complete.
    pub bytes: bool,
    /// Restored bitwise, with bitwise equal results after.
    pub deterministic: bool,
}

impl Descriptor {
    /// Whether it lists that feature.
    pub fn has_feature(&self, feature: &str) -> bool {
        self.features.iter().any(|f| f == feature)
    }
}
