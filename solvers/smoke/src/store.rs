//! What changes in a run.

use cosplat_core::boundary::Vec3;
use cosplat_core::plugin::{StateError, StateReader, StateSink};

use crate::grid::{Faces, Grid};

/// The state.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Store {
    /// Velocity on faces \[m/s\].
    pub(crate) u: Faces,
    /// Share of each cell that is smoke.
    pub(crate) c: Vec<f64>,
    /// Pressure over density with which the next projection begins, on the solver's finest level \[m²/s²\].
    pub(crate) pressure: Vec<f64>,
    /// Particles \[m\].
    pub(crate) x: Vec<Vec3>,
}

impl Store {
    /// Air at rest.
    pub(crate) fn new(grid: &Grid, pressures: usize, x: Vec<Vec3>) -> Self {
        Self { u: grid.faces(), c: grid.field(), pressure: vec![0.0; pressures], x }
    }

    fn fields(&self) -> [&Vec<f64>; 5] {
        [&self.u[0], &self.u[1], &self.u[2], &self.c, &self.pressure]
    }

    /// Writes everything.
    pub(crate) fn save(&self, sink: &mut dyn StateSink) {
        for field in self.fields() {
            sink.u64(field.len() as u64);
            sink.bytes(bytemuck::cast_slice(field));
        }
        sink.vec3s(&self.x);
    }

    /// Reads what `save` wrote, for a grid and particles as there are now.
    pub(crate) fn load(&self, reader: &mut StateReader<'_>) -> Result<Self, StateError> {
        let mut loaded = Self::default();
        let Self { u: [u, v, w], c, pressure, .. } = &mut loaded;
        for (to, of) in [u, v, w, c, pressure].into_iter().zip(self.fields()) {
            let found = reader.u64()?;
            if found != of.len() as u64 {
                return Err(StateError::Count { what: "values on the grid", found, expected: of.len() as u64 });
            }
            *to = reader.bytes(8 * of.len())?.chunks_exact(8).map(bytemuck::pod_read_unaligned).collect();
        }
        loaded.x = reader.vec3s("particles", self.x.len())?;
        Ok(loaded)
    }
}
