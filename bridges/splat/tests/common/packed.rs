//! Small files of the packed formats, written here by their published layouts, and the comparison of what they hold.

use cosplat_splat::{Splats, coefficients};

use super::Random;

/// Largest difference, over the Gaussians, of what a picture depends on.
pub(crate) struct Gap {
    pub(crate) position: f64,
    pub(crate) log_scale: f64,
    pub(crate) opacity: f64,
    /// Of the rotation matrices.
    pub(crate) rotation: f64,
    pub(crate) dc: f64,
    pub(crate) rest: f64,
}

/// Compares Gaussian by Gaussian, in order.
pub(crate) fn gap(a: &Splats, b: &Splats) -> Gap {
    assert_eq!(a.len(), b.len());
    let largest = |d: &mut dyn Iterator<Item = f64>| d.fold(0.0, f64::max);
    let flat = |x: &[[f32; 3]], y: &[[f32; 3]]| {
        let pairs = x.iter().flatten().zip(y.iter().flatten());
        largest(&mut pairs.map(|(p, q)| (f64::from(*p) - f64::from(*q)).abs()))
    };
    let angle = |p: &[f32; 4], q: &[f32; 4]| {
        let length = |v: &[f32; 4]| v.iter().map(|c| f64::from(*c).powi(2)).sum::<f64>().sqrt();
        let dot: f64 = p.iter().zip(q).map(|(x, y)| f64::from(*x) * f64::from(*y)).sum();
        (1.0 - (dot / length(p) / length(q)).powi(2)).max(0.0).sqrt()
    };
    Gap {
        position: flat(&a.positions, &b.positions),
        log_scale: flat(&a.log_scales, &b.log_scales),
        opacity: largest(&mut (0..a.len()).map(|i| (a.opacity(i) - b.opacity(i)).abs())),
        rotation: largest(&mut a.rotations.iter().zip(&b.rotations).map(|(p, q)| angle(p, q))),
        dc: flat(&a.sh_dc, &b.sh_dc),
        rest: flat(&a.sh_rest, &b.sh_rest),
    }
}

/// A chunked PLY of random bits: chunks of 256, all bounds from −1 to 1 but for log scales, which go from −6 to −2.
pub(crate) fn chunked_ply(count: usize, degree: u8, colours: bool, seed: u64) -> Vec<u8> {
    let mut r = Random::new(seed);
    let mut header = format!("ply\nformat binary_little_endian 1.0\nelement chunk {}\n", count.div_ceil(256));
    let mut bounds = Vec::new();
    let kinds: &[(&str, [f32; 2])] = &[("", [-1.0, 1.0]), ("scale_", [-6.0, -2.0]), ("colour", [0.25, 0.75])];
    for (kind, range) in &kinds[..if colours { 3 } else { 2 }] {
        for (side, value) in ["min", "max"].iter().zip(range) {
            for axis in if *kind == "colour" { ["r", "g", "b"] } else { ["x", "y", "z"] } {
                let kind = if *kind == "colour" { "" } else { *kind };
                header.push_str(&["property float ", side, "_", kind, axis, "\n"].concat());
                bounds.extend(value.to_le_bytes());
            }
        }
    }
    header.push_str(&["element vertex ", &count.to_string(), "\n"].concat());
    for name in ["position", "rotation", "scale", "color"] {
        header.push_str(&["property uint packed_", name, "\n"].concat());
    }
    let higher = 3 * coefficients(degree);
    if degree > 0 {
        header.push_str(&["element sh ", &count.to_string(), "\n"].concat());
        for i in 0..higher {
            header.push_str(&["property uchar f_rest_", &i.to_string(), "\n"].concat());
        }
    }
    header.push_str("end_header\n");
    let mut out = header.into_bytes();
    out.extend(bounds.repeat(count.div_ceil(256)));
    out.extend((0..(16 + higher) * count).map(|_| (r.unit() * 256.0) as u8));
    out
}

/// Sections of a `.ksplat`: Gaussians, degree, Gaussians of a full bucket, sizes of partly filled buckets.
pub(crate) type KsplatSection = (u32, u8, u32, Vec<u32>);

/// A `.ksplat` of random rows: scales near one half, the bits of everything else chosen by `seed`.
pub(crate) fn ksplat(level: u16, sections: &[KsplatSection], seed: u64) -> Vec<u8> {
    let mut r = Random::new(seed);
    let total: u32 = sections.iter().map(|s| s.0).sum();
    let mut out = vec![0; 4096];
    out[1] = 1;
    for (at, value) in [(4, sections.len() as u32), (8, sections.len() as u32), (12, total), (16, total)] {
        out[at..at + 4].copy_from_slice(&value.to_le_bytes());
    }
    out[20..22].copy_from_slice(&level.to_le_bytes());
    let mut data = Vec::new();
    for (count, degree, size, partial) in sections {
        let full = (count - partial.iter().sum::<u32>()) / size.max(&1);
        let buckets = full + partial.len() as u32;
        let mut header = vec![0; 1024];
        for (at, value) in [
            (0, *count),
            (4, *count),
            (8, *size),
            (12, buckets),
            (16, 4.0_f32.to_bits()),
            (20, 12),
            (24, 32_767),
            (32, full),
            (36, partial.len() as u32),
            (40, u32::from(*degree)),
        ] {
            header[at..at + 4].copy_from_slice(&value.to_le_bytes());
        }
        out.extend(header);
        data.extend(partial.iter().flat_map(|p| p.to_le_bytes()));
        data.extend((0..buckets).flat_map(|b| [b as f32, 0.0, 0.0]).flat_map(f32::to_le_bytes));
        for _ in 0..*count {
            for k in 0..10 {
                if level > 0 && k >= 3 {
                    // Half precision: 0x3800 is one half, and the lower bits are its fraction.
                    data.extend((0x3800 | (r.unit() * 1024.0) as u16).to_le_bytes());
                } else if level > 0 {
                    data.extend(((r.unit() * 65_535.0) as u16).to_le_bytes());
                } else {
                    data.extend(r.single(0.5, 1.0).to_le_bytes());
                }
            }
            data.extend((0..4).map(|_| (r.unit() * 256.0) as u8));
            for _ in 0..3 * coefficients(*degree) {
                let bits = (r.unit() * 1024.0) as u16;
                match level {
                    0 => data.extend(r.single(-0.5, 0.5).to_le_bytes()),
                    1 => data.extend((0x3000 | bits).to_le_bytes()),
                    _ => data.push(bits as u8),
                }
            }
        }
    }
    out.extend(data);
    out
}
