// The largest or the smallest value along a ray (1.4-10): of the field itself, whatever the step.
#import pellucid::frame::bounds
#import pellucid::ray::ray_at
#import pellucid::field::is_here
#import pellucid::march::{Turn, turn_of, end_turn, DONE}
#import pellucid::pieces::{cells_at, highest, next_cell}
#import pellucid::projected::set_value
#ifdef SKIP
#import pellucid::skip::leap_cells
#endif

#ifdef MINIMUM
// The smallest value is the largest with its sign turned.
const SIGN: f32 = -1.0;
#else
const SIGN: f32 = 1.0;
#endif

// How many pieces are looked at between two looks at the blocks.
const RUN: u32 = 8u;

// `place` has the distance of the next piece in x, the best value so far in y (blocks are compared with it), and its
// distance in z.
fn follow(turn: ptr<function, Turn>) {
    let ray = (*turn).ray;
    var state = (*turn).state;
    var cells = cells_at(ray, state.place.x);
    var looks = bounds.most_looks;
    var here = true;
    while here && looks > 0u && cells.ends.x < cells.length {
        looks -= 1u;
#ifdef SKIP
        let before = cells.ends.x;
        leap_cells(ray, &cells, state.place.y);
        state.counts.z += u32(max(min(cells.ends.x, cells.length) - before, 0.0));
#endif
        for (var i = 0u; i < RUN && cells.ends.x < cells.length; i += 1u) {
            if !is_here(ray_at(ray, (cells.ends.x + cells.ends.y) * 0.5)) {
                here = false;
                break;
            }
            state.counts.x += 1u;
            let found = highest(ray_at(ray, cells.ends.x), ray_at(ray, cells.ends.y), SIGN, state.place.y);
            if found.x > state.place.y {
                state.place.y = found.x;
                state.place.z = mix(cells.ends.x, cells.ends.y, found.y);
            }
            next_cell(&cells);
        }
    }
    // The middle of a piece tells it from its neighbours.
    state.place.x = (cells.ends.x + cells.ends.y) * 0.5;
    if cells.ends.x >= cells.length {
        state.counts.w |= DONE;
        set_value(&state, state.place.y * SIGN, state.place.z);
    }
    (*turn).state = state;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    var turn = turn_of(id.xy);
    if turn.open {
        follow(&turn);
        end_turn(turn);
    }
}
