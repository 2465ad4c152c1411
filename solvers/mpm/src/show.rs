//! What others see of a body: its surface particles for partners, all of them for pictures.

use std::ops::Range;

use cosplat_core::boundary::{BoundaryState, SampleStatics, Samples};
use cosplat_core::visual::VisualState;
use nalgebra::{Matrix3, Vector3};

use crate::model::Shown;
use crate::real::Real;
use crate::sim::Sim;
use crate::store::{Block, V};

/// Constants of a body's samples, which resist with those masses \[kg\].
pub(crate) fn statics(shown: &Shown, first: u32, mass_kg: Vec<f64>) -> SampleStatics {
    let marks = || shown.surface.iter();
    SampleStatics {
        id: marks().map(|m| u64::from(m.id - first)).collect(),
        area_m2: marks().map(|m| m.area).collect(),
        volume_m3: marks().map(|m| m.volume).collect(),
        mass_kg,
    }
}

impl<R: Real> Sim<R> {
    /// A body's samples now. Normals turn as areas do, with the cofactors of the total deformation gradient.
    pub(crate) fn samples(&self, shown: &Shown) -> BoundaryState {
        let (store, dx, home) = (&self.store, self.setting.dx, self.homes());
        let mut samples = Samples::default();
        for mark in &shown.surface {
            let slot = store.slot[mark.id as usize] as usize;
            samples.position.push(store.position(home[slot / 4], slot, dx));
            samples.velocity.push(store.triple(slot, V));
            samples.normal.push(self.total_gradient(slot).map_or(mark.normal, |f| turned(f, mark.normal)));
        }
        BoundaryState::Samples(samples)
    }

    /// Particles with those identities, in that order, with their total deformation gradients where they are asked for.
    pub(crate) fn visual(&self, ids: Range<u64>, gradients: bool) -> VisualState {
        let (store, dx, home) = (&self.store, self.setting.dx, self.homes());
        let slots = || ids.clone().map(|id| store.slot[id as usize] as usize);
        let identity = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        let gradient = slots().map(|slot| self.total_gradient(slot).unwrap_or(identity).map(|f| f as f32));
        VisualState::Particles {
            position: slots().map(|slot| store.position(home[slot / 4], slot, dx)).collect(),
            gradient: if gradients { gradient.collect() } else { Vec::new() },
        }
    }

    /// Block of each quad.
    fn homes(&self) -> Vec<&Block> {
        self.store.blocks.iter().flat_map(|b| std::iter::repeat_n(b, b.quads as usize)).collect()
    }

    /// Total deformation gradient of a particle, rows, where it is carried.
    fn total_gradient(&self, slot: usize) -> Option<[f64; 9]> {
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
