//! What a plugin says about itself before it joins anything.

use serde::{Deserialize, Serialize};

use crate::control::PROTOCOL;
use crate::plan::BoundaryForm;
use crate::scene::ProbeQuantity;
use crate::visual::VisualForm;

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
    /// Form in which it shows them for pictures and files, if it does.
    #[serde(default)]
    pub visual: Option<VisualForm>,
    /// Scene features it takes beside bodies: `joints`, `links`, `statics`, `prescribed`, `slab`, and actions by kind.
    /// With `sudden-impulses` samples take the impulses that it resolves at once, at the start of a window.
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
    /// A plugin that can do nothing yet: to be completed with `..Descriptor::new(…)`.
    ///
    /// It speaks the present protocol, shows samples in double precision without normals, saves its state completely and
    /// takes no parameters.
    pub fn new(name: &str, version: &str, summary: &str) -> Self {
        Self {
            name: name.to_owned(),
            version: version.to_owned(),
            summary: summary.to_owned(),
            protocol: [PROTOCOL; 2],
            body_kinds: Vec::new(),
            materials: Vec::new(),
            roles: Vec::new(),
            boundary: BoundaryForm::SamplesF64 { normals: false },
            visual: None,
            features: Vec::new(),
            probes: Vec::new(),
            saves: Saves { bytes: true, deterministic: true },
            params_schema: serde_json::json!({ "type": "object", "properties": {}, "additionalProperties": false }),
        }
    }

    /// Whether it lists that feature.
    pub fn has_feature(&self, feature: &str) -> bool {
        self.features.iter().any(|f| f == feature)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_new_descriptor_lists_nothing_and_takes_no_parameter() {
        let plain = Descriptor::new("mine", "1.2.3", "does nothing");
        assert_eq!((&plain.name[..], plain.protocol), ("mine", [PROTOCOL; 2]));
        assert!(plain.body_kinds.is_empty() && plain.roles.is_empty() && !plain.has_feature("statics"));
        assert_eq!(plain.params_schema["additionalProperties"], false);
        let able = Descriptor { features: vec!["statics".into()], ..plain };
        assert!(able.has_feature("statics") && !able.has_feature("links"));
    }
}
