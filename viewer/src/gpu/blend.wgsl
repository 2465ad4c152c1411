// Front to back, a pixel a thread; the twin of `blend.rs` and `beside.rs`.

struct Blend {
    background: vec4f,
    width: u32,
    height: u32,
    has_features: u32,
    kernel_floor: f32,
}

struct Ellipse {
    centre: vec2f,
    opacity: f32,
    depth: f32,
    conic: vec3f,
    colour: vec3f,
}

struct Feature {
    normal: vec3f,
    object: u32,
    motion: vec3f,
}

// Σ w n and Σ w z; Σ w · motion, Σ w of those that move, and the object.
struct Sums {
    normal: vec3f,
    depth: f32,
    motion: vec3f,
    object: u32,
}

const TILE: u32 = 16u;
const CUT: f32 = 1.0 / 255.0;
const CAP: f32 = 0.99;
const FINISHED: f32 = 1e-4;

@group(0) @binding(0) var<uniform> blend: Blend;
@group(0) @binding(1) var<storage, read> ellipses: array<Ellipse>;
@group(0) @binding(2) var<storage, read> features: array<Feature>;
@group(0) @binding(3) var<storage, read> lists: array<u32>;
@group(0) @binding(4) var<storage, read> ranges: array<vec2u>;
@group(0) @binding(5) var<storage, read_write> rgba: array<vec4f>;
@group(0) @binding(6) var<storage, read_write> beside: array<Sums>;

@compute @workgroup_size(16, 16)
fn draw(
    @builtin(workgroup_id) tile: vec3u,
    @builtin(num_workgroups) tiles: vec3u,
    @builtin(global_invocation_id) pixel: vec3u,
) {
    if pixel.x >= blend.width || pixel.y >= blend.height {
        return;
    }
    let place = vec2f(pixel.xy) + 0.5;
    let range = ranges[tile.y * tiles.x + tile.x];
    var through = 1.0;
    var sum = vec3f(0.0);
    var sums = Sums(vec3f(0.0), 0.0, vec3f(0.0), 0xffffffffu);
    var most = 0.0;
    for (var k = range.x; k < range.y; k++) {
        let at = lists[k];
        let ellipse = ellipses[at];
        let d = place - ellipse.centre;
        let power = (-0.5 * ellipse.conic.x * d.x - ellipse.conic.y * d.y) * d.x - 0.5 * ellipse.conic.z * d.y * d.y;
        let alpha = min(ellipse.opacity * (exp(clamp(power, -80.0, 0.0)) - blend.kernel_floor), CAP);
        if alpha < CUT {
            continue;
        }
        let next = through * (1.0 - alpha);
        if next < FINISHED {
            break;
        }
        let weight = alpha * through;
        through = next;
        sum += weight * ellipse.colour;
        if blend.has_features != 0u {
            let feature = features[at];
            sums.normal += weight * feature.normal;
            sums.depth += weight * ellipse.depth;
            sums.motion += weight * feature.motion;
            if weight > most {
                most = weight;
                sums.object = feature.object;
            }
        }
    }
    let out = pixel.y * blend.width + pixel.x;
    rgba[out] = vec4f(sum + through * blend.background.xyz, 1.0 - through);
    if blend.has_features != 0u {
        beside[out] = sums;
    }
}
