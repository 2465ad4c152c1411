//! Decisions about what a run leaves behind.

use cosplat_core::scene::{Material, Scene, Source};

use super::{Decision, decision};
use crate::folder::summary::Summary;

/// Name of the decision with pictures alone.
const PICTURES: &str = "pictures";

/// What a study does without, one thing at a time. Nothing of it may change what is computed.
pub(super) fn decisions(scene: &Scene, summary: &Summary) -> Vec<Decision> {
    let mut found = vec![decision("trace", "with `trace.json`", &[("output.trace", "true")], true)];
    if !scene.output.draws() {
        return found;
    }
    let on = |keys: &[&'static str]| keys.iter().map(|key| (format!("output.{key}"), "true".to_owned())).collect();
    let with = |name: &str, instead: &str, keys: &[&'static str]| Decision {
        set: on(keys),
        ..decision(name, instead, &[], true)
    };
    found.push(with("frames", "frames are drawn, written and recorded", &["pictures", "splats", "recording"]));
    found.push(with(PICTURES, "frames are drawn", &["pictures"]));
    let video = with("video", "frames are drawn and made into a film", &["pictures", "video"]);
    found.push(Decision { beside: Some(PICTURES), ..video });
    if scene.bodies.iter().any(|body| matches!(body.source, Source::Splat { .. })) {
        let mut still = with("colours", "colours do not turn with what is drawn", &["pictures"]);
        still.set.push(("output.turn_colours".into(), "false".into()));
        found.push(Decision { beside: Some(PICTURES), ..still });
    }
    let is_liquid = |material: &Material| matches!(material, Material::SphLiquid { .. } | Material::MpmLiquid { .. });
    if scene.bodies.iter().any(|body| is_liquid(&body.material)) && summary.frames.is_some() {
        let set = [("output.surfaces", "\"obj\"")];
        found.push(decision("surfaces", "surfaces of liquids are meshed", &set, true));
    }
    found
}
