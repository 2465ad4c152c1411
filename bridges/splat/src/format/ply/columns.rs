//! Which property of a file goes where.

use super::header::{Element, Kind};
use crate::error::{Fault, SplatError};
use crate::splats::{Extra, SH_C0, Splats};

/// Slots of one Gaussian in a flat row: position, quaternion, log scale, opacity logit, base band, higher bands as
/// coefficient · 3 + channel, and colours 0 to 255 where the base band is missing.
const ROTATION: usize = 3;
const SCALE: usize = 7;
const OPACITY: usize = 10;
const DC: usize = 11;
const REST: usize = 14;
const COLOUR: usize = REST + 45;
/// Length of the flat row.
pub(super) const ROW: usize = COLOUR + 3;

/// Higher-band coefficients that are kept: bands 1 to 3.
pub(super) const KEPT: usize = 15;

/// Where a column goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Target {
    /// Into this slot of the flat row.
    Slot(usize),
    /// To this extra.
    Extra(usize),
    /// Nowhere.
    Nowhere,
}

/// A column of the vertex table.
#[derive(Clone, Copy, Debug)]
pub(super) struct Column {
    /// Bytes from the start of a binary row.
    pub(super) offset: usize,
    pub(super) kind: Kind,
    pub(super) target: Target,
}

/// How the vertex table becomes Gaussians.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    pub(super) columns: Vec<Column>,
    pub(super) extras: Vec<Extra>,
    pub(super) degree: u8,
    /// Degree in the file; higher than `degree` if bands are left out.
    pub(super) file_degree: u8,
    colour_from_bytes: bool,
}

fn missing(name: &str, advice: &str) -> SplatError {
    let what = format!("there is no property `{name}` of `vertex`");
    SplatError::new(Fault::Header, "header", what, advice.to_owned())
}

impl Plan {
    /// Finds every property by its name.
    pub(super) fn new(vertex: &Element) -> Result<Plan, SplatError> {
        let has = |name: &str| vertex.properties.iter().any(|p| p.name == name);
        let advice = match (has("scale_0"), has("scale_2")) {
            (false, _) => "this looks like a point cloud or a mesh: train or convert it to Gaussians first",
            (true, false) => "this looks like flat 2D Gaussians: export them as 3D Gaussians",
            _ => "convert the file to an INRIA `.ply`",
        };
        let needed = ["x", "y", "z", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3", "opacity"];
        if let Some(name) = needed.iter().find(|name| !has(name)) {
            return Err(missing(name, advice));
        }
        let colour_from_bytes = !has("f_dc_0");
        let colours = if colour_from_bytes { ["red", "green", "blue"] } else { ["f_dc_0", "f_dc_1", "f_dc_2"] };
        if let Some(name) = colours.iter().find(|name| !has(name)) {
            return Err(missing(name, advice));
        }
        let per_channel = rest_per_channel(vertex)?;
        let file_degree = (1..=4).rev().find(|&d| crate::splats::coefficients(d) == per_channel).unwrap_or(0);
        let mut plan = Plan {
            columns: Vec::new(),
            extras: Vec::new(),
            degree: file_degree.min(3),
            file_degree,
            colour_from_bytes,
        };
        let mut offset = 0;
        for property in &vertex.properties {
            let target = plan.target(&property.name, property.kind, per_channel);
            plan.columns.push(Column { offset, kind: property.kind, target });
            offset += property.kind.size();
        }
        Ok(plan)
    }

    fn target(&mut self, name: &str, kind: Kind, per_channel: usize) -> Target {
        let numbered = |prefix: &str, limit: usize| name.strip_prefix(prefix).and_then(index).filter(|&i| i < limit);
        match name {
            "x" => return Target::Slot(0),
            "y" => return Target::Slot(1),
            "z" => return Target::Slot(2),
            "opacity" => return Target::Slot(OPACITY),
            "nx" | "ny" | "nz" => return Target::Nowhere,
            "red" if self.colour_from_bytes => return Target::Slot(COLOUR),
            "green" if self.colour_from_bytes => return Target::Slot(COLOUR + 1),
            "blue" if self.colour_from_bytes => return Target::Slot(COLOUR + 2),
            _ => {}
        }
        for (prefix, first, count) in [("rot_", ROTATION, 4), ("scale_", SCALE, 3), ("f_dc_", DC, 3)] {
            if let Some(i) = numbered(prefix, count) {
                return Target::Slot(first + i);
            }
        }
        if let Some(i) = numbered("f_rest_", 3 * per_channel) {
            let (channel, coefficient) = (i / per_channel, i % per_channel);
            return if coefficient < KEPT { Target::Slot(REST + 3 * coefficient + channel) } else { Target::Nowhere };
        }
        self.extras.push(Extra { name: name.to_owned(), kind: kind.name(), values: Vec::new() });
        Target::Extra(self.extras.len() - 1)
    }

    /// Appends the Gaussian of a flat row.
    pub(super) fn push(&self, row: &[f32; ROW], splats: &mut Splats) {
        let three = |at: usize| [row[at], row[at + 1], row[at + 2]];
        splats.positions.push(three(0));
        splats.rotations.push([row[ROTATION], row[ROTATION + 1], row[ROTATION + 2], row[ROTATION + 3]]);
        splats.log_scales.push(three(SCALE));
        splats.opacity_logits.push(row[OPACITY]);
        splats.sh_dc.push(if self.colour_from_bytes {
            three(COLOUR).map(|v| ((f64::from(v) / 255.0 - 0.5) / SH_C0) as f32)
        } else {
            three(DC)
        });
        splats.sh_rest.extend((0..splats.coefficients()).map(|j| three(REST + 3 * j)));
    }
}

/// A number without a sign or leading zeros.
fn index(digits: &str) -> Option<usize> {
    digits.parse().ok().filter(|i: &usize| i.to_string() == digits)
}

/// Coefficients above the base band in an element, for one channel.
pub(super) fn rest_per_channel(vertex: &Element) -> Result<usize, SplatError> {
    let names: Vec<&str> = vertex.properties.iter().filter_map(|p| p.name.strip_prefix("f_rest_")).collect();
    let mut numbers: Vec<usize> = names.iter().filter_map(|n| index(n)).collect();
    numbers.sort_unstable();
    let contiguous = numbers.len() == names.len() && numbers.iter().enumerate().all(|(i, &n)| i == n);
    if contiguous && [0, 9, 24, 45, 72].contains(&names.len()) {
        return Ok(names.len() / 3);
    }
    let what = format!("{} properties `f_rest_*` are no set of spherical harmonics of degree 0 to 4", names.len());
    let advice = "degrees 0 to 4 have 0, 9, 24, 45 or 72 of them, numbered from 0 without a gap";
    Err(SplatError::new(Fault::Header, "header", what, advice))
}
