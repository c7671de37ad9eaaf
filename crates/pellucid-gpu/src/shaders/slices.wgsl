// Where slices cut rays. Samples lie on planes or shells and are numbered away from the eye; a slice stands
// for one of them, or for several one behind the other (4.6-6).
#define_import_path pellucid::slices

#import pellucid::ray::{Ray, Sample, ray_length}
#import pellucid::field::{cell_of, inside_grid}

struct Slices {
    // Number of the sample at a position: voxels . xyz + w; of shells, distance from the eye in steps + w.
    plane: vec4<f32>,
    // Steps between two samples: in the middle of the picture, at a right angle; one over most samples of a
    // ray; alpha at which pixels are done.
    strides: vec4<f32>,
    // Rows of the matrix from voxels to the clip space of the band: x, y and w.
    clip_x: vec4<f32>,
    clip_y: vec4<f32>,
    clip_w: vec4<f32>,
    // Voxels by which boxes are drawn larger than they are; samples after its first that a slice is drawn at.
    margin: vec4<f32>,
    // The eye in voxels; of parallel rays the way they come from, and w is 0.
    eye: vec4<f32>,
    // Samples per slice; how opacity follows the distance of samples; 1 for shells; 1 where colours are
    // blended without their opacity.
    counts: vec4<u32>,
}

// Cells whose samples are drawn together: from, to.
struct Box {
    low: vec4<u32>,
    high: vec4<u32>,
}

#ifdef STORED_CONSTANTS
@group(0) @binding(9) var<storage, read> slices: Slices;
#else
@group(0) @binding(9) var<uniform> slices: Slices;
#endif
@group(0) @binding(10) var<storage, read> boxes: array<Box>;

const PER_FRAME: u32 = 1u;
const OFF: u32 = 2u;

// Rounding must not cut samples off in the border of the volume, in steps.
const ROOM: f32 = 1e-3;

// How samples lie on a ray.
struct Lattice {
    // The number that the entry would have.
    entry: f32,
    // Steps from one sample to the next, never negative.
    stride: f32,
    // How far samples are from their slice: jittered rays are off by up to half a stride.
    shift: f32,
    // Steps that a step stands for.
    correction: f32,
}

fn lattice_of(ray: Ray) -> Lattice {
    // Rays along the slices, or from behind them, meet none.
    const LONGEST: f32 = 1e6;
    var lattice = Lattice(ray.entry + slices.plane.w, 1.0, 0.0, 1.0);
    if slices.counts.z == 0u {
        let along = dot(slices.plane.xyz, ray.direction);
        lattice.entry = dot(slices.plane.xyz, ray.origin) + slices.plane.w;
        lattice.stride = select(LONGEST, 1.0 / along, along > 1.0 / LONGEST);
    }
    lattice.shift = (ray.jitter - 0.5) * lattice.stride;
    if slices.counts.y == PER_FRAME {
        lattice.correction = slices.strides.x / lattice.stride;
    } else if slices.counts.y == OFF {
        lattice.correction = slices.strides.y / lattice.stride;
    }
    return lattice;
}

// Distance of sample k, in steps from the entry.
fn distance_of(lattice: Lattice, k: f32) -> f32 {
    return (k - lattice.entry) * lattice.stride + lattice.shift;
}

// Whether a sample there is in the volume.
fn is_inside(ray: Ray, distance: f32) -> bool {
    return distance >= -ROOM && distance <= ray_length(ray) + ROOM;
}

// Sample k: it stands for what is nearer to it than to its neighbours, and the first and the last one in
// the volume for what is left at the ends, so that lengths add up to the ray's. Its ratio is 0 outside.
fn slice_sample(ray: Ray, lattice: Lattice, k: f32) -> Sample {
    let distance = distance_of(lattice, k);
    if !is_inside(ray, distance) {
        return Sample(0.0, 0.0, 0u);
    }
    let length = ray_length(ray);
    var start = max(distance - 0.5 * lattice.stride, 0.0);
    var end = min(distance + 0.5 * lattice.stride, length);
    if !is_inside(ray, distance - lattice.stride) {
        start = 0.0;
    }
    if !is_inside(ray, distance + lattice.stride) {
        end = length;
    }
    return Sample(clamp(distance, 0.0, length), (end - start) * lattice.correction, 0u);
}

// How many samples of a ray lie in the volume.
fn samples_of(ray: Ray, lattice: Lattice) -> u32 {
    let offset = lattice.shift / lattice.stride;
    let room = ROOM / lattice.stride;
    let first = ceil(lattice.entry - offset - room);
    let last = floor(lattice.entry - offset + ray_length(ray) / lattice.stride + room);
    return u32(max(last - first + 1.0, 0.0));
}

// Whether a box owns the samples at a position: every cell has one owner.
fn owns(box: u32, p: vec3<f32>) -> bool {
    let cell = vec3<u32>(cell_of(inside_grid(p)));
    return all(cell >= boxes[box].low.xyz) && all(cell < boxes[box].high.xyz);
}

// A fragment's share of the picture.
struct Share {
    // Colour and opacity, as its blending wants them.
    color: vec4<f32>,
    // Samples taken, seen.
    counts: vec2<f32>,
}

fn share_of(color: vec4<f32>, counts: vec4<u32>) -> Share {
    var rgba = color;
    if slices.counts.w != 0u && rgba.a > 0.0 {
        rgba = vec4<f32>(rgba.rgb / rgba.a, rgba.a);
    }
    return Share(rgba, vec2<f32>(counts.xy));
}
