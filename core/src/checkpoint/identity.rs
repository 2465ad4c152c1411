//! What a run computes, as one number: who resumes must compute the same.

use xxhash_rust::xxh3::Xxh3;

use crate::control::AssetInfo;
use crate::plan::Plan;
use crate::plugin::SolverScene;

/// Identity of a whole run: its plan and every part of its scene, with the geometry that belongs to each. Threads are
/// no part of it, in neither: a run may be taken up on another machine.
pub(crate) fn identity_of<'p>(plan: &Plan, parts: impl Iterator<Item = (&'p SolverScene, &'p [AssetInfo])>) -> u128 {
    let mut hasher = begun(plan);
    parts.for_each(|(scene, assets)| add(&mut hasher, scene, assets));
    hasher.digest128()
}

/// Identity of what one participant computes.
pub(crate) fn identity_of_part(plan: &Plan, scene: &SolverScene, assets: &[AssetInfo]) -> u128 {
    identity_of(plan, std::iter::once((scene, assets)))
}

/// The plan without what results do not depend on: threads, and words for people.
fn begun(plan: &Plan) -> Xxh3 {
    let mut plan = Plan { left_out: Vec::new(), window_bound_by: String::new(), ..plan.clone() };
    plan.participants.iter_mut().for_each(|p| p.threads = 0);
    let mut hasher = Xxh3::new();
    // Plans and scenes are plain data and always have a JSON form.
    hasher.update(serde_json::to_string(&plan).unwrap_or_default().as_bytes());
    hasher
}

fn add(hasher: &mut Xxh3, scene: &SolverScene, assets: &[AssetInfo]) {
    let scene = SolverScene { assets: std::collections::BTreeMap::new(), threads: 0, ..scene.clone() };
    hasher.update(serde_json::to_string(&scene).unwrap_or_default().as_bytes());
    for asset in assets {
        hasher.update(asset.name.as_bytes());
        hasher.update(&asset.bytes.to_le_bytes());
        hasher.update(&asset.hash.to_le_bytes());
    }
}
