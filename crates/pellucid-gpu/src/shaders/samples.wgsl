// The walk over the samples of rays, for modes that look at one value at a time. The mode is another
// module of the same name, chosen when the shader is linked.
#import pellucid::frame::bounds
#import pellucid::ray::{ray_at, sample_of, stride_sample}
#import pellucid::field::is_here
#import pellucid::march::{Turn, turn_of, end_turn, DONE, NOWHERE, TERMINATED}
#import pellucid::mode::{finish, visit}
#ifdef NORMALS
#import pellucid::surface::add_normal
#endif
#ifdef SKIP
#import pellucid::skip::leap_samples
#endif
#ifdef STRIDES
#import pellucid::skip::stride_level
#endif

// How many samples are taken between two looks at the blocks.
const RUN: u32 = 8u;

fn follow(turn: ptr<function, Turn>) {
    let ray = (*turn).ray;
    var state = (*turn).state;
    var k = state.place.x;
    var looks = bounds.most_looks;
    var here = true;
#ifdef STRIDES
    // A run that the end of a brick cut short goes on in the next one with the same stride.
    var level = u32(state.place.z);
    var taken = u32(state.place.w);
#endif
    while here && looks > 0u && k < ray.count {
        looks -= 1u;
#ifdef STRIDES
        if taken == 0u {
            let to = leap_samples(ray, k);
            state.counts.z += u32(min(to, ray.count) - k);
            k = to;
            level = stride_level(ray, k);
        }
        let first = taken;
        taken = 0u;
#else
#ifdef SKIP
        let to = leap_samples(ray, k);
        state.counts.z += u32(min(to, ray.count) - k);
        k = to;
#endif
        let first = 0u;
#endif
        for (var i = first; i < RUN && k < ray.count; i += 1u) {
#ifdef STRIDES
            let sample = stride_sample(ray, k, level);
#else
            let sample = sample_of(ray, k);
#endif
            let p = ray_at(ray, sample.distance);
            if !is_here(p) {
                here = false;
#ifdef STRIDES
                taken = i;
#endif
                break;
            }
            state.counts.x += 1u;
            if visit(&state, ray, sample, p) {
                state.counts.w |= TERMINATED | DONE;
                here = false;
                break;
            }
#ifdef STRIDES
            k += f32(1u << level);
#else
            k += 1.0;
#endif
        }
    }
#ifdef STRIDES
    state.place.z = f32(level);
    state.place.w = f32(taken);
#endif
#ifdef NORMALS
    if state.surface.w < NOWHERE && (*turn).state.surface.w == NOWHERE {
        add_normal(&state, ray);
    }
#endif
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
