// What slices made of pixels (3.2), and how it becomes a part of the picture.
#define_import_path pellucid::sliced

#import pellucid::frame::{frame, bounds}
#import pellucid::march::NOWHERE
#import pellucid::pixel::{Pixel, pixels}
#import pellucid::slices::slices

@group(0) @binding(13) var colors: texture_2d<f32>;
@group(0) @binding(14) var taken: texture_2d<f32>;

// Colours, as they were blended.
fn blended_at(pixel: vec2<u32>) -> vec4<f32> {
    return textureLoad(colors, pixel, 0);
}

// Adds a ray of a pixel of the band: its associated colour, and of how many samples it has if it meets the volume.
fn add_to_pixel(pixel: vec2<u32>, color: vec4<f32>, is_hit: bool, all: u32) {
    let slot = pixel.y * frame.size.x + pixel.x;
    let counts = vec2<u32>(textureLoad(taken, pixel, 0).xy + 0.5);
    var sum = Pixel(vec4<f32>(0.0), vec4<f32>(0.0, 0.0, 0.0, NOWHERE), vec4<u32>(0u));
    if bounds.rows.ray > 0u {
        sum = pixels[slot];
    }
    let n = frame.size.z;
    sum.color += color / f32(n * n);
    var skipped = 0u;
    var rays = 0u;
    if is_hit {
        skipped = all - min(all, counts.x);
        rays = 1u + select(0u, 0x10000u, color.a >= slices.strides.w);
    }
    sum.counts += vec4<u32>(counts, skipped, rays);
    pixels[slot] = sum;
}
