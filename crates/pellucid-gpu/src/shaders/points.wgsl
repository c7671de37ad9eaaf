// The points of light volumes, which all volumes share (6.1-2, K-04).
#define_import_path pellucid::points

// The points of all lights, one behind the other; one point where there are no light volumes.
@group(1) @binding(7) var points: texture_3d<f32>;

fn at_point(point: vec3<i32>) -> f32 {
    return textureLoad(points, point, 0).x;
}

// What is left of a light, by its number, at a part of its box that has so many points along its last axis: between
// eight points.
fn light_in_box(light: u32, part: vec3<f32>, depth: i32) -> f32 {
    let last = vec3<i32>(vec2<i32>(textureDimensions(points).xy), depth) - 1;
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
