//! What a viewer shows first.

use cosplat_core::scene::{OutputSpec, RendererSpec};
use cosplat_viewer::gpu::{Choice, Renderer};
use cosplat_viewer::recording::Layout;
use cosplat_viewer::{Camera, Options};

use super::files::Wanted;
use super::rows::CURVES;

/// What a layout is made from.
#[derive(Clone, Debug)]
pub(super) struct Stage {
    scene: String,
    run: String,
    camera: Camera,
    background: [f32; 3],
}

impl Stage {
    pub(super) fn new(wanted: &Wanted) -> Self {
        let Wanted { scene, run, output, shot, .. } = wanted;
        Self { scene: scene.clone(), run: run.clone(), camera: shot.at(0.0), background: options(output).background }
    }

    pub(super) fn layout(&self) -> Layout<'_> {
        Layout {
            scene: &self.scene,
            run: &self.run,
            up: self.camera.up,
            camera: Some(&self.camera),
            background: self.background,
            curves: &CURVES,
        }
    }
}

/// How pictures are drawn.
pub(super) fn options(output: &OutputSpec) -> Options {
    let linear = output.camera.as_ref().map_or([1.0; 3], |c| c.background);
    Options::default().with_linear_background(linear)
}

/// Who draws.
///
/// # Errors
/// In words, where a graphics processor is asked for and there is none.
pub(super) fn renderer(output: &OutputSpec) -> Result<Renderer, String> {
    let wanted = if output.pictures { output.renderer } else { RendererSpec::Cpu };
    let choice = match wanted {
        RendererSpec::Cpu => Choice::Cpu,
        RendererSpec::Gpu => Choice::Gpu,
        RendererSpec::Auto => Choice::Auto,
    };
    Renderer::new(choice).map_err(|e| format!("`output.renderer`: {e}"))
}
