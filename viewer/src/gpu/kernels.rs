//! The shaders, compiled, and how one is run.

use wgpu::{
    BindGroupDescriptor, BindGroupEntry, Buffer, CommandEncoder, ComputePassDescriptor, ComputePipeline,
    ComputePipelineDescriptor, Device, PipelineCompilationOptions, ShaderModule, ShaderModuleDescriptor, ShaderSource,
};

/// Work groups along one axis at most; a kernel counts on along the next.
const ALONG: u32 = 65_535;

/// All entry points.
#[derive(Debug)]
pub(super) struct Kernels {
    pub(super) project: ComputePipeline,
    pub(super) count_digits: ComputePipeline,
    pub(super) scatter: ComputePipeline,
    pub(super) scan_blocks: ComputePipeline,
    pub(super) add_sums: ComputePipeline,
    pub(super) count_tiles: ComputePipeline,
    pub(super) list_tiles: ComputePipeline,
    pub(super) find_ranges: ComputePipeline,
    pub(super) draw: ComputePipeline,
}

impl Kernels {
    pub(super) fn new(device: &Device) -> Kernels {
        let module = |text: &'static str| {
            device.create_shader_module(ShaderModuleDescriptor { label: None, source: ShaderSource::Wgsl(text.into()) })
        };
        let kernel = |module: &ShaderModule, entry: &str| {
            device.create_compute_pipeline(&ComputePipelineDescriptor {
                label: Some(entry),
                layout: None,
                module,
                entry_point: Some(entry),
                compilation_options: PipelineCompilationOptions::default(),
                cache: None,
            })
        };
        let (project, sort) = (module(include_str!("project.wgsl")), module(include_str!("sort.wgsl")));
        let (scan, bin) = (module(include_str!("scan.wgsl")), module(include_str!("bin.wgsl")));
        Kernels {
            project: kernel(&project, "project"),
            count_digits: kernel(&sort, "count_digits"),
            scatter: kernel(&sort, "scatter"),
            scan_blocks: kernel(&scan, "scan_blocks"),
            add_sums: kernel(&scan, "add_sums"),
            count_tiles: kernel(&bin, "count_tiles"),
            list_tiles: kernel(&bin, "list_tiles"),
            find_ranges: kernel(&bin, "find_ranges"),
            draw: kernel(&module(include_str!("blend.wgsl")), "draw"),
        }
    }
}

/// Work groups for so many items.
pub(super) fn groups(items: u64, each: u64) -> [u32; 2] {
    let needed = items.div_ceil(each).max(1);
    let along = needed.min(u64::from(ALONG));
    [along as u32, needed.div_ceil(along) as u32]
}

/// Records a kernel on the buffers with these binding numbers.
pub(super) fn record(
    device: &Device,
    encoder: &mut CommandEncoder,
    kernel: &ComputePipeline,
    buffers: &[(u32, &Buffer)],
    [across, down]: [u32; 2],
) {
    let entries = buffers.iter().map(|&(binding, b)| BindGroupEntry { binding, resource: b.as_entire_binding() });
    let entries: Vec<BindGroupEntry<'_>> = entries.collect();
    let layout = kernel.get_bind_group_layout(0);
    let group = device.create_bind_group(&BindGroupDescriptor { label: None, layout: &layout, entries: &entries });
    let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor::default());
    pass.set_pipeline(kernel);
    pass.set_bind_group(0, &group, &[]);
    pass.dispatch_workgroups(across, down, 1);
}
