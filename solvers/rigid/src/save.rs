//! Saving and restoring, bitwise.
//!
//! The state is what is kept here in double precision, and what rapier remembers from one substep to the next: impulses
//! for warm starts, the order of contacts, its tree of bounding boxes. Colliders are not in it: their shapes are the
//! scene's and their places follow from the bodies, which are told anew before every substep.

use cosplat_core::plugin::{Moving, PluginError, StateError, StateHasher, StateReader, StateSink};
use rapier3d::dynamics::{ImpulseJointSet, IslandManager, RigidBodySet};
use rapier3d::geometry::{BroadPhaseBvh, NarrowPhase};
use rapier3d::pipeline::PhysicsWorld;
use rapier3d::prelude::{CCDSolver, PhysicsPipeline};

use crate::V3;
use crate::model::State;

/// What rapier remembers.
type Memory = (IslandManager, BroadPhaseBvh, NarrowPhase, RigidBodySet, ImpulseJointSet);

/// Writes all of it.
pub(crate) fn save(state: &State, world: Option<&PhysicsWorld>, sink: &mut dyn StateSink) {
    Moving::save(&state.bodies, sink);
    let hooks: Vec<[f64; 3]> = state.hooks.iter().map(|&h| h.into()).collect();
    sink.vec3s(&hooks);
    sink.f64(state.dissipated);
    let memory = world
        .map(|w| postcard::to_stdvec(&(&w.islands, &w.broad_phase, &w.narrow_phase, &w.bodies, &w.impulse_joints)));
    // It holds plain numbers and lists, which can always be written.
    let memory = memory.and_then(Result::ok).unwrap_or_default();
    sink.u64(memory.len() as u64);
    sink.bytes(&checksum(&memory).to_le_bytes());
    sink.bytes(&memory);
}

fn checksum(bytes: &[u8]) -> u128 {
    let mut hasher = StateHasher::default();
    hasher.bytes(bytes);
    hasher.finish()
}

/// Reads all of it into `state` and `world`, which stay as they are where it does not fit.
pub(crate) fn restore(state: &mut State, world: Option<&mut PhysicsWorld>, bytes: &[u8]) -> Result<(), PluginError> {
    let mut reader = StateReader::new(bytes);
    let bodies = Moving::restore(state.bodies.len(), &mut reader)?;
    let hooks = reader.vec3s("lever arms", state.hooks.len())?.into_iter().map(V3::from).collect();
    let dissipated = reader.f64()?;
    let length = usize::try_from(reader.u64()?).unwrap_or(usize::MAX);
    let mut sum = [0; 16];
    sum.copy_from_slice(reader.bytes(16)?);
    let memory = reader.bytes(length)?;
    reader.end()?;
    // rapier trusts its own memory; bytes that nobody saved must not reach it.
    let same = checksum(memory) == u128::from_le_bytes(sum);
    let torn = StateError::Count { what: "intact memories of contacts", found: 0, expected: 1 };
    if !same {
        return Err(torn.into());
    }
    if let Some(world) = world {
        let (islands, broad_phase, narrow_phase, bodies, impulse_joints): Memory =
            postcard::from_bytes(memory).map_err(|_| torn)?;
        if bodies.len() != world.bodies.len() {
            let (found, expected) = (bodies.len() as u64, world.bodies.len() as u64);
            return Err(StateError::Count { what: "rapier bodies", found, expected }.into());
        }
        world.islands = islands;
        world.broad_phase = broad_phase;
        world.narrow_phase = narrow_phase;
        world.bodies = bodies;
        world.impulse_joints = impulse_joints;
        world.physics_pipeline = PhysicsPipeline::new();
        world.ccd_solver = CCDSolver::new();
    }
    *state = State { bodies, hooks, dissipated };
    Ok(())
}
