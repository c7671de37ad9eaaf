// The rays of a picture, and where on them samples are taken: as `rays.rs` of the CPU backend
// defines it. Distances count steps from the entry.
#define_import_path pellucid::ray

#import pellucid::frame::frame
#import pellucid::lists::planes
#import pellucid::way::Way

@group(0) @binding(3) var blue_noise: texture_2d<f32>;

const FAR: f32 = 1e30;

struct Ray {
    // Voxels: the entry, and the way of a step.
    origin: vec3<f32>,
    direction: vec3<f32>,
    inverse: vec3<f32>,
    // Unit vector in the world.
    to_eye: vec3<f32>,
    // Where in its step a sample lies.
    jitter: f32,
    // Number of segments, 0 if the ray meets nothing; length of the last one in steps.
    count: f32,
    last_ratio: f32,
    // Distance from the eye to the entry, in steps.
    entry: f32,
}

// A piece of a ray between two nodes.
struct Segment {
    // Distances of its ends, and the data values there.
    distance: vec2<f32>,
    value: vec2<f32>,
    // In steps: exactly 1 between two samples.
    length: f32,
}

// What stands for a segment, or for as many as a stride has.
struct Sample {
    // Where it is, in steps.
    distance: f32,
    // Length it stands for, in strides: 1 but for the last.
    ratio: f32,
    // The stride is 2^level steps.
    level: u32,
}

fn nonzero(x: f32) -> f32 {
    return select(x, 1e-30, abs(x) < 1e-30);
}

fn nonzeros(v: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(nonzero(v.x), nonzero(v.y), nonzero(v.z));
}

// Less of the box's extent is lost in the rounding of positions.
const ROUNDING: f32 = 1e-6;

// How often a direction fits into each of the box's extents, and the longest way that it has in the box.
fn ways_of(direction: vec3<f32>) -> vec4<f32> {
    let ways = (frame.high.xyz - frame.low.xyz) / max(abs(direction), vec3<f32>(1e-30));
    return vec4<f32>(ways, min(ways.x, min(ways.y, ways.z)));
}

// The axes on which not even that way leads off a side by more than rounding: directions along an axis or a side, also
// where they were turned there. On these, a position is in the box or it is not, and there is nothing to divide by.
fn still_axes(ways: vec4<f32>) -> vec3<bool> {
    return ways.xyz * ROUNDING > vec3<f32>(ways.w);
}

// Where a line is in the grid's box and kept by the clips, between two distances; they are in no order if it is
// nowhere.
fn span_of(origin: vec3<f32>, direction: vec3<f32>, from_t: f32, to_t: f32) -> vec2<f32> {
    let inverse = 1.0 / nonzeros(direction);
    let one = (frame.low.xyz - origin) * inverse;
    let other = (frame.high.xyz - origin) * inverse;
    let extent = frame.high.xyz - frame.low.xyz;
    let room = max(extent.x, max(extent.y, extent.z)) * ROUNDING;
    let is_beside = (origin < frame.low.xyz - room) | (origin > frame.high.xyz + room);
    let still = still_axes(ways_of(direction));
    let ever = select(vec3<f32>(FAR), vec3<f32>(-FAR), is_beside);
    let near = select(min(one, other), -ever, still);
    let far = select(max(one, other), ever, still);
    var t0 = max(max(from_t, near.x), max(near.y, near.z));
    var t1 = min(min(to_t, far.x), min(far.y, far.z));
    for (var i = 0u; i < frame.plane_count; i += 1u) {
        let plane = planes[frame.lists.y + i];
        let slope = dot(plane.xyz, direction);
        let crossing = (plane.w - dot(plane.xyz, origin)) / nonzero(slope);
        if slope >= 0.0 {
            t0 = max(t0, crossing);
        } else {
            t1 = min(t1, crossing);
        }
    }
    return vec2<f32>(t0, t1);
}

// How far the way from a position inside leads to where the field ends, in units of its direction.
fn exit_of(origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    let ways = ways_of(direction);
    let sides = select(frame.low.xyz, frame.high.xyz, direction > vec3<f32>(0.0));
    // A position on a side, by rounding beyond it, has no way left there; along a side there is no end.
    let leaving = max((sides - origin) / nonzeros(direction), vec3<f32>(0.0));
    let exits = select(leaving, vec3<f32>(FAR), still_axes(ways));
    var length = min(exits.x, min(exits.y, exits.z));
    let extent = frame.high.xyz - frame.low.xyz;
    let flattest = ROUNDING * max(extent.x, max(extent.y, extent.z)) / ways.w;
    for (var i = 0u; i < frame.plane_count; i += 1u) {
        let plane = planes[frame.lists.y + i];
        let slope = dot(plane.xyz, direction);
        if slope < -flattest {
            length = min(length, max((dot(plane.xyz, origin) - plane.w) / -slope, 0.0));
        }
    }
    return length;
}

// A ray before it is cut to the field.
struct Beam {
    // Where it crosses the base plane, and its way of a step, in voxels; the same as a unit vector of the world.
    origin: vec3<f32>,
    direction: vec3<f32>,
    world: vec3<f32>,
    // Steps from the eye to the base plane.
    to_base: f32,
}

// The ray through a place of the picture, in pixels.
fn beam_of(at: vec2<f32>) -> Beam {
    let a = (at.x - frame.picture.x) * frame.picture.z;
    let b = (frame.picture.y - at.y) * frame.picture.z;
    var unit = 1.0;
    if frame.size.w != 0u {
        unit = 1.0 / sqrt(1.0 + a * a + b * b);
    }
    let origin = frame.origin_middle.xyz + frame.origin_right.xyz * a + frame.origin_up.xyz * b;
    let direction = (frame.direction_middle.xyz + frame.direction_right.xyz * a + frame.direction_up.xyz * b) * unit;
    let world = (frame.world_middle.xyz + frame.world_right.xyz * a + frame.world_up.xyz * b) * unit;
    return Beam(origin, direction, world, frame.origin_middle.w / unit);
}

// Where the ray with number `sub` of a pixel goes through the picture, in pixels.
fn place_of(pixel: vec2<u32>, sub: u32) -> vec2<f32> {
    let n = frame.size.z;
    let inside = (vec2<f32>(vec2<u32>(sub % n, sub / n)) + 0.5) / f32(n);
    return vec2<f32>(pixel) + inside;
}

// The ray with number `sub` of a pixel.
fn ray_of(pixel: vec2<u32>, sub: u32) -> Ray {
    let beam = beam_of(place_of(pixel, sub));
    let origin = beam.origin;
    let direction = beam.direction;
    let to_base = beam.to_base;
    let span = span_of(origin, direction, -to_base, FAR);
    let t0 = span.x;
    let t1 = span.y;

    var ray: Ray;
    ray.origin = origin + direction * t0;
    ray.direction = direction;
    let slow = abs(ray.direction) < vec3<f32>(1e-12);
    ray.inverse = 1.0 / select(ray.direction, vec3<f32>(1e-12), slow);
    ray.to_eye = -beam.world;
    ray.entry = t0 + to_base;
    let whole = t1 - t0;
    // A remainder below the precision of the interval is no segment.
    let count = max(ceil(whole - 1e-6 * max(whole, 1.0)), 1.0);
    ray.count = select(0.0, count, t0 < t1);
    ray.last_ratio = min(whole - (count - 1.0), 1.0);
    ray.jitter = jitter_of(pixel, sub);
    return ray;
}

// What of a ray its samples ask for.
fn ray_along(way: Way) -> Ray {
    var ray: Ray;
    ray.origin = way.origin;
    ray.direction = way.direction;
    ray.inverse = 1.0 / nonzeros(way.direction);
    ray.to_eye = way.to_eye;
    return ray;
}

// Where in its step the ray with number `sub` of a pixel has its samples.
fn jitter_of(pixel: vec2<u32>, sub: u32) -> f32 {
    if frame.jitter.z == 0u {
        return 0.5;
    }
    let cell = (pixel + frame.jitter.xy) % 64u;
    // The rays of one pixel differ by the golden ratio, which spreads any number evenly.
    return fract(textureLoad(blue_noise, cell, 0).x + f32(sub) * 0.618034);
}

// The position at a distance, in voxels.
fn ray_at(ray: Ray, distance: f32) -> vec3<f32> {
    return ray.origin + ray.direction * distance;
}

// Length of segment k, in steps: 1 but for the last.
fn ray_ratio(ray: Ray, k: f32) -> f32 {
    return select(1.0, ray.last_ratio, k >= ray.count - 1.0);
}

// Distance of segment k's sample.
fn ray_sample(ray: Ray, k: f32) -> f32 {
    return k + ray.jitter * ray_ratio(ray, k);
}

// The sample of segment k.
fn sample_of(ray: Ray, k: f32) -> Sample {
    return Sample(ray_sample(ray, k), ray_ratio(ray, k), 0u);
}

// The sample of the stride that starts with segment k, in the middle of what is left of it.
fn stride_sample(ray: Ray, k: f32, level: u32) -> Sample {
    let stride = f32(1u << level);
    let length = min(ray_length(ray) - k, stride);
    return Sample(k + ray.jitter * length, length / stride, level);
}

// Distance of the exit.
fn ray_length(ray: Ray) -> f32 {
    return ray.count - 1.0 + ray.last_ratio;
}

// Nodes of the piecewise linear view of a ray: the entry, every sample, the exit; n from 0 to
// count + 1.
fn ray_node(ray: Ray, n: f32) -> f32 {
    if n < 1.0 {
        return 0.0;
    }
    if n > ray.count {
        return ray_length(ray);
    }
    return ray_sample(ray, n - 1.0);
}

// Length of the segment behind node n, in steps; n from 0 to count.
fn ray_segment(ray: Ray, n: f32) -> f32 {
    if n >= ray.count {
        return (1.0 - ray.jitter) * ray.last_ratio;
    }
    let ratio = ray_ratio(ray, n);
    if n < 1.0 {
        return ray.jitter * ratio;
    }
    return 1.0 + ray.jitter * (ratio - 1.0);
}
