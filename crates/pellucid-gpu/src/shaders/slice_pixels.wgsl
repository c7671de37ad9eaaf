// What slices made of their pixels (3.2): adds the band's colours to the picture.
#import pellucid::frame::{frame, bounds}
#import pellucid::ray::ray_of
#import pellucid::sliced::{add_to_pixel, blended_at}
#import pellucid::slices::{lattice_of, samples_of}
#ifdef CLASSIFIED_LAST
#import pellucid::table::classify
#endif

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
    let ray = ray_of(id.xy + vec2<u32>(frame.size.y, bounds.rows.first), bounds.rows.ray);
    let color = color_of(blended_at(id.xy));
    let is_hit = ray.count > 0.0;
    var all = 0u;
    if is_hit {
        all = samples_of(ray, lattice_of(ray));
    }
    add_to_pixel(id.xy, color, is_hit, all);
}
