//! Points in cells of a lattice, for what is within a radius.

use nalgebra::Vector3;

/// A cell of the lattice.
pub(crate) type Key = [i64; 3];

/// Points by cell.
pub(crate) struct Cells {
    size: f64,
    /// Cell and point, sorted.
    entries: Vec<(Key, u32)>,
}

impl Cells {
    /// Cells of that size, which is the largest radius that may be asked for.
    pub(crate) fn new(points: &[Vector3<f64>], size: f64) -> Cells {
        let mut entries: Vec<(Key, u32)> = points.iter().enumerate().map(|(i, p)| (key(p, size), i as u32)).collect();
        entries.sort_unstable();
        Cells { size, entries }
    }

    /// Visits every point of the 27 cells around `p`, in one order.
    pub(crate) fn around(&self, p: &Vector3<f64>, mut visit: impl FnMut(u32)) {
        let [x, y, z] = key(p, self.size);
        for dx in -1..=1 {
            for dy in -1..=1 {
                // Three cells along z follow each other.
                let from = self.entries.partition_point(|e| e.0 < [x + dx, y + dy, z - 1]);
                let row = self.entries[from..].iter().take_while(|e| e.0 <= [x + dx, y + dy, z + 1]);
                row.for_each(|e| visit(e.1));
            }
        }
    }
}

/// The cell of a point.
pub(crate) fn key(p: &Vector3<f64>, size: f64) -> Key {
    // Conversion to integers saturates; half of the range leaves room for the neighbours.
    [0, 1, 2].map(|k| ((p[k] / size).floor() as i64).clamp(i64::MIN / 2, i64::MAX / 2))
}
