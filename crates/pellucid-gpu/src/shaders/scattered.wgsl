// Scattering by a phase function (6.2, K-07).
#define_import_path pellucid::scattered

#import pellucid::frame::frame
#import pellucid::arriving::Incident
#import pellucid::scatter::{Scatterer, phase_weight, scatterer_of}

// A sample that light falls on.
struct Lit {
    matter: Scatterer,
    to_eye: vec3<f32>,
    // Factor of its own colour.
    scattered: vec3<f32>,
}

fn in_the_dark(value: f32, gradient: vec3<f32>, to_eye: vec3<f32>) -> Lit {
    return Lit(scatterer_of(value), to_eye, vec3<f32>(0.0));
}

// Adds a light that arrives.
fn add_light(sample: ptr<function, Lit>, light: Incident, has_highlight: bool) {
    (*sample).scattered += light.radiance * phase_weight((*sample).matter.g, -dot(light.to_light, (*sample).to_eye));
}

// An associated sample in the light that was added, behind an opacity.
fn in_light(sample: Lit, rgba: vec4<f32>, front: f32) -> vec4<f32> {
    return vec4<f32>(rgba.rgb * (sample.scattered + frame.material.x), rgba.a);
}
