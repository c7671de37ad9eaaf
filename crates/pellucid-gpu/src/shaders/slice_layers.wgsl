// A fragment of a slice through several volumes: what lies on its ray between the slice and the next one, in pieces that
// end at the borders of volumes, so that every volume is covered exactly.
#import pellucid::of0::frame::{frame, bounds}
#import pellucid::of0::ray::{jitter_of, place_of}
#import pellucid::of0::slices::{share_of, slices}
#import pellucid::of0::table::{over, over_length}
#import pellucid::merge::merged
#import pellucid::slice_nodes::{find_nodes, node, stride}
#import pellucid::ways::{begin, clear_until, each_of, end_of, find_ways, whole, CLOSE}

struct Blended {
    @location(0) color: vec4<f32>,
    @location(1) counts: vec2<f32>,
}

@fragment
fn fragment(@builtin(position) position: vec4<f32>, @location(0) @interpolate(flat) slice: u32) -> Blended {
    let pixel = vec2<u32>(position.xy) + vec2<u32>(frame.size.y, bounds.rows.first);
    find_ways(place_of(pixel, bounds.rows.ray));
    find_nodes(place_of(pixel, bounds.rows.ray));
    let jitter = jitter_of(pixel, bounds.rows.ray);
    var color = vec4<f32>(0.0);
    var counts = vec4<u32>(0u);
    for (var i = 0u; i < slices.counts.x; i += 1u) {
        let k = f32(slice * slices.counts.x + i);
        var distance = max(node(k) - begin, 0.0);
        let end = min(node(k + 1.0) - begin, whole);
        if clear_until(distance) >= end {
            continue;
        }
        while distance + CLOSE < end {
            let ends = vec2<f32>(distance, end_of(distance, end));
            distance = ends.y;
            counts.x += 1u;
            var elements = each_of(ends, jitter, color.a);
            var rgba = merged(&elements);
            if slices.counts.y != 0u {
                // As if every ray crossed the slices at a right angle.
                rgba = over_length(rgba, 1.0 / stride);
            }
            if rgba.a > 0.0 {
                counts.y += 1u;
                color = over(color, rgba);
            }
        }
    }
    if counts.x == 0u {
        discard;
    }
    let share = share_of(color, counts);
    return Blended(share.color, share.counts);
}
