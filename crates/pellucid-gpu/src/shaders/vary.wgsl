// Classified samples by where they are: as they are, in the colours of their voxels, or under noise (K-23).
#define_import_path pellucid::vary

#import pellucid::frame::frame
#import pellucid::table::over_length
#ifdef PAINTED
#import pellucid::paint::color_at
#endif
#ifdef PERTURBED
#import pellucid::noise::{variation_at, varied_color, varied_extinction}
#endif

// An associated colour of any length at a position in voxels.
fn varied(p: vec3<f32>, classified: vec4<f32>) -> vec4<f32> {
    var rgba = classified;
#ifdef PAINTED
    rgba = vec4<f32>(rgba.rgb * color_at(p), rgba.a);
#endif
#ifdef PERTURBED
    if frame.noise.counts.y == 0u {
        return rgba;
    }
    let variation = variation_at(p);
    let dense = over_length(rgba, varied_extinction(variation));
    return vec4<f32>(varied_color(variation, dense.rgb, dense.a), dense.a);
#else
    return rgba;
#endif
}
