//! Rotation of colours band by band.

mod common;

use common::Random;
use cosplat_splat::sh::{ShRotation, basis};
use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};
use proptest::prelude::*;

fn some_rotation(r: &mut Random) -> Matrix3<f64> {
    Rotation3::from_euler_angles(r.between(-3.0, 3.0), r.between(-1.5, 1.5), r.between(-3.0, 3.0)).into_inner()
}

/// The table of rotated coefficients that came with the problem, made by another program.
#[test]
fn rotated_harmonics_are_those_of_the_table() {
    let table = include_str!("data/D20_sh_rotation.csv");
    let rows: Vec<Vec<f64>> =
        table.lines().skip(1).map(|l| l.split(',').map(|v| v.parse().unwrap()).collect()).collect();
    for case in rows.chunks(16) {
        let q = Quaternion::new(case[0][1], case[0][2], case[0][3], case[0][4]);
        let turn = UnitQuaternion::from_quaternion(q).to_rotation_matrix().into_inner();
        let before: [f64; 15] = std::array::from_fn(|j| case[j + 1][6]);
        let after = ShRotation::new(&turn, 3).apply_wide(&before);
        for (j, v) in after.iter().enumerate() {
            assert!((v - case[j + 1][7]).abs() < 2e-10, "case {} coefficient {}: {v}", case[0][0], j + 1);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(256) })]

    #[test]
    fn rotated_harmonics_are_the_function_turned(seed in any::<u64>()) {
        let mut r = Random::new(seed);
        let turn = some_rotation(&mut r);
        let c: [f64; 15] = std::array::from_fn(|_| r.between(-1.0, 1.0));
        let rotated = ShRotation::new(&turn, 3).apply_wide(&c);
        let d = some_rotation(&mut r) * Vector3::x();
        let value = |c: &[f64; 15], d: Vector3<f64>| basis(d.into()).iter().zip(c).map(|(y, c)| y * c).sum::<f64>();
        prop_assert!((value(&rotated, d) - value(&c, turn.transpose() * d)).abs() < 1e-13);
        for band in [0..3, 3..8, 8..15] {
            let norm = |c: &[f64; 15]| c[band.clone()].iter().map(|v| v * v).sum::<f64>().sqrt();
            prop_assert!((norm(&rotated) - norm(&c)).abs() < 1e-14 * 4.0);
        }
    }
}
