// Surfaces of several volumes, in the order in which rays meet them: as `Isosurfaced` of the CPU backend.
#import pellucid::of0::frame::{frame, bounds}
#import pellucid::of0::ray::{beam_of, place_of}
#import pellucid::of0::march::{Turn, begin_turn, end_turn, DONE, HIT, NOWHERE, TERMINATED}
#import pellucid::of0::table::over
#import pellucid::count::COUNT
#import pellucid::cursor::{Cursor, BEYOND}
#import pellucid::each_hit::{first_hit, hit, next_hit}

var<private> cursors: array<Cursor, COUNT>;

// The volume whose surface is ahead.
fn nearest() -> u32 {
    var found = 0u;
    for (var i = 1u; i < COUNT; i += 1u) {
        if cursors[i].ahead < cursors[found].ahead {
            found = i;
        }
    }
    return found;
}

fn follow(turn: ptr<function, Turn>) {
    let pixel = (*turn).pixel;
    let sub = bounds.rows.ray;
    var state = (*turn).state;
    for (var i = 0u; i < COUNT; i += 1u) {
        cursors[i] = first_hit(i, pixel, sub);
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
