//! Opening a device, buffers, and what can go wrong.

use std::pin::pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll, Waker};
use std::time::Duration;

use thiserror::Error;
use wgpu::{Buffer, BufferDescriptor, BufferUsages, CommandEncoder, Device, Queue};

use crate::gaussians::LengthError;

use super::kernels::Kernels;

/// How long a picture may take.
const PATIENCE: Duration = Duration::from_mins(2);

/// Numbers of the largest element of any binding.
const LEAST: u64 = 16;

/// Why a graphics processor cannot draw.
#[derive(Clone, Debug, Error)]
pub enum GpuError {
    /// There is none that can compute.
    #[error(
        "no graphics processor with Vulkan is found ({0}); install its driver, or `mesa-vulkan-drivers` to try it in software"
    )]
    NoAdapter(String),
    /// It cannot be opened.
    #[error("the graphics processor `{0}` cannot be used: {1}")]
    Device(String, String),
    /// A buffer would be larger than it allows.
    #[error("{what} need {bytes} bytes and the graphics processor allows {limit}; draw with the CPU renderer")]
    TooLarge {
        /// What is too large.
        what: &'static str,
        /// Its size.
        bytes: u64,
        /// The largest that is allowed.
        limit: u64,
    },
    /// It gave up, was lost or ran out of memory.
    #[error("the graphics processor failed: {0}; draw with the CPU renderer")]
    Failed(String),
    /// The next moment is not one of these sets.
    #[error(transparent)]
    Next(#[from] LengthError),
}

/// A graphics processor that draws.
#[derive(Debug)]
pub struct Gpu {
    pub(super) device: Device,
    pub(super) queue: Queue,
    pub(super) kernels: Kernels,
    about: String,
    is_software: bool,
    largest: u64,
    /// What was said outside any call, first first.
    said: Arc<Mutex<Option<String>>>,
}

impl Gpu {
    /// Opens the fastest one, or one in software where there is no other.
    ///
    /// # Errors
    /// There is none, or it cannot be opened.
    pub fn open() -> Result<Gpu, GpuError> {
        let mut description = wgpu::InstanceDescriptor::new_without_display_handle();
        description.backends = wgpu::Backends::VULKAN;
        let instance = wgpu::Instance::new(description);
        let options = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            ..wgpu::RequestAdapterOptions::default()
        };
        let adapter = wait(instance.request_adapter(&options)).map_err(|e| GpuError::NoAdapter(e.to_string()))?;
        let info = adapter.get_info();
        let is_software = info.device_type == wgpu::DeviceType::Cpu;
        let about = format!("{}, Vulkan, {}", info.name, if is_software { "software" } else { "hardware" });
        let limits = adapter.limits();
        let largest = limits.max_buffer_size.min(limits.max_storage_buffer_binding_size);
        let description = wgpu::DeviceDescriptor {
            label: Some("cosplat"),
            required_limits: limits,
            ..wgpu::DeviceDescriptor::default()
        };
        let (device, queue) =
            wait(adapter.request_device(&description)).map_err(|e| GpuError::Device(about.clone(), e.to_string()))?;
        let said = Arc::new(Mutex::new(None));
        let hears = Arc::clone(&said);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            hears.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert_with(|| error.to_string());
        }));
        let kernels = Kernels::new(&device);
        let gpu = Gpu { device, queue, kernels, about, is_software, largest, said };
        gpu.complaint()?;
        Ok(gpu)
    }

    /// Its name, interface and kind.
    pub fn about(&self) -> &str {
        &self.about
    }

    /// Whether it is the processor after all, by a driver in software.
    pub fn is_software(&self) -> bool {
        self.is_software
    }

    /// What went wrong since this was last asked.
    pub(super) fn complaint(&self) -> Result<(), GpuError> {
        let said = self.said.lock().unwrap_or_else(PoisonError::into_inner).take();
        said.map_or(Ok(()), |said| Err(GpuError::Failed(said)))
    }

    /// A buffer of zeros for so many numbers of 32 bits.
    pub(super) fn zeros(&self, what: &'static str, numbers: u64) -> Result<Buffer, GpuError> {
        // Bindings must hold one element at least.
        let size = 4 * numbers.max(LEAST);
        if size > self.largest {
            return Err(GpuError::TooLarge { what, bytes: size, limit: self.largest });
        }
        let usage = BufferUsages::STORAGE | BufferUsages::UNIFORM | BufferUsages::COPY_DST | BufferUsages::COPY_SRC;
        Ok(self.device.create_buffer(&BufferDescriptor { label: Some(what), size, usage, mapped_at_creation: false }))
    }

    /// A buffer with these bytes, a multiple of four.
    pub(super) fn filled(&self, what: &'static str, bytes: &[u8]) -> Result<Buffer, GpuError> {
        let buffer = self.zeros(what, bytes.len() as u64 / 4)?;
        self.queue.write_buffer(&buffer, 0, bytes);
        Ok(buffer)
    }

    /// Runs what was recorded and reads buffers back.
    pub(super) fn finish(&self, mut encoder: CommandEncoder, wanted: &[&Buffer]) -> Result<Vec<Vec<u32>>, GpuError> {
        let usage = BufferUsages::MAP_READ | BufferUsages::COPY_DST;
        let staged = wanted.iter().map(|from| {
            let description = BufferDescriptor { label: None, size: from.size(), usage, mapped_at_creation: false };
            let to = self.device.create_buffer(&description);
            encoder.copy_buffer_to_buffer(from, 0, &to, 0, from.size());
            to
        });
        let staged: Vec<Buffer> = staged.collect();
        self.queue.submit([encoder.finish()]);
        for buffer in &staged {
            // Whether it worked is seen when the range is asked for.
            buffer.slice(..).map_async(wgpu::MapMode::Read, |_| ());
        }
        let poll = wgpu::PollType::Wait { submission_index: None, timeout: Some(PATIENCE) };
        self.device.poll(poll).map_err(|e| GpuError::Failed(e.to_string()))?;
        self.complaint()?;
        let read = |buffer: &Buffer| {
            let view = buffer.slice(..).get_mapped_range().map_err(|e| GpuError::Failed(e.to_string()))?;
            Ok(bytemuck::pod_collect_to_vec::<u8, u32>(&view))
        };
        staged.iter().map(read).collect()
    }
}

/// The value of a future of wgpu, which on machines with an operating system is there at once.
fn wait<T>(future: impl Future<Output = T>) -> T {
    let mut future = pin!(future);
    loop {
        if let Poll::Ready(value) = future.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
            return value;
        }
        std::thread::yield_now();
    }
}
