//! What a capture becomes, as a picture: what is kept, what is dropped, and the particles.

use std::io::Cursor;
use std::path::Path;

use cosplat_core::scene::{Body, Fill, Scene, Source};
use cosplat_splat::stage::Staged;
use cosplat_splat::{Splats, dc_of_colour, logit_of_opacity, merge};
use cosplat_viewer::{Options, Picture, png, render};

use super::splat::cut::particles;
use super::splat::look::{LookArgs, camera};
use super::splat::put;
use super::splat::statistics::Extent;
use crate::exit::{Code, Error, Problem};
use crate::frames::borrowed;
use crate::geometry;
use crate::scene_source;

/// Side of each of the three pictures of a capture.
const SIDE_PX: usize = 480;
/// Colour of what was dropped, display values.
const DROPPED: [f64; 3] = [0.9, 0.1, 0.1];

/// Opacity in which it is shown.
const MARKED: f64 = 0.4;

/// Draws each capture of a scene into a folder: its file's name, `BODY.png`, by body.
///
/// # Errors
/// The folder cannot be made, or a picture cannot be drawn or written.
pub(super) fn draw(
    scene: &Scene,
    source: &scene_source::Source,
    folder: &Path,
) -> Result<Vec<(String, String)>, Error> {
    let captures: Vec<&Body> = scene.bodies.iter().filter(|b| matches!(b.source, Source::Splat { .. })).collect();
    if !captures.is_empty() {
        std::fs::create_dir_all(folder).map_err(|e| {
            let problem = Problem::new(format!("Cannot create `{}`", folder.display())).at(folder).because(e);
            Error::new(Code::Environment, problem.hint("give `--draw` a folder that you may write to"))
        })?;
    }
    let one = |body: &&Body| {
        let wrong = |why: String| {
            let problem = Problem::new(format!("Cannot draw the body `{}`", body.name)).because(why);
            Error::new(Code::Scene, problem.hint("look at the file with `cosplat splat info`"))
        };
        let path = folder.join(format!("{}.png", body.name));
        let (staged, dropped) = geometry::staged(scene, source, body).map_err(wrong)?;
        let method = if let Source::Splat { fill, .. } = body.source { fill } else { Fill::None };
        put(&path, &picture(method, &staged, &dropped).map_err(|e| wrong(e.to_string()))?)?;
        Ok((body.name.clone(), path.display().to_string()))
    };
    captures.iter().map(one).collect()
}

/// As PNG, three beside each other: what is kept; the same with what was dropped, in red; particles, cut in the middle.
fn picture(method: Fill, staged: &Staged, dropped: &Splats) -> Result<Vec<u8>, Box<dyn std::error::Error>> {
    let extent = Extent::visible(&staged.splats).ok_or("nothing is visible")?;
    let view = camera(&LookArgs::of_size([SIDE_PX; 2]), &staged.splats, &extent).view()?;
    let options = Options { background: [1.0; 3], near: 1e-6, ..Options::default() };
    let mut marked = dropped.clone();
    marked.sh_dc.fill(DROPPED.map(dc_of_colour));
    marked.sh_rest.fill([0.0; 3]);
    // Most of it was dropped because it can hardly be seen.
    marked.opacity_logits.fill(logit_of_opacity(MARKED));
    let cut = particles(method, staged, extent.centre()[1])?;
    let both = if marked.is_empty() { staged.splats.clone() } else { merge(&[&staged.splats, &marked])? };
    let columns = [&staged.splats, &both, &cut].map(|s| render(&[borrowed(s)], &view, &options));
    let row = |y: usize| columns.iter().flat_map(move |p| p.rgba[y * SIDE_PX..(y + 1) * SIDE_PX].iter().copied());
    let rgba = (0..SIDE_PX).flat_map(row).collect();
    let mut bytes = Cursor::new(Vec::new());
    png::encode(&mut bytes, &Picture { width: 3 * SIDE_PX, height: SIDE_PX, rgba, depth: Vec::new() })?;
    Ok(bytes.into_inner())
}
