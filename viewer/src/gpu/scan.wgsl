// Sums of all numbers before each: blocks of 1024, then the sums of blocks in the same way, then both together.

struct Scan {
    count: u32,
}

const WIDE: u32 = 256u;
const EACH: u32 = 4u;

@group(0) @binding(0) var<uniform> scan: Scan;
@group(0) @binding(1) var<storage, read_write> values: array<u32>;
@group(0) @binding(2) var<storage, read_write> sums: array<u32>;

var<workgroup> part: array<u32, WIDE>;

@compute @workgroup_size(256)
fn scan_blocks(
    @builtin(workgroup_id) block: vec3u,
    @builtin(num_workgroups) blocks: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let number = block.y * blocks.x + block.x;
    let start = (number * WIDE + local) * EACH;
    var own = 0u;
    for (var k = start; k < min(start + EACH, scan.count); k++) {
        own += values[k];
    }
    part[local] = own;
    workgroupBarrier();
    for (var step = 1u; step < WIDE; step *= 2u) {
        var before = 0u;
        if local >= step {
            before = part[local - step];
        }
        workgroupBarrier();
        part[local] += before;
        workgroupBarrier();
    }
    var sum = part[local] - own;
    for (var k = start; k < min(start + EACH, scan.count); k++) {
        let value = values[k];
        values[k] = sum;
        sum += value;
    }
    if local == WIDE - 1u && number < arrayLength(&sums) {
        sums[number] = sum;
    }
}

@compute @workgroup_size(256)
fn add_sums(
    @builtin(workgroup_id) block: vec3u,
    @builtin(num_workgroups) blocks: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let number = block.y * blocks.x + block.x;
    let start = (number * WIDE + local) * EACH;
    for (var k = start; k < min(start + EACH, scan.count); k++) {
        values[k] += sums[number];
    }
}
