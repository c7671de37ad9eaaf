// What rays have found in several volumes, each followed by itself, in one: as `apart.rs` of the CPU backend.
#import pellucid::of0::frame::{frame, bounds}
#import pellucid::of0::march::{NOWHERE, states}
#import pellucid::count::COUNT
#import pellucid::merge::merged

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.size.x || id.y >= bounds.rows.count {
        return;
    }
    let slot = id.y * frame.size.x + id.x;
    // The states in a volume follow those in the one before it.
    let room = arrayLength(&states) / COUNT;
    var elements: array<vec4<f32>, COUNT>;
    var counts = vec4<u32>(0u);
    var surface = vec4<f32>(0.0, 0.0, 0.0, NOWHERE);
    var most = 0.0;
    for (var i = 0u; i < COUNT; i += 1u) {
        let own = states[i * room + slot];
        elements[i] = own.color;
        counts = vec4<u32>(counts.xyz + own.counts.xyz, counts.w | own.counts.w);
        // What is seen best tells where.
        if own.color.a > most {
            most = own.color.a;
            surface = own.surface;
        }
    }
    states[slot].color = merged(&elements);
    states[slot].surface = surface;
    states[slot].counts = counts;
}
