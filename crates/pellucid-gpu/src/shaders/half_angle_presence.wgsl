// Marks where a slab holds something, for light that comes from matter alone (6.3-7 c, d).
#import pellucid::frame::bounds
#import pellucid::sweep::{light_ray, lost, passage_of, sweep}
#import pellucid::slab::matter_of

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= sweep.size.xy) {
        return;
    }
    let matter = matter_of(passage_of(light_ray(id.xy), f32(bounds.rows.x)));
    let held = select(0.0, 1.0, matter.color.a > 0.0);
    lost[(bounds.rows.w * sweep.size.y + id.y) * sweep.size.x + id.x] = vec4<f32>(0.0, 0.0, 0.0, held);
}
