// The transfer function applied to the voxels, interpolating their associated colours (4.2-1, 3.2-8).
#define_import_path pellucid::preclassify

#import pellucid::field::{cell_of, data_value, inside_grid, is_present, last_voxel, stored_voxel}
#import pellucid::table::classify

fn color_of(voxel: vec3<i32>) -> vec4<f32> {
    let stored = stored_voxel(voxel);
    if !is_present(stored) {
        return vec4<f32>(0.0);
    }
    return classify(data_value(stored));
}

fn classify_voxels(p: vec3<f32>) -> vec4<f32> {
    let q = inside_grid(p);
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
    return mix(near, far, u.z);
}
