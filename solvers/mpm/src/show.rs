//! What a body shows to others: its surface particles.

use cosplat_core::boundary::{BoundaryState, SampleStatics, Samples};
use nalgebra::{Matrix3, Vector3};

use crate::model::Shown;
use crate::real::Real;
use crate::sim::Sim;
use crate::store::V;

/// Constants of a body's samples.
pub(crate) fn statics(shown: &Shown, first: u32) -> SampleStatics {
    let n = shown.surface.len();
    SampleStatics {
        id: shown.surface.iter().map(|&(id, _)| u64::from(id - first)).collect(),
        area_m2: vec![shown.area; n],
        volume_m3: vec![shown.volume; n],
        mass_kg: vec![shown.mass; n],
    }
}

impl<R: Real> Sim<R> {
    /// A body's samples now. Normals turn as areas do, with the cofactors of the total deformation gradient.
    pub(crate) fn samples(&self, shown: &Shown) -> BoundaryState {
        let (store, dx) = (&self.store, self.setting.dx);
        let corner: Vec<&crate::store::Block> =
            store.blocks.iter().flat_map(|b| std::iter::repeat_n(b, b.quads as usize)).collect();
        let mut samples = Samples::default();
        for &(id, normal) in &shown.surface {
            let slot = store.slot[id as usize] as usize;
            samples.position.push(store.position(corner[slot / 4], slot, dx));
            samples.velocity.push(store.triple(slot, V));
            samples.normal.push(self.total_gradient(slot).map_or(normal, |f| turned(f, normal)));
        }
        BoundaryState::Samples(samples)
    }

    /// Total deformation gradient of a particle, rows, where it is carried.
    pub(crate) fn total_gradient(&self, slot: usize) -> Option<[f64; 9]> {
        let numbers: &[R] = bytemuck::cast_slice(self.store.grads.get(slot / 4..=slot / 4)?);
        Some(std::array::from_fn(|k| numbers[k * 4 + slot % 4].f64()))
    }
}

fn turned(f: [f64; 9], normal: [f64; 3]) -> [f64; 3] {
    let f = Matrix3::from_row_slice(&f);
    let inverse = f.try_inverse().unwrap_or_else(Matrix3::identity);
    let n = inverse.transpose() * Vector3::from(normal);
    n.try_normalize(0.0).map_or(normal, Into::into)
}
