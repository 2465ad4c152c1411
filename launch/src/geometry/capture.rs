//! Captures: Gaussians in metres, particles inside them, and what ties the two.

use std::path::PathBuf;

use cosplat_core::asset::Asset;
use cosplat_core::scene::{Body, Source};
use cosplat_splat::clean::{Rules, clean};
use cosplat_splat::format::{self, Decoded, ending_of};
use cosplat_splat::stage::{Recipe, Report, Staged};
use cosplat_splat::{Axes, Similarity, SplatError, Splats};

use super::up::{axis, stated_or};
use super::{Made, Maker, files};
use crate::frames::Look;

impl Maker<'_> {
    pub(super) fn capture(&self, body: &Body) -> Result<Made, String> {
        let (decoded, recipe, assumed, path) = self.decoded(body)?;
        let staged = Staged::new(decoded, &recipe).map_err(|e| format!("`{}`: {e}", path.display()))?;
        let mut notes = notes(&staged.report, staged.cloud.position_m.len());
        notes.extend(assumed);
        let asset = Some(Asset::Particles(staged.cloud.clone()));
        Ok(Made { asset, look: self.draws.then(|| Look::Capture(Box::new(staged))), notes })
    }

    /// The body, and what of its file was dropped, in the body's frame.
    pub(super) fn with_dropped(&self, body: &Body) -> Result<(Staged, Splats), String> {
        let (decoded, recipe, _, path) = self.decoded(body)?;
        let (kept, _) = clean(&decoded.splats, &recipe.rules());
        let (finite, _) = clean(&decoded.splats, &Rules { opacity: 0.0, ..Rules::default() });
        let dropped: Vec<u32> = finite.into_iter().filter(|i| kept.binary_search(i).is_err()).collect();
        let mut dropped = decoded.splats.select(&dropped);
        let staged = Staged::new(decoded, &recipe).map_err(|e| format!("`{}`: {e}", path.display()))?;
        staged.similarity.apply(&mut dropped, Axes::Scene);
        Ok((staged, dropped))
    }

    /// The Gaussians that a mesh wears: those of `file` that can be seen, in the frame of the body that the mesh becomes.
    /// Both files have one frame, so that what turns and scales the mesh turns and scales them.
    pub(super) fn worn(&self, mesh: &Source, file: &str) -> Result<Splats, String> {
        let Source::Mesh { file: of_mesh, metres_per_unit, up } = mesh else {
            return Err("its source is no mesh".to_owned());
        };
        let (bytes, path) = files::read(self.source, file)?;
        let splats = format::read(&bytes, ending_of(&path))
            .map_err(|e| e.in_file(path.display().to_string()).to_string())?
            .splats;
        let (kept, counted) = clean(&splats, &Rules::default());
        if kept.is_empty() {
            return Err(format!("`{}`: nothing of it can be seen: {counted}", path.display()));
        }
        let mut splats = splats.select(&kept);
        let up = self.up_of_mesh(of_mesh, up)?;
        let similarity = Similarity::upright(axis(&up), *metres_per_unit).map_err(|e| e.to_string())?;
        similarity.apply(&mut splats, Axes::Scene);
        Ok(splats)
    }

    /// The file of a capture, what is to be made of it, and a sentence about its up axis.
    fn decoded(&self, body: &Body) -> Result<(Decoded, Recipe, Option<String>, PathBuf), String> {
        let Source::Splat { file, metres_per_unit, up, min_opacity, keep_box, fill } = &body.source else {
            return Err("its source is no capture".to_owned());
        };
        let spacing = body.spacing_m.ok_or(
            "a capture needs `spacing`, the distance of its particles in metres: about a fortieth of its size",
        )?;
        let (bytes, path) = files::read(self.source, file)?;
        let ending = ending_of(&path);
        let named = |e: SplatError| e.in_file(path.display().to_string()).to_string();
        let known = format::of(&bytes, ending).map_err(named)?;
        let decoded = format::read(&bytes, ending).map_err(named)?;
        let (up, assumed) = stated_or(up, decoded.splats.axes.up(), known.name);
        let recipe = Recipe {
            min_opacity: *min_opacity,
            keep_box: *keep_box,
            method: *fill,
            binding: self.bindings.get(&body.name).map(|b| b.spec).unwrap_or_default(),
            ..Recipe::new(*metres_per_unit, axis(up), spacing)
        };
        Ok((decoded, recipe, assumed, path))
    }
}

fn notes(report: &Report, particles: usize) -> Vec<String> {
    let bound = report.visible - report.visible_unbound;
    let share = 100.0 * bound as f64 / report.visible.max(1) as f64;
    let [low, high] = report.box_m.map(|c| c.map(|v| format!("{v:.3}")).join(", "));
    let mut notes = vec![
        report.clean.to_string(),
        format!(
            "{particles} particles: {} inside, {} on the surface, {} between pieces; {} cells of specks left out",
            report.cloud.inside, report.cloud.sheet, report.cloud.bridges, report.cloud.stray
        ),
        format!("{share:.1} % of {} visible Gaussians follow them", report.visible),
        format!("visible from [{low}] to [{high}] m in its own frame"),
    ];
    if report.cloud.closed_m2 > 0.0 {
        let square_cm = 1e4 * report.cloud.closed_m2;
        notes.push(format!("its underside, which no camera saw, is closed with {square_cm:.1} cm²"));
    }
    notes.extend(report.notes.iter().cloned());
    notes
}
