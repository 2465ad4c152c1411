//! Static colliders, and which of them each block of particles can reach.

use crate::law::Law;
use crate::real::Real;
use crate::store::Block;
use cosplat_core::distance::Placed;

/// What a surface does to what touches it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Surface {
    /// Holds on in every direction.
    Stick,
    /// Static and kinetic friction; may separate.
    Coulomb(f64, f64),
}

/// A static collider.
#[derive(Clone, Debug)]
pub(crate) struct Wall {
    /// Shape.
    pub(crate) shape: Placed,
    /// Surface for each body; `None` where the pair is left out.
    pub(crate) surface: Vec<Option<Surface>>,
}

/// All static colliders.
#[derive(Clone, Debug, Default)]
pub(crate) struct Walls {
    /// Colliders.
    pub(crate) list: Vec<Wall>,
    /// Colliders that some particle of a block could touch, by block.
    pub(crate) near: Vec<Vec<u32>>,
}

/// Middle of a block of cells \[m\].
pub(crate) fn middle(block: &Block, dx: f64) -> [f64; 3] {
    block.at.map(|a| (4.0 * f64::from(a) + 2.5) * dx)
}

/// Radius of a ball that holds all particles of a block, strayed ones too, in cells: half the diagonal of 6³ cells.
pub(crate) const BLOCK_RADIUS: f64 = 5.2;

impl Walls {
    /// Colliders without a grid.
    pub(crate) fn new(list: Vec<Wall>) -> Self {
        Self { list, near: Vec::new() }
    }

    /// Looks for the colliders near each block of a solid; what flows meets them at nodes (`shores`).
    pub(crate) fn prepare<R: Real>(&mut self, blocks: &[Block], laws: &[Law<R>], dx: f64) {
        let list = &self.list;
        let near = |block: &Block| {
            if laws[block.body as usize].flows() {
                return Vec::new();
            }
            let reach = |wall: &Wall| wall.shape.at_least(middle(block, dx), BLOCK_RADIUS * dx) < dx;
            let body = block.body as usize;
            let touching = |(_, wall): &(usize, &Wall)| wall.surface[body].is_some() && reach(wall);
            list.iter().enumerate().filter(touching).map(|(i, _)| i as u32).collect()
        };
        self.near = blocks.iter().map(near).collect();
    }
}
