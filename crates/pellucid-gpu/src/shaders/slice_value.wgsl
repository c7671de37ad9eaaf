// One value for a whole ray, by blending (3.2-10): values are blended as places in the table, 0 to 1, and
// classified once all slices are there. Opacity says that there was one; for means, what they are of.
#define_import_path pellucid::mode

#import pellucid::frame::frame
#import pellucid::ray::{Ray, Sample, ray_at, ray_length}
#import pellucid::field::{field_value, is_present}
#import pellucid::march::State
#import pellucid::slices::{is_inside, lattice_of, slices}
#ifndef MEAN
#import pellucid::pieces::{cells_at, highest, next_cell, NONE}
#endif
#import pellucid::table::even_node

#ifdef MEAN
fn visit(state: ptr<function, State>, ray: Ray, sample: Sample, p: vec3<f32>) -> bool {
    let value = field_value(p);
    if !is_present(value) {
        return false;
    }
    let last = f32(frame.dims.w - 1u);
    let weight = sample.ratio * slices.strides.z;
    (*state).color += vec4<f32>(vec3<f32>(even_node(value) / last * weight), weight);
    (*state).counts.y += 1u;
    return false;
}
#else
#ifdef MINIMUM
const SIGN: f32 = -1.0;
#else
const SIGN: f32 = 1.0;
#endif

// The extreme of what a sample stands for, which is the way half to its neighbours.
fn extreme_around(ray: Ray, distance: f32) -> f32 {
    let stride = lattice_of(ray).stride;
    let length = ray_length(ray);
    let start = select(0.0, max(distance - 0.5 * stride, 0.0), is_inside(ray, distance - stride));
    let end = select(length, min(distance + 0.5 * stride, length), is_inside(ray, distance + stride));
    var best = NONE;
    var cells = cells_at(ray, start);
    while cells.ends.x < min(end, cells.length) {
        let piece = vec2<f32>(max(cells.ends.x, start), min(cells.ends.y, end));
        best = max(best, highest(ray_at(ray, piece.x), ray_at(ray, piece.y), SIGN, best).x);
        next_cell(&cells);
    }
    return best;
}

fn visit(state: ptr<function, State>, ray: Ray, sample: Sample, p: vec3<f32>) -> bool {
    let found = extreme_around(ray, sample.distance);
    if found == NONE {
        return false;
    }
    let color = (*state).color;
    let place = vec3<f32>(clamp(even_node(found * SIGN) / f32(frame.dims.w - 1u), 0.0, 1.0));
#ifdef MINIMUM
    let best = min(select(vec3<f32>(1.0), color.rgb, color.a > 0.0), place);
#else
    let best = max(color.rgb, place);
#endif
    (*state).color = vec4<f32>(best, 1.0);
    (*state).counts.y += 1u;
    return false;
}
#endif
