// What slices made of pixels (3.2), and how it becomes a part of the picture.
#define_import_path pellucid::sliced

#import pellucid::frame::{frame, bounds}
#import pellucid::march::{HIT, TERMINATED, NOWHERE, new_state, states}
#import pellucid::pixel::{Pixel, pixels}
#import pellucid::slices::slices

@group(0) @binding(13) var colors: texture_2d<f32>;
@group(0) @binding(14) var taken: texture_2d<f32>;

// Colours, as they were blended.
fn blended_at(pixel: vec2<u32>) -> vec4<f32> {
    return textureLoad(colors, pixel, 0);
}

// Adds a ray of a pixel of the band: its associated colour, and of how many samples it has if it meets the volume. Of a
// volume that is merged with others, it is a ray's state.
fn add_to_pixel(pixel: vec2<u32>, color: vec4<f32>, is_hit: bool, all: u32) {
    let slot = pixel.y * frame.size.x + pixel.x;
    let counts = vec2<u32>(textureLoad(taken, pixel, 0).xy + 0.5);
    let skipped = select(0u, all - min(all, counts.x), is_hit);
    let is_done = is_hit && color.a >= slices.strides.w;
#ifdef APART
    var state = new_state();
    state.color = color;
    state.counts = vec4<u32>(counts, skipped, select(0u, HIT, is_hit) | select(0u, TERMINATED, is_done));
    states[slot] = state;
#else
    var sum = Pixel(vec4<f32>(0.0), vec4<f32>(0.0, 0.0, 0.0, NOWHERE), vec4<u32>(0u));
    if bounds.rows.ray > 0u {
        sum = pixels[slot];
    }
    let n = frame.size.z;
    sum.color += color / f32(n * n);
    sum.counts += vec4<u32>(counts, skipped, select(0u, 1u, is_hit) + select(0u, 0x10000u, is_done));
    pixels[slot] = sum;
#endif
}
