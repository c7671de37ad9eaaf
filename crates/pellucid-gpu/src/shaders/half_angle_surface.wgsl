// What a light has brought comes to the rays' colours, and where half of their opacity is reached: looked for once
// more, from the eye, which may have seen the last slabs first.
#import pellucid::frame::frame
#import pellucid::march::{end_turn, turn_of, NOWHERE}
#import pellucid::eye::eye_crossing
#import pellucid::slab::matter_of
#import pellucid::surface::add_normal
#import pellucid::sweep::{load_sweep, passage_of, sweep}
#import pellucid::table::{coverage, each_opacity, opacity_over}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    load_sweep();
    var turn = turn_of(id.xy);
    if !turn.open {
        return;
    }
    let found = turn.state.place;
    // Light of several sweeps adds up; what holds it back is the same in all of them.
    turn.state.color += vec4<f32>(found.rgb, coverage(found.a) / sweep.scales.w);
    // What is held back of each colour, until another sweep begins.
    turn.state.place = vec4<f32>(0.0, each_opacity(found.a));
    if found.a >= 0.5 && turn.state.surface.w == NOWHERE {
        let eye = eye_crossing(turn.ray);
        let first = u32(max(eye.crossing.ends.x, 0.0));
        let end = u32(max(ceil(eye.crossing.ends.y), 0.0));
        var transmittance = 1.0;
        for (var number = 0u; number < end - first; number += 1u) {
            let slab = select(first + number, end - 1u - number, eye.is_backward);
            let passage = passage_of(eye.crossing, f32(slab));
            let matter = matter_of(passage);
            transmittance *= 1.0 - opacity_over(matter.color.a, passage.ratio);
            if transmittance <= 0.5 {
                // Distances count steps from the entry.
                let along = select(passage.place - eye.crossing.ends.x, eye.crossing.ends.y - passage.place, eye.is_backward);
                var state = turn.state;
                state.surface.w = along * eye.crossing.stretch;
                add_normal(&state, turn.ray);
                turn.state = state;
                break;
            }
        }
    }
    end_turn(turn);
}
