// Rays of the eye as they cross slabs.
#define_import_path pellucid::eye

#import pellucid::passage::{Crossing, Line, passage_of}
#import pellucid::sweep::sweep
#import pellucid::way::Way
#ifdef SKIP
#import pellucid::ray::nonzeros
#import pellucid::skip::clear_steps
#endif

const FAR: f32 = 1e30;

// A ray that is in the volume for so many steps.
fn line_along(way: Way, length: f32, jitter: f32) -> Line {
    // A ray that lies in a slab crosses it very slowly.
    const SLOWEST: f32 = 1e-6;
    let along = dot(sweep.slabs.xyz, way.direction);
    let is_backward = along < 0.0;
    let speed = max(abs(along), SLOWEST);
    let entry = way.origin + way.direction * select(0.0, length, is_backward);
    let begin = dot(sweep.slabs.xyz, entry) + sweep.slabs.w;
    var crossing: Crossing;
    crossing.direction = select(way.direction, -way.direction, is_backward) / speed;
    crossing.origin = entry - crossing.direction * begin;
    crossing.ends = vec2<f32>(max(begin, 0.0), min(begin + length * speed, f32(sweep.size.z)));
    crossing.stretch = 1.0 / speed;
    crossing.jitter = jitter;
    return Line(way, crossing, is_backward);
}

// How many slabs from one on certainly add nothing, itself included; 0 if it may.
fn clear_slabs(line: Line, slab: f32) -> f32 {
    let ends = line.crossing.ends;
    if slab >= ends.y {
        return FAR;
    }
    if slab + 1.0 <= ends.x {
        return floor(ends.x) - slab;
    }
#ifdef SKIP
    return clear_steps(passage_of(line.crossing, slab).position, 1.0 / nonzeros(line.crossing.direction));
#else
    return 0.0;
#endif
}
