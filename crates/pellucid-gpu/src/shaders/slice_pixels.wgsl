// What slices made of their pixels (3.2): adds the band's colours to the picture.
#import pellucid::frame::{frame, bounds}
#import pellucid::ray::ray_of
#import pellucid::march::NOWHERE
#import pellucid::pixel::{Pixel, pixels}
#import pellucid::slices::{lattice_of, samples_of, slices}
#ifdef CLASSIFIED_LAST
#import pellucid::table::classify
#endif

@group(0) @binding(13) var colors: texture_2d<f32>;
@group(0) @binding(14) var taken: texture_2d<f32>;

// What was blended, as an associated colour.
fn color_of(blended: vec4<f32>) -> vec4<f32> {
#ifdef CLASSIFIED_LAST
    if blended.a <= 0.0 {
        return vec4<f32>(0.0);
    }
    var place = blended.x;
#ifdef MEAN
    place /= blended.a;
#endif
    var value = frame.values.z;
    if frame.values.w > 0.0 {
        value += place * f32(frame.dims.w - 1u) / frame.values.w;
    }
    var rgba = classify(value);
#ifdef OPAQUE
    rgba.a = 1.0;
#endif
    return vec4<f32>(rgba.rgb * rgba.a, rgba.a);
#else
#ifdef TRANSMITTANCE
    // The share of light that was held back, in white.
    return 1.0 - blended;
#else
    return blended;
#endif
#endif
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.size.x || id.y >= bounds.rows.count {
        return;
    }
    let slot = id.y * frame.size.x + id.x;
    let ray = ray_of(id.xy + vec2<u32>(frame.size.y, bounds.rows.first), bounds.rows.ray);
    let color = color_of(textureLoad(colors, id.xy, 0));
    let counts = vec2<u32>(textureLoad(taken, id.xy, 0).xy + 0.5);
    var pixel = Pixel(vec4<f32>(0.0), vec4<f32>(0.0, 0.0, 0.0, NOWHERE), vec4<u32>(0u));
    if bounds.rows.ray > 0u {
        pixel = pixels[slot];
    }
    let n = frame.size.z;
    pixel.color += color / f32(n * n);
    var skipped = 0u;
    var rays = 0u;
    if ray.count > 0.0 {
        let all = samples_of(ray, lattice_of(ray));
        skipped = all - min(all, counts.x);
        rays = 1u + select(0u, 0x10000u, color.a >= slices.strides.w);
    }
    pixel.counts += vec4<u32>(counts, skipped, rays);
    pixels[slot] = pixel;
}
