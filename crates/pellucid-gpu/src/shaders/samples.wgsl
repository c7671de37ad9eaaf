// The walk over the samples of rays, for modes that look at one value at a time. The mode is another
// module of the same name, chosen when the shader is linked.
#import pellucid::frame::bounds
#import pellucid::ray::{ray_at, ray_sample}
#import pellucid::field::is_here
#import pellucid::march::{Turn, turn_of, end_turn, DONE, TERMINATED}
#import pellucid::mode::{finish, visit}
#ifdef SKIP
#import pellucid::skip::leap_samples
#endif

// How many samples are taken between two looks at the blocks.
const RUN: u32 = 8u;

fn follow(turn: ptr<function, Turn>) {
    let ray = (*turn).ray;
    var state = (*turn).state;
    var k = state.place.x;
    var looks = bounds.rows.w;
    var here = true;
    while here && looks > 0u && k < ray.count {
        looks -= 1u;
#ifdef SKIP
        let to = leap_samples(ray, k, state.place.y);
        state.counts.z += u32(min(to, ray.count) - k);
        k = to;
#endif
        for (var i = 0u; i < RUN && k < ray.count; i += 1u) {
            let distance = ray_sample(ray, k);
            let p = ray_at(ray, distance);
            if !is_here(p) {
                here = false;
                break;
            }
            state.counts.x += 1u;
            if visit(&state, ray, k, distance, p) {
                state.counts.w |= TERMINATED | DONE;
                here = false;
                break;
            }
            k += 1.0;
        }
    }
    state.place.x = k;
    if k >= ray.count {
        state.counts.w |= DONE;
    }
    if (state.counts.w & DONE) != 0u {
        finish(&state);
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
