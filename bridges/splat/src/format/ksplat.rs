//! `.ksplat`: sections of Gaussians in rows, relative to the centres of buckets where compressed.
//!
//! Layout as published with `GaussianSplats3D` (MIT), version 0.1. A header of 4096 bytes is followed by one of 1024 bytes
//! a section and the data of the sections: sizes of partly filled buckets, centres of buckets, rows. Level 0 holds single
//! precision; level 1 positions in 16 bits and the rest in half precision; level 2 the higher bands in bytes. Scales are
//! linear. Axes are those of the `.ply` the file was made from.

use super::half::half_to_f32;
use super::{Decoded, Format};
use crate::error::{Fault, SplatError};
use crate::splats::{Axes, Splats, coefficients, dc_of_colour, logit_of_opacity};

/// The registry entry.
pub(super) const FORMAT: Format =
    Format { name: "ksplat", endings: &["ksplat"], axes: Axes::Rdf, recognise: |_| false, read, write: None };

const HEADER: usize = 4096;
const SECTION: usize = 1024;
/// Bytes of a bucket's centre.
const CENTRE: usize = 12;
/// Steps from the centre of a bucket to its edge, unless a section says otherwise.
const STEPS: u32 = 32_767;
/// Range of the higher bands at level 2, unless the header says otherwise.
const BAND_RANGE: f32 = 1.5;

fn fault(place: impl Into<String>, what: impl Into<String>) -> SplatError {
    SplatError::new(Fault::Header, place, what, "write the file again with the tool it came from")
}

fn u16_at(bytes: &[u8], at: usize) -> u16 {
    bytes.get(at..).and_then(<[u8]>::first_chunk).map_or(0, |b| u16::from_le_bytes(*b))
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    bytes.get(at..).and_then(<[u8]>::first_chunk).map_or(0, |b| u32::from_le_bytes(*b))
}

fn f32_at(bytes: &[u8], at: usize) -> f32 {
    f32::from_bits(u32_at(bytes, at))
}

/// How numbers of a row are stored.
#[derive(Clone, Copy, Debug)]
struct Coding {
    level: u16,
    /// Smallest and largest number of the higher bands at level 2.
    bands: [f32; 2],
}

impl Coding {
    /// Bytes of a scale or a component of a quaternion.
    fn number(self) -> usize {
        if self.level == 0 { 4 } else { 2 }
    }

    /// Bytes of a coefficient of the higher bands.
    fn band(self) -> usize {
        [4, 2, 1][usize::from(self.level)]
    }

    /// Bytes of a row: ten numbers (position, scale, quaternion), four bytes of colour, higher bands.
    fn row(self, degree: u8) -> usize {
        10 * self.number() + 4 + 3 * coefficients(degree) * self.band()
    }

    /// Scale or component of a quaternion: number `k` of a row.
    fn at(self, row: &[u8], k: usize) -> f32 {
        if self.level == 0 { f32_at(row, 4 * k) } else { half_to_f32(u16_at(row, 2 * k)) }
    }

    /// Number `k` of the higher bands of a row.
    fn band_at(self, row: &[u8], k: usize) -> f32 {
        let bands = &row[10 * self.number() + 4..];
        match self.level {
            0 => f32_at(bands, 4 * k),
            1 => half_to_f32(u16_at(bands, 2 * k)),
            _ => self.bands[0] + f32::from(bands[k]) / 255.0 * (self.bands[1] - self.bands[0]),
        }
    }
}

/// A section: its rows and what they are relative to.
struct Section<'a> {
    place: String,
    degree: u8,
    rows: &'a [u8],
    buckets: Buckets<'a>,
}

/// Centres of buckets and how many Gaussians each holds: first full ones, then partly filled ones.
#[derive(Clone, Copy)]
struct Buckets<'a> {
    centres: &'a [u8],
    /// Gaussians in full buckets.
    in_full: u64,
    full: usize,
    size: u64,
    /// Sizes of the others.
    partial: &'a [u8],
    /// Half an edge and its steps.
    half: f32,
    steps: u32,
}

impl<'a> Section<'a> {
    /// Reads the header of a section; its data begins at byte `base`. Also gives the byte behind it.
    fn open(bytes: &'a [u8], number: usize, base: usize, coding: Coding) -> Result<(Section<'a>, usize), SplatError> {
        let place = format!("section {number}");
        let header = bytes.get(HEADER + number * SECTION..).and_then(|b| b.get(..SECTION)).ok_or_else(|| {
            SplatError::truncated(place.as_str(), (HEADER + (number + 1) * SECTION) as u64, bytes.len() as u64)
        })?;
        let word = |at: usize| u32_at(header, at) as usize;
        let (count, room, size, buckets) = (word(0), word(4), word(8), word(12));
        let (full, partial, storage) = (word(32), word(36), usize::from(u16_at(header, 20)));
        let degree = u16_at(header, 40);
        if degree > 3 {
            return Err(fault(place, format!("degree {degree} of the spherical harmonics is not 0 to 3")));
        }
        if count > room {
            return Err(fault(place, format!("{count} Gaussians are there and {room} fit")));
        }
        if coding.level > 0 && buckets > 0 && storage != CENTRE {
            return Err(fault(place, format!("the centre of a bucket has {storage} bytes, not {CENTRE}")));
        }
        let (degree, row) = (degree as u8, coding.row(degree as u8));
        // Products of two numbers of 32 bits or less: no overflow in 128 bits.
        let ends = [4 * partial as u128, storage as u128 * buckets as u128, row as u128 * count as u128]
            .into_iter()
            .scan(base as u128, |at, length| {
                *at += length;
                Some(*at)
            })
            .map(|end| usize::try_from(end).ok().filter(|end| *end <= bytes.len()));
        let ends: Option<Vec<usize>> = ends.collect();
        let Some(&[sizes, centres, end]) = ends.as_deref() else {
            let needs = (base + row * count) as u64 + 4 * partial as u64 + (storage * buckets) as u64;
            return Err(SplatError::truncated(place, needs, bytes.len() as u64));
        };
        let steps = Some(u32_at(header, 24)).filter(|steps| *steps > 0).unwrap_or(STEPS);
        let buckets = Buckets {
            centres: &bytes[sizes..centres],
            in_full: full as u64 * size as u64,
            full,
            size: size as u64,
            partial: &bytes[base..sizes],
            half: f32_at(header, 16) / 2.0,
            steps,
        };
        let next = centres.saturating_add(row.saturating_mul(room));
        Ok((Section { place, degree, rows: &bytes[centres..end], buckets }, next))
    }

    /// Appends the Gaussians, with the higher bands that all sections share.
    fn decode(&self, coding: Coding, splats: &mut Splats) -> Result<(), SplatError> {
        let kept = splats.coefficients();
        let own = coefficients(self.degree);
        let mut bucket = Walk::new(self.buckets);
        for row in self.rows.chunks_exact(coding.row(self.degree)) {
            splats.positions.push(if coding.level == 0 {
                [0, 1, 2].map(|k| f32_at(row, 4 * k))
            } else {
                let centre = bucket.next_centre().ok_or_else(|| {
                    let what = format!("Gaussian {} lies in no bucket", splats.positions.len());
                    let advice = "write the file again with the tool it came from";
                    SplatError::new(Fault::Value, self.place.as_str(), what, advice)
                })?;
                self.buckets.position(row, centre)
            });
            splats.log_scales.push([3, 4, 5].map(|k| f64::from(coding.at(row, k)).ln() as f32));
            splats.rotations.push([6, 7, 8, 9].map(|k| coding.at(row, k)));
            let colour = [0, 1, 2, 3].map(|k| f64::from(row[10 * coding.number() + k]) / 255.0);
            splats.sh_dc.push([0, 1, 2].map(|k| dc_of_colour(colour[k])));
            splats.opacity_logits.push(logit_of_opacity(colour[3]));
            splats.sh_rest.extend(
                (0..kept).map(|j| if j < own { place_in_row(j).map(|k| coding.band_at(row, k)) } else { [0.0; 3] }),
            );
        }
        Ok(())
    }
}

/// Red, green and blue of coefficient `j`: bands follow each other, channel-major within each.
fn place_in_row(j: usize) -> [usize; 3] {
    let (first, width) = match j {
        0..3 => (0, 3),
        3..8 => (3, 5),
        _ => (8, 7),
    };
    [0, 1, 2].map(|channel| 3 * first + channel * width + (j - first))
}

impl Buckets<'_> {
    /// x = (v − steps) · half / steps + centre.
    fn position(self, row: &[u8], centre: [f32; 3]) -> [f32; 3] {
        let steps = f64::from(self.steps);
        let step = f64::from(self.half) / steps;
        [0, 1, 2].map(|k| ((f64::from(u16_at(row, 2 * k)) - steps) * step + f64::from(centre[k])) as f32)
    }
}

/// Goes from Gaussian to Gaussian and says in which bucket each is.
struct Walk<'a> {
    buckets: Buckets<'a>,
    done: u64,
    /// The partly filled bucket reached, and what is left in it.
    partial: usize,
    left: u32,
}

impl<'a> Walk<'a> {
    fn new(buckets: Buckets<'a>) -> Walk<'a> {
        Walk { buckets, done: 0, partial: 0, left: 0 }
    }

    /// Centre of the next Gaussian's bucket, if it has one.
    fn next_centre(&mut self) -> Option<[f32; 3]> {
        let Buckets { centres, in_full, full, size, partial, .. } = self.buckets;
        let bucket = if self.done < in_full {
            usize::try_from(self.done / size).ok()?
        } else {
            while self.left == 0 {
                self.left = u32::from_le_bytes(*partial.get(4 * self.partial..)?.first_chunk()?);
                self.partial += 1;
            }
            self.left -= 1;
            full + self.partial - 1
        };
        self.done += 1;
        let centre = centres.get(bucket.checked_mul(CENTRE)?..)?.get(..CENTRE)?;
        Some([0, 4, 8].map(|at| f32_at(centre, at)))
    }
}

fn read(bytes: &[u8]) -> Result<Decoded, SplatError> {
    let header = bytes.get(..HEADER);
    let header = header.ok_or_else(|| SplatError::truncated("header", HEADER as u64, bytes.len() as u64))?;
    let [major, minor] = [header[0], header[1]];
    if major != 0 || minor == 0 {
        let what = format!("version {major}.{minor} is not 0.1");
        return Err(SplatError::new(Fault::Unsupported, "header", what, "write the file again with a newer tool"));
    }
    let level = u16_at(header, 20);
    if level > 2 {
        return Err(fault("header", format!("level {level} of compression is not 0, 1 or 2")));
    }
    let or = |value: f32, default: f32| if value == 0.0 || value.is_nan() { default } else { value };
    let bands = [or(f32_at(header, 36), -BAND_RANGE), or(f32_at(header, 40), BAND_RANGE)];
    let coding = Coding { level, bands };
    let (most, promised) = (u32_at(header, 4) as usize, u32_at(header, 16) as usize);
    let mut base = (most as u64 * SECTION as u64 + HEADER as u64) as usize;
    if base > bytes.len() {
        return Err(SplatError::truncated("headers of sections", base as u64, bytes.len() as u64));
    }
    let mut sections = Vec::new();
    for number in 0..most {
        let (section, next) = Section::open(bytes, number, base, coding)?;
        base = next;
        sections.push(section);
    }
    let filled = |section: &&Section<'_>| !section.rows.is_empty();
    let degree = sections.iter().filter(filled).map(|s| s.degree).max().unwrap_or(0);
    let count = sections.iter().map(|s| s.rows.len() / coding.row(s.degree)).sum();
    let mut splats = Splats::with_capacity(count, degree);
    for section in sections.iter().filter(filled) {
        section.decode(coding, &mut splats)?;
    }
    let mut notes = Vec::new();
    if promised != count {
        notes.push(format!("the header speaks of {promised} Gaussians and the sections hold {count}"));
    }
    Ok(Decoded { splats, notes })
}
