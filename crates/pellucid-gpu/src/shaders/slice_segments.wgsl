// A fragment of a slab between two slices, for modes that look at pairs of values: two fetches, as a slice
// knows nothing of the one before (4.6-5), or k + 1 of them for k segments (4.6-6).
#import pellucid::frame::{frame, bounds}
#import pellucid::ray::{Ray, Segment, ray_at, ray_length, ray_of}
#import pellucid::field::field_value
#import pellucid::march::{State, new_state}
#import pellucid::mode::{meet_segment, visit_segment}
#import pellucid::slices::{distance_of, is_inside, lattice_of, owns, share_of, slices}

struct Blended {
    @location(0) color: vec4<f32>,
    @location(1) counts: vec2<f32>,
}

// Visits what lies between two distances. Returns whether nothing is seen behind it.
fn ends(state: ptr<function, State>, ray: Ray, distances: vec2<f32>, values: vec2<f32>, correction: f32) -> bool {
    let segment = Segment(distances, values, (distances.y - distances.x) * correction);
    return visit_segment(state, ray, segment) && meet_segment(state, ray, segment);
}

@fragment
fn fragment(
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) box: u32,
    @location(1) @interpolate(flat) slice: u32,
) -> Blended {
    let ray = ray_of(vec2<u32>(position.xy) + vec2<u32>(frame.size.y, bounds.rows.first), bounds.rows.ray);
    var state = new_state();
    if ray.count > 0.0 {
        let lattice = lattice_of(ray);
        let length = ray_length(ray);
        // The value behind the last segment, if that is where the next one begins.
        var front = 0.0;
        var carried = false;
        for (var i = 0u; i < slices.counts.x; i += 1u) {
            let k = f32(slice * slices.counts.x + i);
            let unlimited = distance_of(lattice, k);
            let start = clamp(unlimited, 0.0, length);
            let p = ray_at(ray, start);
            if !is_inside(ray, unlimited) || !owns(box, p) {
                carried = false;
                continue;
            }
            if !carried {
                front = field_value(p);
                state.counts.x += 1u;
            }
            // What is in front of the first slice is its own.
            if !is_inside(ray, distance_of(lattice, k - 1.0)) && start > 0.0 {
                let entry = field_value(ray_at(ray, 0.0));
                state.counts.x += 1u;
                if ends(&state, ray, vec2<f32>(0.0, start), vec2<f32>(entry, front), lattice.correction) {
                    break;
                }
            }
            let next = distance_of(lattice, k + 1.0);
            let end = select(length, clamp(next, 0.0, length), is_inside(ray, next));
            let back = field_value(ray_at(ray, end));
            state.counts.x += 1u;
            if ends(&state, ray, vec2<f32>(start, end), vec2<f32>(front, back), lattice.correction) {
                break;
            }
            front = back;
            carried = true;
        }
    }
    if state.counts.x == 0u {
        discard;
    }
    let share = share_of(state.color, state.counts);
    return Blended(share.color, share.counts);
}
