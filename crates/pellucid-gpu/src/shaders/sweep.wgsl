// Light on its way through slabs (6.3, K-05 to K-09): where it is, and what is left of it. A slab is crossed by
// rays of the light and of the eye in segments of their own lengths, with a sample in each.
#define_import_path pellucid::sweep

#import pellucid::frame::{frame, load_frame, Run}
#import pellucid::lists::Light
#import pellucid::passage::Crossing
#ifdef HARDWARE
#import pellucid::field::linear
#endif
#import pellucid::ray::{FAR, nonzero, span_of}

struct Sweep {
    // Coordinate of the slabs at a position: voxels . xyz + w.
    slabs: vec4<f32>,
    // Rows of the matrix from voxels to texels of the light's picture, times depth; and to depth.
    texel_x: vec4<f32>,
    texel_y: vec4<f32>,
    depth: vec4<f32>,
    // Where rays of light begin, in voxels, and the coordinate of the slabs there: in the middle of the light's
    // plane, and per unit to the right and up.
    origin_middle: vec4<f32>,
    origin_right: vec4<f32>,
    origin_up: vec4<f32>,
    // Their directions, likewise, per world unit of the middle one.
    direction_middle: vec4<f32>,
    direction_right: vec4<f32>,
    direction_up: vec4<f32>,
    // The light's plane: the corner of the first texel, sides of texels.
    plane: vec4<f32>,
    // Steps of light in a slab; of a light that is somewhere, its coordinate; a step in world units; 1 if it is
    // somewhere.
    ways: vec4<f32>,
    // Radius of the blur in texels to the right and up; of a light that is somewhere in world units for a path of
    // 1, and 1 if it grows with the root of the path. Texels per world unit in z and w.
    blur: vec4<f32>,
    // Factors of direct and indirect light; indirect light as it enters; how many lights there are.
    scales: vec4<f32>,
    // Weights of direct light that is scattered into the cone.
    cone: vec4<f32>,
    // Cosine and sine of the angle between two taps; one over the sides of the layers, in texels with their rims.
    taps: vec4<f32>,
    // Texels and slabs.
    size: vec4<u32>,
    // Taps of the blur; 1 if light loses nothing in the slab that it lights; 1 if direct light that becomes
    // indirect comes from matter alone, 2 if all of it does.
    counts: vec4<u32>,
    // The light itself.
    light: Light,
}

#ifdef LOADED_CONSTANTS
@group(0) @binding(17) var<storage, read> stored_sweep: Sweep;
var<private> sweep: Sweep;
#else
@group(0) @binding(17) var<uniform> sweep: Sweep;
#endif

// As `load_frame`.
fn load_sweep() {
#ifdef LOADED_CONSTANTS
    sweep = stored_sweep;
#endif
    load_frame();
}

// What light has lost so far, in layers of texels: of indirect light in rgb, of direct light in a. Zeros are light
// as it enters, and so is the rim around the picture, a texel wide: nothing is lost beside it.
@group(0) @binding(18) var lost: texture_2d_array<f32>;

// Where a texel's ray of light crosses the light's plane.
fn on_plane(texel: vec2<f32>) -> vec2<f32> {
    return sweep.plane.xy + texel * sweep.plane.zw;
}

// The ray of light through the middle of a texel.
fn light_ray(texel: vec2<u32>) -> Crossing {
    let at = on_plane(vec2<f32>(texel) + 0.5);
    let start = sweep.origin_middle + sweep.origin_right * at.x + sweep.origin_up * at.y;
    let way = sweep.direction_middle + sweep.direction_right * at.x + sweep.direction_up * at.y;
    let length = select(1.0, sqrt(1.0 + dot(at, at)), sweep.ways.w != 0.0);
    var ray: Crossing;
    ray.direction = way.xyz / way.w;
    ray.origin = start.xyz - ray.direction * start.w;
    ray.ends = span_of(ray.origin, ray.direction, 0.0, f32(sweep.size.z));
    ray.stretch = length / (way.w * sweep.ways.z);
    ray.jitter = 0.5;
    return ray;
}

// A position in the light's picture, in texels, and its depth: 1 for a light that is nowhere.
fn in_picture(p: vec3<f32>) -> vec3<f32> {
    let here = vec4<f32>(p, 1.0);
    let depth = dot(sweep.depth, here);
    return vec3<f32>(vec2<f32>(dot(sweep.texel_x, here), dot(sweep.texel_y, here)) / depth, depth);
}

// The layer of light in front of a slab of a run.
fn layer_of(run: Run, slab: u32) -> u32 {
    let layer = run.layer + slab - run.first;
    return select(layer, layer - run.layers, layer >= run.layers);
}

// Four texels that a place lies between: the middle of the first, and the part of the way to the others.
struct Between {
    texel: vec2<i32>,
    part: vec2<f32>,
}

fn between(place: vec2<f32>) -> Between {
    let at = within_rim(place) - 0.5;
    let corner = min(floor(at), vec2<f32>(sweep.size.xy) - 1.0);
    return Between(vec2<i32>(corner), at - corner);
}

// Beyond the middles of the rim's texels nothing changes.
fn within_rim(place: vec2<f32>) -> vec2<f32> {
    return clamp(place, vec2<f32>(-0.5), vec2<f32>(sweep.size.xy) + 0.5);
}

fn loss_at(layer: u32, texel: vec2<i32>) -> vec4<f32> {
    return textureLoad(lost, texel + 1, layer, 0);
}

// What is lost at a place of the light's picture, between the middles of four texels.
fn loss(layer: u32, place: vec2<f32>) -> vec4<f32> {
#ifdef HARDWARE
    return textureSampleLevel(lost, linear, (within_rim(place) + 1.0) * sweep.taps.zw, layer, 0.0);
#else
    let four = between(place);
    let near = mix(loss_at(layer, four.texel), loss_at(layer, four.texel + vec2<i32>(1, 0)), four.part.x);
    let far =
        mix(loss_at(layer, four.texel + vec2<i32>(0, 1)), loss_at(layer, four.texel + vec2<i32>(1, 1)), four.part.x);
    return mix(near, far, four.part.y);
#endif
}
