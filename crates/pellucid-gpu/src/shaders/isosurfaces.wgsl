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

// `place` has the distance up to which surfaces have been met in x, and in y how many of those at that very distance.
fn follow(turn: ptr<function, Turn>) {
    let pixel = (*turn).pixel;
    let sub = bounds.rows.ray;
    var state = (*turn).state;
    let begin = state.place.x;
    let known = u32(max(state.place.y, 0.0));
    for (var i = 0u; i < COUNT; i += 1u) {
        cursors[i] = first_hit(i, pixel, sub, begin, bounds.most_looks);
        if cursors[i].is_in {
            state.counts.w |= HIT;
        }
    }
    var at_begin = 0u;
    var last = begin;
    var at_last = 0u;
    var is_open = true;
    while is_open {
        let layer = nearest();
        let cursor = cursors[layer];
        if !cursor.is_told || cursor.ahead >= BEYOND {
            if cursor.is_told {
                state.counts.w |= DONE;
            }
            state.place = vec4<f32>(cursor.ahead, select(0.0, f32(at_last), cursor.ahead == last), 0.0, 0.0);
            is_open = false;
            continue;
        }
        at_begin += select(0u, 1u, cursor.ahead == begin);
        if cursor.ahead > begin || (cursor.ahead == begin && at_begin > known) {
            let met = hit(layer, pixel, sub, cursor);
            state.counts.y += 1u;
            state.color = over(state.color, met.rgba);
            if state.surface.w == NOWHERE {
                state.surface = vec4<f32>(met.normal, cursor.ahead - beam_of(place_of(pixel, sub)).to_base);
            }
            if state.color.a >= frame.limits.z {
                state.counts.w |= TERMINATED | DONE;
                is_open = false;
            }
        }
        at_last = select(1u, at_last + 1u, cursor.ahead == last);
        last = cursor.ahead;
        if is_open {
            cursors[layer] = next_hit(layer, pixel, sub, cursor);
        }
    }
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
