// Light at samples, by local reflection (5.4) and by scattering (6.2): as `pellucid-optics` defines it in
// `shading.rs`, `light.rs` and `phase`.
#define_import_path pellucid::light

#import pellucid::frame::{frame, world_of}
#import pellucid::table::each_color
#ifdef SHADOWED
#import pellucid::light_volume::left_in_volume
#import pellucid::shadow::left_of_light
#endif
#ifdef SCATTERED
#import pellucid::scatter::{Scatterer, scatterer_of, phase_weight, gradient_share}
#endif

// What shines around the middle of a light.
struct Extent {
    // What it is; 1 if paths that were scattered find it as well; 1 if a face shines to both sides.
    kind: vec4<u32>,
    // The edges of a face.
    first: vec4<f32>,
    second: vec4<f32>,
    // Out of the side of a face that shines, and its area; else the squared sine of a disc's angle, or a ball's radius.
    normal: vec4<f32>,
}

struct Light {
    // Unit vector to it, or its position; `w` is 1 for a position.
    place: vec4<f32>,
    // Linear RGB; 1 if it makes highlights.
    radiance: vec4<f32>,
    // Where a cone points; 1 if there is one.
    axis: vec4<f32>,
    // Cosines of the cone's inner and outer angle; distance at which the radiance holds, 0 if anywhere.
    cone: vec4<f32>,
    extent: Extent,
}

@group(0) @binding(4) var<storage, read> lights: array<Light>;

struct Normal {
    // Unit, out of the surface towards lower values; zero where there is no gradient.
    direction: vec3<f32>,
    // The gradient's.
    magnitude: f32,
}

fn normal_of(gradient: vec3<f32>) -> Normal {
    let scale = max(max(abs(gradient.x), abs(gradient.y)), abs(gradient.z));
    if scale < 1.1754944e-38 || scale > 3.0e38 {
        return Normal(vec3<f32>(0.0), 0.0);
    }
    // Squares of very short and very long gradients leave the range of numbers.
    let scaled = gradient / scale;
    let size = length(scaled);
    return Normal(-scaled / size, size * scale);
}

fn normalized(v: vec3<f32>) -> vec3<f32> {
    let squared = dot(v, v);
    if squared <= 1e-24 {
        return vec3<f32>(0.0);
    }
    return v / sqrt(squared);
}

// A light as it reaches a place, were nothing in between.
struct Incident {
    // Unit vector to it, and its radiance; zero if it shines from this very place.
    to_light: vec3<f32>,
    radiance: vec3<f32>,
}

fn incident(light: Light, p: vec3<f32>) -> Incident {
    var to_light = light.place.xyz;
    var strength = 1.0;
    if light.place.w != 0.0 {
        let path = light.place.xyz - world_of(p);
        let distance = length(path);
        if !(distance > 1e-12) {
            return Incident(vec3<f32>(0.0), vec3<f32>(0.0));
        }
        to_light = path / distance;
        if light.cone.z > 0.0 {
            let ratio = light.cone.z / distance;
            strength = min(ratio * ratio, 1e12);
        }
        if light.axis.w != 0.0 {
            strength *= smoothstep(light.cone.y, light.cone.x, dot(light.axis.xyz, -to_light));
        }
    }
    return Incident(to_light, light.radiance.rgb * strength);
}

// A sample that light falls on.
struct Lit {
    // As a surface: unit normal and the gradient's magnitude.
    surface: Normal,
    to_eye: vec3<f32>,
    // Factors of its own colour, by what reflects and what scatters; highlights.
    diffuse: vec3<f32>,
    scattered: vec3<f32>,
    specular: vec3<f32>,
#ifdef SCATTERED
    matter: Scatterer,
#endif
}

// A sample in the dark; what is a surface has a gradient.
fn in_the_dark(value: f32, gradient: vec3<f32>, to_eye: vec3<f32>) -> Lit {
    var sample: Lit;
    sample.to_eye = to_eye;
#ifdef SHADED
    sample.surface = normal_of(gradient);
    if frame.two_sided != 0u && dot(sample.surface.direction, to_eye) < 0.0 {
        sample.surface.direction = -sample.surface.direction;
    }
#endif
#ifdef SCATTERED
    sample.matter = scatterer_of(value);
#endif
    return sample;
}

// Adds a light, of whose colours a part is left.
fn add_light(sample: ptr<function, Lit>, light: Light, p: vec3<f32>, left: vec3<f32>) {
    let arriving = incident(light, p);
    let radiance = arriving.radiance * left;
#ifdef SCATTERED
    let matter = (*sample).matter;
    (*sample).scattered += radiance * phase_weight(matter.g, -dot(arriving.to_light, (*sample).to_eye));
#endif
#ifdef SHADED
    let facing = max(dot((*sample).surface.direction, arriving.to_light), 0.0);
    if facing == 0.0 {
        return;
    }
    (*sample).diffuse += radiance * (facing * frame.material.y);
    if light.radiance.w != 0.0 && frame.material.z > 0.0 {
        let halfway = normalized(arriving.to_light + (*sample).to_eye);
        let tilt = clamp(dot((*sample).surface.direction, halfway), 0.0, 1.0);
        if tilt > 0.0 {
            (*sample).specular += radiance * (pow(tilt, frame.material.w) * frame.material.z);
        }
    }
#endif
}

// An associated sample in the light that was added: weighted by its opacity, or transparent samples would glow
// (5.4-1).
fn in_light(sample: Lit, rgba: vec4<f32>) -> vec4<f32> {
    let unlit = vec3<f32>(frame.material.x);
#ifdef SCATTERED
    // `C = E ((1 - S) P + S f)` (K-10, K-11).
    var share = sample.matter.surface;
#ifdef WEIGHTED
    share = gradient_share(sample.surface.magnitude);
#endif
    let color = mix(sample.scattered, sample.diffuse, share) + unlit;
    return vec4<f32>(rgba.rgb * color + sample.specular * share * rgba.a, rgba.a);
#else
    var color = unlit + sample.diffuse;
    var specular = sample.specular;
#ifdef WEIGHTED
    let weight = smoothstep(0.0, 1.0, (sample.surface.magnitude - frame.limits.x) * frame.limits.y);
    color = mix(vec3<f32>(1.0), color, weight);
    specular *= weight;
#endif
    return vec4<f32>(rgba.rgb * color + specular * rgba.a, rgba.a);
#endif
}

// An associated sample in the light of all sources.
fn lit(rgba: vec4<f32>, value: f32, p: vec3<f32>, gradient: vec3<f32>, to_eye: vec3<f32>) -> vec4<f32> {
    var sample = in_the_dark(value, gradient, to_eye);
    for (var i = 0u; i < frame.light_count; i += 1u) {
        var left = 1.0;
#ifdef SHADOWED
        if frame.shadows.w == 0.0 {
            left = left_of_light(lights[i].place, p);
        } else {
            left = left_in_volume(i, p);
        }
#endif
        add_light(&sample, lights[i], p, each_color(left));
    }
    return in_light(sample, rgba);
}
