// What slices through several volumes made of their pixels: adds the band's colours to the picture.
#import pellucid::of0::frame::{frame, bounds}
#import pellucid::of0::ray::place_of
#import pellucid::of0::sliced::{add_to_pixel, blended_at}
#import pellucid::slice_nodes::{find_nodes, slabs_in}
#import pellucid::ways::{find_ways, whole}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.size.x || id.y >= bounds.rows.count {
        return;
    }
    let at = place_of(id.xy + vec2<u32>(frame.size.y, bounds.rows.first), bounds.rows.ray);
    find_ways(at);
    find_nodes(at);
    add_to_pixel(id.xy, blended_at(id.xy), whole > 0.0, slabs_in(whole));
}
