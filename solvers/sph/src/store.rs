//! Particles: one array per quantity, physically sorted by cell.

use cosplat_core::boundary::{Vec3, dot, sub};
use cosplat_core::plugin::{StateError, StateReader, StateSink};

use crate::force::largest;
use crate::grid::Grid;
use crate::rub::Rubbed;

/// All that changes about the particles.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Store {
    /// Identity: place in the order in which the bodies were sampled.
    pub(crate) id: Vec<u32>,
    /// Positions \[m\].
    pub(crate) x: Vec<Vec3>,
    /// Velocities \[m/s\].
    pub(crate) v: Vec<Vec3>,
    /// Densities \[kg/m³\]; negative for those put aside, 0 for those that wait to enter or have left (`gates`).
    pub(crate) rho: Vec<f64>,
    /// Pressures with which an incompressible liquid's next solutions begin: \[Pa\]; empty for others.
    pub(crate) warm: Vec<f64>,
    /// Largest acceleration in the last substep \[m/s²\].
    pub(crate) acceleration: f64,
    /// Energy lost to viscosity since t = 0 \[J\].
    pub(crate) dissipated: f64,
    /// Layers that have entered through each inflow.
    pub(crate) entered: Vec<u64>,
    /// Where everything was when lists were last made.
    pub(crate) listed: Listed,
    /// Friction with samples in the last window.
    pub(crate) rubbed: Vec<Rubbed>,
}

/// Where everything was when lists were last made: they can be made again from it, and outlive a step of the coupling and a
/// saved state without a change of a single bit.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Listed {
    /// Places of the particles \[m\], in their present order; empty before there are lists.
    pub(crate) x: Vec<Vec3>,
    /// How many of them, the first, were not put aside (`aside`): the others are in no list.
    pub(crate) part: u64,
    /// Places of the boundary particles of partners \[m\], face by face.
    pub(crate) partners: Vec<Vec3>,
    /// How much farther than the kernel the lists reach \[m\].
    pub(crate) skin: f64,
}

impl Listed {
    /// Places of those that are listed \[m\].
    pub(crate) fn those(&self) -> &[Vec3] {
        &self.x[..self.part as usize]
    }
}

impl Store {
    /// Number of particles.
    pub(crate) fn len(&self) -> usize {
        self.id.len()
    }

    /// Whether the lists hold all that is in the kernel's reach now, with boundary particles of partners at `places` \[m\]:
    /// no two have come closer by more than the skin.
    pub(crate) fn hold(&self, places: &[Vec3]) -> bool {
        let then = &self.listed;
        if then.x.is_empty() || then.x.len() != self.len() || then.partners.len() != places.len() {
            return false;
        }
        let way = |(a, b): (&Vec3, &Vec3)| {
            let apart = sub(*a, *b);
            dot(apart, apart)
        };
        let (mut first, mut second) = (0.0, 0.0);
        let part = self.x.iter().zip(&then.x).zip(&self.rho).filter(|(_, rho)| **rho > 0.0);
        for way in part.map(|(both, _)| way(both)) {
            if way > first {
                (first, second) = (way, first);
            } else if way > second {
                second = way;
            }
        }
        let partner = places.iter().zip(&then.partners).map(way).fold(0.0, largest);
        first.sqrt() + largest(second, partner).sqrt() <= then.skin
    }

    /// Sorts the particles by the cells of a grid for a search up to `reach` \[m\], those put aside behind the others.
    pub(crate) fn sort(&mut self, reach: f64) {
        let (part, aside): (Vec<u32>, Vec<u32>) = (0..self.len() as u32).partition(|&i| self.rho[i as usize] > 0.0);
        let x: Vec<Vec3> = part.iter().map(|&i| self.x[i as usize]).collect();
        let (_, order) = Grid::new(&x, reach);
        let order: Vec<u32> = order.iter().map(|&k| part[k as usize]).chain(aside).collect();
        take(&mut self.id, &order);
        take(&mut self.x, &order);
        take(&mut self.v, &order);
        take(&mut self.rho, &order);
        if !self.warm.is_empty() {
            take(&mut self.warm, &order);
        }
    }

    /// Writes everything.
    pub(crate) fn save(&self, sink: &mut dyn StateSink) {
        sink.u64(self.len() as u64);
        sink.bytes(bytemuck::cast_slice(&self.id));
        sink.vec3s(&self.x);
        sink.vec3s(&self.v);
        sink.bytes(bytemuck::cast_slice(&self.rho));
        sink.f64(self.acceleration);
        sink.f64(self.dissipated);
        sink.bytes(bytemuck::cast_slice(&self.entered));
        sink.u64(self.rubbed.len() as u64);
        sink.bytes(bytemuck::cast_slice(&self.rubbed));
        sink.vec3s(&self.listed.x);
        sink.u64(self.listed.part);
        sink.vec3s(&self.listed.partners);
        sink.f64(self.listed.skin);
        sink.bytes(bytemuck::cast_slice(&self.warm));
    }

    /// Reads what `save` wrote, for as many particles as there are now.
    pub(crate) fn load(&self, reader: &mut StateReader<'_>) -> Result<Self, StateError> {
        let n = self.len();
        let count = |found: u64, what| StateError::Count { what, found, expected: n as u64 };
        let found = reader.u64()?;
        if found != n as u64 {
            return Err(count(found, "particles"));
        }
        let id: Vec<u32> = reader.bytes(4 * n)?.chunks_exact(4).map(bytemuck::pod_read_unaligned).collect();
        let mut seen = vec![false; n];
        for &i in &id {
            // Each identity once, or the masses would not fit the particles.
            match seen.get_mut(i as usize) {
                Some(seen) if !*seen => *seen = true,
                _ => return Err(count(u64::from(i), "identity of a particle")),
            }
        }
        let (x, v) = (reader.vec3s("positions", n)?, reader.vec3s("velocities", n)?);
        let rho = reader.bytes(8 * n)?.chunks_exact(8).map(bytemuck::pod_read_unaligned).collect();
        let (acceleration, dissipated) = (reader.f64()?, reader.f64()?);
        let bytes = reader.bytes(8 * self.entered.len())?;
        let entered = bytes.chunks_exact(8).map(bytemuck::pod_read_unaligned).collect();
        let (rubbed, x_listed) = (many(reader)?, many(reader)?);
        let part = reader.u64()?;
        let listed = Listed { x: x_listed, part, partners: many(reader)?, skin: reader.f64()? };
        let bytes = reader.bytes(8 * self.warm.len())?;
        let warm = bytes.chunks_exact(8).map(bytemuck::pod_read_unaligned).collect();
        if !(listed.x.is_empty() || listed.x.len() == n) || listed.part > listed.x.len() as u64 {
            return Err(count(part, "places of lists"));
        }
        Ok(Self { id, x, v, rho, warm, acceleration, dissipated, entered, listed, rubbed })
    }
}

/// A list as long as the state says.
fn many<T: bytemuck::AnyBitPattern>(reader: &mut StateReader<'_>) -> Result<Vec<T>, StateError> {
    let length = usize::try_from(reader.u64()?).unwrap_or(usize::MAX);
    let bytes = reader.bytes(length.saturating_mul(size_of::<T>()))?;
    Ok(bytes.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned).collect())
}

fn take<T: Copy>(all: &mut Vec<T>, order: &[u32]) {
    *all = order.iter().map(|&i| all[i as usize]).collect();
}
