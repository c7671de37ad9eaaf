// Surfaces of several volumes, in the order in which rays meet them: as `Isosurfaced` of the CPU backend.
#import pellucid::of0::frame::{frame, bounds}
#import pellucid::of0::ray::{beam_of, place_of}
#import pellucid::of0::march::{Turn, begin_turn, end_turn, DONE, HIT, NOWHERE, TERMINATED}
#import pellucid::of0::table::over
#import pellucid::ahead::{cursors, look_ahead, nearest}
#import pellucid::count::COUNT
#import pellucid::cursor::BEYOND
#import pellucid::each_hit::{hit, next_hit}

fn follow(turn: ptr<function, Turn>) {
    let pixel = (*turn).pixel;
    let sub = bounds.rows.ray;
    var state = (*turn).state;
    look_ahead(pixel, sub, vec2<f32>(0.0, BEYOND));
    for (var i = 0u; i < COUNT; i += 1u) {
        if cursors[i].is_in {
            state.counts.w |= HIT;
        }
    }
    var layer = nearest();
    while cursors[layer].ahead < BEYOND {
        let cursor = cursors[layer];
        let met = hit(layer, pixel, sub, cursor, state.color.a);
        state.counts.y += 1u;
        state.color = over(state.color, met.rgba);
        if state.surface.w == NOWHERE {
            state.surface = vec4<f32>(met.normal, cursor.ahead - beam_of(place_of(pixel, sub)).to_base);
        }
        if state.color.a >= frame.limits.z {
            state.counts.w |= TERMINATED;
            break;
        }
        cursors[layer] = next_hit(layer, pixel, sub, cursor);
        layer = nearest();
    }
    state.counts.w |= DONE;
    for (var i = 0u; i < COUNT; i += 1u) {
        state.counts = vec4<u32>(state.counts.xyz + cursors[i].counts, state.counts.w);
    }
    (*turn).state = state;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    var turn = begin_turn(id.xy);
    if turn.open {
        follow(&turn);
        end_turn(turn);
    }
}
