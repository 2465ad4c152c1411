//! Where a rigid partner reaches into a static solid, a place counts once, as the partner's.
//!
//! In a corner between a partner and a wall the boundary particles beyond both press along the partner's normal as well: by
//! sums over all pairs a quarter of the mean distance of pairs, so `d/4`, of the partner's face along such an edge. Whose
//! they are bears that load: a piston that ends at the walls of its tank leaves an eighth of eight particles' width to them.

use cosplat_core::boundary::{Vec3, add, norm, scale, sub};

use crate::grid::Grid;
use crate::kernel::Kernel;
use crate::model::Model;
use crate::wall::Piece;

/// Share of a cell from which on a partner that takes it reaches into a solid: it does not just touch it.
const ENTERED: f64 = 0.5;

/// What must be left of a cell for it to count.
const LEFT: f64 = 0.05;

/// Boundary particles of rigid partners where lists are made.
struct Rigid {
    kernel: Kernel,
    grid: Grid,
    x: Vec<Vec3>,
    volume: Vec<f64>,
    /// What a lattice fills of the kernel half a spacing above its surface.
    half: f64,
}

impl Rigid {
    fn new(model: &Model, all: &[(Vec3, f64)]) -> Self {
        let x: Vec<Vec3> = all.iter().map(|p| p.0).collect();
        let (grid, order) = Grid::new(&x, model.kernel.reach);
        let sorted = || order.iter().map(|&i| all[i as usize]);
        let half = model.kernel.half_space(model.spacing);
        let kernel = model.kernel.scaled();
        Self { kernel, grid, x: sorted().map(|p| p.0).collect(), volume: sorted().map(|p| p.1).collect(), half }
    }

    /// Share of a cell with its middle at `x` \[m\] that they take: all of one half a spacing below a surface, nothing of one
    /// as far above it; and the partner's normal there.
    fn share(&self, x: Vec3) -> (f64, Vec3) {
        let (mut filled, mut away) = (0.0, [0.0; 3]);
        self.grid.near(&self.x, x, self.kernel.reach, |b| {
            let apart = sub(x, self.x[b]);
            let r = norm(apart);
            filled += self.volume[b] * self.kernel.weight(r);
            away = sub(away, scale(apart, self.volume[b] * self.kernel.slope(r)));
        });
        let normal = scale(away, 1.0 / norm(away).max(f64::MIN_POSITIVE));
        (((filled - self.half) / (1.0 - 2.0 * self.half)).clamp(0.0, 1.0), normal)
    }
}

/// Takes from boundary particles of static solids what lies inside rigid partners, whose boundary particles are `rigid`: the
/// body that they meet, their places \[m\] and their volumes \[m³\]. Whether a partner reaches into the solid of each face.
pub(crate) fn once(model: &Model, rigid: &[(usize, Vec3, f64)], pieces: &mut Vec<Piece>) -> Vec<bool> {
    let mut entered = vec![false; model.faces.len()];
    for body in 0..model.liquids.len() {
        let own: Vec<(Vec3, f64)> = rigid.iter().filter(|p| p.0 == body).map(|p| (p.1, p.2)).collect();
        if own.is_empty() {
            continue;
        }
        let rigid = Rigid::new(model, &own);
        pieces.retain_mut(|piece| {
            let face = &model.faces[piece.face as usize];
            if face.body != body || face.interface.is_some() {
                return true;
            }
            let (share, normal) = rigid.share(piece.x);
            // What is left of its cell has its middle farther from the partner.
            piece.x = add(piece.x, scale(normal, 0.5 * share * model.spacing));
            piece.volume *= 1.0 - share;
            entered[piece.face as usize] |= share >= ENTERED;
            share <= 1.0 - LEFT
        });
    }
    entered
}
