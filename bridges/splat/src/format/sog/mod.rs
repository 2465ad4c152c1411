//! `.sog` version 2: lossless WebP pictures in a ZIP archive, one pixel a Gaussian, and `meta.json`.
//!
//! Layout as published by `PlayCanvas` (MIT). Axes are those of the `.ply` the file was made from.

mod image;

use serde::Deserialize;

use self::image::{Image, Pixel};
use super::zip::Zip;
use super::{Decoded, Format, Limits};
use crate::error::{Fault, SplatError};
use crate::splats::{Axes, Splats, coefficients, logit_of_opacity};

/// The registry entry.
pub(super) const FORMAT: Format = Format {
    name: "sog",
    endings: &["sog"],
    axes: Axes::Rdf,
    recognise: |bytes| bytes.starts_with(b"PK\x03\x04"),
    read: |bytes| read(bytes, Limits::default()),
    write: None,
};

/// Centroids in one row of their picture.
const PER_ROW: usize = 64;

#[derive(Deserialize)]
struct Meta {
    #[serde(default)]
    version: u32,
    #[serde(default)]
    count: u64,
    means: Option<Means>,
    scales: Option<Coded>,
    quats: Option<Files>,
    sh0: Option<Coded>,
    #[serde(rename = "shN")]
    higher: Option<Higher>,
}

#[derive(Deserialize)]
struct Means {
    mins: [f64; 3],
    maxs: [f64; 3],
    files: Vec<String>,
}

#[derive(Deserialize)]
struct Files {
    files: Vec<String>,
}

#[derive(Deserialize)]
struct Coded {
    #[serde(default)]
    codebook: Vec<f32>,
    files: Vec<String>,
}

#[derive(Deserialize)]
struct Higher {
    #[serde(default)]
    bands: u8,
    #[serde(default)]
    codebook: Vec<f32>,
    files: Vec<String>,
}

fn fault(what: impl Into<String>) -> SplatError {
    SplatError::new(Fault::Header, "meta.json", what, "write the file again with the tool it came from")
}

/// The archive and what is said about it.
struct Source<'a> {
    zip: Zip<'a>,
    count: usize,
    limits: Limits,
}

impl Source<'_> {
    /// The picture of that number in a list, with at least a pixel a Gaussian.
    fn image(&self, files: &[String], number: usize) -> Result<Image, SplatError> {
        let image = self.any_image(files, number, 2 * self.count + (1 << 16))?;
        if image.pixels() < self.count {
            let what = format!("`{}` has {} pixels for {} Gaussians", files[number], image.pixels(), self.count);
            return Err(fault(what));
        }
        Ok(image)
    }

    fn any_image(&self, files: &[String], number: usize, most: usize) -> Result<Image, SplatError> {
        let name = files.get(number).ok_or_else(|| fault("a list of files is too short"))?;
        Image::decode(&self.zip.member(name, self.limits)?, most, name)
    }
}

fn read(bytes: &[u8], limits: Limits) -> Result<Decoded, SplatError> {
    let zip = Zip::open(bytes)?;
    let meta: Meta =
        serde_json::from_slice(&zip.member("meta.json", limits)?).map_err(|error| fault(error.to_string()))?;
    if meta.version != 2 {
        let what = format!("version {} is not 2", meta.version);
        return Err(SplatError::new(Fault::Unsupported, "meta.json", what, "convert it with a newer tool"));
    }
    let (Some(means), Some(scales), Some(quats), Some(sh0)) = (meta.means, meta.scales, meta.quats, meta.sh0) else {
        return Err(fault("one of `means`, `scales`, `quats`, `sh0` is missing"));
    };
    let degree = meta.higher.as_ref().map_or(0, |h| h.bands);
    if degree > 3 || (meta.higher.is_some() && degree == 0) {
        return Err(fault(format!("{degree} bands are not 1 to 3")));
    }
    let size = 4 * (14 + 3 * coefficients(degree) as u64);
    limits.check(meta.count.saturating_mul(size), bytes.len())?;
    let source = Source { zip, count: meta.count as usize, limits };
    let (log_scales, _) = coded(&source, &scales, "scales")?;
    let (sh_dc, alphas) = coded(&source, &sh0, "sh0")?;
    let sh_rest = match &meta.higher {
        Some(higher) => bands(&source, higher)?,
        None => Vec::new(),
    };
    let splats = Splats {
        positions: positions(&source, &means)?,
        rotations: rotations(&source, &quats.files)?,
        log_scales,
        opacity_logits: alphas.iter().map(|&a| logit_of_opacity(f64::from(a) / 255.0)).collect(),
        sh_dc,
        sh_rest,
        sh_degree: degree,
        ..Splats::default()
    };
    Ok(Decoded { splats, notes: Vec::new() })
}

/// t = min + (max − min) · v / 65535 of 16 bits from two pictures; x = sign(t) (e^|t| − 1).
fn positions(source: &Source<'_>, means: &Means) -> Result<Vec<[f32; 3]>, SplatError> {
    let (low, high) = (source.image(&means.files, 0)?, source.image(&means.files, 1)?);
    let of = |i: usize| {
        let (l, h) = (low.at(i), high.at(i));
        [0, 1, 2].map(|k| {
            let v = f64::from(u16::from_le_bytes([l[k], h[k]])) / 65535.0;
            let t = means.mins[k] + (means.maxs[k] - means.mins[k]) * v;
            (t.signum() * (t.abs().exp() - 1.0)) as f32
        })
    };
    Ok((0..source.count).map(of).collect())
}

/// Red, green, blue through a codebook of 256 numbers, and the fourth byte.
fn coded(source: &Source<'_>, part: &Coded, name: &str) -> Result<(Vec<[f32; 3]>, Vec<u8>), SplatError> {
    let book = codebook(&part.codebook, name)?;
    let image = source.image(&part.files, 0)?;
    Ok((0..source.count).map(|i| (through(book, image.at(i)), image.at(i)[3])).unzip())
}

fn codebook<'a>(book: &'a [f32], name: &str) -> Result<&'a [f32; 256], SplatError> {
    book.as_array().ok_or_else(|| fault(format!("the codebook of `{name}` has {} entries, not 256", book.len())))
}

fn through(book: &[f32; 256], pixel: Pixel) -> [f32; 3] {
    [0, 1, 2].map(|k| book[usize::from(pixel[k])])
}

/// The fourth byte minus 252 is the place of the largest component in w, x, y, z; the other three follow in order as
/// (v / 255 − ½) √2.
fn rotations(source: &Source<'_>, files: &[String]) -> Result<Vec<[f32; 4]>, SplatError> {
    let image = source.image(files, 0)?;
    let of = |i: usize| {
        let pixel = image.at(i);
        let largest = usize::from(pixel[3].checked_sub(252).ok_or_else(|| {
            let what = format!("Gaussian {i} has the mark {}, which is not 252 to 255", pixel[3]);
            SplatError::new(Fault::Value, files[0].as_str(), what, "write the file again with the tool it came from")
        })?);
        let small = [0, 1, 2].map(|k| (f64::from(pixel[k]) / 255.0 - 0.5) * std::f64::consts::SQRT_2);
        let left = (1.0 - small.iter().map(|v| v * v).sum::<f64>()).max(0.0).sqrt();
        let mut q = [left as f32; 4];
        for (at, v) in (0..4).filter(|&at| at != largest).zip(small) {
            q[at] = v as f32;
        }
        Ok(q)
    };
    (0..source.count).map(of).collect()
}

/// A palette: labels red + 256 green; centroid k in row k / 64, its coefficients from column (k mod 64) · K.
fn bands(source: &Source<'_>, higher: &Higher) -> Result<Vec<[f32; 3]>, SplatError> {
    let book = codebook(&higher.codebook, "shN")?;
    let k = coefficients(higher.bands);
    let centroids = source.any_image(&higher.files, 0, PER_ROW * k * (1 << 16) / PER_ROW)?;
    let labels = source.image(&higher.files, 1)?;
    if centroids.width() != PER_ROW * k {
        return Err(fault(format!("the picture of centroids is {} wide, not {}", centroids.width(), PER_ROW * k)));
    }
    let mut rest = Vec::with_capacity(source.count * k);
    for i in 0..source.count {
        let [low, high, ..] = labels.at(i);
        let first = usize::from(u16::from_le_bytes([low, high])) * k;
        if first + k > centroids.pixels() {
            let what = format!("Gaussian {i} has the label {}, and there are {}", first / k, centroids.pixels() / k);
            return Err(SplatError::new(Fault::Value, "shN", what, "write the file again with the tool it came from"));
        }
        rest.extend((first..first + k).map(|at| through(book, centroids.at(at))));
    }
    Ok(rest)
}
