// Lights as they arrive at samples (5.4, 6.1): as `lights.rs` of the CPU backend.
#define_import_path pellucid::arriving

#import pellucid::frame::{frame, world_of}
#import pellucid::lists::Light
#ifdef SHADOWED
#import pellucid::light_volume::transmittance_in_volume
#ifdef LAYERED
#import pellucid::across::transmittance_across
#else
#import pellucid::shadow::transmittance_to
#endif
#endif

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

// What is left of a light, by its number, where it arrives.
fn share_of(number: u32, light: Light, p: vec3<f32>) -> f32 {
#ifdef SHADOWED
    if frame.shadows.w != 0.0 {
        return transmittance_in_volume(number, p);
    }
#ifdef LAYERED
    return transmittance_across(light.place, world_of(p));
#else
    return transmittance_to(light.place, p);
#endif
#else
    return 1.0;
#endif
}
