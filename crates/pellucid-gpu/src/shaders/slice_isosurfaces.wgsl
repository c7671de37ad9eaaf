// A fragment of a slice through several volumes: the surfaces that its ray meets between the slice and the next one, where
// the ray caster finds them, in their order.
#import pellucid::of0::frame::{frame, bounds}
#import pellucid::of0::ray::{beam_of, place_of}
#import pellucid::of0::slices::{share_of, slices}
#import pellucid::of0::table::over
#import pellucid::ahead::{cursors, look_ahead, nearest}
#import pellucid::count::COUNT
#import pellucid::cursor::BEYOND
#import pellucid::each_hit::{hit, next_hit}
#import pellucid::slice_nodes::{find_nodes, node}

struct Blended {
    @location(0) color: vec4<f32>,
    @location(1) counts: vec2<f32>,
}

@fragment
fn fragment(@builtin(position) position: vec4<f32>, @location(0) @interpolate(flat) slice: u32) -> Blended {
    let pixel = vec2<u32>(position.xy) + vec2<u32>(frame.size.y, bounds.rows.first);
    let sub = bounds.rows.ray;
    let at = place_of(pixel, sub);
    find_nodes(at);
    let to_base = beam_of(at).to_base;
    let first = f32(slice * slices.counts.x);
    // Rounding must not put a surface before the first slice.
    let begin = select(to_base + node(first), 0.0, slice == 0u);
    var color = vec4<f32>(0.0);
    var counts = vec4<u32>(0u);
    // Mesa's software driver works on pixels beside the polygon, too, for which buffers hold zeros: their rays are no
    // numbers, along which no search would end before loops of the pixels around them may not go on either.
    if slices.counts.x > 0u {
        look_ahead(pixel, sub, vec2<f32>(begin, to_base + node(first + f32(slices.counts.x))));
        var layer = nearest();
        while cursors[layer].ahead < BEYOND {
            color = over(color, hit(layer, pixel, sub, cursors[layer], color.a).rgba);
            counts.y += 1u;
            if color.a >= frame.limits.z {
                break;
            }
            cursors[layer] = next_hit(layer, pixel, sub, cursors[layer]);
            layer = nearest();
        }
        for (var i = 0u; i < COUNT; i += 1u) {
            counts.x += cursors[i].counts.x;
        }
    }
    if counts.x == 0u {
        discard;
    }
    let share = share_of(color, counts);
    return Blended(share.color, share.counts);
}
