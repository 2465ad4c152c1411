//! `cosplat splat info`: what a file holds.

use std::path::PathBuf;

use clap::Args;
use cosplat_splat::Axes;
use serde::Serialize;

use super::guess::{Up, suspicions};
use super::read;
use super::statistics::{Extent, Spread, Statistics, VISIBLE};
use crate::cli::Format;
use crate::exit::{Code, Error};
use crate::render::{Paint, json, print, printable};

/// `cosplat splat info`.
#[derive(Clone, Debug, Args)]
pub(crate) struct InfoArgs {
    /// Splat file: .ply, .compressed.ply, .spz, .glb, .sog, .ksplat or .splat
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
    /// Form of the answer on standard output
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
}

/// What is said about a file. Lengths are in units of the file.
#[derive(Debug, Serialize)]
struct Info {
    status: &'static str,
    file: String,
    format: &'static str,
    bytes: u64,
    gaussians: usize,
    degree: u8,
    antialiased: bool,
    /// Axes by the convention of the format: `right-down-forward`, `right-up-back` or `scene`.
    axes: &'static str,
    up: Up,
    #[serde(flatten)]
    statistics: Statistics,
    /// Names of properties that are only carried along.
    extras: Vec<String>,
    suspicious: Vec<String>,
    notes: Vec<String>,
    read_ms: f64,
}

/// Says what a splat file holds.
///
/// # Errors
/// The file cannot be used.
pub(super) fn info(args: &InfoArgs) -> Result<Code, Error> {
    let capture = read(&args.file)?;
    let splats = &capture.decoded.splats;
    let statistics = Statistics::of(splats);
    let info = Info {
        status: "ok",
        file: args.file.display().to_string(),
        format: capture.format,
        bytes: capture.bytes,
        gaussians: splats.len(),
        degree: splats.sh_degree,
        antialiased: splats.antialiased,
        axes: match splats.axes {
            Axes::Rdf => "right-down-forward",
            Axes::Rub => "right-up-back",
            Axes::Scene => "scene",
        },
        up: Up::of(splats, &capture.decoded.notes),
        suspicious: suspicions(splats, &statistics, capture.format),
        statistics,
        extras: splats.extras.iter().map(|e| e.name.clone()).collect(),
        notes: capture.decoded.notes,
        read_ms: capture.time.as_secs_f64() * 1e3,
    };
    match args.format {
        Format::Json => print(&json(&info)?)?,
        Format::Human => print(&info.human(Paint::stdout()))?,
    }
    Ok(Code::Ok)
}

impl Info {
    fn human(&self, paint: Paint) -> String {
        let mut lines = vec![
            ("format", format!("{}, {} bytes, read in {:.0} ms", self.format, self.bytes, self.read_ms)),
            ("Gaussians", format!("{}, colour of degree {}", self.gaussians, self.degree)),
            ("axes", self.axes.to_owned()),
        ];
        if self.gaussians > 0 {
            lines.extend(self.figures());
        }
        if self.antialiased {
            lines.push(("filter", "trained with the antialiasing filter".to_owned()));
        }
        if !self.extras.is_empty() {
            lines.push(("carried along", self.extras.join(", ")));
        }
        let Statistics { not_finite, without_rotation, .. } = self.statistics;
        if not_finite + without_rotation > 0 {
            let text = format!("{not_finite} with a number that is none, {without_rotation} without a rotation");
            lines.push(("damaged", paint.warn(&text)));
        }
        lines.extend(self.notes.iter().map(|note| ("note", printable(note))));
        let mut text = format!("{}\n", paint.bold(&printable(&self.file)));
        text.extend(lines.iter().map(|(name, value)| format!("  {name:<17} {value}\n")));
        text.extend(self.suspicious.iter().map(|what| format!("{} {what}\n", paint.warn("suspicious:"))));
        text
    }

    /// Lines about what there is at least one of.
    fn figures(&self) -> Vec<(&'static str, String)> {
        let Statistics { extent, visible_extent, visible, invisible, opacity, sigma, flatness, .. } = &self.statistics;
        let share = 100.0 * *visible as f64 / self.gaussians as f64;
        let mut lines = vec![
            ("up", self.up.line()),
            ("extent", extent.as_ref().map_or_else(|| "none".to_owned(), shown)),
            ("visible extent", visible_extent.as_ref().map_or_else(|| "none".to_owned(), shown)),
            ("opacity", spread(opacity)),
            ("", format!("{visible} of at least {VISIBLE} ({share:.1} %), {invisible} below 1/255")),
            ("sigma", spread(sigma)),
        ];
        let longest = visible_extent.or(*extent).map_or(0.0, |e| e.longest());
        if longest > 0.0 {
            lines.push(("", format!("the median is {:.3} % of the longest side", 100.0 * sigma.median / longest)));
        }
        lines.push(("largest/smallest", spread(flatness)));
        lines
    }
}

fn spread(s: &Spread) -> String {
    let [min, p01, median, p99, max] = [s.min, s.p01, s.median, s.p99, s.max].map(short);
    format!("{min} (least)  {p01} (1 %)  {median} (median)  {p99} (99 %)  {max} (most)")
}

fn shown(extent: &Extent) -> String {
    let corner = |c: [f64; 3]| c.map(short).join(", ");
    format!("[{}] to [{}], {} long", corner(extent.low), corner(extent.high), short(extent.longest()))
}

/// Four digits that count.
fn short(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    if !(1e-3..1e6).contains(&value.abs()) {
        return format!("{value:.3e}");
    }
    let digits = (3 - value.abs().log10().floor() as i32).clamp(0, 6);
    format!("{value:.*}", digits as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use cosplat_splat::format;

    #[test]
    fn the_plant_of_the_default_scene_is_as_it_should_be() {
        let bytes = include_bytes!("../../../scenes/assets/plant.v4.spz");
        let decoded = format::read(bytes, None).unwrap();
        let statistics = Statistics::of(&decoded.splats);
        assert_eq!((decoded.splats.len(), statistics.not_finite, statistics.without_rotation), (113_648, 0, 0));
        // It is one unit tall, and positions have 12 bits behind the point.
        let extent = statistics.visible_extent.unwrap();
        assert!((extent.longest() - 1.0).abs() < 0.01, "{extent:?}");
        assert!(statistics.sigma.median > 0.001 && statistics.sigma.median < 0.01, "{:?}", statistics.sigma);
        let up = Up::of(&decoded.splats, &decoded.notes);
        assert_eq!((up.convention, up.from_ground), (Some("+y"), None), "it stands on nothing");
        assert_eq!(suspicions(&decoded.splats, &statistics, "ply"), Vec::<String>::new());
    }

    #[test]
    fn numbers_have_four_digits() {
        let cases = [(0.0, "0"), (0.123_456, "0.1235"), (-12.3456, "-12.35"), (98765.0, "98765"), (1e-9, "1.000e-9")];
        for (value, text) in cases {
            assert_eq!(short(value), text);
        }
    }
}
