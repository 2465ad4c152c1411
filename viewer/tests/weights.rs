//! Which Gaussians a marked part of a picture is made of.

mod common;

use common::{Set, camera, crowd};
use cosplat_viewer::{Options, Seen, render, weights};

const WIDTH: usize = 70;
const HEIGHT: usize = 50;

/// The left half.
fn left() -> Vec<bool> {
    (0..WIDTH * HEIGHT).map(|i| i % WIDTH < WIDTH / 2).collect()
}

/// White Gaussians on black: the sum of all weights is the sum of one channel of the picture, in the mask as everywhere.
#[test]
fn weights_add_up_to_the_picture() {
    let mut set = crowd(400, 3);
    set.dc.fill([0.5 / 0.282_094_8; 3]);
    let (sets, view, mask) = ([set.view(), set.view()], camera(WIDTH, HEIGHT), left());
    let picture = render(&sets, &view, &Options::default());
    let found = weights(&sets, &view, &Options::default(), &mask).expect("the sizes fit");
    assert_eq!(found.iter().map(Vec::len).collect::<Vec<_>>(), [400, 400]);
    let sum = |of: &dyn Fn(&Seen) -> f64| found.iter().flatten().map(of).sum::<f64>();
    let seen = |only: bool| -> f64 {
        picture.rgba.iter().zip(&mask).filter(|(_, m)| **m || !only).map(|(p, _)| f64::from(p[0])).sum()
    };
    // Sums of thousands of numbers of single precision.
    assert!((sum(&|s| s.all) / seen(false) - 1.0).abs() < 1e-5, "{} {}", sum(&|s| s.all), seen(false));
    assert!((sum(&|s| s.masked) / seen(true) - 1.0).abs() < 1e-5);
    assert!(found.iter().flatten().all(|s| s.masked <= s.all));
}

/// One on each side, one behind the first, one on the border of the mask, one outside the picture: the truth is known.
#[test]
fn what_is_in_the_mask_has_its_weight_there() {
    let mut set = Set::default();
    for (place, sigma) in [
        ([-0.4, 0.0, 2.0], 0.02),
        ([0.4, 0.0, 2.0], 0.02),
        ([-0.8, 0.0, 4.0], 0.02),
        ([0.0, 0.0, 2.0], 0.02),
        ([50.0, 0.0, 2.0], 0.02),
    ] {
        set.push(place, [sigma; 3], 0.98, [1.0; 3]);
    }
    let found =
        weights(&[set.view()], &camera(WIDTH, HEIGHT), &Options::default(), &left()).expect("they fit").remove(0);
    let share = |i: usize| found[i].masked / found[i].all;
    assert!((share(0) - 1.0).abs() < 1e-9 && share(1).abs() < 1e-9, "{found:?}");
    // Variances of 1 and ¼ pixels² with the dilation of 0.3: alone 2π o a, behind the first 2π o (b − o a b / (a + b)).
    // The first one stands 0.2 beside the axis, which makes its picture longer by 2 %; sums over pixels, not integrals.
    let (a, b, o) = (1.3, 0.55, 0.98);
    let around = |value: f64, wanted: f64| (value / (std::f64::consts::TAU * o * wanted) - 1.0).abs() < 0.03;
    assert!(around(found[0].all, a) && around(found[2].all, b - o * a * b / (a + b)), "{found:?}");
    // It stands on the border: half of it is on either side, but for the rounding of its kernel.
    assert!((share(3) - 0.5).abs() < 1e-5, "{}", share(3));
    assert_eq!(found[4], Seen::default());
    assert!(weights(&[set.view()], &camera(WIDTH, HEIGHT), &Options::default(), &[true; 5]).is_err());
}

#[test]
fn weights_have_the_same_bits_on_any_number_of_threads() {
    let set = crowd(300, 9);
    let of = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let found = || weights(&[set.view()], &camera(WIDTH, HEIGHT), &Options::default(), &left());
        pool.install(found).expect("the sizes fit")
    };
    let first = of(1);
    assert!([2, 3, 7].into_iter().all(|threads| of(threads) == first));
}
