// One triangle over everything that is drawn to.
#define_import_path pellucid::window

// A corner of it, at a depth.
fn window_corner(corner: u32, depth: f32) -> vec4<f32> {
    let at = vec2<f32>(f32(corner & 1u) * 4.0 - 1.0, f32(corner >> 1u) * 4.0 - 1.0);
    return vec4<f32>(at, depth, 1.0);
}
