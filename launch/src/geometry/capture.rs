//! Captures: Gaussians in metres, particles inside them, and what ties the two.

use cosplat_core::asset::Asset;
use cosplat_core::scene::{Body, Source};
use cosplat_splat::format;
use cosplat_splat::stage::{Recipe, Report, Staged};

use super::{Made, Maker, files};
use crate::frames::Look;

impl Maker<'_> {
    pub(super) fn capture(&self, body: &Body) -> Result<Made, String> {
        let Source::Splat { file, metres_per_unit, up, min_opacity, keep_box } = &body.source else {
            return Err("its source is no capture".to_owned());
        };
        let spacing = body.spacing_m.ok_or(
            "a capture needs `spacing`, the distance of its particles in metres: about a fortieth of its size",
        )?;
        let (bytes, path) = files::read(self.source, file)?;
        let ending = path.extension().and_then(|e| e.to_str());
        let decoded = format::read(&bytes, ending).map_err(|e| e.in_file(path.display().to_string()).to_string())?;
        let recipe = Recipe {
            min_opacity: *min_opacity,
            keep_box: *keep_box,
            ..Recipe::new(*metres_per_unit, axis(up), spacing)
        };
        let staged = Staged::new(decoded, &recipe).map_err(|e| format!("`{}`: {e}", path.display()))?;
        let notes = notes(&staged.report, staged.cloud.position_m.len());
        let asset = Some(Asset::Particles(staged.cloud.clone()));
        Ok(Made { asset, look: self.draws.then(|| Look::Capture(Box::new(staged))), notes })
    }
}

fn notes(report: &Report, particles: usize) -> Vec<String> {
    let bound = report.visible - report.visible_unbound;
    let share = 100.0 * bound as f64 / report.visible.max(1) as f64;
    let [low, high] = report.box_m.map(|c| c.map(|v| format!("{v:.3}")).join(", "));
    let mut notes = vec![
        report.clean.to_string(),
        format!("{particles} particles; {share:.1} % of {} visible Gaussians follow them", report.visible),
        format!("visible from [{low}] to [{high}] m in its own frame"),
    ];
    notes.extend(report.notes.iter().cloned());
    notes
}

/// Direction of an axis as scenes name it.
pub(super) fn axis(name: &str) -> [f64; 3] {
    let sign = if name.starts_with('-') { -1.0 } else { 1.0 };
    match name.as_bytes().last() {
        Some(b'x') => [sign, 0.0, 0.0],
        Some(b'y') => [0.0, sign, 0.0],
        _ => [0.0, 0.0, sign],
    }
}
