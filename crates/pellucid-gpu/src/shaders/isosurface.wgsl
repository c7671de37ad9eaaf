// First surfaces of constant value, found along the ray without a mesh (5.5-8).
#define_import_path pellucid::mode

#import pellucid::frame::frame
#import pellucid::ray::{Ray, Segment}
#import pellucid::crossing::{crosses, level_of, met_at, place_in}
#import pellucid::levels::{between, levels}
#import pellucid::normal::normal_of
#import pellucid::march::{State, NOWHERE}
#import pellucid::table::over

// Whether a segment crosses any surface.
fn visit_segment(state: ptr<function, State>, ray: Ray, segment: Segment) -> bool {
    return crosses(segment.value);
}

// Adds the surfaces that a segment crosses, nearest first. Returns whether the ray is done.
fn meet_segment(state: ptr<function, State>, ray: Ray, segment: Segment) -> bool {
    for (var i = 0u; i < frame.level_count; i += 1u) {
        let number = level_of(segment.value, i);
        if !between(segment.value.x, segment.value.y, levels[number].value.x) {
            continue;
        }
        (*state).counts.y += 1u;
        let distance = place_in(ray, segment, number);
        let met = met_at(ray, distance, number, segment.value.y - segment.value.x, (*state).color.a);
        (*state).color = over((*state).color, met.rgba);
        if (*state).surface.w == NOWHERE {
            (*state).surface = vec4<f32>(normal_of(met.gradient).direction, distance);
        }
        if (*state).color.a >= frame.limits.z {
            return true;
        }
    }
    return false;
}
