//! Structural similarity of two pictures (Wang, Bovik, Sheikh and Simoncelli 2004).

/// Half of the window of 11 pixels.
const HALF: usize = 5;
/// Standard deviation of the window \[px\].
const SIGMA: f64 = 1.5;
/// (0.01)² and (0.03)², for values 0 to 1.
const STEADY: [f64; 2] = [1e-4, 9e-4];

/// Mean over all windows that lie in the picture, and over three channels, of interleaved values 0 to 1; nothing for
/// pictures of different sizes or smaller than a window.
pub(super) fn ssim(a: &[f32], b: &[f32], width: usize) -> Option<f64> {
    let height = a.len() / (3 * width.max(1));
    if a.len() != b.len() || width <= 2 * HALF || height <= 2 * HALF {
        return None;
    }
    let channel = |of: &dyn Fn(usize) -> f64| blurred(of, width, height);
    let mean = |c: usize| {
        let (x, y) = (|i: usize| f64::from(a[3 * i + c]), |i: usize| f64::from(b[3 * i + c]));
        let [mx, my] = [channel(&x), channel(&y)];
        let [xx, yy, xy] = [channel(&|i| x(i) * x(i)), channel(&|i| y(i) * y(i)), channel(&|i| x(i) * y(i))];
        let one = |i: usize| {
            let (vx, vy, v) = (xx[i] - mx[i] * mx[i], yy[i] - my[i] * my[i], xy[i] - mx[i] * my[i]);
            (2.0 * mx[i] * my[i] + STEADY[0]) * (2.0 * v + STEADY[1])
                / ((mx[i] * mx[i] + my[i] * my[i] + STEADY[0]) * (vx + vy + STEADY[1]))
        };
        (0..mx.len()).map(one).sum::<f64>() / mx.len() as f64
    };
    Some((0..3).map(mean).sum::<f64>() / 3.0)
}

/// The means over all windows, first along rows, then along columns.
fn blurred(of: &dyn Fn(usize) -> f64, width: usize, height: usize) -> Vec<f64> {
    let weights: Vec<f64> = (0..=2 * HALF).map(|k| (-0.5 * ((k as f64 - HALF as f64) / SIGMA).powi(2)).exp()).collect();
    let total: f64 = weights.iter().sum();
    let sum = |at: &dyn Fn(usize) -> f64| weights.iter().enumerate().map(|(k, w)| w * at(k)).sum::<f64>() / total;
    let narrow = width - 2 * HALF;
    let rows: Vec<f64> = (0..height * narrow).map(|i| sum(&|k| of(i / narrow * width + i % narrow + k))).collect();
    (0..(height - 2 * HALF) * narrow).map(|i| sum(&|k| rows[i + k * narrow])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_pictures_are_one_and_known_ones_what_the_formula_says() {
        let noise: Vec<f32> =
            (0..3 * 20 * 16_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 8) as f32 / (1 << 24) as f32).collect();
        // Roundings of sums of 121 numbers.
        assert!(ssim(&noise, &noise, 20).is_some_and(|s| (s - 1.0).abs() < 1e-12));
        // Two plain ones differ in the first factor alone.
        let [a, b] = [0.4_f32, 0.6].map(|v| vec![v; noise.len()]);
        let exact = (2.0 * 0.24 + 1e-4) / (0.16 + 0.36 + 1e-4);
        assert!(ssim(&a, &b, 20).is_some_and(|s| (s - exact).abs() < 1e-6));
        assert!(ssim(&noise, &a, 20).is_some_and(|s| s < 0.1));
        assert!(ssim(&a, &b[3..], 20).is_none() && ssim(&a, &b, 8).is_none());
    }
}
