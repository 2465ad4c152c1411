// From a Gaussian in space to an ellipse in the picture; the twin of `project.rs`, in single precision.

struct Group {
    // Rows right, down, forward of the camera, now and at the next moment.
    rows: array<vec4f, 3>,
    next_rows: array<vec4f, 3>,
    // Width and height, focal length [pixels], nearest distance.
    lens: vec4f,
    next_lens: vec4f,
    // Dilation [pixels²], kernel floor.
    kernel: vec4f,
    // Gaussians before this set, in it, coefficients above the base band, place of the set.
    first: u32,
    count: u32,
    coefficients: u32,
    object: u32,
    // Flags.
    antialiased: u32,
    has_features: u32,
    has_next: u32,
    unused: u32,
}

struct Ellipse {
    centre: vec2f,
    opacity: f32,
    depth: f32,
    // Inverse covariance (x y; y z), per pixel².
    conic: vec3f,
    colour: vec3f,
}

struct Feature {
    normal: vec3f,
    object: u32,
    motion: vec3f,
}

const WIDE: u32 = 256u;
const CUT: f32 = 1.0 / 255.0;
// Widening of the box, in pixels, so that rounding never loses a pixel that the cut would keep.
const SLACK: f32 = 0.01;
// Sorts behind every depth.
const UNSEEN: u32 = 0xffffffffu;
// Above this, products overflow.
const LARGEST: f32 = 1e37;

@group(0) @binding(0) var<uniform> group: Group;
// Five a Gaussian: from the eye and logit; rotation w x y z of length one; logarithms of scales; base band; from the
// next eye.
@group(0) @binding(1) var<storage, read> shapes: array<vec4f>;
@group(0) @binding(2) var<storage, read> bands: array<f32>;
@group(0) @binding(3) var<storage, read_write> ellipses: array<Ellipse>;
// First pixels and pixels after the last, in 16 bits each: columns, rows.
@group(0) @binding(4) var<storage, read_write> boxes: array<vec2u>;
@group(0) @binding(5) var<storage, read_write> keys: array<u32>;
@group(0) @binding(6) var<storage, read_write> order: array<u32>;
@group(0) @binding(7) var<storage, read_write> features: array<Feature>;

fn columns_of(q: vec4f) -> mat3x3f {
    let w = q.x;
    let x = q.y;
    let y = q.z;
    let z = q.w;
    return mat3x3f(
        vec3f(1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)),
        vec3f(2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)),
        vec3f(2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)),
    );
}

fn band(i: u32, j: u32) -> vec3f {
    let at = 3u * (i * group.coefficients + j);
    return vec3f(bands[at], bands[at + 1u], bands[at + 2u]);
}

// max(0, ½ + Y₀ dc + Σ Yⱼ(d) cⱼ), with the constants, signs and order of Kerbl et al. (2023).
fn colour(i: u32, dc: vec3f, d: vec3f) -> vec3f {
    var sum = vec3f(0.5) + 0.28209479 * dc;
    let x = d.x;
    let y = d.y;
    let z = d.z;
    if group.coefficients >= 3u {
        sum += 0.48860251 * (-y * band(i, 0u) + z * band(i, 1u) - x * band(i, 2u));
    }
    let xx = x * x;
    let yy = y * y;
    let zz = z * z;
    if group.coefficients >= 8u {
        sum += 1.0925484 * (x * y * band(i, 3u) - y * z * band(i, 4u) - x * z * band(i, 6u));
        sum += 0.31539157 * (2.0 * zz - xx - yy) * band(i, 5u) + 0.54627422 * (xx - yy) * band(i, 7u);
    }
    if group.coefficients >= 15u {
        sum -= 0.59004359 * (y * (3.0 * xx - yy) * band(i, 8u) + x * (xx - 3.0 * yy) * band(i, 14u));
        sum += 2.8906114 * x * y * z * band(i, 9u) + 1.4453057 * z * (xx - yy) * band(i, 13u);
        sum -= 0.4570458 * (4.0 * zz - xx - yy) * (y * band(i, 10u) + x * band(i, 12u));
        sum += 0.37317633 * z * (2.0 * zz - 3.0 * xx - 3.0 * yy) * band(i, 11u);
    }
    return max(sum, vec3f(0.0));
}

fn normal(turn: mat3x3f, scales: vec3f, from_eye: vec3f) -> vec3f {
    var axis = turn[0];
    var least = scales.x;
    if scales.y < least {
        axis = turn[1];
        least = scales.y;
    }
    if scales.z < least {
        axis = turn[2];
    }
    return select(axis, -axis, dot(axis, from_eye) > 0.0);
}

fn motion(from_next_eye: vec3f, centre: vec2f) -> vec3f {
    let x = dot(group.next_rows[0].xyz, from_next_eye);
    let y = dot(group.next_rows[1].xyz, from_next_eye);
    let z = dot(group.next_rows[2].xyz, from_next_eye);
    if group.has_next == 0u || !(z > group.next_lens.w) {
        return vec3f(0.0);
    }
    return vec3f(group.next_lens.z * vec2f(x, y) / z + 0.5 * group.next_lens.xy - centre, 1.0);
}

@compute @workgroup_size(256)
fn project(
    @builtin(workgroup_id) block: vec3u,
    @builtin(num_workgroups) blocks: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let i = (block.y * blocks.x + block.x) * WIDE + local;
    if i >= group.count {
        return;
    }
    let at = group.first + i;
    order[at] = at;
    keys[at] = UNSEEN;
    boxes[at] = vec2u(0u);
    let from_eye = shapes[5u * i].xyz;
    let scales = shapes[5u * i + 2u].xyz;
    let t = vec3f(
        dot(group.rows[0].xyz, from_eye),
        dot(group.rows[1].xyz, from_eye),
        dot(group.rows[2].xyz, from_eye),
    );
    if !(t.z > group.lens.w) || t.z > LARGEST {
        return;
    }
    var opacity = 1.0 / (1.0 + exp(-shapes[5u * i].w));
    let size = group.lens.xy;
    let focal = group.lens.z;
    let limit = 1.3 * size / (2.0 * focal);
    let held = clamp(t.xy / t.z, -limit, limit);
    let along = focal / t.z;
    // Rows of J W R S.
    let turn = columns_of(shapes[5u * i + 1u]);
    let scale = exp(scales);
    let u = along * ((group.rows[0].xyz - held.x * group.rows[2].xyz) * turn) * scale;
    let v = along * ((group.rows[1].xyz - held.y * group.rows[2].xyz) * turn) * scale;
    let plain = vec3f(dot(u, u), dot(u, v), dot(v, v));
    let dilation = group.kernel.x;
    // |u|² |v|² − (u · v)² = |u × v|² (Lagrange) keeps the digits that the difference would lose for thin ellipses.
    let cross_uv = cross(u, v);
    let plain_det = dot(cross_uv, cross_uv);
    let det = plain_det + dilation * (plain.x + plain.z) + dilation * dilation;
    if !(det > 0.0) || det > LARGEST {
        return;
    }
    if group.antialiased != 0u {
        opacity *= sqrt(plain_det / det);
    }
    let reach = -2.0 * log(group.kernel.y + CUT / max(opacity, 1e-30));
    if !(reach > 0.0) {
        return;
    }
    let covariance = plain + vec3f(dilation, 0.0, dilation);
    let centre = focal * t.xy / t.z + 0.5 * size;
    let half = sqrt(reach * covariance.xz) + SLACK;
    let start = clamp(ceil(centre - half - 0.5), vec2f(0.0), size);
    let end = clamp(floor(centre + half - 0.5) + 1.0, vec2f(0.0), size);
    if !(start.x < end.x && start.y < end.y) {
        return;
    }
    boxes[at] = vec2u(start) | (vec2u(end) << vec2u(16u));
    keys[at] = bitcast<u32>(t.z);
    let rgb = colour(i, shapes[5u * i + 3u].xyz, normalize(from_eye));
    let conic = vec3f(covariance.z, -covariance.y, covariance.x) / det;
    ellipses[at] = Ellipse(centre, opacity, t.z, conic, rgb);
    if group.has_features != 0u {
        features[at] = Feature(normal(turn, scales, from_eye), group.object, motion(shapes[5u * i + 4u].xyz, centre));
    }
}
