// The field on a plane through the volume, coloured at full opacity.
#import pellucid::frame::frame
#import pellucid::ray::{ray_at, ray_length}
#import pellucid::field::{field_value, is_here, is_present}
#import pellucid::march::{Turn, turn_of, end_turn, DONE}
#import pellucid::projected::set_value

// Rounding must not cut a plane out of the border of the volume, in steps.
const ROOM: f32 = 1e-4;

fn follow(turn: ptr<function, Turn>) {
    let ray = (*turn).ray;
    let along = dot(ray.direction, frame.plane.xyz);
    let distance = (frame.plane.w - dot(ray.origin, frame.plane.xyz)) / along;
    let met = along != 0.0 && distance >= -ROOM && distance <= ray_length(ray) + ROOM;
    if ray.count == 0.0 || !met {
        (*turn).state.counts.w |= DONE;
        return;
    }
    let p = ray_at(ray, distance);
    if !is_here(p) {
        return;
    }
    (*turn).state.counts.w |= DONE;
    (*turn).state.counts.x += 1u;
    var state = (*turn).state;
    let value = field_value(p);
    set_value(&state, value, distance);
    if is_present(value) {
        state.surface = vec4<f32>(frame.plane_normal.xyz, distance);
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
