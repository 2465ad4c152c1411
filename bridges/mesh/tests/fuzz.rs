//! Random damage to mesh files of every format.

mod common;
#[path = "../../splat/tests/common/damage.rs"]
mod damage;

use std::ops::Range;

use common::{brick, files};
use cosplat_mesh::format::{Beside, read};
use cosplat_mesh::{Prepared, Recipe};

/// Damaged files of one test: some thirteen seconds.
const FILES: u64 = 3_500_000;

#[test]
fn no_damage_makes_a_reader_panic_or_hang() {
    survive(0..FILES);
}

#[test]
fn no_other_damage_makes_a_reader_panic_or_hang() {
    survive(FILES..2 * FILES);
}

fn survive(numbers: Range<u64>) {
    let files = files::all(&brick([0.0; 3], [1.0, 2.0, 3.0]));
    for (ending, bytes) in &files {
        assert!(read(bytes, Some(ending), Beside::Nothing).is_ok(), "{ending}");
    }
    let recipe = Recipe { metres_per_unit: 1.0, up: [0.0, 1.0, 0.0] };
    damage::fuzz(&files, numbers, |ending, bytes| {
        // What can be read is also welded and measured.
        let Ok(prepared) = Prepared::from_bytes(bytes, Some(ending), Beside::Nothing, &recipe) else { return false };
        let n = prepared.mesh.vertices_m.len();
        assert!(prepared.mesh.triangles.iter().flatten().all(|i| (*i as usize) < n));
        true
    });
}
