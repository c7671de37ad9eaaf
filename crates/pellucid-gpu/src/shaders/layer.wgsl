// A volume among others: where rays are in it, and what it sends to the eye. Distances count as those of ways.
#define_import_path pellucid::layer

#import pellucid::way::Way
#import pellucid::ray::{beam_of, ray_along, span_of, FAR}
#import pellucid::field::field_value
#import pellucid::table::over_length
#import pellucid::vary::varied
#import pellucid::surface::{normal_at, shown}
#ifdef SEGMENTS
#import pellucid::integrals::{between, value_of}
#else
#import pellucid::classified::classified_at
#endif
#ifdef SKIP
#import pellucid::skip::way_to_matter
#endif

// The way of the ray through a place of the picture, in pixels.
fn way_of(at: vec2<f32>) -> Way {
    let beam = beam_of(at);
    let ends = span_of(beam.origin, beam.direction, -beam.to_base, FAR);
    return Way(beam.origin + beam.direction * ends.x, beam.direction, -beam.world, ends);
}

fn position(way: Way, distance: f32) -> vec3<f32> {
    return way.origin + way.direction * (distance - way.ends.x);
}

// How many steps from a distance on nothing can be seen, or a little less.
fn clear(way: Way, distance: f32) -> f32 {
#ifdef SKIP
    return way_to_matter(ray_along(way), position(way, distance));
#else
    return 0.0;
#endif
}

// What a piece sends to the eye, over its own length, behind an opacity; its sample lies in it where `jitter` says.
fn element(way: Way, ends: vec2<f32>, jitter: f32, front: f32) -> vec4<f32> {
    let length = ends.y - ends.x;
#ifdef SEGMENTS
    let p = position(way, (ends.x + ends.y) * 0.5);
    let values = vec2<f32>(field_value(position(way, ends.x)), field_value(position(way, ends.y)));
    let rgba = varied(p, between(values.x, values.y, length));
    let value = value_of(values);
#else
    let p = position(way, ends.x + jitter * length);
    let sample = classified_at(p, 0u);
    let rgba = over_length(varied(p, sample.rgba), length);
    let value = sample.value;
#endif
    if rgba.a <= 0.0 {
        return vec4<f32>(0.0);
    }
    return shown(ray_along(way), p, value, rgba, front);
}

// The unit normal of the field at a distance; zero where there is none.
fn normal(way: Way, distance: f32) -> vec3<f32> {
    return normal_at(position(way, distance));
}
