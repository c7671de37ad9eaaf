// Local light (5.4): as `pellucid-optics` defines it in `shading.rs` and `light.rs`.
#define_import_path pellucid::light

#import pellucid::frame::frame

struct Light {
    // Unit vector to it, or its position; `w` is 1 for a position.
    place: vec4<f32>,
    // Linear RGB; 1 if it makes highlights.
    radiance: vec4<f32>,
    // Where a cone points; 1 if there is one.
    axis: vec4<f32>,
    // Cosines of the cone's inner and outer angle; distance at which the radiance holds, 0 if anywhere.
    cone: vec4<f32>,
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

// An associated sample with light upon it: weighted by its opacity, or transparent samples would glow
// (5.4-1).
fn lit(rgba: vec4<f32>, p: vec3<f32>, gradient: vec3<f32>, to_eye: vec3<f32>) -> vec4<f32> {
    let surface = normal_of(gradient);
    var normal = surface.direction;
    if frame.counts.w != 0u && dot(normal, to_eye) < 0.0 {
        normal = -normal;
    }
    var diffuse = vec3<f32>(frame.material.x);
    var specular = vec3<f32>(0.0);
    for (var i = 0u; i < frame.counts.x; i += 1u) {
        let light = lights[i];
        var to_light = light.place.xyz;
        var strength = 1.0;
        if light.place.w != 0.0 {
            let here = vec4<f32>(p, 1.0);
            let world = vec3<f32>(dot(frame.world_x, here), dot(frame.world_y, here), dot(frame.world_z, here));
            let path = light.place.xyz - world;
            let distance = length(path);
            if !(distance > 1e-12) {
                continue;
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
        let facing = max(dot(normal, to_light), 0.0);
        if facing == 0.0 {
            continue;
        }
        let radiance = light.radiance.rgb * strength;
        diffuse += radiance * (facing * frame.material.y);
        if light.radiance.w != 0.0 && frame.material.z > 0.0 {
            let tilt = clamp(dot(normal, normalized(to_light + to_eye)), 0.0, 1.0);
            if tilt > 0.0 {
                specular += radiance * (pow(tilt, frame.material.w) * frame.material.z);
            }
        }
    }
#ifdef WEIGHTED
    let t = clamp((surface.magnitude - frame.limits.x) * frame.limits.y, 0.0, 1.0);
    let weight = t * t * (3.0 - 2.0 * t);
    diffuse = mix(vec3<f32>(1.0), diffuse, weight);
    specular *= weight;
#endif
    return vec4<f32>(rgba.rgb * diffuse + specular * rgba.a, rgba.a);
}
