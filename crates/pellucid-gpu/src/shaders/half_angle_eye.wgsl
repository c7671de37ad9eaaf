// The eye looks at a run of slabs in the light that has come to each (Eq. 6.9, 6.10, K-05). The pass: rows and
// ray of the picture; the first slab, the end, and how many layers light is kept in by turns.
#import pellucid::frame::{frame, bounds}
#import pellucid::march::{end_turn, turn_of}
#import pellucid::light::{add_light, in_light, in_the_dark, incident, lights}
#import pellucid::eye::eye_crossing
#import pellucid::slab::matter_of
#import pellucid::surface::gradient_of_surface
#import pellucid::sweep::{in_picture, loss, on_plane, passage_of, sweep, Passage}
#import pellucid::table::{opacity_over, over_length}
#ifdef TRANSPORT
#import pellucid::scatter::transported
#endif

// How many steps light has come within the slab to a sample.
fn steps_inside(passage: Passage, slab: f32) -> f32 {
    let part = passage.place - slab;
    if sweep.ways.w == 0.0 {
        return part * sweep.ways.x;
    }
    let seen = in_picture(passage.position);
    let at = on_plane(seen.xy);
    let distance = seen.z * sqrt(1.0 + dot(at, at));
    return part * distance / ((passage.place - sweep.ways.y) * sweep.ways.z);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    var turn = turn_of(id.xy);
    if !turn.open {
        return;
    }
    let eye = eye_crossing(turn.ray);
    // A new state has another use of it.
    var color = select(turn.state.place, vec4<f32>(0.0), bounds.texture_low.w != 0u);
    let first = bounds.core_low.x;
    let last = min(bounds.core_low.y, u32(max(ceil(eye.crossing.ends.y), 0.0)));
    for (var slab = max(first, u32(max(eye.crossing.ends.x, 0.0))); slab < last; slab += 1u) {
        if !eye.is_backward && color.a >= frame.limits.z {
            break;
        }
        let passage = passage_of(eye.crossing, f32(slab));
        if passage.ratio <= 0.0 {
            continue;
        }
        turn.state.counts.x += 1u;
        let matter = matter_of(passage);
        if matter.color.a <= 0.0 {
            continue;
        }
        turn.state.counts.y += 1u;
        let p = passage.position;
        let rgba = over_length(matter.color, passage.ratio);
        let lost = loss(slab % bounds.core_low.z, in_picture(p).xy);
        var direct = 1.0 - lost.a;
        var indirect = vec3<f32>(sweep.scales.z) - lost.rgb;
        if sweep.counts.y == 0u {
            let inside = steps_inside(passage, f32(slab));
            let through = 1.0 - opacity_over(matter.color.a, inside);
            direct *= through;
#ifdef TRANSPORT
            indirect *= transported(matter.value, inside);
#else
            indirect *= through;
#endif
        }
        let light = lights[sweep.size.w];
        var sample = in_the_dark(matter.value, gradient_of_surface(p), turn.ray.to_eye);
        add_light(&sample, light, p, direct * sweep.scales.x);
        var seen = in_light(sample, rgba);
#ifdef INDIRECT
        let factor = indirect * incident(light, p).radiance * sweep.scales.y;
        seen += vec4<f32>(rgba.rgb * factor, 0.0);
#endif
        // In front of what is there (over), or behind it (under).
        if eye.is_backward {
            color = seen + color * (1.0 - seen.a);
        } else {
            color += seen * (1.0 - color.a);
        }
    }
    turn.state.place = color;
    end_turn(turn);
}
