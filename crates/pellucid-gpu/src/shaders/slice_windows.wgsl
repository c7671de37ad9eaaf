// What slices through several volumes are drawn as: the whole window, for volumes end anywhere on a slice.
#import pellucid::window::window_corner

struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) slice: u32,
}

// Slices, in the order in which they are drawn.
@group(0) @binding(11) var<storage, read> instances: array<u32>;

@vertex
fn vertex(@builtin(vertex_index) corner: u32, @builtin(instance_index) instance: u32) -> Corner {
    return Corner(window_corner(corner, 0.5), instances[instance]);
}
