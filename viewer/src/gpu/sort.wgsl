// One pass of a stable radix sort by four bits (Satish, Harris and Garland 2009): a block counts its digits, the counts
// are summed over all blocks, and each block puts its elements behind those of smaller digits and earlier blocks.

struct Pass {
    count: u32,
    shift: u32,
    blocks: u32,
}

const WIDE: u32 = 64u;
const EACH: u32 = 16u;
const DIGITS: u32 = 16u;

@group(0) @binding(0) var<uniform> pass_: Pass;
@group(0) @binding(1) var<storage, read> keys: array<u32>;
// By digit, then by block.
@group(0) @binding(2) var<storage, read_write> places: array<u32>;
@group(0) @binding(3) var<storage, read> values: array<u32>;
@group(0) @binding(4) var<storage, read_write> sorted_keys: array<u32>;
@group(0) @binding(5) var<storage, read_write> sorted_values: array<u32>;

// By digit, then by thread; a thread has a run of elements, so that equal digits keep their order.
var<workgroup> counts: array<u32, 1024>;

fn digit(i: u32) -> u32 {
    return (keys[i] >> pass_.shift) & (DIGITS - 1u);
}

fn count(start: u32, local: u32) {
    for (var d = 0u; d < DIGITS; d++) {
        counts[d * WIDE + local] = 0u;
    }
    for (var i = start; i < min(start + EACH, pass_.count); i++) {
        counts[digit(i) * WIDE + local] += 1u;
    }
}

@compute @workgroup_size(64)
fn count_digits(
    @builtin(workgroup_id) block: vec3u,
    @builtin(num_workgroups) blocks: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let number = block.y * blocks.x + block.x;
    count((number * WIDE + local) * EACH, local);
    workgroupBarrier();
    if local < DIGITS && number < pass_.blocks {
        var sum = 0u;
        for (var k = 0u; k < WIDE; k++) {
            sum += counts[local * WIDE + k];
        }
        places[local * pass_.blocks + number] = sum;
    }
}

@compute @workgroup_size(64)
fn scatter(
    @builtin(workgroup_id) block: vec3u,
    @builtin(num_workgroups) blocks: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let number = block.y * blocks.x + block.x;
    let start = (number * WIDE + local) * EACH;
    count(start, local);
    workgroupBarrier();
    if local < DIGITS && number < pass_.blocks {
        var place = places[local * pass_.blocks + number];
        for (var k = 0u; k < WIDE; k++) {
            let own = counts[local * WIDE + k];
            counts[local * WIDE + k] = place;
            place += own;
        }
    }
    workgroupBarrier();
    for (var i = start; i < min(start + EACH, pass_.count); i++) {
        let at = digit(i) * WIDE + local;
        let place = counts[at];
        counts[at] = place + 1u;
        sorted_keys[place] = keys[i];
        sorted_values[place] = values[i];
    }
}
