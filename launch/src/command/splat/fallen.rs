//! The page about a drop test: pictures of all ways at the same moments, and curves.

use std::path::Path;

use cosplat_core::scene::Fill;
use cosplat_splat::stage::Staged;
use cosplat_viewer::{Camera, Options, Picture, png, render};

use super::drop::{Conditions, Fall, MOMENTS, SHOWN};
use super::look::borrowed;
use super::statistics::Extent;
use crate::page::{self, Chart, Line};

/// Side of a picture.
const SIDE_PX: usize = 240;
const FIELD_OF_VIEW_DEG: f64 = 30.0;
/// Room around what is drawn.
const MARGIN: f64 = 1.3;

/// The page as HTML.
///
/// # Errors
/// In words, where a picture cannot be drawn.
pub(super) fn page(
    file: &Path,
    conditions: &Conditions,
    bodies: &[(Fill, Staged)],
    falls: &[Fall],
) -> Result<String, String> {
    let names = ["filled by winding numbers", "as PhysGaussian fills", "hollow"];
    let mut bytes = std::io::Cursor::new(Vec::new());
    png::encode(&mut bytes, &drawn(falls)?).map_err(|e| e.to_string())?;
    let times: Vec<String> = falls
        .first()
        .map(|f| SHOWN.iter().filter_map(|&m| f.time_s.get(m)).map(|t| format!("{t:.3} s")).collect())
        .unwrap_or_default();
    let caption = format!("from the left at {}; from above: {}", times.join(", "), names.join(", "));
    let pictures = [page::Picture { caption: &caption, png: bytes.get_ref() }];
    let lines = |of: fn(&Fall) -> &Vec<f64>| -> Vec<Line<'_>> {
        let points = |f: &Fall| f.time_s.iter().copied().zip(of(f).iter().copied()).collect();
        falls.iter().zip(names).map(|(f, name)| Line { name, gate: None, points: points(f) }).collect()
    };
    let chart = |title, note, lines| Chart { title, unit: "m", logarithmic: false, note, lines };
    let charts = [
        chart("Height of the centre of mass above the ground", "", lines(|f| &f.centre_m)),
        chart("Height of the body", "From its lowest to its highest particle.", lines(|f| &f.height_m)),
        chart(
            "Width of the body",
            "Root mean square distance of its mass from the vertical line through its centre.",
            lines(|f| &f.width_m),
        ),
    ];
    let name = file.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let Conditions { height_m, density_kg_m3, youngs_modulus_pa } = conditions;
    let mut facts = vec![format!(
        "Dropped from {height_m:.3} m on a smooth plane, as an elastic body of {density_kg_m3} kg/m³ with a Young's modulus \
         of {youngs_modulus_pa:.3e} Pa, by the material point method; measured at {} moments.",
        MOMENTS + 1
    )];
    facts.extend(bodies.iter().zip(names).zip(falls).map(|(((_, body), name), fall)| {
        let [least, last] = fall.squashed().map(|part| 100.0 * part);
        let mass = body.cloud.volume_m3.iter().sum::<f64>() * density_kg_m3;
        let particles = body.cloud.position_m.len();
        format!("{name}: {particles} particles, {mass:.4} kg, squashed to {least:.0} % of its height, {last:.0} % at the end.")
    }));
    Ok(page::drop::html(&format!("Drop test of {name}"), &facts, &pictures, &charts))
}

/// A row a way, a column a moment, all by one camera from the front.
fn drawn(falls: &[Fall]) -> Result<Picture, String> {
    let seen: Vec<Extent> = falls.iter().flat_map(|f| &f.shown).filter_map(Extent::visible).collect();
    let [low, high] = [
        [0, 1, 2].map(|k| seen.iter().map(|e| e.low[k]).fold(f64::INFINITY, f64::min)),
        [0, 1, 2].map(|k| seen.iter().map(|e| e.high[k]).fold(f64::NEG_INFINITY, f64::max)),
    ];
    let target = [0, 1, 2].map(|k| f64::midpoint(low[k], high[k]));
    let size = (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max);
    let away = MARGIN * size / 2.0 / (FIELD_OF_VIEW_DEG.to_radians() / 2.0).tan() + (high[1] - low[1]) / 2.0;
    let camera = Camera {
        eye: [target[0], target[1] - away, target[2] + 0.15 * away],
        target,
        up: [0.0, 0.0, 1.0],
        fov_y_deg: FIELD_OF_VIEW_DEG,
        width: SIDE_PX,
        height: SIDE_PX,
    };
    let view = camera.view().map_err(|e| e.to_string())?;
    let options = Options { background: [1.0; 3], near: 1e-6, ..Options::default() };
    let (across, down) = (SHOWN.len(), falls.len());
    let mut rgba = vec![[1.0; 4]; across * down * SIDE_PX * SIDE_PX];
    for (row, fall) in falls.iter().enumerate() {
        for (column, splats) in fall.shown.iter().enumerate() {
            let picture = render(&[borrowed(splats)], &view, &options);
            for (y, line) in picture.rgba.chunks(SIDE_PX).enumerate() {
                let at = ((row * SIDE_PX + y) * across + column) * SIDE_PX;
                rgba[at..at + SIDE_PX].copy_from_slice(line);
            }
        }
    }
    Ok(Picture { width: across * SIDE_PX, height: down * SIDE_PX, rgba, depth: Vec::new() })
}
