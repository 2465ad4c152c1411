//! Who draws: the processor or a graphics processor.

use clap::ValueEnum;
use cosplat_viewer::gpu::{Choice, GpuError, Renderer};

use crate::exit::{Code, Error, Problem};

/// Value of `--renderer`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum RendererName {
    /// The CPU: the same bytes on every machine
    #[default]
    Cpu,
    /// A graphics processor with Vulkan, also one in software; fails where there is none
    Gpu,
    /// A graphics processor if there is one in hardware, else the CPU
    Auto,
}

impl RendererName {
    /// Who draws from now on.
    ///
    /// # Errors
    /// A graphics processor was asked for and there is none.
    pub(crate) fn open(self) -> Result<Renderer, Error> {
        let choice = match self {
            Self::Cpu => Choice::Cpu,
            Self::Gpu => Choice::Gpu,
            Self::Auto => Choice::Auto,
        };
        Renderer::new(choice).map_err(|e| cannot(&e))
    }
}

/// What a renderer that was asked for could not do.
pub(super) fn cannot(error: &GpuError) -> Error {
    let problem = Problem::new("The graphics processor cannot draw this").because(error);
    Error::new(Code::Environment, problem.hint("leave `--renderer` away, or let `--renderer auto` choose"))
}
