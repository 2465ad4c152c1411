//! Which of the two draws.

use crate::camera::View;
use crate::gaussians::Gaussians;
use crate::layers::{Layers, Next};
use crate::picture::Picture;
use crate::render::{Options, render, render_layers};

use super::device::{Gpu, GpuError};

/// Who is asked to draw.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Choice {
    /// The processor: the same bytes on every machine.
    #[default]
    Cpu,
    /// A graphics processor, also one in software; an error where it cannot.
    Gpu,
    /// A graphics processor that is one, or the processor.
    Auto,
}

/// Who draws, and why.
#[derive(Debug)]
pub struct Renderer {
    gpu: Option<Gpu>,
    why: String,
    /// Whether the processor takes over what the other cannot do.
    may_change: bool,
}

impl Renderer {
    /// The one that was asked for. A graphics processor is looked for here and at no other place.
    ///
    /// # Errors
    /// A graphics processor was asked for and there is none.
    pub fn new(choice: Choice) -> Result<Renderer, GpuError> {
        let may_change = choice == Choice::Auto;
        let cpu = |why: String| Renderer { gpu: None, why, may_change };
        match choice {
            Choice::Cpu => Ok(cpu("the CPU, which gives the same bytes everywhere".to_owned())),
            Choice::Gpu => Gpu::open().map(|gpu| Renderer { why: gpu.about().to_owned(), gpu: Some(gpu), may_change }),
            Choice::Auto => Ok(match Gpu::open() {
                Ok(gpu) if gpu.is_software() => cpu(format!("the CPU, because {} would be slower", gpu.about())),
                Ok(gpu) => Renderer { why: gpu.about().to_owned(), gpu: Some(gpu), may_change },
                Err(error) => cpu(format!("the CPU, because {error}")),
            }),
        }
    }

    /// `gpu` or `cpu`.
    pub fn name(&self) -> &'static str {
        if self.gpu.is_some() { "gpu" } else { "cpu" }
    }

    /// Who draws and, where it was not simply asked for, why.
    pub fn why(&self) -> &str {
        &self.why
    }

    /// As [`render`].
    ///
    /// # Errors
    /// The graphics processor that was asked for cannot do it.
    ///
    /// # Panics
    /// A set for which [`Gaussians::check`] fails.
    pub fn render(&mut self, sets: &[Gaussians<'_>], view: &View, options: &Options) -> Result<Picture, GpuError> {
        match self.on_gpu(|gpu| gpu.render(sets, view, options))? {
            Some(picture) => Ok(picture),
            None => Ok(render(sets, view, options)),
        }
    }

    /// As [`render_layers`].
    ///
    /// # Errors
    /// The next moment is not one of these sets, or the graphics processor that was asked for cannot do it.
    ///
    /// # Panics
    /// A set for which [`Gaussians::check`] fails.
    pub fn render_layers(
        &mut self,
        sets: &[Gaussians<'_>],
        view: &View,
        options: &Options,
        next: Option<&Next<'_>>,
    ) -> Result<Layers, GpuError> {
        match self.on_gpu(|gpu| gpu.render_layers(sets, view, options, next))? {
            Some(layers) => Ok(layers),
            None => Ok(render_layers(sets, view, options, next)?),
        }
    }

    /// What the graphics processor makes, if it is it that draws. Where it may be left, it is left for good: pictures of
    /// one film come from as few hands as can be.
    fn on_gpu<T>(&mut self, make: impl FnOnce(&Gpu) -> Result<T, GpuError>) -> Result<Option<T>, GpuError> {
        let Some(gpu) = &self.gpu else { return Ok(None) };
        match make(gpu) {
            Ok(made) => Ok(Some(made)),
            Err(GpuError::Next(error)) => Err(error.into()),
            Err(error) if self.may_change => {
                self.why = format!("the CPU, because {error}");
                self.gpu = None;
                Ok(None)
            }
            Err(error) => Err(error),
        }
    }
}
