// Marks the pixels that are opaque, so that no fragment behind them is worked on (8.6-2): they get a depth
// before that of all slices.
#import pellucid::slices::slices
#import pellucid::window::window_corner

@group(0) @binding(13) var colors: texture_2d<f32>;

@vertex
fn vertex(@builtin(vertex_index) corner: u32) -> @builtin(position) vec4<f32> {
    return window_corner(corner, 0.0);
}

@fragment
fn fragment(@builtin(position) position: vec4<f32>) {
    if textureLoad(colors, vec2<u32>(position.xy), 0).a < slices.strides.w {
        discard;
    }
}
