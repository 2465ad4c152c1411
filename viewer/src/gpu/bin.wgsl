// Which ellipses each tile sees; the twin of `tiles.rs`.

struct Bin {
    // Gaussians, and places in the lists of all tiles together.
    count: u32,
    listed: u32,
    // Tiles in a row.
    across: u32,
}

const WIDE: u32 = 256u;
const TILE: u32 = 16u;

@group(0) @binding(0) var<uniform> bin: Bin;
// Gaussians, nearest first.
@group(0) @binding(1) var<storage, read> order: array<u32>;
@group(0) @binding(2) var<storage, read> boxes: array<vec2u>;
// Tiles of each, then of all before each.
@group(0) @binding(3) var<storage, read_write> starts: array<u32>;
// Sum of all, in 64 bits: low, high.
@group(0) @binding(4) var<storage, read_write> total: array<atomic<u32>, 2>;
@group(0) @binding(5) var<storage, read_write> tiles: array<u32>;
@group(0) @binding(6) var<storage, read_write> lists: array<u32>;
// First place in the lists and the one after the last, by tile.
@group(0) @binding(7) var<storage, read_write> ranges: array<vec2u>;

// First tiles and tiles after the last, in columns and rows.
fn tiles_of(box: vec2u) -> vec4u {
    let end = box >> vec2u(16u);
    if end.x == 0u {
        return vec4u(0u);
    }
    return vec4u((box & vec2u(0xffffu)) / TILE, (end - 1u) / TILE + 1u);
}

@compute @workgroup_size(256)
fn count_tiles(
    @builtin(workgroup_id) block: vec3u,
    @builtin(num_workgroups) blocks: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let rank = (block.y * blocks.x + block.x) * WIDE + local;
    if rank >= bin.count {
        return;
    }
    let span = tiles_of(boxes[order[rank]]);
    let number = (span.z - span.x) * (span.w - span.y);
    starts[rank] = number;
    let before = atomicAdd(&total[0], number);
    if before + number < before {
        atomicAdd(&total[1], 1u);
    }
}

@compute @workgroup_size(256)
fn list_tiles(
    @builtin(workgroup_id) block: vec3u,
    @builtin(num_workgroups) blocks: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let rank = (block.y * blocks.x + block.x) * WIDE + local;
    if rank >= bin.count {
        return;
    }
    let gaussian = order[rank];
    let span = tiles_of(boxes[gaussian]);
    var place = starts[rank];
    for (var row = span.y; row < span.w; row++) {
        for (var column = span.x; column < span.z; column++) {
            tiles[place] = row * bin.across + column;
            lists[place] = gaussian;
            place++;
        }
    }
}

@compute @workgroup_size(256)
fn find_ranges(
    @builtin(workgroup_id) block: vec3u,
    @builtin(num_workgroups) blocks: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let place = (block.y * blocks.x + block.x) * WIDE + local;
    if place >= bin.listed {
        return;
    }
    let tile = tiles[place];
    if place == 0u || tiles[place - 1u] != tile {
        ranges[tile].x = place;
    }
    if place + 1u == bin.listed || tiles[place + 1u] != tile {
        ranges[tile].y = place + 1u;
    }
}
