// What is left of lights at samples, as it was found at the points of a grid (6.1-2, K-04).
#define_import_path pellucid::light_volume

#import pellucid::frame::frame
#import pellucid::points::light_in_box

// The share of a light, by its number, that comes to a position.
fn transmittance_in_volume(light: u32, p: vec3<f32>) -> f32 {
    let here = vec4<f32>(p, 1.0);
    let part = vec3<f32>(dot(frame.points_x, here), dot(frame.points_y, here), dot(frame.points_z, here));
    return light_in_box(light, part, i32(frame.shadows.w));
}
