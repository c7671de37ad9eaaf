// Between a cloud and a surface: `C = E ((1 - S) P + S f)` (K-10, K-11).
#define_import_path pellucid::hybrid

#import pellucid::frame::frame
#import pellucid::arriving::Incident
#import pellucid::blinn_phong as reflection
#import pellucid::scatter::gradient_share
#import pellucid::scattered as cloud

// A sample that light falls on: of which a share reflects it, and the rest scatters it.
struct Lit {
    surface: reflection::Lit,
    rest: cloud::Lit,
}

fn in_the_dark(value: f32, gradient: vec3<f32>, to_eye: vec3<f32>) -> Lit {
    return Lit(reflection::in_the_dark(value, gradient, to_eye), cloud::in_the_dark(value, gradient, to_eye));
}

// Adds a light that arrives.
fn add_light(sample: ptr<function, Lit>, light: Incident, has_highlight: bool) {
    // Functions take no pointers to parts.
    var surface = (*sample).surface;
    reflection::add_light(&surface, light, has_highlight);
    var rest = (*sample).rest;
    cloud::add_light(&rest, light, has_highlight);
    *sample = Lit(surface, rest);
}

// An associated sample in the light that was added, behind an opacity.
fn in_light(sample: Lit, rgba: vec4<f32>, front: f32) -> vec4<f32> {
#ifdef WEIGHTED
    let share = gradient_share(sample.surface.surface.magnitude);
#else
    let share = sample.rest.matter.surface;
#endif
    let color = mix(sample.rest.scattered, sample.surface.diffuse, share) + frame.material.x;
    return vec4<f32>(rgba.rgb * color + sample.surface.specular * share * rgba.a, rgba.a);
}
