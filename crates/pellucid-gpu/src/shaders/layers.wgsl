// Several volumes along rays, on one lattice that begins where a ray enters the first of them: as `ways.rs` of the CPU
// backend. Its pieces end at its nodes and at the borders of volumes, so that every volume is covered exactly.
#import pellucid::of0::frame::{frame, bounds}
#import pellucid::of0::ray::{jitter_of, place_of}
#import pellucid::of0::march::{Turn, begin_turn, end_turn, DONE, HIT, NOWHERE, TERMINATED}
#import pellucid::of0::table::over
#import pellucid::each::normal
#import pellucid::merge::{densest, merged}
#import pellucid::ways::{begin, clear_until, each_of, end_of, find_ways, ways, whole, CLOSE}

// How many pieces are looked at between two looks at the blocks.
const RUN: u32 = 8u;

// The last node before which nothing can be seen, or the distance itself.
fn leap(from_distance: f32) -> f32 {
    var distance = from_distance;
    var node = floor(clear_until(distance));
    while node > distance {
        distance = node;
        node = floor(clear_until(distance));
    }
    return distance;
}

fn follow(turn: ptr<function, Turn>, jitter: f32) {
    var state = (*turn).state;
    var distance = state.place.x;
    var looks = bounds.most_looks;
    // The volume whose surface a ray meets.
    var met = 0u;
    while looks > 0u && distance + CLOSE < whole {
        looks -= 1u;
        let to = leap(distance);
        state.counts.z += u32(min(to, whole) - distance);
        distance = to;
        for (var i = 0u; i < RUN && distance + CLOSE < whole; i += 1u) {
            let ends = vec2<f32>(distance, end_of(distance, floor(distance + CLOSE) + 1.0));
            distance = ends.y;
            state.counts.x += 1u;
            var elements = each_of(ends, jitter, state.color.a);
            let rgba = merged(&elements);
            if rgba.a <= 0.0 {
                continue;
            }
            state.counts.y += 1u;
            state.color = over(state.color, rgba);
            if state.color.a >= 0.5 && state.surface.w == NOWHERE {
                state.surface.w = begin + ends.x + jitter * (ends.y - ends.x);
                met = densest(&elements);
            }
            if state.color.a >= frame.limits.z {
                state.counts.w |= TERMINATED | DONE;
                looks = 0u;
                break;
            }
        }
    }
    if state.surface.w < NOWHERE && (*turn).state.surface.w == NOWHERE {
        state.surface = vec4<f32>(normal(met, ways[met], state.surface.w), state.surface.w);
    }
    state.place.x = distance;
    if !(distance + CLOSE < whole) {
        state.counts.w |= DONE;
    }
    (*turn).state = state;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    var turn = begin_turn(id.xy);
    if turn.open {
        find_ways(place_of(turn.pixel, bounds.rows.ray));
        if whole > 0.0 {
            turn.state.counts.w |= HIT;
        }
        follow(&turn, jitter_of(turn.pixel, bounds.rows.ray));
        end_turn(turn);
    }
}
