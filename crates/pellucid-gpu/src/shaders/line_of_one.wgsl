// A ray of the eye through the slabs around a volume.
#define_import_path pellucid::line

#import pellucid::frame::bounds
#import pellucid::eye
#import pellucid::passage::{Line, passage_of, steps_to}
#import pellucid::ray::{ray_length, ray_of}
#import pellucid::slab::matter_of
#import pellucid::surface::normal_at
#import pellucid::table::opacity_over
#import pellucid::way::Way

struct Lines {
    each: Line,
    // Coordinates between which it is in the volume.
    ends: vec2<f32>,
    is_backward: bool,
    // Whether it meets the volume.
    is_met: bool,
}

fn lines_of(pixel: vec2<u32>) -> Lines {
    let ray = ray_of(pixel, bounds.rows.ray);
    let is_met = ray.count > 0.0;
    let length = select(0.0, ray_length(ray), is_met);
    // Distances count from the entry.
    let way = Way(ray.origin, ray.direction, ray.to_eye, vec2<f32>(0.0, length));
    let line = eye::line_along(way, length, ray.jitter);
    return Lines(line, line.crossing.ends, line.is_backward, is_met);
}

fn clear_slabs(lines: ptr<function, Lines>, slab: f32) -> f32 {
    return eye::clear_slabs((*lines).each, slab);
}

// The opacity of what it crosses in a slab, and the coordinate of that.
fn opacity_in(lines: ptr<function, Lines>, slab: f32) -> vec2<f32> {
    let passage = passage_of((*lines).each.crossing, slab);
    return vec2<f32>(opacity_over(matter_of(passage).color.a, passage.ratio), passage.place);
}

// The normal at a coordinate, and the distance.
fn surface_at(lines: ptr<function, Lines>, place: f32) -> vec4<f32> {
    let way = (*lines).each.way;
    let distance = steps_to((*lines).each, place);
    return vec4<f32>(normal_at(way.origin + way.direction * distance), distance);
}
