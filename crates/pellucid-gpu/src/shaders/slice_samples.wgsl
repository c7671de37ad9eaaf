// A fragment of a slice, for modes that look at one value at a time: the samples of its ray there, as the ray
// caster would take them (3.3-1).
#import pellucid::frame::{frame, bounds}
#import pellucid::ray::{ray_at, ray_of}
#import pellucid::march::new_state
#import pellucid::mode::visit
#import pellucid::slices::{lattice_of, owns, share_of, slice_sample, slices}

struct Blended {
    @location(0) color: vec4<f32>,
    @location(1) counts: vec2<f32>,
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
        for (var i = 0u; i < slices.counts.x; i += 1u) {
            let sample = slice_sample(ray, lattice, f32(slice * slices.counts.x + i));
            let p = ray_at(ray, sample.distance);
            if sample.ratio <= 0.0 || !owns(box, p) {
                continue;
            }
            state.counts.x += 1u;
            if visit(&state, ray, sample, p) {
                break;
            }
        }
    }
    if state.counts.x == 0u {
        discard;
    }
    let share = share_of(state.color, state.counts);
    return Blended(share.color, share.counts);
}
