// The walk over segments between the nodes of the lattice, for modes that look at pairs of values. The
// value at a segment's end is carried over to the next: one fetch a segment (4.6-7).
#import pellucid::frame::bounds
#import pellucid::ray::{Segment, ray_at, ray_node, ray_segment}
#import pellucid::field::{field_value, is_here}
#import pellucid::march::{Turn, turn_of, end_turn, DONE, NOWHERE, TERMINATED}
#import pellucid::mode::{meet_segment, visit_segment}
#ifdef NORMALS
#import pellucid::surface::add_normal
#endif
#ifdef SKIP
#import pellucid::skip::leap_segments
#endif

// How many segments are visited between two looks at the blocks: fewer than samples, because what is
// looked for is often a surface.
const RUN: u32 = 4u;

fn follow(turn: ptr<function, Turn>) {
    let ray = (*turn).ray;
    var state = (*turn).state;
    // The node in front of the segment; the last segment starts at node `count`.
    var n = state.place.x;
    var front = state.place.y;
    var carried = state.place.z != 0.0;
    var looks = bounds.rows.w;
    var here = ray.count > 0.0;
    while here && looks > 0u && n <= ray.count {
        // What happens seldom is done between walks: within them, processors whose lanes share branches
        // would pay for it at every segment.
        var segment: Segment;
        var halted = false;
        while here && !halted && looks > 0u && n <= ray.count {
            looks -= 1u;
#ifdef SKIP
            let to = leap_segments(ray, n);
            state.counts.z += u32(min(to, ray.count) - min(n, ray.count));
            carried = carried && to == n;
            n = to;
#endif
            for (var i = 0u; i < RUN && n <= ray.count; i += 1u) {
                let start = ray_node(ray, n);
                if !carried {
                    let p = ray_at(ray, start);
                    if !is_here(p) {
                        here = false;
                        break;
                    }
                    front = field_value(p);
                    carried = true;
                    state.counts.x += 1u;
                }
                let end = ray_node(ray, n + 1.0);
                let p = ray_at(ray, end);
                if !is_here(p) {
                    here = false;
                    break;
                }
                let back = field_value(p);
                state.counts.x += 1u;
                segment = Segment(vec2<f32>(start, end), vec2<f32>(front, back), ray_segment(ray, n));
                front = back;
                n += 1.0;
                if visit_segment(&state, ray, segment) {
                    halted = true;
                    break;
                }
            }
        }
        if halted && meet_segment(&state, ray, segment) {
            state.counts.w |= TERMINATED | DONE;
            here = false;
        }
    }
#ifdef NORMALS
    if state.surface.w < NOWHERE && (*turn).state.surface.w == NOWHERE {
        add_normal(&state, ray);
    }
#endif
    if n > ray.count || ray.count == 0.0 {
        state.counts.w |= DONE;
    }
    state.place = vec4<f32>(n, front, select(0.0, 1.0, carried), 0.0);
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
