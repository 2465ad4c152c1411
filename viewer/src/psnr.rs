//! Peak signal to noise ratio.

/// −10 log₁₀ of the mean squared difference, in dB, for values 0 to 1; infinite for equal pictures, NaN for pictures of
/// different sizes or of none.
pub fn psnr(a: &[f32], b: &[f32]) -> f64 {
    if a.len() != b.len() || a.is_empty() {
        return f64::NAN;
    }
    let squared = a.iter().zip(b).map(|(&x, &y)| (f64::from(x) - f64::from(y)).powi(2));
    let mean = squared.sum::<f64>() / a.len() as f64;
    if mean == 0.0 { f64::INFINITY } else { -10.0 * mean.log10() }
}

#[cfg(test)]
mod tests {
    use super::psnr;

    #[test]
    fn known_ratios() {
        assert!(psnr(&[0.5; 8], &[0.5; 8]).is_infinite());
        assert!((psnr(&[0.0; 8], &[0.1; 8]) - 20.0).abs() < 1e-5);
        assert!(psnr(&[0.0; 8], &[0.0; 7]).is_nan() && psnr(&[], &[]).is_nan());
    }
}
