// What the field is at a position: its value, and its gradient.
#define_import_path pellucid::field

#import pellucid::frame::{frame, bounds}
#import pellucid::ray::planes

@group(1) @binding(0) var volume: texture_3d<f32>;
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
    return all(q >= vec3<f32>(bounds.core_low.xyz) - OVERLAP) && all(q <= vec3<f32>(bounds.core_high.xyz) + OVERLAP);
#else
    return true;
#endif
}

fn stored_voxel(voxel: vec3<i32>) -> f32 {
#ifdef BRICKS
    // A gradient in the overlap reaches over the brick's border by as little.
    let last = vec3<i32>(textureDimensions(volume)) - 1;
    return textureLoad(volume, clamp(voxel - vec3<i32>(bounds.texture_low.xyz), vec3<i32>(0), last), 0).x;
#else
    return textureLoad(volume, voxel, 0).x;
#endif
}

#ifdef HARDWARE
// The data value at a position, interpolated by the sampler.
fn field_value(p: vec3<f32>) -> f32 {
    let size = vec3<f32>(textureDimensions(volume));
#ifdef BRICKS
    let texel = p - vec3<f32>(bounds.texture_low.xyz);
#else
    let texel = p;
#endif
    return data_value(textureSampleLevel(volume, linear, (texel + 0.5) / size, 0.0).x);
}
#else
#ifdef HOLES
fn mix_present(u: f32, a: f32, b: f32) -> f32 {
    // A voxel without weight may be absent.
    if u == 0.0 {
        return a;
    }
    if u == 1.0 {
        return b;
    }
    if !is_present(a) || !is_present(b) {
        return ABSENT;
    }
    return a + (b - a) * u;
}
#else
fn mix_present(u: f32, a: f32, b: f32) -> f32 {
    return a + (b - a) * u;
}
#endif

// The data value at a position, interpolated exactly; ABSENT where there is none.
fn field_value(p: vec3<f32>) -> f32 {
    let q = inside_grid(p);
    let a = cell_of(q);
    let b = min(a + 1, last_voxel());
    let u = q - vec3<f32>(a);
    let near = mix_present(
        u.y,
        mix_present(u.x, stored_voxel(a), stored_voxel(vec3<i32>(b.x, a.y, a.z))),
        mix_present(u.x, stored_voxel(vec3<i32>(a.x, b.y, a.z)), stored_voxel(vec3<i32>(b.x, b.y, a.z))),
    );
    let far = mix_present(
        u.y,
        mix_present(u.x, stored_voxel(vec3<i32>(a.x, a.y, b.z)), stored_voxel(vec3<i32>(b.x, a.y, b.z))),
        mix_present(u.x, stored_voxel(vec3<i32>(a.x, b.y, b.z)), stored_voxel(b)),
    );
    let stored = mix_present(u.z, near, far);
#ifdef HOLES
    if !is_present(stored) {
        return ABSENT;
    }
#endif
    return data_value(stored);
}
#endif

// Whether the field is defined one voxel from a position: inside the box and not clipped.
fn has_tap(p: vec3<f32>) -> bool {
    // The rounding of positions must not cut off a tap that lies in the border.
    const ROOM: f32 = 1e-4;
    var inside = all(p >= frame.low.xyz - ROOM) && all(p <= frame.high.xyz + ROOM);
    for (var i = 0u; i < frame.counts.y; i += 1u) {
        inside = inside && dot(planes[i].xyz, p) >= planes[i].w - ROOM;
    }
    return inside;
}

fn tap(p: vec3<f32>) -> f32 {
    if !has_tap(p) {
        return ABSENT;
    }
    return field_value(p);
}

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
fn field_gradient(p: vec3<f32>) -> vec3<f32> {
    let at = field_value(p);
    let dx = vec3<f32>(1.0, 0.0, 0.0);
    let dy = vec3<f32>(0.0, 1.0, 0.0);
    let dz = vec3<f32>(0.0, 0.0, 1.0);
    let g = vec3<f32>(
        slope(tap(p - dx), at, tap(p + dx)),
        slope(tap(p - dy), at, tap(p + dy)),
        slope(tap(p - dz), at, tap(p + dz)),
    );
    return vec3<f32>(dot(frame.gradient_x.xyz, g), dot(frame.gradient_y.xyz, g), dot(frame.gradient_z.xyz, g));
}
