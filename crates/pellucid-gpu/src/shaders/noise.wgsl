// Noise on a volume: where samples look for their values, and how their optics vary (K-21 to K-24). As `turbulence.rs`
// of `pellucid-optics`, which defines it.
#define_import_path pellucid::noise

#import pellucid::frame::frame

struct Term {
    // Texels of the noise per voxel along each axis; the factor in w.
    scale: vec4<f32>,
    // The texel at voxel 0.
    start: vec4<f32>,
}

struct Noise {
    // Voxels that a noise of 1 moves by, and that nothing moves further than.
    amplitude: vec4<f32>,
    reach: vec4<f32>,
    // Voxels between a position and the taps of its gradient.
    spacing: vec4<f32>,
    // Data values at which nothing and everything moves; 1 if that depends on them.
    between: vec4<f32>,
    // How much extinction, colour and transport vary.
    weights: vec4<f32>,
    // Terms that displace, and that vary: they are behind the former.
    counts: vec4<u32>,
    terms: array<Term, 16>,
}

@group(1) @binding(5) var noise_texels: texture_3d<f32>;
#ifdef STORED_CONSTANTS
@group(1) @binding(6) var<storage, read> noise: Noise;
#else
@group(1) @binding(6) var<uniform> noise: Noise;
#endif

fn texel(cell: vec3<i32>) -> vec4<f32> {
    return textureLoad(noise_texels, cell & vec3<i32>(31), 0) * 2.0 - 1.0;
}

// The sum of some of the terms at a position in voxels.
fn turbulence(first: u32, end: u32, p: vec3<f32>) -> vec4<f32> {
    var sum = vec4<f32>(0.0);
    for (var i = first; i < end; i += 1u) {
        let term = noise.terms[i];
        let place = p * term.scale.xyz + term.start.xyz;
        let cell = floor(place);
        let part = place - cell;
        let a = vec3<i32>(cell);
        let near = mix(
            mix(texel(a), texel(a + vec3<i32>(1, 0, 0)), part.x),
            mix(texel(a + vec3<i32>(0, 1, 0)), texel(a + vec3<i32>(1, 1, 0)), part.x),
            part.y,
        );
        let far = mix(
            mix(texel(a + vec3<i32>(0, 0, 1)), texel(a + vec3<i32>(1, 0, 1)), part.x),
            mix(texel(a + vec3<i32>(0, 1, 1)), texel(a + vec3<i32>(1, 1, 1)), part.x),
            part.y,
        );
        sum += mix(near, far, part.z) * term.scale.w;
    }
    return sum;
}

// Whether anything moves.
fn displaces() -> bool {
    return noise.counts.x > 0u;
}

// Where what is drawn at a position comes from, by the part of the amplitude there: towards a face of the box, the
// shift across it fades to nothing.
fn displaced(p: vec3<f32>, part: f32) -> vec3<f32> {
    let shift = turbulence(0u, noise.counts.x, p).xyz;
    let room = max(min(p - frame.low.xyz, frame.high.xyz - p), vec3<f32>(0.0)) / noise.reach.xyz;
    return p + noise.amplitude.xyz * part * min(room, vec3<f32>(1.0)) * shift;
}

// The part of the amplitude at a data value.
fn amplitude_at(value: f32) -> f32 {
    return smoothstep(0.0, 1.0, (value - noise.between.x) / (noise.between.y - noise.between.x));
}

// The noise that varies optics at a position, within -1 and 1.
fn variation_at(p: vec3<f32>) -> vec4<f32> {
    let end = noise.counts.x + noise.counts.y;
    return clamp(turbulence(noise.counts.x, end, p), vec4<f32>(-1.0), vec4<f32>(1.0));
}

// The factor of the extinction: full opacity, which is an infinite extinction, stays what it is.
fn varied_extinction(variation: vec4<f32>) -> f32 {
    return max(1.0 + noise.weights.x * variation.a, 1e-6);
}

// A colour: each channel times 1 and more or less, no more than `most` unless it was.
fn varied_color(variation: vec4<f32>, color: vec3<f32>, most: f32) -> vec3<f32> {
    return min(color * (1.0 + noise.weights.y * variation.rgb), max(color, vec3<f32>(most)));
}

// Factors of the indirect attenuation.
fn varied_transport(variation: vec4<f32>) -> vec3<f32> {
    return 1.0 + noise.weights.z * variation.rgb;
}
