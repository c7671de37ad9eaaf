// Local reflection (5.4): as `pellucid-optics` defines it in `shading.rs`.
#define_import_path pellucid::blinn_phong

#import pellucid::frame::frame
#import pellucid::arriving::Incident
#import pellucid::normal::{Normal, normal_of, normalized}

// A sample that light falls on.
struct Lit {
    surface: Normal,
    to_eye: vec3<f32>,
    // Factor of its own colour, and highlights.
    diffuse: vec3<f32>,
    specular: vec3<f32>,
}

fn in_the_dark(value: f32, gradient: vec3<f32>, to_eye: vec3<f32>) -> Lit {
    var surface = normal_of(gradient);
    if frame.two_sided != 0u && dot(surface.direction, to_eye) < 0.0 {
        surface.direction = -surface.direction;
    }
    return Lit(surface, to_eye, vec3<f32>(0.0), vec3<f32>(0.0));
}

// Adds a light that arrives.
fn add_light(sample: ptr<function, Lit>, light: Incident, has_highlight: bool) {
    let facing = max(dot((*sample).surface.direction, light.to_light), 0.0);
    if facing == 0.0 {
        return;
    }
    (*sample).diffuse += light.radiance * (facing * frame.material.y);
    if has_highlight && frame.material.z > 0.0 {
        let halfway = normalized(light.to_light + (*sample).to_eye);
        let tilt = clamp(dot((*sample).surface.direction, halfway), 0.0, 1.0);
        if tilt > 0.0 {
            (*sample).specular += light.radiance * (pow(tilt, frame.material.w) * frame.material.z);
        }
    }
}

// An associated sample in the light that was added, behind an opacity: weighted by its own, or transparent samples would
// glow (5.4-1).
fn in_light(sample: Lit, rgba: vec4<f32>, front: f32) -> vec4<f32> {
    var color = vec3<f32>(frame.material.x) + sample.diffuse;
    var specular = sample.specular;
#ifdef WEIGHTED
    let weight = smoothstep(0.0, 1.0, (sample.surface.magnitude - frame.limits.x) * frame.limits.y);
    color = mix(vec3<f32>(1.0), color, weight);
    specular *= weight;
#endif
    return vec4<f32>(rgba.rgb * color + specular * rgba.a, rgba.a);
}
