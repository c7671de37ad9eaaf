// The light at the points of a light volume that lie in a run of slabs (6.1-2): between the layers in front of and
// behind a point.
#import pellucid::constants::load_constants
#import pellucid::frame::bounds
#import pellucid::sweep::{in_picture, layer_of, loss, sweep}

@group(0) @binding(23) var points: texture_storage_3d<r32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    load_constants();
    if any(id >= bounds.size) {
        return;
    }
    let part = vec3<f32>(id) / vec3<f32>(bounds.size - 1u);
    let p = mix(bounds.low.xyz, bounds.high.xyz, part);
    // The last coordinate is the end of the last slab.
    let place = clamp(dot(sweep.slabs.xyz, p) + sweep.slabs.w, 0.0, f32(sweep.size.z));
    let slab = min(u32(place), sweep.size.z - 1u);
    if slab < bounds.run.first || slab >= bounds.run.end {
        return;
    }
    let texel = in_picture(p).xy;
    let lost = mix(loss(layer_of(bounds.run, slab), texel).a, loss(layer_of(bounds.run, slab + 1u), texel).a, place - f32(slab));
    textureStore(points, id + vec3<u32>(0u, 0u, bounds.first), vec4<f32>(1.0 - lost));
}
