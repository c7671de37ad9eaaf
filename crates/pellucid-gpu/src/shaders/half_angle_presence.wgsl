// Marks where a slab holds something, for light that comes from matter alone (6.3-7 c, d).
#import pellucid::frame::bounds
#import pellucid::sweep::{light_ray, load_sweep, passage_of, sweep}
#import pellucid::slab::matter_of

@group(0) @binding(22) var held: texture_storage_2d<r32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    load_sweep();
    if any(id.xy >= sweep.size.xy) {
        return;
    }
    let matter = matter_of(passage_of(light_ray(id.xy), bounds.slab.x));
    textureStore(held, id.xy + 1u, vec4<f32>(select(0.0, 1.0, matter.color.a > 0.0)));
}
