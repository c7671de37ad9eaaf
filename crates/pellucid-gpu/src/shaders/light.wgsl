// Light at samples: what arrives there (`arriving.wgsl`), and what of it goes to the eye. Shading is a module with the same
// functions whatever it is: `blinn_phong.wgsl`, `scattered.wgsl`, or `hybrid.wgsl`.
#define_import_path pellucid::light

#import pellucid::frame::frame
#import pellucid::arriving::{Incident, incident, share_of}
#import pellucid::lists::{Light, lights}
#import pellucid::table::each_color
#ifdef SCATTERED
#ifdef SHADED
#import pellucid::hybrid as shading
#else
#import pellucid::scattered as shading
#endif
#else
#import pellucid::blinn_phong as shading
#endif

// A sample to be lit.
struct Unlit {
    // Associated colour and opacity.
    rgba: vec4<f32>,
    value: f32,
    // In voxels.
    position: vec3<f32>,
    // Where it may be a surface, else 0.
    gradient: vec3<f32>,
    to_eye: vec3<f32>,
    // Opacity of what is in front of it, as far as it is known: fragments of slices know of their own alone.
    front: f32,
}

// A sample in the light of all sources.
fn lit(sample: Unlit) -> vec4<f32> {
    var found = shading::in_the_dark(sample.value, sample.gradient, sample.to_eye);
    for (var i = 0u; i < frame.light_count; i += 1u) {
        let light = lights[frame.lists.z + i];
        add(&found, light, sample.position, each_color(share_of(i, light, sample.position)));
    }
    return shading::in_light(found, sample.rgba, sample.front);
}

// A sample in one light, of whose colours a share is left.
fn lit_by(sample: Unlit, light: Light, share: vec3<f32>) -> vec4<f32> {
    var found = shading::in_the_dark(sample.value, sample.gradient, sample.to_eye);
    add(&found, light, sample.position, share);
    return shading::in_light(found, sample.rgba, sample.front);
}

fn add(found: ptr<function, shading::Lit>, light: Light, position: vec3<f32>, share: vec3<f32>) {
    let arriving = incident(light, position);
    shading::add_light(found, Incident(arriving.to_light, arriving.radiance * share), light.radiance.w != 0.0);
}
