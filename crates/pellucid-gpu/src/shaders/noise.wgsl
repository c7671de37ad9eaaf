// Noise on a volume: where samples look for their values, and how their optics vary (K-21 to K-24). As `turbulence.rs`
// of `pellucid-optics`, which defines it.
#define_import_path pellucid::noise

#import pellucid::frame::{frame, Term}
#ifdef LOADED_CONSTANTS
#import pellucid::frame::stored_frame
#endif

@group(1) @binding(5) var noise_texels: texture_3d<f32>;

fn term_of(number: u32) -> Term {
#ifdef LOADED_CONSTANTS
    // What has no fixed place in registers is read where it is.
    return stored_frame.noise.terms[number];
#else
    return frame.noise.terms[number];
#endif
}

fn texel(cell: vec3<i32>) -> vec4<f32> {
    return textureLoad(noise_texels, cell & vec3<i32>(31), 0) * 2.0 - 1.0;
}

// The sum of some of the terms at a position in voxels.
fn turbulence(first: u32, end: u32, p: vec3<f32>) -> vec4<f32> {
    var sum = vec4<f32>(0.0);
    for (var i = first; i < end; i += 1u) {
        let term = term_of(i);
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
    return frame.noise.counts.x > 0u;
}

// Where what is drawn at a position comes from, by the part of the amplitude there: towards a face of the box, the
// shift across it fades to nothing.
fn displaced(p: vec3<f32>, part: f32) -> vec3<f32> {
    let shift = turbulence(0u, frame.noise.counts.x, p).xyz;
    let room = max(min(p - frame.low.xyz, frame.high.xyz - p), vec3<f32>(0.0)) / frame.noise.reach.xyz;
    return p + frame.noise.amplitude.xyz * part * min(room, vec3<f32>(1.0)) * shift;
}

// The part of the amplitude at a data value.
fn amplitude_at(value: f32) -> f32 {
    return smoothstep(0.0, 1.0, (value - frame.noise.between.x) / (frame.noise.between.y - frame.noise.between.x));
}

// The noise that varies optics at a position, within -1 and 1.
fn variation_at(p: vec3<f32>) -> vec4<f32> {
    let end = frame.noise.counts.x + frame.noise.counts.y;
    return clamp(turbulence(frame.noise.counts.x, end, p), vec4<f32>(-1.0), vec4<f32>(1.0));
}

// The factor of the extinction: full opacity, which is an infinite extinction, stays what it is.
fn varied_extinction(variation: vec4<f32>) -> f32 {
    return max(1.0 + frame.noise.weights.x * variation.a, 1e-6);
}

// A colour: each channel times 1 and more or less, no more than `most` unless it was.
fn varied_color(variation: vec4<f32>, color: vec3<f32>, most: f32) -> vec3<f32> {
    return min(color * (1.0 + frame.noise.weights.y * variation.rgb), max(color, vec3<f32>(most)));
}

// Factors of the indirect attenuation.
fn varied_transport(variation: vec4<f32>) -> vec3<f32> {
    return 1.0 + frame.noise.weights.z * variation.rgb;
}
