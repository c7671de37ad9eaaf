// What a light has brought comes to the rays' colours, and where half of their opacity is reached: looked for once
// more, from the eye, which may have seen the last slabs first.
#import pellucid::constants::load_constants
#import pellucid::line::{lines_of, opacity_in, surface_at}
#import pellucid::march::{begin_turn, end_turn, NOWHERE}
#import pellucid::sweep::sweep
#import pellucid::table::{coverage, each_opacity}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    load_constants();
    var turn = begin_turn(id.xy);
    if !turn.open {
        return;
    }
    let found = turn.state.place;
    // Light of several sweeps adds up; what holds it back is the same in all of them.
    turn.state.color += vec4<f32>(found.rgb, coverage(found.a) / sweep.scales.w);
    // What is held back of each colour, until another sweep begins.
    turn.state.place = vec4<f32>(0.0, each_opacity(found.a));
    if found.a >= 0.5 && turn.state.surface.w == NOWHERE {
        var lines = lines_of(turn.pixel);
        let first = u32(max(lines.ends.x, 0.0));
        let end = u32(max(ceil(lines.ends.y), 0.0));
        var transmittance = 1.0;
        for (var number = 0u; number < end - first; number += 1u) {
            let slab = select(first + number, end - 1u - number, lines.is_backward);
            let opacity = opacity_in(&lines, f32(slab));
            transmittance *= 1.0 - opacity.x;
            if transmittance <= 0.5 {
                turn.state.surface = surface_at(&lines, opacity.y);
                break;
            }
        }
    }
    end_turn(turn);
}
