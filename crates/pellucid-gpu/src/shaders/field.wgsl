// What the field is at a position: its value, and its gradient.
#define_import_path pellucid::field

#import pellucid::frame::{frame, bounds}
#import pellucid::lists::planes
#ifdef PERTURBED
#import pellucid::noise::{amplitude_at, displaced, displaces}
#endif
#ifdef KERNELS
#import pellucid::kernel::{kernels, weight, MOST_FOURS, MOST_GRADIENT_TAPS}
#endif

#ifdef STACK
// One layer for each plane of voxels across an axis (3.2-1).
@group(1) @binding(0) var volume: texture_2d_array<f32>;

// A position in the stack: in its layers, and along them.
fn in_stack(p: vec3<f32>) -> vec3<f32> {
    switch frame.stack.x {
        case 0u: { return p.yzx; }
        case 1u: { return p.xzy; }
        default: { return p; }
    }
}
#else
@group(1) @binding(0) var volume: texture_3d<f32>;
#endif
#ifdef HARDWARE
@group(1) @binding(1) var linear: sampler;
#endif

// Absence. Stored voxels that are not finite are uploaded as this, as WGSL knows no NaN.
const ABSENT: f32 = 3.4028234e38;

fn is_present(value: f32) -> bool {
    return abs(value) < 3.0e38;
}

// Stored numbers as data values.
fn data_value(stored: f32) -> f32 {
    return stored * frame.values.x + frame.values.y;
}

fn last_voxel() -> vec3<i32> {
    return vec3<i32>(frame.dims.xyz) - 1;
}

// A position in the grid: rays may leave it by a rounding, and where there is one voxel only the box
// is thicker than the grid.
fn inside_grid(p: vec3<f32>) -> vec3<f32> {
    return clamp(p, vec3<f32>(0.0), vec3<f32>(last_voxel()));
}

// The voxel below a position, so that there is another above it where there can be one.
fn cell_of(p: vec3<f32>) -> vec3<i32> {
    return min(vec3<i32>(floor(p)), max(last_voxel() - 1, vec3<i32>(0)));
}

// Whether the sample at a position is taken in this pass. Bricks overlap a little: a ray along their
// border could otherwise be rounded into one that has been passed, and would end there.
fn is_here(p: vec3<f32>) -> bool {
#ifdef BRICKS
    const OVERLAP: f32 = 1e-3;
    let q = inside_grid(p);
    return all(q >= vec3<f32>(bounds.core_low) - OVERLAP) && all(q <= vec3<f32>(bounds.core_high) + OVERLAP);
#else
    return true;
#endif
}

fn stored_voxel(voxel: vec3<i32>) -> f32 {
#ifdef STACK
    let place = vec3<i32>(in_stack(vec3<f32>(voxel)));
    return textureLoad(volume, place.xy, place.z, 0).x;
#else
#ifdef BRICKS
    // A gradient in the overlap reaches over the brick's border by as little.
    let last = vec3<i32>(textureDimensions(volume)) - 1;
    return textureLoad(volume, clamp(voxel - vec3<i32>(bounds.texture_low), vec3<i32>(0), last), 0).x;
#else
    return textureLoad(volume, voxel, 0).x;
#endif
#endif
}

// Where an absent voxel is met, the nearest one's value stands for it; where that is absent there is no
// value. Holes neither grow nor leak (`sampler.rs` of `pellucid-field`).
fn voxel_or(voxel: vec3<i32>, nearest: f32) -> f32 {
    let stored = stored_voxel(voxel);
#ifdef HOLES
    return select(nearest, stored, is_present(stored));
#else
    return stored;
#endif
}

#ifdef HARDWARE
// The data value at a position, interpolated by the sampler.
fn still_value(p: vec3<f32>) -> f32 {
#ifdef STACK
    // Between two layers by two fetches (3.4-1); one where a position lies in a layer.
    const ROUNDING: f32 = 1e-3;
    let q = in_stack(inside_grid(p));
    let uv = (q.xy + 0.5) / vec2<f32>(textureDimensions(volume));
    let layer = floor(q.z + 0.5);
    let beside = q.z - layer;
    let value = textureSampleLevel(volume, linear, uv, i32(layer), 0.0).x;
    if abs(beside) < ROUNDING {
        return data_value(value);
    }
    let other = textureSampleLevel(volume, linear, uv, i32(layer + sign(beside)), 0.0).x;
    return data_value(mix(value, other, abs(beside)));
#else
    let size = vec3<f32>(textureDimensions(volume));
#ifdef BRICKS
    let texel = p - vec3<f32>(bounds.texture_low);
#else
    let texel = p;
#endif
    return data_value(textureSampleLevel(volume, linear, (texel + 0.5) / size, 0.0).x);
#endif
}
#else
fn nearest_voxel(q: vec3<f32>) -> f32 {
    return stored_voxel(min(vec3<i32>(floor(q + 0.5)), last_voxel()));
}

// The stored number between eight voxels (1.5-10).
fn trilinear(q: vec3<f32>, nearest: f32) -> f32 {
    let a = cell_of(q);
    let b = min(a + 1, last_voxel());
    let u = q - vec3<f32>(a);
    let near = mix_two(
        u.y,
        mix_two(u.x, voxel_or(a, nearest), voxel_or(vec3<i32>(b.x, a.y, a.z), nearest)),
        mix_two(u.x, voxel_or(vec3<i32>(a.x, b.y, a.z), nearest), voxel_or(vec3<i32>(b.x, b.y, a.z), nearest)),
    );
    let far = mix_two(
        u.y,
        mix_two(u.x, voxel_or(vec3<i32>(a.x, a.y, b.z), nearest), voxel_or(vec3<i32>(b.x, a.y, b.z), nearest)),
        mix_two(u.x, voxel_or(vec3<i32>(a.x, b.y, b.z), nearest), voxel_or(b, nearest)),
    );
    return mix_two(u.z, near, far);
}

// Exactly `a` between equals.
fn mix_two(u: f32, a: f32, b: f32) -> f32 {
    return a + (b - a) * u;
}

#ifdef KERNELS
// The stored number under the filter's weights. The sum is of differences to the nearest voxel, so that
// a flat field stays flat to the bit. Kernels that reach over the border meet the border voxel again.
fn filtered(q: vec3<f32>, nearest: f32) -> f32 {
    let taps = kernels.taps.x;
    let cell = floor(q);
    let v = q - cell - 0.5;
    let first = vec3<i32>(cell) + 1 - i32(taps / 2u);
    let last = last_voxel();
    // Rows are read four voxels at a time; what a row has too few of has no weight.
    var along: array<vec4<f32>, MOST_FOURS>;
    for (var i = 0u; i < taps; i += 1u) {
        along[i / 4u][i % 4u] = weight(i, v.x);
    }
    var sum = 0.0;
    for (var k = 0u; k < taps; k += 1u) {
        let z = clamp(first.z + i32(k), 0, last.z);
        var slice = 0.0;
        for (var j = 0u; j < taps; j += 1u) {
            let y = clamp(first.y + i32(j), 0, last.y);
            var row = 0.0;
            for (var i = 0u; i < taps; i += 4u) {
                let x = clamp(vec4<i32>(first.x + i32(i)) + vec4<i32>(0, 1, 2, 3), vec4<i32>(0), vec4<i32>(last.x));
                let stored = vec4<f32>(
                    voxel_or(vec3<i32>(x.x, y, z), nearest),
                    voxel_or(vec3<i32>(x.y, y, z), nearest),
                    voxel_or(vec3<i32>(x.z, y, z), nearest),
                    voxel_or(vec3<i32>(x.w, y, z), nearest),
                );
                row += dot(along[i / 4u], stored - nearest);
            }
            slice += weight(j, v.y) * row;
        }
        sum += weight(k, v.z) * slice;
    }
    return sum + nearest;
}
#endif

// The data value at a position, reconstructed exactly; ABSENT where there is none.
fn still_value(p: vec3<f32>) -> f32 {
    let q = inside_grid(p);
    var nearest = 0.0;
#ifdef HOLES
    nearest = nearest_voxel(q);
    if !is_present(nearest) {
        return ABSENT;
    }
#endif
#ifdef KERNELS
    if kernels.taps.x != 2u {
        nearest = nearest_voxel(q);
        if kernels.taps.x == 0u {
            return data_value(nearest);
        }
        return data_value(filtered(q, nearest));
    }
#endif
    return data_value(trilinear(q, nearest));
}
#endif

// Where what is drawn at a position comes from.
fn source_of(p: vec3<f32>) -> vec3<f32> {
#ifdef PERTURBED
    var part = select(0.0, 1.0, displaces());
    if displaces() && frame.noise.between.z != 0.0 {
        let value = still_value(p);
        part = select(0.0, amplitude_at(value), is_present(value));
    }
    if part > 0.0 {
        return displaced(p, part);
    }
#endif
    return p;
}

// The data value that is drawn at a position; ABSENT where there is none.
fn field_value(p: vec3<f32>) -> f32 {
    return still_value(source_of(p));
}

// The rounding of positions must not cut off what lies in the border, in voxels.
const ROOM: f32 = 1e-4;

// Whether everything between two corners is inside the box and not clipped.
fn is_defined(low: vec3<f32>, high: vec3<f32>) -> bool {
    var inside = all(low >= frame.low.xyz - ROOM) && all(high <= frame.high.xyz + ROOM);
    for (var i = 0u; i < frame.plane_count; i += 1u) {
        let plane = planes[frame.lists.y + i];
        let deepest = select(high, low, plane.xyz > vec3<f32>(0.0));
        inside = inside && dot(plane.xyz, deepest) >= plane.w - ROOM;
    }
    return inside;
}

// The value beside a position, for differences.
fn tap(p: vec3<f32>) -> f32 {
    if !is_defined(p, p) {
        return ABSENT;
    }
    return field_value(p);
}

// Differences per voxel as data units per world length.
fn world_gradient(g: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(dot(frame.gradient_x.xyz, g), dot(frame.gradient_y.xyz, g), dot(frame.gradient_z.xyz, g));
}

#ifdef KERNELS
// A gradient per voxel, if there is one.
struct Slopes {
    stored: vec3<f32>,
    present: bool,
}

// The gradient of stored numbers as sums under separable weights; none if a voxel of them is absent.
fn summed_gradient(q: vec3<f32>) -> Slopes {
    let taps = kernels.taps.y;
    let across = kernels.taps.w;
    let derivative = across + taps;
    let cell = floor(q);
    let v = q - cell - 0.5;
    let first = vec3<i32>(cell) + 1 - i32(taps / 2u);
    let last = last_voxel();
    let middle = stored_voxel(clamp(vec3<i32>(cell), vec3<i32>(0), last));
    var along: array<vec2<f32>, MOST_GRADIENT_TAPS>;
    for (var i = 0u; i < taps; i += 1u) {
        along[i] = vec2<f32>(weight(across + i, v.x), weight(derivative + i, v.x));
    }
    var sum = vec3<f32>(0.0);
    var present = is_present(middle);
    for (var k = 0u; k < taps; k += 1u) {
        let z = clamp(first.z + i32(k), 0, last.z);
        var slice = vec3<f32>(0.0);
        for (var j = 0u; j < taps; j += 1u) {
            let y = clamp(first.y + i32(j), 0, last.y);
            var row = vec2<f32>(0.0);
            for (var i = 0u; i < taps; i += 1u) {
                let x = clamp(first.x + i32(i), 0, last.x);
                let stored = stored_voxel(vec3<i32>(x, y, z));
#ifdef HOLES
                present = present && is_present(stored);
#endif
                row += along[i] * (stored - middle);
            }
            let smoothing = weight(across + j, v.y);
            slice += vec3<f32>(smoothing * row.y, weight(derivative + j, v.y) * row.x, smoothing * row.x);
        }
        let smoothing = weight(across + k, v.z);
        sum += vec3<f32>(smoothing, smoothing, weight(derivative + k, v.z)) * slice;
    }
    return Slopes(sum, present);
}

// The gradient per voxel from samples around a position: one that does not exist is the point
// reflection of its opposite, and where neither does there is no difference.
fn sampled_gradient(q: vec3<f32>) -> vec3<f32> {
    let at = field_value(q);
    var sum = vec3<f32>(0.0);
    if !is_present(at) {
        return sum;
    }
    let r = i32(kernels.taps.z);
    for (var z = 0; z <= r; z += 1) {
        for (var y = select(-r, 0, z == 0); y <= r; y += 1) {
            for (var x = select(-r, 1, z == 0 && y == 0); x <= r; x += 1) {
                let offset = vec3<i32>(x, y, z);
                let here = sample_weights(r + offset);
                let opposite = sample_weights(r - offset);
                if all(here == vec3<f32>(0.0)) && all(opposite == vec3<f32>(0.0)) {
                    continue;
                }
                let after = tap(q + vec3<f32>(offset));
                let before = tap(q - vec3<f32>(offset));
                var rise = after - at;
                var fall = before - at;
                if !is_present(after) {
                    rise = select(0.0, -fall, is_present(before));
                }
                if !is_present(before) {
                    fall = -rise;
                }
                sum += here * rise + opposite * fall;
            }
        }
    }
    return sum;
}

// The stencil's weights of a sample, for the three parts of a gradient.
fn sample_weights(place: vec3<i32>) -> vec3<f32> {
    let x = kernels.stencil[place.x].xy;
    let y = kernels.stencil[place.y].xy;
    let z = kernels.stencil[place.z].xy;
    return vec3<f32>(x.y * y.x * z.x, x.x * y.y * z.x, x.x * y.x * z.y);
}

// Whether all that the sums of a gradient stand for is there.
fn is_whole_around(q: vec3<f32>) -> bool {
    if kernels.flags.x != 0u {
        let first = floor(q) - 1.0;
        return is_defined(first, first + 3.0);
    }
    let radius = f32(kernels.taps.z);
    return is_defined(q - radius, q + radius);
}

// The gradient in data units per world length, by the estimator that is asked for.
fn still_gradient(p: vec3<f32>) -> vec3<f32> {
    let q = clamp(p, frame.low.xyz, frame.high.xyz);
    if is_whole_around(q) {
        let slopes = summed_gradient(select(q, floor(q + 0.5), kernels.flags.y != 0u));
        if slopes.present {
            return world_gradient(slopes.stored * frame.values.x);
        }
    }
    return world_gradient(sampled_gradient(q));
}
#else
// The change per voxel along an axis: half of that between both neighbours, or of that to the one
// that is there.
fn slope(before: f32, at: f32, after: f32) -> f32 {
    let has_before = is_present(before);
    let has_after = is_present(after);
    if has_before && has_after {
        return (after - before) * 0.5;
    }
    if has_after {
        return after - at;
    }
    if has_before {
        return at - before;
    }
    return 0.0;
}

// The gradient in data units per world length, by central differences over one voxel.
fn still_gradient(p: vec3<f32>) -> vec3<f32> {
    let at = field_value(p);
    if !is_present(at) {
        return vec3<f32>(0.0);
    }
    let dx = vec3<f32>(1.0, 0.0, 0.0);
    let dy = vec3<f32>(0.0, 1.0, 0.0);
    let dz = vec3<f32>(0.0, 0.0, 1.0);
    let g = vec3<f32>(
        slope(tap(p - dx), at, tap(p + dx)),
        slope(tap(p - dy), at, tap(p + dy)),
        slope(tap(p - dz), at, tap(p + dz)),
    );
    return world_gradient(g);
}
#endif

#ifdef PERTURBED
// Central differences of the displaced field, one-sided beside what is absent.
fn displaced_gradient(p: vec3<f32>) -> vec3<f32> {
    let center = field_value(p);
    var g = vec3<f32>(0.0);
    if !is_present(center) {
        return g;
    }
    for (var axis = 0u; axis < 3u; axis += 1u) {
        var step = vec3<f32>(0.0);
        step[axis] = frame.noise.spacing[axis];
        let before = tap(p - step);
        let after = tap(p + step);
        let has_before = is_present(before);
        let has_after = is_present(after);
        let down = select(select(0.0, after - center, has_after), center - before, has_before);
        let up = select(down, after - center, has_after);
        g[axis] = (up + down) * 0.5 / frame.noise.spacing[axis];
    }
    return world_gradient(g);
}
#endif

// The gradient of what is drawn, in data units per world length.
fn field_gradient(p: vec3<f32>) -> vec3<f32> {
#ifdef PERTURBED
    if displaces() {
        return displaced_gradient(p);
    }
#endif
    return still_gradient(p);
}
