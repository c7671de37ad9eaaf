// What is left of lights at samples, as it was found at the points of a grid (6.1-2, K-04).
#define_import_path pellucid::light_volume

#import pellucid::frame::frame

// The points of all lights, one behind the other; one point where there are no light volumes.
@group(1) @binding(7) var points: texture_3d<f32>;

fn at_point(point: vec3<i32>) -> f32 {
    return textureLoad(points, point, 0).x;
}

// The share of a light, by its number, that comes to a position: between eight points.
fn transmittance_in_volume(light: u32, p: vec3<f32>) -> f32 {
    let depth = i32(frame.shadows.w);
    let last = vec3<i32>(vec2<i32>(textureDimensions(points).xy), depth) - 1;
    let part = (p - frame.low.xyz) / (frame.high.xyz - frame.low.xyz);
    let q = clamp(part, vec3<f32>(0.0), vec3<f32>(1.0)) * vec3<f32>(last);
    let cell = min(vec3<i32>(q), last - 1);
    let u = q - vec3<f32>(cell);
    let a = cell + vec3<i32>(0, 0, i32(light) * depth);
    let b = a + 1;
    let near = mix(
        mix(at_point(a), at_point(vec3<i32>(b.x, a.y, a.z)), u.x),
        mix(at_point(vec3<i32>(a.x, b.y, a.z)), at_point(vec3<i32>(b.x, b.y, a.z)), u.x),
        u.y,
    );
    let far = mix(
        mix(at_point(vec3<i32>(a.x, a.y, b.z)), at_point(vec3<i32>(b.x, a.y, b.z)), u.x),
        mix(at_point(vec3<i32>(a.x, b.y, b.z)), at_point(b), u.x),
        u.y,
    );
    return mix(near, far, u.z);
}
