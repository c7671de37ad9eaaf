// The colours of voxels: as `ColorGrid` of the plan defines what is between them.
#define_import_path pellucid::paint

#import pellucid::frame::frame

#ifdef PAINTED
// Linear light, times alpha, and the alpha: whole numbers.
@group(1) @binding(8) var colors: texture_3d<u32>;

fn color_at(p: vec3<f32>) -> vec3<f32> {
    let last = vec3<f32>(frame.dims.xyz) - 1.0;
    let inside = clamp(p, vec3<f32>(0.0), last);
    let low = floor(inside);
    let high = min(low + 1.0, last);
    let u = inside - low;
    var sum = vec4<f32>(0.0);
    for (var i = 0u; i < 8u; i += 1u) {
        let side = vec3<f32>(vec3<u32>(i & 1u, (i >> 1u) & 1u, i >> 2u));
        let voxel = mix(low, high, side);
        let parts = mix(1.0 - u, u, side);
        let weight = parts.x * parts.y * parts.z;
        sum += weight * vec4<f32>(textureLoad(colors, vec3<i32>(voxel), 0));
    }
    return select(vec3<f32>(0.0), sum.rgb / max(sum.a, 1e-30), sum.a > 0.0);
}
#endif
