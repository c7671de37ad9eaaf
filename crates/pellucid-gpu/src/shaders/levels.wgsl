// Isosurfaces, and where pairs of values pass them.
#define_import_path pellucid::levels

#import pellucid::field::is_present

struct Level {
    // Linear RGB and opacity.
    color: vec4<f32>,
    // Data value.
    value: vec4<f32>,
}

@group(0) @binding(6) var<storage, read> levels: array<Level>;

fn between(front: f32, back: f32, level: f32) -> bool {
    return is_present(front) && is_present(back) && (front < level) != (back < level);
}
