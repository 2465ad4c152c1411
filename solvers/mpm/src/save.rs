//! Everything a step depends on, as bytes, and back.

use bytemuck::Pod;
use cosplat_core::plugin::{StateError, StateReader, StateSink};

use crate::real::Real;
use crate::store::{Block, DEAD, Store};

impl<R: Real> Store<R> {
    /// Writes blocks and particles as they lie in memory.
    pub(crate) fn save(&self, sink: &mut dyn StateSink) {
        sink.u64(self.blocks.len() as u64);
        for block in &self.blocks {
            let [x, y, z] = block.at.map(i32::cast_unsigned);
            sink.bytes(bytemuck::cast_slice(&[x, y, z, block.part, block.live]));
        }
        sink.bytes(bytemuck::cast_slice(&self.ids));
        sink.bytes(bytemuck::cast_slice(&self.quads));
        sink.bytes(bytemuck::cast_slice(&self.grads));
    }

    /// Reads what `save` wrote for a store of so many particles, whose parts belong to these bodies.
    pub(crate) fn load(&self, reader: &mut StateReader, owners: &[u32]) -> Result<Self, StateError> {
        let count = reader.u64()?;
        if count > self.len() as u64 {
            return Err(StateError::Count { what: "blocks", found: count, expected: self.len() as u64 });
        }
        let (mut blocks, mut quads, mut live) = (Vec::with_capacity(count as usize), 0_u32, 0_u64);
        for _ in 0..count {
            let [x, y, z, part, here] = columns::<[u32; 5]>(reader, 1)?[0];
            live += u64::from(here);
            let Some(&body) = owners.get(part as usize).filter(|_| live <= self.len() as u64) else {
                return Err(StateError::Count { what: "particles", found: live, expected: self.len() as u64 });
            };
            let (at, lanes) = ([x, y, z].map(u32::cast_signed), here.div_ceil(4));
            let block = Block { at, body, part, first: quads, quads: lanes, live: here };
            quads += block.quads;
            blocks.push(block);
        }
        if live != self.len() as u64 {
            return Err(StateError::Count { what: "particles", found: live, expected: self.len() as u64 });
        }
        let ids: Vec<[u32; 4]> = columns(reader, quads as usize)?;
        let mut slot = vec![DEAD; self.len()];
        for (at, &id) in ids.as_flattened().iter().enumerate().filter(|(_, id)| **id != DEAD) {
            let Some(slot) = slot.get_mut(id as usize) else {
                return Err(StateError::Count { what: "identity", found: u64::from(id), expected: self.len() as u64 });
            };
            *slot = at as u32;
        }
        if slot.contains(&DEAD) {
            return Err(StateError::Count { what: "identities", found: 0, expected: self.len() as u64 });
        }
        let numbers = columns(reader, quads as usize)?;
        let grads = if self.grads.is_empty() { Vec::new() } else { columns(reader, quads as usize)? };
        Ok(Self { blocks, quads: numbers, ids, grads, slot })
    }
}

fn columns<T: Pod>(reader: &mut StateReader, count: usize) -> Result<Vec<T>, StateError> {
    Ok(bytemuck::pod_collect_to_vec(reader.bytes(count * size_of::<T>())?))
}
