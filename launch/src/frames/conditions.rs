//! What a video model is conditioned on: of each frame the depth, which body is seen, and the flow to the next frame.

use std::path::{Path, PathBuf};

use cosplat_core::plan::LeftOut;
use cosplat_core::scene::Preset;
use cosplat_splat::Splats;
use cosplat_viewer::gpu::Renderer;
use cosplat_viewer::{Form, Gaussians, Next, Options, Plane, View};
use serde::Serialize;

use super::body::{Player, borrowed};
use crate::folder::CONDITIONS;

/// The last frame that was seen; its flow is known when the next one comes.
struct Held {
    number: u64,
    view: View,
    splats: Vec<Splats>,
}

/// Writes the by-products of frames.
pub(super) struct Conditions {
    folder: PathBuf,
    /// Of the frame in which is drawn.
    metres_per_unit: f64,
    held: Option<Held>,
}

/// `about.json`: what the files mean.
#[derive(Serialize)]
struct About {
    frames: u64,
    frames_per_second: f64,
    size_px: [u32; 2],
    colour: &'static str,
    flow: &'static str,
    depth: &'static str,
    mask: &'static str,
    bodies: Vec<Body>,
}

#[derive(Serialize)]
struct Body {
    name: String,
    /// Its number in a mask.
    value: usize,
    /// Whether a solver moves it.
    moves: bool,
}

impl Conditions {
    pub(super) fn new(folder: &Path, metres_per_unit: f64) -> Self {
        Self { folder: folder.join(CONDITIONS), metres_per_unit, held: None }
    }

    /// Takes a frame, and writes the one before.
    pub(super) fn take(
        &mut self,
        renderer: &mut Renderer,
        options: &Options,
        (number, view): (u64, View),
        players: &[Player<'_>],
    ) -> Result<(), String> {
        let now = Held { number, view, splats: players.iter().map(|p| p.splats.clone()).collect() };
        if let Some(before) = self.held.take() {
            let positions = now.splats.iter().map(|s| s.positions.as_slice()).collect();
            self.write(renderer, options, &before, Some(&Next { positions, view }))?;
        }
        self.held = Some(now);
        Ok(())
    }

    /// Writes the last frame, which has no flow, and what the files mean.
    pub(super) fn finish(
        &mut self,
        renderer: &mut Renderer,
        options: &Options,
        preset: Preset,
        frames_per_second: f64,
        players: &[Player<'_>],
    ) -> Result<(), String> {
        let Some(last) = self.held.take() else { return Ok(()) };
        self.write(renderer, options, &last, None)?;
        let body = |(i, player): (usize, &Player<'_>)| Body {
            name: player.name().to_owned(),
            value: i + 1,
            moves: !player.is_still(),
        };
        let about = About {
            frames: last.number + 1,
            frames_per_second,
            size_px: preset.size_px(),
            colour: "frames/frame_NNNN.png: 8 bits, sRGB",
            flow: "flow_NNNN.flo: pixels right and down to the next frame, 1e10 where nothing is seen",
            depth: "depth_NNNN.npy: metres along the optical axis, infinite where nothing is seen",
            mask: "mask_NNNN.png: 16 bits, the number of the body that is seen, 0 where none is",
            bodies: players.iter().enumerate().map(body).collect(),
        };
        let text = serde_json::to_string_pretty(&about).map_err(|e| e.to_string())? + "\n";
        self.put("about.json", text.as_bytes())
    }

    fn write(
        &self,
        renderer: &mut Renderer,
        options: &Options,
        frame: &Held,
        next: Option<&Next<'_>>,
    ) -> Result<(), String> {
        let sets: Vec<Gaussians<'_>> = frame.splats.iter().map(borrowed).collect();
        let mut layers = renderer.render_layers(&sets, &frame.view, options, next).map_err(|e| e.to_string())?;
        for depth in &mut layers.picture.depth {
            *depth = (f64::from(*depth) * self.metres_per_unit) as f32;
        }
        let mut files = vec![("depth", "npy", Plane::Depth, Form::Npy), ("mask", "png", Plane::Object, Form::Png)];
        files.extend(next.map(|_| ("flow", "flo", Plane::Flow, Form::Flo)));
        for (name, ending, plane, form) in files {
            let bytes = layers.encode(plane, form).map_err(|e| e.to_string())?;
            self.put(&format!("{name}_{:04}.{ending}", frame.number), &bytes)?;
        }
        Ok(())
    }

    fn put(&self, name: &str, bytes: &[u8]) -> Result<(), String> {
        let path = self.folder.join(name);
        std::fs::write(&path, bytes).map_err(|e| format!("cannot write `{}`: {e}", path.display()))
    }
}

/// The frame before a run was resumed is known to its earlier life alone, which had not seen the one behind it.
pub(super) fn lost_at(taken: u64) -> Option<LeftOut> {
    let number = taken.checked_sub(1)?;
    Some(LeftOut {
        what: format!("depth, mask and flow of frame {number} in `{CONDITIONS}/`"),
        why: "the run was resumed behind it, and they are made when the next frame is known".to_owned(),
        indicator: None,
        limit: None,
        saved: "nothing".to_owned(),
    })
}
