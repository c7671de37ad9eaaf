// Light at samples, by local reflection (5.4) and by scattering (6.2): as `pellucid-optics` defines it in
// `shading.rs`, `light.rs` and `phase`.
#define_import_path pellucid::light

#import pellucid::frame::{frame, world_of}
#import pellucid::lists::{Light, lights}
#import pellucid::table::each_color
#ifdef SHADOWED
#ifdef LAYERED
#import pellucid::across::transmittance_across
#else
#import pellucid::light_volume::transmittance_in_volume
#import pellucid::shadow::transmittance_to
#endif
#endif
#ifdef SCATTERED
#import pellucid::scatter::{Scatterer, scatterer_of, phase_weight, gradient_share}
#endif

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
        let light = lights[frame.lists.z + i];
        var left = 1.0;
#ifdef SHADOWED
#ifdef LAYERED
        left = transmittance_across(light.place, world_of(p));
#else
        if frame.shadows.w == 0.0 {
            left = transmittance_to(light.place, p);
        } else {
            left = transmittance_in_volume(i, p);
        }
#endif
#endif
        add_light(&sample, light, p, each_color(left));
    }
    return in_light(sample, rgba);
}
