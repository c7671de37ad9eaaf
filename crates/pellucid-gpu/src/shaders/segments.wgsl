// The walk over segments between the nodes of the lattice, for modes that look at pairs of values. The
// value at a segment's end is carried over to the next: one fetch a segment (4.6-7).
#import pellucid::frame::bounds
#import pellucid::ray::{Segment, ray_at, ray_node, ray_segment}
#import pellucid::field::{field_value, is_here}
#import pellucid::march::{Turn, turn_of, end_turn, DONE, NOWHERE, TERMINATED}
#import pellucid::mode::{meet_segment, visit_segment}
#ifdef SURFACES
#import pellucid::field::ABSENT
#import pellucid::pieces::{cells_at, is_of_nearest, next_cell}
#ifdef EXACT
#import pellucid::monotone::{Walk, next_piece}
#endif
#ifdef SKIP
#import pellucid::skip::leap_faces
#endif
#endif
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
    var looks = bounds.most_looks;
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

#ifdef SURFACES
#ifdef KERNELS
// The walk over the faces between nearest voxels, where the field jumps from the value of one to that of the other:
// segments of no length. Between nodes of a lattice corners of voxels would be missed.
fn follow_faces(turn: ptr<function, Turn>) {
    const FACES: u32 = 8u;
    let ray = (*turn).ray;
    var state = (*turn).state;
    var cells = cells_at(ray, state.place.x);
    // There is no face at the entry, nor behind what is leapt over.
    var front = select(ABSENT, state.place.y, state.place.z != 0.0);
    var looks = bounds.most_looks;
    var here = true;
    while here && looks > 0u && cells.ends.x < cells.length {
        looks -= 1u;
#ifdef SKIP
        let leapt = leap_faces(ray, &cells);
        if leapt > 0.0 {
            front = ABSENT;
            state.counts.z += u32(leapt);
        }
#endif
        for (var i = 0u; i < FACES && cells.ends.x < cells.length; i += 1u) {
            let p = ray_at(ray, (cells.ends.x + cells.ends.y) * 0.5);
            if !is_here(p) {
                here = false;
                break;
            }
            let back = field_value(p);
            state.counts.x += 1u;
            let face = Segment(vec2<f32>(cells.ends.x), vec2<f32>(front, back), 0.0);
            front = back;
            next_cell(&cells);
            if visit_segment(&state, ray, face) && meet_segment(&state, ray, face) {
                state.counts.w |= TERMINATED | DONE;
                here = false;
                break;
            }
        }
    }
    if cells.ends.x >= cells.length {
        state.counts.w |= DONE;
    }
    state.place = vec4<f32>(cells.ends.x, front, 1.0, 0.0);
    (*turn).state = state;
}
#endif
#ifdef EXACT
// The walk over the pieces on which the field only rises or only falls.
fn follow_monotone(turn: ptr<function, Turn>) {
    const PIECES: u32 = 2u;
    let ray = (*turn).ray;
    var state = (*turn).state;
    let is_fresh = state.place.z == 0.0;
    var walk = Walk(cells_at(ray, state.place.x), state.place.w, select(state.place.y, ABSENT, is_fresh));
    var looks = bounds.most_looks;
    var here = true;
    while here && looks > 0u && walk.cells.ends.x < walk.cells.length {
        looks -= 1u;
#ifdef SKIP
        var cells = walk.cells;
        let leapt = leap_faces(ray, &cells);
        if leapt > 0.0 {
            walk = Walk(cells, 0.0, ABSENT);
            state.counts.z += u32(leapt);
        }
#endif
        var segment: Segment;
        var halted = false;
        for (var i = 0u; i < PIECES && !halted && walk.cells.ends.x < walk.cells.length; i += 1u) {
            if !is_here(ray_at(ray, (walk.cells.ends.x + walk.cells.ends.y) * 0.5)) {
                here = false;
                break;
            }
            state.counts.x += 1u;
            halted = next_piece(ray, &walk, &segment) && visit_segment(&state, ray, segment);
        }
        // Between walks, as in `follow`.
        if halted && meet_segment(&state, ray, segment) {
            state.counts.w |= TERMINATED | DONE;
            here = false;
        }
    }
    if walk.cells.ends.x >= walk.cells.length {
        state.counts.w |= DONE;
    }
    // The middle of a piece tells it from its neighbours.
    state.place = vec4<f32>((walk.cells.ends.x + walk.cells.ends.y) * 0.5, walk.front, 1.0, walk.part);
    (*turn).state = state;
}
#endif
#endif

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    var turn = turn_of(id.xy);
    if turn.open {
#ifdef EXACT
        follow_monotone(&turn);
        end_turn(turn);
        return;
#endif
#ifdef SURFACES
#ifdef KERNELS
        if is_of_nearest() {
            follow_faces(&turn);
            end_turn(turn);
            return;
        }
#endif
#endif
        follow(&turn);
        end_turn(turn);
    }
}
