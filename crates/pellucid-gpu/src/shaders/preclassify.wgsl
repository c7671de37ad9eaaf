// The transfer function applied to the voxels, interpolating their associated colours (4.2-1, 3.2-8).
#define_import_path pellucid::preclassify

#import pellucid::frame::bounds
#import pellucid::field::{cell_of, data_value, inside_grid, is_present, last_voxel, stored_voxel, source_of}
#import pellucid::frame::frame
#import pellucid::table::{classify, opacity_over}
#ifdef KERNELS
#import pellucid::kernel::{kernels, weight}
#endif

// The colour that is interpolated: associated, unless those of invisible voxels are to bleed (3.2-8).
fn color_at(value: f32) -> vec4<f32> {
    let rgba = classify(value);
#ifdef BLEEDING
    return vec4<f32>(rgba.rgb, opacity_over(rgba.a, frame.limits.w));
#else
    return rgba;
#endif
}

// What was interpolated, as an associated colour.
fn associated(rgba: vec4<f32>) -> vec4<f32> {
#ifdef BLEEDING
    return vec4<f32>(rgba.rgb * rgba.a, rgba.a);
#else
    return rgba;
#endif
}

#ifdef KERNELS

// The voxels themselves, where the field is made of coefficients.
@group(1) @binding(4) var voxels: texture_3d<f32>;

fn color_of(voxel: vec3<i32>) -> vec4<f32> {
#ifdef BRICKS
    let stored = textureLoad(voxels, voxel - vec3<i32>(bounds.texture_low), 0).x;
#else
    let stored = textureLoad(voxels, voxel, 0).x;
#endif
    if !is_present(stored) {
        return vec4<f32>(0.0);
    }
    return color_at(stored * kernels.classified.x + kernels.classified.y);
}

// Under the filter's weights; kernels that reach over the border meet the border voxel again.
fn classify_voxels(p: vec3<f32>) -> vec4<f32> {
    let q = inside_grid(source_of(p));
    let last = last_voxel();
    let taps = kernels.taps.x;
    if taps == 0u {
        return associated(color_of(min(vec3<i32>(floor(q + 0.5)), last)));
    }
    let cell = floor(q);
    let v = q - cell - 0.5;
    let first = vec3<i32>(cell) + 1 - i32(taps / 2u);
    var sum = vec4<f32>(0.0);
    for (var k = 0u; k < taps; k += 1u) {
        let z = clamp(first.z + i32(k), 0, last.z);
        var slice = vec4<f32>(0.0);
        for (var j = 0u; j < taps; j += 1u) {
            let y = clamp(first.y + i32(j), 0, last.y);
            var row = vec4<f32>(0.0);
            for (var i = 0u; i < taps; i += 1u) {
                let x = clamp(first.x + i32(i), 0, last.x);
                row += weight(i, v.x) * color_of(vec3<i32>(x, y, z));
            }
            slice += weight(j, v.y) * row;
        }
        sum += weight(k, v.z) * slice;
    }
    // Filters with negative weights overshoot.
    return associated(clamp(sum, vec4<f32>(0.0), vec4<f32>(1.0)));
}
#else
fn color_of(voxel: vec3<i32>) -> vec4<f32> {
    let stored = stored_voxel(voxel);
    if !is_present(stored) {
        return vec4<f32>(0.0);
    }
    return color_at(data_value(stored));
}

fn classify_voxels(p: vec3<f32>) -> vec4<f32> {
    let q = inside_grid(source_of(p));
    let a = cell_of(q);
    let b = min(a + 1, last_voxel());
    let u = q - vec3<f32>(a);
    let near = mix(
        mix(color_of(a), color_of(vec3<i32>(b.x, a.y, a.z)), u.x),
        mix(color_of(vec3<i32>(a.x, b.y, a.z)), color_of(vec3<i32>(b.x, b.y, a.z)), u.x),
        u.y,
    );
    let far = mix(
        mix(color_of(vec3<i32>(a.x, a.y, b.z)), color_of(vec3<i32>(b.x, a.y, b.z)), u.x),
        mix(color_of(vec3<i32>(a.x, b.y, b.z)), color_of(b), u.x),
        u.y,
    );
    return associated(mix(near, far, u.z));
}
#endif
