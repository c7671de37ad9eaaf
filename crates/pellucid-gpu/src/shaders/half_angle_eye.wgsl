// The eye looks at a run of slabs in the light that has come to each (Eq. 6.9, 6.10, K-05).
#import pellucid::frame::{frame, bounds}
#import pellucid::march::{states, turn_of}
#import pellucid::light::{add_light, in_light, in_the_dark, incident}
#import pellucid::eye::eye_crossing
#import pellucid::ray::{nonzeros, Ray}
#import pellucid::slab::{matter_of, Matter}
#ifdef SKIP
#import pellucid::skip::clear_steps
#endif
#import pellucid::surface::gradient_of_surface
#import pellucid::sweep::{in_picture, layer_of, load_sweep, loss, on_plane, passage_of, sweep, Crossing, Passage}
#import pellucid::table::{each_color, opacity_over, over, over_length}
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

// The first slab from one on whose sample may contribute, or the end.
fn leap(crossing: Crossing, inverse: vec3<f32>, first: u32, end: u32) -> u32 {
    var slab = first;
#ifdef SKIP
    while slab < end {
        let passage = passage_of(crossing, f32(slab));
        let clear = clear_steps(passage.position, inverse);
        if clear == 0.0 {
            break;
        }
        slab += u32(min(clear, 1e6));
    }
#endif
    return min(slab, end);
}

// What is seen of the light that has come to a sample, and its opacity.
fn seen(passage: Passage, matter: Matter, slab: u32, ray: Ray) -> vec4<f32> {
    let p = passage.position;
    let rgba = over_length(matter.color, passage.ratio);
    let lost = loss(layer_of(bounds.run, slab), in_picture(p).xy);
    var direct = 1.0 - lost.a;
    var indirect = vec3<f32>(sweep.scales.z) - lost.rgb;
    if sweep.counts.y == 0u {
        let inside = steps_inside(passage, f32(slab));
        let transmittance = 1.0 - opacity_over(matter.color.a, inside);
        direct *= transmittance;
#ifdef TRANSPORT
        let passing = transported(p, matter.value, inside);
        indirect *= passing;
#ifdef SCATTERS_DIRECT
        // As light does that passes the slab.
        indirect += max(passing - each_color(transmittance), vec3<f32>(0.0)) * sweep.cone.rgb * each_color(1.0 - lost.a);
#endif
#else
        indirect *= each_color(transmittance);
#endif
    }
    let light = sweep.light;
    var sample = in_the_dark(matter.value, gradient_of_surface(ray, p), ray.to_eye);
    add_light(&sample, light, p, each_color(direct) * sweep.scales.x);
    var color = in_light(sample, rgba);
#ifdef INDIRECT
    let factor = indirect * incident(light, p).radiance * sweep.scales.y;
    color += vec4<f32>(rgba.rgb * factor, 0.0);
#endif
    return color;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    load_sweep();
    // How many slabs are looked at between two looks at the blocks.
    const RUN: u32 = 4u;
    let turn = turn_of(id.xy);
    if !turn.open {
        return;
    }
    let is_first = bounds.rows.begin != 0u;
    let eye = eye_crossing(turn.ray);
    let inverse = 1.0 / nonzeros(eye.crossing.direction);
    // A new state, and one that another sweep has left, has another use of it.
    var color = select(turn.state.place, vec4<f32>(0.0), bounds.begin_sweep != 0u);
    var counts = turn.state.counts;
    let end = min(bounds.run.end, u32(max(ceil(eye.crossing.ends.y), 0.0)));
    var slab = max(bounds.run.first, u32(max(eye.crossing.ends.x, 0.0)));
    while slab < end && (eye.is_backward || color.a < frame.limits.z) {
        let next = leap(eye.crossing, inverse, slab, end);
        counts.z += next - slab;
        slab = next;
        for (var i = 0u; i < RUN && slab < end; i += 1u) {
            let passage = passage_of(eye.crossing, f32(slab));
            var is_open = passage.ratio > 0.0 && (eye.is_backward || color.a < frame.limits.z);
            counts.x += select(0u, 1u, is_open);
            let matter = matter_of(passage);
            is_open = is_open && matter.color.a > 0.0;
            // As in `matter_of`.
            while is_open {
                counts.y += 1u;
                let found = seen(passage, matter, slab, turn.ray);
                // In front of what is there (over), or behind it (under).
                let front = select(color, found, eye.is_backward);
                let behind = select(found, color, eye.is_backward);
                color = over(front, behind);
                is_open = false;
            }
            slab += 1u;
        }
    }
    if is_first {
        states[turn.slot] = turn.state;
    }
    // Of all others nothing else has changed.
    states[turn.slot].place = color;
    states[turn.slot].counts = counts;
}
