//! Where a surface ends.

use std::collections::{BTreeMap, BTreeSet};

use crate::own::Mesh;

/// Sides and corners of each triangle that lie on a rim: bit `k` for the side opposite the corner `k`, bit `3 + k` for
/// the corner.
pub(crate) fn of(triangles: &[[u32; 3]]) -> Vec<u8> {
    let sides = |&[a, b, c]: &[u32; 3]| [[b, c], [c, a], [a, b]].map(|[i, j]| [i.min(j), i.max(j)]);
    let mut beside: BTreeMap<[u32; 2], u32> = BTreeMap::new();
    triangles.iter().flat_map(sides).for_each(|side| *beside.entry(side).or_default() += 1);
    let open = |side: &[u32; 2]| beside.get(side) == Some(&1);
    let corners: BTreeSet<u32> = beside.keys().filter(|side| open(side)).flatten().copied().collect();
    let bits = |t: &[u32; 3]| {
        let (sides, at) = (sides(t).map(|side| open(&side)), t.map(|i| corners.contains(&i)));
        sides.into_iter().chain(at).zip(0..).map(|(on, k)| u8::from(on) << k).sum()
    };
    triangles.iter().map(bits).collect()
}

impl Mesh {
    /// Whether the point of a triangle with these shares lies on a rim.
    pub(crate) fn is_rim(&self, triangle: usize, share: [f64; 3]) -> bool {
        let zero = share.map(|s| s == 0.0);
        let bit = match (zero, zero.iter().filter(|z| **z).count()) {
            ([true, ..], 1) => 0,
            ([_, true, _], 1) => 1,
            (_, 1) => 2,
            ([false, ..], 2) => 3,
            ([_, false, _], 2) => 4,
            (_, 2) => 5,
            _ => return false,
        };
        self.rim.get(triangle).is_some_and(|bits| bits >> bit & 1 == 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_has_a_rim_but_not_along_its_diagonal() {
        let triangles = vec![[0, 1, 2], [0, 2, 3]];
        let mesh = Mesh { rim: of(&triangles), triangles, ..Mesh::default() };
        assert!(mesh.is_rim(0, [0.5, 0.5, 0.0]) && mesh.is_rim(0, [0.0, 0.5, 0.5]) && mesh.is_rim(0, [1.0, 0.0, 0.0]));
        assert!(!mesh.is_rim(0, [0.5, 0.0, 0.5]) && !mesh.is_rim(0, [0.2, 0.3, 0.5]));
        assert!(mesh.is_rim(1, [0.0, 0.5, 0.5]) && !mesh.is_rim(1, [0.5, 0.5, 0.0]));
    }
}
