// Marks where a slab holds something, for light that comes from matter alone (6.3-7 c, d).
#import pellucid::constants::load_constants
#import pellucid::frame::bounds
#import pellucid::slabs::held_back
#import pellucid::sweep::sweep

@group(0) @binding(22) var held: texture_storage_2d<r32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    load_constants();
    if any(id.xy >= sweep.size.xy) {
        return;
    }
    let opacity = held_back(id.xy, bounds.slab.x).direct;
    textureStore(held, id.xy + 1u, vec4<f32>(select(0.0, 1.0, opacity > 0.0)));
}
